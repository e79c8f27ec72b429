//! Tiles as files: `zoom/column/row.png` in a folder.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde_json::Value;

use super::decode::MAX_TILE_BYTES;
use super::store::{Description, Hints, MAX_ZOOM, Store, TileAt};
use crate::fault::{Fault, damaged, unsupported};
use crate::open::TileRows;

/// Entries of folders looked at when opened: a larger set is taken to cover the whole map.
const MAX_ENTRIES: usize = 200_000;
/// Bytes of a file of metadata at most.
const MAX_METADATA_BYTES: u64 = 4 << 20;
/// What file names of tiles may end with after the row.
const SUFFIXES: [&str; 8] = [
    ".png", ".jpg", ".jpeg", ".webp", "@2x.png", "@2x.jpg", "@2x.jpeg", "@2x.webp",
];

/// A folder of tiles.
pub(super) struct Folder {
    path: PathBuf,
    /// Those of [`SUFFIXES`] that occur.
    suffixes: Vec<&'static str>,
    rows: TileRows,
}

/// What was found in a folder.
#[derive(Default)]
struct Listing {
    tiles: Vec<TileAt>,
    suffixes: Vec<&'static str>,
    zooms: Vec<u8>,
    /// Names of files that are vector tiles.
    vector: bool,
    entries: usize,
    /// Names, lengths and times of all that was seen.
    facts: Vec<String>,
}

/// Whether a folder looks like a set of tiles: a folder named by a zoom lies in it.
pub(crate) fn is_one(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|entries| {
        entries
            .take(MAX_ENTRIES)
            .filter_map(Result::ok)
            .any(|e| zoom_of(&e.file_name().to_string_lossy()).is_some() && e.path().is_dir())
    })
}

fn zoom_of(name: &str) -> Option<u8> {
    number(name)
        .and_then(|n| u8::try_from(n).ok())
        .filter(|z| *z <= MAX_ZOOM)
}

/// A number without signs or other ornaments.
fn number(text: &str) -> Option<u32> {
    let plain = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    plain.then(|| text.parse().ok())?
}

impl Folder {
    /// Looks at a folder; the text names its state for a fingerprint.
    pub(super) fn open(
        path: &Path,
        rows: Option<TileRows>,
    ) -> Result<(Self, Description, String), Fault> {
        let mut hints = Hints::default();
        for name in ["metadata.json", "tiles.json", "tilejson.json"] {
            if let Some(Value::Object(members)) = read_text(&path.join(name))
                .and_then(|text| serde_json::from_str::<Value>(&text).ok())
            {
                hints.take(&members);
            }
        }
        if let Some(text) = read_text(&path.join("tilemapresource.xml")) {
            // gdal2tiles and others write it beside rows that count from south.
            hints.rows = hints.rows.or(Some(TileRows::FromSouth));
            if text.contains("profile=\"") && !text.contains("mercator\"") {
                return unsupported(
                    "expected tiles in Web Mercator, found another profile in tilemapresource.xml",
                );
            }
        }
        let mut listing = Listing::default();
        let complete = listing.fill(path)?;
        let rows = rows.or(hints.rows).unwrap_or(TileRows::FromNorth);
        let Some(first) = listing.tiles.iter().min().copied() else {
            return if listing.vector || hints.vector {
                unsupported("expected PNG, JPEG or WebP tiles, found vector tiles")
            } else {
                damaged("expected tiles as zoom/column/row.png, .jpg or .webp, found none")
            };
        };
        let turned = |tile: TileAt| match rows {
            TileRows::FromNorth => tile,
            TileRows::FromSouth => tile.flipped(),
        };
        let all = listing.tiles.iter().map(|t| turned(*t));
        let (zooms, extent) = if complete {
            let zooms = all.clone().map(|t| t.zoom);
            (zooms.collect(), super::frame::extent_of(all))
        } else {
            (listing.zooms.clone(), None)
        };
        let description = Description {
            min_zoom: zooms.iter().min().copied().unwrap_or(first.zoom),
            max_zoom: zooms.iter().max().copied().unwrap_or(first.zoom),
            first: Some(turned(first)),
            extent,
            hints,
        };
        listing.facts.sort_unstable();
        let facts = listing.facts.join("\n");
        let folder = Self {
            path: path.to_owned(),
            suffixes: if complete {
                listing.suffixes
            } else {
                SUFFIXES.to_vec()
            },
            rows,
        };
        Ok((folder, description, facts))
    }
}

fn read_text(path: &Path) -> Option<String> {
    let mut text = String::new();
    let file = fs::File::open(path).ok()?;
    file.take(MAX_METADATA_BYTES)
        .read_to_string(&mut text)
        .ok()?;
    Some(text)
}

impl Listing {
    /// Lists tiles from coarse to fine; `false` where there are too many.
    fn fill(&mut self, path: &Path) -> Result<bool, Fault> {
        let mut zooms: Vec<(u8, PathBuf)> = Vec::new();
        for (name, path) in self.entries(path)?.unwrap_or_default() {
            if let Some(zoom) = zoom_of(&name)
                && path.is_dir()
            {
                zooms.push((zoom, path));
            }
        }
        zooms.sort();
        self.zooms = zooms.iter().map(|(zoom, _)| *zoom).collect();
        for (zoom, path) in zooms {
            let Some(columns) = self.entries(&path)? else {
                return Ok(false);
            };
            for (name, path) in columns {
                let Some(column) = number(&name).filter(|c| u64::from(*c) < 1 << zoom) else {
                    continue;
                };
                if !path.is_dir() {
                    continue;
                }
                let Some(files) = self.entries(&path)? else {
                    return Ok(false);
                };
                for (name, path) in files {
                    self.file(zoom, column, &name, &path);
                }
            }
        }
        Ok(true)
    }

    fn file(&mut self, zoom: u8, column: u32, name: &str, path: &Path) {
        self.vector |= path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("pbf") || e.eq_ignore_ascii_case("mvt"));
        let digits = name.bytes().take_while(u8::is_ascii_digit).count();
        let Some(suffix) = SUFFIXES.iter().find(|s| **s == &name[digits..]) else {
            return;
        };
        let Some(row) = number(&name[..digits]).filter(|r| u64::from(*r) < 1 << zoom) else {
            return;
        };
        if let Ok(metadata) = fs::metadata(path) {
            let modified = metadata
                .modified()
                .ok()
                .and_then(|t| t.duration_since(UNIX_EPOCH).ok())
                .unwrap_or_default();
            self.facts.push(format!(
                "{zoom}/{column}/{name} {} {}",
                metadata.len(),
                modified.as_nanos()
            ));
        }
        if !self.suffixes.contains(suffix) {
            self.suffixes.push(suffix);
        }
        self.tiles.push(TileAt { zoom, column, row });
    }

    /// Names and paths in a folder; `None` where the budget is spent.
    fn entries(&mut self, path: &Path) -> Result<Option<Vec<(String, PathBuf)>>, Fault> {
        let mut found = Vec::new();
        for entry in fs::read_dir(path).map_err(Fault::Io)? {
            let entry = entry.map_err(Fault::Io)?;
            self.entries += 1;
            if self.entries > MAX_ENTRIES {
                return Ok(None);
            }
            found.push((
                entry.file_name().to_string_lossy().into_owned(),
                entry.path(),
            ));
        }
        Ok(Some(found))
    }
}

impl Store for Folder {
    fn tile(&self, tile: TileAt) -> Result<Option<Vec<u8>>, Fault> {
        let tile = match self.rows {
            TileRows::FromNorth => tile,
            TileRows::FromSouth => tile.flipped(),
        };
        let folder = self
            .path
            .join(tile.zoom.to_string())
            .join(tile.column.to_string());
        for suffix in &self.suffixes {
            let path = folder.join(format!("{}{suffix}", tile.row));
            let file = match fs::File::open(path) {
                Ok(file) => file,
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                Err(e) => return Err(Fault::Io(e)),
            };
            let mut bytes = Vec::new();
            file.take(MAX_TILE_BYTES)
                .read_to_end(&mut bytes)
                .map_err(Fault::Io)?;
            return Ok(Some(bytes));
        }
        // A folder that is gone altogether is no set of holes.
        if self.path.is_dir() {
            Ok(None)
        } else {
            Err(Fault::Io(io::ErrorKind::NotFound.into()))
        }
    }
}
