//! Geometry that is too long for the project's text: lists of vertices in files beside it, named by
//! their content.
//!
//! A file of that name never changes, so a save writes what is new before the project names it, and
//! takes away what nothing names any more only after the project has been replaced: the old project
//! stays whole until the new one is there.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::stored::fault::At;
use crate::stored::range::MOST_VERTICES;
use crate::stored::vertices::check;
use crate::{ChangeKind, ContentHash, Element, ElementId, Project, ScenarioId, SideFile, Vertices};

/// Longer lists lie in files of their own.
const LONGEST_IN_TEXT: usize = 10_000;
/// Vertices of all lists together that stay in the text; what is too much goes, the longest first.
const MOST_IN_TEXT: usize = 400_000;
const EXTENSION: &str = "vertices";

/// The folder of a project's side files.
pub fn side_folder(project: &Path) -> PathBuf {
    let mut name = project.as_os_str().to_owned();
    name.push(".d");
    PathBuf::from(name)
}

fn file_in(folder: &Path, hash: ContentHash) -> PathBuf {
    folder.join(format!("{hash}.{EXTENSION}"))
}

/// A list of vertices that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingGeometry {
    /// The element that has it.
    pub element: ElementId,
    /// What people call the element.
    pub name: String,
    /// The scenario that changes the element; `None`: it is the base's.
    pub scenario: Option<ScenarioId>,
    /// The file that should hold it.
    pub file: PathBuf,
    /// What is wrong with the file, in a line.
    pub reason: String,
}

impl Project {
    /// The lists of vertices whose side files are missing or damaged, for a project at `path`. Their
    /// elements count as empty there; saving keeps the references.
    pub fn missing_geometry(&self, path: &Path) -> Vec<MissingGeometry> {
        let folder = side_folder(path);
        let mut missing = Vec::new();
        let mut look = |scenario: Option<&ScenarioId>, element: &Element| {
            for list in element.vertex_lists() {
                let Some(side_file) = list.missing() else {
                    continue;
                };
                let Err(reason) = read(&folder, side_file) else {
                    continue;
                };
                missing.push(MissingGeometry {
                    element: element.id.clone(),
                    name: element.name.clone(),
                    scenario: scenario.cloned(),
                    file: file_in(&folder, side_file.hash),
                    reason,
                });
            }
        };
        for element in &self.elements {
            look(None, element);
        }
        for scenario in &self.scenarios {
            for element in scenario.changes.iter().filter_map(|c| c.element()) {
                look(Some(&scenario.id), element);
            }
        }
        missing
    }

    /// All elements of the base and of the scenarios' changes.
    fn all_elements(&self) -> impl Iterator<Item = &Arc<Element>> {
        let changed = self.scenarios.iter().flat_map(|s| &s.changes);
        self.elements
            .iter()
            .chain(changed.filter_map(|change| change.element()))
    }

    /// Gives every element to a closure that may change it.
    fn for_each_element(&mut self, mut change: impl FnMut(&mut Arc<Element>)) {
        self.elements.iter_mut().for_each(&mut change);
        for scenario in &mut self.scenarios {
            for entry in &mut scenario.changes {
                if let ChangeKind::Add { element, .. } | ChangeKind::Replace { element, .. } =
                    &mut entry.kind
                {
                    change(element);
                }
            }
        }
    }

    /// Reads lists that lie in files of `folder`; those that cannot be read stay references.
    pub(crate) fn load_side_files(&mut self, folder: &Path) {
        let is_elsewhere =
            |element: &Element| element.vertex_lists().iter().any(|l| l.missing().is_some());
        // Lists that several elements share are read once.
        let mut known: BTreeMap<ContentHash, Vertices> = BTreeMap::new();
        self.for_each_element(|element| {
            if !is_elsewhere(element) {
                return;
            }
            for list in Arc::make_mut(element).vertex_lists_mut() {
                let Some(side_file) = list.missing() else {
                    continue;
                };
                if let Some(same) = known.get(&side_file.hash) {
                    *list = same.clone();
                } else if let Ok(read) = read(folder, side_file) {
                    known.insert(side_file.hash, read.clone());
                    *list = read;
                }
            }
        });
    }

    /// The project as its text holds it, long lists replaced by references, and those lists.
    pub(crate) fn apart(&self) -> (Cow<'_, Self>, BTreeMap<ContentHash, Vertices>) {
        let mut lengths: Vec<usize> = self
            .all_elements()
            .flat_map(|element| element.vertex_lists())
            .map(|list| list.len())
            .collect();
        lengths.sort_unstable();
        // The longest length of which all lists up to it fit.
        let mut sum = 0;
        let mut longest = 0;
        for length in lengths.iter().copied() {
            sum += length;
            if length > LONGEST_IN_TEXT || sum > MOST_IN_TEXT {
                break;
            }
            longest = length;
        }
        if lengths.last().is_none_or(|last| *last <= longest) {
            return (Cow::Borrowed(self), BTreeMap::new());
        }
        let mut lists = BTreeMap::new();
        let mut text = self.clone();
        text.for_each_element(|element| {
            if !element.vertex_lists().iter().any(|l| l.len() > longest) {
                return;
            }
            for list in Arc::make_mut(element).vertex_lists_mut() {
                if list.len() > longest {
                    let side_file = list.to_side_file();
                    lists.insert(side_file.hash, list.clone());
                    *list = Vertices::elsewhere(side_file);
                }
            }
        });
        (Cow::Owned(text), lists)
    }
}

/// A list from its file; what is wrong in words.
fn read(folder: &Path, side_file: &SideFile) -> Result<Vertices, String> {
    let path = file_in(folder, side_file.hash);
    let is_file = fs::metadata(&path).map(|data| data.is_file());
    match is_file {
        Ok(true) => {}
        Ok(false) => return Err("expected a file, found something else".to_owned()),
        Err(error) => return Err(format!("cannot read it: {error}")),
    }
    let most = MOST_VERTICES as u64 * 24 + 16;
    let mut bytes = Vec::new();
    let file = File::open(&path).map_err(|error| format!("cannot read it: {error}"))?;
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| format!("cannot read it: {error}"))?;
    let list = Vertices::from_side_bytes(&bytes, side_file)?;
    check(&list, &At::Root).map_err(|fault| fault.to_string())?;
    Ok(list)
}

/// Writes the lists that are not there yet.
pub(crate) fn write(folder: &Path, lists: &BTreeMap<ContentHash, Vertices>) -> io::Result<()> {
    if lists.is_empty() {
        return Ok(());
    }
    fs::create_dir_all(folder)?;
    for (hash, list) in lists {
        if read(folder, &list.to_side_file()).is_ok() {
            continue;
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".relievo-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut file = builder.tempfile_in(folder)?;
        file.write_all(&list.to_side_bytes())?;
        file.as_file().sync_all()?;
        file.persist(file_in(folder, *hash))
            .map_err(|error| error.error)?;
    }
    crate::file::sync_folder(folder)
}

/// Takes away files of lists that nothing names any more, and the folder once it is empty. What
/// cannot be removed stays: it is only waste.
pub(crate) fn clean(folder: &Path, text: &Project) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    let used: BTreeSet<OsString> = text
        .all_elements()
        .flat_map(|element| element.vertex_lists())
        .filter_map(|list| list.missing())
        .filter_map(|side_file| file_in(folder, side_file.hash).file_name().map(Into::into))
        .collect();
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name();
        let is_ours = name.to_str().is_some_and(|name| {
            let hash = name
                .strip_suffix(".vertices")
                .and_then(ContentHash::from_hex);
            let unfinished = name.strip_prefix(".relievo-");
            hash.is_some() || unfinished.is_some_and(|rest| rest.strip_suffix(".tmp").is_some())
        });
        if is_ours && !used.contains(&name) {
            drop(fs::remove_file(entry.path()));
        }
    }
    // Fails where anything is left.
    drop(fs::remove_dir(folder));
}
