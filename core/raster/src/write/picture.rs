//! PNG.

use std::path::Path;

use super::{WriteError, atomically};
use crate::{Bands, Block, colour};

/// What a PNG stores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Png {
    /// 8 bits a channel, sRGB; alpha is dropped.
    Rgb8,
    /// 8 bits a channel, sRGB, straight alpha.
    Rgba8,
    /// Heights as 16-bit grey: 0 is a hole, 1 to 65535 run linearly from the first to the second
    /// height in metres; heights beyond clamp.
    Heights16 {
        /// Height stored as 1.
        low_m: f32,
        /// Height stored as 65535.
        high_m: f32,
    },
}

/// Writes a block as PNG, whole or not at all.
///
/// # Errors
/// [`WriteError`] when the block does not hold what `png` stores or is empty, or the system
/// refuses.
pub fn write_png(path: &Path, block: &Block, png: Png) -> Result<(), WriteError> {
    let unsupported = |reason: String| WriteError::Unsupported {
        reason,
        path: path.to_owned(),
    };
    let expected = if matches!(png, Png::Heights16 { .. }) {
        Bands::Height
    } else {
        Bands::Colour
    };
    if block.bands() != expected {
        return Err(unsupported(format!(
            "expected samples of {expected:?}, found {:?}",
            block.bands()
        )));
    }
    let (Ok(width), Ok(height)) = (u32::try_from(block.width()), u32::try_from(block.height()))
    else {
        return Err(unsupported("expected sides below 2³²".into()));
    };
    if width == 0 || height == 0 {
        return Err(unsupported(format!(
            "expected a picture with an area, found {width} × {height}"
        )));
    }
    let (kind, depth, data) = match png {
        Png::Rgb8 => (
            png::ColorType::Rgb,
            png::BitDepth::Eight,
            bytes_of(block, 3),
        ),
        Png::Rgba8 => (
            png::ColorType::Rgba,
            png::BitDepth::Eight,
            bytes_of(block, 4),
        ),
        Png::Heights16 { low_m, high_m } => {
            let scale = 65_534.0 / (high_m - low_m).max(f32::MIN_POSITIVE);
            let grey = |h: &f32| {
                if h.is_nan() {
                    0
                } else {
                    (1.5 + (h - low_m) * scale).clamp(1.0, 65_535.0) as u16
                }
            };
            let data = block
                .plane(0)
                .iter()
                .flat_map(|h| grey(h).to_be_bytes())
                .collect();
            (png::ColorType::Grayscale, png::BitDepth::Sixteen, data)
        }
    };
    atomically(path, |to| {
        let mut encoder = png::Encoder::new(to, width, height);
        encoder.set_color(kind);
        encoder.set_depth(depth);
        if kind != png::ColorType::Grayscale {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&data)?;
        writer.finish()?;
        Ok(())
    })
}

/// The first `channels` planes, interleaved, 8 bits each.
pub(super) fn bytes_of(block: &Block, channels: usize) -> Vec<u8> {
    let mut bytes = vec![0; block.width() * block.height() * channels];
    for channel in 0..channels {
        for (byte, v) in bytes[channel..]
            .iter_mut()
            .step_by(channels)
            .zip(block.plane(channel))
        {
            *byte = colour::to_u8(*v);
        }
    }
    bytes
}
