//! A square of cells: evaluated once, summed at its spacing and at twice as much.

use std::sync::Arc;

use glam::DVec2;
use relievo_planet::{Grid, SampleRect};

use crate::frame::LocalFrame;
use crate::ground::AnalysisError;
use crate::triangle::positive_part_of_cell;
use crate::volume::{Change, Region};

/// Cells along a side of a patch; even.
pub(crate) const CELLS: usize = 32;

/// Samples along a side of a patch.
const NODES: usize = CELLS + 1;

/// Where a patch lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// North-western node in metres of the frame.
    corner_m: DVec2,
    /// Metres between nodes.
    pub(crate) spacing_m: f64,
}

impl Place {
    /// Samples of a patch.
    pub(crate) const SAMPLES: u64 = (NODES * NODES) as u64;

    pub(crate) fn new(corner_m: DVec2, spacing_m: f64) -> Self {
        Self {
            corner_m,
            spacing_m,
        }
    }

    fn side_m(&self) -> f64 {
        self.spacing_m * CELLS as f64
    }

    pub(crate) fn grid(&self, frame: &LocalFrame) -> Grid {
        let half = 0.5 * self.spacing_m;
        let lattice = frame.lattice(self.corner_m + DVec2::new(-half, half), self.spacing_m);
        let nodes = NODES as i64;
        Grid::new(Arc::new(lattice), SampleRect::at(0, 0, nodes, nodes))
    }

    /// The four patches of half the spacing that cover the same square.
    pub(crate) fn quarters(&self) -> [Self; 4] {
        let half_m = 0.5 * self.side_m();
        [(0.0, 0.0), (half_m, 0.0), (0.0, -half_m), (half_m, -half_m)]
            .map(|(x, y)| Self::new(self.corner_m + DVec2::new(x, y), 0.5 * self.spacing_m))
    }

    pub(crate) fn overlaps(&self, min_m: DVec2, max_m: DVec2) -> bool {
        let south_east = self.corner_m + DVec2::new(self.side_m(), -self.side_m());
        self.corner_m.x < max_m.x
            && south_east.x > min_m.x
            && south_east.y < max_m.y
            && self.corner_m.y > min_m.y
    }
}

/// What is summed over cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    pub(crate) cut_m3: f64,
    pub(crate) fill_m3: f64,
    pub(crate) net_m3: f64,
    pub(crate) plan_m2: f64,
    pub(crate) surface_m2: f64,
    pub(crate) slope_rad_m2: f64,
}

impl Sums {
    pub(crate) fn add(&mut self, other: &Self) {
        self.cut_m3 += other.cut_m3;
        self.fill_m3 += other.fill_m3;
        self.net_m3 += other.net_m3;
        self.plan_m2 += other.plan_m2;
        self.surface_m2 += other.surface_m2;
        self.slope_rad_m2 += other.slope_rad_m2;
    }

    /// Magnitudes of the differences.
    fn apart(&self, other: &Self) -> Self {
        Self {
            cut_m3: (self.cut_m3 - other.cut_m3).abs(),
            fill_m3: (self.fill_m3 - other.fill_m3).abs(),
            net_m3: (self.net_m3 - other.net_m3).abs(),
            plan_m2: (self.plan_m2 - other.plan_m2).abs(),
            surface_m2: (self.surface_m2 - other.surface_m2).abs(),
            slope_rad_m2: (self.slope_rad_m2 - other.slope_rad_m2).abs(),
        }
    }
}

/// A patch that has been evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub(crate) place: Place,
    pub(crate) fine: Sums,
    /// Magnitude of what the same patch at twice the spacing would differ by, and what cells that have
    /// changed in part leave open.
    pub(crate) error: Sums,
    /// Deepest cut and highest fill at a node.
    pub(crate) highest_m: [f64; 2],
    /// What they may be between nodes, by the steepest change of the difference nearby.
    pub(crate) highest_bound_m: [f64; 2],
    /// How far rounding to single precision may move a height difference.
    pub(crate) rounding_m: f64,
}

impl Patch {
    pub(crate) fn evaluate(
        change: &dyn Change,
        region: &Region,
        place: Place,
        differs_m: f64,
    ) -> Result<Self, AnalysisError> {
        let grid = place.grid(&region.frame);
        let (before, after) = change.heights(&grid)?;
        let difference: Vec<f64> = before
            .iter()
            .zip(&after)
            .map(|(b, a)| {
                let d = a - b;
                if d.is_finite() { d } else { 0.0 }
            })
            .collect();
        let surface = Surface {
            region,
            place,
            difference: &difference,
            after: &after,
            differs_m,
        };
        let (fine, at_edges) = surface.sums(1);
        let (coarse, _) = surface.sums(2);
        let mut error = fine.apart(&coarse);
        error.add(&at_edges);
        let largest = after.iter().map(|h| h.abs()).filter(|h| h.is_finite());
        let largest_m = largest.fold(0.0, f64::max);
        let (highest_m, highest_bound_m) = surface.highest();
        Ok(Self {
            place,
            fine,
            error,
            highest_m,
            highest_bound_m,
            rounding_m: largest_m * f64::from(f32::EPSILON),
        })
    }
}

struct Surface<'a> {
    region: &'a Region,
    place: Place,
    /// After minus before, 0 where either is missing.
    difference: &'a [f64],
    after: &'a [f64],
    differs_m: f64,
}

impl Surface<'_> {
    /// Sums over cells of `stride` nodes, and what cells that have changed in part leave open.
    fn sums(&self, stride: usize) -> (Sums, Sums) {
        let side_m = self.place.spacing_m * stride as f64;
        let mut sums = (Sums::default(), Sums::default());
        for row in (0..CELLS).step_by(stride) {
            for column in (0..CELLS).step_by(stride) {
                let first = row * NODES + column;
                let south = first + stride * NODES;
                let nodes = [first, first + stride, south + stride, south];
                let d = nodes.map(|i| self.difference[i]);
                if d == [0.0; 4] {
                    continue;
                }
                let steps = DVec2::new(column as f64, -(row as f64)) * self.place.spacing_m;
                let centre_m = self.place.corner_m + steps + 0.5 * DVec2::new(side_m, -side_m);
                let share = self.inside(centre_m, side_m);
                if share > 0.0 {
                    let area_m2 = side_m * side_m * share * self.region.frame.area_scale(centre_m);
                    let (cell, open) = self.cell(d, nodes, side_m, area_m2);
                    sums.0.add(&cell);
                    sums.1.add(&open);
                }
            }
        }
        sums
    }

    /// Share of a cell that lies in the region, whose sides are parallel to it.
    fn inside(&self, centre_m: DVec2, side_m: f64) -> f64 {
        let (min, max) = (centre_m - 0.5 * side_m, centre_m + 0.5 * side_m);
        let both = max.min(self.region.max_m) - min.max(self.region.min_m);
        (both.max(DVec2::ZERO) / side_m)
            .min(DVec2::ONE)
            .element_product()
    }

    /// What a cell comes to, and how much of it is open where it has changed in part: the edge of what
    /// changes, a kink or a wall, may run anywhere through it.
    fn cell(&self, d: [f64; 4], nodes: [usize; 4], side_m: f64, area_m2: f64) -> (Sums, Sums) {
        let (_, fill_m) = positive_part_of_cell(d);
        let (_, cut_m) = positive_part_of_cell(d.map(|d| -d));
        let changed = d.iter().filter(|d| d.abs() > self.differs_m).count();
        let (stretch, slope_rad) = self.steepness(nodes, side_m);
        let changed_m2 = changed as f64 / 4.0 * area_m2;
        let cell = Sums {
            cut_m3: cut_m * area_m2,
            fill_m3: fill_m * area_m2,
            net_m3: (fill_m - cut_m) * area_m2,
            plan_m2: changed_m2,
            surface_m2: stretch * changed_m2,
            slope_rad_m2: slope_rad * changed_m2,
        };
        if changed == 0 || changed == 4 {
            return (cell, Sums::default());
        }
        let most = |sign: f64| d.iter().map(|d| d * sign).fold(0.0, f64::max);
        let open_m2 = 0.5 * area_m2;
        let open = Sums {
            cut_m3: 0.5 * most(-1.0) * open_m2,
            fill_m3: 0.5 * most(1.0) * open_m2,
            net_m3: 0.5 * (most(1.0) + most(-1.0)) * open_m2,
            plan_m2: open_m2,
            surface_m2: stretch * open_m2,
            slope_rad_m2: slope_rad * open_m2,
        };
        (cell, open)
    }

    /// Area of the surface after per area of plan, and its mean angle against the horizontal, in a cell;
    /// level where a height is missing.
    fn steepness(&self, nodes: [usize; 4], side_m: f64) -> (f64, f64) {
        let h = nodes.map(|i| self.after[i]);
        if h.iter().any(|h| !h.is_finite()) {
            return (1.0, 0.0);
        }
        // Four triangles around the centre: their gradients come from a side and the centre.
        let centre = h.iter().sum::<f64>() / 4.0;
        let (mut stretch, mut slope_rad) = (0.0, 0.0);
        for i in 0..4 {
            let (a, b) = (h[i], h[(i + 1) % 4]);
            let along = (b - a) / side_m;
            let across = (f64::midpoint(a, b) - centre) / (0.5 * side_m);
            let steep = libm::hypot(along, across);
            stretch += 0.25 * (1.0 + steep * steep).sqrt();
            slope_rad += 0.25 * libm::atan(steep);
        }
        (stretch, slope_rad)
    }

    /// Deepest cut and highest fill at nodes inside the region, and what they may reach half a diagonal
    /// beside a node, by the largest change of the difference between its neighbours.
    fn highest(&self) -> ([f64; 2], [f64; 2]) {
        let (mut highest, mut bound) = ([0.0_f64; 2], [0.0_f64; 2]);
        let slack_m = 1e-9 * self.place.side_m();
        for row in 0..NODES {
            for column in 0..NODES {
                let steps = DVec2::new(column as f64, -(row as f64)) * self.place.spacing_m;
                let at_m = self.place.corner_m + steps;
                let inside = at_m.cmpge(self.region.min_m - slack_m).all()
                    && at_m.cmple(self.region.max_m + slack_m).all();
                let d = self.difference[row * NODES + column];
                if !inside || d == 0.0 {
                    continue;
                }
                let side = usize::from(d > 0.0);
                highest[side] = highest[side].max(d.abs());
                let neighbours = [
                    (row > 0).then(|| (row - 1) * NODES + column),
                    (row < CELLS).then(|| (row + 1) * NODES + column),
                    (column > 0).then(|| row * NODES + column - 1),
                    (column < CELLS).then(|| row * NODES + column + 1),
                ];
                // What falls off towards a neighbour may have risen before it fell.
                let rises = neighbours
                    .into_iter()
                    .flatten()
                    .map(|i| (self.difference[i] - d).abs());
                bound[side] = bound[side].max(d.abs() + 0.5 * rises.fold(0.0, f64::max));
            }
        }
        (highest, bound)
    }
}
