//! Reading and saving project files. The only part of this crate that touches a disk.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::side;
use crate::{ContentHash, MOST_BYTES, OpenProjectError, Project, SaveProjectError};

/// What a file's bytes were when they were read or written: their hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileStamp([u8; 32]);

impl FileStamp {
    fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// From 64 lower-case hexadecimal digits, as it is shown.
    pub fn from_hex(text: &str) -> Option<Self> {
        ContentHash::from_hex(text).map(|hash| Self(hash.0))
    }
}

impl core::fmt::Display for FileStamp {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        ContentHash(self.0).fmt(f)
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

/// Reads a project file and the long lists of vertices beside it. Lists that cannot be read count as
/// empty: see [`Project::missing_geometry`].
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
    let mut project = Project::from_json(&text, path)?;
    project.load_side_files(&side::side_folder(path));
    Ok((project, stamp))
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

/// As [`save_with`] for those who keep no journal.
///
/// # Errors
/// As [`save_with`].
pub fn save_atomic(
    path: &Path,
    project: &Project,
    replace: Replace,
) -> Result<FileStamp, SaveProjectError> {
    save_with(path, project, replace, |_| {})
}

/// Saves a project so that after a crash at any moment the file holds either the old or the new
/// content: written to a temporary file in the same folder, synced, renamed, the folder synced.
///
/// Long lists of vertices are written to files beside it first; those that nothing names any more go
/// last. `about_to` hears what the file will be when all that is left to do is to replace it: see
/// [`Journal::saving`](crate::Journal::saving).
///
/// The project's paths must fit the folder: see [`Project::rebased`]. A link is followed, so that the
/// file it leads to is replaced. The permissions of an existing file are kept.
///
/// # Errors
/// Where the file cannot be written or may not be replaced; the old file is then untouched and
/// nothing is left behind.
pub fn save_with(
    path: &Path,
    project: &Project,
    replace: Replace,
    about_to: impl FnOnce(FileStamp),
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
    let (in_text, lists) = project.apart();
    let text = in_text.text();
    if text.len() > MOST_BYTES {
        return Err(SaveProjectError::TooLarge {
            most: MOST_BYTES,
            found: text.len(),
            path: path.to_owned(),
        });
    }
    let side_folder = side::side_folder(&target);
    side::write(&side_folder, &lists).map_err(failed)?;
    let stamp = FileStamp::of(text.as_bytes());

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

    // As late as possible, though no file system lets a check and a rename be one step.
    if let Replace::IfUnchanged(stamp) = replace {
        match fs::read(&target) {
            Ok(bytes) if FileStamp::of(&bytes) == stamp => {}
            Ok(_) => {
                return Err(SaveProjectError::ChangedOnDisk {
                    path: path.to_owned(),
                });
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(failed(error)),
        }
    }
    about_to(stamp);
    let result = match replace {
        Replace::Always | Replace::IfUnchanged(_) => temporary.persist(&target),
        Replace::Never => temporary.persist_noclobber(&target),
    };
    if let Err(error) = result {
        let exists = error.error.kind() == io::ErrorKind::AlreadyExists;
        return Err(if exists && replace == Replace::Never {
            SaveProjectError::Exists {
                path: path.to_owned(),
            }
        } else {
            failed(error.error)
        });
    }
    sync_folder(&folder).map_err(failed)?;
    side::clean(&side_folder, &in_text);
    Ok(stamp)
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
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some network file systems cannot; the rename itself has succeeded.
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        result => result,
    }
}

#[cfg(not(unix))]
pub(crate) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// A name beside `path` that nothing has, for keeping two versions of a project: `NAME 2.relievo`.
pub fn free_name_beside(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default();
    let numbered = |number: usize| {
        let mut name = stem.to_owned();
        name.push(format!(" {number}"));
        if let Some(extension) = path.extension() {
            name.push(".");
            name.push(extension);
        }
        path.with_file_name(name)
    };
    let mut number = 2;
    while numbered(number).exists() {
        number += 1;
    }
    numbered(number)
}
