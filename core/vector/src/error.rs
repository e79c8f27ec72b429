//! Why features cannot be had.

use std::io;
use std::path::{Path, PathBuf};

/// Why a file of vectors cannot be read or written. Each is one line that names the file.
#[derive(Clone, Debug, thiserror::Error)]
pub enum VectorError {
    /// The operating system says no.
    #[error("{reason}: {path:?}")]
    Io {
        /// What it says.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The content breaks the format.
    #[error("damaged {format} file: {reason}: {path:?}")]
    Damaged {
        /// The format.
        format: &'static str,
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The content is in order, but nothing here can use it.
    #[error("{format} file that cannot be used: {reason}: {path:?}")]
    Unsupported {
        /// The format.
        format: &'static str,
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// Whoever asked does not want it any more.
    #[error("cancelled")]
    Cancelled,
}

/// What can be wrong with a file, before anybody knows its path.
#[derive(Clone, Debug, thiserror::Error)]
pub(crate) enum Fault {
    #[error("{0}")]
    Io(String),
    #[error("{0}")]
    Damaged(String),
    #[error("{0}")]
    Unsupported(String),
    #[error("cancelled")]
    Cancelled,
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof {
            Self::Damaged("the file ends before the data that it points to".into())
        } else {
            Self::Io(error.to_string())
        }
    }
}

impl Fault {
    /// The fault as met with a file of a format.
    pub(crate) fn of(self, format: &'static str, path: &Path) -> VectorError {
        let path = path.to_owned();
        match self {
            Self::Io(reason) => VectorError::Io { reason, path },
            Self::Damaged(reason) => VectorError::Damaged {
                format,
                reason: one_line(&reason),
                path,
            },
            Self::Unsupported(reason) => VectorError::Unsupported {
                format,
                reason: one_line(&reason),
                path,
            },
            Self::Cancelled => VectorError::Cancelled,
        }
    }
}

/// A [`Fault::Damaged`] as an `Err`.
pub(crate) fn damaged<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Damaged(reason.into()))
}

/// A [`Fault::Unsupported`] as an `Err`.
pub(crate) fn unsupported<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Unsupported(reason.into()))
}

/// Libraries put what they found into their messages: one line of it, and not a long one.
fn one_line(reason: &str) -> String {
    let line: String = reason
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(300)
        .collect();
    line
}
