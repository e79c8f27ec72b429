//! Features into files: GeoJSON and GeoPackage, in longitude and latitude of WGS 84.
//!
//! Longitudes may go on beyond ±180, neighbours less than 180° apart: what crosses the antimeridian is
//! cut there.
//! A file appears under its name when it is whole: it is written beside it and renamed.

mod cut;
mod geojson;
#[cfg(feature = "geopackage")]
mod geopackage;

use std::io;
use std::path::Path;

use tempfile::{Builder as TempBuilder, NamedTempFile};

use crate::error::Fault;
use crate::{Value, VectorError};

pub use geojson::{to_geojson, write_geojson};
#[cfg(feature = "geopackage")]
pub use geopackage::write_geopackage;

/// A place to write.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Longitude in degrees.
    pub lon_deg: f64,
    /// Latitude in degrees.
    pub lat_deg: f64,
    /// Height in metres, where there is one.
    pub height_m: Option<f64>,
}

impl Position {
    /// A place without a height.
    pub const fn new(lon_deg: f64, lat_deg: f64) -> Self {
        Self {
            lon_deg,
            lat_deg,
            height_m: None,
        }
    }
}

/// A geometry to write.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// One point or several.
    Points(Vec<Position>),
    /// One line or several.
    Lines(Vec<Vec<Position>>),
    /// One polygon or several: an outer ring and its holes each, closed or not, in any direction.
    Polygons(Vec<Vec<Vec<Position>>>),
}

impl Geometry {
    fn positions(&self) -> Box<dyn Iterator<Item = &Position> + '_> {
        match self {
            Self::Points(points) => Box::new(points.iter()),
            Self::Lines(lines) => Box::new(lines.iter().flatten()),
            Self::Polygons(polygons) => Box::new(polygons.iter().flatten().flatten()),
        }
    }

    #[cfg(feature = "geopackage")]
    fn has_heights(&self) -> bool {
        self.positions().any(|p| p.height_m.is_some())
    }
}

/// A feature to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Where it is.
    pub geometry: Geometry,
    /// What is known of it, in this order.
    pub properties: Vec<(String, Value)>,
}

/// A ring that ends where it began, in the direction that RFC 7946 asks for: outer rings
/// counterclockwise, holes clockwise.
fn closed(ring: &[Position], is_hole: bool) -> Vec<Position> {
    let mut ring = ring.to_vec();
    if let (Some(first), Some(last)) = (ring.first().copied(), ring.last())
        && first != *last
    {
        ring.push(first);
    }
    let twice: f64 = ring
        .windows(2)
        .map(|e| (e[1].lon_deg - e[0].lon_deg) * (e[1].lat_deg + e[0].lat_deg))
        .sum();
    // The shoelace formula has the other sign.
    if (twice > 0.0) != is_hole {
        ring.reverse();
    }
    ring
}

/// Makes a file beside its place and moves it there when it is whole.
fn whole(
    format: &'static str,
    path: &Path,
    write: impl FnOnce(&mut NamedTempFile) -> Result<(), Fault>,
) -> Result<(), VectorError> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    let make = || -> Result<(), Fault> {
        let mut file = TempBuilder::new()
            .prefix(".relievo-")
            .tempfile_in(folder.unwrap_or(Path::new(".")))?;
        write(&mut file)?;
        file.as_file().sync_all()?;
        file.persist(path)
            .map_err(|e| Fault::Io(e.error.to_string()))?;
        Ok(())
    };
    make().map_err(|fault| match fault {
        Fault::Damaged(reason) => Fault::Io(reason).of(format, path),
        other @ (Fault::Io(_) | Fault::Unsupported(_) | Fault::Cancelled) => other.of(format, path),
    })
}

/// Numbers that are not finite have no place in these files.
fn finite(features: &[Feature]) -> Result<(), Fault> {
    let fine = |p: &Position| {
        p.lon_deg.is_finite() && p.lat_deg.is_finite() && p.height_m.is_none_or(f64::is_finite)
    };
    let at = features
        .iter()
        .position(|f| !f.geometry.positions().all(fine));
    match at {
        Some(at) => Err(Fault::Unsupported(format!(
            "expected coordinates that are numbers, found others in feature {at}"
        ))),
        None => Ok(()),
    }
}

fn io_fault(error: &io::Error) -> Fault {
    Fault::Io(error.to_string())
}
