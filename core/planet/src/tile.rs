//! The anisotropic tile grid: levels of 2^m × 2^n tiles of [`TILE_SAMPLES`]² samples.

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, I64Vec2};

use crate::{Grid, GridCrs, Lattice, MapPoint, SampleRect};

/// Samples along a side of a tile, for heights, normals and colours alike.
pub const TILE_SAMPLES: i64 = 256;

/// Finest exponent of a level: 2^30 tiles of 256 samples are 3.6 cm at Earth's equator in n = 24
/// already, and every index still fits an f64 exactly.
pub const MAX_EXPONENT: u8 = 30;

/// A level of the tile grid: 2^m tiles around, 2^n from pole to pole.
///
/// Samples are square on the ground at the equator for m = n + 1; towards the poles m falls
/// (\[CH06\] 4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LevelKey {
    /// Exponent of the number of tile rows (θ).
    pub n: u8,
    /// Exponent of the number of tile columns (φ).
    pub m: u8,
}

impl LevelKey {
    /// The level with 2^m × 2^n tiles.
    ///
    /// # Panics
    /// If an exponent exceeds [`MAX_EXPONENT`].
    pub fn new(m: u8, n: u8) -> Self {
        assert!(
            m <= MAX_EXPONENT && n <= MAX_EXPONENT,
            "tile level out of range: m {m}, n {n}"
        );
        Self { n, m }
    }

    /// Number of tile columns and rows.
    pub fn tiles(&self) -> I64Vec2 {
        I64Vec2::new(1 << self.m, 1 << self.n)
    }

    /// Number of sample columns and rows.
    pub fn samples(&self) -> I64Vec2 {
        self.tiles() * TILE_SAMPLES
    }

    /// Size of a sample in radians of longitude and colatitude.
    pub fn step_rad(&self) -> DVec2 {
        DVec2::new(TAU, PI) / self.samples().as_dvec2()
    }

    /// The lattice of the level's samples; column 0 begins at longitude −π, row 0 at the north pole.
    pub fn lattice(&self) -> Lattice {
        Lattice {
            crs: GridCrs::Map,
            origin: DVec2::new(-PI, 0.0),
            step: self.step_rad(),
            columns_around: Some(self.samples().x),
        }
    }

    /// All samples of the level.
    pub fn extent(&self) -> SampleRect {
        SampleRect::new(I64Vec2::ZERO, self.samples())
    }

    /// Continuous sample coordinates of a map point, column in 0 ≤ x < samples.
    pub fn sample_from_map(&self, point: MapPoint) -> DVec2 {
        let p = point.normalised();
        DVec2::new(p.lon_rad + PI, p.colat_rad) / self.step_rad()
    }

    /// The sample inside the level that a sample index outside it denotes: columns wrap, rows
    /// reflect over the poles onto the opposite meridian.
    pub fn wrap_sample(&self, sample: I64Vec2) -> I64Vec2 {
        let size = self.samples();
        let mut row = sample.y.rem_euclid(2 * size.y);
        let mut column = sample.x;
        if row >= size.y {
            row = 2 * size.y - 1 - row;
            column += size.x / 2;
        }
        I64Vec2::new(column.rem_euclid(size.x), row)
    }

    /// Keys of all tiles that a rectangle of samples touches, row by row, where the rectangle lies
    /// inside the level's rows; columns wrap. Each key comes with its tile's rectangle in the
    /// unwrapped indices of `rect`.
    pub fn tiles_touching(
        &self,
        rect: &SampleRect,
    ) -> impl Iterator<Item = (TileKey, SampleRect)> + use<> {
        let level = *self;
        let rect = if rect.is_empty() {
            SampleRect::default()
        } else {
            *rect
        };
        let first = rect.min.div_euclid(I64Vec2::splat(TILE_SAMPLES));
        let last = (rect.max + TILE_SAMPLES - 1).div_euclid(I64Vec2::splat(TILE_SAMPLES));
        let (first_row, last_row) = (first.y.max(0), last.y.min(level.tiles().y));
        (first_row..last_row).flat_map(move |row| {
            (first.x..last.x).map(move |column| {
                (
                    TileKey::wrapped(level, column, row),
                    SampleRect::at(
                        column * TILE_SAMPLES,
                        row * TILE_SAMPLES,
                        TILE_SAMPLES,
                        TILE_SAMPLES,
                    ),
                )
            })
        })
    }
}

/// Names one tile: a level and a place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileKey {
    /// The level.
    pub level: LevelKey,
    /// Tile row from the north pole, below 2^n.
    pub row: u32,
    /// Tile column eastward from longitude −π, below 2^m.
    pub column: u32,
}

impl TileKey {
    /// The tile at (column, row), or `None` outside the level.
    pub fn new(level: LevelKey, column: i64, row: i64) -> Option<Self> {
        let inside =
            SampleRect::new(I64Vec2::ZERO, level.tiles()).contains(I64Vec2::new(column, row));
        inside.then_some(Self {
            level,
            row: row as u32,
            column: column as u32,
        })
    }

    /// The tile at any column (wrapping around the planet) of a row inside the level.
    fn wrapped(level: LevelKey, column: i64, row: i64) -> Self {
        Self {
            level,
            row: row as u32,
            column: column.rem_euclid(level.tiles().x) as u32,
        }
    }

    /// The tile's samples in its level's lattice.
    pub fn rect(&self) -> SampleRect {
        SampleRect::at(
            i64::from(self.column) * TILE_SAMPLES,
            i64::from(self.row) * TILE_SAMPLES,
            TILE_SAMPLES,
            TILE_SAMPLES,
        )
    }

    /// The grid of the tile's samples.
    pub fn grid(&self) -> Grid {
        Grid::new(Arc::new(self.level.lattice()), self.rect())
    }

    /// The tile of the next coarser level (both exponents one less, not below 0) that covers it;
    /// `None` for the coarsest.
    pub fn parent(&self) -> Option<Self> {
        let LevelKey { m, n } = self.level;
        if m == 0 && n == 0 {
            return None;
        }
        let level = LevelKey::new(m.saturating_sub(1), n.saturating_sub(1));
        Some(Self {
            level,
            row: self.row >> u8::from(n > 0),
            column: self.column >> u8::from(m > 0),
        })
    }

    /// The tile `columns` east and `rows` south, around the planet and over the poles.
    #[must_use]
    pub fn neighbour(&self, columns: i64, rows: i64) -> Self {
        let tiles = self.level.tiles();
        let mut row = (i64::from(self.row) + rows).rem_euclid(2 * tiles.y);
        let mut column = i64::from(self.column) + columns;
        if row >= tiles.y {
            // On a level one tile wide, half way around is the same tile.
            row = 2 * tiles.y - 1 - row;
            column += tiles.x / 2;
        }
        Self::wrapped(self.level, column, row)
    }
}

impl core::fmt::Display for TileKey {
    /// `m/n/column/row`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "{}/{}/{}/{}",
            self.level.m, self.level.n, self.column, self.row
        )
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn tiles() -> impl Strategy<Value = TileKey> {
        (
            0..=MAX_EXPONENT,
            0..=MAX_EXPONENT,
            any::<u32>(),
            any::<u32>(),
        )
            .prop_map(|(m, n, x, y)| {
                let level = LevelKey::new(m, n);
                let tiles = level.tiles();
                TileKey::new(level, i64::from(x) % tiles.x, i64::from(y) % tiles.y).expect("inside")
            })
    }

    proptest! {
        #[test]
        fn a_parent_covers_its_child(tile in tiles()) {
            if let Some(parent) = tile.parent() {
                let (fine, coarse) = (tile.level.samples(), parent.level.samples());
                let scale = fine / coarse;
                let covered = SampleRect::new(parent.rect().min * scale, parent.rect().max * scale);
                prop_assert!(covered.contains_rect(&tile.rect()));
            }
        }

        #[test]
        fn around_the_planet_a_tile_is_its_own_neighbour(tile in tiles(), turns in -3..3_i64) {
            let tiles = tile.level.tiles();
            prop_assert_eq!(tile.neighbour(turns * tiles.x, 0), tile);
            if tiles.x > 1 {
                prop_assert_eq!(tile.neighbour(0, 2 * tiles.y), tile);
            }
        }

        #[test]
        fn a_wrapped_sample_lies_in_the_level_at_the_same_place(
            m in 1..20_u8, n in 0..20_u8, x in -1_000_000..1_000_000_i64, y in -300_i64..300,
        ) {
            let level = LevelKey::new(m, n);
            let wrapped = level.wrap_sample(I64Vec2::new(x, y));
            prop_assert!(level.extent().contains(wrapped));
            let lattice = level.lattice();
            let centre = lattice.centre(I64Vec2::new(x, y));
            let place = MapPoint::new(centre.x, centre.y);
            prop_assert!(place.angle_to(lattice.map_point(wrapped)) < 1e-9);
        }

        #[test]
        fn the_tile_of_a_point_is_where_its_sample_lies(
            m in 0..30_u8, n in 0..30_u8, lon in -9.0..9.0, colat in 0.0..3.1,
        ) {
            let level = LevelKey::new(m, n);
            let sample = level.sample_from_map(MapPoint::new(lon, colat));
            prop_assert!(level.extent().contains(sample.floor().as_i64vec2()));
        }

        #[test]
        fn touching_tiles_cover_a_rectangle_inside_the_level_exactly(
            column in -600..600_i64, row in 0..1000_i64, width in 0..900_i64, height in 0..900_i64,
        ) {
            let level = LevelKey::new(3, 3);
            let rect = SampleRect::at(column, row, width, height);
            let inside = rect.intersection(&SampleRect::new(
                I64Vec2::new(i64::MIN / 4, 0),
                I64Vec2::new(i64::MAX / 4, level.samples().y),
            ));
            let mut covered = 0;
            for (key, at) in level.tiles_touching(&rect) {
                prop_assert!(at.overlaps(&rect));
                prop_assert_eq!(level.wrap_sample(at.min), key.rect().min);
                covered += at.intersection(&inside).area();
            }
            prop_assert_eq!(covered, inside.area());
        }
    }

    #[test]
    fn over_the_pole_the_neighbour_lies_on_the_opposite_meridian() {
        let tile = TileKey::new(LevelKey::new(3, 2), 1, 0).expect("inside");
        assert_eq!(
            tile.neighbour(0, -1),
            TileKey::new(tile.level, 5, 0).expect("inside")
        );
        assert_eq!(TileKey::new(tile.level, 8, 0), None);
        assert_eq!(TileKey::new(tile.level, 0, -1), None);
    }
}
