//! Reports as files: a page with everything, and each figure by itself.

mod csv;
mod html;
mod scale;
mod svg;

use std::path::{Path, PathBuf};

use crate::{Content, Machine, Report, Suite};

/// Name of the page in its folder.
pub const PAGE: &str = "index.html";

/// Why a report was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A folder or file.
    #[error("cannot write {path:?}: {reason}")]
    Io {
        /// Which.
        path: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
    /// A chart that cannot be drawn.
    #[error("cannot draw {figure}: {reason}")]
    Chart {
        /// Which.
        figure: String,
        /// Why.
        reason: String,
    },
}

/// Writes reports into a folder, which is made where it is missing: `index.html`, and each figure as
/// `SUITE-FIGURE` with `.csv` (charts and tables), `.svg` (charts) or `.png` (pictures). Files of the
/// same names are replaced. Returns the paths, the page first.
///
/// # Errors
/// [`WriteError`].
pub fn to_folder(
    folder: &Path,
    reports: &[(&Suite, Report)],
    machine: &Machine,
) -> Result<Vec<PathBuf>, WriteError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |reason| WriteError::Io { path, reason }
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    let page = html::page(reports, machine)?;
    let mut files = vec![(PAGE.to_owned(), page.into_bytes())];
    for (suite, report) in reports {
        for figure in &report.figures {
            let mut add = |extension, bytes| {
                files.push((file_name(suite, &figure.name, extension), bytes));
            };
            match &figure.content {
                Content::Chart(chart) => {
                    add("csv", csv::chart(figure, chart, machine).into_bytes());
                    add("svg", svg::file(figure, chart, machine)?.into_bytes());
                }
                Content::Table(table) => {
                    add("csv", csv::table(figure, table, machine).into_bytes());
                }
                Content::Picture(picture) => add("png", picture.png.clone()),
            }
        }
    }
    let mut paths = Vec::new();
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(io(&path))?;
        paths.push(path);
    }
    Ok(paths)
}

/// Name of a figure's file.
fn file_name(suite: &Suite, figure: &str, extension: &str) -> String {
    format!("{}-{figure}.{extension}", suite.name)
}

/// Text between tags or in an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
