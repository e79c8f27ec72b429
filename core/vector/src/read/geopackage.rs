//! GeoPackage: features in a SQLite database.
//!
//! Opened as a stranger's ([`relievo_raster::sqlite`]); a database that another program is writing to is
//! read as it was last closed. Every row has a budget of its own, since tables may be views.
//!
//! Source: OGC 12-128r19 (GeoPackage 1.4).

use std::path::Path;

use relievo_raster::crs::from_wkt;
use relievo_raster::sqlite::{self, Budget, Limits, OpenError};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OptionalExtension};

use super::wkb;
use crate::error::{Fault, damaged, unsupported};
use crate::features::{Builder, Features};
use crate::open::{OpenOptions, Summary, system};
use crate::value::Value;

/// Looks at the budget until a row must be there: some seconds (tests are in more of a hurry).
const BUDGET: u64 = if cfg!(test) { 500 } else { 20_000 };
/// Bytes of a geometry or a text at most.
const MAX_VALUE_BYTES: i32 = 1 << 29;
/// Tables of features that are listed at most.
const MAX_LAYERS: usize = 1000;

fn fault(error: &rusqlite::Error) -> Fault {
    match error.sqlite_error_code() {
        Some(rusqlite::ErrorCode::OperationInterrupted) => {
            Fault::Damaged("expected a table of features: a question took too long".into())
        }
        Some(rusqlite::ErrorCode::SystemIoFailure | rusqlite::ErrorCode::CannotOpen) => {
            Fault::Io(error.to_string())
        }
        _ => Fault::Damaged(error.to_string()),
    }
}

struct Package {
    connection: Connection,
    budget: Budget,
}

/// A table of features.
struct Table {
    name: String,
    column: String,
    srs: i64,
}

/// Whether the database says that it holds features.
pub(crate) fn has_features(path: &Path) -> bool {
    Package::open(path)
        .and_then(|package| package.tables())
        .is_ok_and(|tables| !tables.is_empty())
}

pub(crate) fn read(path: &Path, options: &OpenOptions) -> Result<(Features, Summary), Fault> {
    let package = Package::open(path)?;
    let tables = package.tables()?;
    let layers: Vec<String> = tables.iter().map(|t| t.name.clone()).collect();
    let table = match &options.layer {
        Some(wanted) => tables.iter().find(|t| t.name == *wanted),
        None => tables.first(),
    };
    let Some(table) = table else {
        return unsupported(match &options.layer {
            Some(wanted) => format!(
                "expected a table of features named {wanted:?}, found {}",
                layers.join(", ")
            ),
            None => "expected a table of features, found none".to_owned(),
        });
    };
    let mut remarks = Vec::new();
    if options.layer.is_none() && tables.len() > 1 {
        remarks.push(format!(
            "holds {} tables of features, of which the first is read: {}",
            tables.len(),
            layers.join(", ")
        ));
    }
    let (crs, name) = system(options, package.system(table.srs)?, &mut remarks)?;
    let mut builder = Builder::new(crs, options.limits, options.cancel.clone());
    package.features(table, &mut builder)?;
    let summary = Summary {
        format: "GeoPackage",
        crs: name,
        layers,
        remarks,
    };
    Ok((builder.end()?, summary))
}

impl Package {
    fn open(path: &Path) -> Result<Self, Fault> {
        let limits = Limits {
            value_bytes: MAX_VALUE_BYTES,
            looks: BUDGET,
        };
        let (connection, budget) = sqlite::open(path, limits).map_err(|error| match error {
            OpenError::Io(error) => Fault::from(error),
            OpenError::Database(error) => fault(&error),
        })?;
        Ok(Self { connection, budget })
    }

    /// Starts a question's budget anew.
    fn refill(&self) {
        self.budget.refill();
    }

    fn tables(&self) -> Result<Vec<Table>, Fault> {
        self.refill();
        let sql = "SELECT c.table_name, g.column_name, g.srs_id FROM gpkg_contents c \
                   JOIN gpkg_geometry_columns g ON g.table_name = c.table_name \
                   WHERE c.data_type = 'features' ORDER BY c.rowid";
        let mut statement = self.connection.prepare(sql).map_err(|e| fault(&e))?;
        let rows = statement
            .query_map([], |row| {
                Ok(Table {
                    name: row.get(0)?,
                    column: row.get(1)?,
                    srs: row.get(2)?,
                })
            })
            .map_err(|e| fault(&e))?;
        rows.take(MAX_LAYERS)
            .map(|row| row.map_err(|e| fault(&e)))
            .collect()
    }

    /// The definition of a spatial reference system; `None` where it is undefined or not known.
    fn system(&self, srs: i64) -> Result<Option<String>, Fault> {
        self.refill();
        let sql = "SELECT organization, organization_coordsys_id, definition \
                   FROM gpkg_spatial_ref_sys WHERE srs_id = ?1";
        let found: Option<(String, i64, String)> = self
            .connection
            .query_row(sql, [srs], |row| {
                Ok((row.get(0)?, row.get(1)?, row.get(2)?))
            })
            .optional()
            .map_err(|e| fault(&e))?;
        let Some((organization, code, definition)) = found else {
            return damaged(format!(
                "expected the spatial reference system {srs} to be listed, found it missing"
            ));
        };
        let authority = organization.to_ascii_uppercase();
        if matches!(authority.as_str(), "EPSG" | "ESRI") && code > 0 {
            return Ok(Some(format!("{authority}:{code}")));
        }
        Ok(from_wkt(&definition))
    }

    fn features(&self, table: &Table, builder: &mut Builder) -> Result<(), Fault> {
        self.refill();
        let sql = format!("SELECT * FROM {}", quoted(&table.name));
        let mut statement = self.connection.prepare(&sql).map_err(|e| fault(&e))?;
        let names: Vec<String> = statement.column_names().map(str::to_owned).collect();
        let Some(geometry) = names.iter().position(|n| *n == table.column) else {
            return damaged(format!(
                "expected a column {:?} in table {:?}, found none",
                table.column, table.name
            ));
        };
        let mut rows = statement.query([]).map_err(|e| fault(&e))?;
        while let Some(row) = rows.next().map_err(|e| fault(&e))? {
            self.refill();
            for (i, name) in names.iter().enumerate() {
                let value = row.get_ref(i).map_err(|e| fault(&e))?;
                if i == geometry {
                    if let ValueRef::Blob(blob) = value {
                        add_geometry(builder, blob)?;
                    }
                    continue;
                }
                let value = match value {
                    ValueRef::Null => Value::Null,
                    ValueRef::Integer(v) => Value::Int(v),
                    ValueRef::Real(v) => Value::Float(v),
                    ValueRef::Text(text) => Value::from(&*String::from_utf8_lossy(text)),
                    ValueRef::Blob(blob) => Value::from(&*format!("{} bytes", blob.len())),
                };
                builder.add_property(name, value)?;
            }
            builder.end_feature()?;
        }
        Ok(())
    }
}

/// An SQL name.
fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// Adds a geometry in GeoPackage's own wrapping (clause 2.1.3).
fn add_geometry(builder: &mut Builder, blob: &[u8]) -> Result<(), Fault> {
    let Some(header) = blob.first_chunk::<8>() else {
        return damaged(format!(
            "expected a geometry of 8 bytes or more, found {}",
            blob.len()
        ));
    };
    if !header.starts_with(b"GP") {
        return damaged("expected a geometry that begins with GP, found another");
    }
    let flags = header[3];
    let envelope = match (flags >> 1) & 7 {
        0 => 0,
        1 => 32,
        2 | 3 => 48,
        4 => 64,
        other => {
            return damaged(format!(
                "expected an envelope of kind 0 to 4, found {other}"
            ));
        }
    };
    if flags & 0x10 != 0 {
        // Empty.
        return Ok(());
    }
    match blob.get(8 + envelope..) {
        Some(geometry) => wkb::add(builder, geometry),
        None => damaged("expected a geometry behind its envelope, found its end"),
    }
}
