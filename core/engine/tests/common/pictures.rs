//! Files of pictures for tests.

use std::path::Path;
use std::sync::Arc;

use relievo_engine::raster::file::Georeference;
use relievo_engine::raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_engine::raster::{Bands, Block, Cancel, PixelRect};

/// A square picture in degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    /// Western and southern edge in degrees.
    pub(crate) corner: [f64; 2],
    /// Pixels along a side.
    pub(crate) side: u32,
    /// Degrees from pixel to pixel.
    pub(crate) pixel_deg: f64,
}

/// Writes a picture of 8 bits; `colour`: display values by column and row from the north-west.
pub(crate) fn write_picture(
    path: &Path,
    square: Square,
    colour: impl Fn(u32, u32) -> [f64; 3] + Sync,
) {
    let [west, south] = square.corner;
    let pixel_deg = square.pixel_deg;
    let north = south + pixel_deg * f64::from(square.side);
    let layout = CogLayout {
        width: square.side,
        height: square.side,
        samples: CogSamples::Rgb8,
        tile: 256,
        georeference: Some(Georeference {
            crs: Arc::from("EPSG:4326"),
            plane_from_pixel: [west, pixel_deg, 0.0, north, 0.0, -pixel_deg],
        }),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: PixelRect| {
        let mut block = Block::new(Bands::Colour, rect.width as usize, rect.height as usize);
        let [red, green, blue, alpha] = block.planes_mut();
        for i in 0..red.len() {
            let (x, y) = (i as u32 % rect.width, i as u32 / rect.width);
            [red[i], green[i], blue[i]] = colour(rect.x + x, rect.y + y).map(|v| v as f32);
            alpha[i] = 1.0;
        }
        Ok(block)
    };
    let work = CogWork {
        threads: 1,
        resume: None,
        cancel: &Cancel::default(),
    };
    write_cog(path, &layout, &source, &work, &mut |_| {}).unwrap();
}
