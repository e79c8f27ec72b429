//! PMTiles, version 3: tiles in one file with directories of their own.
//!
//! Source: Protomaps, "PMTiles Version 3 Specification". Tiles are numbered along a Hilbert curve,
//! zoom after zoom; a directory maps runs of numbers to tiles or to further directories.

use std::collections::HashMap;
use std::io::Read;
use std::sync::Arc;

use parking_lot::Mutex;
use serde_json::Value;

use super::decode::MAX_TILE_BYTES;
use super::store::{Description, Hints, MAX_ZOOM, Store, TileAt, sensible};
use crate::fault::{Fault, damaged, unsupported};
use crate::geotiff::Bytes;

/// Bytes of the header.
const HEADER_BYTES: usize = 127;
/// Decompressed bytes of a directory or of the metadata at most.
const MAX_DIRECTORY_BYTES: u64 = 16 << 20;
/// Bytes of metadata that are parsed at most: values take many times the memory of their text.
const MAX_METADATA_BYTES: usize = 1 << 20;
/// Directories below the root at most: the specification hopes for one.
const MAX_DEPTH: usize = 4;
/// Entries of directories kept in memory at most.
const MAX_KEPT_ENTRIES: usize = 1 << 21;

/// How directories are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compression {
    None,
    Gzip,
    Zstd,
}

/// A run of tiles or, with a run of 0, a further directory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Entry {
    tile_id: u64,
    offset: u64,
    length: u64,
    run: u64,
}

/// Directories that were read, by their place.
#[derive(Default)]
struct Kept {
    directories: HashMap<u64, Arc<Vec<Entry>>>,
    entries: usize,
}

/// An open file.
pub(super) struct PmTiles {
    bytes: Bytes,
    root: Arc<Vec<Entry>>,
    leaves_at: u64,
    tiles_at: u64,
    internal: Compression,
    kept: Mutex<Kept>,
}

impl PmTiles {
    /// Reads header, metadata and root directory.
    pub(super) fn open(bytes: Bytes) -> Result<(Self, Description), Fault> {
        let mut header = [0; HEADER_BYTES];
        bytes.read_at(0, &mut header)?;
        if header[7] != 3 {
            return unsupported(format!(
                "expected version 3 of PMTiles, found version {}",
                header[7]
            ));
        }
        let long = |at: usize| {
            header[at..at + 8]
                .iter()
                .rev()
                .fold(0_u64, |n, b| n << 8 | u64::from(*b))
        };
        let degrees = |at: usize| {
            let bytes = [header[at], header[at + 1], header[at + 2], header[at + 3]];
            f64::from(i32::from_le_bytes(bytes)) / 1e7
        };
        let internal = match header[97] {
            1 => Compression::None,
            2 => Compression::Gzip,
            4 => Compression::Zstd,
            other => {
                return unsupported(format!(
                    "expected directories compressed by gzip or Zstandard or not, found method {other}"
                ));
            }
        };
        if !matches!(header[98], 0..=2) {
            return unsupported(format!(
                "expected tiles that are not compressed or by gzip, found method {}",
                header[98]
            ));
        }
        match header[99] {
            0 | 2..=4 => {}
            1 => return unsupported("expected PNG, JPEG or WebP tiles, found vector tiles (MVT)"),
            5 => return unsupported("expected PNG, JPEG or WebP tiles, found AVIF"),
            other => {
                return unsupported(format!(
                    "expected PNG, JPEG or WebP tiles, found type {other}"
                ));
            }
        }
        let (min_zoom, max_zoom) = (header[100], header[101]);
        if min_zoom > max_zoom || max_zoom > MAX_ZOOM {
            return damaged(format!(
                "expected zooms that rise up to {MAX_ZOOM} at most, found {min_zoom} to {max_zoom}"
            ));
        }
        let mut hints = Hints::default();
        if long(32) > 0 {
            let text = decompressed(&bytes, long(24), long(32), internal)?;
            // Metadata that cannot be read cost hints, no tiles.
            if text.len() <= MAX_METADATA_BYTES
                && let Ok(Value::Object(members)) = serde_json::from_slice::<Value>(&text)
            {
                hints.take(&members);
            }
        }
        let own = [degrees(102), degrees(106), degrees(110), degrees(114)];
        if sensible(own) {
            hints.bounds_deg = Some(own);
        }
        let root = directory(&decompressed(&bytes, long(8), long(16), internal)?)?;
        let file = Self {
            bytes,
            root: Arc::new(root),
            leaves_at: long(40),
            tiles_at: long(56),
            internal,
            kept: Mutex::default(),
        };
        let description = Description {
            min_zoom,
            max_zoom,
            first: file.first()?,
            extent: None,
            hints,
        };
        Ok((file, description))
    }

    /// The first tile of the file.
    fn first(&self) -> Result<Option<TileAt>, Fault> {
        let mut directory = Arc::clone(&self.root);
        for _ in 0..=MAX_DEPTH {
            let Some(entry) = directory.first().copied() else {
                return Ok(None);
            };
            if entry.run > 0 {
                return Ok(tile_of(entry.tile_id));
            }
            directory = self.leaf(entry)?;
        }
        damaged(format!(
            "expected directories nested at most {MAX_DEPTH} times, found more"
        ))
    }

    fn leaf(&self, entry: Entry) -> Result<Arc<Vec<Entry>>, Fault> {
        let Some(at) = self.leaves_at.checked_add(entry.offset) else {
            return damaged("expected a directory inside of the file");
        };
        if let Some(known) = self.kept.lock().directories.get(&at) {
            return Ok(Arc::clone(known));
        }
        let bytes = decompressed(&self.bytes, at, entry.length, self.internal)?;
        let made = Arc::new(directory(&bytes)?);
        let mut kept = self.kept.lock();
        if kept.entries + made.len() > MAX_KEPT_ENTRIES {
            *kept = Kept::default();
        }
        if kept.directories.insert(at, Arc::clone(&made)).is_none() {
            kept.entries += made.len();
        }
        Ok(made)
    }
}

impl Store for PmTiles {
    fn tile(&self, tile: TileAt) -> Result<Option<Vec<u8>>, Fault> {
        let id = id_of(tile);
        let mut directory = Arc::clone(&self.root);
        for _ in 0..=MAX_DEPTH {
            let after = directory.partition_point(|e| e.tile_id <= id);
            let Some(entry) = after.checked_sub(1).map(|i| directory[i]) else {
                return Ok(None);
            };
            if entry.run == 0 {
                directory = self.leaf(entry)?;
                continue;
            }
            if id - entry.tile_id >= entry.run {
                return Ok(None);
            }
            if entry.length > MAX_TILE_BYTES {
                return damaged(format!(
                    "expected tiles of at most {} MiB, found {} bytes",
                    MAX_TILE_BYTES >> 20,
                    entry.length
                ));
            }
            let Some(at) = self.tiles_at.checked_add(entry.offset) else {
                return damaged("expected a tile inside of the file");
            };
            return Ok(Some(self.bytes.vec_at(at, entry.length)?));
        }
        damaged(format!(
            "expected directories nested at most {MAX_DEPTH} times, found more"
        ))
    }
}

fn decompressed(
    bytes: &Bytes,
    at: u64,
    length: u64,
    method: Compression,
) -> Result<Vec<u8>, Fault> {
    if length > MAX_DIRECTORY_BYTES {
        return damaged(format!(
            "expected directories of at most {} MiB, found {length} bytes",
            MAX_DIRECTORY_BYTES >> 20
        ));
    }
    let raw = bytes.vec_at(at, length)?;
    let mut out = Vec::new();
    let broken = |e: String| Fault::Damaged(format!("cannot decompress a directory: {e}"));
    match method {
        Compression::None => return Ok(raw),
        Compression::Gzip => flate2::read::GzDecoder::new(raw.as_slice())
            .take(MAX_DIRECTORY_BYTES + 1)
            .read_to_end(&mut out)
            .map_err(|e| broken(e.to_string()))?,
        Compression::Zstd => zstd::stream::read::Decoder::new(raw.as_slice())
            .map_err(|e| broken(e.to_string()))?
            .take(MAX_DIRECTORY_BYTES + 1)
            .read_to_end(&mut out)
            .map_err(|e| broken(e.to_string()))?,
    };
    if out.len() as u64 > MAX_DIRECTORY_BYTES {
        return damaged(format!(
            "expected directories of at most {} MiB, found more",
            MAX_DIRECTORY_BYTES >> 20
        ));
    }
    Ok(out)
}

/// The entries of a directory: all numbers of tiles, all runs, all lengths, all offsets.
fn directory(bytes: &[u8]) -> Result<Vec<Entry>, Fault> {
    let mut rest = bytes;
    let count = number(&mut rest)?;
    // Each entry takes four numbers of at least a byte.
    if count > rest.len() as u64 / 4 {
        return damaged(format!(
            "expected a directory of {count} entries, found {} bytes",
            rest.len()
        ));
    }
    let mut entries = vec![Entry::default(); count as usize];
    let mut tile_id = 0_u64;
    for entry in &mut entries {
        let step = number(&mut rest)?;
        let next = tile_id.checked_add(step);
        tile_id =
            next.ok_or_else(|| Fault::Damaged("expected numbers of tiles below 2⁶⁴".into()))?;
        entry.tile_id = tile_id;
    }
    for entry in &mut entries {
        entry.run = number(&mut rest)?;
    }
    for entry in &mut entries {
        entry.length = number(&mut rest)?;
    }
    let mut end = 0_u64;
    for (i, entry) in entries.iter_mut().enumerate() {
        let offset = number(&mut rest)?;
        entry.offset = match offset {
            0 if i == 0 => return damaged("expected an offset of the first entry, found none"),
            // Right after the entry before.
            0 => end,
            given => given - 1,
        };
        end = entry.offset.saturating_add(entry.length);
    }
    Ok(entries)
}

/// A number of seven bits a byte, the lowest first.
fn number(rest: &mut &[u8]) -> Result<u64, Fault> {
    let mut value = 0_u64;
    for shift in (0..64).step_by(7) {
        let Some((byte, after)) = rest.split_first() else {
            return damaged("expected a whole directory, found a part of one");
        };
        *rest = after;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Ok(value);
        }
    }
    damaged("expected numbers of at most 64 bits in a directory")
}

/// Tiles of all zooms before one.
fn tiles_before(zoom: u8) -> u64 {
    (0..u32::from(zoom)).map(|z| 1_u64 << (2 * z)).sum()
}

/// The number of a tile: those of coarser zooms, then its place on the Hilbert curve.
pub(super) fn id_of(tile: TileAt) -> u64 {
    let (mut x, mut y) = (u64::from(tile.column), u64::from(tile.row));
    let mut id = tiles_before(tile.zoom);
    for bit in (0..tile.zoom).rev() {
        let side = 1_u64 << bit;
        let (right, down) = (u64::from(x & side > 0), u64::from(y & side > 0));
        id += side * side * ((3 * right) ^ down);
        (x, y) = turned(x & (side - 1), y & (side - 1), side, right, down);
    }
    id
}

/// The tile with a number.
fn tile_of(id: u64) -> Option<TileAt> {
    let zoom = (0..=MAX_ZOOM).rev().find(|z| tiles_before(*z) <= id)?;
    let mut rest = id - tiles_before(zoom);
    if rest >= 1 << (2 * u32::from(zoom)) {
        return None;
    }
    let (mut x, mut y) = (0, 0);
    for bit in 0..zoom {
        let side = 1_u64 << bit;
        let right = (rest / 2) & 1;
        let down = (rest ^ right) & 1;
        (x, y) = turned(x, y, side, right, down);
        x += side * right;
        y += side * down;
        rest /= 4;
    }
    Some(TileAt {
        zoom,
        column: x as u32,
        row: y as u32,
    })
}

/// Mirrors and turns a quarter of the curve.
fn turned(x: u64, y: u64, side: u64, right: u64, down: u64) -> (u64, u64) {
    match (right, down) {
        (1, 0) => (side - 1 - y, side - 1 - x),
        (_, 0) => (y, x),
        _ => (x, y),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn tiles_have_the_numbers_of_the_specification() {
        let id = |zoom, column, row| id_of(TileAt { zoom, column, row });
        assert_eq!(id(0, 0, 0), 0);
        assert_eq!(
            [id(1, 0, 0), id(1, 0, 1), id(1, 1, 1), id(1, 1, 0)],
            [1, 2, 3, 4]
        );
        assert_eq!(id(2, 0, 0), 5);
        assert_eq!(id(12, 3423, 1763), 19_078_479);
    }

    proptest! {
        #[test]
        fn numbers_name_one_tile_each(zoom in 0..=MAX_ZOOM, x in any::<u32>(), y in any::<u32>()) {
            let mask = ((1_u64 << zoom) - 1) as u32;
            let tile = TileAt { zoom, column: x & mask, row: y & mask };
            prop_assert_eq!(tile_of(id_of(tile)), Some(tile));
        }

        #[test]
        fn no_bytes_make_a_directory_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            directory(&bytes).ok();
        }
    }
}
