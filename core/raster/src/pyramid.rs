//! Pyramids for files that have none, or whose own ends too soon.
//!
//! Made once, as a tiled TIFF in a cache folder, named by a hash of the source's fingerprint; a
//! cached file that is damaged or does not fit is made again. Where the folder cannot be written
//! the pyramid stays in memory.

mod store;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use parking_lot::Mutex;

use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::geotiff::{Bytes, Companions, GeoTiff};
use crate::open::{OpenError, OpenOptions, Stretch};
use crate::reduce::ratio::Reduction;
use crate::{Bands, Block};
use store::Store;
use writer::{Samples, TILE, Writer};

/// Longest side of the coarsest level: one tile.
const COARSEST_SIDE: u32 = 256;
/// Part of the cached files' names: a pyramid made otherwise is another file.
const VERSION: &str = "1";
/// Sides of regions that workers make between two looks at the progress, in tiles.
const BATCH_TILES: usize = 32;
/// A pyramid is not kept in memory beyond so many bytes.
const MEMORY_LIMIT_BYTES: u64 = 512 << 20;
/// Pixels of the level that a pyramid starts from at most: reading more takes the better part of an
/// hour, and such files come with overviews.
const LARGEST_AREA: u64 = 1 << 37;
/// Bytes of that level, decoded, from which on the file must not be tiny beside them.
const LARGE_BYTES: u64 = 1 << 30;
/// Decoded bytes for a byte of such a file at most: a kilobyte that stands for gigabytes is no image
/// whose pixels are worth reading one by one.
const MOST_EXPANSION: u64 = 4096;

/// A file with all levels: some of its own, the others from a pyramid.
struct Completed {
    info: RasterInfo,
    /// Gives the first `own` levels.
    base: Option<Arc<dyn RasterFile>>,
    own: usize,
    made: GeoTiff,
    remarks: Vec<String>,
    fingerprint: [u8; 32],
}

/// The file with overviews down to one tile; itself if it has them, or if the options want none.
///
/// With `copy` the pyramid holds the base's own levels too and the base is let go: for files that
/// decode as a whole only. `key` names the content.
pub(crate) fn complete(
    base: Arc<dyn RasterFile>,
    copy: bool,
    key: [u8; 32],
    options: &OpenOptions,
) -> Result<Arc<dyn RasterFile>, OpenError> {
    let info = base.info().clone();
    let coarsest = info.overviews[info.overviews.len() - 1];
    let sizes = sizes_below(coarsest);
    if !options.make_pyramid || (sizes.is_empty() && !copy) {
        return Ok(base);
    }
    let plan = Plan {
        sizes,
        copy,
        key,
        base: &*base,
    };
    let made = plan
        .cached(options)
        .map_or_else(|| plan.make(options), Ok)?;
    let mut completed = info;
    let fingerprint = base.fingerprint();
    let remarks = base.remarks().to_vec();
    let own = if copy { 0 } else { completed.overviews.len() };
    if copy {
        completed.overviews.truncate(1);
    }
    completed.overviews.extend(&plan.sizes);
    Ok(Arc::new(Completed {
        info: completed,
        base: (!copy).then_some(base),
        own,
        made,
        remarks,
        fingerprint,
    }))
}

/// Halves, rounded up, until one tile holds the level.
fn sizes_below(size: OverviewInfo) -> Vec<OverviewInfo> {
    let mut sizes = Vec::new();
    let mut last = size;
    while last.width.max(last.height) > COARSEST_SIDE {
        last = OverviewInfo {
            width: last.width.div_ceil(2),
            height: last.height.div_ceil(2),
        };
        sizes.push(last);
    }
    sizes
}

/// What a pyramid is to hold.
struct Plan<'a> {
    /// Sizes of the levels to make.
    sizes: Vec<OverviewInfo>,
    /// Whether level 0 of the base comes first.
    copy: bool,
    key: [u8; 32],
    base: &'a dyn RasterFile,
}

impl Plan<'_> {
    fn path(&self, folder: &Path) -> PathBuf {
        let mut hash = blake3::Hasher::new();
        hash.update(&self.key);
        hash.update(format!("pyramid {VERSION} {:?} {}", self.sizes, self.copy).as_bytes());
        folder.join(format!("{}.tif", &hash.finalize().to_hex()[..32]))
    }

    /// All levels that the pyramid's file holds.
    fn levels(&self) -> Vec<OverviewInfo> {
        let first = self.copy.then(|| self.base.info().overviews[0]);
        first
            .into_iter()
            .chain(self.sizes.iter().copied())
            .collect()
    }

    /// The pyramid in the cache folder, if it is there and in order.
    fn cached(&self, options: &OpenOptions) -> Option<GeoTiff> {
        let path = self.path(options.cache_dir.as_deref()?);
        let bytes = Bytes::open(&path).ok()?;
        match self.opened(bytes, &path, options) {
            Ok(tiff) => Some(tiff),
            Err(reason) => {
                tracing::warn!(%reason, "making a cached pyramid again");
                None
            }
        }
    }

    fn opened(&self, bytes: Bytes, path: &Path, options: &OpenOptions) -> Result<GeoTiff, String> {
        let own = OpenOptions {
            chunk_cache: Arc::clone(&options.chunk_cache),
            as_bands: Some(self.base.info().bands),
            stretch: Stretch::Full,
            make_pyramid: false,
            ..OpenOptions::default()
        };
        let tiff = GeoTiff::from_bytes(bytes, path, &Companions::default(), self.key, &own)
            .map_err(|e| e.to_string())?;
        if tiff.info().overviews != self.levels() {
            return Err(format!(
                "expected levels {:?}, found {:?}",
                self.levels(),
                tiff.info().overviews
            ));
        }
        Ok(tiff)
    }

    /// Refuses what would keep the machine busy for hours.
    fn check_size(&self) -> Result<(), String> {
        let info = self.base.info();
        let size = info.overviews[if self.copy {
            0
        } else {
            info.overviews.len() - 1
        }];
        // Narrow images cost whole tiles.
        let side = |n: u32| u64::from(n.max(TILE));
        let area = side(size.width) * side(size.height);
        let advice = "make overviews with gdaladdo";
        if area > LARGEST_AREA {
            return Err(format!(
                "expected overviews in an image of {} x {} pixels, found none that are small: {advice}",
                size.width, size.height
            ));
        }
        let sample: u64 = if info.deep_colour || info.bands == Bands::Height {
            2
        } else {
            1
        };
        let bytes = area * u64::from(info.band_count.max(1)).min(4) * sample;
        let length = std::fs::metadata(&info.path).map_or(0, |m| m.len());
        if bytes > LARGE_BYTES && bytes / MOST_EXPANSION > length {
            return Err(format!(
                "expected overviews in a file of {length} bytes that claims {} x {} pixels, found none that are small: {advice}",
                size.width, size.height
            ));
        }
        Ok(())
    }

    /// Makes the pyramid, in the cache folder if that can be written, else in memory.
    fn make(&self, options: &OpenOptions) -> Result<GeoTiff, OpenError> {
        let source = &self.base.info().path;
        let failed = |reason: String| OpenError::Pyramid {
            reason,
            path: source.clone(),
        };
        self.check_size().map_err(failed)?;
        if let Some(folder) = &options.cache_dir {
            match self.make_in_folder(folder, options) {
                Ok(tiff) => return Ok(tiff),
                Err(Trouble::Read(error)) => return Err(OpenError::from_read(error, source)),
                Err(Trouble::Write(reason)) => {
                    tracing::warn!(%reason, ?folder, "keeping a pyramid in memory");
                }
            }
        }
        let bytes: u64 = self
            .levels()
            .iter()
            .map(|l| u64::from(l.width) * u64::from(l.height))
            .sum::<u64>()
            * 4;
        if bytes > MEMORY_LIMIT_BYTES {
            return Err(failed(format!(
                "expected a cache folder that can be written, with about {} MiB free",
                bytes >> 20
            )));
        }
        let store = match self.write(Store::memory(), options) {
            Ok(store) => store,
            Err(Trouble::Read(error)) => return Err(OpenError::from_read(error, source)),
            Err(Trouble::Write(reason)) => return Err(failed(reason)),
        };
        let bytes = store
            .into_memory()
            .ok_or_else(|| failed("a store in memory stays there".into()))?;
        self.opened(Bytes::Memory(bytes), source, options)
            .map_err(failed)
    }

    fn make_in_folder(&self, folder: &Path, options: &OpenOptions) -> Result<GeoTiff, Trouble> {
        let write = |e: std::io::Error| Trouble::Write(e.to_string());
        std::fs::create_dir_all(folder).map_err(write)?;
        let store = self.write(Store::file_in(folder).map_err(write)?, options)?;
        let path = self.path(folder);
        store.persist(&path).map_err(write)?;
        let bytes = Bytes::open(&path).map_err(write)?;
        self.opened(bytes, &path, options).map_err(Trouble::Write)
    }

    /// Writes all levels, each from the one before.
    fn write(&self, store: Store, options: &OpenOptions) -> Result<Store, Trouble> {
        let info = self.base.info();
        let levels = self.levels();
        let mut writer = Writer::new(store, Samples::for_file(info), info.bands)
            .map_err(|e| Trouble::Write(e.to_string()))?;
        let total: usize = levels.iter().map(|l| tiles(*l).count()).sum();
        let done = AtomicUsize::new(0);
        let mut above = info.overviews[if self.copy {
            0
        } else {
            info.overviews.len() - 1
        }];
        for (i, size) in levels.iter().enumerate() {
            let from = if i > 0 {
                From::Written(i - 1)
            } else if self.copy {
                From::Base(0)
            } else {
                From::Base(info.overviews.len() - 1)
            };
            let step = Step {
                base: self.base,
                from,
                above,
                size: *size,
                cancel: &options.cancel,
            };
            let all: Vec<(u32, u32)> = tiles(*size).collect();
            writer.start_level(*size);
            for batch in all.chunks(BATCH_TILES) {
                for tile in step.make_tiles(batch, &writer)? {
                    writer
                        .add_tile(tile)
                        .map_err(|e| Trouble::Write(e.to_string()))?;
                }
                let so_far = done.fetch_add(batch.len(), Ordering::Relaxed) + batch.len();
                if let Some(progress) = &options.progress {
                    progress(so_far as f32 / total.max(1) as f32);
                }
            }
            above = *size;
        }
        writer.finish().map_err(|e| Trouble::Write(e.to_string()))
    }
}

/// Why a pyramid is not there.
enum Trouble {
    Read(ReadError),
    Write(String),
}

/// An encoded tile; `None` where nothing is to be stored.
type MadeTile = Result<Option<Vec<u8>>, Trouble>;

/// Where the finer level of a step is.
#[derive(Clone, Copy)]
enum From {
    Base(usize),
    Written(usize),
}

/// From one level to the next.
struct Step<'a> {
    base: &'a dyn RasterFile,
    from: From,
    above: OverviewInfo,
    size: OverviewInfo,
    cancel: &'a Cancel,
}

impl Step<'_> {
    /// Encoded tiles of a batch, in order, made by several threads.
    fn make_tiles(
        &self,
        batch: &[(u32, u32)],
        writer: &Writer,
    ) -> Result<Vec<Option<Vec<u8>>>, Trouble> {
        let next = AtomicUsize::new(0);
        let made: Mutex<Vec<Option<MadeTile>>> =
            Mutex::new((0..batch.len()).map(|_| None).collect());
        let work = || {
            let mut scratch = Block::new(self.base.info().bands, 0, 0);
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(tile) = batch.get(i) else { break };
                let result = self.make_tile(*tile, writer, &mut scratch);
                let failed = result.is_err();
                made.lock()[i] = Some(result);
                if failed {
                    // The others stop after the tile that they have at hand.
                    next.store(batch.len(), Ordering::Relaxed);
                }
            }
        };
        let threads = std::thread::available_parallelism()
            .map_or(1, |n| n.get().min(8))
            .min(batch.len());
        std::thread::scope(|scope| {
            for _ in 1..threads {
                // A thread that cannot start is missed by nobody: this one does its work.
                std::thread::Builder::new()
                    .name("pyramid".into())
                    .spawn_scoped(scope, work)
                    .ok();
            }
            work();
        });
        let mut tiles = Vec::with_capacity(batch.len());
        let mut made = made.into_inner();
        if let Some(at) = made.iter().position(|m| matches!(m, Some(Err(_))))
            && let Some(Err(trouble)) = made.swap_remove(at)
        {
            return Err(trouble);
        }
        for tile in made.into_iter().flatten() {
            tiles.push(tile?);
        }
        Ok(tiles)
    }

    fn make_tile(
        &self,
        (column, row): (u32, u32),
        writer: &Writer,
        scratch: &mut Block,
    ) -> Result<Option<Vec<u8>>, Trouble> {
        let wanted = PixelRect {
            x: column * TILE,
            y: row * TILE,
            width: TILE.min(self.size.width - column * TILE),
            height: TILE.min(self.size.height - row * TILE),
        };
        if self.above == self.size {
            self.read(wanted, scratch, writer)?;
            return Ok(writer.encode(scratch));
        }
        let reduction = Reduction::new(self.above, self.size, wanted);
        self.read(reduction.needs(), scratch, writer)?;
        Ok(writer.encode(&reduction.apply(scratch)))
    }

    fn read(&self, rect: PixelRect, out: &mut Block, writer: &Writer) -> Result<(), Trouble> {
        match self.from {
            From::Base(level) => self
                .base
                .read(level, rect, out, self.cancel)
                .map_err(Trouble::Read),
            From::Written(_) if self.cancel.is_cancelled() => {
                Err(Trouble::Read(ReadError::Cancelled))
            }
            From::Written(level) => writer
                .read(level, rect, out)
                .map_err(|e| Trouble::Write(e.to_string())),
        }
    }
}

/// Columns and rows of all tiles of a level, row by row.
fn tiles(size: OverviewInfo) -> impl Iterator<Item = (u32, u32)> {
    (0..size.height.div_ceil(TILE))
        .flat_map(move |row| (0..size.width.div_ceil(TILE)).map(move |column| (column, row)))
}

impl RasterFile for Completed {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn remarks(&self) -> &[String] {
        &self.remarks
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
        match &self.base {
            Some(base) if overview < self.own => base.read(overview, rect, out, cancel),
            _ => {
                self.made.read(overview - self.own, rect, out, cancel)?;
                // Rounding in storage must not leave a height file with colours or vice versa.
                debug_assert_eq!(
                    out.bands(),
                    if self.info.bands == Bands::Height {
                        Bands::Height
                    } else {
                        Bands::Colour
                    }
                );
                Ok(())
            }
        }
    }
}
