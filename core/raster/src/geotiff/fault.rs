//! What can be wrong with a TIFF, before anybody knows its path.

use std::io;

/// Why a TIFF, or a part of it, cannot be read.
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

/// A [`Fault::Damaged`] as an `Err`.
pub(crate) fn damaged<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Damaged(reason.into()))
}

/// A [`Fault::Unsupported`] as an `Err`.
pub(crate) fn unsupported<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Unsupported(reason.into()))
}
