//! Small files that the window keeps from one run to the next.
//!
//! One that cannot be read or written is no reason to trouble anybody: it is told to diagnostics only.

use std::path::Path;
use std::{fs, io};

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Most bytes of a file that are read.
const MOST_BYTES: u64 = 1 << 20;

/// What a file holds; the default where there is none or it is damaged.
pub(crate) fn read<T: DeserializeOwned + Default>(file: &Path) -> T {
    let stored = match fs::metadata(file) {
        Ok(metadata) if metadata.len() <= MOST_BYTES => fs::read(file),
        Ok(_) => Err(io::Error::other("expected at most 1 MiB, found more")),
        Err(error) => Err(error),
    };
    let stored = match stored {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(io::Error::other),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return T::default(),
        Err(error) => Err(error),
    };
    stored.unwrap_or_else(|error| {
        tracing::warn!("what was kept cannot be read: {error}: {file:?}");
        T::default()
    })
}

/// Writes a file so that whoever reads it finds the old or the new one.
pub(crate) fn write<T: Serialize>(file: &Path, what: &T) {
    if let Err(error) = try_write(file, what) {
        tracing::warn!("what the window remembers is not kept: {error}: {file:?}");
    }
}

fn try_write<T: Serialize>(file: &Path, what: &T) -> io::Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    let new = file.with_extension(format!("{}.new", std::process::id()));
    fs::write(
        &new,
        serde_json::to_vec_pretty(what).map_err(io::Error::other)?,
    )?;
    fs::rename(&new, file)
}
