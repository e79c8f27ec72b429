//! The coarse lattice on which seams are found, and its blocks.

use core::f64::consts::PI;
use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_planet::{GridCrs, Lattice, Planet, SampleRect};

use super::super::ground::Ground;

/// Samples of the coarse lattice are made in blocks of this many columns and rows.
pub(super) const BLOCK: i64 = 128;

/// Rows of the coarse lattice within the reach, at least, where finer samples are asked for.
const ROWS_IN_REACH: f64 = 16.0;

/// A spacing is met when it is missed by no more than this factor.
const TOLERANCE: f64 = 1.01;

/// Most halvings from the coarse lattice to the finest.
const MOST_DOUBLINGS: u32 = 30;

/// Columns around the planet that are kept, so that the coarse lattice still shows directions where a
/// level has few columns, around a pole.
const LEAST_COLUMNS: i64 = 64;

/// Seams further away than this many columns or rows are not seen, however near they are in metres.
const MOST_HALO: i64 = 128;

/// Lattices with at most this many columns around the planet are read all around where the reach asks
/// for it. On others no sample is read twice, once directly and once over the pole.
const WHOLE_CIRCLE: i64 = 2 * (BLOCK + 2 * MOST_HALO);

/// How a lattice lies in the coarse one: sample (i, j) in coarse sample (i / 2^d₀, j / 2^d₁).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coarse {
    pub(super) lattice: Arc<Lattice>,
    /// Of columns and of rows.
    pub(super) doublings: [u32; 2],
    /// Metres from row to row.
    pub(super) spacing_m: f64,
    /// Columns and rows of a lattice that closes upon itself.
    closed: Option<I64Vec2>,
}

impl Coarse {
    /// The coarsest lattice around `lattice` that has [`ROWS_IN_REACH`], or `lattice` itself where it
    /// has fewer already; `None` where its samples are larger than the reach.
    pub(super) fn new(lattice: &Lattice, planet: &Planet, reach_m: f64) -> Option<Self> {
        let mut spacing_m = row_spacing_m(lattice, planet)?;
        if spacing_m.is_nan() || spacing_m <= 0.0 || spacing_m > reach_m {
            return None;
        }
        let size = lattice.columns_around.map(|columns| {
            let rows = libm::round(PI / lattice.step.y.abs()) as i64;
            I64Vec2::new(columns, rows)
        });
        let is_whole = |samples: i64, doublings: u32| samples & ((1 << doublings) - 1) == 0;
        let mut rows = 0;
        while spacing_m * 2.0 <= reach_m / ROWS_IN_REACH * TOLERANCE
            && rows < MOST_DOUBLINGS
            && size.is_none_or(|size| is_whole(size.y, rows + 1))
        {
            spacing_m *= 2.0;
            rows += 1;
        }
        let mut columns = rows;
        if let Some(size) = size {
            while columns > 0 && (!is_whole(size.x, columns) || size.x >> columns < LEAST_COLUMNS) {
                columns -= 1;
            }
        }
        let [columns_m, rows_m] = [columns, rows].map(|doublings| (1_i64 << doublings) as f64);
        let coarse = Lattice {
            crs: lattice.crs.clone(),
            origin: lattice.origin,
            // Powers of two: exact, so the coarse lattice of a level is that of the coarse level.
            step: lattice.step * DVec2::new(columns_m, rows_m),
            columns_around: size.map(|size| size.x >> columns),
        };
        Some(Self {
            lattice: Arc::new(coarse),
            doublings: [columns, rows],
            spacing_m,
            closed: size.map(|size| I64Vec2::new(size.x >> columns, size.y >> rows)),
        })
    }

    /// A row as it is called inside the lattice, and whether it was found over a pole.
    fn row(&self, y: i64) -> (i64, bool) {
        let Some(size) = self.closed else {
            return (y, false);
        };
        let phase = y.rem_euclid(2 * size.y);
        if phase < size.y {
            (phase, false)
        } else {
            (2 * size.y - 1 - phase, true)
        }
    }

    /// A column as it is called inside the lattice.
    fn column(&self, x: i64, over_pole: bool) -> i64 {
        self.closed.map_or(x, |size| {
            let half = if over_pole { size.x / 2 } else { 0 };
            (x + half).rem_euclid(size.x)
        })
    }

    /// The samples of a rectangle as they are called inside the lattice, row by row.
    pub(super) fn inside(&self, rect: &SampleRect) -> impl Iterator<Item = I64Vec2> + use<> {
        let columns = |over| (rect.min.x..rect.max.x).map(move |x| self.column(x, over));
        let columns = [false, true].map(|over| columns(over).collect::<Arc<[i64]>>());
        let rows: Vec<_> = (rect.min.y..rect.max.y).map(|y| self.row(y)).collect();
        rows.into_iter().flat_map(move |(y, over)| {
            let columns = Arc::clone(&columns[usize::from(over)]);
            (0..columns.len()).map(move |i| I64Vec2::new(columns[i], y))
        })
    }

    /// The blocks in which samples of a rectangle lie, row by row.
    pub(super) fn blocks(&self, rect: &SampleRect) -> Vec<SampleRect> {
        let mut blocks = BTreeSet::new();
        for over in [false, true] {
            let rows = (rect.min.y..rect.max.y).map(|y| self.row(y));
            let rows = rows.filter(|(_, found)| *found == over);
            let rows: BTreeSet<i64> = rows.map(|(y, _)| y.div_euclid(BLOCK)).collect();
            if rows.is_empty() {
                continue;
            }
            let columns = (rect.min.x..rect.max.x).map(|x| self.column(x, over));
            let columns: BTreeSet<i64> = columns.map(|x| x.div_euclid(BLOCK)).collect();
            blocks.extend(rows.iter().flat_map(|y| columns.iter().map(|x| (*y, *x))));
        }
        let rect = |(y, x)| {
            let rect = SampleRect::at(x * BLOCK, y * BLOCK, BLOCK, BLOCK);
            self.closed.map_or(rect, |size| {
                rect.intersection(&SampleRect::new(I64Vec2::ZERO, size))
            })
        };
        blocks.into_iter().map(rect).collect()
    }

    /// Where seams are seen from the samples of a block, and what is read for that; `None` where the plane
    /// shows no place.
    pub(super) fn around(
        &self,
        planet: &Planet,
        block: SampleRect,
        support_m: f64,
    ) -> Option<Around> {
        let (seams, most_columns) = self.seen_from(planet, block, support_m)?;
        // The same for all reaches that have this lattice: what was read for one serves the next.
        let most_m = super::SUPPORT * 2.0 * ROWS_IN_REACH * TOLERANCE * self.spacing_m;
        let (most, _) = self.seen_from(planet, block, support_m.max(most_m))?;
        Some(Around {
            block,
            seams,
            most_columns,
            read: most.grow(Around::RIM),
        })
    }

    /// The samples that are seen from those of a block, and how many columns away is as far as is seen.
    fn seen_from(
        &self,
        planet: &Planet,
        block: SampleRect,
        support_m: f64,
    ) -> Option<(SampleRect, Option<i64>)> {
        let rows_m = |rows: f64| (libm::ceil(rows) as i64).clamp(1, MOST_HALO);
        if self.lattice.crs != GridCrs::Map {
            let ground = Ground::new(&self.lattice, super::KIND).ok()?;
            let steps = ground.steps_m(planet, (block.min + block.max) / 2)?;
            // Scales differ a little between the middle of a block and its surroundings.
            let halo = steps.map(|step| rows_m(1.25 * support_m / step.length()));
            return Some((within(block, halo), Some(MOST_HALO)));
        }
        let step = self.lattice.step.abs();
        let row_m = planet.metres_per_radian(PI / 2.0).y * step.y;
        let rows = rows_m(support_m / row_m);
        // Columns are nearest to each other where a row is nearest to a pole.
        let extent = SampleRect::new(
            I64Vec2::new(block.min.x, block.min.y - rows),
            I64Vec2::new(block.max.x, block.max.y + rows),
        );
        let column_m = [extent.min.y, extent.max.y - 1].map(|row| {
            let colat_rad = self.lattice.centre(I64Vec2::new(0, row)).y.clamp(0.0, PI);
            planet.metres_per_radian(colat_rad).x * step.x
        });
        let columns = libm::ceil(support_m / column_m[0].min(column_m[1]));
        let Some(size) = self.closed.filter(|size| size.x <= WHOLE_CIRCLE) else {
            return Some((within(block, [rows_m(columns), rows]), Some(MOST_HALO)));
        };
        let over_pole = extent.min.y < 0 || extent.max.y > size.y;
        if over_pole || block.width() as f64 + 2.0 * columns >= size.x as f64 {
            let west = block.min.x - (size.x - block.width()) / 2;
            let rows = (extent.min.y.max(0), extent.max.y.min(size.y));
            let seams = SampleRect::at(west, rows.0, size.x, rows.1 - rows.0);
            return Some((seams, None));
        }
        Some((within(block, [columns as i64, rows]), None))
    }
}

/// The samples of a block, and those around it where seams are seen from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Around {
    pub(super) block: SampleRect,
    pub(super) seams: SampleRect,
    /// Seams so many columns away count as being as far away as they are seen.
    pub(super) most_columns: Option<i64>,
    /// More samples on every side: seams are found beside what is not there.
    pub(super) read: SampleRect,
}

impl Around {
    /// Seams so many rows away count as being as far away as they are seen.
    pub(super) const MOST_ROWS: i64 = MOST_HALO;

    /// Samples read beyond those where seams are seen: whether there is one is asked for beside them too.
    const RIM: i64 = 2;
}

/// A block and so many columns and rows around it.
fn within(block: SampleRect, [columns, rows]: [i64; 2]) -> SampleRect {
    let halo = I64Vec2::new(columns, rows);
    SampleRect::new(block.min - halo, block.max + halo)
}

/// Metres from row to row, one number for all of a lattice so that wholes equal their parts.
fn row_spacing_m(lattice: &Lattice, planet: &Planet) -> Option<f64> {
    if lattice.crs == GridCrs::Map {
        let mean_m = planet.equatorial_radius_m * (1.0 - planet.flattening / 2.0);
        return Some(lattice.step.y.abs() * mean_m);
    }
    let ground = Ground::new(lattice, super::KIND).ok()?;
    let [_, row] = ground.steps_m(planet, I64Vec2::ZERO)?;
    Some(row.length())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_planet::LevelKey;

    use super::*;

    fn coarse(m: u8, n: u8, reach_m: f64) -> Option<Coarse> {
        Coarse::new(&LevelKey::new(m, n).lattice(), &Planet::EARTH, reach_m)
    }

    #[test]
    fn the_coarse_lattice_of_a_level_is_that_of_a_coarser_level() {
        let spacing_m = |n: u8| {
            let planet = Planet::EARTH;
            let radius_m = planet.equatorial_radius_m * (1.0 - planet.flattening / 2.0);
            LevelKey::new(0, n).lattice().step.y * radius_m
        };
        for doublings in 0..8_u8 {
            let n = 14 - doublings;
            let coarse = coarse(15, 14, spacing_m(n) * 16.0).expect("finer than the reach");
            assert_eq!(coarse.doublings, [u32::from(doublings); 2]);
            assert_eq!(*coarse.lattice, LevelKey::new(n + 1, n).lattice());
        }
        assert_eq!(coarse(15, 14, spacing_m(14) * 0.99), None);
        assert!(coarse(15, 14, spacing_m(14) * 1.01).is_some());
    }

    #[test]
    fn next_to_a_pole_and_for_any_reach_some_columns_are_left() {
        for (m, n) in [(0, 9), (2, 9), (0, 0), (1, 0), (13, 12)] {
            for reach_m in [1e4, 1e6, 2e7] {
                let Some(coarse) = coarse(m, n, reach_m) else {
                    continue;
                };
                let columns = coarse.lattice.columns_around.expect("closed");
                assert!(columns >= LEAST_COLUMNS, "{m} {n} {reach_m}");
            }
        }
    }

    proptest! {
        #[test]
        fn what_a_block_reads_is_bounded_and_no_sample_is_read_twice(
            m in 0..8_u8, n in 0..8_u8, reach_m in 1e3..2e7_f64, x in -600..600_i64, y in -600..600_i64,
        ) {
            let Some(coarse) = coarse(m, n, reach_m) else {
                return Ok(());
            };
            let size = coarse.closed.expect("closed");
            for block in coarse.blocks(&SampleRect::at(x, y, 5, 5)) {
                prop_assert!(SampleRect::new(I64Vec2::ZERO, size).contains_rect(&block));
                let around = coarse.around(&Planet::EARTH, block, 0.75 * reach_m).expect("a map");
                let seams = around.seams;
                let read = around.read.grow(-Around::RIM);
                prop_assert!(seams.contains_rect(&block) && around.read.contains_rect(&seams.grow(Around::RIM)));
                prop_assert!(read.width() <= WHOLE_CIRCLE && read.height() <= BLOCK + 2 * MOST_HALO);
                prop_assert!(read.width() <= size.x);
                // Over a pole a narrow strip is read on either side.
                let crosses = read.min.y < 0 || read.max.y > size.y;
                prop_assert!(!crosses || 2 * read.width() <= size.x);
            }
        }

        #[test]
        fn every_sample_lies_in_one_of_the_blocks(
            m in 0..4_u8, n in 0..4_u8, x in -600..1600_i64, y in -300..900_i64, w in 1..80_i64, h in 1..80_i64,
        ) {
            let coarse = coarse(m, n, 1e6).expect("finer than the reach");
            let rect = SampleRect::at(x, y, w, h);
            let blocks = coarse.blocks(&rect);
            for inside in coarse.inside(&rect) {
                prop_assert_eq!(blocks.iter().filter(|block| block.contains(inside)).count(), 1);
            }
        }
    }
}
