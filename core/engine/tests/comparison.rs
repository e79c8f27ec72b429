//! Two versions of a project against each other, on level ground at height 0.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use relievo_engine::analysis::{ComparisonReport, MapBox, Task, Version, VolumeSettings};
use relievo_engine::project::{
    Adjust, Blend, Change, ChangeKind, Corridor, Element, ElementId, ElementKind, Layer, LayerId,
    LayerKind, LayerOverride, Polygon, ProfileKind, Project, Scenario, ScenarioId, SectionKind,
    SurfaceKind, Tint, TintInterpolation, TintLayer, TintStop, Vertex,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions};

/// Degrees of longitude and latitude of a metre around (10, 45), WGS 84.
const METRE_DEG: (f64, f64) = (1.0 / 78_846.8, 1.0 / 111_131.8);

fn vertex(x_m: f64, y_m: f64) -> Vertex {
    Vertex::new(10.0 + x_m * METRE_DEG.0, 45.0 + y_m * METRE_DEG.1)
}

/// A box 2 m deep with walls, 100 m wide.
fn pit() -> Element {
    let corners = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)];
    let outline: Vec<Vertex> = corners.map(|(x, y)| vertex(x, y)).to_vec();
    let polygon = Polygon::new(outline, SurfaceKind::Platform { height_m: -2.0 });
    let kind = ElementKind::Polygon(polygon);
    let mut pit = Element::new(ElementId::from("pit"), "Pit", kind);
    pit.side.wall = true;
    pit
}

fn replace(element: Element) -> Change {
    ChangeKind::Replace {
        element: Arc::new(element),
        index: None,
    }
    .into()
}

/// What a scenario with these changes comes to against the base.
fn compared(
    elements: Vec<Element>,
    changes: Vec<Change>,
    bounds: Option<[f64; 4]>,
) -> ComparisonReport {
    let mut project = Project {
        elements: elements.into_iter().map(Arc::new).collect(),
        ..Project::default()
    };
    let tint = LayerKind::Tint(TintLayer {
        tint: Tint {
            stops: vec![TintStop::new(0.0, [90, 120, 60])],
            interpolation: TintInterpolation::Smooth,
        },
        blend: Blend::default(),
        adjust: Adjust::default(),
    });
    project
        .layers
        .push(Layer::new(LayerId::from("tint"), "Tint", tint));
    let mut scenario = Scenario::new(ScenarioId::from("s"), "Plan", None);
    scenario.changes = changes;
    scenario.layers.push(LayerOverride {
        id: LayerId::from("tint"),
        visible: None,
        opacity: Some(0.5),
        extra: serde_json::Map::new(),
    });
    project.scenarios.push(scenario);
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let engine = Engine::new(project, &std::env::temp_dir(), options).unwrap();
    let bounds = bounds.map(|b| MapBox::from_degrees(b).unwrap());
    let plan = Version::called(engine.project(), "Plan").unwrap();
    let comparison = engine
        .comparison(&Version::Base, &plan, bounds.as_ref())
        .unwrap();
    let settings = VolumeSettings {
        max_samples: 1 << 18,
        tolerance: 1e-2,
        ..VolumeSettings::from_spacing(1e9)
    };
    let cancel = Cancel::default();
    comparison
        .measure(&settings, &Task::quiet(&cancel))
        .unwrap()
}

#[test]
fn what_is_hidden_or_only_looks_different_is_said_and_moves_no_ground() {
    let mut hidden = pit();
    hidden.visible = false;
    let report = compared(vec![pit()], vec![replace(hidden.clone())], None);
    let note = |report: &ComparisonReport, text: &str| {
        assert!(report.notes.iter().any(|n| n == text), "{:?}", report.notes);
    };
    note(&report, "Only hidden in Plan, not removed: Pit.");
    note(
        &report,
        "Layers that only look different, which moves no ground: Tint.",
    );
    assert!(report.total.fill_m3.value > 19_000.0, "{:?}", report.total);

    let report = compared(vec![hidden.clone()], vec![replace(pit())], None);
    note(&report, "Only hidden in base, not new in Plan: Pit.");
    assert!(report.total.cut_m3.value > 19_000.0, "{:?}", report.total);

    let mut painted = pit();
    painted.style.fill = Some([200, 0, 0]);
    let report = compared(vec![pit()], vec![replace(painted)], None);
    note(
        &report,
        "Only name or looks differ, which moves no ground: Pit.",
    );
    note(&report, "Nothing differs.");
    assert_eq!((report.total.samples, report.elements.len()), (0, 0));

    let mut deeper = hidden.clone();
    deeper.name = "Deeper pit".to_owned();
    let report = compared(vec![hidden], vec![replace(deeper)], None);
    note(&report, "Hidden in both, though they differ: Deeper pit.");
}

#[test]
fn within_bounds_rows_and_total_count_what_lies_inside_and_nothing_else() {
    let add = |element: Element| -> Change {
        ChangeKind::Add {
            element: Arc::new(element),
            index: None,
        }
        .into()
    };
    // The eastern half and 10 m of its southern part cut off.
    let (west, south) = (vertex(0.0, 0.0).lon_deg, vertex(0.0, -40.0).lat_deg);
    let bounds = [west, south, west + 0.01, south + 0.01];
    let report = compared(Vec::new(), vec![add(pit())], Some(bounds));
    for found in [&report.total, &report.elements[0].volumes] {
        let exact = 2.0 * 50.0 * 90.0;
        let off = (found.cut_m3.value - exact).abs();
        assert!(off <= found.cut_m3.error + 1e-4 * exact, "{found:?}");
        assert!(found.cut_m3.error < 0.02 * exact, "{found:?}");
    }
    let beside = [west + 0.01, south, west + 0.02, south + 0.01];
    let report = compared(Vec::new(), vec![add(pit())], Some(beside));
    assert_eq!(report.elements.len(), 1);
    assert_eq!(report.elements[0].volumes.cut_m3.value, 0.0);
    assert_eq!(report.total.samples, 0);
}

#[test]
fn a_trench_a_metre_wide_is_found_in_the_wide_reach_of_a_pit() {
    // Wide and coarse around, narrow here: a grid of the pit's own spacing would pass over it.
    let line = vec![vertex(60.3, -41.0), vertex(83.1, 55.0)];
    let section = SectionKind::Trench {
        bottom_width_m: 1.0,
        depth_m: 3.0,
    };
    let profile = ProfileKind::Follow {
        offset_m: 0.0,
        smooth_m: 0.0,
    };
    let corridor = ElementKind::Corridor(Corridor::new(line, profile, section));
    let mut trench = Element::new(ElementId::from("trench"), "Trench", corridor);
    trench.side.wall = true;
    let added = |element: Element| -> Change {
        ChangeKind::Add {
            element: Arc::new(element),
            index: None,
        }
        .into()
    };
    let length_m = f64::hypot(83.1 - 60.3, 55.0 + 41.0);
    let report = compared(Vec::new(), vec![added(pit()), added(trench)], None);
    let cut = report.elements[1].volumes.cut_m3;
    let exact = 3.0 * length_m;
    assert!(
        (cut.value - exact).abs() <= cut.error + 1e-3 * exact,
        "{cut:?}, exactly {exact}"
    );
    assert!(cut.error < 0.1 * exact, "{cut:?}");
    let total = report.total.cut_m3;
    let exact = exact + 2.0 * 100.0 * 100.0;
    assert!(
        (total.value - exact).abs() <= total.error + 1e-3 * exact,
        "{total:?}, exactly {exact}"
    );
}
