//! The water of a flood as depths on the samples of the data.

use std::collections::BTreeMap;

use glam::{DVec2, I64Vec2};
use relievo_planet::{Lattice, LevelKey, SampleRect};

use super::basin::TILE;

/// How deep water stands, sample by sample of the level that was flooded.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    level: LevelKey,
    /// North-western sample of what is under water; columns go on beyond the level's end.
    first: I64Vec2,
    size: I64Vec2,
    /// Depths of tiles by row and column, NaN where it is dry.
    tiles: BTreeMap<(i64, i64), Vec<f32>>,
}

impl Water {
    /// From tiles with at least one sample under water.
    pub(super) fn new(level: LevelKey, tiles: BTreeMap<(i64, i64), Vec<f32>>) -> Self {
        let (mut north, mut south) = (i64::MAX, i64::MIN);
        let mut columns: Vec<(i64, i64)> = Vec::new();
        for ((row, column), depths) in &tiles {
            let (mut west, mut east) = (TILE, 0);
            for (index, _) in depths.iter().enumerate().filter(|(_, d)| !d.is_nan()) {
                let (x, y) = (index as i64 % TILE, row * TILE + index as i64 / TILE);
                (west, east) = (west.min(x), east.max(x + 1));
                (north, south) = (north.min(y), south.max(y + 1));
            }
            columns.push((column * TILE + west, column * TILE + east));
        }
        let (west, east) = shortest(columns, level.samples().x);
        Self {
            level,
            first: I64Vec2::new(west, north),
            size: I64Vec2::new(east - west, south - north),
            tiles,
        }
    }

    /// Columns and rows of the smallest rectangle of samples that holds the water.
    pub fn size(&self) -> I64Vec2 {
        self.size
    }

    /// Where the rectangle's samples lie: sample (0, 0) is the north-western one.
    pub fn lattice(&self) -> Lattice {
        let whole = self.level.lattice();
        Lattice {
            origin: whole.origin + self.first.as_dvec2() * whole.step,
            columns_around: None,
            ..whole
        }
    }

    /// Size of a sample in radians of longitude and colatitude.
    pub fn step_rad(&self) -> DVec2 {
        self.level.lattice().step
    }

    /// Depths in metres on a part of the rectangle, row by row; NaN where it is dry.
    pub fn depths(&self, rect: SampleRect) -> Vec<f32> {
        let around = self.level.samples().x;
        let mut found = Vec::with_capacity(rect.area() as usize);
        for y in rect.min.y..rect.max.y {
            let row = self.first.y + y;
            for x in rect.min.x..rect.max.x {
                let column = (self.first.x + x).rem_euclid(around);
                let tile = self
                    .tiles
                    .get(&(row.div_euclid(TILE), column.div_euclid(TILE)));
                let index = row.rem_euclid(TILE) * TILE + column.rem_euclid(TILE);
                found.push(tile.map_or(f32::NAN, |depths| depths[index as usize]));
            }
        }
        found
    }
}

/// The shortest range of columns, counted around, that holds all of these ranges.
fn shortest(mut ranges: Vec<(i64, i64)>, around: i64) -> (i64, i64) {
    ranges.sort_unstable();
    let Some(first) = ranges.first().copied() else {
        return (0, 0);
    };
    let mut end = first.1;
    // The widest gap, and where it ends.
    let mut widest = (0, first.0);
    for (west, east) in &ranges {
        if west - end > widest.0 {
            widest = (west - end, *west);
        }
        end = end.max(*east);
    }
    let over_the_end = first.0 + around - end;
    if over_the_end >= widest.0 {
        return (first.0, end);
    }
    let west = widest.1;
    (west, west - widest.0 + around)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_on_both_sides_of_the_antimeridian_lies_in_a_narrow_rectangle() {
        assert_eq!(shortest(vec![(5, 20), (90, 100)], 100), (90, 120));
        assert_eq!(shortest(vec![(5, 20), (15, 30)], 100), (5, 30));
        assert_eq!(shortest(vec![(0, 100)], 100), (0, 100));
        assert_eq!(shortest(vec![(0, 10), (40, 50), (45, 60)], 100), (0, 60));
    }
}
