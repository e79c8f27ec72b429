//! Where layers show: masks by height, slope, place and areas, and lenses that move.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use common::{LAT, LON, METRES, converge, is_beside, is_within, platform};
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::{
    Adjust, Blend, Edit, Element, Extra, Layer, LayerId, LayerKind, Lens, LensShape, Mask,
    MaskRange, Noise, NoiseLayer, Project, Tint, TintInterpolation, TintLayer, TintStop,
    VectorLayer,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, View};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREY: [u8; 4] = [90, 90, 90, 255];

fn one_colour(id: &str, colour: [u8; 3]) -> Layer {
    let tint = Tint {
        stops: vec![TintStop::new(0.0, colour)],
        interpolation: TintInterpolation::Smooth,
    };
    let tint = TintLayer {
        tint,
        blend: Blend::Normal,
        adjust: Adjust::default(),
    };
    Layer::new(LayerId::from(id), id, LayerKind::Tint(tint))
}

/// Grey with red over it where the mask says so; a platform of 40 m with sides of one in two.
fn engine(mask: Option<Mask>, others: Vec<Layer>, folder: &Path) -> Engine {
    let mut red = one_colour("red", [255, 0, 0]);
    red.mask = mask;
    let mut layers = vec![one_colour("grey", [90; 3]), red];
    layers.extend(others);
    let element: Arc<Element> = platform("pad", (0.0, 0.0), 50.0, 40.0);
    let project = Project {
        layers,
        elements: vec![element],
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, folder, options).unwrap();
    engine.wait_for_sources();
    engine
}

fn range(from: f64, to: f64, fade: f64) -> MaskRange {
    MaskRange {
        from,
        to,
        fade,
        extra: Extra::new(),
    }
}

fn lens(east_m: f64, shape: LensShape) -> Mask {
    let lens = Lens {
        lon_deg: LON + east_m / METRES.0,
        lat_deg: LAT,
        fade_m: 0.0,
        shape,
        extra: Extra::new(),
    };
    Mask {
        lens: Some(lens),
        ..Mask::default()
    }
}

fn circle(radius_m: f64) -> LensShape {
    LensShape::Circle { radius_m }
}

/// A triangle that reaches as far in all directions as a circle of 100 m at most.
fn triangle() -> LensShape {
    LensShape::Polygon {
        corners_m: vec![[-90.0, -40.0], [90.0, -40.0], [0.0, 95.0]],
    }
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

fn colour(engine: &Engine, east_m: f64, north_m: f64) -> [u8; 4] {
    let place = MapPoint::from_degrees(LON + east_m / METRES.0, LAT + north_m / METRES.1);
    let answer = engine.questions().place(place, &Cancel::default()).unwrap();
    answer.colour.unwrap()
}

#[test]
fn a_layer_shows_in_its_range_of_heights_and_fades_beyond() {
    let mask = Mask {
        heights: Some(range(30.0, 100.0, 20.0)),
        ..Mask::default()
    };
    let engine = engine(Some(mask), vec![], Path::new("."));
    assert_eq!(colour(&engine, 0.0, 0.0), RED);
    // From the edge at 50 m the ground falls by half a metre a metre.
    assert_eq!(colour(&engine, 60.0, 0.0), RED, "at 35 m");
    assert_eq!(colour(&engine, 115.0, 0.0), GREY, "at 7.5 m");
    assert_eq!(colour(&engine, 300.0, 0.0), GREY);
    let [r, g, _, alpha] = colour(&engine, 90.0, 0.0);
    assert!(r > 100 && g > 30 && alpha == 255, "at 20 m: half {r} {g}");
}

#[test]
fn a_layer_shows_on_steep_ground_and_inverted_on_level_ground() {
    let steep = |invert| Mask {
        slopes: Some(range(20.0, 90.0, 0.0)),
        invert,
        ..Mask::default()
    };
    let on_sides = engine(Some(steep(false)), vec![], Path::new("."));
    let beside = engine(Some(steep(true)), vec![], Path::new("."));
    for (east_m, is_steep) in [(0.0, false), (90.0, true), (300.0, false)] {
        let (inside, outside) = if is_steep { (RED, GREY) } else { (GREY, RED) };
        assert_eq!(colour(&on_sides, east_m, 0.0), inside, "{east_m}");
        assert_eq!(colour(&beside, east_m, 0.0), outside, "{east_m}");
    }
}

#[test]
fn all_that_a_mask_says_holds_at_once() {
    let mask = Mask {
        heights: Some(range(30.0, 100.0, 0.0)),
        ..lens(0.0, circle(20.0))
    };
    let engine = engine(Some(mask), vec![], Path::new("."));
    assert_eq!(colour(&engine, 10.0, 0.0), RED);
    assert_eq!(colour(&engine, 40.0, 0.0), GREY, "high, but outside");
    assert_eq!(colour(&engine, 300.0, 0.0), GREY);
}

#[test]
fn a_layer_shows_inside_the_areas_of_a_hidden_vector_layer() {
    let folder = tempfile::tempdir().unwrap();
    let (west, east) = (LON - 100.0 / METRES.0, LON);
    let (south, north) = (LAT - 100.0 / METRES.1, LAT + 100.0 / METRES.1);
    let ring = format!(
        "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
    );
    let text = format!(
        r#"{{"type": "Feature", "properties": {{}}, "geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}"#
    );
    std::fs::write(folder.path().join("areas.geojson"), text).unwrap();
    let mut areas = Layer::new(
        LayerId::from("areas"),
        "areas",
        LayerKind::Vector(Box::new(VectorLayer::new("areas.geojson"))),
    );
    areas.visible = false;
    let by = |id: &str| Mask {
        vector: Some(LayerId::from(id)),
        ..Mask::default()
    };
    let inside = engine(Some(by("areas")), vec![areas.clone()], folder.path());
    assert_eq!(colour(&inside, -50.0, 0.0), RED);
    assert_eq!(colour(&inside, 50.0, 0.0), GREY);
    // A layer that is none, or not of features, is told and does not count.
    let other = engine(Some(by("grey")), vec![areas], folder.path());
    assert_eq!(colour(&other, 50.0, 0.0), RED);
    let told: Vec<String> = other.messages().iter().map(|m| m.text.clone()).collect();
    let told = told.join("; ");
    assert!(
        told.contains("vector layer \"grey\"") && told.contains("kind tint"),
        "{told}"
    );
}

#[test]
fn a_mask_that_says_nothing_makes_the_same_tiles_as_none() {
    let made = |mask| {
        let mut engine = engine(mask, vec![], Path::new("."));
        engine.set_view(view());
        converge(&mut engine);
        let log = engine.take_log();
        let names: BTreeSet<_> = log
            .iter()
            .map(|e| format!("{} {:?}", e.key, e.id))
            .collect();
        names
    };
    assert_eq!(made(None), made(Some(Mask::default())));
    let nowhere = Mask {
        invert: true,
        ..Mask::default()
    };
    let mut hidden = engine(Some(nowhere), vec![], Path::new("."));
    hidden.set_view(view());
    converge(&mut hidden);
    assert_eq!(colour(&hidden, 0.0, 0.0), GREY);
    assert_eq!(hidden.left_out().len(), 1);
}

#[test]
fn a_layer_shows_in_a_polygon_and_inverted_outside_it() {
    let outside = Mask {
        invert: true,
        ..lens(20.0, triangle())
    };
    let inside = engine(Some(lens(20.0, triangle())), vec![], Path::new("."));
    let outside = engine(Some(outside), vec![], Path::new("."));
    for (place, is_inside) in [
        ((20.0, 0.0), true),
        ((20.0, 80.0), true),
        ((95.0, -35.0), true),
        ((95.0, 20.0), false),
        ((20.0, -50.0), false),
        ((-200.0, 0.0), false),
    ] {
        let (here, there) = if is_inside { (RED, GREY) } else { (GREY, RED) };
        assert_eq!(colour(&inside, place.0, place.1), here, "{place:?}");
        assert_eq!(colour(&outside, place.0, place.1), there, "{place:?}");
    }
}

#[test]
fn a_circle_that_moves_makes_only_the_tiles_again_that_it_leaves_or_enters() {
    moves_alone(&circle(100.0));
}

#[test]
fn a_polygon_that_moves_makes_only_the_tiles_again_that_it_leaves_or_enters() {
    moves_alone(&triangle());
}

fn moves_alone(shape: &LensShape) {
    let lens = |east_m: f64| lens(east_m, shape.clone());
    // Hills in colours over all of it, so that no tile is one colour and left out.
    let noise = Noise {
        amplitude_m: 500.0,
        wavelength_m: 20_000.0,
        ..Noise::default()
    };
    let hills = LayerKind::Noise(NoiseLayer { noise });
    let mut shade = one_colour("shade", [0; 3]);
    if let LayerKind::Tint(tint) = &mut shade.kind {
        tint.tint.stops.push(TintStop::new(500.0, [255; 3]));
    }
    shade.opacity = 0.5;
    let hills = Layer::new(LayerId::from("hills"), "hills", hills);
    let mut engine = engine(Some(lens(-300.0)), vec![hills, shade], Path::new("."));
    // A look over many tiles, from so high that the lens is small beside one.
    engine.set_view(View {
        camera: Camera::from_degrees(LON, LAT, 2.0e4, 0.0, -60.0, 60.0).unwrap(),
        colour_window: 1024,
        viewport_px: [1280, 960],
        ..view()
    });
    converge(&mut engine);
    let all = engine.take_log();
    engine
        .apply(Edit::SetMask {
            id: LayerId::from("red"),
            mask: Some(Box::new(lens(300.0))),
        })
        .unwrap();
    converge(&mut engine);
    let made = engine.take_log();
    assert!(!made.is_empty());
    let reached = |key| {
        [-300.0, 300.0].into_iter().any(|east_m| {
            is_within(key, (east_m, 0.0), 100.0) || is_beside(key, (east_m, 0.0), 100.0)
        })
    };
    let beyond: Vec<_> = made.iter().filter(|e| !reached(e.key)).collect();
    assert!(beyond.is_empty(), "{beyond:?}");
    let is_again = |key| made.iter().any(|e| e.key == key);
    let overlays = all.iter().filter(|e| e.kind == "overlay");
    assert!(
        overlays.filter(|e| !is_again(e.key)).count() > 5,
        "{} again",
        made.len()
    );
    assert!(
        made.iter().all(|e| e.kind == "overlay"),
        "no height, no normal"
    );
}
