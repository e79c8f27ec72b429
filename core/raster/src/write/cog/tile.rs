//! Tiles as they are stored: interleaved, predicted, compressed; and back again.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use super::CogSamples;
use crate::write::picture;
use crate::{Bands, Block, colour, normal};

/// Deflate level: within some percent of the smallest, several times as fast.
const DEFLATE_LEVEL: u32 = 6;

/// Compresses a block, at most a tile large; what the image does not fill is holes, transparency or
/// level ground.
pub(super) fn encode(block: &Block, side: u32, samples: CogSamples) -> io::Result<Vec<u8>> {
    let side = side as usize;
    let mut padded = Block::new(block.bands(), side, side);
    if let CogSamples::Height { .. } = samples {
        padded.samples_mut().fill(f32::NAN);
    }
    padded.copy_from(block, (0, 0), (0, 0), (block.width(), block.height()));
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(DEFLATE_LEVEL));
    encoder.write_all(&bytes_of_tile(&padded, samples))?;
    encoder.finish()
}

/// The samples of a tile as a reader finds them.
pub(super) fn decode(compressed: &[u8], side: u32, samples: CogSamples) -> io::Result<Block> {
    let side = side as usize;
    let channels = samples.channels();
    let sample_bytes = if samples.is_float() { 4 } else { 1 };
    let mut bytes = vec![0; side * side * channels * sample_bytes];
    ZlibDecoder::new(compressed).read_exact(&mut bytes)?;
    let mut block = Block::new(samples.bands(), side, side);
    let planes = samples.bands().planes();
    let mut values = vec![0.0; side * channels];
    for (y, row) in bytes
        .chunks_exact_mut(side * channels * sample_bytes)
        .enumerate()
    {
        for i in channels..row.len() {
            row[i] = row[i].wrapping_add(row[i - channels]);
        }
        for (i, value) in values.iter_mut().enumerate() {
            *value = if samples.is_float() {
                let count = side * channels;
                f32::from_be_bytes([
                    row[i],
                    row[count + i],
                    row[2 * count + i],
                    row[3 * count + i],
                ])
            } else if samples == CogSamples::Normal8 {
                (f32::from(row[i]) - 127.0) / 127.0
            } else {
                colour::from_u8(row[i])
            };
        }
        if samples.bands() == Bands::Normal {
            for pixel in values.chunks_exact_mut(channels) {
                let unit = [0, 1, 2].map(|c| f64::from(pixel[c]));
                [pixel[0], pixel[1]] = normal::coordinates(unit.into());
            }
        }
        for plane in 0..planes.min(channels) {
            let out = &mut block.plane_mut(plane)[y * side..(y + 1) * side];
            for (v, pixel) in out.iter_mut().zip(values.chunks_exact(channels)) {
                *v = pixel[plane];
            }
        }
    }
    match samples {
        CogSamples::Rgb8 => block.plane_mut(3).fill(1.0),
        CogSamples::Height { nodata } => {
            for height in block.plane_mut(0) {
                if *height == nodata {
                    *height = f32::NAN;
                }
            }
        }
        CogSamples::Rgba8 | CogSamples::Normal8 | CogSamples::NormalF32 => {}
    }
    Ok(block)
}

/// A tile's samples interleaved and predicted, as they are compressed.
fn bytes_of_tile(block: &Block, samples: CogSamples) -> Vec<u8> {
    let channels = samples.channels();
    if samples.is_float() {
        let width = block.width();
        let mut out = Vec::with_capacity(width * block.height() * channels * 4);
        let mut row = vec![0.0_f32; width * channels];
        for y in 0..block.height() {
            for (x, pixel) in row.chunks_exact_mut(channels).enumerate() {
                let i = y * width + x;
                match samples {
                    CogSamples::Height { nodata } => {
                        let h = block.plane(0)[i];
                        pixel[0] = if h.is_nan() { nodata } else { h };
                    }
                    CogSamples::Rgb8
                    | CogSamples::Rgba8
                    | CogSamples::Normal8
                    | CogSamples::NormalF32 => pixel.copy_from_slice(&east_north_up(block, i)),
                }
            }
            predict_floats(&row, channels, &mut out);
        }
        return out;
    }
    let mut bytes = if samples == CogSamples::Normal8 {
        (0..block.width() * block.height())
            .flat_map(|i| east_north_up(block, i).map(|c| (c * 127.0 + 127.5) as u8))
            .collect()
    } else {
        picture::bytes_of(block, channels)
    };
    for row in bytes.chunks_exact_mut(block.width() * channels) {
        for i in (channels..row.len()).rev() {
            row[i] = row[i].wrapping_sub(row[i - channels]);
        }
    }
    bytes
}

/// The unit normal of a sample.
fn east_north_up(block: &Block, i: usize) -> [f32; 3] {
    let unit = normal::unit([block.plane(0)[i], block.plane(1)[i]]);
    unit.as_vec3().to_array()
}

/// Predictor 3: bytes of a row by significance, then differences of bytes.
///
/// Source: Adobe Photoshop TIFF Technical Note 3, 2005.
fn predict_floats(row: &[f32], channels: usize, out: &mut Vec<u8>) {
    let start = out.len();
    for byte in 0..4 {
        out.extend(row.iter().map(|v| v.to_be_bytes()[byte]));
    }
    let bytes = &mut out[start..];
    for i in (channels..bytes.len()).rev() {
        bytes[i] = bytes[i].wrapping_sub(bytes[i - channels]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_back_is_what_was_stored() {
        let side = 16;
        let count = (side * side) as usize;
        let shades = |planes: usize, scale: f32| {
            let mut block = Block::new(CogSamples::Rgba8.bands(), side as usize, side as usize);
            for plane in 0..planes {
                for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
                    *v = colour::from_u8(((i * 7 + plane * 50) % 256) as u8) * scale;
                }
            }
            block
        };
        let colours = shades(4, 1.0);
        let stored = encode(&colours, side, CogSamples::Rgba8).expect("memory");
        assert_eq!(
            decode(&stored, side, CogSamples::Rgba8).expect("whole"),
            colours
        );
        let samples = CogSamples::Height { nodata: -1.0 };
        let mut heights = Block::new(samples.bands(), side as usize, side as usize);
        for (i, v) in heights.plane_mut(0).iter_mut().enumerate() {
            *v = if i % 9 == 0 {
                f32::NAN
            } else {
                i as f32 * 1.37
            };
        }
        let stored = encode(&heights, side, samples).expect("memory");
        let found = decode(&stored, side, samples).expect("whole");
        let same = |(a, b): (&f32, &f32)| a == b || (a.is_nan() && b.is_nan());
        assert!(found.samples().iter().zip(heights.samples()).all(same));
        let mut normals = Block::filled(
            CogSamples::NormalF32.bands(),
            side as usize,
            side as usize,
            &[0.0, 0.5],
        );
        normals.plane_mut(0)[count / 2] = 0.25;
        let stored = encode(&normals, side, CogSamples::NormalF32).expect("memory");
        let found = decode(&stored, side, CogSamples::NormalF32).expect("whole");
        // Files hold the normals' components.
        let rounding = 2.0 * f32::EPSILON;
        assert!(
            found
                .samples()
                .iter()
                .zip(normals.samples())
                .all(|(a, b)| (a - b).abs() <= rounding)
        );
        let stored = encode(&normals, side, CogSamples::Normal8).expect("memory");
        let found = decode(&stored, side, CogSamples::Normal8).expect("whole");
        assert!(
            found
                .samples()
                .iter()
                .zip(normals.samples())
                .all(|(a, b)| (a - b).abs() < 0.004)
        );
        assert!(decode(&stored[..stored.len() / 2], side, CogSamples::Normal8).is_err());
    }
}
