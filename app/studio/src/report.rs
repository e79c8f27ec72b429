//! What was measured, as files: both faces write the same bytes.

mod html;
mod table;

use std::path::Path;

use relievo_engine::Engine;
use relievo_engine::analysis::{AnalysisError, Comparison, ComparisonReport, SitePictures, Task};
use relievo_engine::project::resolve_path;
use relievo_engine::vector::VectorError;
use relievo_engine::vector::write::{Feature, write_geojson};

#[cfg(feature = "window")]
pub(crate) use html::grouped;
#[cfg(feature = "window")]
pub(crate) use table::QUANTITIES;

/// Pictures across in a report, pixels.
const PICTURE_WIDTH: u32 = 720;

/// Places of which a report has pictures.
const MOST_SITES: usize = 8;

/// How a comparison is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// A page with pictures.
    Html,
    /// Numbers with their names.
    Json,
    /// A table.
    Csv,
}

impl Format {
    /// All of them with the ends of their names.
    pub(crate) const ALL: [(Self, &'static str); 3] = [
        (Self::Html, "html"),
        (Self::Csv, "csv"),
        (Self::Json, "json"),
    ];
}

/// The text of a report on a comparison that has been measured; pictures of the page are made here.
///
/// # Errors
/// [`AnalysisError`].
pub(crate) fn text(
    format: Format,
    title: &str,
    comparison: &Comparison,
    report: &ComparisonReport,
    task: &Task,
) -> Result<String, AnalysisError> {
    Ok(match format {
        Format::Csv => table::csv(report),
        Format::Json => format!("{:#}\n", table::json(report)),
        Format::Html => {
            let count = comparison.sites().min(MOST_SITES);
            let mut sites: Vec<SitePictures> = Vec::new();
            for site in 0..count {
                sites.extend(comparison.pictures(site, PICTURE_WIDTH, task)?);
                (task.progress)((site + 1) as f64 / count as f64);
            }
            let page = html::page(title, report, &sites);
            page.map_err(|error| AnalysisError::Ground(Box::new(error)))?
        }
    })
}

/// Writes contours as GeoJSON, or as a GeoPackage where the file's name ends so.
///
/// # Errors
/// One line.
#[cfg(feature = "window")]
pub(crate) fn write_contours(
    file: &Path,
    lines: &[relievo_engine::analysis::ContourLine],
) -> Result<(), String> {
    let features = relievo_engine::export::contour_features(lines);
    let written = write_features(file, "contours", &features);
    written.map_err(|error| error.to_string())
}

/// Writes features as GeoJSON, or as a table of a GeoPackage where the file's name ends so.
///
/// # Errors
/// [`VectorError`] when the system refuses.
pub(crate) fn write_features(
    file: &Path,
    table: &str,
    features: &[Feature],
) -> Result<(), VectorError> {
    #[cfg(feature = "readers")]
    if file
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("gpkg"))
    {
        return relievo_engine::vector::write::write_geopackage(file, table, features);
    }
    #[cfg(not(feature = "readers"))]
    let _geojson_has_no_tables = table;
    write_geojson(file, features)
}

/// Refuses, in one line, to write where something is read: `inputs` and the project's sources.
///
/// # Errors
/// What was expected and found.
pub(crate) fn check_output(output: &Path, inputs: &[&Path], engine: &Engine) -> Result<(), String> {
    // What does not exist yet is nobody's input; whether it can be written shows when it is.
    let Ok(place) = output.canonicalize() else {
        return Ok(());
    };
    if place.is_dir() {
        return Err(format!(
            "expected a file to write, found a folder: {output:?}"
        ));
    }
    let folder = engine.folder();
    let layers = engine.project().layers.iter();
    let sources = layers.filter_map(|l| l.path().map(|path| resolve_path(folder, path)));
    let read = inputs.iter().map(|i| i.to_path_buf()).chain(sources);
    for input in read {
        if input.canonicalize().is_ok_and(|input| input == place) {
            return Err(format!(
                "expected an output beside what is read, found one of the inputs: {output:?}"
            ));
        }
    }
    Ok(())
}

/// Writes a file, beside its place first.
///
/// # Errors
/// One line that names it.
pub(crate) fn write(file: &Path, bytes: &[u8]) -> Result<(), String> {
    let mut part = file.to_owned().into_os_string();
    part.push(".part");
    let written = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, file));
    written.map_err(|error| {
        // What is there in part is of no use to anybody.
        let _gone = std::fs::remove_file(&part);
        format!("cannot write {file:?}: {error}")
    })
}
