//! `relievo render`: a picture of a project, converged unless a time limit says otherwise.

mod stats;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use relievo_engine::planet::Camera;
use relievo_engine::planet::camera::CameraError;
use relievo_engine::{ClipKind, Engine, Frame, Severity, View};
use relievo_gpu::{FrameStats, Gpu, GpuError, Renderer};

use super::progress::Progress;
use super::{Context, Failure, project, units};
use crate::picture;
use stats::{Stats, Timings};

/// Render a picture of a project.
///
/// Waits until every visible tile is made, unless a time limit is given. Works without a display.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
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
    /// Write what there is after so many milliseconds. Default: wait until nothing is missing.
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
}

/// How many frames may pass without a settled plan once nothing is missing.
const MOST_SETTLING_FRAMES: u32 = 200;

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let FrontEnd::Clipmap = arguments.front_end;
    check_name(&arguments.output)?;
    let started = Instant::now();
    let mut engine = project::open_complete(&arguments.project, context)?;
    for output in [Some(&arguments.output), arguments.stats.as_ref()]
        .into_iter()
        .flatten()
    {
        project::check_output(output, &[&arguments.project], &engine)?;
    }
    let camera = camera(arguments, &engine)?;
    let opened = Instant::now();
    let gpu = Gpu::headless().map_err(|error| Failure::System(with_cause(&error)))?;
    let most = gpu.device.limits().max_texture_dimension_2d;
    if let Some(side) = arguments.size.into_iter().find(|s| *s > most) {
        return Err(Failure::Input(format!(
            "expected a picture of at most {most} pixels a side, found {side}"
        )));
    }
    let quality = picture::still_quality(&engine.project().quality, gpu.class);
    let view = picture::view(camera, arguments.size, &engine.project().quality, &quality);
    let renderer =
        Renderer::new(&gpu, wgpu::TextureFormat::Rgba8Unorm, quality).map_err(Failure::input)?;
    let ready = Instant::now();
    let limit = arguments.time_limit.map(Duration::from_millis);
    let still = Still::converge(&mut engine, view, &gpu, renderer, limit, context)?;
    let drawn = Instant::now();
    let picture = still.renderer.read_back().map_err(Failure::system)?;
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
        Stats::new(&engine, &gpu, &quality, &still, timings).write(path)?;
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

/// A picture that is drawn.
struct Still {
    renderer: Renderer,
    /// The last frame.
    frame: Frame,
    /// What the last drawn frame cost.
    drawn: FrameStats,
    /// Whether nothing is missing.
    converged: bool,
}

impl Still {
    /// Draws until nothing is missing or the time is over.
    fn converge(
        engine: &mut Engine,
        view: View,
        gpu: &Gpu,
        mut renderer: Renderer,
        limit: Option<Duration>,
        context: &Context,
    ) -> Result<Self, Failure> {
        let started = Instant::now();
        let progress = Progress::new("making tiles");
        engine.set_view(view);
        // Nobody sees a still before it is done: what comes is kept for the one frame that is drawn.
        let (mut held, mut most_pending) = (Vec::new(), 1);
        let mut settling = 0;
        loop {
            if context.cancel.is_cancelled() {
                return Err(Failure::Cancelled);
            }
            let Some(mut frame) = engine.drain(f32::INFINITY) else {
                return Err(Failure::System("the view was not taken".to_owned()));
            };
            let complete = frame.is_converged() && frame.uploads.is_empty();
            settling += u32::from(complete);
            let converged = complete && (frame.plan.settled || settling > MOST_SETTLING_FRAMES);
            let over = limit.is_some_and(|l| started.elapsed() >= l);
            most_pending = most_pending.max(frame.pending);
            progress.set(1.0 - frame.pending as f64 / most_pending as f64);
            held.append(&mut frame.uploads);
            if converged || over {
                // Levels that an earlier plan had are gone.
                held.retain(|upload| (upload.layer as usize) < levels(&frame, upload.clipmap));
                frame.uploads = held;
                let mut encoder = gpu
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let drawn = renderer
                    .render(&frame, &mut encoder)
                    .map_err(Failure::system)?;
                gpu.queue.submit([encoder.finish()]);
                frame.uploads.clear();
                return Ok(Self {
                    renderer,
                    frame,
                    drawn,
                    converged,
                });
            }
            if !complete {
                let left = limit.map_or(Duration::MAX, |l| l.saturating_sub(started.elapsed()));
                engine.wait(left.min(Duration::from_millis(100)));
            }
        }
    }
}

/// Number of levels of a clipmap.
fn levels(frame: &Frame, clipmap: ClipKind) -> usize {
    match clipmap {
        ClipKind::Height => frame.heights.len(),
        ClipKind::Colour => frame.colours.len(),
        ClipKind::Normal => frame.normals.len(),
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
