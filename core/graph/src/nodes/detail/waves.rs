//! Spectral noise: octaves as sums of plane waves in space.

use core::f64::consts::TAU;

use crate::nodes::lanes::{LANES, Lanes};
use crate::nodes::noise::scrambled;

/// Waves of an octave.
const WAVES: u32 = 24;

/// 1.5 · 2⁵²: adding it rounds a float to the nearest integer.
const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// The exponent that an octave's own waves follow.
const TILT: f64 = 0.75;

/// A plane wave through space.
#[derive(Clone, Copy, Debug)]
struct Wave {
    /// Turns of its phase across a radius, axis by axis.
    turns: [f64; 3],
    phase: f64,
    height: f32,
}

/// An octave of plane waves: random directions and phases, lengths evenly spread over the octave, so that
/// it has no gaps and adds nothing to other octaves. Variance 1, 0 on average.
///
/// Sources: the spectral synthesis that \[CH07\] names (\[Ber03\]), and \[Sau88\]; waves are summed in space
/// instead of transformed on a lattice, so there is no period, no seam and no pole.
#[derive(Clone, Debug)]
pub(super) struct Waves {
    waves: Vec<Wave>,
}

impl Waves {
    /// Waves about 1 long where a radius is `scale`.
    pub(super) fn new(scale: f64, seed: u32) -> Self {
        let mut state = u64::from(seed);
        let mut random = || {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            (scrambled(state) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut order: Vec<u32> = (0..WAVES).collect();
        for i in (1..order.len()).rev() {
            let other = (random() * (i + 1) as f64) as usize;
            order.swap(i, other.min(i));
        }
        let n = f64::from(WAVES);
        let mut waves: Vec<Wave> = Vec::with_capacity(order.len());
        let mut square = 0.0;
        for (i, length) in order.into_iter().enumerate() {
            // Each in its own part of the octave and of the sphere.
            let length = libm::exp2((f64::from(length) + random()) / n - 0.5);
            let z = 2.0 * (i as f64 + random()) / n - 1.0;
            let (sin, cos) = libm::sincos(TAU * random());
            let across = (1.0 - z * z).sqrt();
            let height = libm::pow(length, TILT);
            square += 0.5 * height * height;
            waves.push(Wave {
                turns: [across * cos, across * sin, z].map(|v| v * scale / length),
                phase: random(),
                height: height as f32,
            });
        }
        let to_one = (1.0 / f64::sqrt(square)) as f32;
        for wave in &mut waves {
            wave.height *= to_one;
        }
        Self { waves }
    }

    /// The octave at unit vectors.
    #[inline(always)]
    pub(super) fn at(&self, unit: &[[f64; LANES]; 3], noise: &mut Lanes) {
        *noise = [0.0; LANES];
        for wave in &self.waves {
            let [x, y, z] = wave.turns;
            for (l, noise) in noise.iter_mut().enumerate() {
                let turns = x * unit[0][l] + y * unit[1][l] + z * unit[2][l] + wave.phase;
                let nearest = (turns + SHIFTER) - SHIFTER;
                *noise += wave.height * cos_of_turns((turns - nearest) as f32);
            }
        }
    }
}

/// cos 2πt for −½ ≤ t ≤ ½, within 2·10⁻⁶.
#[inline(always)]
fn cos_of_turns(t: f32) -> f32 {
    // cos 2πt = −cos 2πu for u = ½ − |t|, so that |u| ≤ ¼ where |t| > ¼.
    let a = t.abs();
    let folded = a > 0.25;
    let u = if folded { 0.5 - a } else { a };
    let s = u * u;
    // Taylor's series of cos x up to x¹⁰, x = 2πu ≤ π/2: the next term is below 5·10⁻⁷.
    let c = 1.0
        + s * (-19.739_209 + s * (64.939_39 + s * (-85.456_82 + s * (60.244_64 - s * 26.426_256))));
    if folded { -c } else { c }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_polynomial_is_a_cosine(t in -0.5..=0.5_f32) {
            let exact = libm::cos(TAU * f64::from(t));
            prop_assert!((f64::from(cos_of_turns(t)) - exact).abs() < 2e-6);
        }
    }

    #[test]
    fn an_octave_has_a_variance_of_one_and_no_mean() {
        let waves = Waves::new(1.0, 5);
        let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
        let mut unit = [[0.0; LANES]; 3];
        let mut noise = [0.0; LANES];
        for i in 0..2000_u32 {
            for (axis, step) in unit.iter_mut().zip([0.371, 0.733, 0.219]) {
                for (l, v) in axis.iter_mut().enumerate() {
                    *v = (f64::from(i) * 64.0 + l as f64) * step;
                }
            }
            waves.at(&unit, &mut noise);
            for v in noise {
                sum += f64::from(v);
                squares += f64::from(v * v);
                n += 1.0;
            }
        }
        assert!((sum / n).abs() < 0.02, "{}", sum / n);
        assert!((squares / n - 1.0).abs() < 0.03, "{}", squares / n);
    }
}
