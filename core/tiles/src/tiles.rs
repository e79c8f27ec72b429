//! The door to cache, manager and workers: what is wanted, what is finished, and the threads between them.

mod manager;
mod on_disk;
mod state;
mod workers;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};
use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::TileKey;
use relievo_raster::Cancel;
use thread_priority::set_current_thread_priority;

use self::state::State;
use self::workers::below_normal;
use crate::cache::{Focus, TileState};
use crate::disk::{DiskOptions, Folder, Shelf};
use crate::log::LogEntry;

/// Threads that read finished tiles from disk: one would idle while the disk seeks.
const READERS: usize = 2;

/// Longest time that closing waits for tiles to be written.
const CLOSING: Duration = Duration::from_secs(2);

/// How a [`Tiles`] works.
pub struct TilesOptions {
    /// Worker threads, at least 1.
    pub threads: usize,
    /// Bound of the cache in bytes.
    pub memory: usize,
    /// Where tiles are kept from run to run; `None`: nowhere.
    pub disk: Option<DiskOptions>,
    /// Whether [`Tiles::take_log`] records.
    pub log: bool,
    /// Called from a worker after each tile that somebody wants, for a window to wake up.
    pub wake: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Default for TilesOptions {
    /// All cores but one, 1 GiB, nothing on disk.
    fn default() -> Self {
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        Self {
            threads: (cores - 1).max(1),
            memory: 1 << 30,
            disk: None,
            log: false,
            wake: None,
        }
    }
}

/// One tile that somebody wants.
#[derive(Clone)]
pub struct Want {
    /// The graph that makes it.
    pub graph: Arc<Graph>,
    /// The cut point.
    pub node: NodeIndex,
    /// The tile.
    pub key: TileKey,
    /// `graph.content_id(node, key)`.
    pub id: ContentId,
}

/// A tile that is done.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its name.
    pub id: ContentId,
    /// What became of it.
    pub state: TileState,
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Tiles made, inputs included.
    pub made: u64,
    /// Tiles read from disk instead.
    pub loaded: u64,
    /// Tiles written to disk.
    pub stored: u64,
    /// Tiles that could not be made.
    pub failed: u64,
    /// Made although nobody wanted them any more when they were done.
    pub in_vain: u64,
    /// Removed from the cache to make room.
    pub evicted: u64,
    /// Bytes in the cache.
    pub cache_bytes: usize,
    /// Tasks that wait or run.
    pub pending: usize,
}

struct Shared {
    state: Mutex<State>,
    /// Signals the manager: wants came.
    asked: Condvar,
    /// Signals workers: tasks can run.
    work: Condvar,
    /// Signals readers: tiles can be read from disk.
    read: Condvar,
    /// Signals the writer: there may be something to write.
    write: Condvar,
    /// Signals who closes: the writer is done.
    written: Condvar,
    /// Signals waiters: something finished or the manager is done.
    progress: Condvar,
    cancel: Cancel,
    log: bool,
    wake: Option<Box<dyn Fn() + Send + Sync>>,
    /// Nanoseconds workers spent making tiles.
    busy_ns: AtomicU64,
}

/// Cache, manager and workers. Dropping it asks running work to stop and waits for it.
pub struct Tiles {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// Threads that the disk may hold up, the writer last.
    on_disk: Vec<JoinHandle<()>>,
}

impl Tiles {
    /// Starts the threads.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(options: TilesOptions) -> std::io::Result<Self> {
        let disk = options.disk.as_ref().map(|disk| {
            let folder = Folder::new(&disk.folder, disk.bytes);
            (Arc::new(folder) as Arc<dyn Shelf>, disk.dear, disk.calm)
        });
        Self::with_shelf(options, disk)
    }

    fn with_shelf(
        options: TilesOptions,
        disk: Option<(Arc<dyn Shelf>, Duration, Duration)>,
    ) -> std::io::Result<Self> {
        let has_disk = disk.is_some();
        let calm = disk.as_ref().map_or(Duration::ZERO, |d| d.2);
        let (disk, dear) = disk.map(|d| (d.0, d.1)).unzip();
        let shared = Arc::new(Shared {
            state: Mutex::new(State::new(options.memory, calm, dear, disk)),
            asked: Condvar::new(),
            work: Condvar::new(),
            read: Condvar::new(),
            write: Condvar::new(),
            written: Condvar::new(),
            progress: Condvar::new(),
            cancel: Cancel::default(),
            log: options.log,
            wake: options.wake,
            busy_ns: AtomicU64::new(0),
        });
        let mut tiles = Self {
            shared,
            threads: Vec::new(),
            on_disk: Vec::new(),
        };
        let manager = tiles.spawn("relievo-manager".to_owned(), Shared::manage)?;
        tiles.threads.push(manager);
        for n in 0..options.threads.max(1) {
            let worker = tiles.spawn(format!("relievo-worker-{n}"), |shared| {
                // Refused in some sandboxes; the work is the same, only less polite.
                if let Err(error) = set_current_thread_priority(below_normal()) {
                    tracing::debug!("workers keep their priority: {error:?}");
                }
                shared.work_on();
            })?;
            tiles.threads.push(worker);
        }
        if has_disk {
            for n in 0..READERS {
                let reader = tiles.spawn(format!("relievo-disk-reader-{n}"), move |shared| {
                    shared.read_on(n == 0);
                })?;
                tiles.on_disk.push(reader);
            }
            let writer = tiles.spawn("relievo-disk-writer".to_owned(), |shared| {
                shared.write_on();
                shared.state.lock().disk = None;
                shared.written.notify_all();
            })?;
            tiles.on_disk.push(writer);
        }
        Ok(tiles)
    }

    fn spawn(
        &self,
        name: String,
        body: impl FnOnce(&Shared) + Send + 'static,
    ) -> std::io::Result<JoinHandle<()>> {
        let shared = Arc::clone(&self.shared);
        std::thread::Builder::new()
            .name(name)
            .spawn(move || body(&shared))
    }

    /// Replaces what is wanted, most urgent first. Tasks that nobody wants any more are dropped,
    /// running ones finish. Returns at once.
    pub fn want(&self, wants: Vec<Want>, focus: impl Into<Focus>) {
        let mut state = self.shared.state.lock();
        state.inbox = Some((wants, focus.into()));
        drop(state);
        self.shared.asked.notify_one();
    }

    /// Says that nobody will want some tiles again: they go before anything else, with the next wants.
    pub fn forget(&self, tiles: impl IntoIterator<Item = ContentId>) {
        self.shared.state.lock().forgotten.extend(tiles);
    }

    /// The state of a tile, if the cache has it.
    pub fn get(&self, id: ContentId) -> Option<TileState> {
        self.shared.state.lock().cache.get(id)
    }

    /// Everything wanted that was finished since the last call, in order of completion. What the
    /// cache had already when it was wanted comes too.
    pub fn take_finished(&self) -> Vec<Finished> {
        std::mem::take(&mut self.shared.state.lock().finished)
    }

    /// Waits until something finishes, all is done, or the time is over; `true` once nothing waits
    /// or runs. For offline work: never call it on a thread that draws.
    pub fn wait(&self, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        let mut state = self.shared.state.lock();
        loop {
            if state.is_idle() {
                return true;
            }
            if !state.finished.is_empty()
                || self
                    .shared
                    .progress
                    .wait_until(&mut state, deadline)
                    .timed_out()
            {
                return state.is_idle();
            }
        }
    }

    /// Tries tiles again that could not be made.
    pub fn forget_failures(&self) {
        self.shared.state.lock().cache.forget_failures();
    }

    /// What was made since the last call; empty unless [`TilesOptions::log`].
    pub fn take_log(&self) -> Vec<LogEntry> {
        std::mem::take(&mut self.shared.state.lock().log)
    }

    /// Counts since the start.
    pub fn stats(&self) -> Stats {
        let state = self.shared.state.lock();
        Stats {
            evicted: state.cache.evicted(),
            cache_bytes: state.cache.used(),
            pending: state.queue.len(),
            ..state.stats
        }
    }

    /// Time that all workers together spent making tiles.
    pub fn busy(&self) -> Duration {
        Duration::from_nanos(self.shared.busy_ns.load(Ordering::Relaxed))
    }
}

impl Drop for Tiles {
    fn drop(&mut self) {
        self.shared.state.lock().closing = true;
        self.shared.cancel.cancel();
        self.shared.asked.notify_all();
        self.shared.work.notify_all();
        self.shared.read.notify_all();
        self.shared.write.notify_all();
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a tile thread ended by a panic");
            }
        }
        // A disk that does not answer must not keep a window from closing.
        let deadline = Instant::now() + CLOSING;
        let mut state = self.shared.state.lock();
        while state.disk.is_some()
            && !self.on_disk.last().is_some_and(JoinHandle::is_finished)
            && !self
                .shared
                .written
                .wait_until(&mut state, deadline)
                .timed_out()
        {}
    }
}

impl Shared {
    /// Tells everybody that something finished.
    fn tell(&self, state: &mut MutexGuard<State>) {
        self.progress.notify_all();
        self.work.notify_all();
        self.read.notify_all();
        self.write.notify_one();
        MutexGuard::unlocked(state, || self.wake());
    }

    fn wake(&self) {
        if let Some(wake) = &self.wake {
            wake();
        }
    }
}

#[cfg(test)]
mod tests;
