//! *Show synthesised detail* over imagery: teal where colours are made up, and nowhere else.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "common/pictures.rs"]
mod pictures;
#[path = "common/screen.rs"]
mod screen;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::I64Vec2;
use pictures::{Square, write_picture};
use relievo_engine::planet::{Camera, Planet, TileKey};
use relievo_engine::project::{
    ColourDetail, DetailBy, ImageryLayer, Layer, LayerId, LayerKind, Project, Source, VectorLayer,
};
use relievo_engine::{ClipKind, Engine, EngineOptions, Layout, View};
use screen::{Part, picture};

/// Pixels of 22.2 m by 15.7 m on the ground.
const COARSE: Square = Square {
    corner: [10.0, 45.0],
    side: 100,
    pixel_deg: 0.0002,
};

/// Metres from sample to sample of the map from which on the picture is fine enough, and up to which it is
/// not.
const FINE_ENOUGH_M: f64 = 22.3;
const TOO_COARSE_M: f64 = 7.8;

/// Its middle in degrees.
const MIDDLE: [f64; 2] = [10.01, 45.01];

/// Red-brown ground with a grain: detail, which follows it, leaves red above blue.
fn ground(x: u32, y: u32) -> [f64; 3] {
    let grain = f64::from((x * 29 + y * 17 + (x * y) % 13) % 23) / 23.0 - 0.5;
    [0.7 + 0.1 * grain, 0.45 + 0.08 * grain, 0.2 + 0.05 * grain]
}

/// What lies over that ground cannot be missed: 0.4 of teal (0, 0.6, 0.6).
fn is_teal([red, _, blue, _]: [u8; 4]) -> bool {
    // 0.7 and 0.2 become 0.42 and 0.36.
    i32::from(red) - i32::from(blue) < 64
}

fn write(folder: &Path, name: &str, square: Square) -> PathBuf {
    let path = folder.join(name);
    write_picture(&path, square, ground);
    path
}

fn imagery(id: &str, path: &Path, detail: Vec<ColourDetail>) -> Layer {
    let mut imagery = ImageryLayer::new(Source::new(path.to_str().unwrap()));
    imagery.detail = detail;
    Layer::new(LayerId::from(id), id, LayerKind::Imagery(imagery))
}

fn noise() -> ColourDetail {
    ColourDetail::new(DetailBy::Noise)
}

/// The layers from 600 m above the middle of the picture, down to its made-up texels.
fn seen(layers: Vec<Layer>) -> Engine {
    let project = Project {
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    let [lon_deg, lat_deg] = MIDDLE;
    engine.set_view(View {
        camera: Camera::from_degrees(lon_deg, lat_deg, 600.0, 0.0, -90.0, 60.0).unwrap(),
        viewport_px: [240, 180],
        layout: Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    engine
}

/// How many texels there are and how many of them are teal, of the samples that lie so far east and north of
/// the middle in degrees that `counts` says yes, by metres from sample to sample; pixels at the rim of the
/// picture are left out.
fn teal(
    tiles: &BTreeMap<(ClipKind, TileKey), Part>,
    counts: impl Fn([f64; 2]) -> bool,
) -> Vec<(f64, [usize; 2])> {
    let half_deg = COARSE.pixel_deg * (f64::from(COARSE.side) / 2.0 - 2.0);
    let mut levels = BTreeMap::new();
    for ((kind, key), part) in tiles {
        if *kind != ClipKind::Colour {
            continue;
        }
        let lattice = key.level.lattice();
        let [all, teal] = levels.entry(key.level).or_insert([0; 2]);
        for (i, texel) in part.texels.iter().enumerate() {
            let (width, i) = (part.rect.width(), i as i64);
            let sample = part.rect.min + I64Vec2::new(i % width, i / width);
            let place = lattice.centre(sample);
            let off_deg = [
                place.x.to_degrees() - MIDDLE[0],
                90.0 - place.y.to_degrees() - MIDDLE[1],
            ];
            if off_deg.iter().all(|deg| deg.abs() < half_deg) && counts(off_deg) {
                *all += 1;
                *teal += usize::from(is_teal(*texel));
            }
        }
    }
    let spacing_m = |rows_rad: f64| rows_rad * Planet::EARTH.radius_m;
    let levels = levels.into_iter().filter(|(_, [all, _])| *all > 0);
    let mut levels: Vec<_> = levels
        .map(|(level, counts)| (spacing_m(level.step_rad().y), counts))
        .collect();
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    levels
}

/// All texels of levels that are finer than the picture are teal and none of the others.
fn only_finer_ones_are_teal(levels: &[(f64, [usize; 2])]) {
    let (mut finer, mut coarser) = (0, 0);
    for (spacing_m, [all, teal]) in levels {
        if *spacing_m <= TOO_COARSE_M {
            assert_eq!(teal, all, "{spacing_m} m: {levels:?}");
            finer += all;
        } else if *spacing_m >= FINE_ENOUGH_M {
            assert_eq!(*teal, 0, "{spacing_m} m: {levels:?}");
            coarser += all;
        }
    }
    assert!(finer > 10_000 && coarser > 500, "{levels:?}");
}

/// No texel of any level is teal.
fn none_is_teal(levels: &[(f64, [usize; 2])]) {
    assert!(levels.iter().map(|(_, [all, _])| all).sum::<usize>() > 5000);
    assert!(levels.iter().all(|(_, [_, teal])| *teal == 0), "{levels:?}");
}

#[test]
fn made_up_colours_are_teal_where_they_are_finer_than_the_picture_and_only_while_they_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "coarse.tif", COARSE);
    let mut engine = seen(vec![imagery("coarse", &file, vec![noise()])]);
    let before = picture(&mut engine);
    none_is_teal(&teal(&before, |_| true));
    engine.show_synthesised(true);
    only_finer_ones_are_teal(&teal(&picture(&mut engine), |_| true));
    engine.show_synthesised(false);
    assert!(picture(&mut engine) == before, "as it was");
    // Without detail there is nothing to show.
    let mut plain = seen(vec![imagery("coarse", &file, vec![])]);
    plain.show_synthesised(true);
    none_is_teal(&teal(&picture(&mut plain), |_| true));
}

#[test]
fn made_up_colours_are_teal_in_their_areas_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "coarse.tif", COARSE);
    let [e, middle] = MIDDLE;
    let (w, s, n) = (e - 0.1, middle - 0.1, middle + 0.1);
    let areas = format!(
        r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon",
        "coordinates":[[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]]}}}}"#
    );
    let path = folder.path().join("west.geojson");
    std::fs::write(&path, areas).unwrap();
    let vector = VectorLayer::new(path.to_str().unwrap());
    let mut west = Layer::new(
        LayerId::from("west"),
        "west",
        LayerKind::Vector(Box::new(vector)),
    );
    west.visible = false;
    let detail = ColourDetail {
        areas: Some(west.id.clone()),
        ..noise()
    };
    let mut engine = seen(vec![imagery("coarse", &file, vec![detail]), west]);
    engine.show_synthesised(true);
    let shown = picture(&mut engine);
    // A texel beside the edge of the areas is half in them.
    let beside_deg = 2.0 * COARSE.pixel_deg;
    only_finer_ones_are_teal(&teal(&shown, |[east, _]| east < -beside_deg));
    none_is_teal(&teal(&shown, |[east, _]| east > beside_deg));
}

#[test]
fn where_imagery_without_detail_covers_made_up_colours_nothing_is_teal() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "coarse.tif", COARSE);
    // The eastern half and beyond, no finer than what it covers.
    let over = Square {
        corner: [MIDDLE[0], COARSE.corner[1]],
        ..COARSE
    };
    let over = imagery("over", &write(folder.path(), "over.tif", over), vec![]);
    let below = imagery("coarse", &file, vec![noise()]);
    let mut engine = seen(vec![below.clone(), over.clone()]);
    engine.show_synthesised(true);
    let shown = picture(&mut engine);
    let beside_deg = 2.0 * COARSE.pixel_deg;
    only_finer_ones_are_teal(&teal(&shown, |[east, _]| east < -beside_deg));
    none_is_teal(&teal(&shown, |[east, _]| east > beside_deg));
    // Below the made-up ones it covers nothing.
    let mut engine = seen(vec![over, below]);
    engine.show_synthesised(true);
    only_finer_ones_are_teal(&teal(&picture(&mut engine), |_| true));
}
