//! Layers brought to one look: what is foretold of an adjustment is what the picture then has.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "common/pictures.rs"]
mod pictures;

use std::path::{Path, PathBuf};

use pictures::{Square, write_picture};
use relievo_engine::analysis::Task;
use relievo_engine::analysis::colour::{Difference, Lab, MatchMethod, ciede2000};
use relievo_engine::project::{
    Adjust, Edit, ImageryLayer, Layer, LayerId, LayerKind, Project, Resampling, Source,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Bake, Engine, EngineOptions, MatchTarget, Output};

const METHODS: [MatchMethod; 3] = [
    MatchMethod::MeanAndSpread,
    MatchMethod::Histogram,
    MatchMethod::Regression,
];

/// Fewer pixels than places are compared.
const SQUARE: Square = Square {
    corner: [10.0, 45.0],
    side: 100,
    pixel_deg: 0.001,
};

/// Ground of many colours, by pixel.
fn ground(x: u32, y: u32) -> [f64; 3] {
    let (u, v) = (f64::from(x) / 99.0, f64::from(y) / 99.0);
    let grain = f64::from((x * 7 + y * 13) % 17) / 17.0;
    [
        0.05 + 0.8 * u,
        0.1 + 0.6 * v + 0.1 * grain,
        0.15 + 0.4 * (1.0 - u) * v + 0.2 * grain,
    ]
}

/// The same ground by a camera that bends, mixes and burns out; clouds over a seventh of it.
fn elsewhere(x: u32, y: u32) -> [f64; 3] {
    if (20..58).contains(&x) && (30..68).contains(&y) {
        return [0.93, 0.94, 0.97];
    }
    let [r, g, b] = ground(x, y);
    [
        1.25 * r.powf(1.7) + 0.05 * g,
        0.9 * g.powf(0.6) + 0.05,
        0.7 * b.powf(1.4) + 0.15 * r,
    ]
}

/// A layer whose pixels are not mixed with each other.
fn layer(id: &str, path: &Path) -> Layer {
    let mut imagery = ImageryLayer::new(Source::new(path.to_str().unwrap()));
    imagery.source.resampling = Resampling::Nearest;
    Layer::new(LayerId::from(id), id, LayerKind::Imagery(imagery))
}

fn engine(layers: Vec<Layer>) -> Engine {
    let project = Project {
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine
}

/// The two pictures as files.
fn both(folder: &Path) -> [PathBuf; 2] {
    let files = ["below.tif", "above.tif"].map(|name| folder.join(name));
    write_picture(&files[0], SQUARE, elsewhere);
    write_picture(&files[1], SQUARE, ground);
    files
}

/// How far the layer `id` is from the layer `below`, and at how many places that was measured.
fn measured(engine: &Engine, id: &str) -> (Difference, usize) {
    let (cancel, below) = (Cancel::default(), LayerId::from("below"));
    let target = MatchTarget::Layer(below);
    let questions = engine.questions();
    questions
        .colour_difference(&LayerId::from(id), &target, None, &Task::quiet(&cancel))
        .unwrap()
}

/// Each method, all of it and a part, with its adjustment made: the method, the share, what was foretold and
/// the engine that shows it.
fn each_match(files: &[PathBuf; 2], mut see: impl FnMut(&str, Difference, usize, Engine)) {
    let cancel = Cancel::default();
    for method in METHODS {
        for strength in [1.0, 0.6] {
            let name = format!("{method:?} × {strength}");
            let mut engine = engine(vec![layer("below", &files[0]), layer("above", &files[1])]);
            let (above, how) = (LayerId::from("above"), (method, strength));
            let questions = engine.questions();
            let found = questions
                .match_colours(
                    &above,
                    &MatchTarget::Below,
                    None,
                    how,
                    &Task::quiet(&cancel),
                )
                .unwrap();
            let (before, places) = measured(&engine, "above");
            assert_eq!(found.fit.before, before, "{name}");
            assert_eq!(found.fit.pairs, places, "{name}");
            assert_ne!(found.adjust, Adjust::default());
            let adjust = found.adjust;
            engine.apply(Edit::SetAdjust { id: above, adjust }).unwrap();
            see(&name, found.fit.after, places, engine);
        }
    }
}

/// Nothing is rounded on the way from the file to what is compared, and the node itself foretells: the same
/// bits.
#[test]
fn what_a_match_foretells_is_what_is_measured_once_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let files = both(folder.path());
    each_match(&files, |name, foretold, places, engine| {
        // The pictures do not come to agree, or there would be nothing to foretell.
        assert!(foretold.mean > 1.0, "{name}: {foretold:?}");
        let (after, places_after) = measured(&engine, "above");
        assert_eq!(places, places_after, "{name}");
        assert_eq!(
            (foretold.mean, foretold.p95),
            (after.mean, after.p95),
            "{name}"
        );
    });
}

/// Rounding to 8 bits moves a channel by half a step at most, and each place's difference by no more than
/// the two colours then differ. That differs from place to place and mostly cancels; the bound does not
/// count on it.
#[test]
fn what_a_match_foretells_is_what_the_baked_picture_has_but_for_its_8_bits() {
    let folder = tempfile::tempdir().unwrap();
    let files = both(folder.path());
    let [west, south] = SQUARE.corner;
    let side_deg = SQUARE.pixel_deg * f64::from(SQUARE.side);
    let bake = Bake {
        output: Output::Colour,
        bounds: [west, south, west + side_deg, south + side_deg],
        resolution: SQUARE.pixel_deg,
        crs: "EPSG:4326".to_owned(),
    };
    let bound = half_a_step();
    assert!((0.1..0.5).contains(&bound), "{bound}");
    each_match(&files, |name, foretold, places, shown| {
        let baked = folder.path().join("baked.tif");
        let cancel = Cancel::default();
        let questions = shown.questions();
        questions
            .bake(&bake, &baked, 1, &mut |_| {}, &cancel)
            .unwrap();
        let both = engine(vec![layer("below", &files[0]), layer("baked", &baked)]);
        let (after, places_after) = measured(&both, "baked");
        assert_eq!(places, places_after, "{name}");
        let off = (after.mean - foretold.mean).abs();
        assert!(off < bound, "{name}: {off} of {bound}");
    });
}

/// The mean colour difference that half a step of 8 bits in all three channels makes, over all colours, the
/// worst of its eight directions.
fn half_a_step() -> f64 {
    let half = 0.5 / 255.0_f32;
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 0..12_u32.pow(3) {
        let colour = [i % 12, i / 12 % 12, i / 144].map(|k| (k as f32 + 0.5) / 12.0);
        let here = Lab::from_srgb(colour);
        let directions = (0..8).map(|bits: u32| {
            let by = |c: usize| if bits >> c & 1 == 1 { half } else { -half };
            let there = core::array::from_fn(|c| colour[c] + by(c));
            ciede2000(here, Lab::from_srgb(there))
        });
        sum += directions.fold(0.0, f64::max);
        count += 1.0;
    }
    sum / count
}
