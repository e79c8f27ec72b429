//! Where a pyramid grows: a temporary file beside its final place, or memory.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use parking_lot::Mutex;
use tempfile::NamedTempFile;

/// Bytes that only grow, but for the header.
pub(super) struct Store {
    place: Place,
    length: u64,
}

enum Place {
    File {
        file: NamedTempFile,
        reader: Mutex<File>,
    },
    Memory(Vec<u8>),
}

impl Store {
    /// In memory.
    pub(super) fn memory() -> Self {
        Self {
            place: Place::Memory(Vec::new()),
            length: 0,
        }
    }

    /// In a new file of a folder; gone again unless it is persisted.
    pub(super) fn file_in(folder: &Path) -> io::Result<Self> {
        let file = NamedTempFile::with_prefix_in(".pyramid-", folder)?;
        let reader = Mutex::new(file.reopen()?);
        Ok(Self {
            place: Place::File { file, reader },
            length: 0,
        })
    }

    /// Adds bytes; returns where they start.
    pub(super) fn append(&mut self, bytes: &[u8]) -> io::Result<u64> {
        let at = self.length;
        match &mut self.place {
            Place::File { file, .. } => file.write_all(bytes)?,
            Place::Memory(all) => all.extend_from_slice(bytes),
        }
        self.length += bytes.len() as u64;
        Ok(at)
    }

    /// Where the next bytes go.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Bytes written before.
    pub(super) fn read(&self, at: u64, length: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; length];
        match &self.place {
            Place::File { reader, .. } => {
                let mut reader = reader.lock();
                reader.seek(SeekFrom::Start(at))?;
                reader.read_exact(&mut bytes)?;
            }
            Place::Memory(all) => {
                let start = at as usize;
                let found = all
                    .get(start..start + length)
                    .ok_or(io::ErrorKind::UnexpectedEof)?;
                bytes.copy_from_slice(found);
            }
        }
        Ok(bytes)
    }

    /// Writes over bytes written before.
    pub(super) fn overwrite(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        match &mut self.place {
            Place::File { file, .. } => {
                file.seek(SeekFrom::Start(at))?;
                file.write_all(bytes)?;
                file.seek(SeekFrom::End(0)).map(drop)
            }
            Place::Memory(all) => {
                let start = at as usize;
                all[start..start + bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
        }
    }

    /// Moves the file to its final place in one step.
    pub(super) fn persist(self, path: &Path) -> io::Result<()> {
        match self.place {
            Place::File { mut file, .. } => {
                file.flush()?;
                file.as_file().sync_all()?;
                file.persist(path).map(drop).map_err(|e| e.error)
            }
            Place::Memory(all) => std::fs::write(path, all),
        }
    }

    /// The bytes of a store in memory.
    pub(super) fn into_memory(self) -> Option<Arc<[u8]>> {
        match self.place {
            Place::File { .. } => None,
            Place::Memory(all) => Some(all.into()),
        }
    }
}
