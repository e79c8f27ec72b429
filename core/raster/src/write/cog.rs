//! Cloud Optimised GeoTIFF, tile by tile.
//!
//! Tiles are made in batches on several threads and put, compressed, one after another into a
//! spool; overviews are reduced from the tiles of the finer level in it, so memory holds a batch
//! whatever the size of the image. At the end the directories go first, then the tiles from the
//! coarsest level to the full image: the order COG readers expect. A spool that is kept lets work
//! that was stopped go on.

mod assemble;
mod spool;
mod tile;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use parking_lot::Mutex;

use super::{WriteError, geokeys, io_error};
use crate::crs::Crs;
use crate::file::{Cancel, Georeference, OverviewInfo, PixelRect};
use crate::parts::parts;
use crate::reduce::ratio::Reduction;
use crate::{Bands, Block};
use spool::Spool;

/// Tiles per thread and batch: enough that threads rarely wait for the slowest.
const TILES_A_THREAD: usize = 4;

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
    /// Files above this size are BigTIFF: [`CogLayout::LARGEST_CLASSIC_BYTES`] or less.
    pub largest_classic_bytes: u64,
}

impl CogLayout {
    /// Largest file whose positions fit into 32 bits, with some room.
    pub const LARGEST_CLASSIC_BYTES: u64 = 4_000_000_000;

    /// The full image and its overviews: halves, rounded up, until one tile holds them.
    fn levels(&self) -> Vec<OverviewInfo> {
        let (mut width, mut height) = (self.width, self.height);
        let mut levels = vec![OverviewInfo { width, height }];
        while width.max(height) > self.tile {
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            levels.push(OverviewInfo { width, height });
        }
        levels
    }
}

/// What gives the samples of a file that is written: a block of a rectangle of them, on any thread.
pub type CogSource<'a> =
    dyn Fn(PixelRect) -> Result<Block, Box<dyn core::error::Error + Send + Sync>> + Sync + 'a;

/// How a file is written.
#[derive(Clone, Copy, Debug)]
pub struct CogWork<'a> {
    /// Threads that make tiles, at least 1.
    pub threads: usize,
    /// What names the samples, if work that is stopped is to go on later: finished tiles are kept
    /// in a file beside the image (its name and `.part`), and taken up again by a request of the
    /// same name, size and samples. `None` leaves nothing behind.
    pub resume: Option<[u8; 32]>,
    /// Asks to stop.
    pub cancel: &'a Cancel,
}

/// Writes a Cloud Optimised GeoTIFF: tiled, Deflate with a predictor, overviews down to one tile,
/// pixels as areas; whole or not at all. The bytes do not depend on threads or stops.
///
/// - `source`: gives the samples of a rectangle; called once per tile, on all threads.
/// - `progress`: called with the part that is done, 0 to 1, never falling.
///
/// # Errors
/// [`WriteError`] when the layout cannot be stored, the source fails, the system refuses, or work
/// was cancelled. A file that was there before is untouched then; what [`CogWork::resume`] says is
/// kept.
pub fn write_cog(
    path: &Path,
    layout: &CogLayout,
    source: &CogSource<'_>,
    work: &CogWork<'_>,
    progress: &mut dyn FnMut(f64),
) -> Result<(), WriteError> {
    let unsupported = |reason: String| WriteError::Unsupported {
        reason,
        path: path.to_owned(),
    };
    let CogLayout {
        width,
        height,
        tile,
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
    let total = layout.levels().iter().map(|l| tiles_of(*l, tile)).sum();
    let mut spool = Spool::open(path, layout, work.resume, total)?;
    let result = fill(path, layout, source, work, progress, &mut spool).and_then(|()| {
        assemble::assemble(path, layout, &geo, &layout.levels(), &spool, work.cancel)
    });
    // What holds nothing is not worth keeping.
    if result.is_ok() || spool.count() == 0 {
        spool.remove();
    }
    result?;
    progress(1.0);
    Ok(())
}

/// Adds the tiles that the spool lacks.
fn fill(
    path: &Path,
    layout: &CogLayout,
    source: &CogSource<'_>,
    work: &CogWork<'_>,
    progress: &mut dyn FnMut(f64),
    spool: &mut Spool,
) -> Result<(), WriteError> {
    let levels = layout.levels();
    let counts: Vec<usize> = levels.iter().map(|l| tiles_of(*l, layout.tile)).collect();
    let total: usize = counts.iter().sum();
    let mut first = 0;
    for (level, size) in levels.iter().enumerate() {
        let maker = TileMaker {
            layout,
            size: *size,
            source,
            finer: level.checked_sub(1).map(|l| (levels[l], first - counts[l])),
            path,
        };
        let end = first + counts[level];
        while spool.count() < end {
            if work.cancel.is_cancelled() {
                return Err(WriteError::Cancelled);
            }
            let start = spool.count();
            let batch = (end - start).min(work.threads.max(1) * TILES_A_THREAD);
            let made = maker.make_batch(start - first, batch, spool, work)?;
            spool.append(&made).map_err(io_error(path))?;
            // The last part is left for putting the file together.
            progress(0.97 * spool.count() as f64 / total as f64);
        }
        first = end;
    }
    Ok(())
}

/// Tiles of a level.
fn tiles_of(size: OverviewInfo, tile: u32) -> usize {
    size.width.div_ceil(tile) as usize * size.height.div_ceil(tile) as usize
}

/// A compressed tile.
type MadeTile = Result<Vec<u8>, WriteError>;

/// Makes the tiles of one level.
struct TileMaker<'a> {
    layout: &'a CogLayout,
    size: OverviewInfo,
    source: &'a CogSource<'a>,
    /// Size of the next finer level, and the number of its first tile in the spool.
    finer: Option<(OverviewInfo, usize)>,
    path: &'a Path,
}

impl TileMaker<'_> {
    /// Compressed tiles from number `start` of the level on, in order.
    fn make_batch(
        &self,
        start: usize,
        count: usize,
        spool: &Spool,
        work: &CogWork<'_>,
    ) -> Result<Vec<Vec<u8>>, WriteError> {
        let next = AtomicUsize::new(0);
        let made: Mutex<Vec<Option<MadeTile>>> = Mutex::new((0..count).map(|_| None).collect());
        let make = || loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count {
                return;
            }
            let tile = if work.cancel.is_cancelled() {
                Err(WriteError::Cancelled)
            } else {
                self.make(start + i, spool)
            };
            if tile.is_err() {
                // The others stop after the tile that they have at hand.
                next.store(count, Ordering::Relaxed);
            }
            made.lock()[i] = Some(tile);
        };
        std::thread::scope(|scope| {
            for n in 1..work.threads.clamp(1, count) {
                let name = format!("relievo-write-{n}");
                // A thread that cannot start is missed by nobody: the others do its work.
                if let Err(error) = std::thread::Builder::new()
                    .name(name)
                    .spawn_scoped(scope, make)
                {
                    tracing::warn!("writes on fewer threads: {error}");
                }
            }
            make();
        });
        let mut tiles = Vec::with_capacity(count);
        for tile in made.into_inner() {
            // Tiles that nobody came to follow one that failed.
            tiles.push(tile.unwrap_or(Err(WriteError::Cancelled)));
        }
        if let Some(at) = tiles
            .iter()
            .position(|t| matches!(t, Err(e) if !matches!(e, WriteError::Cancelled)))
        {
            return tiles.swap_remove(at).map(|_| Vec::new());
        }
        tiles.into_iter().collect()
    }

    fn make(&self, number: usize, spool: &Spool) -> Result<Vec<u8>, WriteError> {
        let CogLayout { tile, samples, .. } = *self.layout;
        let columns = self.size.width.div_ceil(tile) as usize;
        let (x, y) = (
            (number % columns) as u32 * tile,
            (number / columns) as u32 * tile,
        );
        let rect = PixelRect {
            x,
            y,
            width: tile.min(self.size.width - x),
            height: tile.min(self.size.height - y),
        };
        let block = match self.finer {
            None => (self.source)(rect).map_err(WriteError::Samples)?,
            Some((size, first)) => self.reduced(rect, size, first, spool)?,
        };
        if (block.width(), block.height()) != (rect.width as usize, rect.height as usize)
            || block.bands() != samples.bands()
        {
            return Err(WriteError::Unsupported {
                reason: "the source gave a block of another shape than asked for".into(),
                path: self.path.to_owned(),
            });
        }
        tile::encode(&block, tile, samples).map_err(io_error(self.path))
    }

    /// A rectangle of this level from the tiles of the finer one.
    fn reduced(
        &self,
        rect: PixelRect,
        finer: OverviewInfo,
        first: usize,
        spool: &Spool,
    ) -> Result<Block, WriteError> {
        let CogLayout { tile, samples, .. } = *self.layout;
        let reduction = Reduction::new(finer, self.size, rect);
        let needs = reduction.needs();
        let columns = finer.width.div_ceil(tile) as usize;
        let mut fine = Block::new(samples.bands(), needs.width as usize, needs.height as usize);
        for part in parts(needs, (tile, tile)) {
            let number = first + part.row as usize * columns + part.column as usize;
            let stored = spool
                .read(number)
                .and_then(|bytes| tile::decode(&bytes, tile, samples))
                .map_err(io_error(self.path))?;
            fine.copy_from(&stored, part.in_cell, part.in_rect, part.size);
        }
        Ok(reduction.apply(&fine))
    }
}
