//! What can go wrong with files.

use std::path::{Path, PathBuf};

use crate::Fault;
use crate::stored::parse;

/// Why a project (or a list of edits) cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum OpenProjectError {
    /// The file cannot be read.
    #[error("cannot read the project: {source}: {path:?}")]
    Read {
        /// What the system said.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
    /// The file is larger than any project.
    #[error("expected a project of at most {most} bytes, found {found}: {path:?}")]
    TooLarge {
        /// The limit.
        most: usize,
        /// The size.
        found: u64,
        /// The file.
        path: PathBuf,
    },
    /// The file is not text.
    #[error("expected UTF-8 text, found other bytes after byte {valid_bytes}: {path:?}")]
    NotText {
        /// Bytes before the first that is not.
        valid_bytes: usize,
        /// The file.
        path: PathBuf,
    },
    /// The text is not JSON.
    #[error("expected JSON, found at line {line}, column {column}: {message}: {path:?}")]
    Syntax {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// What is wrong.
        message: String,
        /// The file.
        path: PathBuf,
    },
    /// A newer program made the file.
    #[error(
        "this program reads versions up to {supported}, the file has version {found}: open it with a newer Relievo: {path:?}"
    )]
    NewerVersion {
        /// The newest version that can be read.
        supported: u32,
        /// The file's version.
        found: u32,
        /// The file.
        path: PathBuf,
    },
    /// A value does not fit.
    #[error("line {line}, {fault}: {path:?}")]
    Invalid {
        /// Line of the value, from 1.
        line: usize,
        /// Where, what was expected and what was found.
        fault: Fault,
        /// The file.
        path: PathBuf,
    },
}

impl OpenProjectError {
    pub(crate) fn invalid(text: &str, fault: Fault, path: &Path) -> Self {
        Self::Invalid {
            line: parse::line_of(text, &fault.pointer),
            fault,
            path: path.to_owned(),
        }
    }

    pub(crate) fn syntax(error: &serde_json::Error, path: &Path) -> Self {
        // The library repeats the place at the end of its message.
        let message = error.to_string();
        let message = message
            .split(" at line ")
            .next()
            .unwrap_or_default()
            .to_owned();
        Self::Syntax {
            line: error.line(),
            column: error.column(),
            message,
            path: path.to_owned(),
        }
    }
}

/// Why a project cannot be saved. The file on disk is as it was.
#[derive(Debug, thiserror::Error)]
pub enum SaveProjectError {
    /// The file cannot be written.
    #[error("cannot write the project: {source}: {path:?}")]
    Write {
        /// What the system said.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
    /// Another program changed the file since it was read.
    #[error("the project changed on disk since it was opened: {path:?}")]
    ChangedOnDisk {
        /// The file.
        path: PathBuf,
    },
    /// The text would be longer than any that can be opened.
    #[error("expected a project of at most {most} bytes, found {found}: {path:?}")]
    TooLarge {
        /// The limit.
        most: usize,
        /// The length.
        found: usize,
        /// The file.
        path: PathBuf,
    },
    /// The file exists and was not to be replaced.
    #[error("the file exists: {path:?}")]
    Exists {
        /// The file.
        path: PathBuf,
    },
}
