//! What a picture cost, as JSON.

use std::path::Path;

use relievo_engine::{Engine, LevelView};
use relievo_gpu::{Gpu, Quality, Still};
use serde::Serialize;

use crate::cli::Failure;

/// Wall clock times, milliseconds.
#[derive(Serialize)]
#[expect(
    clippy::struct_field_names,
    reason = "units belong into names that users read"
)]
pub(super) struct Timings {
    /// Opening the project and its files, pyramids included.
    pub(super) open_ms: f64,
    /// Opening the device and making pipelines.
    pub(super) device_ms: f64,
    /// From the view to the last tile on the screen.
    pub(super) converge_ms: f64,
    /// Reading the picture back and writing it.
    pub(super) write_ms: f64,
    /// Making tiles, summed over threads.
    pub(super) tiles_busy_ms: f64,
    /// The device, for the latest frame that was measured.
    pub(super) gpu_frame_ms: Option<f64>,
}

/// All figures of a picture.
#[derive(Serialize)]
pub(super) struct Stats {
    converged: bool,
    size_px: [u32; 2],
    adapter: String,
    adapter_class: String,
    backend: String,
    timings: Timings,
    tiles_made: u64,
    tiles_failed: u64,
    tiles_in_vain: u64,
    tiles_pending: usize,
    cache_bytes: usize,
    uploads: u32,
    uploaded_bytes: u64,
    gpu_bytes: u64,
    triangles: u64,
    triangles_without_culling: u64,
    draws: u32,
    colour_window_samples: u32,
    height_levels: Vec<Level>,
    colour_levels: Vec<Level>,
    normal_levels: Vec<Level>,
    /// What of colour, light and air the terrain's pipeline has.
    pipeline: Pipeline,
    /// Layers without effect on the picture, and why: not compiled, off the screen or covered.
    left_out: Vec<LeftOut>,
    /// Parts of the drawing that nothing needed, and why.
    drawing_left_out: Vec<PartLeftOut>,
    messages: Vec<String>,
    peak_rss_bytes: Option<u64>,
}

/// One clip level on the screen.
#[derive(Serialize)]
struct Level {
    n: u8,
    m: u8,
    sample_m: f64,
    /// Samples along a pixel in the middle of the picture, on ground seen from straight above.
    samples_per_px: f64,
}

#[derive(Serialize)]
struct Pipeline {
    colour: bool,
    normals: bool,
    haze: bool,
    max_taps: u32,
}

#[derive(Serialize)]
struct PartLeftOut {
    part: &'static str,
    reason: &'static str,
}

#[derive(Serialize)]
struct LeftOut {
    layer: String,
    reason: String,
}

impl Stats {
    pub(super) fn new(
        engine: &Engine,
        gpu: &Gpu,
        quality: &Quality,
        still: &Still,
        timings: Timings,
    ) -> Self {
        let (tiles, frame, drawn) = (engine.stats().tiles, &still.frame, &still.drawn);
        let pixel_m = frame.plan.pixel_rad * frame.plan.clearance_m;
        let levels = |views: &[LevelView]| {
            views
                .iter()
                .map(|v| Level::of(v, frame.planet.radius_m, pixel_m))
                .collect()
        };
        Self {
            converged: still.converged,
            size_px: frame.viewport_px,
            adapter: gpu.info.name.clone(),
            adapter_class: format!("{:?}", gpu.class).to_lowercase(),
            backend: gpu.info.backend.to_string(),
            timings,
            tiles_made: tiles.made,
            tiles_failed: tiles.failed,
            tiles_in_vain: tiles.in_vain,
            tiles_pending: frame.pending,
            cache_bytes: tiles.cache_bytes,
            uploads: drawn.uploads,
            uploaded_bytes: drawn.uploaded_bytes,
            gpu_bytes: drawn.gpu_memory,
            triangles: drawn.triangles,
            triangles_without_culling: drawn.triangles_without_culling,
            draws: drawn.draws,
            colour_window_samples: quality.colour_window,
            height_levels: levels(&frame.heights),
            colour_levels: levels(&frame.colours),
            normal_levels: levels(&frame.normals),
            pipeline: Pipeline {
                colour: drawn.pipeline.colour,
                normals: drawn.pipeline.normals,
                haze: drawn.pipeline.haze,
                max_taps: drawn.pipeline.max_taps,
            },
            left_out: left_out(engine),
            drawing_left_out: drawn
                .left_out()
                .into_iter()
                .map(|(part, reason)| PartLeftOut { part, reason })
                .collect(),
            messages: engine.messages().iter().map(|m| m.text.clone()).collect(),
            peak_rss_bytes: peak_rss_bytes(),
        }
    }

    /// Writes them; a name that cannot be written is the system's failure.
    pub(super) fn write(&self, path: &Path) -> Result<(), Failure> {
        write_json(path, self)
    }
}

impl Level {
    fn of(view: &LevelView, radius_m: f64, pixel_m: f64) -> Self {
        let level = view.window.level;
        let sample_m = level.step_rad().y * radius_m;
        Self {
            n: level.n,
            m: level.m,
            sample_m,
            samples_per_px: pixel_m / sample_m,
        }
    }
}

/// Writes figures of any kind as JSON.
pub(super) fn write_json(path: &Path, figures: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(figures).map_err(Failure::system)?;
    text.push('\n');
    std::fs::write(path, text)
        .map_err(|e| Failure::System(format!("cannot write the figures: {e}: {path:?}")))
}

fn left_out(engine: &Engine) -> Vec<LeftOut> {
    let unseen = engine.unseen();
    let left_out = engine.left_out().iter().chain(&unseen);
    left_out
        .map(|(id, reason)| LeftOut {
            layer: id.0.clone(),
            reason: (*reason).to_owned(),
        })
        .collect()
}

/// Most memory that the process had at any time, bytes; `None` where the system does not tell.
fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
