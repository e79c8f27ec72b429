//! Sets of map tiles in Web Mercator: folders, MBTiles, PMTiles; imagery or encoded heights.
//!
//! All zooms together are one raster: the finest is level 0, each coarser one an overview. The
//! raster is cropped to what the set covers, in steps of whole pixels of its coarsest level, so that
//! all levels cover the same ground. Sizes are virtual: nothing is held but tiles that were read.
//!
//! A tile that the set leaves out is filled from the next coarser zoom that has one, linearly
//! between its samples; where no level of the raster has one there is a hole. What a tile itself
//! leaves transparent (or black, for heights) stays a hole.
//!
//! Absent: vector tiles, other projections, tiles from a network.

mod decode;
mod encoding;
mod fill;
mod folder;
mod frame;
#[cfg(feature = "sqlite")]
mod mbtiles;
mod pmtiles;
mod store;

use std::path::Path;
use std::sync::Arc;

pub use encoding::HeightEncoding;
pub(crate) use folder::is_one as is_folder_of_tiles;

use crate::chunk_cache::{ChunkCache, ChunkKey};
use crate::fault::{Fault, damaged};
use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::geotiff::{Bytes, Chunk};
use crate::open::{OpenError, OpenOptions, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, pyramid};
use decode::Content;
use frame::Frame;
use store::{Description, Store, TileAt};
use tiff::decoder::DecodingResult;

/// Longest side of the coarsest own level: a pyramid is made from there on.
const MAX_COARSEST_SIDE: u32 = 1 << 16;
/// Kinds of tile sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A folder of files.
    Folder,
    /// An SQLite database.
    #[cfg(feature = "sqlite")]
    MbTiles,
    /// One file with directories.
    PmTiles,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Folder => "XYZ tiles",
            #[cfg(feature = "sqlite")]
            Self::MbTiles => "MBTiles",
            Self::PmTiles => "PMTiles",
        }
    }
}

/// An open set.
struct TileSet {
    info: RasterInfo,
    kind: Kind,
    store: Box<dyn Store>,
    content: Content,
    frame: Frame,
    fingerprint: [u8; 32],
    cache: Arc<ChunkCache>,
    /// Number of the set in the cache.
    number: u64,
}

/// Opens a set and completes its pyramid.
pub(crate) fn open(
    path: &Path,
    kind: Kind,
    options: &OpenOptions,
) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let on_open = |fault: Fault| fault.on_open(kind.name(), path);
    let mut facts = format!(
        "{} {:?} {:?}",
        options.sample_facts(),
        options.encoding,
        options.tile_rows
    );
    let (store, description): (Box<dyn Store>, Description) = match kind {
        Kind::Folder => {
            let (store, description, listing) =
                folder::Folder::open(path, options.tile_rows).map_err(on_open)?;
            facts.push_str(&listing);
            (Box::new(store), description)
        }
        #[cfg(feature = "sqlite")]
        Kind::MbTiles => {
            let (store, description) =
                mbtiles::MbTiles::open(path, options.tile_rows).map_err(on_open)?;
            (Box::new(store), description)
        }
        Kind::PmTiles => {
            let (store, description) =
                pmtiles::PmTiles::open(Bytes::open(path).map_err(io)?).map_err(on_open)?;
            (Box::new(store), description)
        }
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(facts.as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let content = content(path, &description, options)?;
    let (first, name) = first_tile(&*store, &description).map_err(on_open)?;
    // Now rather than with the first sample: lossy heights are of no use at all.
    let side = decode::side(&first).map_err(on_open)?;
    decode::decode(&first, side, content).map_err(on_open)?;
    let frame = Frame::of(&description, side).map_err(on_open)?;
    let overviews: Vec<OverviewInfo> = (0..frame.levels)
        .map(|level| frame.size_of(level))
        .collect();
    let coarsest = overviews[overviews.len() - 1];
    if options.make_pyramid && coarsest.width.max(coarsest.height) > MAX_COARSEST_SIDE {
        return Err(on_open(Fault::Unsupported(format!(
            "expected zooms down to one of at most {MAX_COARSEST_SIDE} pixels a side, found zoom {} \
             with {} × {} as the coarsest",
            description.min_zoom, coarsest.width, coarsest.height
        ))));
    }
    let info = RasterInfo {
        path: path.to_owned(),
        format: kind.name(),
        overviews,
        bands: match content {
            Content::Colour => Bands::Colour,
            Content::Height { .. } => Bands::Height,
        },
        band_count: match content {
            Content::Colour => 4,
            Content::Height { .. } => 1,
        },
        sample_type: match content {
            Content::Colour => "uint8".into(),
            Content::Height { encoding, .. } => format!("uint8 {encoding}"),
        },
        compression: format!(
            "{name} of {side} × {side}, zooms {} to {}",
            description.min_zoom, description.max_zoom
        ),
        deep_colour: false,
        nodata: options.nodata,
        may_have_holes: true,
        georeference: placed(
            Some(frame.plane_from_pixel()),
            Some("EPSG:3857".into()),
            options,
        ),
    };
    let cache = Arc::clone(&options.chunk_cache);
    let number = cache.new_file();
    let set = TileSet {
        info,
        kind,
        store,
        content,
        frame,
        fingerprint,
        cache,
        number,
    };
    pyramid::complete(Arc::new(set), false, fingerprint, options)
}

/// What the pixels mean, by the options or else by the metadata.
fn content(
    path: &Path,
    description: &Description,
    options: &OpenOptions,
) -> Result<Content, OpenError> {
    let refused = |reason: String| OpenError::Options {
        reason,
        path: path.to_owned(),
    };
    if options.select.is_some() {
        return Err(refused("bands of tiles cannot be selected".into()));
    }
    let encoding = options.encoding.or(description.hints.encoding);
    let heights = |encoding| Content::Height {
        encoding,
        nodata: options.nodata.map(|v| v as f32),
    };
    match (options.as_bands, encoding) {
        (Some(Bands::Height), None) => Err(refused(
            "expected the encoding of heights, terrain-rgb or terrarium, found none given and none \
             in the metadata"
                .into(),
        )),
        (Some(Bands::Height) | None, Some(encoding)) => Ok(heights(encoding)),
        (Some(Bands::Colour) | None, _) => Ok(Content::Colour),
        (Some(other @ (Bands::Mask | Bands::Normal)), _) => Err(refused(format!(
            "tiles hold heights or colours, {other:?} was asked for"
        ))),
    }
}

/// The bytes of a tile that exists, and the name of its format.
fn first_tile(
    store: &dyn Store,
    description: &Description,
) -> Result<(Vec<u8>, &'static str), Fault> {
    let Some(at) = description.first else {
        return damaged("expected tiles, found none");
    };
    let Some(bytes) = store.tile(at)? else {
        return damaged(format!("expected the tile {at}, found none"));
    };
    let bytes = decode::unwrapped(bytes)?;
    let (name, _) = decode::format(&bytes)?;
    Ok((bytes, name))
}

impl TileSet {
    /// A decoded tile of a level from the cache; `None` where the set has none.
    fn chunk(&self, level: u8, column: u32, row: u32) -> Result<Option<Arc<Chunk>>, Fault> {
        let tile = TileAt {
            zoom: self.frame.max_zoom - level,
            column,
            row,
        };
        let key = ChunkKey {
            file: self.number,
            image: level.into(),
            plane: 0,
            column,
            row,
        };
        self.cache.get(key, || {
            let named = |fault: Fault| match fault {
                Fault::Damaged(reason) | Fault::Unsupported(reason) => {
                    Fault::Damaged(format!("tile {tile}: {reason}"))
                }
                io @ Fault::Io(_) => io,
            };
            let Some(bytes) = self.store.tile(tile)? else {
                return Ok(None);
            };
            decode::unwrapped(bytes)
                .and_then(|bytes| decode::decode(&bytes, self.frame.side, self.content))
                .map(Some)
                .map_err(named)
        })
    }

    /// Reads a rectangle of a level into a block of its shape.
    fn read_level(
        &self,
        level: u8,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let side = u64::from(self.frame.side);
        // Pixels of the whole map at this zoom.
        let origin = (
            (self.frame.origin.0 >> level) + u64::from(rect.x),
            (self.frame.origin.1 >> level) + u64::from(rect.y),
        );
        let end = (
            origin.0 + u64::from(rect.width),
            origin.1 + u64::from(rect.height),
        );
        for row in origin.1 / side..end.1.div_ceil(side) {
            for column in origin.0 / side..end.0.div_ceil(side) {
                if cancel.is_cancelled() {
                    return Err(ReadError::Cancelled);
                }
                let x = (origin.0.max(column * side), end.0.min((column + 1) * side));
                let y = (origin.1.max(row * side), end.1.min((row + 1) * side));
                if x.0 >= x.1 || y.0 >= y.1 {
                    continue;
                }
                let part = PixelRect {
                    x: (x.0 - origin.0) as u32,
                    y: (y.0 - origin.1) as u32,
                    width: (x.1 - x.0) as u32,
                    height: (y.1 - y.0) as u32,
                };
                let chunk = self
                    .chunk(level, column as u32, row as u32)
                    .map_err(|f| f.on_read(self.kind.name(), &self.info.path))?;
                match chunk {
                    Some(chunk) => {
                        let from = ((x.0 - column * side) as usize, (y.0 - row * side) as usize);
                        copy(&chunk, side as usize, from, part, out);
                    }
                    None => self.fill(level, rect, part, out, cancel)?,
                }
            }
        }
        Ok(())
    }

    /// Fills a part of a block that stands for `rect` from the next coarser level.
    fn fill(
        &self,
        level: u8,
        rect: PixelRect,
        part: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        if level + 1 >= self.frame.levels {
            fill::empty(part, out);
            return Ok(());
        }
        let wanted = PixelRect {
            x: rect.x + part.x,
            y: rect.y + part.y,
            ..part
        };
        let needs = fill::needs(wanted, self.frame.size_of(level + 1));
        let mut coarse = Block::new(out.bands(), needs.width as usize, needs.height as usize);
        self.read_level(level + 1, needs, &mut coarse, cancel)?;
        fill::doubled(coarse, needs, wanted, part, out);
        Ok(())
    }
}

/// Copies a part of a tile.
fn copy(chunk: &Chunk, side: usize, from: (usize, usize), part: PixelRect, out: &mut Block) {
    let out_width = out.width();
    let width = part.width as usize;
    for y in 0..part.height as usize {
        let first = (from.1 + y) * side + from.0;
        let to = (part.y as usize + y) * out_width + part.x as usize;
        if let DecodingResult::F32(heights) = &chunk.samples {
            out.plane_mut(0)[to..to + width].copy_from_slice(&heights[first..first + width]);
        }
        if let DecodingResult::U8(rgba) = &chunk.samples {
            let pixels = rgba[first * 4..(first + width) * 4].as_chunks::<4>().0;
            for (plane, values) in out.planes_mut::<4>().into_iter().enumerate() {
                for (value, pixel) in values[to..to + width].iter_mut().zip(pixels) {
                    *value = crate::colour::from_u8(pixel[plane]);
                }
            }
        }
    }
}

impl RasterFile for TileSet {
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
        assert_inside(rect, self.info.overviews[overview]);
        out.reshape(self.info.bands, rect.width as usize, rect.height as usize);
        self.read_level(overview as u8, rect, out, cancel)
    }
}

impl Drop for TileSet {
    fn drop(&mut self) {
        self.cache.forget_file(self.number);
    }
}

#[cfg(test)]
mod tests;
