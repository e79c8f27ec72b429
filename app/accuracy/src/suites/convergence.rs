//! How fast the picture becomes right: after the camera has jumped, and while it flies.
//!
//! Everything runs as in a window: workers make tiles while frames are drawn, each frame takes what is
//! finished and waits for the rest of its time. \[CH07\] sections 7 and 8 measure the same by the levels
//! that are kept up with; here it is the picture's error.

use std::time::{Duration, Instant};

use relievo_engine::planet::Camera;
use relievo_engine::{Engine, View};
use relievo_gpu::{Gpu, Renderer, Still};

use super::colour::{shown, without};
use crate::metric::{PictureError, Seen, from_rgba8};
use crate::scene::{open, open_with, shots, standard, still, view};
use crate::{
    Axis, Cell, Chart, Content, Context, Curve, Figure, Point, Report, Suite, SuiteError, Table,
};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "convergence",
    sentence: "The picture's error against the time since the camera jumped, and in flight against its speed, by workers and time of a frame.",
    run,
};

/// How tiles and frames share the machine.
#[derive(Clone, Copy, Debug)]
struct Setting {
    /// Threads that make tiles.
    workers: usize,
    /// Time of a frame.
    frame: Duration,
}

impl Setting {
    fn name(self) -> String {
        let plural = if self.workers == 1 { "" } else { "s" };
        format!(
            "{} worker{plural}, {} ms a frame",
            self.workers,
            self.frame.as_millis()
        )
    }
}

/// A frame that was on the screen.
struct Shown {
    /// Milliseconds since the start.
    at_ms: f64,
    camera: Camera,
    pixels: Vec<[f32; 3]>,
    converged: bool,
}

/// What draws frames of one view after the other.
struct Window<'a> {
    gpu: &'a Gpu,
    size_px: [u32; 2],
    engine: Engine,
    still: Still,
}

impl<'a> Window<'a> {
    /// A window in which a camera's picture has converged.
    fn open(
        context: &Context,
        gpu: &'a Gpu,
        size_px: [u32; 2],
        workers: usize,
        at: Camera,
    ) -> Result<Self, SuiteError> {
        let mut engine = open_with(context, workers)?;
        let quality = standard(gpu);
        let view = view(&engine, at, size_px, &quality);
        let still = still(&mut engine, gpu, view, quality, &context.cancel)?;
        Ok(Self {
            gpu,
            size_px,
            engine,
            still,
        })
    }

    fn view(&self, camera: Camera) -> View {
        view(&self.engine, camera, self.size_px, &standard(self.gpu))
    }

    /// Draws one frame of a camera; whether nothing is missing in it.
    fn frame(&mut self, camera: Camera, dt_s: f32) -> Result<bool, SuiteError> {
        let view = self.view(camera);
        self.engine.set_view(view);
        let failed = |text: String| SuiteError::System(text);
        let frame = self.engine.drain(dt_s);
        let frame = frame.ok_or_else(|| failed("the view was not taken".to_owned()))?;
        let renderer: &mut Renderer = &mut self.still.renderer;
        let converged = frame.is_converged() && frame.uploads.is_empty() && frame.plan.settled;
        Still::submit(renderer, &frame, self.gpu).map_err(|error| failed(error.to_string()))?;
        Ok(converged)
    }

    /// Frames from now on until nothing is missing or the time is over; `camera` says where the camera is
    /// after so many seconds.
    fn watch(
        &mut self,
        context: &Context,
        frame: Duration,
        most: Duration,
        stops: bool,
        camera: &dyn Fn(f64) -> Camera,
    ) -> Result<Vec<Shown>, SuiteError> {
        let started = Instant::now();
        let mut seen = Vec::new();
        let mut before_s = 0.0;
        loop {
            context.go_on()?;
            let begun = Instant::now();
            let now_s = started.elapsed().as_secs_f64();
            let camera = camera(now_s);
            let dt_s = (now_s - before_s) as f32;
            before_s = now_s;
            let converged = self.frame(camera, dt_s)?;
            let picture = self.still.renderer.read_back();
            let picture = picture.map_err(|error| SuiteError::System(error.to_string()))?;
            seen.push(Shown {
                at_ms: started.elapsed().as_secs_f64() * 1e3,
                camera,
                pixels: from_rgba8(&picture.rgba),
                converged,
            });
            if (stops && converged) || started.elapsed() >= most {
                return Ok(seen);
            }
            std::thread::sleep(frame.saturating_sub(begun.elapsed()));
        }
    }
}

fn settings(context: &Context) -> Vec<Setting> {
    let workers: &[usize] = if context.quick { &[1] } else { &[1, 2, 4] };
    let frames: &[u64] = if context.quick { &[16] } else { &[16, 50, 200] };
    let workers = workers.iter().filter(|w| **w <= context.threads.max(2));
    let of = |workers: &usize| {
        let workers = *workers;
        frames.iter().map(move |ms| Setting {
            workers,
            frame: Duration::from_millis(*ms),
        })
    };
    workers.flat_map(of).collect()
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let gpu = match context.gpu() {
        Ok(gpu) => gpu,
        Err(why) => return Ok(without("frames of the clipmaps", why)),
    };
    let size_px = context.pick([64, 48], [480, 360]);
    let mut sharp = open(context)?;
    let shots = shots(&sharp, context)?;
    let (Some(from), Some(to)) = (shots.first(), shots.get(1)) else {
        return Err(SuiteError::Input("the project has no view".to_owned()));
    };
    let settings = settings(context);
    let mut report = Report::default();
    let mut jumps = Vec::new();
    let (mut rows, mut flights) = (Vec::new(), Vec::new());
    let most = Duration::from_secs(context.pick(20, 60));
    let truth = picture(context, gpu, &mut sharp, size_px, to.camera)?;
    for (done, setting) in settings.iter().enumerate() {
        context.step(2 * done, 2 * settings.len())?;
        let mut window = Window::open(context, gpu, size_px, setting.workers, from.camera)?;
        let seen = window.watch(context, setting.frame, most, true, &|_| to.camera)?;
        let errors: Vec<f64> = seen
            .iter()
            .map(|s| mean_de(size_px, &truth, &s.pixels))
            .collect();
        rows.push(jump_row(*setting, &seen, &errors));
        let points = seen.iter().zip(&errors);
        jumps.push(Curve {
            name: setting.name(),
            points: points
                .map(|(s, error)| Point::new(format!("{:.0} ms", s.at_ms), s.at_ms, *error))
                .collect(),
            joined: true,
        });
        context.step(2 * done + 1, 2 * settings.len())?;
        flights.push(flight(
            context,
            &mut window,
            &mut sharp,
            to.camera,
            *setting,
        )?);
    }
    report.summary = rows.iter().zip(&settings).map(|((settled_ms, _), setting)| {
        format!("{}: {settled_ms:.0} ms after a jump the picture is within one CIEDE2000 of the converged one on average.", setting.name())
    }).collect();
    report.figures.push(jump_chart(from.name, to.name, jumps));
    report
        .figures
        .push(jump_table(rows.into_iter().map(|(_, row)| row).collect()));
    report.figures.push(flight_chart(flights));
    Ok(report)
}

/// The converged picture of a camera.
fn picture(
    context: &Context,
    gpu: &Gpu,
    engine: &mut Engine,
    size_px: [u32; 2],
    camera: Camera,
) -> Result<Vec<[f32; 3]>, SuiteError> {
    let quality = standard(gpu);
    let view = view(engine, camera, size_px, &quality);
    shown(&still(engine, gpu, view, quality, &context.cancel)?)
}

fn mean_de([width, height]: [u32; 2], truth: &[[f32; 3]], pixels: &[[f32; 3]]) -> f64 {
    let size_px = [width as usize, height as usize];
    let truth = Seen {
        size_px,
        pixels: truth,
    };
    PictureError::between(&truth, &Seen { size_px, pixels }).mean_de
}

/// Errors in flight, by speed.
fn flight(
    context: &Context,
    window: &mut Window,
    sharp: &mut Engine,
    from: Camera,
    setting: Setting,
) -> Result<Curve, SuiteError> {
    let speeds: &[f64] = if context.quick {
        &[1.0]
    } else {
        &[0.25, 1.0, 4.0, 16.0]
    };
    let seconds = context.pick(0.5, 3.0);
    let samples = context.pick(2, 6);
    let radius_m = window.engine.project().planet.body.figure().radius_m;
    let mut curve = Curve {
        name: setting.name(),
        points: Vec::new(),
        joined: true,
    };
    for speed in speeds {
        // Towards north at one height: where the camera is depends on the time only.
        let height_m = (from.altitude_m - window.engine.ground_m(from.map_point())).max(1.0);
        let camera = |s: f64| Camera {
            lat_rad: (from.lat_rad + speed * height_m * s / radius_m).min(1.5),
            heading_rad: 0.0,
            ..from
        };
        let most = Duration::from_secs_f64(seconds);
        let seen = window.watch(context, setting.frame, most, false, &camera)?;
        let every = (seen.len() / samples).max(1);
        let mut errors = Vec::new();
        for frame in seen.iter().skip(every / 2).step_by(every) {
            context.go_on()?;
            let truth = picture(context, window.gpu, sharp, window.size_px, frame.camera)?;
            errors.push(mean_de(window.size_px, &truth, &frame.pixels));
        }
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        curve.points.push(Point::new(
            format!("{speed} heights a second"),
            *speed,
            mean,
        ));
    }
    Ok(curve)
}

/// When a jump's picture is within one colour difference of its end, and its row.
fn jump_row(setting: Setting, seen: &[Shown], errors: &[f64]) -> (f64, Vec<Cell>) {
    let within = |limit: f64| {
        let late = errors.iter().rposition(|e| *e > limit).map_or(0, |i| i + 1);
        seen.get(late).map_or(f64::INFINITY, |s| s.at_ms)
    };
    let last = seen.last();
    let row = vec![
        setting.name().into(),
        within(3.0).into(),
        within(1.0).into(),
        last.map_or(f64::NAN, |s| s.at_ms).into(),
        if last.is_some_and(|s| s.converged) {
            "yes"
        } else {
            "no"
        }
        .into(),
        errors.last().copied().unwrap_or(f64::NAN).into(),
        (seen.len() as f64).into(),
    ];
    (within(1.0), row)
}

fn jump_chart(from: &str, to: &str, curves: Vec<Curve>) -> Figure {
    Figure::new(
        "jump",
        "Error since a jump of the camera",
        format!(
            "Mean CIEDE2000 against the converged picture, frame by frame, after a jump from “{from}” to \
             “{to}” with nothing made in advance."
        ),
        Content::Chart(Chart {
            x: Axis::log("time since the jump", "ms"),
            y: Axis::log("mean colour difference", "ΔE00"),
            curves,
            marks_front: false,
        }),
    )
}

fn jump_table(rows: Vec<Vec<Cell>>) -> Figure {
    let head = [
        "setting",
        "within 3 ΔE00 after, ms",
        "within 1 ΔE00 after, ms",
        "last frame, ms",
        "converged",
        "error of the last frame, ΔE00",
        "frames",
    ];
    Figure::new(
        "jump-table",
        "When a jump's picture is right",
        "Means over all pixels, for good: no later frame is farther off.",
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    )
}

fn flight_chart(curves: Vec<Curve>) -> Figure {
    Figure::new(
        "flight",
        "Error in flight",
        "Mean CIEDE2000 of frames on the way against the converged picture of the same camera, by speed in \
         heights above the ground a second; [CH07] table 1 keeps its levels up to 0.8.",
        Content::Chart(Chart {
            x: Axis::log("speed", "heights per second"),
            y: Axis::log("mean colour difference", "ΔE00"),
            curves,
            marks_front: false,
        }),
    )
}
