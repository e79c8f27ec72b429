//! Kernels on the widest vectors that the machine has.
//!
//! Loops over samples are written so that the compiler turns them into vector code. What it may
//! use is decided when the program is built, which is 128 bits on the machines of 2003; here the
//! same loop is compiled for wider vectors too, and the widest that the machine has is run.
//! The operations are the same ones in the same order (nothing is contracted or reordered), so the
//! bits of the results are the same on every machine.

use pulp::Arch;

/// Runs a kernel on the widest vectors.
///
/// The closure and everything that it calls in a loop must be `#[inline(always)]`: what is not
/// inlined is right but as slow as without.
///
/// ```
/// let mut values = [1.0_f32; 64];
/// relievo_raster::vector::on_widest(
///     #[inline(always)]
///     || values.iter_mut().for_each(|v| *v *= 2.0),
/// );
/// assert_eq!(values, [2.0; 64]);
/// ```
#[inline]
pub fn on_widest<R>(kernel: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(kernel)
}

/// The integer at or below `v`, 0 ≤ `v` < 2²², as a number and as a float; unspecified for others.
///
/// A cast gives the same, but has rules for values beyond an integer's range that vectors lack.
#[inline(always)]
pub fn floor(v: f32) -> (u32, f32) {
    /// 2²³: adding it rounds to an integer and leaves that in the low bits.
    const SHIFTER: f32 = 8_388_608.0;
    let shifted = v + SHIFTER;
    let nearest = shifted - SHIFTER;
    let above = nearest > v;
    let integer = shifted
        .to_bits()
        .wrapping_sub(SHIFTER.to_bits())
        .wrapping_sub(u32::from(above));
    (integer, nearest - if above { 1.0 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn floors_are_those_of_the_language(v in 0.0..4_194_304.0_f32, small in 0.0..300.0_f32) {
            for v in [v, small, v.floor(), small.floor().next_down().max(0.0), small.ceil()] {
                prop_assert_eq!(floor(v), (v as u32, v.floor()));
            }
        }
    }
}
