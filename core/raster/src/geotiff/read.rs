//! Regions of a level: chunks fetched, converted and put together.

use std::sync::Arc;

use super::GeoTiff;
use super::chunk::{self, Chunk};
use super::fault::Fault;
use super::layout::Layout;
use super::levels::Image;
use super::samples::{BandView, Colours, Heights, Meaning, Window};
use crate::chunk_cache::ChunkKey;
use crate::file::{Cancel, PixelRect, ReadError};
use crate::parts::{Part, parts};
use crate::{Bands, Block};

/// The part of a wanted rectangle that one chunk holds.
struct Place<'a> {
    /// Number of the image in the cache.
    number: u32,
    image: &'a Image,
    part: Part,
}

impl Place<'_> {
    fn window(&self) -> Window {
        Window {
            chunk_width: self.image.layout.chunk_width as usize,
            x: self.part.in_cell.0,
            y: self.part.in_cell.1,
            width: self.part.size.0,
            height: self.part.size.1,
        }
    }

    /// First sample of the part in a block of so many columns.
    fn start(&self, width: usize) -> usize {
        self.part.in_rect.1 * width + self.part.in_rect.0
    }
}

/// All chunks that hold a part of a rectangle, row by row.
fn places(number: u32, image: &Image, rect: PixelRect) -> impl Iterator<Item = Place<'_>> {
    parts(rect, (image.layout.chunk_width, image.layout.chunk_height)).map(move |part| Place {
        number,
        image,
        part,
    })
}

/// How to walk one band of a chunk.
pub(super) fn view<'a>(layout: &Layout, chunk: Option<&'a Chunk>, band: u16) -> BandView<'a> {
    let (step, first) = if layout.planar {
        (1, 0)
    } else {
        (layout.samples, band)
    };
    BandView {
        samples: chunk.map(|c| &c.samples),
        step: step.into(),
        first: first.into(),
    }
}

impl GeoTiff {
    /// Reads a rectangle of a level into a block of its shape.
    pub(super) fn read_level(
        &self,
        level: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let fault = |fault: Fault| super::read_error(fault, &self.info.path);
        let images = &self.levels[level];
        let number = 2 * level as u32;
        for place in places(number, &images.image, rect) {
            if cancel.is_cancelled() {
                return Err(ReadError::Cancelled);
            }
            match &self.meaning {
                Meaning::Height(how) => self.read_heights(how, &place, out),
                Meaning::Colour(how) => self.read_colours(how, &place, out),
            }
            .map_err(fault)?;
        }
        if let Some(mask) = &images.mask {
            for place in places(number + 1, mask, rect) {
                self.apply_mask(&place, out).map_err(fault)?;
            }
        }
        Ok(())
    }

    /// A chunk that holds a band, from the cache.
    pub(super) fn chunk(
        &self,
        number: u32,
        image: &Image,
        band: u16,
        column: u32,
        row: u32,
    ) -> Result<Option<Arc<Chunk>>, Fault> {
        let plane = if image.layout.planar { band } else { 0 };
        let key = ChunkKey {
            file: self.number,
            image: number,
            plane,
            column,
            row,
        };
        let bytes = image.layout.chunk_bytes();
        self.cache.get_sized(key, bytes, || {
            chunk::decode(&image.file, &image.layout, plane, column, row)
        })
    }

    fn chunk_at(&self, place: &Place<'_>, band: u16) -> Result<Option<Arc<Chunk>>, Fault> {
        self.chunk(
            place.number,
            place.image,
            band,
            place.part.column,
            place.part.row,
        )
    }

    fn read_heights(&self, how: &Heights, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let layout = &place.image.layout;
        let band = self.chunk_at(place, how.band)?;
        let alpha = match how.alpha {
            Some(alpha) => Some((self.chunk_at(place, alpha)?, alpha)),
            None => None,
        };
        let band = view(layout, band.as_deref(), how.band);
        let alpha = alpha
            .as_ref()
            .map(|(chunk, band)| view(layout, chunk.as_deref(), *band));
        let width = out.width();
        let start = place.start(width);
        how.read(
            &band,
            alpha.as_ref(),
            place.window(),
            &mut out.plane_mut(0)[start..],
            width,
        );
        Ok(())
    }

    fn read_colours(&self, how: &Colours, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let layout = &place.image.layout;
        let chunks = [
            self.chunk_at(place, how.bands[0])?,
            self.chunk_at(place, how.bands[1])?,
            self.chunk_at(place, how.bands[2])?,
        ];
        let alpha = match how.alpha {
            Some(alpha) => Some((self.chunk_at(place, alpha.band)?, alpha.band)),
            None => None,
        };
        let [r, g, b] = [0, 1, 2].map(|i| view(layout, chunks[i].as_deref(), how.bands[i]));
        let alpha = alpha
            .as_ref()
            .map(|(chunk, band)| view(layout, chunk.as_deref(), *band));
        let window = place.window();
        let width = out.width();
        let start = place.start(width);
        if how.read_bytes([&r, &g, &b], alpha.as_ref(), window, start, out) {
            return Ok(());
        }
        let mut colours = Vec::new();
        how.read([&r, &g, &b], alpha.as_ref(), window, &mut colours);
        let planes: [&mut [f32]; 4] = out.planes_mut();
        for (plane, values) in planes.into_iter().enumerate() {
            for (y, row) in colours.chunks_exact(window.width).enumerate() {
                let start = start + y * width;
                for (value, colour) in values[start..start + row.len()].iter_mut().zip(row) {
                    *value = colour[plane];
                }
            }
        }
        Ok(())
    }

    /// Empties what the mask of a level leaves out.
    fn apply_mask(&self, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let chunk = self.chunk_at(place, 0)?;
        let window = place.window();
        let width = out.width();
        let start = place.start(width);
        let empty = if out.bands() == Bands::Height {
            f32::NAN
        } else {
            0.0
        };
        let mut holes = Vec::new();
        view(&place.image.layout, chunk.as_deref(), 0).for_each(window, None, |i, value, _| {
            if value.is_nan() || value == 0.0 {
                holes.push(start + i / window.width * width + i % window.width);
            }
        });
        for plane in 0..out.bands().planes() {
            let samples = out.plane_mut(plane);
            for i in &holes {
                samples[*i] = empty;
            }
        }
        Ok(())
    }
}
