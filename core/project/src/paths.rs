//! Paths as a project stores them: text with forward slashes, relative to the project's folder where
//! possible, so that a folder can be moved as a whole and opened on another system.

use std::path::{Component, Path, PathBuf};

use crate::{Edit, LayerKind, Project};

/// The file that a stored path means for a project in `folder`.
pub fn resolve_path(folder: &Path, stored: &str) -> PathBuf {
    // Joining an absolute path gives that path.
    normalise(&folder.join(stored))
}

/// How a project in `folder` stores the path of `file`: relative where both are absolute and share a
/// root, else as it is. `None` where the path is not Unicode, which no JSON text can hold.
///
/// Purely by name: links are not followed, nothing need exist.
pub fn store_path(folder: &Path, file: &Path) -> Option<String> {
    let file = normalise(file);
    if !file.is_absolute() {
        return with_slashes(&file);
    }
    let folder = normalise(folder);
    let from: Vec<_> = folder.components().collect();
    let to: Vec<_> = file.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    // Another root, or nothing in common but the root of the whole file system: the absolute path
    // says more and survives moving the project.
    let only_root = from[..shared]
        .iter()
        .all(|part| matches!(part, Component::RootDir | Component::Prefix(_)));
    if !folder.is_absolute() || (only_root && from.len() > shared) {
        return with_slashes(&file);
    }
    let mut relative = PathBuf::new();
    for _ in shared..from.len() {
        relative.push("..");
    }
    relative.extend(&to[shared..]);
    with_slashes(&relative)
}

fn with_slashes(path: &Path) -> Option<String> {
    let text = path.to_str()?;
    Some(if cfg!(windows) {
        text.replace('\\', "/")
    } else {
        text.to_owned()
    })
}

/// Without `.` and with `..` taken back where that is possible by name.
fn normalise(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => match result.components().next_back() {
                Some(Component::Normal(_)) => {
                    result.pop();
                }
                Some(Component::RootDir) => {}
                Some(Component::Prefix(_) | Component::CurDir | Component::ParentDir) | None => {
                    result.push("..");
                }
            },
            Component::Prefix(_) | Component::RootDir | Component::Normal(_) => result.push(part),
        }
    }
    result
}

/// A stored path of a project in folder `from` as a project in folder `to` stores it; unchanged
/// where that cannot be said.
fn rebase(stored: &str, from: &Path, to: &Path) -> String {
    store_path(to, &resolve_path(from, stored)).unwrap_or_else(|| stored.to_owned())
}

impl Project {
    /// The project as it must be stored in folder `to` so that it means the same files as in folder
    /// `from`; both absolute. Saving under another name in the same folder needs no change.
    #[must_use]
    pub fn rebased(&self, from: &Path, to: &Path) -> Self {
        let mut project = self.clone();
        if normalise(from) != normalise(to) {
            for layer in &mut project.layers {
                rebase_kind(&mut layer.kind, from, to);
            }
        }
        project
    }
}

fn rebase_kind(kind: &mut LayerKind, from: &Path, to: &Path) {
    match kind {
        LayerKind::Imagery(imagery) => imagery.source.path = rebase(&imagery.source.path, from, to),
        LayerKind::Height(height) => height.source.path = rebase(&height.source.path, from, to),
        LayerKind::Vector(vector) => vector.path = rebase(&vector.path, from, to),
        LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Tint(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Unknown { .. } => {}
    }
}

/// Rewrites the paths inside an edit as [`Project::rebased`] does those of a project.
#[expect(clippy::wildcard_enum_match_arm, reason = "no other edit holds a path")]
pub(crate) fn rebase_edit(edit: &mut Edit, from: &Path, to: &Path) {
    match edit {
        Edit::AddLayer { layer, .. } => rebase_kind(&mut layer.kind, from, to),
        Edit::SetPath { path, .. } => *path = rebase(path, from, to),
        Edit::Batch { edits, .. } => edits
            .iter_mut()
            .for_each(|edit| rebase_edit(edit, from, to)),
        _others => {}
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_file_beside_or_above_the_project_is_stored_relative_to_it() {
        let folder = Path::new("/home/a/projects");
        for (file, stored) in [
            ("/home/a/projects/data/x.tif", "data/x.tif"),
            ("/home/a/x.tif", "../x.tif"),
            ("/home/a/./b/../x.tif", "../x.tif"),
            ("/mnt/x.tif", "/mnt/x.tif"),
        ] {
            assert_eq!(store_path(folder, Path::new(file)).as_deref(), Some(stored));
            assert_eq!(resolve_path(folder, stored), normalise(Path::new(file)));
        }
    }

    #[test]
    fn a_project_at_the_root_stores_relative_paths() {
        assert_eq!(
            store_path(Path::new("/"), Path::new("/data/x.tif")).as_deref(),
            Some("data/x.tif")
        );
    }

    #[test]
    fn a_rebased_path_means_the_same_file() {
        let (from, to) = (Path::new("/a/b"), Path::new("/a/c/d"));
        for stored in ["x.tif", "../x.tif", "../c/d/x.tif", "/mnt/x.tif"] {
            assert_eq!(
                resolve_path(to, &rebase(stored, from, to)),
                resolve_path(from, stored)
            );
        }
    }
}
