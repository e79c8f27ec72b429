//! The reference front-end: a picture by rays, with what halving its spacing would change.

use std::time::Instant;

use relievo_engine::analysis::Task;
use relievo_engine::graph::RenderError;
use relievo_engine::planet::Camera;
use relievo_engine::{Confirmation, Engine, ReferenceSettings};
use relievo_gpu::{Look, Picture};
use serde::Serialize;

use super::{Arguments, ms};
use crate::cli::measure::threads;
use crate::cli::progress::Progress;
use crate::cli::{Context, Failure};
use crate::picture;

/// One in so many pixels, across and down, is drawn again at half the spacing.
const CONFIRM_EVERY: u32 = 16;

/// Figures of a reference picture.
#[derive(Serialize)]
struct Stats {
    front_end: &'static str,
    size_px: [u32; 2],
    rays_per_pixel: u32,
    samples_per_pixel: f64,
    draw_ms: f64,
    /// What half the spacing and twice the rays change, of display values from 0 to 1.
    confirmed: Confirmation,
}

pub(super) fn run(
    arguments: &Arguments,
    engine: &Engine,
    camera: Camera,
    context: &Context,
) -> Result<(), Failure> {
    if arguments.time_limit.is_some() {
        let text = "--time-limit: the reference front-end has none";
        return Err(Failure::Input(text.to_owned()));
    }
    let settings = ReferenceSettings {
        haze: f64::from(Look::default().haze),
        ..ReferenceSettings::new(arguments.size, threads(context))
    };
    let reference = engine.reference(camera);
    let failed = |error: RenderError| match error {
        RenderError::Cancelled => Failure::Cancelled,
        other @ (RenderError::Read(_) | RenderError::Node { .. }) => {
            Failure::Input(format!("{other}: {:?}", arguments.project))
        }
    };
    let started = Instant::now();
    let drawn = {
        let progress = Progress::new("following rays");
        let told = |share| progress.set(share);
        let task = Task {
            cancel: context.cancel,
            progress: &told,
        };
        reference.picture(&settings, &task).map_err(failed)?
    };
    let draw_ms = ms(started.elapsed());
    let file = Picture {
        width: drawn.width,
        height: drawn.height,
        rgba: drawn.rgba(),
    };
    picture::write(&arguments.output, &file).map_err(Failure::system)?;
    let Some(path) = &arguments.stats else {
        return Ok(());
    };
    let progress = Progress::new("halving the spacing");
    let told = |share| progress.set(share);
    let task = Task {
        cancel: context.cancel,
        progress: &told,
    };
    let confirmed = reference
        .confirm(&drawn, &settings, CONFIRM_EVERY, &task)
        .map_err(failed)?;
    super::stats::write_json(
        path,
        &Stats {
            front_end: "reference",
            size_px: arguments.size,
            rays_per_pixel: settings.rays * settings.rays,
            samples_per_pixel: settings.samples_per_pixel,
            draw_ms,
            confirmed,
        },
    )
}
