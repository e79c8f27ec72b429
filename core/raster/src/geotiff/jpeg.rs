//! What JPEG chunks need beyond their decoder: colours and a check of their size.

use super::fault::{Fault, damaged};

/// Full-range YCbCr of JPEG to RGB in place (ITU-R BT.601, as JFIF 1.02 gives it), rounded.
pub(super) fn rgb_from_ycbcr(samples: &mut [u8], per_pixel: usize) {
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
pub(super) fn check_size(jpeg: &[u8], width: u32, rows: u32) -> Result<(), Fault> {
    let mut at = 2;
    while let Some([0xff, marker, high, low]) = jpeg.get(at..at + 4) {
        if *marker == 0xda {
            // A scan before its frame: a frame further on is none.
            break;
        }
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
