//! Detail beyond the data's own resolution: seen, said to be made up, and never measured.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::analysis::{ProfileSettings, Task, Version, VolumeSettings};
use relievo_engine::graph::roughness::Surface;
use relievo_engine::planet::{Camera, Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_engine::project::{
    Detail, DetailLayer, DetailMethod, HeightLayer, Layer, LayerId, LayerKind, Project, Source,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Bake, Engine, EngineOptions, Layout, Output, Questions, Stage, View};

const WASATCH: &str = "wasatch-dem.tif";
const EARTH: &str = "earth-etopo5.tif";

/// Metres between the samples of the Wasatch Front.
const SPACING_M: f64 = 81.56;

fn file(path: &str) -> Layer {
    let height = HeightLayer::new(Source::new(path));
    Layer::new(LayerId::from(path), path, LayerKind::Height(height))
}

fn detail(method: DetailMethod) -> Layer {
    let detail = Detail {
        method,
        ..Detail::default()
    };
    let kind = LayerKind::Detail(DetailLayer { detail });
    Layer::new(LayerId::from("detail"), "detail", kind)
}

fn engine(layers: Vec<Layer>) -> Engine {
    let project = Project {
        layers,
        ..Project::default()
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let options = EngineOptions {
        threads: Some(1),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, &folder, options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine
}

fn questions(layers: Vec<Layer>) -> Questions {
    engine(layers).questions()
}

fn at(lon_deg: f64, lat_deg: f64) -> MapPoint {
    MapPoint::from_degrees(lon_deg, lat_deg)
}

#[test]
fn a_place_says_that_its_height_is_synthesised_and_what_the_data_say() {
    let cancel = Cancel::default();
    let plain = questions(vec![file(WASATCH)]);
    let shown = questions(vec![file(WASATCH), detail(DetailMethod::Simplex)]);
    let mut differ = 0;
    for (lon, lat) in [(-111.6, 40.3), (-111.62, 40.38), (-111.58, 40.42)] {
        let answer = shown.place(at(lon, lat), &cancel).unwrap();
        let below_m = answer.synthesised_below_m.unwrap();
        assert!(
            (below_m / (2.0 * SPACING_M) - 1.0).abs() < 0.01,
            "{below_m}"
        );
        assert!(answer.height_made_by.iter().any(|m| m.node == "detail"));
        let data_m = answer.data_height_m.unwrap();
        // Read at a spacing of centimetres here and of metres there.
        let plain_m = plain.place(at(lon, lat), &cancel).unwrap().height_m;
        assert!((data_m - plain_m).abs() < 25.0, "{data_m} {plain_m}");
        let added_m = (answer.height_m - data_m).abs();
        assert!(added_m > 0.0 && added_m < 60.0, "{added_m}");
        differ += usize::from(added_m > 0.5);
        let bare = shown.without_detail().place(at(lon, lat), &cancel).unwrap();
        assert_eq!((bare.synthesised_below_m, bare.data_height_m), (None, None));
    }
    assert!(differ > 0);
    let plain = plain.place(at(-111.6, 40.3), &cancel).unwrap();
    assert_eq!(
        (plain.synthesised_below_m, plain.data_height_m),
        (None, None)
    );
}

#[test]
fn measurements_are_those_without_detail_and_say_so() {
    let cancel = Cancel::default();
    let line = [at(-111.65, 40.25), at(-111.6, 40.3)];
    let profile = |questions: &Questions| {
        let (settings, task) = (ProfileSettings::default(), Task::quiet(&cancel));
        questions.profile(&line, &settings, &task).unwrap()
    };
    let plain = questions(vec![file(WASATCH)]);
    let shown = questions(vec![file(WASATCH), detail(DetailMethod::Simplex)]);
    assert_eq!(profile(&plain).points, profile(&shown).points);
    assert_eq!(plain.left_out_of_measures(), None);
    assert!(shown.left_out_of_measures().unwrap().contains("left out"));
}

#[test]
fn detail_continues_what_lies_below_it_and_ends_where_finer_data_begin() {
    let cancel = Cancel::default();
    let inside = at(-111.6, 40.3);
    let outside = at(-106.0, 39.2);
    let below_m = |layers: Vec<Layer>, place: MapPoint| {
        let answer = questions(layers).place(place, &cancel).unwrap();
        answer.synthesised_below_m
    };
    let noise = || detail(DetailMethod::Simplex);
    let over_both = || vec![file(EARTH), file(WASATCH), noise()];
    assert!((below_m(over_both(), inside).unwrap() / (2.0 * SPACING_M) - 1.0).abs() < 0.01);
    assert!(below_m(over_both(), outside).unwrap() > 10_000.0);
    let between = || vec![file(EARTH), noise(), file(WASATCH)];
    assert_eq!(below_m(between(), inside), None);
    assert!(below_m(between(), outside).is_some());
    // Nothing to continue, and nothing to leave out of measures.
    assert_eq!(below_m(vec![noise(), file(WASATCH)], inside), None);
    let alone = questions(vec![noise(), file(WASATCH)]);
    assert_eq!(alone.left_out_of_measures(), None);
}

/// Mean squared second differences of a layer's own samples about Mount Timpanogos, at lags in metres.
fn energies(questions: &Questions, layer: &str, lags_m: &[f64]) -> Vec<f64> {
    const SIDE: i64 = 640;
    let level = LevelKey::new(12, 11);
    let middle = level.sample_from_map(at(-111.55, 40.35));
    let first = middle.floor().as_i64vec2() - SIDE / 2;
    let rect = SampleRect::at(first.x, first.y, SIDE, SIDE);
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    let samples = questions
        .layer_samples(
            &LayerId::from(layer),
            Stage::Source,
            &grid,
            &Cancel::default(),
        )
        .unwrap()
        .unwrap();
    let step_m = level.step_rad() * Planet::EARTH.radius_m;
    let across_m = step_m.x * 0.762;
    let surface = Surface::new(samples.plane(0), SIDE as usize, step_m.y, |_| across_m);
    let side = 0..SIDE as usize;
    let found = lags_m.iter().map(|lag_m| {
        let lag = (lag_m / step_m.y).round() as usize;
        let energy = surface.energy(lag, side.clone(), side.clone());
        energy.mean_m2().unwrap()
    });
    found.collect()
}

#[test]
fn thinned_data_with_detail_are_about_as_rough_as_the_data_were() {
    let folder = tempfile::tempdir().unwrap();
    let thinned = folder.path().join("thinned.tif");
    let original = questions(vec![file(WASATCH)]);
    let bake = Bake {
        output: Output::Height,
        bounds: [395_000.0, 4_410_000.0, 500_000.0, 4_525_000.0],
        resolution: 8.0 * SPACING_M,
        crs: "EPSG:26912".to_owned(),
    };
    let cancel = Cancel::default();
    original
        .bake(&bake, &thinned, 1, &mut |_| {}, &cancel)
        .unwrap();
    let path = thinned.to_str().unwrap();
    let lags_m = [120.0, 240.0, 480.0, 960.0];
    let truth = energies(&original, WASATCH, &lags_m);
    for method in [DetailMethod::Simplex, DetailMethod::Spectral] {
        let finer = questions(vec![file(path), detail(method)]);
        let bare = energies(&finer, path, &lags_m);
        let made = energies(&finer, "detail", &lags_m);
        for (k, lag_m) in lags_m.iter().enumerate() {
            let [bare_db, made_db] = [bare[k], made[k]].map(|m2| 10.0 * (m2 / truth[k]).log10());
            assert!(
                made_db.abs() < 4.0,
                "{method:?} {lag_m} m: {bare_db} {made_db} dB"
            );
            assert!(
                made_db.abs() < bare_db.abs(),
                "{method:?} {lag_m} m: {bare_db} {made_db} dB"
            );
        }
    }
}

#[test]
fn a_comparison_says_that_detail_is_left_out() {
    let cancel = Cancel::default();
    let notes = |layers: Vec<Layer>| {
        let compared = engine(layers).comparison(&Version::Ground, &Version::Base, None);
        let settings = VolumeSettings::from_spacing(50.0);
        let report = compared.unwrap().measure(&settings, &Task::quiet(&cancel));
        report.unwrap().notes.concat()
    };
    let finer = || detail(DetailMethod::Simplex);
    assert!(notes(vec![file(WASATCH), finer()]).contains("Detail beyond"));
    assert!(!notes(vec![file(WASATCH)]).contains("Detail beyond"));
}

/// Drains until the picture is whole and nothing is being made.
fn converge(engine: &mut Engine) {
    for _ in 0..4000 {
        let whole = engine.drain(f32::INFINITY).unwrap().is_converged();
        if engine.wait(Duration::from_millis(50)) && whole {
            return;
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

#[test]
fn a_near_picture_converges_and_showing_what_is_synthesised_makes_no_height_again() {
    let mut engine = engine(vec![file(WASATCH), detail(DetailMethod::Simplex)]);
    engine.set_view(View {
        camera: Camera::from_degrees(-111.6, 40.3, 3500.0, 0.0, -50.0, 60.0).unwrap(),
        viewport_px: [160, 120],
        layout: Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    converge(&mut engine);
    let before = engine.take_log();
    assert!(before.iter().any(|made| made.kind == "detail"));
    assert!(before.iter().all(|made| made.ready));
    engine.show_synthesised(true);
    converge(&mut engine);
    let made = engine.take_log();
    assert!(made.iter().any(|made| made.kind == "overlay"), "{made:?}");
    let again = |kind: &str| {
        made.iter()
            .any(|m| m.kind == kind && before.iter().any(|b| b.id == m.id))
    };
    assert!(!again("detail") && !again("overlay heights"));
    engine.show_synthesised(false);
    converge(&mut engine);
    assert_eq!(engine.take_log().len(), 0);
}
