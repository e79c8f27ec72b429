//! What the kinds of tile sets have in common.

use serde_json::{Map, Value};

use super::encoding::HeightEncoding;
use crate::fault::Fault;
use crate::open::TileRows;

/// Finest zoom that a set may have: coordinates of tiles stay below 2³⁰.
pub(super) const MAX_ZOOM: u8 = 30;

/// Where tiles come from.
pub(super) trait Store: Send + Sync {
    /// The bytes of a tile, rows counted from north; `None` where the set has none.
    fn tile(&self, tile: TileAt) -> Result<Option<Vec<u8>>, Fault>;
}

/// A tile's place: rows from north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TileAt {
    pub(super) zoom: u8,
    pub(super) column: u32,
    pub(super) row: u32,
}

impl TileAt {
    /// The same with rows counted from the other side.
    pub(super) fn flipped(self) -> Self {
        Self {
            row: ((1_u64 << self.zoom) - 1 - u64::from(self.row)) as u32,
            ..self
        }
    }
}

impl core::fmt::Display for TileAt {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}/{}/{}", self.zoom, self.column, self.row)
    }
}

/// What a set says of itself, or what a look at it shows.
#[derive(Debug, Default)]
pub(super) struct Description {
    /// Coarsest zoom with tiles.
    pub(super) min_zoom: u8,
    /// Finest zoom with tiles.
    pub(super) max_zoom: u8,
    /// A tile that exists: it shows the size of all.
    pub(super) first: Option<TileAt>,
    /// Columns and rows, half open, of the tiles of a zoom that cover everything.
    pub(super) extent: Option<TileExtent>,
    pub(super) hints: Hints,
}

/// Tiles of a zoom, half open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileExtent {
    pub(super) zoom: u8,
    pub(super) columns: (u32, u32),
    pub(super) rows: (u32, u32),
}

/// What metadata say.
#[derive(Debug, Default)]
pub(super) struct Hints {
    /// West, south, east, north in degrees.
    pub(super) bounds_deg: Option<[f64; 4]>,
    pub(super) encoding: Option<HeightEncoding>,
    pub(super) rows: Option<TileRows>,
    /// Tiles are vector tiles.
    pub(super) vector: bool,
}

impl Hints {
    /// Takes what is useful from TileJSON or the like: numbers may be texts.
    pub(super) fn take(&mut self, members: &Map<String, Value>) {
        for (name, value) in members {
            self.take_one(name, value);
        }
    }

    /// Takes one member.
    pub(super) fn take_one(&mut self, name: &str, value: &Value) {
        match name.to_ascii_lowercase().as_str() {
            "bounds" => self.bounds_deg = bounds(value).or(self.bounds_deg),
            "encoding" | "terrain_encoding" => {
                let found = value.as_str().and_then(HeightEncoding::from_name);
                self.encoding = found.or(self.encoding);
            }
            "scheme" => {
                self.rows = match value.as_str() {
                    Some("tms") => Some(TileRows::FromSouth),
                    Some("xyz") => Some(TileRows::FromNorth),
                    _ => self.rows,
                };
            }
            "format" => {
                self.vector |= value
                    .as_str()
                    .is_some_and(|f| f.contains("pbf") || f.contains("mvt"));
            }
            // MBTiles keep what is not text in a row of its own.
            "json" => {
                let inner = value.as_str().map(serde_json::from_str::<Value>);
                if let Some(Ok(Value::Object(inner))) = inner {
                    self.take(&inner);
                }
            }
            _ => {}
        }
    }
}

/// West, south, east, north that make sense.
fn bounds(value: &Value) -> Option<[f64; 4]> {
    let numbers: Vec<f64> = match value {
        Value::String(text) => text
            .split(',')
            .map(|n| n.trim().parse().ok())
            .collect::<Option<_>>()?,
        Value::Array(values) => values.iter().map(Value::as_f64).collect::<Option<_>>()?,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::Object(_) => return None,
    };
    let bounds: [f64; 4] = numbers.try_into().ok()?;
    sensible(bounds).then_some(bounds)
}

/// Whether bounds in degrees hold something.
pub(super) fn sensible([west, south, east, north]: [f64; 4]) -> bool {
    [west, south, east, north].iter().all(|v| v.is_finite())
        && west < east
        && south < north
        && west >= -360.0
        && east <= 360.0
        && south >= -90.0
        && north <= 90.0
}
