//! The sRGB transfer function for many samples at a time.

use std::sync::LazyLock;

use relievo_raster::colour::Transfer;

/// Samples that are worked on together: their planes stay in the nearest cache, and loops over them
/// have a fixed length.
pub(crate) const LANES: usize = 64;

/// One plane of them.
pub(crate) type Lanes = [f32; LANES];

/// Intervals of a table, as many as [`Transfer`] has.
const INTERVALS: usize = 1024;

/// Adding it brings the integer part of a float below 2²² to the low bits.
const SHIFTER: f32 = 8_388_608.0;

/// Value at the beginning of each interval, and what is added up to its end. Its length is a power of
/// two beyond [`INTERVALS`], so that a masked index needs no check.
type Table = [[f32; 2]; 2 * INTERVALS];

/// [`Transfer`] on planes: the same bits, several times as fast, for finding places in the table is
/// separate from looking them up and runs on vectors.
pub(crate) struct Light {
    transfer: Transfer,
    decode: Table,
    encode: Table,
}

static SRGB: LazyLock<Light> = LazyLock::new(|| {
    let transfer = Transfer::srgb();
    // Both are exact at the ends of intervals; roots of light are equidistant in `encode`.
    Light {
        transfer,
        decode: table(|place| transfer.decode(place)),
        encode: table(|root| transfer.encode(root * root)),
    }
});

fn table(value: impl Fn(f32) -> f32) -> Table {
    core::array::from_fn(|i| {
        let [a, b] = [i, i + 1].map(|k| value(k.min(INTERVALS) as f32 / INTERVALS as f32));
        [a, b - a]
    })
}

impl Light {
    /// Take it once for a loop over samples.
    pub(crate) fn srgb() -> &'static Self {
        &SRGB
    }

    /// [`Transfer::decode`] of each.
    pub(crate) fn decode(&self, values: &mut Lanes) {
        convert(values, &self.decode, |v| v, |v| self.transfer.decode(v));
    }

    /// [`Transfer::encode`] of each.
    pub(crate) fn encode(&self, values: &mut Lanes) {
        convert(values, &self.encode, f32::sqrt, |v| self.transfer.encode(v));
    }
}

#[inline]
fn convert(
    values: &mut Lanes,
    table: &Table,
    place: impl Fn(f32) -> f32,
    beyond: impl Fn(f32) -> f32,
) {
    let mut index = [0_u32; LANES];
    let mut part = [0.0; LANES];
    let mut outside = 0_u32;
    for ((v, index), part) in values.iter().zip(&mut index).zip(&mut part) {
        let inside = if *v >= 0.0 { *v } else { 0.0 };
        let inside = if inside <= 1.0 { inside } else { 1.0 };
        outside |= u32::from(inside != *v);
        let position = place(inside) * INTERVALS as f32;
        // Truncated by rounding, then stepping back where that went up.
        let shifted = position + SHIFTER;
        let nearest = shifted - SHIFTER;
        let up = nearest > position;
        *index = shifted.to_bits().wrapping_sub(u32::from(up));
        *part = position - (nearest - if up { 1.0 } else { 0.0 });
    }
    if outside == 0 {
        for ((v, index), part) in values.iter_mut().zip(&index).zip(&part) {
            let [a, d] = table[*index as usize & (2 * INTERVALS - 1)];
            *v = a + d * *part;
        }
    } else {
        for v in values {
            *v = beyond(*v);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn planes_agree_with_single_values_to_the_bit() {
        let light = Light::srgb();
        let transfer = Transfer::srgb();
        for first in 0..2000_u32 {
            // Every part of the range, ends of intervals and their neighbours among them.
            let values: Lanes = core::array::from_fn(|l| {
                let v = (first * LANES as u32 + l as u32) as f32 / 128_000.0;
                let end = (v * INTERVALS as f32).round() / INTERVALS as f32;
                match l % 4 {
                    0 => end,
                    1 => end.next_up().min(1.0),
                    2 => end.next_down().max(0.0),
                    _ => v,
                }
            });
            let (mut decoded, mut encoded) = (values, values);
            light.decode(&mut decoded);
            light.encode(&mut encoded);
            for (l, v) in values.into_iter().enumerate() {
                assert_eq!(decoded[l].to_bits(), transfer.decode(v).to_bits(), "{v}");
                assert_eq!(encoded[l].to_bits(), transfer.encode(v).to_bits(), "{v}");
            }
        }
    }

    proptest! {
        #[test]
        fn values_beyond_the_range_do_as_well(v in prop_oneof![-2.0..5.0_f32, Just(f32::NAN), Just(f32::INFINITY), Just(-0.0_f32)], at in 0..LANES) {
            let mut values = [0.25; LANES];
            values[at] = v;
            let light = Light::srgb();
            let mut decoded = values;
            light.decode(&mut decoded);
            let mut encoded = values;
            light.encode(&mut encoded);
            let one = Transfer::srgb();
            for l in 0..LANES {
                let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
                prop_assert!(same(decoded[l], one.decode(values[l])));
                prop_assert!(same(encoded[l], one.encode(values[l])));
            }
        }
    }
}
