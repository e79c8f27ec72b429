//! Heights: exaggerated, in cliffs, absent, from a single sample.

use std::sync::Arc;

use glam::{DVec3, I64Vec2};
use relievo_engine::graph::nodes::{Constant, Memory, Normals, OverlayHeights};
use relievo_engine::graph::{GraphBuilder, NodeIndex};
use relievo_engine::planet::{Grid, LevelKey, Planet, SampleRect, TileKey};
use relievo_engine::raster::{Bands, Block, Cancel, SampleType, normal};

use super::places::{Lifted, Shot};
use super::{Case, Extent, Found, worse, worst};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "exaggeration 0 to the greatest, an eye 1 m above the ground: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.05,
        degrades: "not at all; beyond R + e h = 0.1 R an edit is refused, naming the limit",
        measure: exaggeration,
    },
    Case {
        name: "height steps of ±10⁵ m, an eye 1 m above the upper edge: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.05,
        degrades: "stored heights have a quantum of 8 mm there, which does not tremble",
        measure: cliffs_on_screen,
    },
    Case {
        name: "height steps of ±10⁵ m over samples of 0.6 m to 78 km: normals",
        truth: "differences in f64",
        unit: "degrees",
        limit: 0.05,
        degrades: "half floats of stored stereographic coordinates: hardly more on a cliff than on level ground",
        measure: cliff_normals,
    },
    Case {
        name: "sources without any sample and with one: heights over a ground",
        truth: "the ground, and the sample's own height",
        unit: "m",
        limit: 0.0,
        degrades: "not at all: where there is no sample the ground is the same to the bit",
        measure: sparse_sources,
    },
];

/// Worst error on the screen with the reference, and with absolute heights.
fn lifted(shots: &[Shot], rise_m: impl Fn(f64, f64) -> f64, extent: Extent) -> Found {
    let samples = extent.pick(200, 4000);
    let all = |displace: fn(Lifted) -> glam::Vec3| {
        let errors = shots
            .iter()
            .filter_map(|s| s.screen_error_px(samples, &rise_m, displace));
        errors.reduce(worse).unwrap_or(f64::NAN)
    };
    Found {
        worst: all(Lifted::relative),
        plain: Some(all(Lifted::absolute)),
    }
}

fn exaggeration(extent: Extent) -> Found {
    let (lowest_m, highest_m) = (-10_000.0, 8_848.0);
    let greatest = Planet::EARTH.greatest_exaggeration(lowest_m);
    let factors = [0.0, 0.1, 1.0, 10.0, 100.0, greatest];
    let shots: Vec<Shot> = factors
        .into_iter()
        .flat_map(|e| [lowest_m, 0.0, highest_m].map(|h| e * h))
        .map(|drawn_m| {
            // The shader's reference is a single: so is what it is drawn at.
            let ground_m = f64::from(drawn_m as f32);
            Shot {
                ground_m,
                ..Shot::from(ground_m + 1.0)
            }
        })
        .collect();
    lifted(
        &shots,
        |distance, azimuth| 0.2 * distance.min(1.0) * libm::sin(3.0 * azimuth),
        extent,
    )
}

fn cliffs_on_screen(extent: Extent) -> Found {
    let shots = [1e5, -1e5].map(|ground_m| Shot {
        ground_m,
        ..Shot::from(ground_m + 1.0)
    });
    // A cliff runs through the view a metre beside the eye.
    let cliff = |distance: f64, azimuth: f64| {
        let edge = if distance * libm::sin(azimuth) > 1.0 {
            -1e5
        } else {
            0.0
        };
        edge + 0.2 * distance.min(1.0) * libm::sin(3.0 * azimuth)
    };
    lifted(&shots, cliff, extent)
}

/// Heights that step by the given height between two columns in the middle of a tile.
fn step_normals_error_deg(level: LevelKey, step_m: f32) -> f64 {
    let tile = TileKey::new(level, level.tiles().x / 2, level.tiles().y / 2)
        .expect("a tile in the middle");
    let grid = tile.grid();
    let rect = SampleRect {
        min: grid.rect.min + 120,
        max: grid.rect.min + 136,
    };
    let grid = Grid::new(Arc::clone(&grid.lattice), rect);
    let (width, height) = (rect.width() as usize, rect.height() as usize);
    let mut heights = Block::new(Bands::Height, width, height);
    for (i, h) in heights.samples_mut().iter_mut().enumerate() {
        *h = if i % width < width / 2 { 0.0 } else { step_m };
    }
    let mut builder = GraphBuilder::default();
    let source = builder.add(Arc::new(Memory::new(&grid, heights.clone())), &[]);
    let normals = builder.add(Arc::new(Normals::new(Planet::EARTH, 1.0)), &[source]);
    builder.cut(normals, SampleType::Normal);
    let inner = Grid::new(
        Arc::clone(&grid.lattice),
        SampleRect {
            min: rect.min + 1,
            max: rect.max - 1,
        },
    );
    let Ok(found) = builder
        .build()
        .evaluate(normals, &inner, &Cancel::default())
    else {
        return f64::NAN;
    };
    let mut worst_deg = 0.0;
    for y in 0..height - 2 {
        let colat = grid
            .lattice
            .map_point(rect.min + I64Vec2::new(0, y as i64 + 1))
            .colat_rad;
        let run_m = Planet::EARTH.metres_per_radian(colat).x * level.step_rad().x * 2.0;
        for x in 0..width - 2 {
            let at = |x: usize| f64::from(heights.samples()[(y + 1) * width + x]);
            let slope = (at(x + 2) - at(x)) / run_m;
            let exact = DVec3::new(-slope, 0.0, 1.0);
            let i = y * (width - 2) + x;
            let stored = normal::unit([found.plane(0)[i], found.plane(1)[i]]);
            let angle = libm::atan2(stored.cross(exact).length(), stored.dot(exact));
            worst_deg = worse(worst_deg, angle.to_degrees());
        }
    }
    worst_deg
}

fn cliff_normals(extent: Extent) -> Found {
    let levels: &[u8] = extent.pick(&[0, 9, 17], &[0, 3, 6, 9, 12, 15, 17]);
    let each = levels.iter().flat_map(|n| {
        [-1e5, 1e5, 1e-3].map(|step| step_normals_error_deg(LevelKey::new(n + 1, *n), step))
    });
    Found::only(worst(each))
}

/// A ground of one height under a source; what differs from what should be there.
fn sparse_sources(_: Extent) -> Found {
    let key = TileKey::new(LevelKey::new(5, 4), 9, 7).expect("a tile of that level");
    let grid = key.grid();
    let one = SampleRect {
        min: grid.rect.min + 100,
        max: grid.rect.min + 101,
    };
    let single = Grid::new(Arc::clone(&grid.lattice), one);
    let held =
        |height_m: f32| Memory::new(&single, Block::filled(Bands::Height, 1, 1, &[height_m]));
    let none = Memory::new(&grid, Block::filled(Bands::Height, 256, 256, &[f32::NAN]));
    let over = |source: Memory| {
        let mut builder = GraphBuilder::default();
        let ground = builder.add(Arc::new(Constant::height(123.25)), &[]);
        let source = builder.add(Arc::new(source), &[]);
        let inputs: [NodeIndex; 2] = [ground, source];
        let root = builder.add(Arc::new(OverlayHeights::new(1.0, false)), &inputs);
        builder.cut(root, SampleType::Height);
        builder.build().evaluate(root, &grid, &Cancel::default())
    };
    let error = |source: Memory, expected: &dyn Fn(usize) -> f32| match over(source) {
        Ok(block) => worst(
            block
                .samples()
                .iter()
                .enumerate()
                .map(|(i, h)| f64::from((h - expected(i)).abs())),
        ),
        Err(_) => f64::NAN,
    };
    let lonely = |i: usize| if i == 100 * 256 + 100 { -7.5 } else { 123.25 };
    Found::only(worst([
        error(none, &|_| 123.25),
        error(held(f32::NAN), &|_| 123.25),
        error(held(-7.5), &lonely),
    ]))
}
