//! Suite `leaving-out`: scenes with layers that nobody sees, against the scene without them.

#[path = "../../../../core/engine/tests/leaving_out/scenes.rs"]
mod scenes;

use std::time::{Duration, Instant};

use relievo_engine::graph::ContentId;
use relievo_engine::planet::{Camera, TileKey};
use relievo_engine::project::{Body, NoiseMode, Project};
use relievo_engine::{ClipKind, Engine, EngineOptions, Frame, NodeReport, View};
use relievo_gpu::{FrameStats, Gpu, Quality, Renderer};

use crate::{Cell, Content, Context, Figure, Report, Suite, SuiteError, Table};
use scenes::KINDS;

/// The suite.
pub const SUITE: Suite = Suite {
    name: "leaving-out",
    sentence: "Hidden, inert, unseen and covered layers: the same graph, tiles, memory, pipeline and time as without.",
    run,
};

/// How many such layers.
const COUNTS: [usize; 4] = [0, 1, 10, 50];

/// A picture's size; its windows are small, so that what is measured is the engine's work.
const VIEWPORT_PX: [u32; 2] = [320, 240];

/// Everything that a picture is made of, and what it took.
struct Made {
    nodes: Vec<NodeReport>,
    tiles: Vec<(ClipKind, TileKey, ContentId)>,
    tasks: u64,
    cache_bytes: usize,
    resident: usize,
    left_out: usize,
    unseen: usize,
    time_ms: f64,
    frame: Frame,
}

impl Made {
    /// The graph, not counting what layers are called.
    fn graph(&self) -> Vec<NodeReport> {
        let mut nodes = self.nodes.clone();
        for node in &mut nodes {
            node.layer = None;
        }
        nodes
    }
}

/// Makes a picture from nothing.
fn make(context: &Context, project: Project) -> Result<Made, SuiteError> {
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let system = |error: std::io::Error| SuiteError::System(error.to_string());
    let camera = Camera::from_degrees(10.0, 45.0, 4000.0, 0.0, -60.0, 60.0)
        .map_err(|error| SuiteError::Input(error.to_string()))?;
    let folder = tempfile::tempdir().map_err(system)?;
    std::fs::write(folder.path().join(scenes::FAR), scenes::FAR_FEATURE).map_err(system)?;
    let start = Instant::now();
    let mut engine = Engine::new(project, folder.path(), options).map_err(system)?;
    engine.wait_for_sources();
    engine.set_view(View {
        camera,
        viewport_px: VIEWPORT_PX,
        // Two rows of tiles at the coarsest level: the other side of the planet has one of its own.
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 512,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    let mut uploads = Vec::new();
    let frame = loop {
        context.go_on()?;
        let Some(mut frame) = engine.drain(f32::INFINITY) else {
            return Err(SuiteError::System("the view was not taken".to_owned()));
        };
        let done = frame.is_converged() && frame.uploads.is_empty() && frame.plan.settled;
        uploads.append(&mut frame.uploads);
        if done {
            frame.uploads = uploads;
            break frame;
        }
        engine.wait(Duration::from_millis(20));
    };
    let time_ms = start.elapsed().as_secs_f64() * 1e3;
    let stats = engine.stats();
    Ok(Made {
        nodes: engine.nodes(),
        tiles: engine.visible_tiles(),
        tasks: stats.tiles.made,
        cache_bytes: stats.tiles.cache_bytes,
        resident: stats.kept.resident,
        left_out: engine.left_out().len(),
        unseen: engine.unseen().len(),
        time_ms,
        frame,
    })
}

/// Draws a picture's frame; what the device was asked for.
fn draw(gpu: &Gpu, frame: &Frame) -> Result<FrameStats, SuiteError> {
    let system = |error: &dyn core::fmt::Display| SuiteError::System(error.to_string());
    let quality = Quality {
        colour_window: frame.colour_window,
        ..Quality::for_adapter(gpu.class)
    };
    let mut renderer = Renderer::offscreen(gpu, quality).map_err(|e| system(&e))?;
    renderer.render_now(frame).map_err(|e| system(&e))
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let mut figures = vec![same_work(context)?, same_time(context)?, unused(context)?];
    figures.extend(program());
    Ok(Report {
        summary: vec![
            "A layer that is hidden, has no effect, lies off the screen or under an opaque one costs nothing: \
             the visible tiles have the same names, so the same ones are made and kept. Hidden layers and \
             those without effect are no part of the graph at all."
                .to_owned(),
            "Colours, normals and air that a scene lacks are no part of the shader that draws it, and have no \
             memory on the device."
                .to_owned(),
        ],
        figures,
    })
}

fn yes(is_so: bool) -> Cell {
    if is_so { "yes" } else { "NO" }.into()
}

fn head(columns: &[&str]) -> Vec<String> {
    columns.iter().map(|c| (*c).to_owned()).collect()
}

/// Scenes with such layers against the scene without: what is made and kept.
fn same_work(context: &Context) -> Result<Figure, SuiteError> {
    let without = make(context, scenes::plain())?;
    let gpu = context.gpu();
    let drawn_without = gpu.map(|gpu| draw(gpu, &without.frame)).ok().transpose()?;
    let counts = context.pick(&COUNTS[..2], &COUNTS[..]);
    let mut rows = Vec::new();
    for (k, kind) in KINDS.iter().enumerate() {
        for (c, count) in counts.iter().enumerate() {
            context.step(k * counts.len() + c, 3 * KINDS.len() * counts.len())?;
            let mut project = scenes::plain();
            (kind.add)(&mut project, *count);
            let with = make(context, project)?;
            let drawn = gpu.map(|gpu| draw(gpu, &with.frame)).ok().transpose()?;
            let on_device =
                |same: fn(&FrameStats, &FrameStats) -> bool| match (&drawn, &drawn_without) {
                    (Some(a), Some(b)) => yes(same(a, b)),
                    _ => "no device".into(),
                };
            rows.push(vec![
                kind.name.into(),
                Cell::Number(*count as f64),
                if kind.unseen.is_none() {
                    yes(with.graph() == without.graph())
                } else {
                    "left out tile by tile".into()
                },
                yes(with.tiles == without.tiles),
                Cell::Number(with.tasks as f64 - without.tasks as f64),
                Cell::Number(with.cache_bytes as f64 - without.cache_bytes as f64),
                Cell::Number(with.resident as f64 - without.resident as f64),
                on_device(|a, b| a.pipeline == b.pipeline),
                on_device(|a, b| {
                    (a.gpu_memory, a.draws, a.triangles) == (b.gpu_memory, b.draws, b.triangles)
                }),
                Cell::Number((with.left_out + with.unseen) as f64),
            ]);
        }
    }
    let columns = [
        "layers that are",
        "how many",
        "same graph",
        "same names of visible tiles",
        "tiles made more",
        "bytes of cache more",
        "tiles kept more",
        "same pipeline",
        "same device memory and draws",
        "named as left out or unseen",
    ];
    Ok(Figure::new(
        "same-work",
        "What layers that nobody sees make and keep",
        "Hills in the colours of their heights, with so many more layers (off the screen: an area on the \
         other side of the planet), against the scene without them. Names are content ids: equal names mean \
         equal samples.",
        Content::Table(Table {
            head: head(&columns),
            rows,
        }),
    ))
}

/// The same scenes' times.
fn same_time(context: &Context) -> Result<Figure, SuiteError> {
    let pairs = context.pick(2, 20);
    let count = COUNTS[COUNTS.len() - 1];
    let mut rows = Vec::new();
    for (k, kind) in KINDS.iter().enumerate() {
        let (mut without, mut with) = (Vec::new(), Vec::new());
        for pair in 0..=pairs {
            context.step(
                KINDS.len() * (pairs + 1) + k * (pairs + 1) + pair,
                2 * KINDS.len() * (pairs + 1),
            )?;
            let mut project = scenes::plain();
            (kind.add)(&mut project, count);
            let scenes = [(&mut without, scenes::plain()), (&mut with, project)];
            for (times, project) in scenes {
                let time_ms = make(context, project)?.time_ms;
                // The first pair warms up.
                if pair > 0 {
                    times.push(time_ms);
                }
            }
        }
        let (difference_ms, half_ms) = paired(&without, &with);
        let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
        rows.push(vec![
            kind.name.into(),
            mean(&without).into(),
            mean(&with).into(),
            difference_ms.into(),
            half_ms.into(),
            yes((difference_ms - half_ms..=difference_ms + half_ms).contains(&0.0)),
        ]);
    }
    let columns = [
        "layers that are",
        "without, ms",
        "with, ms",
        "difference, ms",
        "± (95 %), ms",
        "zero is within",
    ];
    Ok(Figure::new(
        "same-time",
        format!("Time of a picture without and with {count} layers that nobody sees"),
        format!(
            "From a new engine to the converged picture on one thread, {pairs} pairs in turns after one that \
             warms up. The difference is the mean over pairs, with the interval that holds it 95 times of 100 \
             (Student). Compiling the project's layers is part of the time."
        ),
        Content::Table(Table {
            head: head(&columns),
            rows,
        }),
    ))
}

/// Mean difference of pairs, and half the width of its 95 % confidence interval.
fn paired(before: &[f64], after: &[f64]) -> (f64, f64) {
    let differences: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let freedom = count - 1.0;
    let variance = differences
        .iter()
        .map(|d| (d - mean) * (d - mean))
        .sum::<f64>()
        / freedom;
    // Student's quantile by its expansion in 1/ν (Abramowitz and Stegun 26.7.5), good to 0.3 % from ν = 4.
    let part = 1.0 / freedom;
    let quantile = 1.960 + part * (2.372 + part * (2.823 + part * 2.556));
    (mean, quantile * (variance / count).sqrt())
}

/// What of the drawing a scene does without.
fn unused(context: &Context) -> Result<Figure, SuiteError> {
    let hills = || scenes::layer("hills", scenes::noise(200.0, NoiseMode::Add));
    let tint = || scenes::layer("tint", scenes::tint());
    let scene = |layers| Project {
        layers,
        ..Project::default()
    };
    let mut airless = scenes::plain();
    airless.planet.body = Body::Moon;
    let all = [
        ("colours, normals, air", scenes::plain()),
        ("no colours", scene(vec![hills()])),
        ("no normals", scene(vec![tint()])),
        ("neither colours nor normals", scene(Vec::new())),
        ("no air", airless),
    ];
    let mut rows = Vec::new();
    for (name, project) in all {
        let made = make(context, project)?;
        let levels = [
            &made.frame.heights,
            &made.frame.colours,
            &made.frame.normals,
        ];
        let mut row: Vec<Cell> = vec![name.into()];
        row.extend(levels.map(|l| Cell::Number(l.len() as f64)));
        row.push(Cell::Number(made.tiles.len() as f64));
        match context.gpu() {
            Ok(gpu) => {
                let drawn = draw(gpu, &made.frame)?;
                let key = drawn.pipeline;
                let parts = [
                    (key.colour, "colour"),
                    (key.normals, "normals"),
                    (key.haze, "air"),
                ];
                let has: Vec<&str> = parts
                    .iter()
                    .filter(|(has, _)| *has)
                    .map(|(_, name)| *name)
                    .collect();
                row.push(if has.is_empty() {
                    "bare ground".into()
                } else {
                    has.join(", ").into()
                });
                row.push((drawn.gpu_memory as f64).into());
            }
            Err(why) => row.extend([Cell::from(why), Cell::from("")]),
        }
        rows.push(row);
    }
    let columns = [
        "scene",
        "height levels",
        "colour levels",
        "normal levels",
        "visible tiles",
        "the shader has",
        "device memory, bytes",
    ];
    Ok(Figure::new(
        "unused",
        "Clipmaps and parts of the shader that a scene lacks",
        "The pipeline is chosen by what the frame has; textures that nothing needs have one texel.",
        Content::Table(Table {
            head: head(&columns),
            rows,
        }),
    ))
}

/// Size and start of the program, where it is the program that measures.
fn program() -> Option<Figure> {
    let path = std::env::current_exe().ok()?;
    if path.file_stem()? != "relievo" {
        return None;
    }
    let bytes = std::fs::metadata(&path).ok()?.len();
    let start = || {
        let started = Instant::now();
        let ended = std::process::Command::new(&path)
            .arg("--version")
            .stdout(std::process::Stdio::null())
            .status();
        ended
            .is_ok_and(|s| s.success())
            .then(|| started.elapsed().as_secs_f64() * 1e3)
    };
    let times: Vec<f64> = (0..15).filter_map(|_| start()).collect();
    let spread = crate::Spread::of(times)?;
    let rows = vec![vec![
        Cell::Number(bytes as f64),
        spread.median.into(),
        spread.low.into(),
        spread.high.into(),
    ]];
    let columns = [
        "size of the program, bytes",
        "start to `--version`, median, ms",
        "lower quartile",
        "upper quartile",
    ];
    Some(Figure::new(
        "program",
        "The program",
        "This very program, with the features it was built with.",
        Content::Table(Table {
            head: head(&columns),
            rows,
        }),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DeviceWish;

    #[test]
    fn no_row_differs_from_the_scene_without() {
        let context = Context::new(true, DeviceWish::Without, &|_| ());
        let figure = same_work(&context).unwrap();
        let Content::Table(table) = figure.content else {
            panic!("a table");
        };
        assert!(table.rows.len() >= KINDS.len());
        for row in &table.rows {
            assert!(!row.contains(&Cell::from("NO")), "{row:?}");
            assert_eq!(
                row[4..7],
                [Cell::Number(0.0), Cell::Number(0.0), Cell::Number(0.0)],
                "{row:?}"
            );
        }
    }

    #[test]
    fn the_interval_of_pairs_is_students() {
        // Differences 1, 2, 3, 4, 5: mean 3, deviation √2.5, t(4) = 2.776.
        let (mean, half) = paired(&[0.0; 5], &[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(mean, 3.0);
        assert!(
            (half - 2.776 * (2.5_f64 / 5.0).sqrt()).abs() < 0.01,
            "{half}"
        );
    }
}
