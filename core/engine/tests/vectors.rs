//! Vector layers: drawn over the colours, read again when their file changes, named when it is gone.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::time::Duration;

use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::{
    Edit, Extrude, Label, Layer, LayerId, LayerKind, Project, VectorLayer, VectorStyle, Width,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, Severity, SourceState, View};

/// Boxes of a degree, each with a name and how many live there.
fn boxes(places: &[(f64, f64, &str, u32)]) -> String {
    let features: Vec<String> = places
        .iter()
        .map(|(lon, lat, name, people)| {
            let (e, n) = (lon + 1.0, lat + 1.0);
            format!(
                r#"{{"type":"Feature","properties":{{"name":"{name}","pop":{people}}},"geometry":{{"type":"Polygon",
                "coordinates":[[[{lon},{lat}],[{e},{lat}],[{e},{n}],[{lon},{n}],[{lon},{lat}]]]}}}}"#
            )
        })
        .collect();
    format!(
        r#"{{"type":"FeatureCollection","features":[{}]}}"#,
        features.join(",")
    )
}

fn project() -> Project {
    let mut layer = VectorLayer::new("zones.geojson");
    layer.style = VectorStyle {
        fill: Some([0, 128, 255]),
        stroke: Some([255, 0, 0]),
        stroke_width: Width::m(2000.0),
        label: Some(Label {
            property: "name".into(),
            size_px: 14.0,
            colour: [0; 3],
            halo: Some([255; 3]),
            extra: relievo_engine::project::Extra::new(),
        }),
        ..VectorStyle::default()
    };
    let kind = LayerKind::Vector(Box::new(layer));
    let mut project = Project::default();
    project
        .layers
        .push(Layer::new(LayerId::from("zones"), "Zones", kind));
    project
}

fn engine(folder: &Path) -> Engine {
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        watch: Some(Duration::MAX),
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project(), folder, options).unwrap();
    engine.set_view(view(8.5));
    engine.wait_for_sources();
    engine
}

fn view(lon_deg: f64) -> View {
    let camera = Camera {
        lon_rad: lon_deg.to_radians(),
        lat_rad: 47.5_f64.to_radians(),
        altitude_m: 400_000.0,
        heading_rad: 0.0,
        pitch_rad: -core::f64::consts::FRAC_PI_2,
        fov_y_rad: 1.0,
    };
    View {
        camera,
        viewport_px: [400, 300],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 2.0,
        height_texel_px: 4.0,
        max_taps: 1,
    }
}

fn colour(engine: &Engine, lon_deg: f64, lat_deg: f64) -> Option<[u8; 4]> {
    let place = MapPoint::from_degrees(lon_deg, lat_deg);
    let answer = engine.questions().place(place, &Cancel::default());
    answer.unwrap().colour
}

/// Drains until nothing is left to do.
fn converge(engine: &mut Engine) {
    for _ in 0..5000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        if frame.is_converged() && frame.uploads.is_empty() {
            return;
        }
        engine.wait(Duration::from_millis(20));
    }
    panic!("does not converge: {:?}", engine.stats());
}

#[test]
fn features_are_drawn_and_nothing_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zones.geojson");
    fs::write(&file, boxes(&[(8.0, 47.0, "A", 5)])).unwrap();
    let engine = engine(folder.path());
    assert_eq!(colour(&engine, 8.5, 47.5), Some([0, 128, 255, 255]));
    assert_eq!(colour(&engine, 8.0, 47.5), Some([255, 0, 0, 255]));
    assert_eq!(colour(&engine, 7.5, 47.5), Some([0; 4]));
}

#[test]
fn a_file_that_changes_is_read_again_and_only_tiles_that_it_changes_are_made() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zones.geojson");
    let both = [(8.0, 47.0, "A", 5), (9.2, 47.0, "B", 3)];
    fs::write(&file, boxes(&both)).unwrap();
    let mut engine = engine(folder.path());
    converge(&mut engine);
    assert!(!engine.take_log().is_empty());
    // Another property, but the same shapes: nothing on the picture changes.
    fs::write(&file, boxes(&[(8.0, 47.0, "Aa", 5), (9.2, 47.0, "B", 3)])).unwrap();
    for _ in 0..2 {
        engine.look_at_files();
        engine.wait_for_sources();
    }
    converge(&mut engine);
    assert_eq!(engine.take_log(), [], "the same shapes");
    let labels = engine.labels(&view(8.5));
    assert!(labels.iter().any(|l| l.text == "Aa"), "{labels:?}");
    fs::write(&file, boxes(&[(8.0, 47.0, "A", 5)])).unwrap();
    for _ in 0..2 {
        engine.look_at_files();
        engine.wait_for_sources();
    }
    assert_eq!(colour(&engine, 9.7, 47.5), Some([0; 4]));
    assert_eq!(colour(&engine, 8.5, 47.5), Some([0, 128, 255, 255]));
}

#[test]
fn a_missing_file_is_named_and_the_rest_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let mut engine = engine(folder.path());
    converge(&mut engine);
    let layer = &engine.project().layers[0];
    let state = engine.sources().state(&layer.kind, engine.folder());
    assert!(matches!(state, Some(SourceState::Failed(_))));
    let told = engine.messages().iter().any(|m| {
        m.severity == Severity::Error && m.text.contains("zones.geojson") && m.layer.is_some()
    });
    assert!(told, "{:?}", engine.messages());
    assert_eq!(engine.left_out().len(), 1);
}

#[test]
fn labels_keep_apart_and_the_important_win() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zones.geojson");
    let crowd: Vec<(f64, f64, String, u32)> = (0..200)
        .map(|i| {
            let (x, y) = (f64::from(i % 20), f64::from(i / 20));
            (6.0 + 0.25 * x, 46.0 + 0.25 * y, format!("place {i}"), i + 1)
        })
        .collect();
    let crowd: Vec<(f64, f64, &str, u32)> = crowd
        .iter()
        .map(|(x, y, name, people)| (*x, *y, name.as_str(), *people))
        .collect();
    fs::write(&file, boxes(&crowd)).unwrap();
    let mut engine = engine(folder.path());
    converge(&mut engine);
    let labels = engine.labels(&view(8.5));
    assert_eq!(
        labels,
        engine.labels(&view(8.5)),
        "the same view, the same texts"
    );
    assert!(labels.len() > 3 && labels.len() < 200, "{}", labels.len());
    for (i, a) in labels.iter().enumerate() {
        for b in &labels[..i] {
            let apart = (a.centre_px - b.centre_px).abs();
            assert!(apart.y > 14.0 || apart.x > 14.0 * 3.0, "{a:?} {b:?}");
        }
    }
    // Far away nothing is seen of them.
    assert_eq!(engine.labels(&view(-100.0)), []);
    let hide = Edit::SetVisible {
        id: LayerId::from("zones"),
        visible: false,
    };
    engine.apply(hide).unwrap();
    assert_eq!(engine.labels(&view(8.5)), []);
}

#[test]
fn a_text_stands_on_the_roof_of_its_body() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zones.geojson");
    fs::write(&file, boxes(&[(9.0, 47.0, "A", 5)])).unwrap();
    let mut engine = engine(folder.path());
    converge(&mut engine);
    let place = |engine: &Engine| engine.labels(&view(8.5))[0].centre_px.x - 200.0;
    let flat = place(&engine);
    let LayerKind::Vector(vector) = &engine.project().layers[0].kind else {
        panic!("expected features");
    };
    let mut style = vector.style.clone();
    style.extrude = Some(Extrude::HeightM(100_000.0));
    let edit = Edit::SetVectorStyle {
        id: LayerId::from("zones"),
        style: Box::new(style),
    };
    engine.apply(edit).unwrap();
    converge(&mut engine);
    // A quarter of the way to the eye is a third farther from the middle of the picture.
    let share = place(&engine) / flat;
    assert!((share - 4.0 / 3.0).abs() < 0.03, "{share}");
}
