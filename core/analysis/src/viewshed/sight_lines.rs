//! Lines of sight over a square of samples.

use crate::frame::LocalFrame;
use crate::viewshed::{Sight, ViewshedSettings};

/// Samples along the sides of the blocks that are skipped, finer ones first.
const BLOCKS: [usize; 2] = [8, 64];

/// How far in metres ground may stand above a line of sight without hiding: rounding.
const GRAZING_M: f64 = 1e-6;

/// Samples around an observer, lowered by the planet's curvature.
pub(super) struct Terrain {
    /// Lowered heights in metres; NaN where there are none.
    heights: Vec<f32>,
    side: usize,
    reach: usize,
    radius_cells: f64,
    eye_m: f64,
    target_height_m: f64,
    /// Highest sample in and around each block of [`BLOCKS`].
    highest: [Vec<f32>; 2],
}

impl Terrain {
    pub(super) fn new(
        mut heights: Vec<f32>,
        reach: usize,
        spacing_m: f64,
        frame: &LocalFrame,
        settings: &ViewshedSettings,
    ) -> Self {
        let side = 2 * reach + 1;
        let lat_rad = frame.centre.lat_rad();
        let half = 0.5 * (1.0 - settings.refraction) * spacing_m * spacing_m;
        // Euler: the curvature of a direction is that of the meridian and of the prime vertical,
        // weighted by the squares of its cosine and sine.
        let north = half / frame.planet().meridian_radius_m(lat_rad);
        let east = half / frame.planet().prime_vertical_radius_m(lat_rad);
        let offset = |index: usize| index as f64 - reach as f64;
        for (row, line) in heights.chunks_exact_mut(side).enumerate() {
            let lowered_m = north * offset(row) * offset(row);
            for (column, height) in line.iter_mut().enumerate() {
                let drop_m = lowered_m + east * offset(column) * offset(column);
                *height = (f64::from(*height) - drop_m) as f32;
            }
        }
        let highest = BLOCKS.map(|block| highest(&heights, side, block));
        let eye_m = f64::from(heights[side * reach + reach]) + settings.observer_height_m;
        Self {
            heights,
            side,
            reach,
            radius_cells: settings.radius_m / spacing_m,
            eye_m,
            target_height_m: settings.target_height_m,
            highest,
        }
    }

    /// What is seen of a row of samples.
    pub(super) fn row(&self, row: usize) -> Vec<Sight> {
        (0..self.side)
            .map(|column| self.sight(column, row))
            .collect()
    }

    fn sight(&self, column: usize, row: usize) -> Sight {
        let height_m = self.heights[row * self.side + column];
        let reach = self.reach as f64;
        let far = libm::hypot(column as f64 - reach, row as f64 - reach);
        if height_m.is_nan() || far > self.radius_cells * (1.0 + 1e-12) {
            return Sight::Outside;
        }
        if column == self.reach && row == self.reach {
            return Sight::Visible;
        }
        let line = Line::new(
            self,
            column,
            row,
            f64::from(height_m) + self.target_height_m,
        );
        if self.hides(&line, 0.0, 1.0, BLOCKS.len()) {
            Sight::Hidden
        } else {
            Sight::Visible
        }
    }

    /// Whether the ground rises above a line between two shares of it. Blocks of one size after the
    /// other are looked at first, coarse ones before fine ones.
    fn hides(&self, line: &Line, from: f64, to: f64, size: usize) -> bool {
        let Some(size) = size.checked_sub(1) else {
            return line
                .crossings(from, to)
                .any(|(share, height_m)| height_m > line.height_m(share) + GRAZING_M);
        };
        let block = BLOCKS[size];
        let step = block as f64 / line.cells();
        let mut begin = from;
        while begin < to {
            let end = if begin + step * 1.5 > to {
                to
            } else {
                begin + step
            };
            let lowest_m = line.height_m(begin).min(line.height_m(end));
            let ground_m = self.highest_along(line, begin, end, size);
            if ground_m > lowest_m && self.hides(line, begin, end, size) {
                return true;
            }
            begin = end;
        }
        false
    }

    /// Highest sample of the blocks that a part of a line touches.
    fn highest_along(&self, line: &Line, begin: f64, end: f64, size: usize) -> f64 {
        let block = BLOCKS[size];
        let across = self.side.div_ceil(block);
        let index = |cells: f64| (cells.max(0.0) as usize / block).min(across - 1);
        let (a, b) = (line.at(begin), line.at(end));
        // Rounding may put a crossing just beyond either end.
        let columns = index(a.0.min(b.0) - 0.5)..=index(a.0.max(b.0) + 0.5);
        let rows = index(a.1.min(b.1) - 0.5)..=index(a.1.max(b.1) + 0.5);
        let mut found = f32::NEG_INFINITY;
        for row in rows {
            for column in columns.clone() {
                found = found.max(self.highest[size][row * across + column]);
            }
        }
        f64::from(found)
    }
}

/// A line from the eye to a target.
struct Line<'a> {
    terrain: &'a Terrain,
    /// Cells from the observer to the target, east and south.
    columns: i64,
    rows: i64,
    target_m: f64,
}

impl<'a> Line<'a> {
    fn new(terrain: &'a Terrain, column: usize, row: usize, target_m: f64) -> Self {
        Self {
            terrain,
            columns: column as i64 - terrain.reach as i64,
            rows: row as i64 - terrain.reach as i64,
            target_m,
        }
    }

    fn cells(&self) -> f64 {
        self.columns.abs().max(self.rows.abs()) as f64
    }

    /// Height of the line at a share of it.
    fn height_m(&self, share: f64) -> f64 {
        self.terrain.eye_m + (self.target_m - self.terrain.eye_m) * share
    }

    /// Column and row at a share of it.
    fn at(&self, share: f64) -> (f64, f64) {
        let reach = self.terrain.reach as f64;
        (
            reach + self.columns as f64 * share,
            reach + self.rows as f64 * share,
        )
    }

    /// Shares at which the line crosses columns or rows of samples within `from..=to`, and the
    /// ground's height there; its ends do not count.
    fn crossings(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.lines(self.columns, self.rows, from, to, true)
            .chain(self.lines(self.rows, self.columns, from, to, false))
    }

    /// Crossings with the lines of samples along one axis: `along` cells of it lie between the ends,
    /// `aside` of the other.
    fn lines(
        &self,
        along: i64,
        aside: i64,
        from: f64,
        to: f64,
        columns: bool,
    ) -> impl Iterator<Item = (f64, f64)> + '_ {
        let count = along.abs() as f64;
        let first = (libm::floor(from * count) as i64).max(1);
        let last = (libm::ceil(to * count) as i64).min(along.abs() - 1);
        let terrain = self.terrain;
        (first..=last).map(move |k| {
            let share = k as f64 / count;
            let beside = aside as f64 * share;
            let whole = libm::floor(beside);
            let part = beside - whole;
            let line = terrain.reach as i64 + k * along.signum();
            let low = terrain.reach as i64 + whole as i64;
            let height = |aside: i64| {
                let (column, row) = if columns {
                    (line, aside)
                } else {
                    (aside, line)
                };
                f64::from(terrain.heights[row as usize * terrain.side + column as usize])
            };
            let ground_m = if part == 0.0 {
                height(low)
            } else {
                height(low) + (height(low + 1) - height(low)) * part
            };
            (share, ground_m)
        })
    }
}

/// Highest sample of each block, its neighbours' first ones included; −∞ where none has a height.
fn highest(heights: &[f32], side: usize, block: usize) -> Vec<f32> {
    let across = side.div_ceil(block);
    let mut found = Vec::with_capacity(across * across);
    for row in 0..across {
        for column in 0..across {
            let (top, left) = (row * block, column * block);
            let (bottom, right) = ((top + block + 1).min(side), (left + block + 1).min(side));
            let mut most = f32::NEG_INFINITY;
            for line in top..bottom {
                for height in &heights[line * side + left..line * side + right] {
                    most = most.max(*height);
                }
            }
            found.push(most);
        }
    }
    found
}
