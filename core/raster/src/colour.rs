//! Colour arithmetic: the sRGB transfer function, premultiplication, 8-bit quantisation.
//!
//! Working values are straight and sRGB encoded; colours mix premultiplied and in linear light.
//! The transfer function is tabled (built once with the `libm` crate) and interpolated linearly,
//! so that it gives the same bits on every platform.
//!
//! Source of the formula: IEC 61966-2-1 (sRGB).

use std::sync::LazyLock;

use crate::{Bands, Block};

/// Intervals of a table; a power of two, so that finding one's place is exact.
const INTERVALS: usize = 1024;

/// A function on 0 to 1 by its values at equidistant places; the last entry is there twice, so
/// that place 1 has an interval too.
type Table = [f32; INTERVALS + 2];

/// Linear light over the encoded value.
static DECODE: LazyLock<Table> = LazyLock::new(|| table(decode_exact));

/// Encoded value over the square root of linear light, which spreads out the steep dark end.
static ENCODE: LazyLock<Table> = LazyLock::new(|| table(|root| encode_exact(root * root)));

fn table(function: impl Fn(f64) -> f64) -> Table {
    core::array::from_fn(|i| function(i.min(INTERVALS) as f64 / INTERVALS as f64) as f32)
}

/// The formula, also beyond 1.
fn decode_exact(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

/// The formula, also beyond 1.
fn encode_exact(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// A table's value at `place`, 0 to 1.
#[inline]
fn look_up(table: &Table, place: f32) -> f32 {
    let position = place * INTERVALS as f32;
    // Through i32, which takes one instruction.
    let i = (position as i32 as usize).min(INTERVALS);
    let (a, b) = (table[i], table[i + 1]);
    a + (b - a) * (position - i as f32)
}

/// The sRGB transfer function, its tables at hand: take it once for a loop over samples.
#[derive(Clone, Copy)]
pub struct Transfer {
    decode: &'static Table,
    encode: &'static Table,
}

impl Transfer {
    /// The transfer function of sRGB.
    pub fn srgb() -> Self {
        Self {
            decode: &DECODE,
            encode: &ENCODE,
        }
    }

    /// Linear light of an encoded value, 0 to 1 for ordinary colours.
    ///
    /// Above 1 and below 0 the formula continues. Monotone; exact at 0 and 1; within 5 · 10⁻⁷ of
    /// the formula from 0 to 1. NaN stays NaN.
    #[inline]
    pub fn decode(&self, encoded: f32) -> f32 {
        if (0.0..=1.0).contains(&encoded) {
            look_up(self.decode, encoded)
        } else {
            decode_beyond(encoded)
        }
    }

    /// The encoded value of linear light, the inverse of [`Self::decode`].
    ///
    /// Above 1 and below 0 the formula continues. Monotone; exact at 0 and 1; within 5 · 10⁻⁶ of
    /// the formula from 0 to 1. NaN stays NaN.
    #[inline]
    pub fn encode(&self, linear: f32) -> f32 {
        if (0.0..=1.0).contains(&linear) {
            look_up(self.encode, linear.sqrt())
        } else {
            encode_beyond(linear)
        }
    }
}

#[cold]
fn decode_beyond(encoded: f32) -> f32 {
    decode_exact(f64::from(encoded)) as f32
}

#[cold]
fn encode_beyond(linear: f32) -> f32 {
    encode_exact(f64::from(linear)) as f32
}

/// [`Transfer::decode`] of one value.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    Transfer::srgb().decode(encoded)
}

/// [`Transfer::encode`] of one value.
pub fn srgb_from_linear(linear: f32) -> f32 {
    Transfer::srgb().encode(linear)
}

/// Decodes a row of values in place: [`Transfer::decode`] of each.
pub fn decode_slice(values: &mut [f32]) {
    let transfer = Transfer::srgb();
    for v in values {
        *v = transfer.decode(*v);
    }
}

/// Encodes a row of values in place: [`Transfer::encode`] of each.
pub fn encode_slice(values: &mut [f32]) {
    let transfer = Transfer::srgb();
    for v in values {
        *v = transfer.encode(*v);
    }
}

/// Straight, encoded colours to premultiplied linear light, in place.
///
/// # Panics
/// If the block holds no colours.
pub fn premultiply(block: &mut Block) {
    assert_eq!(block.bands(), Bands::Colour, "a block of colours");
    let [r, g, b, a] = block.planes_mut();
    for plane in [r, g, b] {
        decode_slice(plane);
        for (v, a) in plane.iter_mut().zip(a.iter()) {
            *v *= a;
        }
    }
}

/// Premultiplied linear light to straight, encoded colours, in place; the inverse of
/// [`premultiply`] where alpha exceeds 0. Where it does not, everything becomes 0.
///
/// # Panics
/// If the block holds no colours.
pub fn unpremultiply(block: &mut Block) {
    assert_eq!(block.bands(), Bands::Colour, "a block of colours");
    let [r, g, b, a] = block.planes_mut();
    for plane in [r, g, b] {
        for (v, a) in plane.iter_mut().zip(a.iter()) {
            *v = if *a > 0.0 { *v / a } else { 0.0 };
        }
        encode_slice(plane);
    }
    for a in a {
        *a = if *a > 0.0 { *a } else { 0.0 };
    }
}

/// A working value 0 to 1 as 255ths, rounded half up; NaN becomes 0, values outside clamp.
#[inline]
pub fn to_u8(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// 255ths as a working value.
#[inline]
pub fn from_u8(value: u8) -> f32 {
    f32::from(value) / 255.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn every_8_bit_value_survives_linear_light() {
        for v in 0..=255 {
            assert_eq!(to_u8(srgb_from_linear(linear_from_srgb(from_u8(v)))), v);
        }
    }

    #[test]
    fn the_ends_are_exact() {
        for v in [0.0, 1.0] {
            assert_eq!(linear_from_srgb(v), v);
            assert_eq!(srgb_from_linear(v), v);
        }
    }

    #[test]
    fn the_tables_keep_their_stated_error() {
        let worst = |f: fn(f32) -> f32, exact: fn(f64) -> f64| {
            (0..=1_000_000)
                .map(|i| i as f32 / 1e6)
                .map(|v| (f64::from(f(v)) - exact(f64::from(v))).abs())
                .fold(0.0, f64::max)
        };
        let (decode, encode) = (
            worst(linear_from_srgb, decode_exact),
            worst(srgb_from_linear, encode_exact),
        );
        assert!(decode < 5e-7, "decode {decode:e}");
        assert!(encode < 5e-6, "encode {encode:e}");
    }

    proptest! {
        #[test]
        fn transfer_functions_never_fall(a in -0.5..8.0_f32, step in 0.0..1e-3_f32) {
            prop_assert!(linear_from_srgb(a) <= linear_from_srgb(a + step));
            prop_assert!(srgb_from_linear(a) <= srgb_from_linear(a + step));
        }

        #[test]
        fn bright_values_continue_the_formula_without_a_step(v in 1.0..100.0_f32) {
            let back = srgb_from_linear(linear_from_srgb(v));
            prop_assert!((back - v).abs() <= v * 1e-6, "{v} -> {back}");
        }

        #[test]
        fn premultiplied_colours_come_back(rgb in prop::array::uniform3(0.0..1.0_f32), a in 0.01..1.0_f32) {
            let mut block = Block::filled(Bands::Colour, 1, 1, &[rgb[0], rgb[1], rgb[2], a]);
            let before = block.clone();
            premultiply(&mut block);
            unpremultiply(&mut block);
            for (x, y) in before.samples().iter().zip(block.samples()) {
                prop_assert!((x - y).abs() < 1e-5, "{x} -> {y}");
            }
        }
    }
}
