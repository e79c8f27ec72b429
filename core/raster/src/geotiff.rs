//! GeoTIFF and Cloud Optimised GeoTIFF.
//!
//! Directories are read here, with bounds on everything; the `tiff` crate decodes single chunks.
//! Strips, tiles, planar and interleaved bands, all integer and float sample types, palettes,
//! overviews, internal masks, alpha, nodata and chunks that a sparse file leaves out.

mod bytes;
mod chunk;
mod fault;
mod geokeys;
mod georeference;
mod ifd;
mod layout;
mod meaning;
mod metadata;
mod samples;
mod stretch;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) use bytes::Bytes;
pub(crate) use chunk::Chunk;
pub(crate) use georeference::check_affine;

use crate::chunk_cache::{ChunkCache, ChunkKey};
use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::open::{OpenError, OpenOptions, Stretch, content_hash, placed};
use crate::{Bands, Block, pyramid, worldfile};
use fault::{Fault, damaged};
use geokeys::GeoKeys;
use georeference::Placement;
use ifd::{Ifd, TiffBytes, tag};
use layout::{Layout, SampleFormat, compression_name, photometric};
use meaning::{Choice, HeightScale, MeaningError, full_range};
use metadata::BandMetadata;
use samples::{BandView, Colours, Heights, Meaning, Window};
use stretch::Numbers;

/// The format's name in messages.
const FORMAT: &str = "GeoTIFF";
/// Bit of NewSubfileType: a smaller version of another image.
const REDUCED: u64 = 1;
/// Bit of NewSubfileType: a mask of another image.
const MASK: u64 = 4;
/// Decoded bytes of a chunk above which level 0 is copied into the pyramid too: a region of
/// interest would cost too much.
const AWKWARD_CHUNK_BYTES: u64 = 8 << 20;
/// Chunks looked at to choose a stretch.
const STRETCH_CHUNKS: u64 = 64;
/// Samples kept to choose a stretch.
const STRETCH_SAMPLES: usize = 1 << 18;

/// An open TIFF.
pub(crate) struct GeoTiff {
    info: RasterInfo,
    file: TiffBytes,
    levels: Vec<Level>,
    meaning: Meaning,
    fingerprint: [u8; 32],
    cache: Arc<ChunkCache>,
    /// Number of the file in the cache.
    number: u64,
}

/// One image of the pyramid.
struct Level {
    image: Layout,
    mask: Option<Layout>,
}

/// Opens a TIFF file and completes its pyramid.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(options.sample_facts().as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let bytes = Bytes::open(path).map_err(io)?;
    let tiff = GeoTiff::from_bytes(bytes, path, fingerprint, options)?;
    let level = &tiff.levels[0].image;
    let awkward = level.row_bytes() * u64::from(level.chunk_height) > AWKWARD_CHUNK_BYTES;
    pyramid::complete(Arc::new(tiff), awkward, fingerprint, options)
}

impl GeoTiff {
    /// Reads the directories of a TIFF; samples are read later.
    pub(crate) fn from_bytes(
        bytes: Bytes,
        path: &Path,
        fingerprint: [u8; 32],
        options: &OpenOptions,
    ) -> Result<Self, OpenError> {
        let refuse = |error: MeaningError| match error {
            MeaningError::File(fault) => open_error(fault, path),
            MeaningError::Options(reason) => OpenError::Options {
                reason,
                path: path.to_owned(),
            },
        };
        let (file, directories) = TiffBytes::open(bytes).map_err(|f| open_error(f, path))?;
        let mut tiff =
            Self::build(file, &directories, path, fingerprint, options).map_err(refuse)?;
        if let Meaning::Colour(colours) = &tiff.meaning
            && colours.palette.is_none()
        {
            let range = tiff
                .stretch(colours, options.stretch)
                .map_err(|f| open_error(f, path))?;
            if let (Some((low, high)), Meaning::Colour(colours)) = (range, &mut tiff.meaning) {
                let inverted = colours.range.0 > colours.range.1;
                colours.range = if inverted { (high, low) } else { (low, high) };
                colours.clamp = true;
            }
        }
        if tiff.info.georeference.is_none() && options.georeference.is_none() {
            tiff.place_beside(path, options)?;
        }
        Ok(tiff)
    }

    fn build(
        file: TiffBytes,
        directories: &[Ifd],
        path: &Path,
        fingerprint: [u8; 32],
        options: &OpenOptions,
    ) -> Result<Self, MeaningError> {
        let ifd = &directories[0];
        let levels = levels(&file, directories)?;
        let layout = &levels[0].image;
        let keys = GeoKeys::read(&file, ifd)?;
        let choice = Choice::of(layout, options)?;
        let own_nodata = file
            .text(ifd, tag::GDAL_NODATA, 256)?
            .as_deref()
            .and_then(metadata::nodata);
        let nodata = options.nodata.or(own_nodata);
        let scale = height_scale(&file, ifd, &keys, choice.selected[0])?;
        let meaning = meaning::meaning(&file, ifd, layout, &choice, &scale, nodata)?;
        let placement = match (&options.georeference, Placement::read(&file, ifd, &keys)) {
            (Some(_), _) => Placement::default(),
            (None, placement) => placement?,
        };
        let georeference = placed(placement.plane_from_pixel, placement.crs.clone(), options)
            .or_else(|| placement.georeference());
        let info = RasterInfo {
            path: path.to_owned(),
            format: FORMAT,
            overviews: levels
                .iter()
                .map(|l| OverviewInfo {
                    width: l.image.width,
                    height: l.image.height,
                })
                .collect(),
            bands: choice.bands,
            band_count: layout.samples,
            sample_type: sample_type(layout),
            compression: compression_name(layout).into(),
            deep_colour: choice.bands == Bands::Colour
                && layout.photometric != photometric::PALETTE
                && layout.bits > 8,
            nodata,
            may_have_holes: meaning.may_have_holes(full_range(layout))
                || layout.format == SampleFormat::Float
                || levels
                    .iter()
                    .any(|l| l.mask.is_some() || l.image.may_be_sparse(&file)),
            georeference,
        };
        let cache = Arc::clone(&options.chunk_cache);
        let number = cache.new_file();
        Ok(Self {
            info,
            file,
            levels,
            meaning,
            fingerprint,
            cache,
            number,
        })
    }

    /// Takes the position of pixels from a world file, where the file itself has none.
    fn place_beside(&mut self, path: &Path, options: &OpenOptions) -> Result<(), OpenError> {
        let found =
            worldfile::beside(path).map_err(|(companion, reason)| OpenError::Companion {
                reason,
                companion,
                path: path.to_owned(),
            })?;
        if let Some(affine) = found {
            let size = self.info.overviews[0];
            let assumed =
                worldfile::assumed_crs(&affine, size.width, size.height).map(str::to_owned);
            self.info.georeference = placed(Some(affine), assumed, options);
        }
        Ok(())
    }

    /// The range to show, from samples spread over the coarsest level.
    fn stretch(&self, colours: &Colours, stretch: Stretch) -> Result<Option<(f64, f64)>, Fault> {
        let layout = &self.levels[0].image;
        let numbers = if layout.format == SampleFormat::Float {
            Numbers::Floats
        } else if layout.bits <= 8 {
            Numbers::Bytes
        } else {
            Numbers::Integers
        };
        let needed = match stretch {
            Stretch::Auto => numbers != Numbers::Bytes,
            Stretch::Full => false,
            Stretch::MinMax | Stretch::Percentile { .. } | Stretch::Range { .. } => true,
        };
        let mut values = if needed && !matches!(stretch, Stretch::Range { .. }) {
            self.spread_values(colours)?
        } else {
            Vec::new()
        };
        let full = (
            colours.range.0.min(colours.range.1),
            colours.range.0.max(colours.range.1),
        );
        Ok(stretch::range(&mut values, stretch, full, numbers))
    }

    fn spread_values(&self, colours: &Colours) -> Result<Vec<f64>, Fault> {
        let image = self.levels.len() - 1;
        let layout = &self.levels[image].image;
        let chunks = u64::from(layout.columns()) * u64::from(layout.rows());
        let looked_at = chunks.min(STRETCH_CHUNKS);
        let grey = colours.bands[0] == colours.bands[1];
        let per_chunk = (STRETCH_SAMPLES as u64 / looked_at).max(1);
        let mut values = Vec::new();
        for i in 0..looked_at {
            let index = i * chunks / looked_at;
            let (column, row) = (
                (index % u64::from(layout.columns())) as u32,
                (index / u64::from(layout.columns())) as u32,
            );
            let window = Window {
                chunk_width: layout.chunk_width as usize,
                x: 0,
                y: 0,
                width: (layout.width - column * layout.chunk_width).min(layout.chunk_width)
                    as usize,
                height: (layout.height - row * layout.chunk_height).min(layout.chunk_height)
                    as usize,
            };
            let every = ((window.width * window.height) as u64 / per_chunk).max(1) as usize;
            let views = if grey {
                &colours.bands[..1]
            } else {
                &colours.bands[..]
            };
            for band in views {
                let chunk = self.chunk(image, false, layout, *band, column, row)?;
                view(layout, chunk.as_deref(), *band).for_each(
                    window,
                    colours.nodata,
                    |i, value, nodata| {
                        if i % every == 0 && !nodata && value.is_finite() {
                            values.push(value);
                        }
                    },
                );
            }
        }
        Ok(values)
    }

    /// A chunk that holds a band, from the cache.
    fn chunk(
        &self,
        level: usize,
        mask: bool,
        layout: &Layout,
        band: u16,
        column: u32,
        row: u32,
    ) -> Result<Option<Arc<Chunk>>, Fault> {
        let plane = if layout.planar { band } else { 0 };
        let key = ChunkKey {
            file: self.number,
            image: (level * 2 + usize::from(mask)) as u32,
            plane,
            column,
            row,
        };
        self.cache.get(key, || {
            chunk::decode(&self.file, layout, plane, column, row)
        })
    }

    fn read_heights(&self, how: &Heights, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let get = |band: u16| {
            self.chunk(
                place.level,
                false,
                place.layout,
                band,
                place.column,
                place.row,
            )
        };
        let band = get(how.band)?;
        let alpha = how.alpha.map(get).transpose()?;
        let band = view(place.layout, band.as_deref(), how.band);
        let alpha = alpha
            .as_ref()
            .map(|chunk| view(place.layout, chunk.as_deref(), how.alpha.unwrap_or(0)));
        let width = out.width();
        let start = place.y * width + place.x;
        how.read(
            &band,
            alpha.as_ref(),
            place.window,
            &mut out.plane_mut(0)[start..],
            width,
        );
        Ok(())
    }

    fn read_colours(&self, how: &Colours, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let get = |band: u16| {
            self.chunk(
                place.level,
                false,
                place.layout,
                band,
                place.column,
                place.row,
            )
        };
        let chunks = [get(how.bands[0])?, get(how.bands[1])?, get(how.bands[2])?];
        let alpha = how.alpha.map(|a| get(a.band)).transpose()?;
        let [r, g, b] = [0, 1, 2].map(|i| view(place.layout, chunks[i].as_deref(), how.bands[i]));
        let alpha = alpha.as_ref().map(|chunk| {
            view(
                place.layout,
                chunk.as_deref(),
                how.alpha.map_or(0, |a| a.band),
            )
        });
        let start = place.y * out.width() + place.x;
        if how.read_bytes([&r, &g, &b], alpha.as_ref(), place.window, start, out) {
            return Ok(());
        }
        let mut colours = Vec::new();
        how.read([&r, &g, &b], alpha.as_ref(), place.window, &mut colours);
        let width = out.width();
        let planes: [&mut [f32]; 4] = out.planes_mut();
        for (plane, values) in planes.into_iter().enumerate() {
            for (y, row) in colours.chunks_exact(place.window.width).enumerate() {
                let start = (place.y + y) * width + place.x;
                for (value, colour) in values[start..start + row.len()].iter_mut().zip(row) {
                    *value = colour[plane];
                }
            }
        }
        Ok(())
    }

    /// Empties what the mask of a level leaves out.
    fn apply_mask(&self, place: &Place<'_>, out: &mut Block) -> Result<(), Fault> {
        let chunk = self.chunk(place.level, true, place.layout, 0, place.column, place.row)?;
        let width = out.width();
        let empty = if out.bands() == Bands::Height {
            f32::NAN
        } else {
            0.0
        };
        let mut holes = Vec::new();
        view(place.layout, chunk.as_deref(), 0).for_each(place.window, None, |i, value, _| {
            if value.is_nan() || value == 0.0 {
                holes.push(
                    (place.y + i / place.window.width) * width + place.x + i % place.window.width,
                );
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

    fn read_level(
        &self,
        level: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let fault = |fault: Fault| read_error(fault, &self.info.path);
        let images = &self.levels[level];
        for place in places(level, &images.image, rect) {
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
            for place in places(level, mask, rect) {
                self.apply_mask(&place, out).map_err(fault)?;
            }
        }
        Ok(())
    }
}

impl RasterFile for GeoTiff {
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
        let size = self.info.overviews[overview];
        let inside = rect
            .x
            .checked_add(rect.width)
            .is_some_and(|x| x <= size.width)
            && rect
                .y
                .checked_add(rect.height)
                .is_some_and(|y| y <= size.height);
        assert!(
            inside,
            "the rectangle {rect:?} lies inside the overview {size:?}"
        );
        out.reshape(self.info.bands, rect.width as usize, rect.height as usize);
        self.read_level(overview, rect, out, cancel)
    }
}

impl Drop for GeoTiff {
    fn drop(&mut self) {
        self.cache.forget_file(self.number);
    }
}

/// The part of a wanted rectangle that one chunk holds.
struct Place<'a> {
    level: usize,
    layout: &'a Layout,
    column: u32,
    row: u32,
    /// Within the chunk.
    window: Window,
    /// Where the window goes in the output.
    x: usize,
    y: usize,
}

/// All chunks that hold a part of a rectangle, row by row.
fn places(level: usize, layout: &Layout, rect: PixelRect) -> impl Iterator<Item = Place<'_>> {
    let (cw, ch) = (layout.chunk_width, layout.chunk_height);
    let empty = rect.width == 0 || rect.height == 0;
    let rows = rect.y / ch..if empty {
        0
    } else {
        (rect.y + rect.height).div_ceil(ch)
    };
    rows.flat_map(move |row| {
        let columns = rect.x / cw..(rect.x + rect.width).div_ceil(cw);
        columns.map(move |column| {
            let (x0, x1) = (
                rect.x.max(column * cw),
                (rect.x + rect.width).min(column.saturating_add(1).saturating_mul(cw)),
            );
            let (y0, y1) = (
                rect.y.max(row * ch),
                (rect.y + rect.height).min(row.saturating_add(1).saturating_mul(ch)),
            );
            let window = Window {
                chunk_width: cw as usize,
                x: (x0 - column * cw) as usize,
                y: (y0 - row * ch) as usize,
                width: (x1 - x0) as usize,
                height: (y1 - y0) as usize,
            };
            Place {
                level,
                layout,
                column,
                row,
                window,
                x: (x0 - rect.x) as usize,
                y: (y0 - rect.y) as usize,
            }
        })
    })
}

fn view<'a>(layout: &Layout, chunk: Option<&'a Chunk>, band: u16) -> BandView<'a> {
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

/// The full image, its overviews from fine to coarse, and their masks.
fn levels(file: &TiffBytes, directories: &[Ifd]) -> Result<Vec<Level>, Fault> {
    let mut levels = vec![Level {
        image: Layout::read(file, &directories[0])?,
        mask: None,
    }];
    let mut masks = Vec::new();
    for ifd in &directories[1..] {
        let kind = file.unsigned(ifd, tag::NEW_SUBFILE_TYPE)?.unwrap_or(0);
        if kind & MASK != 0 {
            masks.push(Layout::read(file, ifd)?);
        } else if kind & REDUCED != 0 {
            match Layout::read(file, ifd) {
                Ok(image) if is_overview(&image, &levels) => {
                    levels.push(Level { image, mask: None });
                }
                // Thumbnails and overviews that nothing here reads can be made again.
                Ok(_) | Err(Fault::Unsupported(_)) => {}
                Err(fault) => return Err(fault),
            }
        }
    }
    levels[1..].sort_by_key(|level| {
        core::cmp::Reverse(u64::from(level.image.width) * u64::from(level.image.height))
    });
    for mask in masks {
        if mask.samples != 1 || mask.format != SampleFormat::Unsigned {
            return damaged("expected a mask of one unsigned band");
        }
        let of = levels
            .iter_mut()
            .find(|l| (l.image.width, l.image.height) == (mask.width, mask.height));
        if let Some(level) = of {
            level.mask.get_or_insert(mask);
        }
    }
    // Masks of overviews may be missing where the image itself has one: without it the overview
    // would show what the mask hides.
    if levels[0].mask.is_some() {
        let masked = levels.iter().take_while(|l| l.mask.is_some()).count();
        levels.truncate(masked);
    }
    Ok(levels)
}

/// Whether an image is a plausible overview: the same bands, smaller, the same shape.
fn is_overview(image: &Layout, levels: &[Level]) -> bool {
    let full = &levels[0].image;
    let known = levels
        .iter()
        .any(|l| (l.image.width, l.image.height) == (image.width, image.height));
    if known
        || image.width > full.width
        || image.height > full.height
        || image.samples != full.samples
    {
        return false;
    }
    if (
        image.format,
        image.bits,
        image.photometric == photometric::PALETTE,
    ) != (
        full.format,
        full.bits,
        full.photometric == photometric::PALETTE,
    ) {
        return false;
    }
    let ratio = |a: u32, b: u32| f64::from(a) / f64::from(b);
    // Rounding of sides up or down to whole pixels, by any writer, moves a side by a pixel or two.
    let expected = f64::from(full.height) / ratio(full.width, image.width);
    let expected_width = f64::from(full.width) / ratio(full.height, image.height);
    (expected - f64::from(image.height)).abs() <= 2.0
        || (expected_width - f64::from(image.width)).abs() <= 2.0
}

fn height_scale(
    file: &TiffBytes,
    ifd: &Ifd,
    keys: &GeoKeys,
    band: u16,
) -> Result<HeightScale, Fault> {
    let xml = file
        .text(ifd, tag::GDAL_METADATA, 16 << 20)?
        .unwrap_or_default();
    let metadata = BandMetadata::of_band(&xml, band);
    let metres = match metadata.unit {
        Some(_) => metadata.metres(),
        None => keys.vertical_metres().unwrap_or(1.0),
    };
    Ok(HeightScale {
        scale: metadata.scale.unwrap_or(1.0) * metres,
        offset: metadata.offset.unwrap_or(0.0) * metres,
    })
}

fn sample_type(layout: &Layout) -> String {
    let name = match layout.format {
        SampleFormat::Unsigned => "uint",
        SampleFormat::Signed => "int",
        SampleFormat::Float => "float",
    };
    let palette = if layout.photometric == photometric::PALETTE {
        " palette"
    } else {
        ""
    };
    format!("{name}{}{palette}", layout.bits)
}

fn open_error(fault: Fault, path: &Path) -> OpenError {
    let path: PathBuf = path.to_owned();
    match fault {
        Fault::Io(error) => OpenError::Io {
            reason: error.to_string(),
            path,
        },
        Fault::Damaged(reason) => OpenError::Damaged {
            format: FORMAT,
            reason,
            path,
        },
        Fault::Unsupported(reason) => OpenError::Unsupported {
            format: FORMAT,
            reason,
            path,
        },
    }
}

fn read_error(fault: Fault, path: &Path) -> ReadError {
    let path = path.to_owned();
    match fault {
        Fault::Io(error) => ReadError::Io {
            reason: error.to_string(),
            path,
        },
        Fault::Damaged(reason) | Fault::Unsupported(reason) => ReadError::Damaged {
            format: FORMAT,
            reason,
            path,
        },
    }
}
