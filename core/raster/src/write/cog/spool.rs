//! Compressed tiles on their way to a file, one after another; kept so that work can go on.
//!
//! A kept spool begins with a magic line and the name of the request; each tile follows with its
//! length and the first bytes of its hash. What a stop cut off or a crash damaged ends what counts.

use std::fs::{File, TryLockError};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use parking_lot::Mutex;

use super::CogLayout;
use crate::write::{WriteError, expect_a_file_or_nothing, folder, io_error};

/// First bytes of a kept spool.
const MAGIC: &[u8; 20] = b"relievo partial 1\n\0\0";
/// Bytes before the first tile.
const HEAD_BYTES: u64 = 20 + 32;
/// Bytes before each tile: its length and the first part of its hash.
const FRAME_BYTES: u64 = 4 + 8;
/// No tile compresses to more: 512² samples of 16 bytes and what Deflate adds.
const MOST_TILE_BYTES: u32 = 8 << 20;

/// The tiles so far.
pub(super) struct Spool {
    file: Mutex<File>,
    /// Where the tiles begin, and their lengths.
    tiles: Vec<(u64, u32)>,
    end: u64,
    /// The kept file; `None` for one that is gone when it is closed.
    path: Option<PathBuf>,
}

impl Spool {
    /// Takes up what was kept of the same request, or begins.
    pub(super) fn open(
        path: &Path,
        layout: &CogLayout,
        resume: Option<[u8; 32]>,
        most_tiles: usize,
    ) -> Result<Self, WriteError> {
        expect_a_file_or_nothing(path)?;
        let Some(request) = resume else {
            return Self::passing(path);
        };
        let mut name = path.as_os_str().to_owned();
        name.push(".part");
        let kept = PathBuf::from(name);
        let error = io_error(&kept);
        let mut file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&kept)
            .map_err(&error)?;
        // On a file system without locks two at once are the user's to avoid.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let reason = "expected to write alone, found that another process writes the same file";
            return Err(WriteError::Unsupported {
                reason: reason.into(),
                path: path.to_owned(),
            });
        }
        let key = key(layout, request);
        let mut head = Vec::new();
        (&mut file)
            .take(HEAD_BYTES)
            .read_to_end(&mut head)
            .map_err(&error)?;
        let ours = head.is_empty() || head.starts_with(MAGIC) || MAGIC.starts_with(&head);
        if !ours {
            tracing::warn!(
                "{kept:?} is no partial file of ours: it is left as it is, and a stop keeps nothing"
            );
            return Self::passing(path);
        }
        let same = head.get(MAGIC.len()..) == Some(key.as_slice());
        let mut spool = Self {
            file: Mutex::new(file),
            tiles: Vec::new(),
            end: HEAD_BYTES,
            path: Some(kept.clone()),
        };
        if same {
            spool.take_up(most_tiles).map_err(&error)?;
        } else {
            if !head.is_empty() {
                tracing::warn!("{kept:?} belongs to another request: begins anew");
            }
            spool.begin(&key).map_err(&error)?;
        }
        Ok(spool)
    }

    /// One that leaves nothing behind.
    fn passing(path: &Path) -> Result<Self, WriteError> {
        let file = tempfile::tempfile_in(folder(path)).map_err(io_error(path))?;
        Ok(Self {
            file: Mutex::new(file),
            tiles: Vec::new(),
            end: 0,
            path: None,
        })
    }

    fn begin(&mut self, key: &[u8; 32]) -> io::Result<()> {
        let file = self.file.get_mut();
        file.set_len(0)?;
        file.seek(SeekFrom::Start(0))?;
        file.write_all(MAGIC)?;
        file.write_all(key)
    }

    /// Counts the whole tiles and drops what follows them.
    fn take_up(&mut self, most_tiles: usize) -> io::Result<()> {
        let file = self.file.get_mut();
        file.seek(SeekFrom::Start(HEAD_BYTES))?;
        let mut reader = BufReader::with_capacity(1 << 20, &mut *file);
        let mut frame = [0; FRAME_BYTES as usize];
        let mut tile = Vec::new();
        while self.tiles.len() < most_tiles && reader.read_exact(&mut frame).is_ok() {
            let [a, b, c, d, check @ ..] = frame;
            let length = u32::from_le_bytes([a, b, c, d]);
            if length > MOST_TILE_BYTES {
                break;
            }
            tile.resize(length as usize, 0);
            if reader.read_exact(&mut tile).is_err() || check_of(&tile) != check {
                break;
            }
            self.tiles.push((self.end + FRAME_BYTES, length));
            self.end += FRAME_BYTES + u64::from(length);
        }
        file.set_len(self.end)?;
        tracing::info!("goes on after {} of {most_tiles} tiles", self.tiles.len());
        Ok(())
    }

    /// Tiles so far.
    pub(super) fn count(&self) -> usize {
        self.tiles.len()
    }

    /// Length of a tile.
    pub(super) fn length(&self, number: usize) -> u64 {
        self.tiles[number].1.into()
    }

    /// Adds tiles.
    pub(super) fn append(&mut self, tiles: &[Vec<u8>]) -> io::Result<()> {
        let file = self.file.get_mut();
        file.seek(SeekFrom::Start(self.end))?;
        let mut bytes = Vec::new();
        for tile in tiles {
            bytes.clear();
            let length = u32::try_from(tile.len()).map_err(io::Error::other)?;
            bytes.extend(length.to_le_bytes());
            bytes.extend(check_of(tile));
            bytes.extend(tile);
            file.write_all(&bytes)?;
            self.tiles.push((self.end + FRAME_BYTES, length));
            self.end += bytes.len() as u64;
        }
        Ok(())
    }

    /// The bytes of a tile.
    pub(super) fn read(&self, number: usize) -> io::Result<Vec<u8>> {
        let (at, length) = self.tiles[number];
        let mut bytes = vec![0; length as usize];
        let mut file = self.file.lock();
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Takes the kept file away: the image is whole.
    pub(super) fn remove(self) {
        if let Some(path) = self.path
            && let Err(error) = std::fs::remove_file(&path)
        {
            tracing::warn!("the partial file {path:?} stays behind: {error}");
        }
    }
}

/// Names everything that decides the bytes.
fn key(layout: &CogLayout, request: [u8; 32]) -> [u8; 32] {
    let CogLayout {
        width,
        height,
        samples,
        tile,
        ..
    } = layout;
    let mut hash = blake3::Hasher::new();
    // Where the image lies is written at the end and decides no tile.
    hash.update(format!("{width} {height} {samples:?} {tile}").as_bytes());
    hash.update(&request);
    *hash.finalize().as_bytes()
}

fn check_of(tile: &[u8]) -> [u8; 8] {
    let hash = blake3::hash(tile);
    let mut check = [0; 8];
    check.copy_from_slice(&hash.as_bytes()[..8]);
    check
}
