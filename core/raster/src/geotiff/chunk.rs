//! Decoding of single chunks (strips, tiles) with the `tiff` crate.
//!
//! The crate sees every chunk as a small file of one strip that exists in memory only. So chunks
//! decode in any thread without a shared decoder, palettes and masks pass as plain grey, and no count
//! in a header makes the crate allocate: all sizes were checked before.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::fault::{Fault, damaged};
use super::ifd::TiffBytes;
use super::layout::{Layout, SampleFormat, compression, photometric};

/// Decoded samples of a chunk, pixel by pixel, in their stored type; less than 8 bits are unpacked
/// to bytes, and YCbCr is RGB already.
#[derive(Debug)]
pub(crate) struct Chunk {
    pub(crate) samples: DecodingResult,
}

impl Chunk {
    /// Bytes that the samples take in memory.
    pub(crate) fn bytes(&self) -> usize {
        match &self.samples {
            DecodingResult::U8(v) => v.len(),
            DecodingResult::I8(v) => v.len(),
            DecodingResult::U16(v) => v.len() * 2,
            DecodingResult::I16(v) => v.len() * 2,
            DecodingResult::F16(v) => v.len() * 2,
            DecodingResult::U32(v) => v.len() * 4,
            DecodingResult::I32(v) => v.len() * 4,
            DecodingResult::F32(v) => v.len() * 4,
            DecodingResult::U64(v) => v.len() * 8,
            DecodingResult::I64(v) => v.len() * 8,
            DecodingResult::F64(v) => v.len() * 8,
        }
    }
}

/// Reads and decodes one chunk; `None` where the file leaves it out (all nodata).
pub(crate) fn decode(
    file: &TiffBytes,
    layout: &Layout,
    plane: u16,
    column: u32,
    row: u32,
) -> Result<Option<Chunk>, Fault> {
    let Some((offset, length)) = layout.chunk_range(file, plane, column, row)? else {
        return Ok(None);
    };
    let rows = layout.rows_in(row);
    let decoded_bytes = layout.row_bytes() * u64::from(rows);
    if length.saturating_mul(most_expansion(layout.compression)) < decoded_bytes {
        return damaged(format!(
            "expected {decoded_bytes} bytes in a strip or tile, found {length} compressed ones"
        ));
    }
    let stored = if layout.compression == compression::NONE {
        length.min(decoded_bytes)
    } else {
        length
    };
    let raw = file.bytes.vec_at(offset, stored)?;
    if layout.compression == compression::JPEG {
        check_jpeg_size(&raw, layout.chunk_width, rows)?;
    }
    let packed = layout.bits < 8;
    // Packed rows pass as rows of bytes.
    let (width, samples, bits) = if packed {
        (layout.row_bytes() as u32, 1, 8)
    } else {
        (layout.chunk_width, layout.chunk_samples(), layout.bits)
    };
    let head = OneStrip {
        width,
        rows,
        samples,
        bits,
        layout,
        big_endian: file.big_endian,
    }
    .bytes(&raw);
    let fault =
        |error: tiff::TiffError| Fault::Damaged(format!("cannot decode a strip or tile: {error}"));
    let mut limits = Limits::default();
    limits.decoding_buffer_size = decoded_bytes as usize;
    limits.intermediate_buffer_size = stored as usize;
    let mut decoder = Decoder::new(Cursor::new(head))
        .map_err(fault)?
        .with_limits(limits);
    let mut decoded = decoder.read_chunk(0).map_err(fault)?;
    if let DecodingResult::U8(bytes) = &mut decoded {
        if packed {
            *bytes = unpack(bytes, layout, rows);
        } else if layout.photometric == photometric::YCBCR && layout.chunk_samples() >= 3 {
            rgb_from_ycbcr(bytes, layout.chunk_samples().into());
        }
    }
    Ok(Some(Chunk { samples: decoded }))
}

/// How many bytes a compressed byte may become at most: a bound that keeps a small file from
/// claiming a large buffer.
fn most_expansion(method: u16) -> u64 {
    match method {
        compression::NONE => 1,
        compression::PACK_BITS => 128,
        // A match of 258 bytes takes at least two bits.
        compression::DEFLATE | compression::OLD_DEFLATE => 1100,
        // The longest string of a 12-bit table, from a 9-bit code.
        compression::LZW => 4096,
        // A block of one repeated byte: 128 KiB from 4 bytes.
        compression::ZSTD => 1 << 15,
        // Empty blocks of 8 x 8 pixels take two bits a component at least.
        _ => 1024,
    }
}

/// A chunk dressed as a TIFF of one strip.
struct OneStrip<'a> {
    width: u32,
    rows: u32,
    samples: u16,
    bits: u16,
    layout: &'a Layout,
    big_endian: bool,
}

impl OneStrip<'_> {
    /// Header, one directory and the strip. Always a classic TIFF: a chunk is far below 4 GiB.
    fn bytes(&self, raw: &[u8]) -> Vec<u8> {
        let format = match self.layout.format {
            SampleFormat::Unsigned => 1,
            SampleFormat::Signed => 2,
            SampleFormat::Float => 3,
        };
        let tables: &[u8] = self.layout.jpeg_tables.as_deref().unwrap_or_default();
        let entry_count: u32 = if tables.len() > 4 { 12 } else { 11 };
        let tables_at = 8 + 2 + entry_count * 12 + 4;
        let strip_at = tables_at + tables.len() as u32;
        let mut out = Vec::with_capacity(strip_at as usize + raw.len());
        let order: &[u8] = if self.big_endian { b"MM" } else { b"II" };
        out.extend_from_slice(order);
        self.put16(&mut out, 42);
        self.put32(&mut out, 8);
        self.put16(&mut out, entry_count as u16);
        // Any number of samples is fine in grey; colours are none of the crate's business here.
        let longs: [(u16, u32); 2] = [(256, self.width), (257, self.rows)];
        for (tag, value) in longs {
            self.entry(&mut out, tag, value);
        }
        self.short_entry(&mut out, 258, self.bits);
        self.short_entry(&mut out, 259, self.layout.compression);
        self.short_entry(&mut out, 262, photometric::BLACK_IS_ZERO);
        self.entry(&mut out, 273, strip_at);
        self.short_entry(&mut out, 277, self.samples);
        self.entry(&mut out, 278, self.rows);
        self.entry(&mut out, 279, raw.len() as u32);
        self.short_entry(&mut out, 317, self.layout.predictor);
        self.short_entry(&mut out, 339, format);
        if tables.len() > 4 {
            self.put16(&mut out, 347);
            self.put16(&mut out, 7);
            self.put32(&mut out, tables.len() as u32);
            self.put32(&mut out, tables_at);
        }
        self.put32(&mut out, 0);
        debug_assert_eq!(
            out.len(),
            tables_at as usize,
            "the directory's size is what was counted"
        );
        out.extend_from_slice(tables);
        // Without the entry the bytes are still skipped by the strip's position.
        out.extend_from_slice(raw);
        out
    }

    fn entry(&self, out: &mut Vec<u8>, tag: u16, value: u32) {
        self.put16(out, tag);
        self.put16(out, 4);
        self.put32(out, 1);
        self.put32(out, value);
    }

    fn short_entry(&self, out: &mut Vec<u8>, tag: u16, value: u16) {
        self.put16(out, tag);
        self.put16(out, 3);
        self.put32(out, 1);
        self.put16(out, value);
        self.put16(out, 0);
    }

    fn put16(&self, out: &mut Vec<u8>, value: u16) {
        out.extend_from_slice(&if self.big_endian {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        });
    }

    fn put32(&self, out: &mut Vec<u8>, value: u32) {
        out.extend_from_slice(&if self.big_endian {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        });
    }
}

/// One byte a sample from rows of packed bits, each row padded to a byte.
fn unpack(packed: &[u8], layout: &Layout, rows: u32) -> Vec<u8> {
    let bits = usize::from(layout.bits);
    let per_byte = 8 / bits;
    let mask = ((1u16 << bits) - 1) as u8;
    let row_samples = layout.chunk_width as usize * usize::from(layout.chunk_samples());
    let mut out = Vec::with_capacity(row_samples * rows as usize);
    for row in packed.chunks_exact(layout.row_bytes() as usize) {
        out.extend(
            (0..row_samples).map(|i| (row[i / per_byte] >> (8 - bits * (i % per_byte + 1))) & mask),
        );
    }
    out
}

/// Full-range YCbCr of JPEG to RGB in place (ITU-R BT.601, as JFIF 1.02 gives it), rounded.
fn rgb_from_ycbcr(samples: &mut [u8], per_pixel: usize) {
    for pixel in samples.chunks_exact_mut(per_pixel) {
        let y = f32::from(pixel[0]);
        let cb = f32::from(pixel[1]) - 128.0;
        let cr = f32::from(pixel[2]) - 128.0;
        pixel[0] = (y + 1.402 * cr + 0.5) as u8;
        pixel[1] = (y - 0.344_136_3 * cb - 0.714_136_3 * cr + 0.5) as u8;
        pixel[2] = (y + 1.772 * cb + 0.5) as u8;
    }
}

/// The size in a JPEG's frame header must be the chunk's: a decoder allocates by it.
fn check_jpeg_size(jpeg: &[u8], width: u32, rows: u32) -> Result<(), Fault> {
    let mut at = 2;
    while let Some([0xff, marker, high, low]) = jpeg.get(at..at + 4) {
        // Start of frame: C0 to CF without the tables C4, C8 and CC.
        if matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc) {
            let Some(frame) = jpeg.get(at + 5..at + 9) else {
                break;
            };
            let found = (
                u32::from(frame[2]) << 8 | u32::from(frame[3]),
                u32::from(frame[0]) << 8 | u32::from(frame[1]),
            );
            if found.0 != width || found.1 < rows || found.1 > rows + 16 {
                return damaged(format!(
                    "expected a JPEG of {width} x {rows} pixels in a strip or tile, found {} x {}",
                    found.0, found.1
                ));
            }
            return Ok(());
        }
        at += 2 + (usize::from(*high) << 8 | usize::from(*low));
    }
    damaged("expected a JPEG frame in a strip or tile, found none")
}
