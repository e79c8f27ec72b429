//! Powers without the platform's library: the same bits everywhere, and loops that vectorise.

/// |x| to the power `exponent` (finite, above 0) with the sign of `x`.
///
/// Relative error below 10⁻⁶ · max(1, `exponent` · |log2 x| / 8); exact at 0 and 1; results beyond
/// 2^±126 are clamped there, and subnormal `x` count as 0.
#[inline(always)]
pub fn power(x: f32, exponent: f32) -> f32 {
    let magnitude = x.abs();
    let raised = exp2(log2(magnitude) * exponent);
    let result = if magnitude >= f32::MIN_POSITIVE {
        raised
    } else {
        0.0
    };
    f32::from_bits(result.to_bits() | (x.to_bits() & 0x8000_0000))
}

/// Binary logarithm of a positive, normal number.
///
/// x = 2^e · m with m from √½ to √2; log2 m from the series of the inverse hyperbolic tangent.
#[inline(always)]
pub(crate) fn log2(x: f32) -> f32 {
    /// Bits of √½.
    const ROOT_HALF: i32 = 0x3f35_04f3;
    let above = (x.to_bits() as i32).wrapping_sub(ROOT_HALF);
    let e = (above >> 23) as f32;
    let m = f32::from_bits(((above & 0x007f_ffff) + ROOT_HALF) as u32);
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    // 2 artanh(s) / (s ln 2), fitted for the least largest error: 3 · 10⁻⁸.
    let series = 2.885_391_2 + q * (0.961_470_8 + q * 0.598_973_9);
    e + s * series
}

/// 2 to the power y, y clamped to ±126.
///
/// y = n + f with |f| ≤ ½; 2^f by a polynomial fitted for the least largest error, 10⁻⁷, exact at 0.
#[inline(always)]
pub(crate) fn exp2(y: f32) -> f32 {
    /// 1.5 · 2²³: adding it leaves the nearest integer in the low bits.
    const SHIFTER: f32 = 12_582_912.0;
    let y = if y > -126.0 { y } else { -126.0 };
    let y = if y < 126.0 { y } else { 126.0 };
    let shifted = y + SHIFTER;
    let n = (shifted.to_bits() as i32).wrapping_sub(SHIFTER.to_bits() as i32);
    let f = y - (shifted - SHIFTER);
    let series = 1.0
        + f * (0.693_147_24
            + f * (0.240_222_35 + f * (0.055_503_085 + f * (0.009_671_875 + f * 0.001_340_725_6))));
    f32::from_bits((series.to_bits() as i32).wrapping_add(n << 23) as u32)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn powers_keep_their_stated_error(x in 1e-6..20.0_f32, exponent in 0.05..8.0_f32) {
            let exact = libm::pow(f64::from(x), f64::from(exponent));
            prop_assume!(exact > 1e-37);
            let allowed = 1e-6 * (f64::from(exponent) * libm::log2(f64::from(x)).abs() / 8.0).max(1.0);
            let got = f64::from(power(x, exponent));
            prop_assert!((got / exact - 1.0).abs() < allowed, "{x} ^ {exponent}: {got} for {exact}");
        }

        #[test]
        fn powers_are_odd(x in 0.0..10.0_f32, exponent in 0.05..8.0_f32) {
            prop_assert_eq!(power(-x, exponent), -power(x, exponent));
        }
    }

    #[test]
    fn nothing_and_one_are_exact_and_nothing_panics() {
        for exponent in [0.01, 0.45, 1.0, 2.2, 100.0] {
            assert_eq!(power(0.0, exponent), 0.0);
            assert_eq!(power(1.0, exponent), 1.0);
            for odd in [
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                f32::MAX,
                f32::MIN_POSITIVE,
                1e-40,
            ] {
                let _unspecified = power(odd, exponent);
            }
        }
    }
}
