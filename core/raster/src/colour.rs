//! Colour arithmetic: the sRGB transfer function, premultiplication, 8-bit quantisation.
//!
//! Working values are straight and sRGB encoded; colours mix premultiplied and in linear light.
//! The transfer function is made of polynomials, fitted for the least largest error: the same bits
//! on every platform, without a table, so that loops over samples run on vectors.
//!
//! Source of the formula: IEC 61966-2-1 (sRGB).

use crate::power::{exp2, log2};
use crate::vector::{floor, on_widest};
use crate::{Bands, Block};

/// Encoded values up to here, and linear light up to there, are proportional to each other.
const KNEE_ENCODED: f32 = 0.040_45;
/// See [`KNEE_ENCODED`].
const KNEE_LINEAR: f32 = 0.003_130_8;
/// Encoded value per linear light below the knee.
const DARK_SLOPE: f32 = 12.92;

/// Linear light of an encoded value, 0 to 1 for ordinary colours.
///
/// Above 1 and below 0 the formula continues. Exact at 0 and 1; within 3 · 10⁻⁷ of the formula
/// from 0 to 1, relatively within 10⁻⁶ above; never falls by more than 3 · 10⁻⁷ of the value where
/// its argument rises. NaN stays NaN.
#[inline(always)]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 1.0 {
        decode(encoded)
    } else {
        decode_bright(encoded)
    }
}

/// The encoded value of linear light, the inverse of [`linear_from_srgb`].
///
/// Above 1 and below 0 the formula continues. Exact at 0 and 1; within 5 · 10⁻⁷ of the formula
/// from 0 to 1, relatively within 10⁻⁶ above; never falls by more than 3 · 10⁻⁷ of the value where
/// its argument rises. NaN stays NaN.
#[inline(always)]
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 1.0 {
        encode(linear)
    } else {
        encode_bright(linear)
    }
}

/// Decodes values in place: [`linear_from_srgb`] of each. For kernels that run on vectors already;
/// short slices of a fixed length are best.
#[inline(always)]
pub fn decode_each(values: &mut [f32]) {
    if all_ordinary(values) {
        for v in values {
            *v = decode(*v);
        }
    } else {
        for v in values {
            let (ordinary, bright) = (decode(*v), decode_bright(*v));
            *v = if *v <= 1.0 { ordinary } else { bright };
        }
    }
}

/// Encodes values in place: [`srgb_from_linear`] of each; like [`decode_each`].
#[inline(always)]
pub fn encode_each(values: &mut [f32]) {
    if all_ordinary(values) {
        for v in values {
            *v = encode(*v);
        }
    } else {
        for v in values {
            let (ordinary, bright) = (encode(*v), encode_bright(*v));
            *v = if *v <= 1.0 { ordinary } else { bright };
        }
    }
}

/// Whether no value is above 1 or NaN. Not short-circuited, so that it runs on vectors.
#[inline(always)]
fn all_ordinary(values: &[f32]) -> bool {
    values
        .iter()
        .fold(true, |ordinary, v| ordinary & (*v <= 1.0))
}

/// [`linear_from_srgb`] up to 1.
///
/// c² differs little from the formula, and its end is exact: what is left vanishes at 1 as 1 − c
/// does, times a polynomial.
#[inline(always)]
fn decode(encoded: f32) -> f32 {
    let c = encoded;
    let left = 0.000_844_277_3
        + c * (0.036_613_952
            + c * (-0.485_693_13
                + c * (0.437_559_63
                    + c * (-0.693_023_15
                        + c * (0.933_967_9
                            + c * (-0.854_057_13 + c * (0.452_668_8 - c * 0.103_786_655)))))));
    let curve = c * c + (1.0 - c) * left;
    if c <= KNEE_ENCODED {
        c * (1.0 / DARK_SLOPE)
    } else {
        curve
    }
}

/// [`srgb_from_linear`] up to 1.
///
/// The power is a smooth function of the fourth root; about its value at 1 the end is exact.
#[inline(always)]
fn encode(linear: f32) -> f32 {
    // Not the root of a negative value, which is slow on some machines.
    let root = if linear > 0.0 { linear } else { 0.0 };
    let u = root.sqrt().sqrt() - 1.0;
    let curve = 1.0
        + u * (1.758_300_7
            + u * (0.585_124_3
                + u * (-0.075_098_28
                    + u * (-0.025_087_62
                        + u * (-0.122_954_68 + u * (-0.132_208_51 - u * 0.073_948_35))))));
    if linear <= KNEE_LINEAR {
        linear * DARK_SLOPE
    } else {
        curve
    }
}

/// [`linear_from_srgb`] above 1: t^2.4 as t² · 2^(0.4 log2 t), which loses fewer digits.
#[inline(always)]
fn decode_bright(encoded: f32) -> f32 {
    let t = (encoded + 0.055) * (1.0 / 1.055);
    t * t * exp2(0.4 * log2(t))
}

/// [`srgb_from_linear`] above 1: l^(5/12) as ⁴√l · 2^(log2 l / 6), which loses fewer digits.
#[inline(always)]
fn encode_bright(linear: f32) -> f32 {
    let root = if linear < 0.0 { 0.0 } else { linear };
    let power = root.sqrt().sqrt() * exp2(log2(root) * (1.0 / 6.0));
    1.055 * power - 0.055
}

/// Decodes a row of values in place: [`linear_from_srgb`] of each.
pub fn decode_slice(values: &mut [f32]) {
    on_widest(
        #[inline(always)]
        || values.chunks_mut(CHUNK).for_each(decode_each),
    );
}

/// Encodes a row of values in place: [`srgb_from_linear`] of each.
pub fn encode_slice(values: &mut [f32]) {
    on_widest(
        #[inline(always)]
        || values.chunks_mut(CHUNK).for_each(encode_each),
    );
}

/// Samples that are looked through at once for values beyond the ordinary.
const CHUNK: usize = 64;

/// Straight, encoded colours to premultiplied linear light, in place.
///
/// # Panics
/// If the block holds no colours.
pub fn premultiply(block: &mut Block) {
    assert_eq!(block.bands(), Bands::Colour, "a block of colours");
    let [r, g, b, a] = block.planes_mut();
    let a = &*a;
    on_widest(
        #[inline(always)]
        || {
            for plane in [r, g, b] {
                for (values, a) in plane.chunks_mut(CHUNK).zip(a.chunks(CHUNK)) {
                    decode_each(values);
                    for (v, a) in values.iter_mut().zip(a) {
                        *v *= a;
                    }
                }
            }
        },
    );
}

/// Premultiplied linear light to straight, encoded colours, in place; the inverse of
/// [`premultiply`] where alpha exceeds 0. Where it does not, everything becomes 0.
///
/// # Panics
/// If the block holds no colours.
pub fn unpremultiply(block: &mut Block) {
    assert_eq!(block.bands(), Bands::Colour, "a block of colours");
    let [r, g, b, a] = block.planes_mut();
    on_widest(
        #[inline(always)]
        || {
            for plane in [r, g, b] {
                for (values, a) in plane.chunks_mut(CHUNK).zip(a.chunks(CHUNK)) {
                    let opaque = a.iter().fold(true, |opaque, a| opaque & (*a == 1.0));
                    if !opaque {
                        for (v, a) in values.iter_mut().zip(a) {
                            *v = if *a > 0.0 { *v / a } else { 0.0 };
                        }
                    }
                    encode_each(values);
                }
            }
            for a in a {
                *a = if *a > 0.0 { *a } else { 0.0 };
            }
        },
    );
}

/// A working value 0 to 1 as 255ths, rounded half up; NaN becomes 0, values outside clamp.
#[inline(always)]
pub fn to_u8(value: f32) -> u8 {
    let scaled = value * 255.0 + 0.5;
    // As a cast to u8 would clamp, but in steps that vectors have.
    let positive = if scaled > 0.0 { scaled } else { 0.0 };
    let clamped = if positive < 255.0 { positive } else { 255.0 };
    floor(clamped).0 as u8
}

/// 255ths as a working value: the f32 nearest to `value` / 255.
#[inline(always)]
pub fn from_u8(value: u8) -> f32 {
    /// 1 / 255 in two parts; an 8-bit number times the upper one, of 16 bits, is exact.
    const UPPER: f32 = 32_897.0 / 8_388_608.0;
    const LOWER: f32 = (1.0 / 255.0 - 32_897.0 / 8_388_608.0) as f32;
    let value = f32::from(value);
    value * UPPER + value * LOWER
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

    /// The formula.
    fn decode_exact(encoded: f64) -> f64 {
        if encoded <= 0.040_45 {
            encoded / 12.92
        } else {
            libm::pow((encoded + 0.055) / 1.055, 2.4)
        }
    }

    /// The formula.
    fn encode_exact(linear: f64) -> f64 {
        if linear <= 0.003_130_8 {
            linear * 12.92
        } else {
            1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
        }
    }

    #[test]
    fn the_8_bit_values_are_the_nearest_floats_and_come_back() {
        for v in 0..=255_u8 {
            assert_eq!(from_u8(v), f32::from(v) / 255.0);
            assert_eq!(to_u8(from_u8(v)), v);
        }
        for (value, expected) in [
            (f32::NAN, 0),
            (f32::INFINITY, 255),
            (f32::NEG_INFINITY, 0),
            (-0.5, 0),
            (1.5, 255),
            (0.5, 128),
        ] {
            assert_eq!(to_u8(value), expected, "{value}");
            assert_eq!((value * 255.0 + 0.5) as u8, expected, "{value}");
        }
    }

    #[test]
    fn the_polynomials_keep_their_stated_error() {
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
        assert!(decode < 3e-7, "decode {decode:e}");
        assert!(encode < 5e-7, "encode {encode:e}");
    }

    #[test]
    fn bright_values_keep_their_stated_error() {
        for i in 0..200_000 {
            let v = 1.0 + i as f32 * 5e-3;
            let wide = f64::from(v);
            for (got, exact) in [
                (linear_from_srgb(v), decode_exact(wide)),
                (srgb_from_linear(v), encode_exact(wide)),
            ] {
                assert!(
                    (f64::from(got) / exact - 1.0).abs() < 1e-6,
                    "{v}: {got} for {exact}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_number_stays_what_it_is() {
        for function in [linear_from_srgb, srgb_from_linear] {
            assert!(function(f32::NAN).is_nan());
            assert_eq!(function(f32::INFINITY), f32::INFINITY);
            assert_eq!(function(f32::NEG_INFINITY), f32::NEG_INFINITY);
        }
    }

    #[test]
    fn slices_agree_with_single_values_to_the_bit() {
        for wild in [false, true] {
            let values: Vec<f32> = (0..100_003)
                .map(|i| match i % 1009 {
                    0 if wild => f32::NAN,
                    1 if wild => -0.25,
                    2 if wild => 1.0 + i as f32 * 1e-3,
                    3 if wild => f32::INFINITY,
                    _ => i as f32 / 100_002.0,
                })
                .collect();
            let (mut decoded, mut encoded) = (values.clone(), values.clone());
            decode_slice(&mut decoded);
            encode_slice(&mut encoded);
            let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            for (i, v) in values.into_iter().enumerate() {
                assert!(same(decoded[i], linear_from_srgb(v)), "{v}");
                assert!(same(encoded[i], srgb_from_linear(v)), "{v}");
            }
        }
    }

    proptest! {
        #[test]
        fn transfer_functions_never_fall(a in -0.5..8.0_f32, step in 0.0..1e-3_f32) {
            for function in [linear_from_srgb, srgb_from_linear] {
                let (before, after) = (function(a), function(a + step));
                prop_assert!(before <= after + 3e-7 * after.abs(), "{} {}", before, after);
            }
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
