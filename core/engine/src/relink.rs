//! Files that are not where a project says: looking for them, and the edit that links them anew.
//!
//! Only names are compared: of a file that is gone nothing else is known. Whoever takes an offer
//! opens the file and sees.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fs::DirEntry;
use std::path::{Path, PathBuf};

use relievo_project::{Edit, LayerId, Project, resolve_path, store_path};
use relievo_raster::Cancel;

/// Folders within folders that are looked into.
const DEEPEST: usize = 8;

/// Entries of folders that are looked at in one search.
const MOST_ENTRIES: usize = 200_000;

/// A layer and the file that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// The layer.
    pub layer: LayerId,
    /// Its file, absolute if the project's folder is.
    pub file: PathBuf,
}

/// The layers of a project in `folder` whose files are not there. Asks the system about each.
pub fn missing(project: &Project, folder: &Path) -> Vec<Link> {
    let links = project.layers.iter().filter_map(|layer| {
        Some(Link {
            layer: layer.id.clone(),
            file: resolve_path(folder, layer.path()?),
        })
    });
    links.filter(|link| !link.file.is_file()).collect()
}

/// Those of `links` whose files' names exist in a folder, with the files there.
pub fn found_in(folder: &Path, links: &[Link]) -> Vec<Link> {
    let there = |link: &Link| {
        let file = folder.join(link.file.file_name()?);
        (file != link.file && file.is_file()).then(|| Link {
            layer: link.layer.clone(),
            file,
        })
    };
    links.iter().filter_map(there).collect()
}

/// What a search found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Files by name, in the order in which folders were given, upper folders first.
    pub files: BTreeMap<OsString, Vec<PathBuf>>,
    /// Whether some folders were left out: there were too many entries, or somebody asked to stop.
    pub cut_short: bool,
}

/// Looks for files by name in folders and what lies below them, 8 deep and 200,000 entries at most;
/// links to folders are not followed, folders that cannot be read are left out.
pub fn search(names: &BTreeSet<OsString>, folders: &[PathBuf], cancel: &Cancel) -> Found {
    let mut found = Found::default();
    let mut entries = 0;
    for folder in folders {
        let mut level = vec![folder.clone()];
        for _ in 0..=DEEPEST {
            let mut below = Vec::new();
            for folder in level {
                let Ok(content) = std::fs::read_dir(&folder) else {
                    continue;
                };
                let mut content: Vec<DirEntry> = content.filter_map(Result::ok).collect();
                content.sort_by_key(DirEntry::file_name);
                for entry in content {
                    entries += 1;
                    if entries > MOST_ENTRIES || cancel.is_cancelled() {
                        found.cut_short = true;
                        return found;
                    }
                    let is_folder = entry.file_type().is_ok_and(|t| t.is_dir());
                    if is_folder {
                        below.push(entry.path());
                    } else if names.contains(&entry.file_name()) {
                        found.add(entry.file_name(), entry.path());
                    }
                }
            }
            level = below;
        }
    }
    found
}

impl Found {
    fn add(&mut self, name: OsString, file: PathBuf) {
        let files = self.files.entry(name).or_default();
        // Folders that are given may lie in each other.
        if file.is_file() && !files.contains(&file) {
            files.push(file);
        }
    }

    /// The files of a name.
    pub fn of(&self, name: &OsStr) -> &[PathBuf] {
        self.files.get(name).map_or(&[], Vec::as_slice)
    }
}

/// The one edit that gives layers of a project in `folder` their files; `None` without links.
///
/// # Errors
/// The first file whose path is not Unicode, which no project can hold.
pub fn relink(folder: &Path, links: &[Link]) -> Result<Option<Edit>, PathBuf> {
    let mut edits = Vec::with_capacity(links.len());
    for link in links {
        edits.push(Edit::SetPath {
            id: link.layer.clone(),
            path: store_path(folder, &link.file).ok_or_else(|| link.file.clone())?,
        });
    }
    Ok(match edits.len() {
        0 | 1 => edits.pop(),
        count => Some(Edit::Batch {
            label: format!("Relink {count} files"),
            edits,
        }),
    })
}

#[cfg(test)]
mod tests {
    use relievo_project::{SourceRole, layer_from_source};

    use super::*;

    fn project(folder: &Path, files: &[&str]) -> Project {
        let mut project = Project::default();
        for name in files {
            let id = LayerId::from(*name);
            let layer = layer_from_source(id, folder, &folder.join(name), SourceRole::Height);
            project.layers.push(layer.unwrap());
        }
        project
    }

    fn touch(path: &Path) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "x").unwrap();
    }

    #[test]
    fn missing_files_that_lie_together_elsewhere_are_linked_by_one_edit() {
        let folder = tempfile::tempdir().unwrap();
        let mut project = project(folder.path(), &["a.tif", "b.tif", "c.tif", "here.tif"]);
        touch(&folder.path().join("here.tif"));
        for name in ["a.tif", "b.tif"] {
            touch(&folder.path().join("moved").join(name));
        }
        let before = project.clone();
        let links = missing(&project, folder.path());
        assert_eq!(links.len(), 3);
        let found = found_in(&folder.path().join("moved"), &links);
        assert_eq!(found.len(), 2);
        let edit = relink(folder.path(), &found).unwrap().unwrap();
        let inverse = project.apply(edit).unwrap();
        let paths: Vec<_> = project
            .layers
            .iter()
            .map(|l| l.source().unwrap().path.as_str())
            .collect();
        assert_eq!(paths, ["moved/a.tif", "moved/b.tif", "c.tif", "here.tif"]);
        assert_eq!(missing(&project, folder.path()).len(), 1);
        project.apply(inverse).unwrap();
        assert_eq!(project, before);
    }

    #[test]
    fn a_search_finds_names_at_any_depth_upper_folders_first_and_each_file_once() {
        let folder = tempfile::tempdir().unwrap();
        for place in ["x/y/a.tif", "z/a.tif", "a.tif", "x/b.tif", "x/other.tif"] {
            touch(&folder.path().join(place));
        }
        // A folder of that name is no file.
        std::fs::create_dir(folder.path().join("b.tif")).unwrap();
        let names = ["a.tif", "b.tif"].map(OsString::from).into();
        let folders = [folder.path().to_owned(), folder.path().join("x")];
        let found = search(&names, &folders, &Cancel::default());
        let places = |name: &str| -> Vec<_> {
            let files = found.of(OsStr::new(name)).iter();
            let relative = files.map(|f| f.strip_prefix(folder.path()).unwrap().to_owned());
            relative.collect()
        };
        assert_eq!(
            places("a.tif"),
            ["a.tif", "z/a.tif", "x/y/a.tif"].map(PathBuf::from)
        );
        assert_eq!(places("b.tif"), ["x/b.tif"].map(PathBuf::from));
        assert!(!found.cut_short);
        let stopped = Cancel::default();
        stopped.cancel();
        assert!(search(&names, &folders, &stopped).cut_short);
    }

    #[test]
    fn nothing_to_link_is_no_edit() {
        assert_eq!(relink(Path::new("/"), &[]), Ok(None));
    }
}
