//! Projects that have no file yet: their beginnings and journals lie in the user's state folder.
//!
//! An untitled project gets a file there like any other, so that its journal extends it and its lock
//! says that a program still has it. A second file says from which folder its relative paths start.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{Recovery, beside};
use crate::{FileStamp, Project, ProjectLock, Replace, SaveProjectError, save_atomic, side_folder};

const PREFIX: &str = "untitled-";
const SUFFIX: &str = ".relievo";

/// An untitled project whose program ended without saving or dismissing it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Abandoned {
    /// Its file in the state folder, which [`Recovery::find`] takes.
    pub path: PathBuf,
    /// Where its relative paths start.
    pub folder: PathBuf,
}

/// Writes the beginning of an untitled project, whose relative paths start at `folder`, into the state
/// folder. Gives its file, for a [`Journal`](super::Journal).
///
/// # Errors
/// Where nothing can be written there.
pub fn keep_untitled(
    project: &Project,
    folder: &Path,
    state_folder: &Path,
) -> Result<(PathBuf, FileStamp), SaveProjectError> {
    let journals = state_folder.join("journals");
    let failed = |source: io::Error| SaveProjectError::Write {
        source,
        path: journals.clone(),
    };
    fs::create_dir_all(&journals).map_err(failed)?;
    let process = std::process::id();
    for number in 1_u32.. {
        let path = journals.join(format!("{PREFIX}{process}-{number}{SUFFIX}"));
        match save_atomic(&path, project, Replace::Never) {
            Ok(stamp) => {
                let from = folder.as_os_str().as_encoded_bytes();
                fs::write(folder_file(&path), from).map_err(failed)?;
                return Ok((path, stamp));
            }
            Err(SaveProjectError::Exists { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    unreachable!("four thousand million untitled projects of one program")
}

/// Untitled projects with unsaved edits that no program has open. Those without edits are removed.
pub fn abandoned(state_folder: &Path) -> Vec<Abandoned> {
    let entries = fs::read_dir(state_folder.join("journals"))
        .into_iter()
        .flatten();
    let mut paths: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_untitled(path, state_folder))
        .collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let Ok(lock) = ProjectLock::take(&path) else {
            continue;
        };
        let edits = crate::open(&path)
            .ok()
            .and_then(|(_, stamp)| Recovery::find(&path, stamp, None).ok());
        let folder = fs::read(folder_file(&path)).ok().and_then(path_of);
        match (edits, folder) {
            (Some(Some(_)), Some(folder)) => found.push(Abandoned { path, folder }),
            (Some(None), _) => {
                drop(lock);
                forget_untitled(&path);
            }
            // Damaged: somebody may still want to look at it.
            _ => {}
        }
    }
    found
}

/// Removes everything of an untitled project from the state folder: it has been saved under a name, or
/// is not wanted.
pub fn forget_untitled(path: &Path) {
    drop(fs::remove_file(beside(path)));
    drop(fs::remove_dir_all(side_folder(path)));
    drop(fs::remove_file(path));
    drop(fs::remove_file(folder_file(path)));
}

/// Whether a project's file is that of an untitled project.
pub fn is_untitled(path: &Path, state_folder: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let is_named = name.is_some_and(|name| {
        name.strip_prefix(PREFIX)
            .is_some_and(|rest| rest.strip_suffix(SUFFIX).is_some())
    });
    is_named && path.parent() == Some(&state_folder.join("journals"))
}

fn folder_file(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".folder");
    PathBuf::from(name)
}

#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "other systems take text only")]
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt as _;
    Some(PathBuf::from(OsString::from_vec(bytes)))
}

#[cfg(not(unix))]
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    let text = String::from_utf8(bytes).ok()?;
    Some(PathBuf::from(OsString::from(text)))
}
