//! Layers drawn from the shape of the ground: slopes and contour lines follow planning elements.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;
use std::sync::Arc;

use common::{LAT, LON, METRES, converge, is_beside, is_within, platform};
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::{
    ContoursLayer, Edit, Element, Layer, LayerId, LayerKind, Noise, NoiseLayer, Project,
    SlopeLayer, SlopeStop,
};
use relievo_engine::raster::Cancel;
use relievo_engine::tiles::LogEntry;
use relievo_engine::{Engine, EngineOptions, View};

/// Level ground up to 20°, red up to 26.4°, green up to 26.7°, blue beyond.
fn slope() -> Layer {
    let stops = [(0.0, 0), (20.0, 1), (26.4, 2), (26.7, 3)];
    let colours = [[0, 0, 0], [255, 0, 0], [0, 255, 0], [0, 0, 255]];
    let slope = SlopeLayer {
        stops: stops
            .map(|(deg, i)| SlopeStop::new(deg, colours[i]))
            .to_vec(),
        ..SlopeLayer::default()
    };
    Layer::new(LayerId::from("steep"), "steep", LayerKind::Slope(slope))
}

fn contours() -> Layer {
    let contours = ContoursLayer {
        interval_m: Some(10.0),
        index_every: 0,
        colour: [255, 0, 0],
        width_px: 2.0,
        ..ContoursLayer::default()
    };
    Layer::new(
        LayerId::from("lines"),
        "lines",
        LayerKind::Contours(contours),
    )
}

fn hills() -> Layer {
    let noise = Noise {
        amplitude_m: 20.0,
        wavelength_m: 3000.0,
        octaves: 3,
        ..Noise::default()
    };
    Layer::new(
        LayerId::from("hills"),
        "hills",
        LayerKind::Noise(NoiseLayer { noise }),
    )
}

fn engine(layers: Vec<Layer>, element: Option<Arc<Element>>) -> Engine {
    let project = Project {
        layers,
        elements: element.into_iter().collect(),
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    Engine::new(project, Path::new("."), options).unwrap()
}

/// The colour some metres east and north of the middle.
fn colour(engine: &Engine, east_m: f64, north_m: f64) -> [u8; 4] {
    let place = MapPoint::from_degrees(LON + east_m / METRES.0, LAT + north_m / METRES.1);
    let answer = engine.questions().place(place, &Cancel::default()).unwrap();
    answer.colour.unwrap()
}

#[test]
fn a_cone_has_one_slope_all_around() {
    let engine = engine(vec![slope()], Some(platform("pad", (0.0, 0.0), 0.5, 60.0)));
    for i in 0..32 {
        let (sin, cos) = (f64::from(i) * 0.2).sin_cos();
        for distance_m in [10.0, 35.0, 70.0, 110.0] {
            // One in two is 26.57°.
            let found = colour(&engine, distance_m * cos, distance_m * sin);
            assert_eq!(found, [0, 255, 0, 255], "{distance_m} m, {i}");
        }
        assert_eq!(colour(&engine, 150.0 * cos, 150.0 * sin), [0, 0, 0, 255]);
    }
}

#[test]
fn contour_lines_lie_where_heights_cross_levels() {
    let engine = engine(
        vec![contours()],
        Some(platform("pad", (0.0, 0.0), 1.0, 65.0)),
    );
    // East of the platform's edge the ground falls from 65 m by half a metre a metre.
    let at_m = |height_m: f64| 1.0 + (65.0 - height_m) / 0.5;
    for level_m in [60.0, 50.0, 40.0, 30.0, 20.0, 10.0] {
        assert_eq!(colour(&engine, at_m(level_m), 0.0), [255, 0, 0, 255]);
        assert_eq!(colour(&engine, 0.0, -at_m(level_m)), [255, 0, 0, 255]);
        assert_eq!(colour(&engine, at_m(level_m + 2.0), 0.0), [0; 4]);
        assert_eq!(colour(&engine, at_m(level_m - 4.0), 0.0), [0; 4]);
    }
    // Level ground has none, also where it lies at a level.
    assert_eq!(colour(&engine, 180.0, 0.0), [0; 4]);
}

fn view() -> View {
    View {
        camera: Camera::from_degrees(LON, LAT, 1500.0, 0.0, -60.0, 60.0).unwrap(),
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    }
}

#[test]
fn without_heights_there_are_neither_slopes_nor_lines() {
    let mut engine = engine(vec![slope(), contours()], None);
    engine.set_view(view());
    converge(&mut engine);
    let reasons: Vec<&str> = engine.left_out().iter().map(|(_, why)| *why).collect();
    assert_eq!(reasons, ["no heights"; 2]);
}

#[test]
fn a_changed_platform_makes_only_the_tiles_again_that_it_reaches() {
    let layers = vec![hills(), slope(), contours()];
    let mut engine = engine(layers, Some(platform("pad", (0.0, 0.0), 40.0, 10.0)));
    engine.set_view(view());
    converge(&mut engine);
    let all = engine.take_log();
    engine
        .apply(Edit::ReplaceElement {
            scenario: None,
            element: platform("pad", (0.0, 0.0), 40.0, 12.0),
        })
        .unwrap();
    converge(&mut engine);
    let made = engine.take_log();
    let made_by = |kind: &str| made.iter().filter(|e| e.kind == kind).count();
    assert!(made_by("overlay") > 0 && made_by("normals") > 0, "{made:?}");
    // From the middle over a corner to the end of its reach.
    let reached = |e: &&LogEntry| {
        let reads_normals = e.kind == "normals" || e.kind == "overlay";
        let test = if reads_normals { is_beside } else { is_within };
        test(e.key, (0.0, 0.0), 57.0 + 200.0)
    };
    let known = |e: &LogEntry| all.iter().any(|a| (a.kind, a.key) == (e.kind, e.key));
    let again = made.iter().filter(|e| known(e));
    let beyond: Vec<_> = again.filter(|e| !reached(e)).collect();
    assert!(beyond.is_empty(), "{beyond:?}");
    let within = all.iter().filter(reached).count();
    assert!(
        made.len() <= within && within * 2 < all.len(),
        "{} of {within}",
        made.len()
    );
}
