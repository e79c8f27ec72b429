//! Opening a project to the first full picture, and once more with what the first run kept on disk.
//!
//! `cargo bench -p relievo-engine --bench reopening [-- PROJECT]`; times in milliseconds, best of
//! three, without drawing.

#![expect(clippy::print_stdout, reason = "a bench says what it found")]
#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has failed")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use relievo_engine::planet::Camera;
use relievo_engine::{Engine, EngineOptions, EngineStats, View};

/// What took how long, counted from the start.
struct Times {
    opened: Duration,
    complete: Duration,
    closed: Duration,
    stats: EngineStats,
}

fn open(project: &Path, cache: Option<PathBuf>) -> Times {
    let start = Instant::now();
    let options = EngineOptions {
        cache_folder: cache,
        ..EngineOptions::default()
    };
    let (mut engine, _) = Engine::open(project, options).unwrap();
    let camera: Camera = engine.project().camera.to_camera();
    engine.set_view(View {
        camera,
        viewport_px: [1280, 960],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 1024,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    let mut opened = None;
    loop {
        let frame = engine.drain(f32::INFINITY).unwrap();
        if engine.stats().opening == 0 {
            opened.get_or_insert_with(|| start.elapsed());
        }
        if frame.is_converged() && frame.plan.settled && frame.uploads.is_empty() {
            break;
        }
        engine.wait(Duration::from_millis(100));
    }
    let complete = start.elapsed();
    let stats = engine.stats();
    let closing = Instant::now();
    drop(engine);
    Times {
        opened: opened.unwrap_or_default(),
        complete,
        closed: closing.elapsed(),
        stats,
    }
}

fn tell(what: &str, times: &Times) {
    let ms = |d: Duration| d.as_secs_f64() * 1e3;
    let tiles = times.stats.tiles;
    println!(
        "| {what} | {:.0} | {:.0} | {} | {:.0} | {} | {} | {:.0} |",
        ms(times.opened),
        ms(times.complete),
        tiles.made,
        times.stats.busy_ns as f64 / 1e6,
        tiles.loaded,
        tiles.stored,
        ms(times.closed),
    );
}

fn main() {
    let named = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects");
    let project = named.map_or_else(|| projects.join("earth.relievo"), PathBuf::from);
    println!("| run | files open | complete | made | making | read | written | closing |");
    println!("|---|---|---|---|---|---|---|---|");
    let best = |mut runs: Vec<Times>| {
        runs.sort_by_key(|t| t.complete);
        runs.swap_remove(0)
    };
    let pyramids = tempfile::tempdir().unwrap();
    let cold = (0..3).map(|_| {
        let tiles = pyramids.path().join("tiles-1");
        if tiles.exists() {
            std::fs::remove_dir_all(tiles).unwrap();
        }
        open(&project, Some(pyramids.path().to_owned()))
    });
    tell("first", &best(cold.collect()));
    let warm = (0..3).map(|_| open(&project, Some(pyramids.path().to_owned())));
    tell("again", &best(warm.collect()));
    tell(
        "nothing kept",
        &best((0..3).map(|_| open(&project, None)).collect()),
    );
}
