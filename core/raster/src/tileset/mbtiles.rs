//! MBTiles: tiles in an SQLite database.
//!
//! Opened as a stranger's ([`crate::sqlite`]).
//!
//! Source: MBTiles specification 1.3; rows count from south.

use std::path::Path;

use parking_lot::Mutex;
use rusqlite::{Connection, OptionalExtension};
use serde_json::Value;

use super::decode::MAX_TILE_BYTES;
use super::store::{Description, Hints, MAX_ZOOM, Store, TileAt, TileExtent};
use crate::fault::{Fault, damaged, unsupported};
use crate::open::TileRows;
use crate::sqlite::{self, Budget, Limits, OpenError};

/// Looks at the budget that a question may last: some seconds (tests are in more of a hurry).
const BUDGET: u64 = if cfg!(test) { 500 } else { 20_000 };
/// Rows of metadata at most.
const MAX_METADATA_ROWS: usize = 1000;

/// An open database.
pub(super) struct MbTiles {
    /// One question at a time: decoding takes longer by far.
    connection: Mutex<Connection>,
    budget: Budget,
    rows: TileRows,
}

fn fault(error: &rusqlite::Error) -> Fault {
    match error.sqlite_error_code() {
        Some(rusqlite::ErrorCode::OperationInterrupted) => Fault::Damaged(
            "expected an index of tiles by zoom, column and row: a question took too long".into(),
        ),
        Some(rusqlite::ErrorCode::SystemIoFailure | rusqlite::ErrorCode::CannotOpen) => {
            Fault::Io(std::io::Error::other(error.to_string()))
        }
        _ => {
            let text = error.to_string();
            let line: Vec<&str> = text.split_whitespace().collect();
            Fault::Damaged(line.join(" "))
        }
    }
}

impl MbTiles {
    /// Opens a database and reads its metadata.
    pub(super) fn open(path: &Path, rows: Option<TileRows>) -> Result<(Self, Description), Fault> {
        let limits = Limits {
            value_bytes: MAX_TILE_BYTES as i32,
            looks: BUDGET,
        };
        let (connection, budget) = sqlite::open(path, limits).map_err(|error| match error {
            OpenError::Io(error) => Fault::Io(error),
            OpenError::Database(error) => fault(&error),
        })?;
        let mut file = Self {
            connection: Mutex::new(connection),
            budget,
            rows: TileRows::FromSouth,
        };
        let hints = file.metadata()?;
        file.rows = rows.or(hints.rows).unwrap_or(TileRows::FromSouth);
        let description = file.describe(hints)?;
        Ok((file, description))
    }

    /// The connection with a fresh budget.
    fn ask(&self) -> parking_lot::MutexGuard<'_, Connection> {
        let connection = self.connection.lock();
        self.budget.refill();
        connection
    }

    fn has(&self, table: &str) -> Result<bool, Fault> {
        self.ask()
            .query_row(
                "SELECT count(*) FROM sqlite_master WHERE name = ?1 AND type IN ('table', 'view')",
                [table],
                |row| row.get::<_, i64>(0),
            )
            .map(|count| count > 0)
            .map_err(|e| fault(&e))
    }

    fn metadata(&self) -> Result<Hints, Fault> {
        let mut hints = Hints::default();
        if !self.has("tiles")? {
            return unsupported(
                "expected an MBTiles database with a table of tiles, found another SQLite file \
                 (a GeoPackage?)",
            );
        }
        if !self.has("metadata")? {
            return Ok(hints);
        }
        let connection = self.ask();
        let mut statement = connection
            .prepare("SELECT name, value FROM metadata")
            .map_err(|e| fault(&e))?;
        let mut rows = statement.query([]).map_err(|e| fault(&e))?;
        for _ in 0..MAX_METADATA_ROWS {
            let Some(row) = rows.next().map_err(|e| fault(&e))? else {
                break;
            };
            // Values of other types than text mean nothing here.
            if let (Ok(name), Ok(value)) = (row.get::<_, String>(0), row.get::<_, String>(1)) {
                hints.take_one(&name, &Value::String(value));
            }
        }
        Ok(hints)
    }

    fn describe(&self, hints: Hints) -> Result<Description, Fault> {
        if hints.vector {
            return unsupported("expected PNG, JPEG or WebP tiles, found vector tiles (pbf)");
        }
        let zooms = self
            .ask()
            .query_row(
                "SELECT (SELECT min(zoom_level) FROM tiles), (SELECT max(zoom_level) FROM tiles)",
                [],
                |row| Ok((row.get::<_, Option<i64>>(0)?, row.get::<_, Option<i64>>(1)?)),
            )
            .map_err(|e| fault(&e))?;
        let (Some(min), Some(max)) = zooms else {
            return damaged("expected tiles, found none");
        };
        let (Ok(min_zoom), Ok(max_zoom)) = (u8::try_from(min), u8::try_from(max)) else {
            return damaged(format!("expected zooms from 0, found {min} to {max}"));
        };
        if max_zoom > MAX_ZOOM {
            return unsupported(format!("expected zooms up to {MAX_ZOOM}, found {max_zoom}"));
        }
        let first = self
            .ask()
            .query_row(
                "SELECT tile_column, tile_row FROM tiles WHERE zoom_level = ?1 LIMIT 1",
                [min],
                |row| Ok((row.get::<_, u32>(0)?, row.get::<_, u32>(1)?)),
            )
            .map_err(|e| fault(&e))?;
        let first = self.turned(TileAt {
            zoom: min_zoom,
            column: first.0,
            row: first.1,
        });
        let extent = if hints.bounds_deg.is_some() {
            None
        } else {
            self.extent(min_zoom)?
        };
        Ok(Description {
            min_zoom,
            max_zoom,
            first,
            extent,
            hints,
        })
    }

    /// What the tiles of a zoom cover.
    fn extent(&self, zoom: u8) -> Result<Option<TileExtent>, Fault> {
        let side = 1_i64 << zoom;
        let found = self
            .ask()
            .query_row(
                "SELECT min(tile_column), max(tile_column), min(tile_row), max(tile_row) \
                 FROM tiles WHERE zoom_level = ?1",
                [zoom],
                |row| Ok([row.get(0)?, row.get(1)?, row.get(2)?, row.get::<_, i64>(3)?]),
            )
            .map_err(|e| fault(&e))?;
        if found.iter().any(|v| !(0..side).contains(v)) {
            return damaged(format!(
                "expected columns and rows of zoom {zoom} below {side}, found {found:?}"
            ));
        }
        let [x0, x1, mut y0, mut y1] = found;
        if self.rows == TileRows::FromSouth {
            (y0, y1) = (side - 1 - y1, side - 1 - y0);
        }
        Ok(Some(TileExtent {
            zoom,
            columns: (x0 as u32, x1 as u32 + 1),
            rows: (y0 as u32, y1 as u32 + 1),
        }))
    }

    /// Between the file's rows and rows from north; `None` for rows that do not exist.
    fn turned(&self, tile: TileAt) -> Option<TileAt> {
        let inside = u64::from(tile.row.max(tile.column)) < 1 << tile.zoom;
        inside.then(|| match self.rows {
            TileRows::FromNorth => tile,
            TileRows::FromSouth => tile.flipped(),
        })
    }
}

impl Store for MbTiles {
    fn tile(&self, tile: TileAt) -> Result<Option<Vec<u8>>, Fault> {
        let Some(tile) = self.turned(tile) else {
            return Ok(None);
        };
        let connection = self.ask();
        let mut statement = connection
            .prepare(
                "SELECT tile_data FROM tiles \
                 WHERE zoom_level = ?1 AND tile_column = ?2 AND tile_row = ?3",
            )
            .map_err(|e| fault(&e))?;
        let bytes: Option<Option<Vec<u8>>> = statement
            .query_row((tile.zoom, tile.column, tile.row), |row| row.get(0))
            .optional()
            .map_err(|e| fault(&e))?;
        Ok(bytes.flatten())
    }
}
