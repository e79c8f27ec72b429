//! Planning among 10,000 elements: a dragged vertex, scenarios switched to and fro, saving, opening, undo.
//!
//! `cargo bench -p relievo-engine --bench planning`. Milliseconds are those of the clock, from an edit to
//! the moment at which every tile that the picture selects is made and handed over, as a window sees it,
//! without drawing; and those of the processor that the asking thread has had, which other load on the
//! machine does not change.

#![expect(clippy::print_stdout, reason = "a bench says what it found")]
#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has failed")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "support/processor.rs"]
mod processor;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use common::{LAT, LON, converge, is_beside, is_within, platform};
use processor::{own_ns, worker_ns};
use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Change, ChangeKind, Edit, Element, ElementId, Layer, LayerId, LayerKind, Noise, NoiseLayer,
    Project, Replace, Scenario, ScenarioId,
};
use relievo_engine::{Engine, EngineOptions, View};

const OTHERS: i32 = 10_000;
const CHANGES: usize = 60;
const UNDONE: usize = 1000;

/// From the middle of the dragged element over a corner to the end of its reach.
const REACH_M: f64 = 40.0 * 1.5 + 100.0;

fn main() {
    println!("{OTHERS} other elements, all with colours");
    println!();
    println!(
        "| what | tiles made | tiles within reach | median ms | p95 ms | workers ms | asking ms |"
    );
    println!("|---|---|---|---|---|---|---|");
    drag();
    switch();
    println!();
    println!("| what | ms |");
    println!("|---|---|");
    files();
    undo();
}

fn coloured(id: &str, at_m: (f64, f64), half_m: f64, height_m: f64, reach_m: f64) -> Arc<Element> {
    let mut element = Element::clone(&platform(id, at_m, half_m, height_m));
    element.side.max_reach_m = reach_m;
    element.style.fill = Some([180, 120, 60]);
    element.style.stroke = Some([40, 30, 20]);
    Arc::new(element)
}

fn dragged(step: usize) -> Arc<Element> {
    let mut element = Element::clone(&coloured("dragged", (0.0, 0.0), 40.0, 9.0, 100.0));
    if let relievo_engine::project::ElementKind::Polygon(polygon) = &mut element.kind {
        let mut vertices = polygon.outline.as_slice().to_vec();
        vertices[2].lon_deg += 2e-6 * step as f64;
        polygon.outline = vertices.into();
    }
    Arc::new(element)
}

fn project() -> Project {
    let noise = Noise {
        amplitude_m: 20.0,
        wavelength_m: 3000.0,
        octaves: 3,
        ..Noise::default()
    };
    let kind = LayerKind::Noise(NoiseLayer { noise });
    let others = (0..OTHERS).map(|i| {
        let at_m = (f64::from(i % 100) - 50.0, f64::from(i / 100) - 50.0);
        let at_m = (at_m.0 * 70.0, at_m.1 * 70.0);
        coloured(&format!("p{i}"), at_m, 12.0, 5.0, 20.0)
    });
    Project {
        layers: vec![Layer::new(LayerId::from("hills"), "hills", kind)],
        elements: others.chain([dragged(0)]).collect(),
        ..Project::default()
    }
}

fn engine() -> Engine {
    let options = EngineOptions {
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project(), Path::new("."), options).unwrap();
    engine.set_view(View {
        camera: Camera::from_degrees(LON, LAT, 1200.0, 30.0, -50.0, 60.0).unwrap(),
        viewport_px: [1280, 960],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 1024,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    converge(&mut engine);
    engine
}

/// Applies edits one after the other, each until nothing that is visible is missing, and tells.
fn tell(engine: &mut Engine, what: &str, within: &str, edits: impl Iterator<Item = Edit>) {
    engine.take_log();
    let (mut times, mut made) = (Vec::new(), 0);
    let (workers, own) = (worker_ns(), own_ns());
    for edit in edits {
        let revision = engine.drain(0.0).unwrap().revision;
        let start = Instant::now();
        engine.apply(edit).unwrap();
        loop {
            let frame = engine.drain(0.0).unwrap();
            if frame.revision > revision && frame.pending == 0 {
                break;
            }
            engine.wait(Duration::from_millis(1));
        }
        times.push(start.elapsed().as_secs_f64() * 1e3);
        made += engine.take_log().len();
    }
    times.sort_by(f64::total_cmp);
    let a_change = |ns: u64| ns as f64 / 1e6 / times.len() as f64;
    println!(
        "| {what} | {:.1} | {within} | {:.1} | {:.1} | {:.1} | {:.1} |",
        made as f64 / times.len() as f64,
        times[times.len() / 2],
        times[times.len() * 95 / 100],
        a_change(worker_ns() - workers),
        a_change(own_ns() - own),
    );
}

fn drag() {
    let mut engine = engine();
    let all = engine.take_log();
    let within = all.iter().filter(|e| {
        let test = if e.kind == "normals" {
            is_beside
        } else {
            is_within
        };
        test(e.key, (0.0, 0.0), REACH_M)
    });
    let within = format!("{} of {}", within.count(), all.len());
    engine.begin_drag();
    let edits = (1..=CHANGES).map(|step| Edit::ReplaceElement {
        scenario: None,
        element: dragged(step),
    });
    tell(&mut engine, "a vertex dragged", &within, edits);
    engine.end_drag();
}

fn switch() {
    let mut engine = engine();
    let mut scenario = Scenario::new(ScenarioId::from("other"), "other", None);
    for i in (0..OTHERS).step_by(200) {
        let id = format!("p{i}");
        let at_m = (f64::from(i % 100) - 50.0, f64::from(i / 100) - 50.0);
        let replace = ChangeKind::Replace {
            element: coloured(&id, (at_m.0 * 70.0, at_m.1 * 70.0), 12.0, 9.0, 20.0),
            index: None,
        };
        scenario.changes.push(Change::from(replace));
    }
    let remove = ChangeKind::Remove {
        id: ElementId::from("dragged"),
    };
    scenario.changes.push(Change::from(remove));
    let scenario = Box::new(scenario);
    let add = Edit::AddScenario {
        index: None,
        scenario,
    };
    engine.apply(add).unwrap();
    converge(&mut engine);
    let show = |shown: bool| Edit::ShowScenario {
        id: shown.then(|| ScenarioId::from("other")),
    };
    tell(
        &mut engine,
        "a scenario shown first",
        "",
        [show(true)].into_iter(),
    );
    converge(&mut engine);
    let edits = (0..CHANGES).map(|i| show(i % 2 == 1));
    tell(&mut engine, "scenarios shown again", "", edits);
}

fn files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.relievo");
    let mut engine = Engine::new(project(), folder.path(), EngineOptions::default()).unwrap();
    let start = Instant::now();
    engine.save(&path, Replace::Always).unwrap();
    println!("| saving | {:.1} |", ms(start));
    let bytes = std::fs::metadata(&path).unwrap().len();
    let start = Instant::now();
    let (opened, _) = relievo_engine::project::open(&path).unwrap();
    println!(
        "| opening ({:.1} MB) | {:.1} |",
        bytes as f64 / 1e6,
        ms(start)
    );
    assert_eq!(opened.elements.len(), project().elements.len());
}

fn undo() {
    let mut engine = Engine::new(project(), Path::new("."), EngineOptions::default()).unwrap();
    for step in 1..=UNDONE {
        let element = dragged(step);
        let scenario = None;
        engine
            .apply(Edit::ReplaceElement { scenario, element })
            .unwrap();
    }
    let start = Instant::now();
    let mut steps = 0;
    while engine.undo().unwrap() {
        steps += 1;
    }
    println!("| undo of {steps} steps | {:.1} |", ms(start));
}

fn ms(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
