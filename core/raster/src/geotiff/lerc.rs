//! Chunks in LERC compression, plain or compressed once more.
//!
//! Source: libtiff's `tif_lerc.c` for what surrounds the LERC blob: the second compression, holes in
//! floats, and alpha as the blob's mask.

use std::io::Read;

use lerc_core::PixelData;
use lerc_reader::{Decoded, InspectOptions};
use tiff::decoder::DecodingResult;

use super::fault::{Fault, damaged, unsupported};
use super::layout::{Layout, LercWrapping, SampleFormat};
use crate::text::one_line;

/// Bytes of a LERC blob beyond its raw samples at most: headers and a mask.
const HEADER_BYTES: u64 = 1 << 16;

/// The samples of a chunk of so many rows.
pub(super) fn decode(
    raw: &[u8],
    layout: &Layout,
    rows: u32,
    big_endian: bool,
) -> Result<DecodingResult, Fault> {
    let pixels = u64::from(layout.chunk_width) * u64::from(rows);
    let limit = layout.row_bytes() * u64::from(rows) * 2 + pixels / 8 + HEADER_BYTES;
    let unwrapped;
    let blob = match layout.lerc {
        LercWrapping::None => raw,
        LercWrapping::Deflate => {
            unwrapped = read_all(flate2::read::ZlibDecoder::new(raw), limit)?;
            &unwrapped
        }
        LercWrapping::Zstd => {
            unwrapped = read_all(zstd::Decoder::with_buffer(raw)?, limit)?;
            &unwrapped
        }
    };
    let fault = |error: lerc_core::Error| {
        Fault::Damaged(format!(
            "cannot decode a strip or tile of LERC: {}",
            one_line(error)
        ))
    };
    // The decoder allocates by what the blob says of itself.
    let options = InspectOptions::new().with_compute_value_range(false);
    let info = lerc_reader::inspect_first_with_options(blob, options).map_err(fault)?;
    let samples = u32::from(layout.chunk_samples());
    if (info.width, info.height) != (layout.chunk_width, rows)
        || info.depth == 0
        || info.depth.abs_diff(samples) > 1
    {
        return damaged(format!(
            "expected LERC of {} x {rows} pixels of {samples} samples, found {} x {} of {}",
            layout.chunk_width, info.width, info.height, info.depth
        ));
    }
    let decoded = lerc_reader::decode_first(blob).map_err(fault)?;
    if info.depth == samples {
        let mut samples = whole(decoded, layout)?;
        if big_endian {
            // libtiff swaps bytes before it compresses: the blob's numbers are those of another order.
            swap_bytes(&mut samples);
        }
        Ok(samples)
    } else if info.depth + 1 == samples {
        with_alpha(&decoded, layout)
    } else {
        damaged(format!(
            "expected {samples} samples a pixel in LERC, found {}",
            info.depth
        ))
    }
}

/// All that a reader gives, if it is no more than `limit` bytes.
fn read_all(reader: impl Read, limit: u64) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    reader
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| {
            Fault::Damaged(format!(
                "cannot decompress a strip or tile of LERC: {}",
                one_line(e)
            ))
        })?;
    if bytes.len() as u64 > limit {
        return damaged(format!(
            "expected at most {limit} bytes of LERC in a strip or tile, found more"
        ));
    }
    Ok(bytes)
}

/// Samples as the layout expects them; what a mask leaves out is NaN in floats.
fn whole(decoded: Decoded, layout: &Layout) -> Result<DecodingResult, Fault> {
    let per_pixel = usize::from(layout.chunk_samples());
    let holes = decoded.mask.unwrap_or_default();
    let samples = match decoded.pixels {
        PixelData::U8(v) => DecodingResult::U8(v),
        PixelData::I8(v) => DecodingResult::I8(v),
        PixelData::U16(v) => DecodingResult::U16(v),
        PixelData::I16(v) => DecodingResult::I16(v),
        PixelData::U32(v) => DecodingResult::U32(v),
        PixelData::I32(v) => DecodingResult::I32(v),
        PixelData::F32(mut v) => {
            for (pixel, valid) in v.chunks_exact_mut(per_pixel).zip(&holes) {
                if *valid == 0 {
                    pixel.fill(f32::NAN);
                }
            }
            DecodingResult::F32(v)
        }
        PixelData::F64(mut v) => {
            for (pixel, valid) in v.chunks_exact_mut(per_pixel).zip(&holes) {
                if *valid == 0 {
                    pixel.fill(f64::NAN);
                }
            }
            DecodingResult::F64(v)
        }
    };
    let found = match samples {
        DecodingResult::U8(_) => (SampleFormat::Unsigned, 8),
        DecodingResult::U16(_) => (SampleFormat::Unsigned, 16),
        DecodingResult::U32(_) => (SampleFormat::Unsigned, 32),
        DecodingResult::I8(_) => (SampleFormat::Signed, 8),
        DecodingResult::I16(_) => (SampleFormat::Signed, 16),
        DecodingResult::I32(_) => (SampleFormat::Signed, 32),
        DecodingResult::F32(_) => (SampleFormat::Float, 32),
        DecodingResult::F64(_)
        | DecodingResult::F16(_)
        | DecodingResult::U64(_)
        | DecodingResult::I64(_) => (SampleFormat::Float, 64),
    };
    if found == (layout.format, layout.bits) {
        return Ok(samples);
    }
    damaged(format!(
        "expected {}-bit {:?} samples in LERC, found {}-bit {:?}",
        layout.bits, layout.format, found.1, found.0
    ))
}

fn swap_bytes(samples: &mut DecodingResult) {
    match samples {
        DecodingResult::U16(v) => v.iter_mut().for_each(|n| *n = n.swap_bytes()),
        DecodingResult::I16(v) => v.iter_mut().for_each(|n| *n = n.swap_bytes()),
        DecodingResult::U32(v) => v.iter_mut().for_each(|n| *n = n.swap_bytes()),
        DecodingResult::I32(v) => v.iter_mut().for_each(|n| *n = n.swap_bytes()),
        DecodingResult::F32(v) => {
            for n in v {
                *n = f32::from_bits(n.to_bits().swap_bytes());
            }
        }
        DecodingResult::F64(v) => {
            for n in v {
                *n = f64::from_bits(n.to_bits().swap_bytes());
            }
        }
        DecodingResult::U8(_)
        | DecodingResult::I8(_)
        | DecodingResult::F16(_)
        | DecodingResult::U64(_)
        | DecodingResult::I64(_) => {}
    }
}

/// Colours whose last sample, alpha, is the mask: full or zero.
fn with_alpha(decoded: &Decoded, layout: &Layout) -> Result<DecodingResult, Fault> {
    let colours = usize::from(layout.chunk_samples()) - 1;
    let mask = decoded.mask.as_deref();
    match &decoded.pixels {
        PixelData::U8(v) if layout.bits == 8 => {
            Ok(DecodingResult::U8(interleave(v, colours, mask, u8::MAX)))
        }
        PixelData::U16(v) if layout.bits == 16 => {
            Ok(DecodingResult::U16(interleave(v, colours, mask, u16::MAX)))
        }
        PixelData::U8(_)
        | PixelData::I8(_)
        | PixelData::U16(_)
        | PixelData::I16(_)
        | PixelData::U32(_)
        | PixelData::I32(_)
        | PixelData::F32(_)
        | PixelData::F64(_) => unsupported(format!(
            "expected 8 or 16-bit colours with a mask in LERC, found {}-bit {:?} samples",
            layout.bits, layout.format
        )),
    }
}

fn interleave<T: Copy + Default>(
    colours: &[T],
    per_pixel: usize,
    mask: Option<&[u8]>,
    full: T,
) -> Vec<T> {
    let mut out = Vec::with_capacity(colours.len() / per_pixel * (per_pixel + 1));
    for (i, pixel) in colours.chunks_exact(per_pixel).enumerate() {
        out.extend_from_slice(pixel);
        let valid = mask.is_none_or(|m| m.get(i).is_some_and(|v| *v != 0));
        out.push(if valid { full } else { T::default() });
    }
    out
}
