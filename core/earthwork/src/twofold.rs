//! Numbers of about 32 digits, as unevaluated sums of two f64.
//!
//! Sources: T. J. Dekker: A Floating-Point Technique for Extending the Available Precision (Numerische
//! Mathematik 18, 1971); J. R. Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates (Discrete & Computational Geometry 18, 1997).

use core::ops::{Add, Mul, Neg, Sub};

/// `high + low`, where `low` is at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    /// a − b, exact.
    pub(crate) fn difference(a: f64, b: f64) -> Self {
        sum(a, -b)
    }

    /// The nearest f64.
    pub(crate) fn value(self) -> f64 {
        self.high
    }
}

/// a + b, exact (Knuth).
fn sum(a: f64, b: f64) -> Twofold {
    let high = a + b;
    let of_b = high - a;
    Twofold {
        high,
        low: (a - (high - of_b)) + (b - of_b),
    }
}

/// A sum of a large and a small number, exact (Dekker).
fn renormalised(large: f64, small: f64) -> Twofold {
    let high = large + small;
    Twofold {
        high,
        low: small - (high - large),
    }
}

impl Add for Twofold {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.high, other.high), sum(self.low, other.low));
        let once = renormalised(high.high, high.low + low.high);
        renormalised(once.high, once.low + low.low)
    }
}

impl Neg for Twofold {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Twofold {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        // Fused: the same on every platform, which multiplying and adding in one need not be.
        let low = libm::fma(self.high, other.high, -high);
        renormalised(high, low + (self.high * other.low + self.low * other.high))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn integers_beyond_f64_are_exact(a in -(1_i64 << 61)..1 << 61, b in -(1_i64 << 61)..1 << 61) {
            // Two halves of 31 bits each are exact in f64, and so is what they are made of.
            let of = |v: i64| {
                let low = v & 0x7fff_ffff;
                Twofold::difference((v - low) as f64, -(low as f64))
            };
            let exact = i128::from(a) * i128::from(b) - i128::from(b);
            let found = of(a) * of(b) - of(b);
            let read = |t: Twofold| (t.high as i128) + (t.low as i128);
            // 122 bits do not all fit into two times 53.
            let slack = exact.unsigned_abs() >> 100;
            prop_assert!((read(found) - exact).unsigned_abs() <= slack, "{a} {b}");
        }
    }

    #[test]
    fn what_cancels_leaves_what_is_left() {
        let tiny = 1e-20;
        let one = Twofold::difference(1.0, -tiny);
        assert_eq!((one - Twofold::difference(1.0, 0.0)).value(), tiny);
        assert_eq!(
            (one * one - one - one + Twofold::difference(1.0, 0.0)).value(),
            0.0
        );
    }
}
