//! Samples whose bits do not fill whole bytes or words of the machine.

use tiff::decoder::DecodingResult;

use super::layout::{Layout, SampleFormat};

/// Samples from rows of packed bits, most significant first, each row padded to a byte; in bytes,
/// 16 or 32 bits, whichever holds them. Floats of 24 bits become f32.
pub(super) fn unpack(packed: &[u8], layout: &Layout, big_endian: bool) -> DecodingResult {
    let row_samples = layout.chunk_width as usize * usize::from(layout.chunk_samples());
    let rows = packed.chunks_exact(layout.row_bytes() as usize);
    let bits = u32::from(layout.bits);
    if layout.format == SampleFormat::Float {
        let number = |b: &[u8]| match *b {
            [a, b, c] if big_endian => u32::from_be_bytes([0, a, b, c]),
            [a, b, c] => u32::from_le_bytes([a, b, c, 0]),
            _ => 0,
        };
        let floats = rows.flat_map(|row| row.chunks_exact(3).take(row_samples));
        return DecodingResult::F32(floats.map(|b| f32_from_24_bits(number(b))).collect());
    }
    if bits == 24 && big_endian {
        // GDAL stores what it packs by libtiff, which turns whole bytes round in files of this order.
        let numbers = rows.flat_map(|row| row.as_chunks::<3>().0.iter().take(row_samples));
        return DecodingResult::U32(
            numbers
                .map(|&[a, b, c]| u32::from_le_bytes([a, b, c, 0]))
                .collect(),
        );
    }
    let samples = rows.flat_map(|row| Bits::new(row, bits).take(row_samples));
    match bits {
        ..8 => DecodingResult::U8(samples.map(|v| v as u8).collect()),
        8..16 => DecodingResult::U16(samples.map(|v| v as u16).collect()),
        _ => DecodingResult::U32(samples.collect()),
    }
}

/// Numbers of so many bits, at most 32, one after another.
struct Bits<'a> {
    bytes: core::slice::Iter<'a, u8>,
    each: u32,
    waiting: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8], each: u32) -> Self {
        Self {
            bytes: bytes.iter(),
            each,
            waiting: 0,
            count: 0,
        }
    }
}

impl Iterator for Bits<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        while self.count < self.each {
            self.waiting = self.waiting << 8 | u64::from(*self.bytes.next()?);
            self.count += 8;
        }
        self.count -= self.each;
        let value = (self.waiting >> self.count) & ((1 << self.each) - 1);
        Some(value as u32)
    }
}

/// A float of 1 sign bit, 7 of exponent (bias 63) and 16 of fraction.
///
/// Source: Adobe Photoshop TIFF Technical Note 3, 2005.
fn f32_from_24_bits(bits: u32) -> f32 {
    let sign = (bits & 0x80_0000) << 8;
    let (exponent, fraction) = (bits >> 16 & 0x7f, bits & 0xffff);
    let magnitude = match (exponent, fraction) {
        (0, _) => {
            // Subnormal: fraction · 2⁻⁷⁸, exact in f32.
            return f32::from_bits(
                sign | (fraction as f32 * f32::from_bits((127 - 78) << 23)).to_bits(),
            );
        }
        (0x7f, _) => 0x7f80_0000 | fraction << 7,
        _ => (exponent + 127 - 63) << 23 | fraction << 7,
    };
    f32::from_bits(sign | magnitude)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn floats_of_24_bits_keep_their_value() {
        assert_eq!(f32_from_24_bits(0x3f_0000), 1.0);
        assert_eq!(f32_from_24_bits(0xc0_8000), -3.0);
        assert_eq!(f32_from_24_bits(1), libm::exp2f(-78.0));
        assert_eq!(f32_from_24_bits(0x80_0000).to_bits(), (-0.0f32).to_bits());
        assert_eq!(f32_from_24_bits(0x7f_0000), f32::INFINITY);
        assert!(f32_from_24_bits(0x7f_0001).is_nan());
    }

    proptest! {
        #[test]
        fn bits_come_back_whatever_their_number(
            each in 1u32..=32, values in prop::collection::vec(any::<u32>(), 0..20),
        ) {
            let wanted: Vec<u32> = values.iter().map(|v| v >> (32 - each)).collect();
            let count = wanted.len() * each as usize;
            let mut bytes = vec![0u8; count.div_ceil(8)];
            for (place, bit) in wanted.iter().flat_map(|v| (0..each).rev().map(move |b| v >> b & 1)).enumerate() {
                bytes[place / 8] |= (bit as u8) << (7 - place % 8);
            }
            let found: Vec<u32> = Bits::new(&bytes, each).take(wanted.len()).collect();
            prop_assert_eq!(found, wanted);
        }
    }
}
