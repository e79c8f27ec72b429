//! Fine imagery without end, put together from patches of exemplars that suit the coarse colours.
//!
//! Patches are centred on a lattice that follows the samples by powers of two, every other row moved
//! by half, so that all is decided by global integer indices: around the planet and over the poles the
//! same patch is found from either side.

use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_planet::{GridCrs, MapPoint, SampleRect};
use relievo_raster::Cancel;

use super::super::ground::Ground;
use super::super::noise::scrambled;
use super::around::Around;
use super::choice::{Choice, Patch};
use super::coarse::{Coarse, Nesting, rows_between_poles};
use super::exemplar::Exemplar;
use super::field::{Field, covered};
use super::shown::Shown;
use crate::RenderError;

/// Coarse samples beyond the wanted ones that decide which patches are chosen: the centre of a patch
/// is less than 6 away (4 and half a step more), and what it is compared with 3 more.
pub(super) const MARGIN: i64 = 10;

/// Weights below this count for nothing: at most places one or two patches are mixed, as mixtures of
/// more lose whatever structure they have.
const LEAST_WEIGHT: f32 = 0.22;

/// The lattice of patches.
#[derive(Clone, Copy, Debug)]
struct Centres {
    /// From patch to patch there are 2^this coarse samples.
    exponent: i32,
    /// Patches around the planet and from pole to pole, where the lattice closes.
    closed: Option<I64Vec2>,
}

/// A place in the lattice of patches, as it is called inside the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    column: i64,
    row: i64,
    /// Whether it was found from beyond a pole.
    mirrored: bool,
}

impl Centres {
    /// As far apart as 4 coarse samples, unless exemplars are too small for that: with as much on
    /// either side, a third of the smallest is left to choose from.
    fn new(nesting: &Nesting, exemplars: &[Arc<Exemplar>]) -> Self {
        let smallest_m = exemplars
            .iter()
            .flat_map(|exemplar| exemplar.extent_m())
            .fold(f64::INFINITY, f64::min);
        let mut exponent = 2;
        while exponent > -32 && libm::ldexp(nesting.spacing_m, exponent) > smallest_m / 3.0 {
            exponent -= 1;
        }
        let closed = nesting.coarse.columns_around.map(|columns| {
            let samples = I64Vec2::new(columns, rows_between_poles(&nesting.coarse));
            if exponent < 0 {
                samples << -exponent
            } else {
                samples >> exponent
            }
        });
        Self { exponent, closed }
    }

    /// Samples from patch to patch after some doublings; an even number.
    fn apart(&self, doublings: u32) -> Option<i64> {
        let exponent = doublings as i32 + self.exponent;
        (1..=40).contains(&exponent).then(|| 1 << exponent)
    }

    fn place(&self, column: i64, row: i64) -> Place {
        let Some(around) = self.closed else {
            return Place {
                column,
                row,
                mirrored: false,
            };
        };
        let phase = row.rem_euclid(2 * around.y);
        let mirrored = phase >= around.y;
        let (row, column) = if mirrored {
            (2 * around.y - 1 - phase, column + around.x / 2)
        } else {
            (phase, column)
        };
        Place {
            column: column.rem_euclid(around.x),
            row,
            mirrored,
        }
    }

    /// Half a step, by which every other row is moved east.
    fn moved(&self, row: i64) -> bool {
        self.place(0, row).row & 1 == 1
    }

    /// The centre of a patch, in coarse samples.
    fn centre(&self, column: i64, row: i64) -> DVec2 {
        let x = column as f64 + if self.moved(row) { 1.0 } else { 0.5 };
        let side = libm::ldexp(1.0, self.exponent);
        DVec2::new(x, row as f64 + 0.5) * side
    }
}

/// The first of the two patches of a row (or rows) between which a sample lies, and how many samples
/// the sample is beyond the first one's centre, minus ½.
fn between(sample: i64, apart: i64, moved: bool) -> (i64, i64) {
    let from = sample - apart / 2 - if moved { apart / 2 } else { 0 };
    (from.div_euclid(apart), from.rem_euclid(apart))
}

/// A line of samples onto which patches are added.
struct Line {
    /// Weighted light.
    light: Vec<[f32; 4]>,
    /// The sums of squares of weights.
    squares: Vec<f32>,
}

/// All patches that some samples need.
pub(super) struct Patches<'a> {
    choice: &'a Choice<'a>,
    nesting: &'a Nesting,
    centres: Centres,
    /// Columns and rows of patches.
    rect: SampleRect,
    /// Row by row.
    chosen: Vec<Option<Patch>>,
}

impl<'a> Patches<'a> {
    /// Chooses patches for colours that are refined over `steps`, from coarse to fine; `coarse` holds at
    /// least [`MARGIN`] samples more than the first on every side.
    pub(super) fn new(
        choice: &'a Choice<'a>,
        nesting: &'a Nesting,
        coarse: &Coarse,
        steps: &[SampleRect],
        cancel: &Cancel,
    ) -> Result<Self, RenderError> {
        let centres = Centres::new(nesting, choice.exemplars);
        let mut all = Self {
            choice,
            nesting,
            centres,
            rect: SampleRect::default(),
            chosen: Vec::new(),
        };
        // Later steps lie inside the first one that shows something.
        let first = (1..)
            .zip(steps)
            .find(|(doublings, _)| all.shows(*doublings));
        let Some((first, step)) = first else {
            return Ok(all);
        };
        let Some(apart) = centres.apart(first) else {
            return Ok(all);
        };
        let samples = covered(step);
        let (min, last) = (samples.min, samples.max - 1);
        all.rect = SampleRect::new(
            I64Vec2::new(
                between(min.x, apart, true).0,
                between(min.y, apart, false).0,
            ),
            I64Vec2::new(
                between(last.x, apart, false).0 + 2,
                between(last.y, apart, false).0 + 2,
            ),
        );
        let ground = Ground::new(&nesting.coarse, super::KIND)?;
        let mut shown = None;
        for row in all.rect.min.y..all.rect.max.y {
            if cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for column in all.rect.min.x..all.rect.max.x {
                let patch = all.choose(&ground, &mut shown, coarse, (column, row));
                all.chosen.push(patch);
            }
        }
        Ok(all)
    }

    /// Whether exemplars have something to show after some doublings.
    fn shows(&self, doublings: u32) -> bool {
        let spacing_m = self.spacing_m(doublings);
        let exemplars = self.choice.exemplars;
        self.centres.apart(doublings).is_some()
            && exemplars.iter().any(|e| e.mip(spacing_m).is_some())
    }

    fn spacing_m(&self, doublings: u32) -> f64 {
        libm::ldexp(self.nesting.spacing_m, -(doublings as i32))
    }

    /// Metres from coarse sample to coarse sample at a patch's centre, eastward and southward.
    fn step_m(&self, ground: &Ground, column: i64, row: i64) -> Option<DVec2> {
        let lattice = &self.nesting.coarse;
        let place = self.centres.place(column, row);
        let centre = self.centres.centre(place.column, place.row);
        if lattice.crs == GridCrs::Map {
            let plane = lattice.origin + centre * lattice.step;
            let colat_rad = MapPoint::new(plane.x, plane.y).normalised().colat_rad;
            return Some((self.choice.planet.metres_per_radian(colat_rad) * lattice.step).abs());
        }
        let nearest = centre.floor().as_i64vec2();
        let [column, row] = ground.steps_m(self.choice.planet, nearest)?;
        Some(DVec2::new(column.length(), row.length()))
    }

    /// The patch of a place, if there is one.
    fn choose(
        &self,
        ground: &Ground,
        shown: &mut Option<Arc<Shown>>,
        coarse: &Coarse,
        (column, row): (i64, i64),
    ) -> Option<Patch> {
        let (choice, exponent) = (self.choice, self.centres.exponent);
        let step_m = self.step_m(ground, column, row)?;
        let place = self.centres.place(column, row);
        let centre = self.centres.centre(column, row);
        let around = Around::new(coarse, centre, exponent, place.mirrored)?;
        // Mostly that of the patch before.
        let last = shown
            .take()
            .filter(|shown| shown.is_for(choice, step_m, exponent));
        let shown =
            shown.insert(last.unwrap_or_else(|| choice.kept.shown(choice, step_m, exponent)));
        let key = scrambled(scrambled(choice.seed).wrapping_add(place.row as u64));
        let key = scrambled(key.wrapping_add(place.column as u64));
        let south = if place.mirrored { -1.0 } else { 1.0 };
        choice.best(shown, &around, key, [step_m.x, step_m.y * south])
    }

    fn get(&self, column: i64, row: i64) -> Option<&Patch> {
        let from = I64Vec2::new(column, row) - self.rect.min;
        self.chosen[(from.y * self.rect.width() + from.x) as usize].as_ref()
    }

    /// The light of the patches on the samples `rect` after some doublings, less the mean of each;
    /// `None` if exemplars have nothing to show there.
    ///
    /// Patches are mixed with weights b² of which the variance stays the same, Σ b v / √Σ b²
    /// (\[HN18\]; \[Bur19\] for sharper weights).
    pub(super) fn light(&self, doublings: u32, rect: &SampleRect) -> Option<Field> {
        let apart = self.centres.apart(doublings)?;
        if !self.shows(doublings) || self.chosen.iter().all(Option::is_none) {
            return None;
        }
        let mut out = Field::new(*rect);
        let width = rect.width() as usize;
        let mut line = Line {
            light: vec![[0.0; 4]; width],
            squares: vec![0.0; width],
        };
        for y in rect.min.y..rect.max.y {
            line.light.fill([0.0; 4]);
            line.squares.fill(0.0);
            let (row, beyond) = between(y, apart, false);
            let beyond = beyond as f32 + 0.5;
            for (row, south) in [(row, beyond), (row + 1, beyond - apart as f32)] {
                let weight = 1.0 - south.abs() / apart as f32;
                if weight > LEAST_WEIGHT {
                    self.add_row(doublings, apart, (row, south, weight), rect, &mut line);
                }
            }
            let first = (y - rect.min.y) as usize * width;
            for (i, ([r, g, b, _], squares)) in line.light.iter().zip(&line.squares).enumerate() {
                let scale = 1.0 / squares.sqrt();
                out.set(first + i, [r * scale, g * scale, b * scale]);
            }
        }
        Some(out)
    }

    /// Adds a row of patches to a line of samples.
    fn add_row(
        &self,
        doublings: u32,
        apart: i64,
        (row, south, row_weight): (i64, f32, f32),
        rect: &SampleRect,
        line: &mut Line,
    ) {
        let moved = self.centres.moved(row);
        let spacing_m = self.spacing_m(doublings);
        let per_coarse = libm::ldexp(1.0, -(doublings as i32)) as f32;
        let per_apart = 1.0 / apart as f32;
        let mut x = rect.min.x;
        while x < rect.max.x {
            // Samples up to the next centre lie between the same two patches.
            let (column, beyond) = between(x, apart, moved);
            let end = (x + apart - beyond).min(rect.max.x);
            let span = (x - rect.min.x) as usize..(end - rect.min.x) as usize;
            let (sums, squares) = (&mut line.light[span.clone()], &mut line.squares[span]);
            for (column, from) in [(column, beyond), (column + 1, beyond - apart)] {
                let shown = self.get(column, row).and_then(|patch| {
                    let exemplar = &self.choice.exemplars[patch.exemplar];
                    Some((patch, exemplar.reader(exemplar.mip(spacing_m)?)))
                });
                for (i, (sum, squares)) in sums.iter_mut().zip(&mut *squares).enumerate() {
                    let east = (from + i as i64) as f32 + 0.5;
                    let weight = row_weight * (1.0 - east.abs() * per_apart) - LEAST_WEIGHT;
                    if weight <= 0.0 {
                        continue;
                    }
                    let weight = weight * weight;
                    if let Some((patch, reader)) = &shown {
                        let from_centre = [east * per_coarse, south * per_coarse];
                        let light = reader.light(patch.at(from_centre, reader.per_metre));
                        // The gain of alpha is 0.
                        for c in 0..4 {
                            sum[c] += weight * (patch.gain[c] * (light[c] - patch.mean[c]));
                        }
                    }
                    *squares += weight * weight;
                }
            }
            x = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn from_beyond_a_pole_or_around_the_planet_the_same_patches_are_found(
            exponent in -3..3_i32, x in -400..400_i64, y in -300..300_i64,
        ) {
            let samples = I64Vec2::new(256, 128);
            let closed = if exponent < 0 { samples << -exponent } else { samples >> exponent };
            let centres = Centres { exponent, closed: Some(closed) };
            let doublings = 4_u32;
            let fine = samples << doublings;
            let apart = centres.apart(doublings).expect("even");
            // Its own name inside the lattice.
            let mut inside = I64Vec2::new(x, y.rem_euclid(2 * fine.y));
            let mirrored = inside.y >= fine.y;
            if mirrored {
                inside = I64Vec2::new(x + fine.x / 2, 2 * fine.y - 1 - inside.y);
            }
            inside.x = inside.x.rem_euclid(fine.x);
            let found = |x: i64, y: i64| {
                let (row, beyond_y) = between(y, apart, false);
                let mut all = Vec::new();
                for (row, dy) in [(row, 2 * beyond_y + 1), (row + 1, 2 * (beyond_y - apart) + 1)] {
                    let (column, beyond_x) = between(x, apart, centres.moved(row));
                    for (column, dx) in [(column, beyond_x), (column + 1, beyond_x - apart)] {
                        let place = centres.place(column, row);
                        let dy = if place.mirrored { -dy } else { dy };
                        all.push((place.row, place.column, dx, dy));
                    }
                }
                all.sort_unstable();
                all
            };
            prop_assert_eq!(found(x, y), found(inside.x, inside.y));
        }

        #[test]
        fn a_sample_lies_between_the_centres_that_are_named_for_it(
            sample in -1000..1000_i64, exponent in 1..6_u32, moved: bool,
        ) {
            let apart = 1_i64 << exponent;
            let (first, beyond) = between(sample, apart, moved);
            let centre = first as f64 + if moved { 1.0 } else { 0.5 };
            prop_assert_eq!(sample as f64 + 0.5 - centre * apart as f64, beyond as f64 + 0.5);
            prop_assert!((0..apart).contains(&beyond));
        }
    }

    #[test]
    fn some_patch_has_weight_everywhere() {
        let mut least = 1.0_f32;
        for i in 0..=100_u8 {
            for k in 0..=100_u8 {
                let (east, south) = (f32::from(i) / 100.0, f32::from(k) / 100.0);
                // The next row is moved by half.
                let next = (east + 0.5).fract();
                let across = |east: f32| east.max(1.0 - east);
                let largest = (across(east) * (1.0 - south)).max(across(next) * south);
                least = least.min(largest);
            }
        }
        assert!(least > LEAST_WEIGHT + 0.1, "{least}");
    }
}
