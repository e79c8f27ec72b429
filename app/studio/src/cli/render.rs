//! `relievo render`: a picture of a project, converged unless a time limit says otherwise.

mod reference;
mod stats;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use relievo_engine::planet::Camera;
use relievo_engine::planet::camera::CameraError;
use relievo_engine::{Engine, Severity, View};
use relievo_gpu::{Gpu, GpuError, Picture, ReadError, RenderError, Renderer, Still, StillError};

use super::progress::Progress;
use super::scenario::Scenario;
use super::{Context, Failure, project, units};
use crate::picture::{self, Fineness};
use stats::{Stats, Timings};

/// Render a picture of a project.
///
/// Waits until every visible tile is made, unless a time limit is given. Works without a display.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// The picture to write; an existing file is replaced.
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Width and height in pixels, 1 to 16384 each.
    #[arg(long, value_name = "WxH", default_value = "1280x960", value_parser = units::size)]
    size: [u32; 2],
    /// The viewer: longitude (east) and latitude in degrees, metres above the datum, and, if not
    /// north and straight down, heading (clockwise from north) and pitch (-90 down, 0 to the
    /// horizon) in degrees. Default: the project's camera.
    #[arg(
        long,
        value_name = "LON,LAT,ALT[,HEADING,PITCH]",
        allow_hyphen_values = true
    )]
    camera: Option<String>,
    /// Vertical field of view in degrees, 0.1 to 170. Default: the project's, or 60 with --camera.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    fov: Option<f64>,
    /// How the picture is drawn.
    #[arg(long, value_enum, value_name = "NAME", default_value = "clipmap")]
    front_end: FrontEnd,
    /// Write what there is after so many milliseconds. Default: wait until nothing is missing. Not for
    /// the reference, which has no half-made picture.
    #[arg(long, value_name = "MS")]
    time_limit: Option<u64>,
    /// Write figures of the picture to a JSON file: times in milliseconds, tiles, triangles, bytes.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FrontEnd {
    /// Spherical clipmaps on the graphics adapter.
    Clipmap,
    /// Rays against the evaluated ground, on the processor: slow, and what the other should show. Without
    /// texts and extruded bodies.
    Reference,
}

/// Samples along the smallest colour window that is worth drawing with.
const LEAST_WINDOW: u32 = 256;

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    check_name(&arguments.output)?;
    let started = Instant::now();
    let mut engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    for output in [Some(&arguments.output), arguments.stats.as_ref()]
        .into_iter()
        .flatten()
    {
        project::check_output(output, &[&arguments.project], &engine)?;
    }
    let camera = camera(arguments, &engine)?;
    let opened = Instant::now();
    if matches!(arguments.front_end, FrontEnd::Reference) {
        return reference::run(arguments, &engine, camera, context);
    }
    let gpu = Gpu::headless().map_err(|error| Failure::System(with_cause(&error)))?;
    let most = gpu.device.limits().max_texture_dimension_2d;
    if let Some(side) = arguments.size.into_iter().find(|s| *s > most) {
        return Err(Failure::Input(format!(
            "expected a picture of at most {most} pixels a side, found {side}"
        )));
    }
    let fineness = picture::still_fineness(&engine.project().quality, gpu.class);
    let ready = Instant::now();
    let limit = arguments.time_limit.map(Duration::from_millis);
    let mut device = Device {
        gpu,
        fineness,
        lost: false,
    };
    let (still, picture) = loop {
        let view = picture::view(camera, arguments.size, &device.fineness);
        match draw(&mut engine, view, &device, limit, context) {
            Ok((still, mut picture)) => {
                picture::labels::draw(&mut picture, &engine.labels(&view));
                break (still, picture);
            }
            Err(DrawFailure::Other(failure)) => return Err(failure),
            Err(DrawFailure::Device(error)) => device.mend(&error, context)?,
        }
        engine.forget_uploads();
    };
    let Device { gpu, fineness, .. } = device;
    let drawn = Instant::now();
    picture::write(&arguments.output, &picture).map_err(Failure::system)?;
    if let Some(path) = &arguments.stats {
        let timings = Timings {
            open_ms: ms(opened - started),
            device_ms: ms(ready - opened),
            converge_ms: ms(drawn - ready),
            write_ms: ms(drawn.elapsed()),
            tiles_busy_ms: engine.stats().busy_ns as f64 / 1e6,
            gpu_frame_ms: still.drawn.measured.map(|m| m.gpu_ms),
        };
        Stats::new(&engine, &gpu, &fineness.quality, &still, timings).write(path)?;
    }
    incomplete(&engine, &arguments.output)
}

/// Refuses names that do not say PNG.
fn check_name(output: &std::path::Path) -> Result<(), Failure> {
    if output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
    {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "expected a name that ends in .png, found {output:?}"
    )))
}

/// The camera that is asked for.
fn camera(arguments: &Arguments, engine: &Engine) -> Result<Camera, Failure> {
    let mut camera = match &arguments.camera {
        Some(text) => text
            .parse()
            .map_err(|e: CameraError| Failure::Input(format!("--camera {text}: {e}")))?,
        None => engine.project().camera.to_camera(),
    };
    if let Some(fov_deg) = arguments.fov {
        if !(0.1..=170.0).contains(&fov_deg) {
            return Err(Failure::Input(format!(
                "--fov: expected 0.1 to 170 degrees, found {fov_deg}"
            )));
        }
        camera.fov_y_rad = fov_deg.to_radians();
    }
    Ok(camera)
}

/// What a picture is drawn with.
struct Device {
    gpu: Gpu,
    fineness: Fineness,
    /// Whether one was lost before.
    lost: bool,
}

/// Why a picture is not drawn.
enum DrawFailure {
    /// The device, for which something may be done.
    Device(RenderError),
    /// Anything else.
    Other(Failure),
}

impl Device {
    /// Does what can be done about a failure of the device, and tells it: a lost one is replaced
    /// once, one without room draws less finely.
    fn mend(&mut self, error: &RenderError, context: &mut Context) -> Result<(), Failure> {
        let smaller = self.fineness.quality.colour_window / 2;
        match error {
            RenderError::DeviceLost if !self.lost => {
                context.note(format!("{error}; drawing once more on another"));
                self.gpu = Gpu::headless().map_err(|e| Failure::System(with_cause(&e)))?;
                self.lost = true;
                Ok(())
            }
            RenderError::OutOfMemory(_) if smaller >= LEAST_WINDOW => {
                context.note(format!(
                    "{error}; drawing less finely, in colour windows of {smaller} samples"
                ));
                self.fineness.quality.colour_window = smaller;
                Ok(())
            }
            RenderError::DeviceLost | RenderError::OutOfMemory(_) | RenderError::Upload(_) => {
                Err(Failure::system(error))
            }
        }
    }
}

/// Draws a picture and reads it back.
fn draw(
    engine: &mut Engine,
    view: View,
    device: &Device,
    limit: Option<Duration>,
    context: &Context,
) -> Result<(Still, Picture), DrawFailure> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let renderer = Renderer::new(&device.gpu, format, device.fineness.quality)
        .map_err(|e| DrawFailure::Other(Failure::input(e)))?;
    let progress = Progress::new("making tiles");
    let mut watch = |share| {
        progress.set(share);
        !context.cancel.is_cancelled()
    };
    let still =
        Still::draw(engine, view, &device.gpu, renderer, limit, &mut watch).map_err(|error| {
            match error {
                StillError::Cancelled => DrawFailure::Other(Failure::Cancelled),
                StillError::NoFrame => DrawFailure::Other(Failure::system(error)),
                StillError::Render(error) => DrawFailure::Device(error),
            }
        })?;
    match still.renderer.read_back() {
        Ok(picture) => Ok((still, picture)),
        Err(ReadError::DeviceLost) => Err(DrawFailure::Device(RenderError::DeviceLost)),
    }
}

/// Bad input when parts of the picture could not be made.
fn incomplete(engine: &Engine, output: &std::path::Path) -> Result<(), Failure> {
    let failed = engine.stats().tiles.failed;
    let first = engine
        .messages()
        .iter()
        .find(|m| m.severity == Severity::Error);
    match first {
        Some(message) if failed > 0 => Err(Failure::Input(format!(
            "{output:?} is written, but {failed} tiles could not be made, the first because: {}",
            message.text
        ))),
        _ => Ok(()),
    }
}

/// An error with the reason that its text leaves out.
fn with_cause(error: &GpuError) -> String {
    match std::error::Error::source(error) {
        Some(cause) => format!("{error}: {cause}"),
        None => error.to_string(),
    }
}

fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}
