//! A square of cells: evaluated once, summed at its spacing and at twice as much.

use core::f64::consts::{FRAC_PI_2, SQRT_2};
use std::sync::Arc;

use glam::DVec2;
use relievo_planet::map::wrap_longitude;
use relievo_planet::{Grid, GridCrs, Lattice, Planet, SampleRect};

use super::Change;
use crate::ground::AnalysisError;
use crate::map_box::MapBox;
use crate::triangle::positive_part_of_cell;

/// Cells along a side of a patch; even.
pub(crate) const CELLS: usize = 32;

/// Samples along a side of a patch.
const NODES: usize = CELLS + 1;

/// Where a patch lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Longitude and colatitude of the north-western node in radians.
    corner: DVec2,
    /// Radians of longitude and colatitude between nodes.
    step: DVec2,
    /// Metres on the ground between nodes along both, where they are widest.
    pub(crate) spacing_m: DVec2,
}

impl Place {
    /// Samples of a patch.
    pub(crate) const SAMPLES: u64 = (NODES * NODES) as u64;

    pub(crate) fn new(planet: &Planet, corner: DVec2, step: DVec2) -> Self {
        let south = corner.y + step.y * CELLS as f64;
        let widest = FRAC_PI_2.clamp(corner.y, south);
        Self {
            corner,
            step,
            spacing_m: planet.metres_per_radian(widest) * step,
        }
    }

    pub(crate) fn area(&self) -> MapBox {
        let west_rad = wrap_longitude(self.corner.x);
        let size = self.step * CELLS as f64;
        MapBox {
            west_rad,
            east_rad: west_rad + size.x,
            north_colat_rad: self.corner.y,
            south_colat_rad: self.corner.y + size.y,
        }
    }

    pub(crate) fn grid(&self) -> Grid {
        let lattice = Lattice {
            crs: GridCrs::Map,
            // Samples are areas around nodes.
            origin: self.corner - 0.5 * self.step,
            step: self.step,
            columns_around: None,
        };
        let nodes = NODES as i64;
        Grid::new(Arc::new(lattice), SampleRect::at(0, 0, nodes, nodes))
    }

    /// Halves of the longer side, or quarters where both are about as long.
    pub(crate) fn parts(&self, planet: &Planet) -> Vec<Self> {
        let DVec2 { x, y } = self.spacing_m;
        let (columns, rows) = (
            if x * SQRT_2 > y { 2 } else { 1 },
            if y * SQRT_2 > x { 2 } else { 1 },
        );
        let step = self.step / DVec2::new(f64::from(columns), f64::from(rows));
        let corners = (0..rows).flat_map(|row| {
            (0..columns).map(move |column| DVec2::new(f64::from(column), f64::from(row)))
        });
        corners
            .map(|at| Self::new(planet, self.corner + at * step * CELLS as f64, step))
            .collect()
    }

    /// The cells of a row of `stride` nodes: square metres of one, and metres along its sides half way.
    fn cell(&self, planet: &Planet, row: usize, stride: usize) -> (f64, DVec2) {
        let side = self.step * stride as f64;
        let metres = |rows: f64| planet.metres_per_radian(self.corner.y + rows * self.step.y);
        let first = row as f64;
        let (north, middle, south) = (
            metres(first),
            metres(first + 0.5 * stride as f64),
            metres(first + stride as f64),
        );
        // Simpson's rule: 10⁻¹² of a cell of 10 km.
        let area = |m: DVec2| m.element_product();
        let mean = (area(north) + 4.0 * area(middle) + area(south)) / 6.0;
        (mean * side.element_product(), middle * side)
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
        place: Place,
        differs_m: f64,
    ) -> Result<Self, AnalysisError> {
        let grid = place.grid();
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
            planet: change.planet(),
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
    planet: Planet,
    place: Place,
    /// After minus before, 0 where either is missing.
    difference: &'a [f64],
    after: &'a [f64],
    differs_m: f64,
}

impl Surface<'_> {
    /// Sums over cells of `stride` nodes, and what cells that have changed in part leave open.
    fn sums(&self, stride: usize) -> (Sums, Sums) {
        let mut sums = (Sums::default(), Sums::default());
        for row in (0..CELLS).step_by(stride) {
            let (area_m2, side_m) = self.place.cell(&self.planet, row, stride);
            for column in (0..CELLS).step_by(stride) {
                let first = row * NODES + column;
                let south = first + stride * NODES;
                let nodes = [first, first + stride, south + stride, south];
                let d = nodes.map(|i| self.difference[i]);
                if d == [0.0; 4] {
                    continue;
                }
                let (cell, open) = self.cell(d, nodes, side_m, area_m2);
                sums.0.add(&cell);
                sums.1.add(&open);
            }
        }
        sums
    }

    /// What a cell comes to, and how much of it is open where it has changed in part: the edge of what
    /// changes, a kink or a wall, may run anywhere through it.
    fn cell(&self, d: [f64; 4], nodes: [usize; 4], side_m: DVec2, area_m2: f64) -> (Sums, Sums) {
        let (_, fill_m) = positive_part_of_cell(d);
        let (_, cut_m) = positive_part_of_cell(d.map(|d| -d));
        let changed = d.iter().filter(|d| d.abs() > self.differs_m).count();
        let (stretch, slope_rad) = match changed {
            0 => (1.0, 0.0),
            _ => self.steepness(nodes, side_m),
        };
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
    fn steepness(&self, nodes: [usize; 4], side_m: DVec2) -> (f64, f64) {
        let h = nodes.map(|i| self.after[i]);
        if h.iter().any(|h| !h.is_finite()) {
            return (1.0, 0.0);
        }
        // Four triangles around the centre: their gradients come from a side and the centre.
        let centre = h.iter().sum::<f64>() / 4.0;
        let (mut stretch, mut slope_rad) = (0.0, 0.0);
        for i in 0..4 {
            let (a, b) = (h[i], h[(i + 1) % 4]);
            // Clockwise from the north side.
            let (side_m, half_m) = match i % 2 {
                0 => (side_m.x, 0.5 * side_m.y),
                _ => (side_m.y, 0.5 * side_m.x),
            };
            let along = (b - a) / side_m;
            let across = (f64::midpoint(a, b) - centre) / half_m;
            let steep = libm::hypot(along, across);
            stretch += 0.25 * (1.0 + steep * steep).sqrt();
            slope_rad += 0.25 * libm::atan(steep);
        }
        (stretch, slope_rad)
    }

    /// Deepest cut and highest fill at nodes, and what they may reach half a diagonal
    /// beside a node, by the largest change of the difference between its neighbours.
    fn highest(&self) -> ([f64; 2], [f64; 2]) {
        let (mut highest, mut bound) = ([0.0_f64; 2], [0.0_f64; 2]);
        for row in 0..NODES {
            for column in 0..NODES {
                let d = self.difference[row * NODES + column];
                if d == 0.0 {
                    continue;
                }
                let side = usize::from(d > 0.0);
                highest[side] = highest[side].max(d.abs());
                let change = |before: Option<usize>, after: Option<usize>| {
                    let neighbours = before.into_iter().chain(after);
                    let changes = neighbours.map(|i| (self.difference[i] - d).abs());
                    changes.fold(0.0, f64::max)
                };
                let at = row * NODES + column;
                let along_row = change(
                    (column > 0).then(|| at - 1),
                    (column < CELLS).then(|| at + 1),
                );
                let along_column = change(
                    (row > 0).then(|| at - NODES),
                    (row < CELLS).then(|| at + NODES),
                );
                // What falls off towards neighbours may have risen before it fell.
                bound[side] = bound[side].max(d.abs() + 0.5 * (along_row + along_column));
            }
        }
        (highest, bound)
    }
}
