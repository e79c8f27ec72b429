//! Features as results: GeoJSON and GeoPackage.

use std::path::{Path, PathBuf};

use relievo_engine::Engine;
use relievo_engine::vector::write::{Feature, to_geojson};

use super::{Context, Failure, measure, project};
use crate::report;

/// Ends of the names of files that features are written to.
#[cfg(feature = "readers")]
pub(crate) const EXTENSIONS: [&str; 3] = ["geojson", "json", "gpkg"];
/// Ends of the names of files that features are written to.
#[cfg(not(feature = "readers"))]
pub(crate) const EXTENSIONS: [&str; 2] = ["geojson", "json"];

/// Writes features to a GeoJSON file or a GeoPackage, whole or not at all, or as GeoJSON to standard
/// output. `table` names the GeoPackage's table, `read` is the project's file.
pub(crate) fn deliver(
    features: &[Feature],
    table: &str,
    file: Option<&PathBuf>,
    read: &Path,
    engine: &Engine,
    context: &mut Context,
) -> Result<(), Failure> {
    let Some(file) = file else {
        let text = to_geojson(features).map_err(Failure::system)?;
        return Ok(context.out.write_all(text.as_bytes())?);
    };
    measure::check_extension(file, &EXTENSIONS)?;
    project::check_output(file, &[read], engine)?;
    if context.cancel.is_cancelled() {
        return Err(Failure::Cancelled);
    }
    report::write_features(file, table, features).map_err(Failure::system)
}
