//! Decoded chunks of files, shared by all files and threads, bounded in bytes.

use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use parking_lot::Mutex;

/// Independent parts, so that threads rarely meet at a lock.
const SHARDS: usize = 16;
/// Bytes of chunks kept that are too large for a shard: an image that is one compressed strip would
/// otherwise be decoded again for every rectangle that is read.
const LARGE_BYTES: u64 = 512 << 20;

/// Which chunk of which file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ChunkKey {
    /// From [`ChunkCache::new_file`].
    pub(crate) file: u64,
    /// Number of the image in the file.
    pub(crate) image: u32,
    /// Plane of a planar image, else 0.
    pub(crate) plane: u16,
    /// Column of the chunk.
    pub(crate) column: u32,
    /// Row of the chunk.
    pub(crate) row: u32,
}

/// What the cache holds for a chunk: nothing yet, or what decoding it gave (`None`: the file leaves
/// the chunk out).
type Slot<T> = Arc<Mutex<Option<Option<Arc<T>>>>>;

/// Decoded chunks up to a number of bytes. A chunk that many ask for at once is decoded once; those
/// that come second wait for it.
///
/// One cache may serve any number of files; by default all files opened with clones of the same
/// [`OpenOptions`](crate::open::OpenOptions) share one. Least recently used chunks go first. Chunks
/// larger than a shard's part of the budget are decoded one at a time and kept beside it, 512 MiB of
/// them at most.
pub struct ChunkCache {
    shards: [Mutex<Shard>; SHARDS],
    large: Mutex<Vec<Large>>,
    hasher: RandomState,
    shard_budget: usize,
    next_file: AtomicU64,
    decoded: AtomicU64,
}

/// A chunk that no shard can keep; the most recently used is the last.
struct Large {
    key: ChunkKey,
    chunk: Arc<super::geotiff::Chunk>,
    bytes: u64,
}

#[derive(Default)]
struct Shard {
    slots: HashMap<ChunkKey, Held>,
    /// Uses, oldest first; an entry counts only if its stamp is the chunk's last.
    uses: VecDeque<(ChunkKey, u64)>,
    bytes: usize,
    clock: u64,
}

struct Held {
    slot: Slot<super::geotiff::Chunk>,
    bytes: usize,
    last_use: u64,
}

impl ChunkCache {
    /// A cache of at most `budget_bytes` of decoded samples.
    pub fn new(budget_bytes: usize) -> Self {
        Self {
            shards: core::array::from_fn(|_| Mutex::default()),
            large: Mutex::default(),
            hasher: RandomState::new(),
            shard_budget: budget_bytes / SHARDS,
            next_file: AtomicU64::new(0),
            decoded: AtomicU64::new(0),
        }
    }

    /// Bytes of decoded samples held now.
    pub fn bytes(&self) -> usize {
        let small: usize = self.shards.iter().map(|shard| shard.lock().bytes).sum();
        let large: u64 = self.large.lock().iter().map(|l| l.bytes).sum();
        small + large as usize
    }

    /// Chunks decoded so far.
    pub fn decoded(&self) -> u64 {
        self.decoded.load(Ordering::Relaxed)
    }

    /// A number for a file that no other file of this cache has.
    pub(crate) fn new_file(&self) -> u64 {
        self.next_file.fetch_add(1, Ordering::Relaxed)
    }

    /// As [`ChunkCache::get`], for a chunk whose samples will take so many bytes.
    pub(crate) fn get_sized<E>(
        &self,
        key: ChunkKey,
        bytes: u64,
        decode: impl FnOnce() -> Result<Option<super::geotiff::Chunk>, E>,
    ) -> Result<Option<Arc<super::geotiff::Chunk>>, E> {
        if bytes > self.shard_budget as u64 {
            self.get_large(key, bytes, decode)
        } else {
            self.get(key, decode)
        }
    }

    /// The chunk, decoded by `decode` if it is not there. An error is not kept.
    pub(crate) fn get<E>(
        &self,
        key: ChunkKey,
        decode: impl FnOnce() -> Result<Option<super::geotiff::Chunk>, E>,
    ) -> Result<Option<Arc<super::geotiff::Chunk>>, E> {
        let shard = &self.shards[self.hasher.hash_one(key) as usize % SHARDS];
        let slot = shard.lock().touch(key);
        let mut content = slot.lock();
        if let Some(chunk) = &*content {
            return Ok(chunk.clone());
        }
        match decode() {
            Ok(chunk) => {
                self.decoded.fetch_add(1, Ordering::Relaxed);
                let chunk = chunk.map(Arc::new);
                *content = Some(chunk.clone());
                drop(content);
                let bytes = chunk.as_ref().map_or(0, |c| c.bytes());
                shard.lock().settle(key, &slot, bytes, self.shard_budget);
                Ok(chunk)
            }
            Err(error) => {
                drop(content);
                shard.lock().forget(key, &slot);
                Err(error)
            }
        }
    }

    /// The lock is held while a chunk is decoded: threads that ask for several at once would take
    /// several times the memory.
    fn get_large<E>(
        &self,
        key: ChunkKey,
        bytes: u64,
        decode: impl FnOnce() -> Result<Option<super::geotiff::Chunk>, E>,
    ) -> Result<Option<Arc<super::geotiff::Chunk>>, E> {
        let mut large = self.large.lock();
        if let Some(at) = large.iter().position(|l| l.key == key) {
            let found = large.remove(at);
            let chunk = Arc::clone(&found.chunk);
            large.push(found);
            return Ok(Some(chunk));
        }
        let mut kept: u64 = large.iter().map(|l| l.bytes).sum();
        while kept + bytes > LARGE_BYTES && !large.is_empty() {
            kept -= large.remove(0).bytes;
        }
        let decoded = decode()?;
        self.decoded.fetch_add(1, Ordering::Relaxed);
        Ok(decoded.map(|chunk| {
            let chunk = Arc::new(chunk);
            large.push(Large {
                key,
                chunk: Arc::clone(&chunk),
                bytes: bytes.max(chunk.bytes() as u64),
            });
            chunk
        }))
    }

    /// Forgets all chunks of a file that is closed.
    pub(crate) fn forget_file(&self, file: u64) {
        self.large.lock().retain(|l| l.key.file != file);
        for shard in &self.shards {
            let mut shard = shard.lock();
            shard.slots.retain(|key, _| key.file != file);
            shard.bytes = shard.slots.values().map(|held| held.bytes).sum();
        }
    }
}

impl Shard {
    /// The slot of a chunk, made if it is not there, and marked as used now.
    fn touch(&mut self, key: ChunkKey) -> Slot<super::geotiff::Chunk> {
        self.clock += 1;
        let held = self.slots.entry(key).or_insert_with(|| Held {
            slot: Slot::default(),
            bytes: 0,
            last_use: 0,
        });
        held.last_use = self.clock;
        let slot = Arc::clone(&held.slot);
        self.uses.push_back((key, self.clock));
        // Stale uses pile up while the same chunks are asked for again and again.
        if self.uses.len() > 64 + 4 * self.slots.len() {
            let slots = &self.slots;
            self.uses
                .retain(|(key, at)| slots.get(key).is_some_and(|held| held.last_use == *at));
        }
        slot
    }

    /// Counts a decoded chunk and makes room.
    fn settle(
        &mut self,
        key: ChunkKey,
        slot: &Slot<super::geotiff::Chunk>,
        bytes: usize,
        budget: usize,
    ) {
        let Some(held) = self
            .slots
            .get_mut(&key)
            .filter(|held| Arc::ptr_eq(&held.slot, slot))
        else {
            return;
        };
        // A chunk that the file leaves out still takes its entry.
        held.bytes = bytes.max(128);
        self.bytes += held.bytes;
        while self.bytes > budget {
            let Some((oldest, at)) = self.uses.pop_front() else {
                break;
            };
            let Some(held) = self.slots.get(&oldest).filter(|held| held.last_use == at) else {
                continue;
            };
            if held.bytes == 0 {
                // Being decoded just now; it will be settled in turn.
                self.uses.push_back((oldest, at));
                if self
                    .uses
                    .iter()
                    .all(|(key, _)| self.slots.get(key).is_none_or(|held| held.bytes == 0))
                {
                    break;
                }
                continue;
            }
            self.bytes -= held.bytes;
            self.slots.remove(&oldest);
        }
    }

    fn forget(&mut self, key: ChunkKey, slot: &Slot<super::geotiff::Chunk>) {
        if self
            .slots
            .get(&key)
            .is_some_and(|held| Arc::ptr_eq(&held.slot, slot))
        {
            self.slots.remove(&key);
        }
    }
}

impl core::fmt::Debug for ChunkCache {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("ChunkCache")
            .field("bytes", &self.bytes())
            .field("decoded", &self.decoded())
            .finish_non_exhaustive()
    }
}
