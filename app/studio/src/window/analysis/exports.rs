//! What was measured, written to files on a thread of its own.

use std::io;
use std::path::{Path, PathBuf};

use eframe::egui::Ui;
use relievo_engine::analysis::Task;

use crate::report::{self, Format};
use crate::window::inbox::Waker;
use crate::window::latest::Latest;
use crate::window::messages::Weight;
use crate::window::panes::Pane;
use crate::window::studio::Studio;
use crate::window::waiting;

/// What can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Export {
    /// The comparison of volumes.
    Volumes(Format),
    /// Contours as GeoJSON.
    ContoursGeoJson,
    /// Contours as a GeoPackage.
    ContoursGeoPackage,
}

impl Export {
    /// The end of the file's name.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Volumes(Format::Html) => "html",
            Self::Volumes(Format::Csv) => "csv",
            Self::Volumes(Format::Json) => "json",
            Self::ContoursGeoJson => "geojson",
            Self::ContoursGeoPackage => "gpkg",
        }
    }

    /// What the question for a place is called.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Volumes(_) => "Save report as",
            Self::ContoursGeoJson | Self::ContoursGeoPackage => "Save contours as",
        }
    }
}

/// Files that are being written.
pub(super) struct Exports {
    latest: Latest<u64, Result<PathBuf, String>>,
    asked: u64,
    told: u64,
}

impl Exports {
    pub(super) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            latest: Latest::new("relievo-export", waker)?,
            asked: 0,
            told: 0,
        })
    }

    /// How far it is.
    pub(super) fn status(&mut self, ui: &mut Ui) {
        waiting::show(ui, &mut self.latest, "Writing the file");
    }
}

impl Studio {
    /// Writes what was measured to a file.
    pub(in crate::window) fn export(&mut self, export: Export, file: PathBuf) {
        let own = self.document.path().map(Path::to_owned);
        let inputs: Vec<&Path> = own.iter().map(PathBuf::as_path).collect();
        if let Err(line) = report::check_output(&file, &inputs, self.document.engine()) {
            self.log.add(Weight::Error, line);
            self.layout.open(Pane::Messages);
            return;
        }
        let title = self.document.name();
        let (volumes, lines) = (self.measured_volumes(), self.contour_lines());
        let exports = &mut self.analyses.exports;
        exports.asked += 1;
        exports.latest.ask(exports.asked, || {
            move |task: &Task| {
                match (export, volumes, lines) {
                    (Export::Volumes(format), Some(found), _) => {
                        let (comparison, report) = (&found.comparison, &found.report);
                        let text = report::text(format, &title, comparison, report, task);
                        report::write(&file, text.map_err(|e| e.to_string())?.as_bytes())?;
                    }
                    (Export::ContoursGeoJson | Export::ContoursGeoPackage, _, Some(lines)) => {
                        report::write_contours(&file, &lines)?;
                    }
                    _ => return Err(format!("nothing was measured that {file:?} could hold")),
                }
                Ok(file)
            }
        });
    }

    /// Tells once what became of a file.
    pub(super) fn take_exported(&mut self) {
        let exports = &mut self.analyses.exports;
        if exports.told == exports.asked {
            return;
        }
        let Some(answer) = exports.latest.answer(&exports.asked) else {
            return;
        };
        exports.told = exports.asked;
        match answer {
            Ok(file) => {
                let text = format!("saved {}", file.display());
                self.log.add(Weight::News, text);
            }
            Err(line) => {
                self.log.add(Weight::Error, line);
                self.layout.open(Pane::Messages);
            }
        }
    }
}
