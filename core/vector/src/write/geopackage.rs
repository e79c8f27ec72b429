//! GeoPackage 1.3 (OGC 12-128r18): one table of features.

use std::borrow::Cow;
use std::path::Path;

use rusqlite::types::ToSqlOutput;
use rusqlite::{Connection, ToSql, params_from_iter};

use super::{Feature, Geometry, Position, closed, cut, finite, whole};
use crate::error::Fault;
use crate::{Value, VectorError};

const SCHEMA: &str = r#"
PRAGMA application_id = 0x47504B47;
PRAGMA user_version = 10300;
PRAGMA journal_mode = OFF;
PRAGMA synchronous = OFF;
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY,
  organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL,
  description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL,
  identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT
  '1970-01-01T00:00:00.000Z', min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL,
  geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined Cartesian SRS', -1, 'NONE', -1, 'undefined', NULL),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined', NULL),
  ('WGS 84 geodetic', 4326, 'EPSG', 4326, 'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]]', NULL);
"#;

/// Names of the table's own columns.
const KEY: &str = "fid";
const GEOMETRY: &str = "geom";

/// Writes a GeoPackage with one table of features, replacing what has its name. The same features
/// give the same bytes: the date of the last change is not recorded.
///
/// # Errors
/// [`VectorError`] where it cannot be written or a coordinate is not a number.
pub fn write_geopackage(path: &Path, table: &str, features: &[Feature]) -> Result<(), VectorError> {
    whole("GeoPackage", path, |file| {
        finite(features)?;
        let connection = Connection::open(file.path()).map_err(|e| sql(&e))?;
        write(&connection, table, features).map_err(|e| sql(&e))?;
        connection.close().map_err(|(_, e)| sql(&e))
    })
}

fn sql(error: &rusqlite::Error) -> Fault {
    Fault::Io(error.to_string())
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

fn write(
    connection: &Connection,
    table: &str,
    features: &[Feature],
) -> Result<(), rusqlite::Error> {
    connection.execute_batch(SCHEMA)?;
    let has_heights = features.iter().any(|f| f.geometry.has_heights());
    let columns = columns(features);
    let definitions: Vec<String> = columns
        .iter()
        .map(|(_, column, kind)| format!(", {} {kind}", quoted(column)))
        .collect();
    let definitions = definitions.concat();
    connection.execute_batch(&format!(
        "CREATE TABLE {} ({KEY} INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, {GEOMETRY} GEOMETRY{definitions});",
        quoted(table)
    ))?;
    let mut bounds = [
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    ];
    let geometries: Vec<Cow<'_, Geometry>> =
        features.iter().map(|f| cut::within(&f.geometry)).collect();
    for p in geometries.iter().flat_map(|g| g.positions()) {
        bounds = [
            bounds[0].min(p.lon_deg),
            bounds[1].min(p.lat_deg),
            bounds[2].max(p.lon_deg),
            bounds[3].max(p.lat_deg),
        ];
    }
    let bound = |v: f64| v.is_finite().then_some(v);
    connection.execute(
        "INSERT INTO gpkg_contents (table_name, data_type, identifier, min_x, min_y, max_x, max_y, srs_id) \
         VALUES (?1, 'features', ?1, ?2, ?3, ?4, ?5, 4326)",
        (table, bound(bounds[0]), bound(bounds[1]), bound(bounds[2]), bound(bounds[3])),
    )?;
    connection.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?1, ?2, 'GEOMETRY', 4326, ?3, 0)",
        (table, GEOMETRY, if has_heights { 2 } else { 0 }),
    )?;
    let places = ", ?".repeat(columns.len());
    let names: Vec<String> = columns
        .iter()
        .map(|(_, column, _)| format!(", {}", quoted(column)))
        .collect();
    let names = names.concat();
    connection.execute_batch("BEGIN")?;
    let mut statement = connection.prepare(&format!(
        "INSERT INTO {} ({GEOMETRY}{names}) VALUES (?{places})",
        quoted(table)
    ))?;
    for (feature, geometry) in features.iter().zip(&geometries) {
        let geometry = Cell::Geometry(blob(geometry));
        let properties = columns.iter().map(|(property, _, _)| {
            let found = feature.properties.iter().find(|(name, _)| name == property);
            Cell::Value(found.map_or(Value::Null, |(_, value)| value.clone()))
        });
        statement.execute(params_from_iter([geometry].into_iter().chain(properties)))?;
    }
    drop(statement);
    connection.execute_batch("COMMIT")
}

/// Properties of all features: each one's name, its column's (SQL does not tell case apart, and two
/// names are taken) and its type.
fn columns(features: &[Feature]) -> Vec<(String, String, &'static str)> {
    let mut columns: Vec<(String, String, &'static str)> = Vec::new();
    let mut taken = vec![KEY.to_owned(), GEOMETRY.to_owned()];
    for (name, value) in features.iter().flat_map(|f| &f.properties) {
        let kind = match value {
            Value::Null => continue,
            Value::Bool(_) => "BOOLEAN",
            Value::Int(_) => "INTEGER",
            Value::Float(_) => "REAL",
            Value::Text(_) => "TEXT",
        };
        if let Some((_, _, known)) = columns.iter_mut().find(|(known, _, _)| known == name) {
            if *known != kind {
                let numbers = |k: &str| matches!(k, "INTEGER" | "REAL");
                *known = if numbers(known) && numbers(kind) {
                    "REAL"
                } else {
                    "TEXT"
                };
            }
            continue;
        }
        let mut column = name.clone();
        while taken.contains(&column.to_lowercase()) {
            column.push('_');
        }
        taken.push(column.to_lowercase());
        columns.push((name.clone(), column, kind));
    }
    columns
}

enum Cell {
    Geometry(Vec<u8>),
    Value(Value),
}

impl ToSql for Cell {
    fn to_sql(&self) -> rusqlite::Result<ToSqlOutput<'_>> {
        Ok(match self {
            Self::Geometry(blob) => blob.as_slice().into(),
            Self::Value(Value::Null) => rusqlite::types::Null.into(),
            Self::Value(Value::Bool(v)) => (*v).into(),
            Self::Value(Value::Int(v)) => (*v).into(),
            Self::Value(Value::Float(v)) => (*v).into(),
            Self::Value(Value::Text(v)) => ToSqlOutput::from(&**v),
        })
    }
}

/// A geometry in GeoPackage's wrapping: little-endian, no envelope, WGS 84, then ISO WKB.
fn blob(geometry: &Geometry) -> Vec<u8> {
    let mut out = Out {
        bytes: vec![b'G', b'P', 0, 1],
        heights: geometry.has_heights(),
    };
    out.bytes.extend(4326_i32.to_le_bytes());
    match geometry {
        Geometry::Points(points) => {
            if let [only] = &points[..] {
                out.point(only);
            } else {
                out.head(4, points.len());
                for p in points {
                    out.point(p);
                }
            }
        }
        Geometry::Lines(lines) => {
            if let [only] = &lines[..] {
                out.line(only);
            } else {
                out.head(5, lines.len());
                for l in lines {
                    out.line(l);
                }
            }
        }
        Geometry::Polygons(polygons) => {
            if let [only] = &polygons[..] {
                out.polygon(only);
            } else {
                out.head(6, polygons.len());
                for p in polygons {
                    out.polygon(p);
                }
            }
        }
    }
    out.bytes
}

struct Out {
    bytes: Vec<u8>,
    heights: bool,
}

impl Out {
    fn kind(&mut self, kind: u32) {
        self.bytes.push(1);
        let kind = kind + if self.heights { 1000 } else { 0 };
        self.bytes.extend(kind.to_le_bytes());
    }

    fn head(&mut self, kind: u32, count: usize) {
        self.kind(kind);
        self.count(count);
    }

    fn count(&mut self, count: usize) {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        self.bytes.extend(count.to_le_bytes());
    }

    fn position(&mut self, p: &Position) {
        self.bytes.extend(p.lon_deg.to_le_bytes());
        self.bytes.extend(p.lat_deg.to_le_bytes());
        if self.heights {
            self.bytes.extend(p.height_m.unwrap_or(0.0).to_le_bytes());
        }
    }

    fn point(&mut self, p: &Position) {
        self.kind(1);
        self.position(p);
    }

    fn line(&mut self, line: &[Position]) {
        self.head(2, line.len());
        for p in line {
            self.position(p);
        }
    }

    fn polygon(&mut self, rings: &[Vec<Position>]) {
        self.head(3, rings.len());
        for (i, ring) in rings.iter().enumerate() {
            let ring = closed(ring, i > 0);
            self.count(ring.len());
            for p in &ring {
                self.position(p);
            }
        }
    }
}
