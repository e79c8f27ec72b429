//! A folder of stored tiles: one file a tile, in 256 folders by the first byte of its name.
//!
//! A file's modification time is its claim to stay: the time of its last use, and half a day on top
//! for each doubling of what it cost above a millisecond. So the order in which files go needs no
//! index that programs would have to share: the oldest first. (This is the rule of *greedy dual*
//! caches with the clock on the wall for their clock.)

use std::collections::HashSet;
use std::fs::{self, File, FileTimes};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use parking_lot::Mutex;
use relievo_graph::ContentId;
use relievo_raster::Tile;

use super::entry::{LARGEST, decode, encode, maker};
use super::{Loaded, Shelf};

/// Claim for each doubling of the cost.
const CLAIM: Duration = Duration::from_hours(12);

/// Doublings that count: a second and more is as dear as can be.
const MOST_DOUBLINGS: u32 = 10;

/// A claim is renewed when it has become so much older than it could be.
const RENEW: Duration = Duration::from_hours(1);

/// Prefix of files that are being written.
const UNFINISHED: &str = ".new-";

/// Files begun by this program: two folders of one program may be the same, so they count together.
static UNFINISHED_FILES: AtomicU64 = AtomicU64::new(0);

/// Unfinished files of programs that ended early are removed after this.
const ABANDONED: Duration = Duration::from_hours(1);

/// Name of a stored tile.
type Name = [u8; 32];

/// A folder of stored tiles.
pub(crate) struct Folder {
    root: PathBuf,
    bound: u64,
    maker: [u8; 32],
    /// Names that are there, as far as this program knows; `None` until it has looked.
    known: Mutex<Option<HashSet<Name>>>,
    /// Bytes that may be written before the folder is measured again.
    room: AtomicU64,
    /// Whether writing failed.
    full: AtomicBool,
}

/// A stored tile as the folder lists it.
struct Listed {
    path: PathBuf,
    bytes: u64,
    claim: SystemTime,
}

impl Folder {
    /// Tiles in `tiles-1` below a folder; nothing is read or made yet.
    pub(crate) fn new(folder: &Path, bound: u64) -> Self {
        Self {
            root: folder.join("tiles-1"),
            bound,
            maker: maker(),
            known: Mutex::new(None),
            room: AtomicU64::new(0),
            full: AtomicBool::new(bound == 0),
        }
    }

    /// The name under which a tile lies: other makers' tiles have others, and age beside it.
    fn name(&self, id: ContentId) -> Name {
        let mut hash = blake3::Hasher::new();
        hash.update(&self.maker).update(&id.0);
        *hash.finalize().as_bytes()
    }

    fn path(&self, name: &Name) -> PathBuf {
        let hex = blake3::Hash::from_bytes(*name).to_hex();
        self.root.join(&hex[..2]).join(&hex[2..])
    }

    fn forget(&self, name: &Name) {
        if let Some(known) = &mut *self.known.lock() {
            known.remove(name);
        }
    }

    /// Reads an entry's bytes and renews its claim; `None` if there is none.
    fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
        let mut file = match File::open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let facts = file.metadata()?;
        if !facts.is_file() || facts.len() > LARGEST as u64 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let mut bytes = Vec::with_capacity(facts.len() as usize + 1);
        // A file that grows meanwhile is not read for ever.
        (&mut file)
            .take(LARGEST as u64 + 1)
            .read_to_end(&mut bytes)?;
        Ok(Some(bytes))
    }

    fn renew(path: &Path, cost: Duration) {
        let claim = claim(cost);
        let renewed = || -> io::Result<()> {
            let modified = path.metadata()?.modified()?;
            if claim.duration_since(modified).is_ok_and(|d| d > RENEW) {
                let file = File::options().write(true).open(path)?;
                file.set_times(FileTimes::new().set_modified(claim))?;
            }
            Ok(())
        };
        if let Err(error) = renewed() {
            tracing::debug!("cannot renew {path:?}: {error}");
        }
    }

    fn write(&self, name: &Name, bytes: &[u8], cost: Duration) -> io::Result<()> {
        let path = self.path(name);
        let shard = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(shard)?;
        let n = UNFINISHED_FILES.fetch_add(1, Ordering::Relaxed);
        let unfinished = shard.join(format!("{UNFINISHED}{}-{n}", std::process::id()));
        let written = || -> io::Result<()> {
            let mut file = File::options()
                .write(true)
                .create_new(true)
                .open(&unfinished)?;
            file.write_all(bytes)?;
            file.set_times(FileTimes::new().set_modified(claim(cost)))?;
            drop(file);
            // Not synced: after a crash a checksum that is wrong costs one tile.
            fs::rename(&unfinished, &path)
        };
        written().inspect_err(|_| {
            if let Err(error) = fs::remove_file(&unfinished) {
                tracing::debug!("cannot remove {unfinished:?}: {error}");
            }
        })
    }

    /// Makes room for `bytes`, looking at the folder as it is now if that may be needed.
    fn make_room(&self, bytes: u64) -> io::Result<()> {
        let left = self.room.load(Ordering::Relaxed);
        if let Some(left) = left.checked_sub(bytes) {
            self.room.store(left, Ordering::Relaxed);
            return Ok(());
        }
        let mut all = self.measure()?;
        let mut used: u64 = all.iter().map(|e| e.bytes).sum();
        if used + bytes > self.bound {
            all.sort_by(|a, b| a.claim.cmp(&b.claim).then_with(|| a.path.cmp(&b.path)));
            let target = (self.bound - self.bound / 8).saturating_sub(bytes);
            for entry in all {
                if used <= target {
                    break;
                }
                fs::remove_file(&entry.path).or_else(unless_gone)?;
                used -= entry.bytes;
                if let Some(name) = name_of(&entry.path) {
                    self.forget(&name);
                }
            }
        }
        // Others may be writing, too: look again before long.
        let room = (self.bound - used.min(self.bound)).min(self.bound / 16);
        self.room
            .store(room.saturating_sub(bytes), Ordering::Relaxed);
        Ok(())
    }

    /// All stored tiles; removes what was left unfinished.
    fn measure(&self) -> io::Result<Vec<Listed>> {
        let mut all = Vec::new();
        self.each(|file| {
            // A file that is gone by now was another program's to remove.
            let Ok(facts) = file.metadata() else { return };
            let claim = facts.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            let path = file.path();
            if name_of(&path).is_some() && facts.is_file() {
                all.push(Listed {
                    path,
                    bytes: facts.len(),
                    claim,
                });
            } else if file.file_name().to_string_lossy().starts_with(UNFINISHED)
                && claim.elapsed().is_ok_and(|age| age > ABANDONED)
                && let Err(error) = fs::remove_file(&path)
            {
                tracing::debug!("cannot remove {path:?}: {error}");
            }
        })?;
        Ok(all)
    }

    /// Calls `each` for every file in the 256 folders.
    fn each(&self, mut each: impl FnMut(&fs::DirEntry)) -> io::Result<()> {
        for shard in 0..=255_u8 {
            let files = match fs::read_dir(self.root.join(format!("{shard:02x}"))) {
                Ok(files) => files,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(error),
            };
            for file in files {
                each(&file?);
            }
        }
        Ok(())
    }

    fn turn_off(&self, error: &io::Error) {
        if !self.full.swap(true, Ordering::Relaxed) {
            let root = self.root.display();
            tracing::warn!("finished tiles are not kept on disk any more: {error}: {root}");
        }
    }
}

impl Shelf for Folder {
    fn list(&self) {
        let mut names = HashSet::new();
        let listed = self.each(|file| {
            names.extend(name_of(&file.path()));
        });
        if let Err(error) = listed {
            self.turn_off(&error);
        }
        // What was written meanwhile may be missing here: it is in memory anyway.
        *self.known.lock() = Some(names);
    }

    fn may_have(&self, id: ContentId) -> bool {
        self.known
            .lock()
            .as_ref()
            .is_none_or(|known| known.contains(&self.name(id)))
    }

    fn load(&self, id: ContentId) -> Option<Loaded> {
        let name = self.name(id);
        let path = self.path(&name);
        let loaded = match Self::read(&path) {
            Ok(None) => None,
            Ok(Some(bytes)) => {
                let loaded = decode(&bytes, id, &self.maker);
                if loaded.is_none() {
                    tracing::debug!("removing a damaged tile: {path:?}");
                    if let Err(error) = fs::remove_file(&path).or_else(unless_gone) {
                        self.turn_off(&error);
                    }
                }
                loaded
            }
            Err(error) => {
                tracing::debug!("cannot read {path:?}: {error}");
                None
            }
        };
        match &loaded {
            Some(loaded) => Self::renew(&path, loaded.cost),
            None => self.forget(&name),
        }
        loaded
    }

    fn save(&self, id: ContentId, tile: &Tile, cost: Duration) -> bool {
        if self.full.load(Ordering::Relaxed) {
            return false;
        }
        let name = self.name(id);
        let bytes = encode(id, tile, cost, &self.maker);
        let length = bytes.len() as u64;
        if length > self.bound {
            return false;
        }
        let saved = self
            .make_room(length)
            .and_then(|()| self.write(&name, &bytes, cost));
        match saved {
            Ok(()) => {
                if let Some(known) = &mut *self.known.lock() {
                    known.insert(name);
                }
                true
            }
            Err(error) => {
                self.turn_off(&error);
                false
            }
        }
    }
}

/// How long a tile of this cost may stay, counted from now.
fn claim(cost: Duration) -> SystemTime {
    let milliseconds = u64::try_from(cost.as_millis()).unwrap_or(u64::MAX);
    let doublings = milliseconds.max(1).ilog2().min(MOST_DOUBLINGS);
    SystemTime::now() + CLAIM * doublings
}

fn unless_gone(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::NotFound {
        Ok(())
    } else {
        Err(error)
    }
}

/// The name behind a path, if the path is one of [`Folder::path`].
fn name_of(path: &Path) -> Option<Name> {
    let rest = path.file_name()?.to_str()?;
    let shard = path.parent()?.file_name()?.to_str()?;
    if shard.len() != 2 || rest.len() != 62 {
        return None;
    }
    let hash = blake3::Hash::from_hex(format!("{shard}{rest}")).ok()?;
    Some(*hash.as_bytes())
}

#[cfg(test)]
mod tests;
