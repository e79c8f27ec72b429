//! Bytes read at a position, by any number of threads at once.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// A file, or bytes in memory, that many threads may read at once.
#[derive(Debug)]
pub(crate) enum Bytes {
    /// A file of the operating system.
    File(SharedFile),
    /// A file image in memory (a pyramid that no cache folder could take).
    Memory(Arc<[u8]>),
}

impl Bytes {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        Ok(Self::File(SharedFile::new(File::open(path)?)?))
    }

    /// Length in bytes.
    pub(crate) fn length(&self) -> u64 {
        match self {
            Self::File(file) => file.length,
            Self::Memory(bytes) => bytes.len() as u64,
        }
    }

    /// Fills `buffer` from `offset`; an error of kind `UnexpectedEof` if the bytes end before.
    pub(crate) fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        let end = offset.checked_add(buffer.len() as u64);
        if end.is_none_or(|end| end > self.length()) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        match self {
            Self::File(file) => file.read_at(offset, buffer),
            Self::Memory(bytes) => {
                let start = offset as usize;
                buffer.copy_from_slice(&bytes[start..start + buffer.len()]);
                Ok(())
            }
        }
    }

    /// A fresh vector of `length` bytes from `offset`.
    pub(crate) fn vec_at(&self, offset: u64, length: u64) -> io::Result<Vec<u8>> {
        // Checked before the allocation: a header may claim any length.
        if offset
            .checked_add(length)
            .is_none_or(|end| end > self.length())
        {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut bytes = vec![0; usize::try_from(length).map_err(io::Error::other)?];
        self.read_at(offset, &mut bytes)?;
        Ok(bytes)
    }
}

/// A file with its length when opened.
#[derive(Debug)]
pub(crate) struct SharedFile {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: parking_lot::Mutex<File>,
    length: u64,
}

impl SharedFile {
    #[cfg(unix)]
    fn new(file: File) -> io::Result<Self> {
        Ok(Self {
            length: file.metadata()?.len(),
            file,
        })
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, buffer, offset)
    }

    #[cfg(not(unix))]
    fn new(file: File) -> io::Result<Self> {
        Ok(Self {
            length: file.metadata()?.len(),
            file: parking_lot::Mutex::new(file),
        })
    }

    #[cfg(not(unix))]
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.file.lock();
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(buffer)
    }
}
