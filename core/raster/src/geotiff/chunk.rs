//! Single chunks (strips, tiles): read, checked and handed to what decodes their compression.

use tiff::decoder::DecodingResult;

use super::fault::{Fault, damaged};
use super::ifd::TiffBytes;
use super::layout::{Layout, compression, photometric};
#[cfg(feature = "lerc")]
use super::lerc;
use super::{jpeg, packed, strip, webp};

/// Decoded samples of a chunk, pixel by pixel, in their stored type; packed bits are unpacked to
/// the next wider type, and YCbCr is RGB already.
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
    let samples = match layout.compression {
        #[cfg(feature = "lerc")]
        compression::LERC => lerc::decode(&raw, layout, rows, file.big_endian)?,
        #[cfg(not(feature = "lerc"))]
        compression::LERC => {
            return crate::fault::unsupported(
                "found LERC, which this program was built without (feature \"lerc\")",
            );
        }
        compression::WEBP => DecodingResult::U8(webp::decode(&raw, layout, rows)?),
        compression::JPEG => {
            jpeg::check_size(&raw, layout.chunk_width, rows)?;
            let mut samples = strip::decode(&raw, layout, rows, file.big_endian)?;
            if let DecodingResult::U8(bytes) = &mut samples
                && layout.photometric == photometric::YCBCR
                && layout.chunk_samples() >= 3
            {
                jpeg::rgb_from_ycbcr(bytes, layout.chunk_samples().into());
            }
            samples
        }
        _ => {
            let samples = strip::decode(&raw, layout, rows, file.big_endian)?;
            if let (DecodingResult::U8(bytes), true) = (&samples, layout.is_packed()) {
                packed::unpack(bytes, layout, file.big_endian)
            } else {
                samples
            }
        }
    };
    Ok(Some(Chunk { samples }))
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
        // A constant needs a header whatever the size, and may be compressed once more.
        compression::LERC => 1 << 20,
        // Empty blocks of 8 x 8 pixels take two bits a component at least.
        _ => 1024,
    }
}
