//! From the bytes of a tile to samples.

use std::io::{Cursor, Read};

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use tiff::decoder::DecodingResult;

use super::encoding::HeightEncoding;
use crate::fault::{Fault, damaged, unsupported};
use crate::geotiff::Chunk;

/// Bytes of a compressed tile at most.
pub(super) const MAX_TILE_BYTES: u64 = 64 << 20;
/// Sides that tiles may have.
const SIDES: core::ops::RangeInclusive<u32> = 64..=4096;

/// What the pixels of tiles mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    Colour,
    Height {
        encoding: HeightEncoding,
        /// The height that means nodata instead of black.
        nodata: Option<f32>,
    },
}

/// Name and codec of the picture that bytes hold.
pub(super) fn format(bytes: &[u8]) -> Result<(&'static str, ImageFormat), Fault> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Ok(("PNG", ImageFormat::Png)),
        [0xff, 0xd8, 0xff, ..] => Ok(("JPEG", ImageFormat::Jpeg)),
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => Ok(("WebP", ImageFormat::WebP)),
        [] => damaged("expected a picture, found an empty tile"),
        [0x1a, ..] => unsupported("expected PNG, JPEG or WebP tiles, found vector tiles (pbf)"),
        other => {
            let hex: Vec<String> = other.iter().take(4).map(|b| format!("{b:02x}")).collect();
            unsupported(format!(
                "expected PNG, JPEG or WebP tiles, found one that starts with {}",
                hex.join(" ")
            ))
        }
    }
}

/// The bytes behind a gzip wrapper, or the bytes themselves.
pub(super) fn unwrapped(bytes: Vec<u8>) -> Result<Vec<u8>, Fault> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let mut inner = Vec::new();
    flate2::read::GzDecoder::new(bytes.as_slice())
        .take(MAX_TILE_BYTES + 1)
        .read_to_end(&mut inner)
        .map_err(|e| Fault::Damaged(format!("cannot decompress a tile: {e}")))?;
    if inner.len() as u64 > MAX_TILE_BYTES {
        return damaged(format!(
            "expected tiles of at most {} MiB, found more",
            MAX_TILE_BYTES >> 20
        ));
    }
    Ok(inner)
}

/// The side of a tile in pixels.
pub(super) fn side(bytes: &[u8]) -> Result<u32, Fault> {
    let (width, height) = decoder(bytes)?.dimensions();
    if width != height || !width.is_power_of_two() || !SIDES.contains(&width) {
        return unsupported(format!(
            "expected square tiles with a power of two from 64 to 4096 pixels, found {width} × {height}"
        ));
    }
    Ok(width)
}

fn decoder(bytes: &[u8]) -> Result<impl ImageDecoder + '_, Fault> {
    let (_, codec) = format(bytes)?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(*SIDES.end());
    limits.max_image_height = Some(*SIDES.end());
    limits.max_alloc = Some(256 << 20);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), codec);
    reader.limits(limits);
    reader.into_decoder().map_err(|e| broken(&e))
}

fn broken(error: &image::ImageError) -> Fault {
    let text = error.to_string();
    let line: Vec<&str> = text.split_whitespace().collect();
    Fault::Damaged(line.join(" "))
}

/// Decodes a tile of a known side: RGBA of 8 bits, or heights.
pub(super) fn decode(bytes: &[u8], side: u32, content: Content) -> Result<Chunk, Fault> {
    let decoder = decoder(bytes)?;
    let (width, height) = decoder.dimensions();
    if (width, height) != (side, side) {
        return damaged(format!(
            "expected a tile of {side} × {side} pixels as the first one, found {width} × {height}"
        ));
    }
    let kind = decoder.color_type();
    if let Content::Height { .. } = content {
        check_exact(bytes, kind)?;
    }
    let rgba = DynamicImage::from_decoder(decoder)
        .map_err(|e| broken(&e))?
        .into_rgba8()
        .into_raw();
    let samples = match content {
        Content::Colour => {
            let mut rgba = rgba;
            for pixel in rgba.as_chunks_mut::<4>().0 {
                if pixel[3] == 0 {
                    *pixel = [0; 4];
                }
            }
            DecodingResult::U8(rgba)
        }
        Content::Height { encoding, nodata } => DecodingResult::F32(
            rgba.as_chunks::<4>()
                .0
                .iter()
                .map(|[r, g, b, a]| {
                    let code = [*r, *g, *b];
                    let height = encoding.height_m(code);
                    let hole = nodata.map_or(code == [0; 3], |n| n == height);
                    if *a == 0 || hole { f32::NAN } else { height }
                })
                .collect(),
        ),
    };
    Ok(Chunk { samples })
}

/// Refuses what cannot hold codes exactly.
fn check_exact(bytes: &[u8], kind: ColorType) -> Result<(), Fault> {
    let lossy = bytes.starts_with(&[0xff, 0xd8]) || is_lossy_webp(bytes);
    if lossy {
        return unsupported(
            "expected lossless tiles (PNG, lossless WebP) for heights, found lossy ones",
        );
    }
    if !matches!(kind, ColorType::Rgb8 | ColorType::Rgba8) {
        return unsupported(format!(
            "expected 8-bit red, green and blue for encoded heights, found {kind:?}"
        ));
    }
    Ok(())
}

/// Whether a WebP holds a picture in VP8, which is lossy.
fn is_lossy_webp(bytes: &[u8]) -> bool {
    if !bytes.starts_with(b"RIFF") {
        return false;
    }
    let mut at = 12;
    while let Some(head) = bytes.get(at..at + 8) {
        match &head[..4] {
            b"VP8 " => return true,
            b"VP8L" => return false,
            _ => {}
        }
        let size = u32::from_le_bytes([head[4], head[5], head[6], head[7]]) as usize;
        at += 8 + size + size % 2;
    }
    false
}
