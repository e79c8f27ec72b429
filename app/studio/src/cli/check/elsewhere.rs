//! Where files are that a project misses: found by name, and opened to see whether they would do.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use relievo_engine::Engine;
use relievo_engine::project::{Layer, LayerId, LayerKind, resolve_path, store_path};
use relievo_engine::raster::Bands;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::relink;
use serde_json::{Value, json};

use crate::cli::{Context, Failure};

/// Files of one name that are opened to see whether they would do.
const TRIED: usize = 16;

/// What was found for layers whose files are missing.
pub(super) struct Elsewhere {
    found: relink::Found,
    missing: BTreeSet<LayerId>,
    folders: Vec<PathBuf>,
}

impl Elsewhere {
    /// Looks into the project's folder and the given ones for files that the project misses.
    pub(super) fn search(
        engine: &Engine,
        folders: &[PathBuf],
        context: &Context,
    ) -> Result<Self, Failure> {
        if let Some(wrong) = folders.iter().find(|f| !f.is_dir()) {
            return Err(Failure::Input(format!(
                "--search: expected a folder, found {wrong:?}"
            )));
        }
        let mut all = vec![engine.folder().to_owned()];
        for folder in folders {
            let folder = std::path::absolute(folder).map_err(Failure::input)?;
            if !all.contains(&folder) {
                all.push(folder);
            }
        }
        let missing = relink::missing(engine.project(), engine.folder());
        let names: BTreeSet<OsString> = missing
            .iter()
            .filter_map(|link| link.file.file_name().map(OsString::from))
            .collect();
        let found = if names.is_empty() {
            relink::Found::default()
        } else {
            relink::search(&names, &all, context.cancel)
        };
        if context.cancel.is_cancelled() {
            return Err(Failure::Cancelled);
        }
        Ok(Self {
            found,
            missing: missing.into_iter().map(|link| link.layer).collect(),
            folders: all,
        })
    }

    /// How to mend a layer whose file is missing, and the edits that would; `None` where the file is
    /// there.
    pub(super) fn offer(&self, engine: &Engine, layer: &Layer) -> Option<(String, Vec<Value>)> {
        if !self.missing.contains(&layer.id) {
            return None;
        }
        let old = resolve_path(engine.folder(), layer.path()?);
        let name = old.file_name()?;
        let mut fitting = BTreeMap::new();
        let mut unfit = Vec::new();
        for (order, file) in self.found.of(name).iter().take(TRIED).enumerate() {
            match (fits(file, layer), store_path(engine.folder(), file)) {
                (Ok(()), Some(path)) => {
                    fitting.insert(order, path);
                }
                (Err(reason), _) => unfit.push(reason),
                (Ok(()), None) => unfit.push(format!("its path is not Unicode: {file:?}")),
            }
        }
        let paths: Vec<String> = fitting.into_values().collect();
        let Some(first) = paths.first() else {
            let looked = self
                .folders
                .iter()
                .map(|f| f.display().to_string())
                .collect::<Vec<_>>()
                .join(", ");
            let besides = unfit
                .first()
                .map(|reason| format!(" but one that will not do ({reason})"))
                .unwrap_or_default();
            let short = if self.found.cut_short {
                " (not all of it: too many files)"
            } else {
                ""
            };
            return Some((
                format!(
                    "restore the file, link the layer to another with the edit set_path, or remove it; nothing of its \
                     name was found in {looked}{short}{besides}; --search FOLDER looks elsewhere"
                ),
                Vec::new(),
            ));
        };
        let edits: Vec<Value> = paths
            .iter()
            .map(|path| json!({"edit": "set_path", "id": layer.id.0, "path": path}))
            .collect();
        let size = std::fs::metadata(resolve_path(engine.folder(), first)).map_or(0, |m| m.len());
        let others = match paths.len() {
            1 => String::new(),
            n => format!(" (and {} more of that name)", n - 1),
        };
        let mend = format!(
            "link the layer to {first:?}, where a file of its name that fits was found, {size} bytes{others}: \
             `relievo apply` takes [{}]",
            edits[0]
        );
        Some((mend, edits))
    }
}

/// Whether a file could stand behind a layer, as far as its header says.
fn fits(file: &Path, layer: &Layer) -> Result<(), String> {
    if matches!(layer.kind, LayerKind::Vector(_)) {
        return Ok(());
    }
    let bands = match &layer.kind {
        LayerKind::Height(_) => Bands::Height,
        LayerKind::Imagery(_)
        | LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Tint(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Vector(_)
        | LayerKind::Unknown { .. } => Bands::Colour,
    };
    let options = OpenOptions {
        make_pyramid: false,
        as_bands: Some(bands),
        ..OpenOptions::default()
    };
    open(file, &options).map(drop).map_err(|e| e.to_string())
}
