//! Writers: Cloud Optimised GeoTIFF, OpenEXR and PNG. Files appear whole or not at all.

mod cog;
#[cfg(feature = "openexr")]
mod exr;
mod geokeys;
mod ifd;
mod picture;

use std::path::{Path, PathBuf};

pub use cog::{CogLayout, CogSamples, CogSource, CogWork, write_cog};
#[cfg(feature = "openexr")]
pub use exr::{ExrLayout, ExrSamples, ExrSource, write_exr};
pub use picture::{Png, write_png};

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The samples could not be had.
    #[error("cannot make the samples: {0}")]
    Samples(Box<dyn core::error::Error + Send + Sync>),
    /// What was asked for cannot be stored.
    #[error("cannot write {path:?}: {reason}")]
    Unsupported {
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The system refuses: no space, no permission, no folder.
    #[error("cannot write {path:?}: {source}")]
    Io {
        /// What the system says.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
}

/// Errors of the system at a file.
fn io_error(path: &Path) -> impl Fn(std::io::Error) -> WriteError + '_ {
    move |source| WriteError::Io {
        source,
        path: path.to_owned(),
    }
}

/// The folder in which a file's temporary copies belong.
fn folder(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."))
}

/// Refuses a place that holds something else than a file: moving a file onto a device or a folder
/// would take it away from the system. Long work asks before it begins.
fn expect_a_file_or_nothing(path: &Path) -> Result<(), WriteError> {
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        return Err(WriteError::Unsupported {
            reason: "expected a file to replace, found a folder or a device".into(),
            path: path.to_owned(),
        });
    }
    Ok(())
}

/// Writes a file beside its place and moves it there when it is whole.
fn atomically(
    path: &Path,
    write: impl FnOnce(&mut std::io::BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> Result<(), WriteError> {
    use std::io::Write;
    expect_a_file_or_nothing(path)?;
    let mut temporary = tempfile::Builder::new()
        .prefix(".relievo-")
        .tempfile_in(folder(path))
        .map_err(io_error(path))?;
    {
        let mut buffered = std::io::BufWriter::new(temporary.as_file_mut());
        write(&mut buffered)
            .and_then(|()| buffered.flush())
            .map_err(io_error(path))?;
    }
    temporary.as_file().sync_all().map_err(io_error(path))?;
    // Temporary files are private; this one becomes an ordinary file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(path).map_or(0o644, |m| m.permissions().mode());
        temporary
            .as_file()
            .set_permissions(std::fs::Permissions::from_mode(mode))
            .map_err(io_error(path))?;
    }
    temporary
        .persist(path)
        .map_err(|e| io_error(path)(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests;
