//! Bytes read at a position, by any number of threads at once.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use crate::file::CHANGED;

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
            Self::File(file) => file.opened.length,
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

/// A file with what it was when opened.
///
/// Bytes that were read while another program wrote to the file belong to neither of its contents.
/// So a read looks at the file once more when it has its bytes, and refuses them if the file is not
/// what it was. A file that was replaced or removed by name stays readable as it was opened.
#[derive(Debug)]
pub(crate) struct SharedFile {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: parking_lot::Mutex<File>,
    opened: Stamp,
}

/// What changes when a file's content does. Systems without times of change have the length alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn of(file: &File) -> io::Result<Self> {
        let metadata = file.metadata()?;
        Ok(Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        })
    }
}

impl SharedFile {
    fn new(file: File) -> io::Result<Self> {
        let opened = Stamp::of(&file)?;
        #[cfg(not(unix))]
        let file = parking_lot::Mutex::new(file);
        Ok(Self { file, opened })
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        let read = std::os::unix::fs::FileExt::read_exact_at(&self.file, buffer, offset);
        self.refuse_changes(&self.file)?;
        read
    }

    #[cfg(not(unix))]
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.file.lock();
        let read = file
            .seek(SeekFrom::Start(offset))
            .and_then(|_at| file.read_exact(buffer));
        self.refuse_changes(&file)?;
        read
    }

    /// An error where the file is not what it was.
    fn refuse_changes(&self, file: &File) -> io::Result<()> {
        if Stamp::of(file)? == self.opened {
            Ok(())
        } else {
            Err(io::Error::other(CHANGED))
        }
    }
}
