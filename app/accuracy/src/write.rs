//! Reports as files: a page with everything, and each figure by itself.

mod csv;
mod html;
mod scale;
mod svg;

use std::path::{Path, PathBuf};

use crate::{Content, Figure, Machine, Report, Suite, Table, number};

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

/// Writes reports into a folder, which is made where it is missing: `index.html`, all pareto fronts as
/// `fronts.csv`, and each figure as `SUITE-FIGURE` with `.csv` (charts and tables), `.svg` (charts) or `.png` (pictures). Files of the
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
    let fronts = fronts(reports);
    let page = html::page(reports, &fronts, machine)?;
    let rows = csv::figure(&fronts, machine);
    let mut files = vec![
        (PAGE.to_owned(), page.into_bytes()),
        ("fronts.csv".to_owned(), rows.into_bytes()),
    ];
    for (suite, report) in reports {
        for figure in &report.figures {
            let mut add = |extension, bytes| {
                files.push((file_name(suite, &figure.name, extension), bytes));
            };
            match &figure.content {
                Content::Chart(chart) => {
                    add("csv", csv::figure(figure, machine).into_bytes());
                    add("svg", svg::file(figure, chart, machine)?.into_bytes());
                }
                Content::Table(_) => add("csv", csv::figure(figure, machine).into_bytes()),
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

/// The pareto fronts of all charts as one table.
fn fronts(reports: &[(&Suite, Report)]) -> Figure {
    let head = ["suite", "figure", "method", "setting", "cost", "error"];
    let mut table = Table {
        head: head.map(str::to_owned).to_vec(),
        rows: Vec::new(),
    };
    let with_unit = |value: f64, unit: &str| format!("{} {unit}", number::text(value));
    for (suite, report) in reports {
        for figure in &report.figures {
            let Content::Chart(chart) = &figure.content else {
                continue;
            };
            for (curve, point) in chart.marked().into_iter().map(|(c, p)| {
                let curve = &chart.curves[c];
                (curve, &curve.points[p])
            }) {
                table.rows.push(vec![
                    suite.name.into(),
                    figure.title.as_str().into(),
                    curve.name.as_str().into(),
                    point.setting.as_str().into(),
                    with_unit(point.x, &chart.x.unit).into(),
                    with_unit(point.y, &chart.y.unit).into(),
                ]);
            }
        }
    }
    let caption = "Of everything measured, what nothing else beats in both cost and error: the settings worth choosing from.";
    Figure::new(
        "fronts",
        "What nothing beats",
        caption,
        Content::Table(table),
    )
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
