//! What an edit among many elements makes again, counted.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::collections::BTreeSet;
use std::path::Path;

use common::{LAT, LON, converge, is_beside, is_within, platform};
use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Change, ChangeKind, Edit, Element, ElementId, Layer, LayerId, LayerKind, Noise, NoiseLayer,
    Project, Scenario, ScenarioId,
};
use relievo_engine::tiles::LogEntry;
use relievo_engine::{Engine, EngineOptions, View};

/// Where the element lies that is edited, in metres east and north of the middle.
const AT_M: (f64, f64) = (20.0, -30.0);

/// From its middle over a corner to the end of its reach.
const REACH_M: f64 = 15.0 * 1.5 + 60.0;

fn edited(half_m: f64, height_m: f64) -> Element {
    let mut element = Element::clone(&platform("edited", AT_M, half_m, height_m));
    element.side.max_reach_m = 60.0;
    element.style.fill = Some([180, 120, 60]);
    element
}

/// Hills with 400 coloured platforms and the one that is edited, seen from above, whole.
fn engine() -> Engine {
    let noise = Noise {
        amplitude_m: 20.0,
        wavelength_m: 3000.0,
        octaves: 3,
        ..Noise::default()
    };
    let kind = LayerKind::Noise(NoiseLayer { noise });
    let others = (0..400).map(|i| {
        let at_m = (
            f64::from(i % 20) * 60.0 - 600.0,
            f64::from(i / 20) * 60.0 - 600.0,
        );
        let mut element = Element::clone(&platform(&format!("p{i}"), at_m, 8.0, 5.0));
        element.side.max_reach_m = 30.0;
        element.style.fill = Some([180, 120, 60]);
        element.into()
    });
    let project = Project {
        layers: vec![Layer::new(LayerId::from("hills"), "hills", kind)],
        elements: others.chain([edited(12.0, 9.0).into()]).collect(),
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options).unwrap();
    let camera = Camera::from_degrees(LON, LAT, 900.0, 0.0, -90.0, 60.0).unwrap();
    engine.set_view(View {
        camera,
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    converge(&mut engine);
    engine
}

#[test]
fn a_drag_among_many_makes_no_more_tiles_than_lie_within_reach() {
    let mut engine = engine();
    let reached = |e: &&LogEntry| {
        let test = if e.kind == "normals" {
            is_beside
        } else {
            is_within
        };
        test(e.key, AT_M, REACH_M)
    };
    let all = engine.take_log();
    let within = all.iter().filter(reached).count();
    assert!(within * 2 < all.len(), "{within} of {}", all.len());
    engine.begin_drag();
    for step in 1..=3 {
        let element = edited(12.0 + 0.5 * f64::from(step), 9.0).into();
        let scenario = None;
        engine
            .apply(Edit::ReplaceElement { scenario, element })
            .unwrap();
        converge(&mut engine);
        let made = engine.take_log();
        let kinds: BTreeSet<&str> = made.iter().map(|e| e.kind).collect();
        assert!(
            kinds.contains("earthwork") && kinds.contains("overlay"),
            "its colour too: {kinds:?}"
        );
        let beyond: Vec<_> = made.iter().filter(|e| !reached(e)).collect();
        assert!(beyond.is_empty(), "{beyond:?}");
        assert!(made.len() <= within, "{} of {within}", made.len());
    }
    engine.end_drag();
    engine.undo().unwrap();
    converge(&mut engine);
    assert!(engine.take_log().is_empty(), "all is known from before");
}

#[test]
fn a_scenario_that_was_shown_before_makes_no_tile() {
    let mut engine = engine();
    let mut scenario = Scenario::new(ScenarioId::from("other"), "other", None);
    for (element, at_m) in [("p130", (0.0, -240.0)), ("p250", (0.0, 120.0))] {
        let replace = ChangeKind::Replace {
            element: platform(element, at_m, 10.0, 14.0),
            index: None,
        };
        scenario.changes.push(Change::from(replace));
    }
    scenario.changes.push(Change::from(ChangeKind::Remove {
        id: ElementId::from("p190"),
    }));
    let scenario = Box::new(scenario);
    let add = Edit::AddScenario {
        index: None,
        scenario,
    };
    engine.apply(add).unwrap();
    converge(&mut engine);
    engine.take_log();
    let show = |engine: &mut Engine, id: Option<&str>| {
        let id = id.map(ScenarioId::from);
        engine.apply(Edit::ShowScenario { id }).unwrap();
        converge(engine);
        engine.take_log().len()
    };
    assert!(show(&mut engine, Some("other")) > 0);
    assert_eq!(show(&mut engine, None), 0);
    assert_eq!(show(&mut engine, Some("other")), 0);
}
