//! Cloud Optimised GeoTIFF, tile by tile.
//!
//! Tiles are made row by row and compressed into one spool per level, overviews by halving as the
//! rows come, so memory holds two rows of tiles whatever the height. At the end the directories go
//! first, then the spools from the coarsest level to the full image: the order COG readers expect.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::ifd::{self, Field, Value};
use super::{WriteError, atomically, folder, geokeys, io_error, picture};
use crate::crs::Crs;
use crate::file::{Cancel, Georeference, PixelRect};
use crate::{Bands, Block, reduce};

/// Deflate level: within some percent of the smallest, several times as fast.
const DEFLATE_LEVEL: u32 = 6;
/// Files from this size on are BigTIFF.
const BIG: u64 = 4_000_000_000;

/// What a file stores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CogSamples {
    /// Heights in metres, f32; holes as the given value (which may be NaN).
    Height {
        /// Stored for holes, and named as nodata.
        nodata: f32,
    },
    /// sRGB, 8 bits a channel; alpha is dropped.
    Rgb8,
    /// sRGB with straight alpha, 8 bits a channel.
    Rgba8,
    /// Unit normals (east, north, up) as 8 bits: −1 to 1 become 0 to 254; 127 is 0.
    Normal8,
    /// Unit normals (east, north, up) as f32.
    NormalF32,
}

impl CogSamples {
    /// What blocks hold.
    pub const fn bands(self) -> Bands {
        match self {
            Self::Height { .. } => Bands::Height,
            Self::Rgb8 | Self::Rgba8 => Bands::Colour,
            Self::Normal8 | Self::NormalF32 => Bands::Normal,
        }
    }

    const fn channels(self) -> usize {
        match self {
            Self::Height { .. } => 1,
            Self::Rgb8 | Self::Normal8 | Self::NormalF32 => 3,
            Self::Rgba8 => 4,
        }
    }

    const fn is_float(self) -> bool {
        matches!(self, Self::Height { .. } | Self::NormalF32)
    }
}

/// Shape and place of a file to be written.
#[derive(Clone, Debug)]
pub struct CogLayout {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// What is stored.
    pub samples: CogSamples,
    /// Side of a tile: 256 or 512.
    pub tile: u32,
    /// Where the pixels lie, if anywhere.
    pub georeference: Option<Georeference>,
}

/// What gives the samples of a file that is written: fills a block with a rectangle of them.
pub type CogSource<'a> =
    dyn FnMut(PixelRect, &mut Block) -> Result<(), Box<dyn core::error::Error + Send + Sync>> + 'a;

/// Writes a Cloud Optimised GeoTIFF: tiled, Deflate with a predictor, overviews by halves down to
/// one tile, pixels as areas; whole or not at all.
///
/// - `source`: fills a block (reshaped to fit) with the samples of a rectangle; called once per
///   tile, row by row from the north.
/// - `progress`: called with the part that is done, 0 to 1, never falling.
///
/// # Errors
/// [`WriteError`] when the layout cannot be stored, the source fails, the system refuses, or work
/// was cancelled. No file is left then, and one that was there before is untouched.
pub fn write_cog(
    path: &Path,
    layout: &CogLayout,
    source: &mut CogSource<'_>,
    progress: &mut dyn FnMut(f64),
    cancel: &Cancel,
) -> Result<(), WriteError> {
    let unsupported = |reason: String| WriteError::Unsupported {
        reason,
        path: path.to_owned(),
    };
    let CogLayout {
        width,
        height,
        tile,
        samples,
        ..
    } = *layout;
    if width == 0 || height == 0 {
        return Err(unsupported(format!(
            "expected an image with an area, found {width} × {height}"
        )));
    }
    if tile != 256 && tile != 512 {
        return Err(unsupported(format!(
            "expected tiles of 256 or 512, found {tile}"
        )));
    }
    let geo = match &layout.georeference {
        None => Vec::new(),
        Some(geo) => {
            let crs = Crs::parse(&geo.crs).map_err(|e| unsupported(e.to_string()))?;
            geokeys::fields(&crs, geo.plane_from_pixel).map_err(unsupported)?
        }
    };
    let mut levels = levels(path, layout)?;
    let rows = height.div_ceil(tile);
    let columns = width.div_ceil(tile);
    let mut block = Block::new(samples.bands(), 0, 0);
    for row in 0..rows {
        for column in 0..columns {
            if cancel.is_cancelled() {
                return Err(WriteError::Cancelled);
            }
            let (x, y) = (column * tile, row * tile);
            let rect = PixelRect {
                x,
                y,
                width: tile.min(width - x),
                height: tile.min(height - y),
            };
            source(rect, &mut block).map_err(WriteError::Samples)?;
            if (block.width(), block.height()) != (rect.width as usize, rect.height as usize)
                || block.bands() != samples.bands()
            {
                return Err(unsupported(
                    "the source gave a block of another shape than asked for".into(),
                ));
            }
            levels[0]
                .push_tile(&block, samples)
                .map_err(io_error(path))?;
            if levels.len() > 1 {
                levels[1].take_half(&block, column, row);
            }
            progress(
                0.95 * (f64::from(row) + f64::from(column + 1) / f64::from(columns))
                    / f64::from(rows),
            );
        }
        push_overviews(&mut levels, row, rows, samples).map_err(io_error(path))?;
    }
    assemble(path, layout, &geo, levels, cancel)?;
    progress(1.0);
    Ok(())
}

/// One resolution on its way to the file.
struct Level {
    width: u32,
    height: u32,
    tile: u32,
    spool: BufWriter<File>,
    sizes: Vec<u64>,
    /// The row of tiles that is being filled (overviews only).
    band: Block,
}

/// The full image and its overviews.
fn levels(path: &Path, layout: &CogLayout) -> Result<Vec<Level>, WriteError> {
    let (mut width, mut height, tile) = (layout.width, layout.height, layout.tile);
    let mut levels = Vec::new();
    loop {
        let spool = tempfile::tempfile_in(folder(path)).map_err(io_error(path))?;
        let band_rows = if levels.is_empty() {
            0
        } else {
            tile.min(height)
        };
        levels.push(Level {
            width,
            height,
            tile,
            spool: BufWriter::new(spool),
            sizes: Vec::new(),
            band: Block::new(
                layout.samples.bands(),
                if levels.is_empty() { 0 } else { width as usize },
                band_rows as usize,
            ),
        });
        if width <= tile && height <= tile {
            return Ok(levels);
        }
        (width, height) = (width.div_ceil(2), height.div_ceil(2));
    }
}

impl Level {
    /// Compresses a tile, padded by repeating nothing: holes, transparency, level ground.
    fn push_tile(&mut self, block: &Block, samples: CogSamples) -> io::Result<()> {
        let side = self.tile as usize;
        let mut padded = Block::new(block.bands(), side, side);
        if let CogSamples::Height { .. } = samples {
            padded.samples_mut().fill(f32::NAN);
        }
        padded.copy_from(block, (0, 0), (0, 0), (block.width(), block.height()));
        let bytes = encode_tile(&padded, samples);
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(DEFLATE_LEVEL));
        encoder.write_all(&bytes)?;
        let compressed = encoder.finish()?;
        self.sizes.push(compressed.len() as u64);
        self.spool.write_all(&compressed)
    }

    /// Takes the halved tile at a column and row of tiles of the next finer level.
    fn take_half(&mut self, finer: &Block, column: u32, row: u32) {
        let half = reduce::halve(finer);
        let x = (column * (self.tile / 2)) as usize;
        let y = ((row % 2) * (self.tile / 2)) as usize;
        self.band
            .copy_from(&half, (0, 0), (x, y), (half.width(), half.height()));
    }
}

/// After row `row` of `rows` rows of tiles of the full image: writes the overviews' rows that are
/// full now.
fn push_overviews(
    levels: &mut [Level],
    row: u32,
    rows: u32,
    samples: CogSamples,
) -> io::Result<()> {
    let (mut row, mut rows) = (row, rows);
    for l in 1..levels.len() {
        if row.is_multiple_of(2) && row + 1 != rows {
            return Ok(());
        }
        (row, rows) = (row / 2, rows.div_ceil(2));
        let (finer, coarser) = levels.split_at_mut(l + 1);
        let Some(level) = finer.last_mut() else {
            return Ok(());
        };
        let tile = level.tile;
        let height = tile.min(level.height - row * tile) as usize;
        for column in 0..level.width.div_ceil(tile) {
            let x = column * tile;
            let width = tile.min(level.width - x) as usize;
            let mut block = Block::new(level.band.bands(), width, height);
            block.copy_from(&level.band, (x as usize, 0), (0, 0), (width, height));
            level.push_tile(&block, samples)?;
            if let Some(next) = coarser.first_mut() {
                next.take_half(&block, column, row);
            }
        }
    }
    Ok(())
}

/// A tile's samples interleaved and predicted, as they are compressed.
fn encode_tile(block: &Block, samples: CogSamples) -> Vec<u8> {
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
                    | CogSamples::NormalF32 => pixel.copy_from_slice(&normal(block, i)),
                }
            }
            predict_floats(&row, channels, &mut out);
        }
        return out;
    }
    let mut bytes = if samples == CogSamples::Normal8 {
        (0..block.width() * block.height())
            .flat_map(|i| normal(block, i).map(|c| (c * 127.0 + 127.5) as u8))
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

/// East, north and up.
fn normal(block: &Block, i: usize) -> [f32; 3] {
    let (e, n) = (block.plane(0)[i], block.plane(1)[i]);
    [e, n, (1.0 - e * e - n * n).max(0.0).sqrt()]
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

/// Writes directories and spools.
fn assemble(
    path: &Path,
    layout: &CogLayout,
    geo: &[Field],
    levels: Vec<Level>,
    cancel: &Cancel,
) -> Result<(), WriteError> {
    let total: u64 = levels.iter().flat_map(|l| &l.sizes).sum();
    let directories = |big: bool, starts: &[u64]| {
        let fields: Vec<Vec<Field>> = levels
            .iter()
            .zip(starts)
            .enumerate()
            .map(|(i, (l, s))| fields(layout, l, *s, i, geo))
            .collect();
        ifd::encode(&fields, big)
    };
    let none = vec![0; levels.len()];
    let big = total + directories(true, &none).len() as u64 > BIG;
    let mut at = directories(big, &none).len() as u64;
    let mut starts = none;
    for (start, level) in starts.iter_mut().zip(&levels).rev() {
        *start = at;
        at += level.sizes.iter().sum::<u64>();
    }
    let head = directories(big, &starts);
    if cancel.is_cancelled() {
        return Err(WriteError::Cancelled);
    }
    let mut stopped = false;
    let written = atomically(path, |out| {
        out.write_all(&head)?;
        for level in levels.into_iter().rev() {
            let mut spool = level
                .spool
                .into_inner()
                .map_err(io::IntoInnerError::into_error)?;
            spool.seek(SeekFrom::Start(0))?;
            io::copy(&mut spool, out)?;
            if cancel.is_cancelled() {
                stopped = true;
                return Err(io::Error::other("cancelled"));
            }
        }
        Ok(())
    });
    if stopped {
        Err(WriteError::Cancelled)
    } else {
        written
    }
}

/// The directory of a level whose tiles begin at `start`.
fn fields(
    layout: &CogLayout,
    level: &Level,
    start: u64,
    index: usize,
    geo: &[Field],
) -> Vec<Field> {
    let samples = layout.samples;
    let channels = samples.channels();
    let float = samples.is_float();
    let short = |tag, v: u16| Field::new(tag, Value::Short(vec![v]));
    let long = |tag, v: u32| Field::new(tag, Value::Long(vec![v]));
    let mut offset = start;
    let offsets = level.sizes.iter().map(|size| {
        let at = offset;
        offset += size;
        at
    });
    let mut fields = vec![
        long(256, level.width),
        long(257, level.height),
        Field::new(
            258,
            Value::Short(vec![if float { 32 } else { 8 }; channels]),
        ),
        short(259, 8),
        short(262, if channels >= 3 { 2 } else { 1 }),
        short(277, channels as u16),
        short(284, 1),
        short(317, if float { 3 } else { 2 }),
        long(322, level.tile),
        long(323, level.tile),
        Field::new(324, Value::Offset(offsets.collect())),
        Field::new(325, Value::Offset(level.sizes.clone())),
        Field::new(339, Value::Short(vec![if float { 3 } else { 1 }; channels])),
    ];
    if index > 0 {
        fields.push(long(254, 1));
    } else {
        fields.extend(geo.iter().cloned());
    }
    if samples == CogSamples::Rgba8 {
        fields.push(short(338, 2));
    }
    if let CogSamples::Height { nodata } = samples {
        let text = if nodata.is_nan() {
            "nan".to_owned()
        } else {
            format!("{nodata}")
        };
        fields.push(Field::new(42_113, Value::Ascii(text)));
    }
    fields
}
