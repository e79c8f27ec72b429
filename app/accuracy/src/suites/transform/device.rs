//! The same forms on a graphics device.

use std::cell::RefCell;

use glam::Vec2;
use relievo_engine::planet::transform::forms::{Form, ring_vertices};
use relievo_gpu::forms::{FormMeter, PreparedForm};
use relievo_gpu::{AdapterClass, Gpu, ReadError};

use super::{DOMAINS, Error, Evaluator, TIMED_COLAT_RAD, errors, worst};
use crate::number::text;
use crate::timing::in_turns;
use crate::{Context, Spread, SuiteError, Work};

/// Errors and times, form by form, or why there are none.
type Measured = Result<(Vec<Error>, Vec<Spread>), String>;

/// A device with its pipelines.
struct Device<'a> {
    gpu: &'a Gpu,
    meter: FormMeter,
}

impl Evaluator for Device<'_> {
    fn deltas(
        &self,
        form: Form,
        vertices: &[[f32; 3]],
        colat_rad: f64,
    ) -> Result<Vec<Vec2>, SuiteError> {
        let prepared = self.meter.prepare(self.gpu, form, vertices, colat_rad, 1);
        let run = || {
            prepared.run(self.gpu)?;
            prepared.deltas(self.gpu)
        };
        run().map_err(lost)
    }
}

fn lost(error: ReadError) -> SuiteError {
    SuiteError::System(error.to_string())
}

pub(super) fn measure(context: &Context) -> Result<Measured, SuiteError> {
    let gpu = match context.gpu() {
        Ok(gpu) => gpu,
        Err(why) => return Ok(Err(why.to_owned())),
    };
    let device = Device {
        gpu,
        meter: FormMeter::new(&gpu.device),
    };
    let errors = errors(context, &device, 0.5)?;
    Ok(Ok((errors, times(context, &device)?)))
}

/// Nanoseconds a vertex of each form in each domain, form by form: of many evaluations of each vertex, so
/// that reading and writing count for little.
fn times(context: &Context, device: &Device) -> Result<Vec<Spread>, SuiteError> {
    // A graphics processor wants far more work before its time is that of the work.
    let (count, repeats) = match device.gpu.class {
        AdapterClass::Software => (context.pick(1 << 12, 1 << 15), 16),
        AdapterClass::Integrated | AdapterClass::Discrete => (1 << 18, context.pick(16, 256)),
    };
    let mut prepared = Vec::new();
    for form in Form::ALL {
        for domain in DOMAINS {
            let vertices = ring_vertices(domain.timed_level, TIMED_COLAT_RAD, count);
            let meter = &device.meter;
            prepared.push(meter.prepare(device.gpu, form, &vertices, TIMED_COLAT_RAD, repeats));
        }
    }
    let failed = RefCell::new(None);
    let work = |form: &PreparedForm| {
        if let Err(error) = form.run(device.gpu) {
            failed.replace(Some(error));
        }
    };
    let units = f64::from(count) * f64::from(repeats);
    let mut works: Vec<Work> = prepared
        .iter()
        .map(|form| Work::new(units, || work(form)))
        .collect();
    let times = in_turns(context, &mut works)?;
    drop(works);
    match failed.into_inner() {
        Some(error) => Err(lost(error)),
        None => Ok(times),
    }
}

/// What was found on the device.
pub(super) fn summary(errors: &[Error]) -> String {
    let of = |form: Form| {
        let chosen = errors.iter().copied().filter(|e| e.form == form);
        text(worst(chosen, Error::parts))
    };
    format!(
        "On the graphics device the form that is drawn with keeps {} of the ring's radius everywhere with the polynomial \
         arc tangent, and {} with the driver's own; the printed form with the driver's functions is off by up to {} of it.",
        of(Form::CancellationFreePoly),
        of(Form::CancellationFree),
        of(Form::Printed),
    )
}
