//! What a scene does not need costs nothing: the same graph, the same tiles, the same memory.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "leaving_out/scenes.rs"]
mod scenes;

use std::fs;
use std::path::Path;
use std::time::Duration;

use relievo_engine::graph::ContentId;
use relievo_engine::planet::{Camera, TileKey};
use relievo_engine::project::{Layer, Project};
use relievo_engine::{ClipKind, Engine, EngineOptions, NodeReport, View};
use scenes::{KINDS, plain};

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

fn picture(folder: &Path, project: Project) -> (Engine, Made) {
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
        layout: relievo_engine::Layout::STANDARD,
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
fn layers_that_nobody_sees_leave_tiles_and_memory_as_they_are_and_most_the_graph_too() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(scenes::FAR), scenes::FAR_FEATURE).unwrap();
    let (engine, without) = picture(folder.path(), plain());
    assert!(without.tiles.len() > 4 && engine.left_out().is_empty());
    for kind in KINDS {
        for count in [1, 10, 50] {
            let mut project = plain();
            (kind.add)(&mut project, count);
            let (with, made) = picture(folder.path(), project);
            assert_eq!(made, without, "{count} {}", kind.name);
            let unseen = with.unseen();
            if let Some(reason) = kind.unseen {
                assert_eq!(unseen.len(), count, "{unseen:?}");
                assert!(unseen.iter().all(|(_, why)| *why == reason), "{unseen:?}");
                assert!(with.left_out().is_empty());
            } else {
                assert_eq!(graph(&with), graph(&engine), "{count} {}", kind.name);
                assert_eq!(with.left_out().len(), count);
                assert!(unseen.is_empty());
            }
        }
    }
}

#[test]
fn a_clipmap_that_nothing_needs_has_no_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let kinds = |layers: Vec<Layer>| {
        let project = Project { layers, ..plain() };
        let (_, made) = picture(folder.path(), project);
        ClipKind::ALL.map(|kind| made.tiles.iter().any(|(k, ..)| *k == kind))
    };
    let [height, colour, normal] = [0, 1, 2].map(|i| ClipKind::ALL[i]);
    assert_eq!(
        [height, colour, normal],
        [ClipKind::Height, ClipKind::Colour, ClipKind::Normal]
    );
    assert_eq!(kinds(vec![]), [true, false, false]);
    let layers = plain().layers;
    assert_eq!(kinds(layers.clone()), [true, true, true]);
    assert_eq!(kinds(layers[..1].to_vec()), [true, false, true]);
    assert_eq!(kinds(layers[1..].to_vec()), [true, true, false]);
}
