//! Colours: gamma and contrast at and beyond their ends.

use std::sync::Arc;

use relievo_engine::graph::GraphBuilder;
use relievo_engine::graph::nodes::{Adjust, AdjustParams, Memory};
use relievo_engine::planet::{Grid, LevelKey, SampleRect, TileKey};
use relievo_engine::raster::{Bands, Block, Cancel};

use super::{Case, Extent, Found, worse, worst};

pub(super) const CASES: &[Case] = &[Case {
    name: "gamma 0.1 to 10 and contrast 0 to 4, and far beyond both: adjusted colours",
    truth: "the formula in f64",
    unit: "parts of 255 after clamping",
    limit: 0.05,
    degrades: "steeper contrast magnifies rounding; beyond 0.01 and 100 gamma counts as these",
    measure: adjust,
}];

/// Every eighth of a step of 8-bit values, adjusted.
fn adjust_error(contrast: f64, gamma: f64) -> f64 {
    const COUNT: usize = 2041;
    let key = TileKey::new(LevelKey::new(5, 4), 0, 0).expect("a tile of that level");
    let lattice = Arc::clone(&key.grid().lattice);
    let min = glam::I64Vec2::ZERO;
    let grid = Grid::new(
        lattice,
        SampleRect {
            min,
            max: min + glam::I64Vec2::new(COUNT as i64, 1),
        },
    );
    let mut block = Block::new(Bands::Colour, COUNT, 1);
    for i in 0..COUNT {
        for plane in 0..3 {
            block.plane_mut(plane)[i] = i as f32 / (COUNT - 1) as f32;
        }
        block.plane_mut(3)[i] = 1.0;
    }
    let mut builder = GraphBuilder::default();
    let source = builder.add(Arc::new(Memory::new(&grid, block.clone())), &[]);
    let params = AdjustParams {
        contrast,
        gamma,
        ..AdjustParams::default()
    };
    let root = builder.add(Arc::new(Adjust::new(&params)), &[source]);
    let Ok(found) = builder.build().evaluate(root, &grid, &Cancel::default()) else {
        return f64::NAN;
    };
    let exponent = 1.0 / gamma.clamp(0.01, 100.0);
    let mut worst_step = 0.0;
    for (found, c) in found.plane(0).iter().zip(block.plane(0)) {
        let affine = 0.5 + (f64::from(*c) - 0.5) * contrast;
        let exact = libm::pow(affine.abs(), exponent).copysign(affine);
        let off = (f64::from(*found).clamp(0.0, 1.0) - exact.clamp(0.0, 1.0)).abs() * 255.0;
        worst_step = worse(worst_step, if found.is_nan() { f64::NAN } else { off });
    }
    worst_step
}

fn adjust(_: Extent) -> Found {
    let contrasts = [0.0, 0.25, 1.0, 4.0, 100.0, -1.0];
    let gammas = [0.1, 0.5, 1.0, 2.2, 10.0, 0.01, 100.0, 0.0, 1e9];
    let pairs = contrasts
        .into_iter()
        .flat_map(|c| gammas.map(move |g| (c, g)));
    Found::only(worst(pairs.map(|(c, g)| adjust_error(c, g))))
}
