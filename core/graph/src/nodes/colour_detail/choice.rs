//! Which piece of which exemplar is laid around a place.

use std::sync::Arc;

use relievo_planet::Planet;
use relievo_raster::colour::linear_from_srgb;

use super::super::noise::scrambled;
use super::around::Around;
use super::exemplar::Exemplar;
use super::shown::{Kept, Reduced, Shown};

/// Pieces that are tried at a place, shared among the exemplars.
const CANDIDATES: usize = 256;

/// Pieces that are tried of every exemplar, however many there are.
const LEAST_CANDIDATES: usize = 32;

/// Detail is at most this much stronger than in the exemplar, where the coarse colour is brighter.
const MOST_GAIN: f32 = 4.0;

/// What decides which patches lie where.
pub(super) struct Choice<'a> {
    pub(super) planet: &'a Planet,
    pub(super) exemplars: &'a [Arc<Exemplar>],
    pub(super) seed: u64,
    pub(super) strength: f32,
    pub(super) tolerance: f32,
    pub(super) kept: &'a Kept,
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
        let reduced = &shown.exemplars[exemplar];
        let centre = if shown.half > 0 { 0.0 } else { 0.5 };
        let centre_m = [
            (column as f64 + centre) * reduced.step_m[0],
            (row as f64 + centre) * reduced.step_m[1],
        ];
        let (mean, gain) = self.matched(reduced, column, row, around)?;
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
    use glam::DVec2;

    use super::super::around::Wanted;
    use super::super::shown::tests::{choice, exemplar};
    use super::*;

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
    fn patches_fade_as_colours_leave_them() {
        assert_eq!(near(0.1, 0.1), 1.0);
        assert_eq!(near(0.2, 0.1), 0.0);
        assert!((near(0.15, 0.1) - 0.5).abs() < 1e-6);
        assert_eq!(near(9.0, f32::INFINITY), 1.0);
        assert_eq!((near(0.0, 0.0), near(0.1, 0.0)), (1.0, 0.0));
    }
}
