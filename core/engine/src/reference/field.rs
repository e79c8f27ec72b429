//! What the reference evaluates: heights and the ground's look on any grid, and which level of the
//! map is fine enough at which distance.

use core::f64::consts::{FRAC_PI_2, PI};

use glam::I64Vec2;
use relievo_graph::RenderError;
use relievo_planet::{Grid, LevelKey, MapPoint, SampleRect, TILE_SAMPLES};
use relievo_raster::{Block, Cancel};

use crate::scene::Scene;

/// Cells along a side of a patch, the piece of a level that is evaluated and kept at once.
pub(super) const CELLS: i64 = 128;

/// Levels by which samples may be finer than the finest data: from there on a source is its own
/// interpolation, of which half a sample's sagitta is a sixteenth.
const BEYOND_DATA: u8 = 2;

/// Finest level whose columns are counted with m ≤ 30.
const FINEST: u8 = 28;

/// Heights and looks from a source that can be evaluated anywhere.
pub(super) trait Field: Sync {
    /// Heights in metres without exaggeration, finite, row by row.
    fn heights(&self, grid: &Grid, cancel: &Cancel) -> Result<Vec<f32>, RenderError>;

    /// Straight colours, sRGB encoded; `None` when nothing colours the ground.
    fn colours(&self, grid: &Grid, cancel: &Cancel) -> Result<Option<Block>, RenderError>;

    /// Normals without exaggeration; `None` when nothing is lit.
    fn normals(&self, grid: &Grid, cancel: &Cancel) -> Result<Option<Block>, RenderError>;

    /// Finest level n of the data.
    fn finest(&self) -> u8;
}

impl Field for Scene {
    fn heights(&self, grid: &Grid, cancel: &Cancel) -> Result<Vec<f32>, RenderError> {
        let block = self.graph.evaluate(self.roots.height, grid, cancel)?;
        let heights = block.plane(0).iter();
        Ok(heights
            .map(|h| if h.is_finite() { *h } else { 0.0 })
            .collect())
    }

    fn colours(&self, grid: &Grid, cancel: &Cancel) -> Result<Option<Block>, RenderError> {
        let evaluate = |node| self.graph.evaluate(node, grid, cancel);
        self.roots.colour.map(evaluate).transpose()
    }

    fn normals(&self, grid: &Grid, cancel: &Cancel) -> Result<Option<Block>, RenderError> {
        let evaluate = |node| self.graph.evaluate(node, grid, cancel);
        self.roots.normal.map(evaluate).transpose()
    }

    fn finest(&self) -> u8 {
        Scene::finest(self)
    }
}

/// Names a patch: a piece of a level of [`CELLS`]² cells between sample centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct PatchKey {
    pub(super) level: LevelKey,
    pub(super) column: i64,
    pub(super) row: i64,
}

/// A place of the map in a patch: continuous cells from its first sample's centre, 0 to [`CELLS`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) key: PatchKey,
    pub(super) u: f64,
    pub(super) v: f64,
}

impl PatchKey {
    /// Its samples: one more than cells, since cells lie between sample centres.
    pub(super) fn grid(&self) -> Grid {
        let (first_x, first_y) = (self.column * CELLS, self.row * CELLS);
        let rect = SampleRect::at(first_x, first_y, CELLS + 1, CELLS + 1);
        Grid::new(std::sync::Arc::new(self.level.lattice()), rect)
    }

    /// Longitude and colatitude of a place in it, radians.
    pub(super) fn map_point(&self, u: f64, v: f64) -> MapPoint {
        let step = self.level.step_rad();
        let corner = I64Vec2::new(self.column * CELLS, self.row * CELLS).as_dvec2();
        MapPoint::new(
            (corner.x + u + 0.5) * step.x - PI,
            (corner.y + v + 0.5) * step.y,
        )
    }
}

impl Spot {
    /// Its patch and those of the same columns and rows that lie nearest.
    pub(super) fn nearest(&self) -> [PatchKey; 4] {
        let half = CELLS as f64 / 2.0;
        let [east, south] = [self.u, self.v].map(|at| if at < half { -1 } else { 1 });
        [[0, 0], [east, 0], [0, south], [east, south]].map(|[columns, rows]| PatchKey {
            column: self.key.column + columns,
            row: self.key.row + rows,
            ..self.key
        })
    }
}

/// The map's levels with columns that are at most as wide on the ground as rows are high.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    /// Spacing of level 0 in metres.
    coarsest_m: f64,
    /// Finest level that is asked for.
    cap: u8,
    /// Up to which angle from a pole the next number of columns, half as many, is enough.
    fewer_columns_rad: [f64; FEWER],
}

/// How often columns may be halved towards a pole.
const FEWER: usize = FINEST as usize;

impl Levels {
    /// For a sphere and data whose finest level is `finest`.
    pub(super) fn new(radius_m: f64, finest: u8) -> Self {
        Self {
            coarsest_m: PI * radius_m / TILE_SAMPLES as f64,
            cap: finest.saturating_add(BEYOND_DATA).min(FINEST),
            fewer_columns_rad: core::array::from_fn(|k| libm::asin(libm::exp2(-(k as f64 + 1.0)))),
        }
    }

    /// All patches of the coarsest level.
    pub(super) fn coarsest() -> impl Iterator<Item = PatchKey> {
        let level = LevelKey::new(1, 0);
        let across = |samples: i64| samples / CELLS;
        let size = level.samples();
        (0..across(size.y)).flat_map(move |row| {
            (0..across(size.x)).map(move |column| PatchKey { level, column, row })
        })
    }

    /// Finest level.
    pub(super) fn cap(&self) -> u8 {
        self.cap
    }

    /// Distance between the rows of level n, metres.
    pub(super) fn spacing_m(&self, n: u8) -> f64 {
        self.coarsest_m / (1_i64 << n) as f64
    }

    /// The coarsest level with at most this spacing in metres, or the finest there is.
    pub(super) fn fine_enough(&self, spacing_m: f64) -> u8 {
        let ratio = self.coarsest_m / spacing_m;
        if ratio <= 1.0 {
            return 0;
        }
        // Exact: the exponent of the ratio, rounded up.
        let exponent = libm::ilogb(ratio);
        let above = i32::from(libm::scalbn(1.0, exponent) < ratio);
        (exponent + above).clamp(0, i32::from(self.cap)) as u8
    }

    /// Where a place of the map, in range, lies in level n.
    pub(super) fn spot(&self, n: u8, point: MapPoint) -> Spot {
        let rows = ((1_i64 << n) * TILE_SAMPLES) as f64;
        let y = point.colat_rad / PI * rows - 0.5;
        let row = (y / CELLS as f64).floor() as i64;
        let level = LevelKey::new(self.columns_exponent(n, row, rows), n);
        let columns = level.samples().x as f64;
        let x = (point.lon_rad + PI) / (2.0 * PI) * columns - 0.5;
        let column = (x / CELLS as f64).floor() as i64;
        Spot {
            key: PatchKey { level, column, row },
            u: x - (column * CELLS) as f64,
            v: y - (row * CELLS) as f64,
        }
    }

    /// Exponent m of the columns of a row of patches: the least with which columns are nowhere wider on
    /// the ground than rows are high.
    fn columns_exponent(&self, n: u8, row: i64, rows: f64) -> u8 {
        let colat = |row: i64| ((row * CELLS) as f64 + 0.5) / rows * PI;
        let (north, south) = (colat(row), colat(row + 1));
        // The side nearer to the equator, as an angle from the nearer pole.
        let widest = if north <= FRAC_PI_2 {
            south.min(FRAC_PI_2)
        } else {
            PI - north
        };
        let fewer = self.fewer_columns_rad.iter().take_while(|c| widest <= **c);
        (n + 1)
            .saturating_sub(fewer.count() as u8)
            .max(2.min(n + 1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_spot_lies_in_its_patch_and_leads_back_to_the_place(
            lon in -PI..PI, colat in 0.0..=PI, n in 0_u8..24,
        ) {
            let point = MapPoint::new(lon, colat);
            let spot = Levels::new(6.371e6, 28).spot(n, point);
            prop_assert!((0.0..=CELLS as f64).contains(&spot.u) && (0.0..=CELLS as f64).contains(&spot.v));
            let back = spot.key.map_point(spot.u, spot.v);
            prop_assert!((back.lon_rad - lon).abs() < 1e-14 && (back.colat_rad - colat).abs() < 1e-14);
            // Columns are at most as wide on the ground as rows are high.
            let step = spot.key.level.step_rad();
            prop_assert!(step.x * libm::sin(colat) <= step.y * 1.000_001 || spot.key.level.m == n + 1);
        }

        #[test]
        fn a_level_is_fine_enough_and_the_next_coarser_is_not(spacing in 0.1..1e5_f64) {
            let levels = Levels::new(6.371e6, 28);
            let n = levels.fine_enough(spacing);
            prop_assert!(levels.spacing_m(n) <= spacing || n == levels.cap());
            prop_assert!(n == 0 || levels.spacing_m(n - 1) > spacing);
        }
    }
}
