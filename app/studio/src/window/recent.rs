//! The projects that were open lately, remembered from one run to the next.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::remembered;

/// Projects that are remembered.
const MOST: usize = 10;

/// The stored list. Members that are not known are dropped: it is no document.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Stored {
    projects: Vec<PathBuf>,
}

/// The list, the latest first.
#[derive(Debug, Default)]
pub(crate) struct Recent {
    /// Where it is kept; `None`: nowhere.
    file: Option<PathBuf>,
    projects: Vec<PathBuf>,
    /// Those whose files are not there.
    missing: BTreeSet<PathBuf>,
    /// Whether its menu is open.
    is_open: bool,
}

impl Recent {
    /// The list that is kept in a folder, empty if there is none.
    pub(crate) fn load(folder: Option<&Path>) -> Self {
        let file = folder.map(|f| f.join("recent.json"));
        Self {
            projects: file.as_deref().map(read).unwrap_or_default(),
            file,
            missing: BTreeSet::new(),
            is_open: false,
        }
    }

    /// The projects, the latest first, and whether each is there.
    pub(crate) fn projects(&self) -> impl Iterator<Item = (&Path, bool)> {
        self.projects
            .iter()
            .map(|path| (path.as_path(), !self.missing.contains(path)))
    }

    /// Paths of all of them.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        self.projects.clone()
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.projects.is_empty()
    }

    /// Takes in whether its menu is open; whether it was not before.
    pub(crate) fn opens(&mut self, is_open: bool) -> bool {
        let was_open = std::mem::replace(&mut self.is_open, is_open);
        is_open && !was_open
    }

    /// A project was opened or saved.
    pub(crate) fn add(&mut self, path: &Path) {
        // Another window may have written meanwhile.
        if let Some(file) = &self.file {
            self.projects = read(file);
        }
        self.projects.retain(|p| p != path);
        self.projects.insert(0, path.to_owned());
        self.projects.truncate(MOST);
        self.missing.remove(path);
        self.save();
    }

    /// Forgets all of them.
    pub(crate) fn clear(&mut self) {
        self.projects.clear();
        self.save();
    }

    /// Says which of them are not there.
    pub(crate) fn set_missing(&mut self, missing: Vec<PathBuf>) {
        self.missing = missing.into_iter().collect();
    }

    fn save(&self) {
        let Some(file) = &self.file else { return };
        // A path that is not Unicode cannot be written as JSON; it is no reason to lose the others.
        let projects = self.projects.iter().filter(|p| p.to_str().is_some());
        let projects = projects.cloned().collect();
        remembered::write(file, &Stored { projects });
    }
}

fn read(file: &Path) -> Vec<PathBuf> {
    let mut stored: Stored = remembered::read(file);
    stored.projects.truncate(MOST);
    stored.projects
}

/// The user's folder for what programs remember, where the system has one.
pub(crate) fn default_state_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "relievo")
        .map(|d| d.state_dir().unwrap_or(d.data_local_dir()).to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_latest_is_first_each_is_there_once_and_ten_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("state");
        let mut recent = Recent::load(Some(&state));
        assert!(recent.is_empty());
        for n in 0..12 {
            recent.add(Path::new(&format!("/p/{n}.relievo")));
        }
        recent.add(Path::new("/p/5.relievo"));
        let names = |recent: &Recent| -> Vec<String> {
            let names = recent
                .projects()
                .map(|(p, _)| p.file_stem().unwrap().to_string_lossy().into_owned());
            names.collect()
        };
        let expected = ["5", "11", "10", "9", "8", "7", "6", "4", "3", "2"];
        assert_eq!(names(&recent), expected);
        assert_eq!(names(&Recent::load(Some(&state))), expected);
        recent.clear();
        assert!(Recent::load(Some(&state)).is_empty());
    }

    #[test]
    fn two_windows_keep_each_others_projects() {
        let folder = tempfile::tempdir().unwrap();
        let mut one = Recent::load(Some(folder.path()));
        let mut other = Recent::load(Some(folder.path()));
        one.add(Path::new("/a.relievo"));
        other.add(Path::new("/b.relievo"));
        assert_eq!(
            other.paths(),
            ["/b.relievo", "/a.relievo"].map(PathBuf::from)
        );
    }

    #[test]
    fn a_damaged_list_is_an_empty_one_and_is_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("recent.json"), "{\"projects\": 7").unwrap();
        let mut recent = Recent::load(Some(folder.path()));
        assert!(recent.is_empty());
        recent.add(Path::new("/a.relievo"));
        assert_eq!(
            Recent::load(Some(folder.path())).paths(),
            [PathBuf::from("/a.relievo")]
        );
    }

    #[test]
    fn what_is_missing_is_marked_and_stays() {
        let mut recent = Recent::load(None);
        recent.add(Path::new("/a.relievo"));
        recent.add(Path::new("/b.relievo"));
        recent.set_missing(vec![PathBuf::from("/a.relievo")]);
        let there: Vec<bool> = recent.projects().map(|(_, there)| there).collect();
        assert_eq!(there, [true, false]);
    }
}
