//! New projects and layers from files.

use std::collections::HashSet;
use std::path::Path;

use crate::{
    ElementId, HeightLayer, ImageryLayer, Layer, LayerId, LayerKind, Project, ScenarioId, Source,
    VectorLayer, VectorStyle, store_path,
};

/// What a file becomes in a new project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceRole {
    /// An imagery layer.
    Imagery,
    /// A height layer.
    Height,
    /// A vector layer.
    Vector,
}

/// Why a project cannot be made from files.
#[derive(Debug, thiserror::Error)]
pub enum NewProjectError {
    /// A path that JSON cannot hold.
    #[error("expected a path in Unicode, found {path:?}")]
    NotUnicode {
        /// The path.
        path: std::path::PathBuf,
    },
}

impl Project {
    /// A project on Earth for `folder` with one layer a file, the first at the bottom. Nothing is
    /// read: what a file holds is the caller's knowledge. `folder` and files absolute.
    ///
    /// # Errors
    /// Where a path is not Unicode.
    pub fn new_from_sources<'a>(
        folder: &Path,
        sources: impl IntoIterator<Item = (&'a Path, SourceRole)>,
    ) -> Result<Self, NewProjectError> {
        let mut project = Self::default();
        for (file, role) in sources {
            let id = project.fresh_layer_id(&stem_of(file), |_| false);
            project
                .layers
                .push(layer_from_source(id, folder, file, role)?);
        }
        Ok(project)
    }

    /// An id made from `stem` that no layer has and that `is_taken` does not claim.
    pub fn fresh_layer_id(&self, stem: &str, is_taken: impl Fn(&LayerId) -> bool) -> LayerId {
        let base = slug(stem);
        let is_free = |id: &str| {
            let id = LayerId(id.to_owned());
            self.layer(&id).is_none() && !is_taken(&id)
        };
        LayerId(numbered(&base, is_free))
    }
}

impl Project {
    /// An id made from `stem` that no element has, in the base or in any scenario, and that `is_taken`
    /// does not claim.
    pub fn fresh_element_id(&self, stem: &str, is_taken: impl Fn(&ElementId) -> bool) -> ElementId {
        let changes = self.scenarios.iter().flat_map(|s| &s.changes);
        let used: HashSet<&ElementId> = self
            .elements
            .iter()
            .map(|element| &element.id)
            .chain(changes.filter_map(|change| change.element_id()))
            .collect();
        let base = slug(stem);
        numbered(&base, |id| {
            let id = ElementId(id.to_owned());
            !used.contains(&id) && !is_taken(&id)
        })
        .as_str()
        .into()
    }

    /// An id made from `stem` that no scenario has.
    pub fn fresh_scenario_id(&self, stem: &str) -> ScenarioId {
        let base = slug(stem);
        numbered(&base, |id| self.scenarios.iter().all(|s| s.id.0 != id))
            .as_str()
            .into()
    }
}

/// The first of `base`, `base-2`, `base-3` that is free.
fn numbered(base: &str, is_free: impl Fn(&str) -> bool) -> String {
    let mut id = base.to_owned();
    let mut number = 1_u64;
    while !is_free(&id) {
        number += 1;
        id = format!("{base}-{number}");
    }
    id
}

/// A layer for a file, named after it. `folder` and `file` absolute.
///
/// # Errors
/// Where the path is not Unicode.
pub fn layer_from_source(
    id: LayerId,
    folder: &Path,
    file: &Path,
    role: SourceRole,
) -> Result<Layer, NewProjectError> {
    let path = store_path(folder, file).ok_or_else(|| NewProjectError::NotUnicode {
        path: file.to_owned(),
    })?;
    let source = Source::new(path);
    let kind = match role {
        SourceRole::Imagery => LayerKind::Imagery(ImageryLayer::new(source)),
        SourceRole::Height => LayerKind::Height(HeightLayer::new(source)),
        SourceRole::Vector => {
            let mut layer = VectorLayer::new(source.path);
            layer.style = VectorStyle::visible();
            LayerKind::Vector(Box::new(layer))
        }
    };
    Ok(Layer::new(id, name_from_stem(&stem_of(file)), kind))
}

fn stem_of(file: &Path) -> String {
    file.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Lower-case letters and digits with single hyphens, short enough for a number behind it.
fn slug(stem: &str) -> String {
    const LONGEST: usize = LayerId::MAX_BYTES - 24;
    let mut slug = String::new();
    for c in stem.chars().take(LONGEST) {
        if c.is_ascii_alphanumeric() {
            slug.push(c.to_ascii_lowercase());
        } else if !slug.is_empty() && !slug.ends_with('-') {
            slug.push('-');
        }
    }
    let slug = slug.trim_end_matches('-');
    if slug.is_empty() {
        "layer".to_owned()
    } else {
        slug.to_owned()
    }
}

/// A file's stem as people would write it: no underscores, no control characters.
fn name_from_stem(stem: &str) -> String {
    let readable = stem
        .chars()
        .map(|c| if c == '_' || c.is_control() { ' ' } else { c });
    let name: String = readable.take(200).collect();
    name.trim().to_owned()
}
