//! What a scene does not need costs nothing: the same graph, the same tiles, the same memory.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::time::Duration;

use relievo_engine::graph::ContentId;
use relievo_engine::planet::{Camera, TileKey};
use relievo_engine::project::{
    Adjust, Blend, ContoursLayer, Layer, LayerId, LayerKind, Noise, NoiseLayer, NoiseMode, Project,
    SlopeLayer, Tint, TintInterpolation, TintLayer, TintStop, VectorLayer, VectorStyle,
};
use relievo_engine::{ClipKind, Engine, EngineOptions, NodeReport, View};

fn layer(id: &str, kind: LayerKind) -> Layer {
    Layer::new(LayerId::from(id), id, kind)
}

fn noise(amplitude_m: f64, mode: NoiseMode) -> LayerKind {
    let noise = Noise {
        amplitude_m,
        mode,
        octaves: 2,
        wavelength_m: 3000.0,
        ..Noise::default()
    };
    LayerKind::Noise(NoiseLayer { noise })
}

fn tint() -> LayerKind {
    let stops = vec![
        TintStop::new(-300.0, [20, 60, 20]),
        TintStop::new(300.0, [200, 200, 180]),
    ];
    let tint = Tint {
        stops,
        interpolation: TintInterpolation::Smooth,
    };
    LayerKind::Tint(TintLayer {
        tint,
        blend: Blend::Normal,
        adjust: Adjust::default(),
    })
}

/// Hills in the colours of their heights.
fn plain() -> Vec<Layer> {
    vec![
        layer("hills", noise(200.0, NoiseMode::Add)),
        layer("tint", tint()),
    ]
}

/// A layer that changes nothing, in one way after the other.
fn inert(k: usize) -> Layer {
    let id = format!("inert-{k}");
    let mut slope = SlopeLayer::default();
    let mut contours = ContoursLayer::default();
    match k % 6 {
        0 => {
            let mut hidden = layer(&id, tint());
            hidden.visible = false;
            hidden
        }
        1 => {
            let mut faint = layer(&id, LayerKind::Contours(contours));
            faint.opacity = 0.0;
            faint
        }
        2 => layer(&id, noise(0.0, NoiseMode::Add)),
        3 => {
            slope.stops.iter_mut().for_each(|s| s.opacity = 0.0);
            layer(&id, LayerKind::Slope(slope))
        }
        4 => {
            (contours.width_px, contours.index_width_px) = (0.0, 0.0);
            layer(&id, LayerKind::Contours(contours))
        }
        _ => {
            let mut hidden = layer(&id, noise(50.0, NoiseMode::Replace));
            hidden.visible = false;
            hidden
        }
    }
}

/// A layer whose features lie on the other side of the planet.
fn far_away(k: usize) -> Layer {
    let mut vector = VectorLayer::new("far.geojson");
    vector.style = VectorStyle {
        fill: Some([0, 128, 255]),
        ..VectorStyle::default()
    };
    layer(&format!("far-{k}"), LayerKind::Vector(Box::new(vector)))
}

/// A layer that the tint above it covers.
fn covered(k: usize) -> Layer {
    let kind = match k % 3 {
        0 => LayerKind::Slope(SlopeLayer::default()),
        1 => LayerKind::Contours(ContoursLayer::default()),
        _ => tint(),
    };
    layer(&format!("covered-{k}"), kind)
}

/// Drains until the picture is whole and nothing is being made; gives the number of uploads.
fn converge(engine: &mut Engine) -> usize {
    let mut uploads = 0;
    for _ in 0..4000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        uploads += frame.uploads.len();
        if engine.wait(Duration::from_millis(50)) && frame.is_converged() {
            return uploads;
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

/// Everything that a picture of the layers is made from.
#[derive(Debug, PartialEq)]
struct Made {
    tiles: Vec<(ClipKind, TileKey, ContentId)>,
    tasks: u64,
    cache_bytes: usize,
    resident: usize,
    uploads: usize,
}

fn picture(folder: &Path, layers: Vec<Layer>) -> (Engine, Made) {
    let project = Project {
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        cache_folder: None,
        watch: Some(Duration::MAX),
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, folder, options).unwrap();
    engine.wait_for_sources();
    engine.set_view(View {
        camera: Camera::from_degrees(10.0, 45.0, 4000.0, 0.0, -60.0, 60.0).unwrap(),
        viewport_px: [160, 120],
        // Two rows of tiles at the coarsest level: the other side of the planet has one of its own.
        colour_window: 512,
        colour_texel_px: 2.0,
        height_texel_px: 4.0,
        max_taps: 1,
    });
    let uploads = converge(&mut engine);
    let stats = engine.stats();
    let made = Made {
        tiles: engine.visible_tiles(),
        tasks: stats.tiles.made,
        cache_bytes: stats.tiles.cache_bytes,
        resident: stats.kept.resident,
        uploads,
    };
    (engine, made)
}

/// The compiled graph without the names of layers.
fn graph(engine: &Engine) -> Vec<NodeReport> {
    let mut nodes = engine.nodes();
    for node in &mut nodes {
        node.layer = None;
    }
    nodes
}

#[test]
fn layers_without_effect_leave_graph_tiles_and_memory_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let (engine, without) = picture(folder.path(), plain());
    assert!(without.tiles.len() > 4 && engine.left_out().is_empty());
    for count in [1, 10, 50] {
        let mut layers = plain();
        for k in 0..count {
            layers.insert(k * layers.len() / count.max(1), inert(k));
        }
        let (with, made) = picture(folder.path(), layers);
        assert_eq!(graph(&with), graph(&engine), "{count}");
        assert_eq!(made, without, "{count}");
        assert_eq!(with.left_out().len(), count);
        assert!(with.unseen().is_empty());
    }
}

#[test]
fn layers_off_the_screen_or_covered_leave_tiles_and_memory_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let feature = r#"{"type":"Feature","properties":{},"geometry":{"type":"Polygon",
        "coordinates":[[[-150,-40],[-149,-40],[-149,-39],[-150,-40]]]}}"#;
    fs::write(folder.path().join("far.geojson"), feature).unwrap();
    let (_, without) = picture(folder.path(), plain());
    for count in [1, 10, 50] {
        for (make, above, reason) in [
            (far_away as fn(usize) -> Layer, true, "off the screen"),
            (covered, false, "covered"),
        ] {
            let mut layers = plain();
            let at = if above { 2 } else { 1 };
            layers.splice(at..at, (0..count).map(make));
            let (engine, made) = picture(folder.path(), layers);
            assert_eq!(made, without, "{count} {reason}");
            let unseen = engine.unseen();
            assert_eq!(unseen.len(), count, "{unseen:?}");
            assert!(unseen.iter().all(|(_, why)| *why == reason), "{unseen:?}");
            assert!(engine.left_out().is_empty());
        }
    }
}

#[test]
fn a_clipmap_that_nothing_needs_has_no_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let kinds = |layers| {
        let (_, made) = picture(folder.path(), layers);
        ClipKind::ALL.map(|kind| made.tiles.iter().any(|(k, ..)| *k == kind))
    };
    let [height, colour, normal] = [0, 1, 2].map(|i| ClipKind::ALL[i]);
    assert_eq!(
        [height, colour, normal],
        [ClipKind::Height, ClipKind::Colour, ClipKind::Normal]
    );
    assert_eq!(kinds(vec![]), [true, false, false]);
    assert_eq!(kinds(plain()), [true, true, true]);
    assert_eq!(kinds(plain()[..1].to_vec()), [true, false, true]);
    assert_eq!(kinds(plain()[1..].to_vec()), [true, true, false]);
}
