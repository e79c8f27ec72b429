//! A slider of one visible imagery layer: from the change to the moment at which every tile that the
//! picture selects is made and handed over, as a window sees it, without drawing.
//!
//! `cargo bench -p relievo-engine --bench slider [-- PROJECT] [--stack N] [--place NAME] [--slider NAME]
//! [--changes N] [--threads N]`; the topmost visible imagery layer of the project (`projects/earth.relievo`) is changed 60 times
//! in four places, with `--stack` under N - 1 copies of itself, each adjusted and seen through. Times of the
//! processor, of workers and of the thread that asks, do not count other load on the machine.

#![expect(clippy::print_stdout, reason = "a bench says what it found")]
#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has failed")]

#[path = "support/processor.rs"]
mod processor;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use processor::{own_ns, worker_ns};
use relievo_engine::planet::Camera;
use relievo_engine::project::{Adjust, ColourDetail, DetailBy, Edit, LayerId, LayerKind};
use relievo_engine::{Engine, EngineOptions, View};

/// What is drawn from where: name, longitude, latitude, altitude, heading, pitch.
const PLACES: [(&str, [f64; 5]); 4] = [
    ("space", [0.0, 20.0, 1.2e7, 0.0, -90.0]),
    ("aircraft", [-111.60, 40.15, 4200.0, 335.0, -12.0]),
    ("ground", [-111.74, 40.35, 1460.0, 62.0, 5.0]),
    ("low above it", [-111.6416, 40.187, 1750.0, 0.0, -50.0]),
];

/// Drains until the picture of the newest revision is whole.
fn settle(engine: &mut Engine) {
    loop {
        let frame = engine.drain(f32::INFINITY).unwrap();
        if frame.is_converged() && frame.plan.settled && frame.uploads.is_empty() {
            return;
        }
        engine.wait(Duration::from_millis(100));
    }
}

/// Drains as a window does until nothing that is visible is missing; milliseconds.
fn shown_ms(engine: &mut Engine, start: Instant, revision: u64) -> f64 {
    loop {
        let frame = engine.drain(0.0).unwrap();
        if frame.revision > revision && frame.pending == 0 {
            return start.elapsed().as_secs_f64() * 1e3;
        }
        engine.wait(Duration::from_millis(1));
    }
}

fn imagery(engine: &Engine) -> LayerId {
    let layers = &engine.project().layers;
    let layer = layers
        .iter()
        .rev()
        .find(|l| l.visible && matches!(l.kind, LayerKind::Imagery(_)));
    layer.unwrap().id.clone()
}

fn with(threads: Option<usize>) -> EngineOptions {
    EngineOptions {
        threads,
        ..EngineOptions::default()
    }
}

/// Lays copies over the topmost imagery layer until there are `count` of it, each with an adjustment of
/// its own; the lowest one is the dearest to change.
fn stack(engine: &mut Engine, count: usize) {
    let id = imagery(engine);
    let lowest = engine.project().layer(&id).unwrap().clone();
    let at = engine.project().layer_index(&id).unwrap();
    for k in 1..count {
        let mut layer = lowest.clone();
        layer.id = LayerId(format!("{}-{k}", id.0));
        layer.opacity = 0.7;
        if let LayerKind::Imagery(imagery) = &mut layer.kind {
            let by = 0.05 * k as f64;
            imagery.adjust = Adjust {
                brightness: 0.5 * by,
                contrast: 1.0 + by,
                hue_deg: 40.0 * by,
                saturation: 1.0 - by,
                gamma: 1.0 + by,
                ..Adjust::default()
            };
        }
        let layer = Box::new(layer);
        let index = Some(at + k);
        engine.apply(Edit::AddLayer { index, layer }).unwrap();
    }
    engine.wait_for_sources();
}

/// The edit of step `i`: every step another value.
type Step = fn(LayerId, usize) -> Edit;

fn gamma(id: LayerId, i: usize) -> Edit {
    let adjust = Adjust {
        gamma: 1.05 + 0.001 * (i % 1000) as f64,
        ..Adjust::default()
    };
    Edit::SetAdjust { id, adjust }
}

fn opacity(id: LayerId, i: usize) -> Edit {
    let opacity = 0.2 + 0.0007 * (i % 1000) as f64;
    Edit::SetOpacity { id, opacity }
}

fn edge_fade(id: LayerId, i: usize) -> Edit {
    let edge_fade_m = 100.0 + 2.0 * i as f64;
    Edit::SetEdgeFade { id, edge_fade_m }
}

fn seam_blend(id: LayerId, i: usize) -> Edit {
    let seam_blend_m = 200.0 + i as f64;
    Edit::SetSeamBlend { id, seam_blend_m }
}

/// Noise finer than the file.
fn amount(id: LayerId, i: usize) -> Edit {
    let mut detail = ColourDetail::new(DetailBy::Noise);
    detail.strength = 0.5 + 0.001 * (i % 1000) as f64;
    Edit::SetColourDetail {
        id,
        detail: vec![detail],
    }
}

const SLIDERS: [(&str, Step); 5] = [
    ("gamma", gamma),
    ("opacity", opacity),
    ("edge fade", edge_fade),
    ("seam blend", seam_blend),
    ("amount of noise", amount),
];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (mut named, mut layers, mut changes) = (None, 1, 60);
    let mut threads = None;
    let (mut only_place, mut only_slider) = (None, None);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--stack" => layers = arguments.next().and_then(|n| n.parse().ok()).unwrap(),
            "--changes" => changes = arguments.next().and_then(|n| n.parse().ok()).unwrap(),
            "--threads" => {
                threads = arguments.next().and_then(|n| n.parse().ok());
            }
            "--place" => only_place = arguments.next(),
            "--slider" => only_slider = arguments.next(),
            flag if flag.starts_with("--") => {}
            file => named = Some(file.to_owned()),
        }
    }
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects");
    let project = named.map_or_else(|| projects.join("earth.relievo"), PathBuf::from);
    println!("processor: milliseconds a change, all workers together, and the asking thread");
    println!();
    println!("| view | slider | tiles made | median ms | p95 ms | workers | asking |");
    println!("|---|---|---|---|---|---|---|");
    for (place, [lon, lat, altitude_m, heading, pitch]) in PLACES {
        if only_place.as_ref().is_some_and(|only| only != place) {
            continue;
        }
        for (name, step) in SLIDERS {
            if only_slider.as_ref().is_some_and(|only| only != name) {
                continue;
            }
            let (mut engine, _) = Engine::open(&project, with(threads)).unwrap();
            engine.wait_for_sources();
            engine.set_view(View {
                camera: Camera::from_degrees(lon, lat, altitude_m, heading, pitch, 60.0).unwrap(),
                viewport_px: [1280, 960],
                layout: relievo_engine::Layout::STANDARD,
                colour_window: 1024,
                colour_texel_px: 1.0,
                height_texel_px: 2.0,
                max_taps: 4,
            });
            let id = imagery(&engine);
            stack(&mut engine, layers);
            settle(&mut engine);
            // The first change of a drag pins what lies below; those that follow are what is felt.
            engine.begin_drag();
            engine.apply(step(id.clone(), 0)).unwrap();
            settle(&mut engine);
            let made = engine.stats().tiles.made;
            let (workers, own) = (worker_ns(), own_ns());
            let mut times: Vec<f64> = (1..=changes)
                .map(|i| {
                    let revision = engine.drain(0.0).unwrap().revision;
                    let start = Instant::now();
                    engine.apply(step(id.clone(), i)).unwrap();
                    shown_ms(&mut engine, start, revision)
                })
                .collect();
            let a_change = |ns: u64| ns as f64 / 1e6 / changes as f64;
            let (workers, own) = (a_change(worker_ns() - workers), a_change(own_ns() - own));
            times.sort_by(f64::total_cmp);
            let made = (engine.stats().tiles.made - made) as f64 / changes as f64;
            println!(
                "| {place} | {name} | {made:.0} | {:.0} | {:.0} | {workers:.1} | {own:.1} |",
                times[changes / 2],
                times[changes * 95 / 100]
            );
        }
    }
}
