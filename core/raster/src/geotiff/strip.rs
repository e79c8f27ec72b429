//! Chunks decoded by the `tiff` crate.
//!
//! The crate sees every chunk as a small file of one strip that exists in memory only. So chunks
//! decode in any thread without a shared decoder, palettes and masks pass as plain grey, and no count
//! in a header makes the crate allocate: all sizes were checked before.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::fault::Fault;
use super::layout::{Layout, SampleFormat, photometric};
use crate::text::one_line;

/// The samples of a chunk of so many rows; packed rows as rows of bytes.
pub(super) fn decode(
    raw: &[u8],
    layout: &Layout,
    rows: u32,
    big_endian: bool,
) -> Result<DecodingResult, Fault> {
    // Packed rows pass as rows of bytes.
    let (width, samples, bits, format) = if layout.is_packed() {
        (layout.row_bytes() as u32, 1, 8, SampleFormat::Unsigned)
    } else {
        (
            layout.chunk_width,
            layout.chunk_samples(),
            layout.bits,
            layout.format,
        )
    };
    let head = OneStrip {
        width,
        rows,
        samples,
        bits,
        format,
        layout,
        big_endian,
    }
    .bytes(raw);
    let fault = |error: tiff::TiffError| {
        Fault::Damaged(format!(
            "cannot decode a strip or tile: {}",
            one_line(error)
        ))
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = (layout.row_bytes() * u64::from(rows)) as usize;
    limits.intermediate_buffer_size = raw.len();
    let mut decoder = Decoder::new(Cursor::new(head))
        .map_err(fault)?
        .with_limits(limits);
    decoder.read_chunk(0).map_err(fault)
}

/// A chunk dressed as a TIFF of one strip.
struct OneStrip<'a> {
    width: u32,
    rows: u32,
    samples: u16,
    bits: u16,
    format: SampleFormat,
    layout: &'a Layout,
    big_endian: bool,
}

impl OneStrip<'_> {
    /// Header, one directory and the strip. Always a classic TIFF: a chunk is far below 4 GiB.
    fn bytes(&self, raw: &[u8]) -> Vec<u8> {
        let format = match self.format {
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
