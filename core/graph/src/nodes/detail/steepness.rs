//! How steep a patch is, cell by cell, and where it is level.

use super::survey::{MARGIN, NARROW, WIDE};

/// Heights within this of each other are level, metres: water, and what interpolation rounds of it.
const LEVEL_M: f32 = 0.002;

/// Cells around a level one that count as level too: no interpolation between cells reaches it then.
const SHORE: usize = 2;

/// Samples left out along the sides of what is read.
const RIM: usize = MARGIN - WIDE;

/// Narrow cells of a patch and of a ring of wide cells around it.
pub(super) struct Cells {
    side: usize,
    /// Steepness to the power of its share; NaN where nothing is known.
    steep: Vec<f32>,
    level: Vec<bool>,
}

impl Cells {
    /// The steepness of a cell that is not level, where it is known.
    pub(super) fn at(&self, column: usize, row: usize) -> Option<f32> {
        let i = row * self.side + column;
        (!self.level[i] && !self.steep[i].is_nan()).then(|| self.steep[i])
    }

    /// Whether a cell or one beside it is level.
    pub(super) fn is_about_level(&self, column: usize, row: usize) -> bool {
        let around = |i: usize| i.saturating_sub(SHORE)..=(i + SHORE).min(self.side - 1);
        around(row).any(|y| around(column).any(|x| self.level[y * self.side + x]))
    }
}

/// Measures the cells of a square of heights, its outermost samples left out.
///
/// - `slope`: the power of the mean gradient that is taken.
pub(super) fn steepness(
    heights: &[f32],
    down_m: f64,
    across_m: impl Fn(usize) -> f64,
    slope: f64,
) -> Cells {
    let width = libm::sqrt(heights.len() as f64) as usize;
    let side = (width - 2 * RIM) / NARROW;
    let mut cells = Cells {
        side,
        steep: Vec::with_capacity(side * side),
        level: Vec::with_capacity(side * side),
    };
    for y in 0..side {
        // Near a pole rows are too narrow to be compared.
        let per_m: [f64; NARROW] = core::array::from_fn(|j| {
            let across = across_m(RIM + y * NARROW + j);
            if across > 0.3 * down_m {
                0.5 / across
            } else {
                0.0
            }
        });
        for x in 0..side {
            let first = (RIM + y * NARROW) * width + RIM + x * NARROW;
            let (mut sum, mut count) = (0.0, 0_u32);
            let (mut low, mut high, mut whole) = (f32::INFINITY, f32::NEG_INFINITY, true);
            for (j, per_m) in per_m.iter().chain([&0.0]).enumerate() {
                for i in 0..=NARROW {
                    let at = first + j * width + i;
                    let here = heights[at];
                    low = low.min(here);
                    high = high.max(here);
                    whole &= !here.is_nan();
                    if i == NARROW || j == NARROW {
                        continue;
                    }
                    let east = f64::from(heights[at + 1] - heights[at - 1]) * per_m;
                    let south = f64::from(heights[at + width] - heights[at - width]) * 0.5 / down_m;
                    let square = east * east + south * south;
                    if square.is_finite() {
                        sum += square;
                        count += 1;
                    }
                }
            }
            cells
                .level
                .push(whole && high - low <= LEVEL_M.max(high.abs() * 1e-6));
            cells.steep.push(if count == 0 {
                f32::NAN
            } else {
                libm::pow(sum / f64::from(count), 0.5 * slope) as f32
            });
        }
    }
    cells
}
