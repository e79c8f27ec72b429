//! Noise as detail: at every halving white noise that coarser samples do not show, as strong as the coarse
//! colours' contrast goes on.

use glam::I64Vec2;
use relievo_planet::SampleRect;

use super::super::noise::scrambled;
use super::coarse::{Nesting, rows_between_poles};
use super::field::{Field, above_smooth, around, covered, quad, reduced};
use super::survey::Contrast;

/// The mean square of what white noise of variance 1 is above the smooth refinement of its own means:
/// 1 − ¼ of the means, and of their neighbours 2 · 2 / 8² + 4 / 64² times ¼ each.
const ABOVE_SMOOTH: f32 = 0.765_869_14;

/// Adds noise to colours that are refined.
pub(super) struct Grain<'a> {
    contrast: &'a Contrast,
    strength: f32,
    seed: u64,
    /// Columns and rows of the coarse lattice, where it closes.
    closed: Option<I64Vec2>,
}

impl<'a> Grain<'a> {
    pub(super) fn new(contrast: &'a Contrast, nesting: &Nesting, strength: f32, seed: u64) -> Self {
        let closed = nesting
            .coarse
            .columns_around
            .map(|columns| I64Vec2::new(columns, rows_between_poles(&nesting.coarse)));
        Self {
            contrast,
            strength,
            seed,
            closed,
        }
    }

    /// Colours after `doublings` refined once more; of all samples but the outermost.
    ///
    /// All channels change in proportion to the light: brightness varies, hue stays.
    pub(super) fn refined(&self, light: &Field, doublings: u32) -> Field {
        let stride = light.rect().width() as usize;
        let noise = self.white(&covered(&light.rect()), doublings + 1);
        let means = reduced(&noise, 2 * stride);
        let contrast = self.contrast.of(&light.rect(), doublings);
        let scale = self.strength / ABOVE_SMOOTH.sqrt();
        light.refined_by(Some(&|at: usize| {
            let noise = above_smooth(quad(&noise, stride, at), &around(&means, stride, at));
            let contrast = scale * contrast[at];
            let light = light.get(at);
            core::array::from_fn(|plane| noise.map(|v| v * (contrast * light[plane])))
        }))
    }

    /// Noise of variance 1 after some doublings, by the samples' own names: around the planet and from
    /// beyond a pole the same sample has the same value.
    fn white(&self, rect: &SampleRect, doublings: u32) -> Vec<f32> {
        let closed = self.closed.map(|samples| samples << doublings);
        let key = scrambled(scrambled(self.seed).wrapping_add(u64::from(doublings)));
        let mut all = Vec::with_capacity(rect.area() as usize);
        for y in rect.min.y..rect.max.y {
            let (mut row, mut first) = (y, rect.min.x);
            if let Some(around) = closed {
                let phase = y.rem_euclid(2 * around.y);
                row = phase;
                if phase >= around.y {
                    row = 2 * around.y - 1 - phase;
                    first += around.x / 2;
                }
                first = first.rem_euclid(around.x);
            }
            let key = scrambled(key.wrapping_add(row as u64));
            let mut column = first;
            for _ in 0..rect.width() {
                all.push(normal(scrambled(key.wrapping_add(column as u64))));
                column += 1;
                if closed.is_some_and(|around| column == around.x) {
                    column = 0;
                }
            }
        }
        all
    }
}

/// About a normal variable of variance 1 from 64 random bits: the sum of four numbers.
#[inline(always)]
fn normal(bits: u64) -> f32 {
    /// Four numbers from 0 to 2¹⁶ have a variance of 4 · 2³² / 12.
    const SCALE: f32 = 1.732_050_8 / 65_536.0;
    let part = |k: u32| (bits >> (16 * k)) as u32 & 0xFFFF;
    let sum = (part(0) + part(1)) + (part(2) + part(3));
    (sum as f32 - 131_070.0) * SCALE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_of_a_halving_has_the_energy_that_it_is_divided_by() {
        let (mut sum, mut squares, mut above) = (0.0, 0.0, 0.0);
        let side = 512;
        let noise: Vec<f32> = (0..side * side)
            .map(|i| normal(scrambled(i as u64)))
            .collect();
        for v in &noise {
            sum += f64::from(*v);
            squares += f64::from(v * v);
        }
        let count = noise.len() as f64;
        assert!((sum / count).abs() < 0.01);
        assert!((squares / count - 1.0).abs() < 0.01, "{}", squares / count);
        let (half, mut count) = (side / 2, 0.0);
        let means = reduced(&noise, side);
        for y in 1..half - 1 {
            for x in 1..half - 1 {
                let at = y * half + x;
                let quad = above_smooth(quad(&noise, half, at), &around(&means, half, at));
                above += quad.iter().map(|v| f64::from(v * v)).sum::<f64>();
                count += 4.0;
            }
        }
        let found = above / count;
        assert!(
            (found / f64::from(ABOVE_SMOOTH) - 1.0).abs() < 0.01,
            "{found}"
        );
    }

    #[test]
    fn from_beyond_a_pole_or_around_the_planet_a_sample_has_the_same_noise() {
        let contrast = Contrast::default();
        let grain = Grain {
            contrast: &contrast,
            strength: 1.0,
            seed: 7,
            closed: Some(I64Vec2::new(64, 32)),
        };
        // After a doubling 128 by 64 samples.
        let all = grain.white(&SampleRect::at(0, 0, 128, 64), 1);
        let beyond = grain.white(&SampleRect::at(-70, -5, 300, 80), 1);
        for (i, v) in beyond.iter().enumerate() {
            let (x, y) = (i as i64 % 300 - 70, i as i64 / 300 - 5);
            let (x, y) = match y {
                ..0 => (x + 64, -1 - y),
                64.. => (x + 64, 127 - y),
                _ => (x, y),
            };
            let inside = all[(y * 128 + x.rem_euclid(128)) as usize];
            assert_eq!(v.to_bits(), inside.to_bits(), "{x} {y}");
        }
        let distinct: std::collections::BTreeSet<u32> = all.iter().map(|v| v.to_bits()).collect();
        assert!(distinct.len() > 7000, "{}", distinct.len());
    }
}
