//! Chunks in WebP compression.

use std::io::Cursor;

use image::codecs::webp::WebPDecoder;
use image::{ColorType, ImageDecoder};

use super::fault::{Fault, damaged};
use super::layout::Layout;
use crate::text::one_line;

/// The samples of a chunk of so many rows.
pub(super) fn decode(raw: &[u8], layout: &Layout, rows: u32) -> Result<Vec<u8>, Fault> {
    let fault = |error: image::ImageError| {
        Fault::Damaged(format!(
            "cannot decode a strip or tile of WebP: {}",
            one_line(error)
        ))
    };
    let decoder = WebPDecoder::new(Cursor::new(raw)).map_err(fault)?;
    // A decoder allocates by the size in its stream.
    let found = decoder.dimensions();
    if found != (layout.chunk_width, rows) {
        return damaged(format!(
            "expected a WebP of {} x {rows} pixels in a strip or tile, found {} x {}",
            layout.chunk_width, found.0, found.1
        ));
    }
    let stored = if decoder.color_type() == ColorType::Rgba8 {
        4
    } else {
        3
    };
    let mut samples = vec![0; found.0 as usize * found.1 as usize * stored];
    decoder.read_image(&mut samples).map_err(fault)?;
    Ok(match (stored, layout.samples) {
        (3, 4) => samples
            .as_chunks::<3>()
            .0
            .iter()
            .flat_map(|[r, g, b]| [*r, *g, *b, u8::MAX])
            .collect(),
        (4, 3) => samples
            .as_chunks::<4>()
            .0
            .iter()
            .flat_map(|[r, g, b, _]| [*r, *g, *b])
            .collect(),
        _ => samples,
    })
}
