//! Sets of tiles as heights, and what is baked from them.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use relievo_engine::planet::MapPoint;
use relievo_engine::project::{
    HeightEncoding, HeightLayer, Layer, LayerId, LayerKind, Project, Source,
};
use relievo_engine::raster::write::{Png, write_png};
use relievo_engine::raster::{Bands, Block, Cancel};
use relievo_engine::{Bake, Engine, EngineOptions, Output, SourceState};

/// One tile of 64 × 64 that covers the world: 7.5 m in Terrarium.
fn tiles(folder: &Path) {
    let tile = folder.join("tiles/0/0");
    std::fs::create_dir_all(&tile).unwrap();
    let colour = [128.0, 7.0, 128.0, 255.0].map(|v| v / 255.0);
    let block = Block::filled(Bands::Colour, 64, 64, &colour);
    write_png(&tile.join("0.png"), &block, Png::Rgb8).unwrap();
}

fn engine(folder: &Path, source: Source) -> Engine {
    let mut project = Project::default();
    let kind = LayerKind::Height(HeightLayer::new(source));
    project
        .layers
        .push(Layer::new(LayerId::from("ground"), "Ground", kind));
    let options = EngineOptions {
        threads: Some(2),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, folder, options).unwrap();
    engine.wait_for_sources();
    engine
}

fn height_m(engine: &Engine) -> f64 {
    let place = MapPoint::new(0.2, 1.2);
    let answer = engine.questions().place(place, &Cancel::default());
    answer.unwrap().height_m
}

#[test]
fn encoded_tiles_are_heights_and_bake_as_openexr_that_is_a_source_again() {
    let folder = tempfile::tempdir().unwrap();
    tiles(folder.path());
    let source = Source {
        encoding: Some(HeightEncoding::Terrarium),
        ..Source::new("tiles")
    };
    let engine_of_tiles = engine(folder.path(), source);
    assert_eq!(height_m(&engine_of_tiles), 7.5);
    let bake = Bake {
        output: Output::Height,
        bounds: [0.0, 0.0, 30.0, 40.0],
        resolution: 0.05,
        crs: "EPSG:4326".to_owned(),
    };
    let baked = |name: &str, threads: usize| {
        let path = folder.path().join(name);
        let mut last = 0.0;
        let mut progress = |part: f64| {
            assert!(part >= last, "progress never falls");
            last = part;
        };
        engine_of_tiles
            .questions()
            .bake(&bake, &path, threads, &mut progress, &Cancel::default())
            .unwrap();
        std::fs::read(path).unwrap()
    };
    assert_eq!(baked("one.exr", 1), baked("three.exr", 3));
    let again = engine(folder.path(), Source::new("one.exr"));
    assert_eq!(height_m(&again), 7.5);
}

#[test]
fn tiles_without_a_word_about_their_encoding_are_no_heights() {
    let folder = tempfile::tempdir().unwrap();
    tiles(folder.path());
    let engine = engine(folder.path(), Source::new("tiles"));
    let kind = &engine.project().layers[0].kind;
    match engine.sources().state(kind, engine.folder()) {
        Some(SourceState::Failed(reason)) => {
            assert!(reason.contains("terrain-rgb or terrarium"), "{reason}");
        }
        _ => panic!("expected a refusal"),
    }
}
