//! What a journal holds after a crash.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde_json::Value;

use super::{MAGIC, RECORD_HEAD_BYTES, aside, beside, checksum, in_state_folder};
use crate::{Edit, EditError, FileStamp, Project};

/// Why a journal cannot be read at all.
#[derive(Debug, thiserror::Error)]
pub enum RecoveryError {
    /// The file cannot be read.
    #[error("cannot read the journal of unsaved edits: {source}: {path:?}")]
    Read {
        /// What the system said.
        source: io::Error,
        /// The file.
        path: PathBuf,
    },
    /// The file is no journal, or its beginning was lost.
    #[error("expected a journal of unsaved edits, found other bytes: {path:?}")]
    NoJournal {
        /// The file.
        path: PathBuf,
    },
}

/// Edits that were made after the last save and never saved.
#[derive(Clone, Debug)]
pub struct Recovery {
    project: PathBuf,
    file: PathBuf,
    stamp: FileStamp,
    /// Bytes of whole records.
    length: u64,
    edits: Vec<Edit>,
    fits: bool,
    torn: bool,
    when: Option<SystemTime>,
}

impl Recovery {
    /// Looks for a journal of the project at `project`, whose file's content is `stamp`. `None` where
    /// there is none, or the file already has all its edits. Changes nothing.
    ///
    /// # Errors
    /// Where a journal is there and cannot be read.
    pub fn find(
        project: &Path,
        stamp: FileStamp,
        state_folder: Option<&Path>,
    ) -> Result<Option<Self>, RecoveryError> {
        for path in places(project, state_folder) {
            if let Some(recovery) = Self::look(&path, project, stamp)? {
                return Ok(Some(recovery));
            }
        }
        Ok(None)
    }

    /// Removes journals whose edits the project's file has, as a crash in the middle of a save leaves
    /// them. For who holds the project's lock: others may be about to write there.
    pub fn tidy(project: &Path, stamp: FileStamp, state_folder: Option<&Path>) {
        for path in places(project, state_folder) {
            if let Ok(None) = Self::look(&path, project, stamp) {
                // Mostly it is not there at all.
                drop(fs::remove_file(path));
            }
        }
    }

    /// The journal in a file, where it has edits that the project lacks.
    pub(super) fn look(
        path: &Path,
        project: &Path,
        stamp: FileStamp,
    ) -> Result<Option<Self>, RecoveryError> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => {
                return Err(RecoveryError::Read {
                    source,
                    path: path.to_owned(),
                });
            }
        };
        if is_only_begun(&bytes) {
            return Ok(None);
        }
        let Some(mut recovery) = Self::read(&bytes, project, path, stamp) else {
            return Err(RecoveryError::NoJournal {
                path: path.to_owned(),
            });
        };
        recovery.when = fs::metadata(path).and_then(|data| data.modified()).ok();
        Ok((!recovery.edits.is_empty()).then_some(recovery))
    }

    fn read(bytes: &[u8], project: &Path, file: &Path, current: FileStamp) -> Option<Self> {
        let mut rest = bytes.strip_prefix(MAGIC)?;
        let (head, after) = record(rest)?;
        rest = after;
        let mut stamp = FileStamp::from_hex(head["extends"].as_str()?)?;
        let mut edits = Vec::new();
        let mut fits = stamp == current;
        let mut length = bytes.len() - rest.len();
        while let Some((value, after)) = record(rest) {
            if let Some(saving) = value["saving"].as_str() {
                // A save that came about: what was before is in the file.
                if FileStamp::from_hex(saving) == Some(current) {
                    edits.clear();
                    stamp = current;
                    fits = true;
                }
            } else if let Ok(edit) = serde_json::from_value::<Edit>(value) {
                edits.push(edit);
            } else {
                // A newer program's: what comes behind may depend on it.
                break;
            }
            rest = after;
            length = bytes.len() - rest.len();
        }
        Some(Self {
            project: project.to_owned(),
            file: file.to_owned(),
            stamp,
            length: length as u64,
            edits,
            fits,
            torn: !rest.is_empty(),
            when: None,
        })
    }

    /// The edits, in order.
    pub fn edits(&self) -> &[Edit] {
        &self.edits
    }

    /// Whether the project's file is the one that the edits extend. Where it is not, another program
    /// changed it: edits may fit or not.
    pub fn fits(&self) -> bool {
        self.fits
    }

    /// Whether the end of the journal was torn and dropped.
    pub fn is_torn(&self) -> bool {
        self.torn
    }

    /// When the last edit was written, where the system says.
    pub fn when(&self) -> Option<SystemTime> {
        self.when
    }

    /// The journal's file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The project.
    pub fn project(&self) -> &Path {
        &self.project
    }

    /// What the edits extend.
    pub(super) fn stamp(&self) -> FileStamp {
        self.stamp
    }

    /// Bytes of whole records.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Applies the edits to a project, up to the first that does not fit. Gives how many were applied
    /// and why no more were.
    pub fn replay(&self, project: &mut Project) -> (usize, Option<EditError>) {
        for (count, edit) in self.edits.iter().enumerate() {
            if let Err(error) = project.apply(edit.clone()) {
                return (count, Some(error));
            }
        }
        (self.edits.len(), None)
    }

    /// Puts a journal that made room for another back in its place, unless something is there.
    ///
    /// # Errors
    /// Where the file cannot be moved.
    pub fn put_back(file: &Path) -> io::Result<()> {
        let aside = aside(file);
        if file.exists() || !aside.exists() {
            return Ok(());
        }
        fs::rename(aside, file)
    }

    /// Removes the journal: its edits are not wanted.
    ///
    /// # Errors
    /// Where the file cannot be removed.
    pub fn discard(self) -> io::Result<()> {
        fs::remove_file(&self.file)
    }
}

/// Where a project's journal may lie.
fn places(project: &Path, state_folder: Option<&Path>) -> impl Iterator<Item = PathBuf> {
    let in_state = state_folder.map(|folder| in_state_folder(project, folder));
    core::iter::once(beside(project)).chain(in_state)
}

/// Whether a journal was begun and not even its beginning came to be whole, as a kill at that moment leaves
/// it: no edit is behind it.
fn is_only_begun(bytes: &[u8]) -> bool {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return MAGIC.starts_with(bytes);
    };
    // The object that it holds is not closed.
    let payload = rest.get(RECORD_HEAD_BYTES..).unwrap_or_default();
    !payload.contains(&b'}')
}

/// The first record and what follows; `None` where there is no whole one.
fn record(bytes: &[u8]) -> Option<(Value, &[u8])> {
    let (head, rest) = bytes.split_at_checked(RECORD_HEAD_BYTES)?;
    let length = u32::from_le_bytes(head.get(..4)?.try_into().ok()?) as usize;
    let (payload, rest) = rest.split_at_checked(length)?;
    if checksum(payload) != head[4..] {
        return None;
    }
    Some((serde_json::from_slice(payload).ok()?, rest))
}
