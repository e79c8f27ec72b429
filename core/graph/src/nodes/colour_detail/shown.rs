//! Exemplars as coarse samples would show them, which is how they are compared with coarse colours.

use core::ptr;
use std::sync::{Arc, Weak};

use glam::DVec2;
use parking_lot::Mutex;

use super::around::{Around, Wanted, half};
use super::choice::Choice;
use super::exemplar::Exemplar;

/// Steps to an octave in which the ratio of a sample's sides is counted, so that neighbouring places
/// share reduced exemplars: the sides are met to about a hundredth.
const STEPS_TO_AN_OCTAVE: f64 = 32.0;

/// Most that a side of a sample is longer than the other one while pieces are compared.
const MOST_CROWDED: f64 = 4.0;

/// Sizes of coarse samples for which reduced exemplars are kept: those of neighbouring latitudes.
const MOST_KEPT: usize = 4;

/// Reduced exemplars that tiles share; what is kept decides how long a tile takes and nothing else.
#[derive(Debug, Default)]
pub(super) struct Kept(Mutex<Vec<Arc<Shown>>>);

impl Kept {
    /// The exemplars as coarse samples of the size `step_m` would show them.
    pub(super) fn shown(&self, choice: &Choice, step_m: DVec2, exponent: i32) -> Arc<Shown> {
        let is_it = |shown: &&Arc<Shown>| shown.is_for(choice, step_m, exponent);
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

/// The exemplars as coarse samples of some size would show them.
#[derive(Debug)]
pub(super) struct Shown {
    /// From sample to sample, as they are counted.
    step_m: DVec2,
    exponent: i32,
    /// Which keeps them from being mistaken for others, but not in memory.
    of: Vec<Weak<Exemplar>>,
    /// Samples from the centre of a patch to its border.
    reach: i64,
    pub(super) half: i64,
    pub(super) exemplars: Vec<Reduced>,
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

    /// Whether it is what such coarse samples would show of the same exemplars.
    pub(super) fn is_for(&self, choice: &Choice, step_m: DVec2, exponent: i32) -> bool {
        let pairs = self.of.iter().zip(choice.exemplars);
        self.exponent == exponent
            && self.step_m == Self::counted(step_m, exponent)
            && self.of.len() == choice.exemplars.len()
            && pairs.fold(true, |same, (a, b)| {
                same & ptr::eq(a.as_ptr(), Arc::as_ptr(b))
            })
    }

    pub(super) fn new(choice: &Choice, step_m: DVec2, exponent: i32) -> Self {
        let half = half(exponent);
        let step_m = Self::counted(step_m, exponent);
        let least = (2 * half).max(1) as usize;
        let reduce = |exemplar: &Arc<Exemplar>| {
            // Single samples are compared; more than the exemplar has would be for nothing.
            let finest_m = if half == 0 { exemplar.spacing_m() } else { 0.0 };
            let step_m = step_m.max(DVec2::splat(finest_m));
            Reduced::new(exemplar, step_m.to_array(), least, half as usize)
        };
        Self {
            step_m,
            exponent,
            of: choice.exemplars.iter().map(Arc::downgrade).collect(),
            reach: 1 << exponent.max(0),
            half,
            exemplars: choice.exemplars.iter().map(reduce).collect(),
        }
    }

    /// A place from 0 on along a side of so many samples, by chance: as far from the ends as a patch
    /// reaches, or in the middle.
    pub(super) fn drawn(&self, side: usize, chance: u64) -> i64 {
        // Between samples there is one place more than samples.
        let places = side as i64 + i64::from(self.half > 0);
        let (first, last) = (self.reach, places - 1 - self.reach);
        if first > last {
            return (places - 1) / 2;
        }
        first + (((chance & 0xFFFF_FFFF) * (last - first + 1) as u64) >> 32) as i64
    }
}

/// An exemplar as coarse samples would show it.
#[derive(Debug)]
pub(super) struct Reduced {
    /// From sample to sample.
    pub(super) step_m: [f64; 2],
    pub(super) width: usize,
    pub(super) height: usize,
    /// Red, green, blue as the eye has them, nearly: encoded; and alpha 1.
    pub(super) encoded: Vec<[f32; 4]>,
    /// Means of what is encoded over as many columns and rows before each sample as from it on, where
    /// they are there.
    pub(super) means: Vec<[f32; 4]>,
}

impl Reduced {
    /// Samples of some size, as many as fit but at least `least` along a side; with means over `half`
    /// samples to either side.
    fn new(exemplar: &Exemplar, step_m: [f64; 2], least: usize, half: usize) -> Self {
        let spacing_m = (step_m[0] * step_m[1]).sqrt();
        let reader = exemplar.reader(exemplar.mip(spacing_m).unwrap_or(0));
        let extent_m = exemplar.extent_m();
        let [width, height] = [0, 1].map(|axis| {
            // Not one less for rounding.
            let fit = libm::floor(extent_m[axis] / step_m[axis] + 1e-6);
            (fit as usize).max(least)
        });
        let step = step_m.map(|step_m| step_m as f32 * reader.per_metre);
        let mut encoded = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let at = [column, row].map(|i| i as f32 + 0.5);
                encoded.push(reader.encoded([at[0] * step[0], at[1] * step[1]]));
            }
        }
        Self {
            step_m,
            width,
            height,
            means: means(&encoded, width, half),
            encoded,
        }
    }

    /// What is added to the index of a place for the index of each of the samples around it.
    pub(super) fn offsets(&self, around: &Around) -> Vec<isize> {
        let offset =
            |sample: &Wanted| sample.row as isize * self.width as isize + sample.column as isize;
        around.samples.iter().map(offset).collect()
    }

    /// Whether the sum of squared differences to the colours around a place is `limit` or more, as far
    /// as means tell: it is at least their squared difference, so many times.
    #[inline]
    pub(super) fn is_far(&self, at: usize, around: &Around, limit: f32) -> bool {
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
    pub(super) fn difference(
        &self,
        at: usize,
        offsets: &[isize],
        around: &Around,
        limit: f32,
    ) -> Option<f32> {
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

    /// Where a sample is kept, or the place at its north-west corner.
    #[inline(always)]
    pub(super) fn at(&self, column: i64, row: i64) -> usize {
        row as usize * self.width + column as usize
    }
}

/// Means over `half` columns and rows to either side of each sample's north-west corner, along rows and
/// then along columns; meaningless where they do not fit.
fn means(samples: &[[f32; 4]], width: usize, half: usize) -> Vec<[f32; 4]> {
    let along = |samples: &[[f32; 4]], stride: usize| -> Vec<[f32; 4]> {
        let scale = 1.0 / (2 * half).max(1) as f32;
        let mean = |at: usize| {
            let (Some(first), end) = (at.checked_sub(half * stride), at + half * stride) else {
                return samples[at];
            };
            if end > samples.len() {
                return samples[at];
            }
            let mut sum = [0.0; 4];
            for at in (first..end).step_by(stride) {
                for (sum, v) in sum.iter_mut().zip(samples[at]) {
                    *sum += v * scale;
                }
            }
            sum
        };
        (0..samples.len()).map(mean).collect()
    };
    if half == 0 {
        return samples.to_vec();
    }
    along(&along(samples, 1), width)
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;
    use relievo_planet::Planet;
    use relievo_raster::{Bands, Block};

    use super::super::super::noise::scrambled;
    use super::*;

    pub(crate) fn exemplar() -> Arc<Exemplar> {
        let mut colours = Block::filled(Bands::Colour, 64, 48, &[0.0, 0.4, 0.6, 1.0]);
        for (i, v) in colours.plane_mut(0).iter_mut().enumerate() {
            *v = (scrambled(i as u64) >> 40) as f32 / 16_777_216.0;
        }
        Arc::new(Exemplar::new(&colours, 1.0).expect("colours"))
    }

    pub(crate) fn choice<'a>(exemplars: &'a [Arc<Exemplar>], kept: &'a Kept) -> Choice<'a> {
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
}
