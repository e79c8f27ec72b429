//! What was measured, anywhere: patches put together and interpolated.

use core::cell::Cell;
use core::f64::consts::{PI, TAU};
use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, GridCrs, MapPoint, Planet};

use super::survey::{NARROW_CELLS, Patch, Survey, WIDE, WIDE_CELLS};
use crate::RenderError;
use crate::node::Made;
use crate::nodes::ground::Ground;

/// How rough a place is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rough {
    /// Height of the longest octave, metres.
    pub(super) height_m: f32,
    /// The factor on it from octave to octave.
    pub(super) falloff: f32,
}

/// A cell of some resolution: its patch, and its number there.
struct Place {
    column: i64,
    row: i64,
    cell: usize,
}

/// A row of cells beside a circle of latitude.
#[derive(Clone, Copy)]
struct Row {
    /// The row of patches that it belongs to.
    patches: i64,
    /// Number of its first cell in a patch.
    first: usize,
    /// Two to this power cells along a side of a patch.
    per: u32,
    /// Cells around the planet, a power of two.
    columns: i64,
    cells_per_rad: f64,
    /// What is added to a longitude: half a turn beyond a pole.
    east_rad: f64,
    weight: f64,
}

/// The rows of cells around a colatitude; `columns_of` says how many patches a row has.
fn rows_around(
    survey: &Survey,
    columns_of: impl Fn(i64) -> i64,
    cells: usize,
    colat_rad: f64,
) -> [Row; 2] {
    let per = cells as i64;
    let rows = survey.rows() * per;
    let v = colat_rad / PI * rows as f64 - 0.5;
    let first = libm::floor(v);
    let share = v - first;
    [(0, 1.0 - share), (1, share)].map(|(south, weight)| {
        let mut row = first as i64 + south;
        // Beyond a pole lies the opposite meridian.
        let beyond = row < 0 || row >= rows;
        if beyond {
            row = if row < 0 {
                -1 - row
            } else {
                2 * rows - 1 - row
            };
        }
        let columns = columns_of(row / per) * per;
        Row {
            patches: row / per,
            first: (row % per * per) as usize,
            per: per.trailing_zeros(),
            columns,
            cells_per_rad: columns as f64 / TAU,
            east_rad: if beyond { TAU } else { PI },
            weight,
        }
    })
}

/// Two neighbouring cells of a row.
#[derive(Clone, Copy)]
struct Pair {
    /// Their patches, and their numbers in a patch's row of cells.
    cells: [(i64, usize); 2],
    /// How much the eastern one counts.
    share: f64,
}

impl Row {
    /// The cells around a longitude.
    fn pair(&self, lon_rad: f64) -> Pair {
        // Shifts and masks: divisions would take longer than the noise.
        let u = (lon_rad + self.east_rad) * self.cells_per_rad - 0.5;
        let toward_zero = u as i64;
        let first = toward_zero - i64::from(toward_zero as f64 > u);
        let in_patch = (1 << self.per) - 1;
        Pair {
            cells: [0, 1].map(|east| {
                let column = (first + east) & (self.columns - 1);
                (column >> self.per, (column & in_patch) as usize)
            }),
            share: u - first as f64,
        }
    }
}

/// Calls `each` with the cells around a longitude and how much each counts.
#[inline]
fn around(rows: &[Row; 2], lon_rad: f64, mut each: impl FnMut(Place, f64)) {
    let [north, south] = rows;
    let of_north = north.pair(lon_rad);
    let alike = north.columns == south.columns && north.east_rad == south.east_rad;
    let of_south = if alike { of_north } else { south.pair(lon_rad) };
    for (row, pair) in [(north, of_north), (south, of_south)] {
        let [west, east] = pair.cells;
        for ((column, cell), share) in [(west, 1.0 - pair.share), (east, pair.share)] {
            let place = Place {
                column,
                row: row.patches,
                cell: row.first + cell,
            };
            each(place, share * row.weight);
        }
    }
}

/// A sample's place and its longer side on the ground in metres; `None` where the plane shows no place.
fn where_is(ground: &Ground, planet: &Planet, sample: I64Vec2) -> Option<(MapPoint, f64)> {
    let place = ground.point(sample.as_dvec2() + 0.5)?;
    let spacing_m = spacing_m(ground, planet, sample, || libm::sin(place.colat_rad))?;
    Some((place, spacing_m))
}

/// A sample's longer side on the ground in metres.
pub(super) fn spacing_m(
    ground: &Ground,
    planet: &Planet,
    sample: I64Vec2,
    sin_colat: impl Fn() -> f64,
) -> Option<f64> {
    if let Some(step) = ground.map_step() {
        let sides = DVec2::new(step.x * sin_colat(), step.y).abs();
        return Some(sides.max_element() * planet.radius_m);
    }
    let [column, row] = ground.steps_m(planet, sample)?;
    Some(column.length().max(row.length()))
}

/// Patches, column and row, that decide the samples of a grid, sorted.
pub(super) fn touched(
    survey: &Survey,
    grid: &Grid,
    node: &'static str,
) -> Result<BTreeSet<(i64, i64)>, RenderError> {
    let mut all = BTreeSet::new();
    let Grid { lattice, rect } = grid;
    let columns_of = |row| survey.columns(row);
    let mut add = |place: MapPoint| {
        let rows = rows_around(survey, columns_of, WIDE_CELLS, place.colat_rad);
        around(&rows, place.lon_rad, |cell, _| {
            all.insert((cell.row, cell.column));
        });
    };
    let cell_m = WIDE as f64 * survey.step_m();
    let ground = Ground::new(lattice, node)?;
    let step_m = match lattice.crs {
        GridCrs::Map => survey.planet().radius_m * lattice.step.abs().max_element(),
        GridCrs::Projected(_) => {
            let middle = (rect.min + rect.max) / 2;
            let steps = ground.steps_m(survey.planet(), middle);
            steps.map_or(cell_m, |[a, b]| 2.0 * a.length().max(b.length()))
        }
    };
    let stride = libm::floor(0.9 * cell_m / step_m).clamp(1.0, 1e6) as i64;
    let along = |min: i64, max: i64| {
        (min..max)
            .step_by(stride as usize)
            .chain((min < max).then(|| max - 1))
    };
    // Any place lies within half a cell of one that is looked at, so that no cell is missed.
    let cell_rad = cell_m / survey.planet().radius_m;
    for y in along(rect.min.y, rect.max.y) {
        for x in along(rect.min.x, rect.max.x) {
            let found = where_is(&ground, survey.planet(), I64Vec2::new(x, y));
            // Samples that show no octave need nothing; beside this one they are about as large.
            let Some((place, spacing_m)) = found else {
                continue;
            };
            if 0.9 * spacing_m > 0.5 * survey.longest_m() {
                continue;
            }
            add(place);
            if stride > 1 {
                let wide_rad = 0.5 * cell_rad / libm::sin(place.colat_rad).max(cell_rad);
                for (east, south) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                    let beside = MapPoint::new(
                        place.lon_rad + east * wide_rad,
                        place.colat_rad + south * 0.5 * cell_rad,
                    );
                    add(beside.normalised());
                }
            }
        }
    }
    Ok(all)
}

/// Patches that were measured.
pub(super) struct Field<'a> {
    survey: &'a Survey,
    patches: Vec<Arc<Patch>>,
    /// The one that was found last.
    last: Cell<usize>,
    /// Rows and their numbers of patches, by whether the row is odd: neighbours are asked for in turns.
    columns: [Cell<(i64, i64)>; 2],
}

impl<'a> Field<'a> {
    /// The field of what [`super::Detail`] asked for.
    pub(super) fn new(survey: &'a Survey, made: &[Made]) -> Self {
        let patches = made.iter();
        let patches = patches.filter_map(|m| Arc::downcast::<Patch>(Arc::clone(m)).ok());
        Self {
            survey,
            patches: patches.collect(),
            last: Cell::new(0),
            columns: [Cell::new((-1, 0)), Cell::new((-1, 0))],
        }
    }

    fn columns(&self, row: i64) -> i64 {
        let known = &self.columns[(row & 1) as usize];
        if known.get().0 != row {
            known.set((row, self.survey.columns(row)));
        }
        known.get().1
    }

    #[inline]
    fn patch(&self, place: &Place) -> Option<&Patch> {
        let is_it = |patch: &Patch| patch.column == place.column && patch.row == place.row;
        let last = self.patches.get(self.last.get());
        if let Some(patch) = last.filter(|patch| is_it(patch)) {
            return Some(patch);
        }
        let at = self.patches.iter().position(|patch| is_it(patch))?;
        self.last.set(at);
        self.patches.get(at).map(|patch| &**patch)
    }

    /// The cells beside a circle of latitude.
    pub(super) fn circle(&self, colat_rad: f64) -> Circle {
        let columns_of = |row| self.columns(row);
        let rows = |cells| rows_around(self.survey, columns_of, cells, colat_rad);
        Circle {
            wide: rows(WIDE_CELLS),
            narrow: rows(NARROW_CELLS),
        }
    }

    /// How rough a place on a circle of latitude is: bilinear between cells, so that nothing jumps.
    pub(super) fn at(&self, circle: &Circle, lon_rad: f64) -> Rough {
        let (mut height_m, mut falloff, mut steep) = (0.0, 0.0, 0.0);
        around(&circle.wide, lon_rad, |cell, weight| {
            if let Some(patch) = self.patch(&cell) {
                let [h, f] = patch.law[cell.cell].map(f64::from);
                height_m += weight * h;
                // Where nothing is rough nothing is said of how that falls off.
                falloff += weight * h * f;
            }
        });
        if height_m == 0.0 {
            return Rough::default();
        }
        around(&circle.narrow, lon_rad, |cell, weight| {
            if let Some(patch) = self.patch(&cell) {
                steep += weight * f64::from(patch.steepness[cell.cell]);
            }
        });
        Rough {
            height_m: (height_m * steep) as f32,
            falloff: (falloff / height_m) as f32,
        }
    }
}

/// The rows of cells beside a circle of latitude.
pub(super) struct Circle {
    wide: [Row; 2],
    narrow: [Row; 2],
}
