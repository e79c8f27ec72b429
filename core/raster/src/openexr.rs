//! OpenEXR: heights or colours of high dynamic range.
//!
//! The `exr` crate parses headers and decompresses single blocks; where blocks lie is read here,
//! block by block, so that neither offset tables nor sizes in a header cost memory. Scan lines and
//! tiles, mip levels as overviews (of rip maps the full image only), half, float and unsigned
//! samples, several parts (the first that can be used). The raster is the data window; its first
//! pixel is pixel (0, 0) whatever the window's own coordinates.
//!
//! - Heights: metres; NaN and infinities are holes.
//! - Colours: the file's linear, premultiplied light becomes straight and display-referred; values
//!   above 1 stay. Infinities become the largest half float, NaN makes a hole.
//!
//! Deliberately absent: deep data, subsampled channels, luminance and chroma, HTJ2K.

mod block;
mod channels;
mod part;
pub(crate) mod place;

use std::path::Path;
use std::sync::Arc;

use crate::chunk_cache::{ChunkCache, ChunkKey};
use crate::fault::Fault;
use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::geotiff::{Bytes, Chunk, Numbers, shown_range};
use crate::open::{OpenError, OpenOptions, Stretch, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, prj, pyramid, worldfile};
use channels::Meaning;
use part::Exr;

/// The format's name in messages.
const FORMAT: &str = "OpenEXR";
/// Decoded bytes of a block above which level 0 is copied into the pyramid too.
const AWKWARD_BLOCK_BYTES: u64 = 8 << 20;
/// Blocks looked at to choose a stretch.
const STRETCH_BLOCKS: u64 = 64;
/// Samples kept to choose a stretch.
const STRETCH_SAMPLES: usize = 1 << 18;

/// An open OpenEXR file.
struct OpenExr {
    info: RasterInfo,
    exr: Exr,
    meaning: Meaning,
    fingerprint: [u8; 32],
    cache: Arc<ChunkCache>,
    /// Number of the file in the cache.
    number: u64,
}

/// Opens an OpenEXR file and completes its pyramid.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(options.sample_facts().as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let file = OpenExr::new(Bytes::open(path).map_err(io)?, path, fingerprint, options)?;
    let awkward = file.exr.block_bytes() > AWKWARD_BLOCK_BYTES;
    pyramid::complete(Arc::new(file), awkward, fingerprint, options)
}

impl OpenExr {
    fn new(
        bytes: Bytes,
        path: &Path,
        fingerprint: [u8; 32],
        options: &OpenOptions,
    ) -> Result<Self, OpenError> {
        let exr = Exr::open(bytes).map_err(|f| f.on_open(FORMAT, path))?;
        let meaning = Meaning::of(exr.header(), options).map_err(|reason| OpenError::Options {
            reason,
            path: path.to_owned(),
        })?;
        let size = exr.levels[0].size;
        let (affine, crs) = if options.georeference.is_some() {
            (None, None)
        } else if let Some(affine) = place::affine(exr.header()) {
            (Some(affine), place::crs(exr.header()))
        } else {
            let beside =
                worldfile::beside(path).map_err(|(companion, reason)| OpenError::Companion {
                    reason,
                    companion,
                    path: path.to_owned(),
                })?;
            let assumed = beside
                .and_then(|a| worldfile::assumed_crs(&a, size.width, size.height))
                .map(str::to_owned);
            let own = place::crs(exr.header()).or_else(|| prj::beside(path));
            (beside, own.or(assumed))
        };
        let info = RasterInfo {
            path: path.to_owned(),
            format: FORMAT,
            overviews: exr.levels.iter().map(|l| l.size).collect(),
            bands: meaning.bands(),
            band_count: exr.header().channels.list.len() as u16,
            sample_type: meaning.sample_type(&exr),
            compression: part::compression_name(exr.header().compression).into(),
            deep_colour: meaning.bands() == Bands::Colour,
            nodata: options.nodata,
            may_have_holes: true,
            georeference: placed(affine, crs, options),
        };
        let cache = Arc::clone(&options.chunk_cache);
        let number = cache.new_file();
        let mut file = Self {
            info,
            exr,
            meaning,
            fingerprint,
            cache,
            number,
        };
        let range = file
            .stretch(options.stretch)
            .map_err(|f| f.on_open(FORMAT, path))?;
        if let Meaning::Colour(colours) = &mut file.meaning {
            colours.range = range;
        }
        Ok(file)
    }

    /// The range of linear light to show as 0 to 1; `None` leaves light as it is.
    fn stretch(&self, stretch: Stretch) -> Result<Option<(f64, f64)>, Fault> {
        let Meaning::Colour(colours) = &self.meaning else {
            return Ok(None);
        };
        match stretch {
            // Light is absolute: black is 0 and white is 1 unless somebody says otherwise.
            Stretch::Auto | Stretch::Full => return Ok(None),
            Stretch::Range { low, high } => return Ok(Some((low, high))),
            Stretch::MinMax | Stretch::Percentile { .. } => {}
        }
        let index = self.exr.levels.len() - 1;
        let level = &self.exr.levels[index];
        let blocks = u64::from(level.columns) * u64::from(level.rows);
        let looked_at = blocks.min(STRETCH_BLOCKS);
        let most = (STRETCH_SAMPLES as u64 / looked_at).max(1) as usize;
        let mut values = Vec::new();
        for i in 0..looked_at {
            let at = i * blocks / looked_at;
            let (column, row) = (
                (at % u64::from(level.columns)) as u32,
                (at / u64::from(level.columns)) as u32,
            );
            let Some(raw) = self.exr.block(index, column, row)? else {
                continue;
            };
            for channel in colours.rgb {
                let every = (raw.width * raw.height / most).max(1);
                values.extend(
                    raw.samples(channel)
                        .step_by(every)
                        .filter(|v| v.is_finite())
                        .map(f64::from),
                );
            }
        }
        Ok(shown_range(
            &mut values,
            stretch,
            (0.0, 1.0),
            Numbers::Floats,
        ))
    }

    /// A decoded block from the cache: heights, or colours interleaved.
    fn chunk(&self, level: usize, column: u32, row: u32) -> Result<Option<Arc<Chunk>>, Fault> {
        let key = ChunkKey {
            file: self.number,
            image: level as u32,
            plane: 0,
            column,
            row,
        };
        self.cache.get(key, || {
            let raw = self.exr.block(level, column, row)?;
            Ok(raw.map(|raw| Chunk {
                samples: tiff::decoder::DecodingResult::F32(self.meaning.convert(&raw)),
            }))
        })
    }
}

impl RasterFile for OpenExr {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn fingerprint(&self) -> [u8; 32] {
        self.fingerprint
    }

    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let OverviewInfo { width, height } = self.info.overviews[overview];
        assert_inside(rect, OverviewInfo { width, height });
        out.reshape(self.info.bands, rect.width as usize, rect.height as usize);
        let empty = if self.info.bands == Bands::Height {
            f32::NAN
        } else {
            0.0
        };
        out.samples_mut().fill(empty);
        if rect.width == 0 || rect.height == 0 {
            return Ok(());
        }
        let (bw, bh) = self.exr.block_size(overview);
        for row in rect.y / bh..=(rect.y + rect.height - 1) / bh {
            for column in rect.x / bw..=(rect.x + rect.width - 1) / bw {
                if cancel.is_cancelled() {
                    return Err(ReadError::Cancelled);
                }
                let chunk = self
                    .chunk(overview, column, row)
                    .map_err(|f| f.on_read(FORMAT, &self.info.path))?;
                if let Some(chunk) = chunk
                    && let tiff::decoder::DecodingResult::F32(samples) = &chunk.samples
                {
                    let stored = (width - column * bw).min(bw) as usize;
                    copy(samples, (column * bw, row * bh), stored, rect, out);
                }
            }
        }
        Ok(())
    }
}

/// Copies what a block at `at`, `width` pixels wide, has of a rectangle.
fn copy(samples: &[f32], at: (u32, u32), width: usize, rect: PixelRect, out: &mut Block) {
    let planes = out.bands().planes();
    let height = samples.len() / planes / width.max(1);
    let x0 = rect.x.max(at.0);
    let x1 = (rect.x + rect.width).min(at.0 + width as u32);
    let y0 = rect.y.max(at.1);
    let y1 = (rect.y + rect.height).min(at.1 + height as u32);
    let out_width = out.width();
    for y in y0..y1 {
        let from = ((y - at.1) as usize * width + (x0 - at.0) as usize) * planes;
        let to = (y - rect.y) as usize * out_width + (x0 - rect.x) as usize;
        let count = (x1 - x0) as usize;
        let pixels = samples[from..from + count * planes].chunks_exact(planes);
        if planes == 1 {
            out.plane_mut(0)[to..to + count].copy_from_slice(&samples[from..from + count]);
            continue;
        }
        for (i, pixel) in pixels.enumerate() {
            for (plane, value) in pixel.iter().enumerate() {
                out.plane_mut(plane)[to + i] = *value;
            }
        }
    }
}

impl Drop for OpenExr {
    fn drop(&mut self) {
        self.cache.forget_file(self.number);
    }
}

#[cfg(test)]
mod tests;
