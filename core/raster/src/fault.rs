//! What can be wrong with a file, before anybody knows its path.

use std::io;
use std::path::Path;

use crate::file::ReadError;
use crate::open::OpenError;

/// Why a file, or a part of it, cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fault {
    /// The operating system says no.
    #[error("{0}")]
    Io(io::Error),
    /// The content breaks the format: expected and found.
    #[error("{0}")]
    Damaged(String),
    /// The content is in order but nothing here reads it: expected and found.
    #[error("{0}")]
    Unsupported(String),
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof {
            Self::Damaged("the file ends before the data that it points to".into())
        } else {
            Self::Io(error)
        }
    }
}

impl Fault {
    /// The fault as met when a file of a format is opened.
    pub(crate) fn on_open(self, format: &'static str, path: &Path) -> OpenError {
        let path = path.to_owned();
        match self {
            Self::Io(error) => OpenError::Io {
                reason: error.to_string(),
                path,
            },
            Self::Damaged(reason) => OpenError::Damaged {
                format,
                reason,
                path,
            },
            Self::Unsupported(reason) => OpenError::Unsupported {
                format,
                reason,
                path,
            },
        }
    }

    /// The fault as met when samples are read.
    pub(crate) fn on_read(self, format: &'static str, path: &Path) -> ReadError {
        let path = path.to_owned();
        match self {
            Self::Io(error) => ReadError::Io {
                reason: error.to_string(),
                path,
            },
            Self::Damaged(reason) | Self::Unsupported(reason) => ReadError::Damaged {
                format,
                reason,
                path,
            },
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
