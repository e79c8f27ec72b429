//! Which piece of which exemplar is laid around a place.

use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use parking_lot::Mutex;
use relievo_planet::{Planet, SampleRect};
use relievo_raster::colour::linear_from_srgb;

use super::super::noise::scrambled;
use super::coarse::Coarse;
use super::exemplar::{Exemplar, Reduced};

/// Pieces that are tried at a place, shared among the exemplars.
const CANDIDATES: usize = 256;

/// Pieces that are tried of every exemplar, however many there are.
const LEAST_CANDIDATES: usize = 32;

/// Detail is at most this much stronger than in the exemplar, where the coarse colour is brighter.
const MOST_GAIN: f32 = 4.0;

/// Steps to an octave in which the ratio of a sample's sides is counted, so that neighbouring places
/// share reduced exemplars: the sides are met to about a hundredth.
const STEPS_TO_AN_OCTAVE: f64 = 32.0;

/// Most that a side of a sample is longer than the other one while pieces are compared.
const MOST_CROWDED: f64 = 4.0;

/// Sizes of coarse samples for which reduced exemplars are kept: those of neighbouring latitudes.
const MOST_KEPT: usize = 8;

/// What decides which patches lie where.
pub(super) struct Choice<'a> {
    pub(super) planet: &'a Planet,
    pub(super) exemplars: &'a [Arc<Exemplar>],
    pub(super) seed: u64,
    pub(super) strength: f32,
    pub(super) tolerance: f32,
    pub(super) kept: &'a Kept,
}

/// Reduced exemplars that tiles share; what is kept decides how long a tile takes and nothing else.
#[derive(Debug, Default)]
pub(super) struct Kept(Mutex<Vec<Arc<Shown>>>);

impl Kept {
    /// The exemplars as coarse samples of the size `step_m` would show them.
    pub(super) fn shown(&self, choice: &Choice, step_m: DVec2, exponent: i32) -> Arc<Shown> {
        let is_it = |shown: &&Arc<Shown>| shown.is_for(step_m, exponent);
        if let Some(shown) = self.0.lock().iter().find(is_it) {
            return Arc::clone(shown);
        }
        // Not while others wait; two that make the same make the same.
        let new = Arc::new(Shown::new(choice, step_m, exponent));
        let mut kept = self.0.lock();
        kept.insert(0, Arc::clone(&new));
        kept.truncate(MOST_KEPT);
        new
    }
}

/// A piece of an exemplar, laid around a centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub(super) exemplar: usize,
    /// Where the centre is in the exemplar, from its north-west corner.
    centre_m: [f32; 2],
    /// From coarse sample to coarse sample in the exemplar, eastward and southward; southward is
    /// negative beyond a pole.
    step_m: [f32; 2],
    /// What is subtracted from the exemplar's light.
    pub(super) mean: [f32; 4],
    /// What the rest is multiplied by.
    pub(super) gain: [f32; 4],
}

impl Patch {
    /// Where in its exemplar, in samples of a resolution, a place is shown that lies so many coarse
    /// samples from the centre.
    #[inline(always)]
    pub(super) fn at(&self, from_centre: [f32; 2], per_metre: f32) -> [f32; 2] {
        [
            (self.centre_m[0] + from_centre[0] * self.step_m[0]) * per_metre,
            (self.centre_m[1] + from_centre[1] * self.step_m[1]) * per_metre,
        ]
    }
}

/// A coarse colour with which a piece is compared.
struct Wanted {
    /// The sample, from the first one south-east of the centre (or at it).
    column: i64,
    row: i64,
    light: [f32; 3],
}

/// The coarse colours around the centre of a patch.
pub(super) struct Around {
    samples: Vec<Wanted>,
    /// Of each sample, and alpha 1.
    encoded: Vec<[f32; 4]>,
    /// Mean of all, if all are there and there are several.
    mean: Option<[f32; 4]>,
}

/// Coarse samples to either side with which a piece is compared, where patches are 2^`exponent` coarse
/// samples apart; 0 is only the sample at the centre.
fn half(exponent: i32) -> i64 {
    // Centres that are several samples apart lie on corners of samples.
    match exponent {
        2.. => 3,
        1 => 2,
        _ => 0,
    }
}

impl Around {
    /// Around a centre in coarse samples; `None` where there is nothing. Beyond a pole rows are
    /// mirrored.
    pub(super) fn new(
        coarse: &Coarse,
        centre: DVec2,
        exponent: i32,
        mirrored: bool,
    ) -> Option<Self> {
        let half = half(exponent);
        let nearest = centre.floor().as_i64vec2();
        let rect = SampleRect::new(nearest - half, nearest + half.max(1));
        let mut samples = Vec::with_capacity(rect.area() as usize);
        let mut encoded = Vec::with_capacity(rect.area() as usize);
        let mut sum = [0.0; 4];
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let sample = I64Vec2::new(x, y);
                let at = coarse.at(sample);
                if coarse.there[at] {
                    let [r, g, b] = coarse.encoded[at];
                    let row = y - nearest.y;
                    samples.push(Wanted {
                        column: x - nearest.x,
                        row: if mirrored && half > 0 { -1 - row } else { row },
                        light: coarse.light.get(at),
                    });
                    encoded.push([r, g, b, 1.0]);
                    for (sum, v) in sum.iter_mut().zip([r, g, b, 1.0]) {
                        *sum += v;
                    }
                }
            }
        }
        let count = samples.len() as f32;
        let all = half > 0 && samples.len() == rect.area() as usize;
        (!samples.is_empty()).then_some(Self {
            samples,
            encoded,
            mean: all.then(|| sum.map(|v| v / count)),
        })
    }
}

/// The exemplars as coarse samples of some size would show them.
#[derive(Debug)]
pub(super) struct Shown {
    /// From sample to sample.
    step_m: DVec2,
    exponent: i32,
    /// Samples from the centre of a patch to its border.
    reach: i64,
    half: i64,
    exemplars: Vec<Reduced>,
}

impl Shown {
    /// The sides of samples as they are counted, from those of coarse samples. Where patches are
    /// nearer together than coarse samples, they are compared at that distance.
    fn counted(step_m: DVec2, exponent: i32) -> DVec2 {
        let scale = libm::ldexp(1.0, exponent.min(0));
        let counted = |v: f64| {
            let steps = libm::round(libm::log2(v) * STEPS_TO_AN_OCTAVE);
            libm::exp2(steps / STEPS_TO_AN_OCTAVE) * scale
        };
        // Next to a pole columns crowd; there, pieces are compared as if they crowded less.
        let least_m = step_m.max_element() / MOST_CROWDED;
        DVec2::new(
            counted(step_m.x.max(least_m)),
            counted(step_m.y.max(least_m)),
        )
    }

    /// Whether it is what such coarse samples would show.
    pub(super) fn is_for(&self, step_m: DVec2, exponent: i32) -> bool {
        self.exponent == exponent && self.step_m == Self::counted(step_m, exponent)
    }

    fn new(choice: &Choice, step_m: DVec2, exponent: i32) -> Self {
        let half = half(exponent);
        let step_m = Self::counted(step_m, exponent);
        let least = (2 * half).max(1) as usize;
        let reduce =
            |exemplar: &Arc<Exemplar>| exemplar.reduced(step_m.to_array(), least, half as usize);
        Self {
            step_m,
            exponent,
            reach: 1 << exponent.max(0),
            half,
            exemplars: choice.exemplars.iter().map(reduce).collect(),
        }
    }

    /// A place from 0 on along a side of so many samples, by chance: as far from the ends as a patch
    /// reaches, or in the middle.
    fn drawn(&self, side: usize, chance: u64) -> i64 {
        // Between samples there is one place more than samples.
        let places = side as i64 + i64::from(self.half > 0);
        let (first, last) = (self.reach, places - 1 - self.reach);
        if first > last {
            return (places - 1) / 2;
        }
        first + (((chance & 0xFFFF_FFFF) * (last - first + 1) as u64) >> 32) as i64
    }
}

impl Reduced {
    /// What is added to the index of a place for the index of each of the samples around it.
    fn offsets(&self, around: &Around) -> Vec<isize> {
        let offset =
            |sample: &Wanted| sample.row as isize * self.width as isize + sample.column as isize;
        around.samples.iter().map(offset).collect()
    }

    /// Whether the sum of squared differences to the colours around a place is `limit` or more, as far
    /// as means tell: it is at least their squared difference, so many times.
    #[inline]
    fn is_far(&self, at: usize, around: &Around, limit: f32) -> bool {
        let Some(mean) = &around.mean else {
            return false;
        };
        let shown = &self.means[at];
        let squares: f32 = (0..3)
            .map(|c| (shown[c] - mean[c]) * (shown[c] - mean[c]))
            .sum();
        squares * around.encoded.len() as f32 >= limit
    }

    /// Sum of squared differences to the colours around a place, if it is below `limit`.
    #[inline]
    fn difference(&self, at: usize, offsets: &[isize], around: &Around, limit: f32) -> Option<f32> {
        /// Samples after which the sum is looked at.
        const STRIDE: usize = 6;
        let mut sums = [0.0_f32; 4];
        let mut sum = 0.0;
        for (offsets, wanted) in offsets.chunks(STRIDE).zip(around.encoded.chunks(STRIDE)) {
            for (offset, wanted) in offsets.iter().zip(wanted) {
                let shown = self.encoded[at.wrapping_add_signed(*offset)];
                for c in 0..4 {
                    let off = shown[c] - wanted[c];
                    sums[c] += off * off;
                }
            }
            sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            if sum >= limit {
                return None;
            }
        }
        Some(sum)
    }

    #[inline(always)]
    fn at(&self, column: i64, row: i64) -> usize {
        row as usize * self.width + column as usize
    }
}

impl Choice<'_> {
    /// The best of some pieces that chance names by `key`, for samples of the size `step_m` in metres;
    /// `None` where even that is too far from the coarse colours.
    pub(super) fn best(
        &self,
        shown: &Shown,
        around: &Around,
        key: u64,
        step_m: [f64; 2],
    ) -> Option<Patch> {
        let exemplars = shown.exemplars.len();
        let each = (CANDIDATES / exemplars).max(LEAST_CANDIDATES);
        let mut best = (f32::INFINITY, 0, 0, 0);
        for (exemplar, reduced) in shown.exemplars.iter().enumerate() {
            let offsets = reduced.offsets(around);
            for candidate in 0..each {
                let number = exemplar * each + candidate;
                let chance = scrambled(key.wrapping_add(number as u64));
                let column = shown.drawn(reduced.width, chance >> 32);
                let row = shown.drawn(reduced.height, chance);
                let at = reduced.at(column, row);
                if reduced.is_far(at, around, best.0) {
                    continue;
                }
                if let Some(difference) = reduced.difference(at, &offsets, around, best.0) {
                    best = (difference, exemplar, column, row);
                }
            }
        }
        let (_, exemplar, column, row) = best;
        let centre = if shown.half > 0 { 0.0 } else { 0.5 };
        let centre_m = [
            (column as f64 + centre) * shown.step_m.x,
            (row as f64 + centre) * shown.step_m.y,
        ];
        let (mean, gain) = self.matched(&shown.exemplars[exemplar], column, row, around)?;
        Some(Patch {
            exemplar,
            centre_m: centre_m.map(|v| v as f32),
            step_m: step_m.map(|v| v as f32),
            mean,
            gain,
        })
    }

    /// The mean light of a piece, and how much stronger it is made; `None` for not at all.
    fn matched(
        &self,
        reduced: &Reduced,
        column: i64,
        row: i64,
        around: &Around,
    ) -> Option<([f32; 4], [f32; 4])> {
        let per_sample = 1.0 / around.samples.len() as f32;
        let (mut off, mut wanted, mut mean) = ([0.0; 3], [0.0; 3], [0.0; 4]);
        for (sample, encoded) in around.samples.iter().zip(&around.encoded) {
            let at = reduced.at(column + sample.column, row + sample.row);
            for c in 0..3 {
                off[c] += (reduced.encoded[at][c] - encoded[c]) * per_sample;
                wanted[c] += sample.light[c] * per_sample;
                mean[c] += linear_from_srgb(reduced.encoded[at][c]) * per_sample;
            }
        }
        let off = off.iter().map(|v| v * v).sum::<f32>().sqrt();
        let amount = self.strength * near(off, self.tolerance);
        let mut gain = [0.0; 4];
        for c in 0..3 {
            // As dark soil is a darker pattern and not a fainter one: in proportion to the light.
            let ratio = wanted[c] / mean[c].max(1e-3);
            gain[c] = amount * ratio.clamp(0.0, MOST_GAIN);
        }
        (amount > 0.0).then_some((mean, gain))
    }
}

/// 1 for colours no further apart than `tolerance`, falling smoothly to 0 at twice that.
fn near(off: f32, tolerance: f32) -> f32 {
    if off <= tolerance {
        return 1.0;
    }
    let t = (2.0 - off / tolerance).max(0.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_raster::{Bands, Block};

    use super::*;

    fn exemplar() -> Arc<Exemplar> {
        let mut colours = Block::filled(Bands::Colour, 64, 48, &[0.0, 0.4, 0.6, 1.0]);
        for (i, v) in colours.plane_mut(0).iter_mut().enumerate() {
            *v = (scrambled(i as u64) >> 40) as f32 / 16_777_216.0;
        }
        Arc::new(Exemplar::new(&colours, 1.0).expect("colours"))
    }

    fn choice<'a>(exemplars: &'a [Arc<Exemplar>], kept: &'a Kept) -> Choice<'a> {
        Choice {
            kept,
            planet: &Planet::EARTH,
            exemplars,
            seed: 1,
            strength: 1.0,
            tolerance: f32::INFINITY,
        }
    }

    #[test]
    fn a_piece_that_is_there_exactly_is_found_when_chance_names_it() {
        let exemplars = [exemplar()];
        let kept = Kept::default();
        let choice = choice(&exemplars, &kept);
        let shown = Shown::new(&choice, DVec2::splat(2.0), 1);
        // 32 × 24 reduced samples, between which 29 × 21 places can be drawn.
        let reduced = &shown.exemplars[0];
        let mut found = 0;
        for key in 0..40_u64 {
            let (column, row) = (2 + key as i64 % 29, 2 + key as i64 / 3);
            let samples = (-2..2_i64).flat_map(|dy| (-2..2_i64).map(move |dx| (dx, dy)));
            let (samples, encoded): (Vec<_>, Vec<_>) = samples
                .map(|(dx, dy)| {
                    let at = reduced.at(column + dx, row + dy);
                    let [r, g, b, _] = reduced.encoded[at].map(linear_from_srgb);
                    let wanted = Wanted {
                        column: dx,
                        row: dy,
                        light: [r, g, b],
                    };
                    (wanted, reduced.encoded[at])
                })
                .unzip();
            let mean = reduced.means[reduced.at(column, row)];
            let sum = encoded.iter().map(|v| v[0]).sum::<f32>();
            assert!((mean[0] - sum / 16.0).abs() < 1e-6);
            let around = Around {
                samples,
                encoded,
                mean: Some(mean),
            };
            let patch = choice
                .best(&shown, &around, key << 20, [2.0, 2.0])
                .expect("any distance");
            if patch.centre_m == [column as f32 * 2.0, row as f32 * 2.0] {
                found += 1;
                assert!(patch.gain[..3].iter().all(|g| (g - 1.0).abs() < 1e-5));
            }
        }
        // 256 of 609 places are tried.
        assert!((8..28).contains(&found), "{found}");
    }

    #[test]
    fn what_is_kept_is_what_was_asked_for() {
        let exemplars = [exemplar()];
        let kept = Kept::default();
        let choice = choice(&exemplars, &kept);
        for round in 0..3 {
            for step in 0..20 {
                let step_m = DVec2::new(2.0 + f64::from(step) * 0.1, 3.0);
                for exponent in [0, 2] {
                    let shown = kept.shown(&choice, step_m, exponent);
                    let new = Shown::new(&choice, step_m, exponent);
                    assert_eq!(
                        shown.exemplars[0].encoded, new.exemplars[0].encoded,
                        "{round}"
                    );
                    assert_eq!((shown.reach, shown.half), (new.reach, new.half));
                    assert!(Arc::ptr_eq(&shown, &kept.shown(&choice, step_m, exponent)));
                }
            }
        }
        assert_eq!(kept.0.lock().len(), MOST_KEPT);
    }

    proptest! {
        #[test]
        fn places_are_drawn_where_a_patch_fits(side in 1..200_usize, chance: u64, exponent in -3..3_i32) {
            let exemplars = [exemplar()];
            let kept = Kept::default();
            let shown = Shown::new(&choice(&exemplars, &kept), DVec2::splat(6.0), exponent);
            let place = shown.drawn(side, chance);
            let end = if exponent > 0 { side as i64 } else { side as i64 - 1 };
            prop_assert!((0..=end).contains(&place));
            prop_assert!(end < 2 * shown.reach || (shown.reach..=end - shown.reach).contains(&place));
        }
    }

    #[test]
    fn patches_fade_as_colours_leave_them() {
        assert_eq!(near(0.1, 0.1), 1.0);
        assert_eq!(near(0.2, 0.1), 0.0);
        assert!((near(0.15, 0.1) - 0.5).abs() < 1e-6);
        assert_eq!(near(9.0, f32::INFINITY), 1.0);
        assert_eq!((near(0.0, 0.0), near(0.1, 0.0)), (1.0, 0.0));
    }
}
