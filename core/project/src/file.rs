//! Reading and saving project files. The only part of this crate that touches a disk.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::{MOST_BYTES, OpenProjectError, Project, SaveProjectError};

/// What a file's bytes were when they were read or written: their hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileStamp([u8; 32]);

impl FileStamp {
    fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }
}

/// When saving may replace a file that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replace {
    /// In any case: the user said so.
    Always,
    /// Where the file still is what it was; one that is gone is written again.
    IfUnchanged(FileStamp),
    /// Never.
    Never,
}

/// Reads a project file.
///
/// # Errors
/// Where the file cannot be read or is not a project that this version reads.
pub fn open(path: &Path) -> Result<(Project, FileStamp), OpenProjectError> {
    let bytes = read_limited(path)?;
    let stamp = FileStamp::of(&bytes);
    let text = String::from_utf8(bytes).map_err(|error| OpenProjectError::NotText {
        valid_bytes: error.utf8_error().valid_up_to(),
        path: path.to_owned(),
    })?;
    Ok((Project::from_json(&text, path)?, stamp))
}

/// Reads the text of a JSON file that is not a project, with the same limits: a list of edits.
///
/// # Errors
/// Where the file cannot be read, is too large or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, OpenProjectError> {
    String::from_utf8(read_limited(path)?).map_err(|error| OpenProjectError::NotText {
        valid_bytes: error.utf8_error().valid_up_to(),
        path: path.to_owned(),
    })
}

fn read_limited(path: &Path) -> Result<Vec<u8>, OpenProjectError> {
    let failed = |source| OpenProjectError::Read {
        source,
        path: path.to_owned(),
    };
    // A pipe or a device would never end.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(io::Error::new(
            io::ErrorKind::InvalidInput,
            "not a file",
        )));
    }
    let file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() > MOST_BYTES {
        return Err(OpenProjectError::TooLarge {
            most: MOST_BYTES,
            found: bytes.len() as u64,
            path: path.to_owned(),
        });
    }
    Ok(bytes)
}

/// Saves a project so that after a crash at any moment the file holds either the old or the new
/// content: written to a temporary file in the same folder, synced, renamed, the folder synced.
///
/// The project's paths must fit the folder: see [`Project::rebased`]. A link is followed, so that the
/// file it leads to is replaced. The permissions of an existing file are kept.
///
/// # Errors
/// Where the file cannot be written or may not be replaced; the old file is then untouched and
/// nothing is left behind.
pub fn save_atomic(
    path: &Path,
    project: &Project,
    replace: Replace,
) -> Result<FileStamp, SaveProjectError> {
    let failed = |source| SaveProjectError::Write {
        source,
        path: path.to_owned(),
    };
    let target = fs::canonicalize(path).unwrap_or_else(|_missing| path.to_owned());
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    // A rename would take a device away from the system.
    if fs::metadata(&target).is_ok_and(|data| !data.is_file()) {
        return Err(failed(io::Error::new(
            io::ErrorKind::InvalidInput,
            "expected a file to replace, found a folder or a device",
        )));
    }
    let text = project.to_json();

    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-").suffix(".tmp");
    let permissions = new_file_permissions(&target);
    if let Some(permissions) = permissions.clone() {
        builder.permissions(permissions);
    }
    let mut temporary = builder.tempfile_in(&folder).map_err(failed)?;
    temporary.write_all(text.as_bytes()).map_err(failed)?;
    if let (Some(permissions), true) = (permissions, target.exists()) {
        temporary
            .as_file()
            .set_permissions(permissions)
            .map_err(failed)?;
    }
    temporary.as_file().sync_all().map_err(failed)?;

    match replace {
        Replace::Always => {}
        // As late as possible, though no file system lets a check and a rename be one step.
        Replace::IfUnchanged(stamp) => match fs::read(&target) {
            Ok(bytes) if FileStamp::of(&bytes) == stamp => {}
            Ok(_) => {
                return Err(SaveProjectError::ChangedOnDisk {
                    path: path.to_owned(),
                });
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(failed(error)),
        },
        Replace::Never => {
            return match temporary.persist_noclobber(&target) {
                Ok(_) => {
                    sync_folder(&folder).map_err(failed)?;
                    Ok(FileStamp::of(text.as_bytes()))
                }
                Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
                    Err(SaveProjectError::Exists {
                        path: path.to_owned(),
                    })
                }
                Err(error) => Err(failed(error.error)),
            };
        }
    }
    temporary
        .persist(&target)
        .map_err(|error| failed(error.error))?;
    sync_folder(&folder).map_err(failed)?;
    Ok(FileStamp::of(text.as_bytes()))
}

/// Whether the file is still what it was.
///
/// # Errors
/// Where it cannot be read.
pub fn is_unchanged(path: &Path, stamp: FileStamp) -> io::Result<bool> {
    Ok(FileStamp::of(&fs::read(path)?) == stamp)
}

/// Those of the file to replace, or what a new file gets (temporary files are private otherwise).
#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "other systems have none")]
fn new_file_permissions(target: &Path) -> Option<fs::Permissions> {
    use std::os::unix::fs::PermissionsExt as _;
    let existing = fs::metadata(target).map(|data| data.permissions());
    // The system takes the user's mask off a new file's.
    Some(existing.unwrap_or_else(|_missing| fs::Permissions::from_mode(0o666)))
}

#[cfg(not(unix))]
fn new_file_permissions(_: &Path) -> Option<fs::Permissions> {
    None
}

/// Makes a rename in the folder survive a power cut.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some network file systems cannot; the rename itself has succeeded.
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        result => result,
    }
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
