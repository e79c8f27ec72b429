//! What suites about pictures look at: a project, views of it, its clipmap pictures and its truth.

use std::path::Path;

use relievo_engine::analysis::Task;
use relievo_engine::graph::RenderError as GraphError;
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::Project;
use relievo_engine::raster::Cancel;
use relievo_engine::{
    Confirmation, Engine, EngineOptions, ReferencePicture, ReferenceSettings, Severity, View,
};
use relievo_gpu::{AdapterClass, Gpu, Look, Quality, Renderer, Still, StillError};

use crate::{Context, SuiteError};

/// The scene that is measured where no project is given: noise down to its finest octave, no files.
const OWN: &str = include_str!("../../../projects/synthetic.relievo");

/// One in so many pixels, across and down, confirms a reference picture.
const CONFIRM_EVERY: u32 = 8;

/// A camera with the words that a report calls it by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pub(crate) name: &'static str,
    pub(crate) camera: Camera,
}

/// An engine on the project of a context, or on the suites' own scene, with all files open.
pub(crate) fn open(context: &Context) -> Result<Engine, SuiteError> {
    open_with(context, context.threads)
}

/// As [`open`], with so many threads that make tiles; nothing that was made before is kept on disk.
pub(crate) fn open_with(context: &Context, threads: usize) -> Result<Engine, SuiteError> {
    let options = EngineOptions {
        threads: Some(threads),
        disk_cache: 0,
        ..EngineOptions::default()
    };
    let system = |error: std::io::Error| SuiteError::System(error.to_string());
    let mut engine = if let Some(path) = &context.project {
        let path = std::path::absolute(path).map_err(system)?;
        let opened = Engine::open(&path, options);
        opened.map_err(|e| SuiteError::Input(e.to_string()))?.0
    } else {
        let name = Path::new("synthetic.relievo");
        let project =
            Project::from_json(OWN, name).map_err(|error| SuiteError::Input(error.to_string()))?;
        Engine::new(project, Path::new("."), options).map_err(system)?
    };
    engine.wait_for_sources();
    let broken = engine
        .messages()
        .iter()
        .find(|m| m.severity == Severity::Error);
    match broken {
        Some(message) => Err(SuiteError::Input(message.text.clone())),
        None => Ok(engine),
    }
}

/// Views of a project: its own camera, and from there ever nearer to the ground.
pub(crate) fn shots(engine: &Engine, context: &Context) -> Result<Vec<Shot>, SuiteError> {
    let own = engine.project().camera.to_camera();
    let place = MapPoint::new(own.lon_rad, core::f64::consts::FRAC_PI_2 - own.lat_rad);
    let ground_m = engine
        .questions()
        .place(place, &context.cancel)
        .map_err(|error| failed(&error))?
        .height_m
        * engine.project().planet.vertical_exaggeration;
    let above = |name, height_m: f64, pitch_deg: f64| Shot {
        name,
        camera: Camera {
            altitude_m: ground_m + height_m,
            heading_rad: 0.5,
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 60.0_f64.to_radians(),
            ..own
        },
    };
    let all = vec![
        above("50 km up, 40° down", 5e4, -40.0),
        above("2 km up, 12° down", 2e3, -12.0),
        Shot {
            name: "the project's own camera",
            camera: own,
        },
        above("5 km up, straight down", 5e3, -90.0),
    ];
    let count = context.pick(2, all.len());
    Ok(all.into_iter().take(count).collect())
}

/// What the front-end spends where nothing else is asked for.
pub(crate) fn standard(gpu: &Gpu) -> Quality {
    Quality {
        colour_window: Quality::for_adapter(gpu.class).colour_window,
        ..Quality::for_adapter(AdapterClass::Discrete)
    }
}

/// The view of a camera with a quality, as the window asks for it.
pub(crate) fn view(engine: &Engine, camera: Camera, size_px: [u32; 2], quality: &Quality) -> View {
    let texel_px = engine.project().quality.texel_px;
    View {
        camera,
        viewport_px: size_px,
        layout: quality.layout,
        colour_window: quality.colour_window,
        colour_texel_px: texel_px,
        height_texel_px: 2.0 * texel_px,
        max_taps: quality.max_taps,
    }
}

/// A converged picture of the clipmaps.
pub(crate) fn still(
    engine: &mut Engine,
    gpu: &Gpu,
    view: View,
    quality: Quality,
    cancel: &Cancel,
) -> Result<Still, SuiteError> {
    let format = relievo_gpu::targets::COLOUR_FORMAT;
    let renderer = Renderer::new(gpu, format, quality)
        .map_err(|error| SuiteError::Input(error.to_string()))?;
    // Another renderer has nothing of what was sent to the one before.
    engine.forget_uploads();
    let mut watch = |_| !cancel.is_cancelled();
    Still::draw(engine, view, gpu, renderer, None, &mut watch).map_err(|error| match error {
        StillError::Cancelled => SuiteError::Cancelled,
        StillError::NoFrame | StillError::Render(_) => SuiteError::System(error.to_string()),
    })
}

/// The truth of a picture, with what half its spacing would change.
pub(crate) fn truth(
    engine: &Engine,
    camera: Camera,
    size_px: [u32; 2],
    context: &Context,
) -> Result<(ReferencePicture, Confirmation), SuiteError> {
    let settings = settings(size_px, context);
    let reference = engine.reference(camera);
    let task = Task::quiet(&context.cancel);
    let picture = reference
        .picture(&settings, &task)
        .map_err(|e| failed(&e))?;
    let confirmed = reference
        .confirm(&picture, &settings, CONFIRM_EVERY, &task)
        .map_err(|e| failed(&e))?;
    Ok((picture, confirmed))
}

/// Settings of truths: those of the picture that the front-end shows.
pub(crate) fn settings(size_px: [u32; 2], context: &Context) -> ReferenceSettings {
    ReferenceSettings {
        haze: f64::from(Look::default().haze),
        ..ReferenceSettings::new(size_px, context.threads)
    }
}

/// A graph's error as a suite's.
pub(crate) fn failed(error: &GraphError) -> SuiteError {
    match error {
        GraphError::Cancelled => SuiteError::Cancelled,
        other @ (GraphError::Read(_) | GraphError::Node { .. }) => {
            SuiteError::Input(other.to_string())
        }
    }
}
