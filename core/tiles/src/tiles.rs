//! Workers, the manager that resolves what they need, and the door to both.

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};
use relievo_graph::{ContentId, Graph, NodeIndex, RenderError};
use relievo_planet::TileKey;
use relievo_raster::{Cancel, Tile};
use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::cache::{Cache, Cost, Focus, TileState};
use crate::disk::{DiskOptions, Folder, Shelf};
use crate::log::LogEntry;
use crate::queue::{Inputs, Job, Queue, Rank};
use crate::reads::Reads;
use crate::storing::Storing;

/// Threads that read finished tiles from disk: one would idle while the disk seeks.
const READERS: usize = 2;

/// A tile that the disk has not given after this is made instead.
const PATIENCE: Duration = Duration::from_millis(100);

/// A tile that is only read by others is stored if it cost so many times more than one that is
/// shown: on reopening it is not needed.
const INPUT_FACTOR: u32 = 4;

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

struct State {
    queue: Queue,
    cache: Cache,
    /// What the latest call of `want` named.
    wanted: HashSet<ContentId>,
    /// Wants that the manager has not looked at yet.
    inbox: Option<(Vec<Want>, Focus)>,
    managing: bool,
    finished: Vec<Finished>,
    log: Vec<LogEntry>,
    stats: Stats,
    closing: bool,
    storing: Storing,
    reads: Reads,
    /// Least cost of a tile that is stored; `None` without a disk.
    dear: Option<Duration>,
    disk: Option<Arc<dyn Shelf>>,
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
            state: Mutex::new(State {
                queue: Queue::default(),
                cache: Cache::new(options.memory),
                wanted: HashSet::new(),
                inbox: None,
                managing: false,
                finished: Vec::new(),
                log: Vec::new(),
                stats: Stats::default(),
                closing: false,
                storing: Storing::new(calm),
                reads: Reads::default(),
                dear,
                disk,
            }),
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

/// A little below normal: drawing comes first, but where the processor draws, too, the lowest
/// priority would leave nothing for tiles at all.
fn below_normal() -> ThreadPriority {
    ThreadPriorityValue::try_from(40).map_or(ThreadPriority::Min, ThreadPriority::Crossplatform)
}

/// Makes a tile. A panic in a node is a bug, but one tile's: it must not take a worker with it and
/// leave everybody waiting.
fn make(job: &Job, inputs: &Inputs, cancel: &Cancel) -> Result<Tile, RenderError> {
    let tile_of = |node, key| Arc::clone(&inputs.tiles[&(node, key)]);
    let made = catch_unwind(AssertUnwindSafe(|| {
        job.graph.make(job.node, job.key, &tile_of, cancel)
    }));
    made.unwrap_or_else(|_| {
        Err(RenderError::Node {
            node: job.graph.node(job.node).kind(),
            reason: format!("panicked while making tile {}; this is a bug", job.key),
        })
    })
}

impl State {
    fn is_idle(&self) -> bool {
        self.inbox.is_none() && !self.managing && self.queue.len() == 0
    }

    /// Adds the task for `job` and for everything it depends on, depth first, each id once. What may
    /// lie on disk is looked for there, and needs nothing else.
    fn resolve(&mut self, job: Job, rank: Rank) {
        if self.cache.contains(job.id) || self.queue.contains(job.id) {
            return;
        }
        if self.disk.as_ref().is_some_and(|d| d.may_have(job.id)) {
            self.queue.add_load(job, rank);
        } else {
            self.resolve_making(job, rank);
        }
    }

    fn resolve_making(&mut self, job: Job, rank: Rank) {
        let mut inputs = Inputs::default();
        let mut missing = Vec::new();
        for &(node, key, id) in self.reads.of(&job).iter() {
            if let Some((TileState::Ready(tile), cost)) = self.cache.get_with_cost(id) {
                inputs.tiles.insert((node, key), tile);
                inputs.cost += cost;
                continue;
            }
            let input = Job {
                graph: Arc::clone(&job.graph),
                node,
                key,
                id,
            };
            self.resolve(input, rank);
            if let Some(TileState::Failed(error)) = self.cache.get(id) {
                self.fail(&job, &error);
                return;
            }
            missing.push((id, (node, key)));
        }
        self.queue.add(job, rank, inputs, &missing);
    }

    fn fail(&mut self, job: &Job, error: &Arc<RenderError>) {
        self.stats.failed += 1;
        self.done(job, &TileState::Failed(Arc::clone(error)), Cost::default());
    }

    /// Keeps a result, tells who wants it and who reads it.
    fn done(&mut self, job: &Job, state: &TileState, cost: Cost) {
        let wanted = self.wanted.contains(&job.id);
        if !wanted && !self.queue.is_read(job.id) {
            self.stats.in_vain += 1;
        }
        self.cache
            .insert(job.id, job.key, state.clone(), cost, wanted);
        if wanted {
            self.finished.push(Finished {
                id: job.id,
                state: state.clone(),
            });
        }
        let lost = match state {
            TileState::Ready(tile) => self.queue.finish(job.id, Some((tile, cost.whole))),
            TileState::Failed(_) => self.queue.finish(job.id, None),
        };
        if let TileState::Failed(error) = state {
            for reader in lost {
                self.fail(&reader, error);
            }
        }
    }

    /// Whether a tile that was just made is worth a place on disk.
    fn is_dear(&self, id: ContentId, tile: &Tile, cost: Cost) -> bool {
        let Some(dear) = self.dear else { return false };
        let factor = if self.wanted.contains(&id) {
            1
        } else {
            INPUT_FACTOR
        };
        // Larger tiles take longer to read, and take the place of others.
        let size = tile.memory().div_ceil(1 << 18) as u32;
        cost.whole >= dear * factor * size
    }
}

impl Shared {
    /// The manager: turns wants into tasks whenever they change.
    fn manage(&self) {
        let mut state = self.state.lock();
        loop {
            while state.inbox.is_none() && !state.closing {
                self.asked.wait(&mut state);
            }
            if state.closing {
                return;
            }
            let Some((wants, focus)) = state.inbox.take() else {
                continue;
            };
            state.managing = true;
            state.queue.clear();
            if let Some(want) = wants.first() {
                state.storing.follow(&want.graph);
            }
            let wanted: HashSet<_> = wants.iter().map(|w| w.id).collect();
            state.cache.set_wanted(|id| wanted.contains(&id), focus);
            state.wanted = wanted;
            let mut told = HashSet::new();
            for (rank, want) in wants.into_iter().enumerate() {
                if state.inbox.is_some() || state.closing {
                    break;
                }
                if !told.insert(want.id) {
                    continue;
                }
                if let Some(found) = state.cache.get(want.id) {
                    state.finished.push(Finished {
                        id: want.id,
                        state: found,
                    });
                    continue;
                }
                let Want {
                    graph,
                    node,
                    key,
                    id,
                } = want;
                let job = Job {
                    graph,
                    node,
                    key,
                    id,
                };
                state.resolve(job, rank as Rank);
                self.work.notify_one();
                if state.queue.is_loading() {
                    self.read.notify_one();
                }
                // Others must get the lock between two wants, or drawing would stall on a long list.
                MutexGuard::bump(&mut state);
            }
            state.managing = false;
            self.progress.notify_all();
            self.work.notify_all();
            self.read.notify_all();
            self.write.notify_one();
            self.wake();
        }
    }

    /// A worker: takes the first task that can run.
    fn work_on(&self) {
        let mut state = self.state.lock();
        loop {
            let Some((job, inputs)) = state.queue.start() else {
                if state.closing {
                    return;
                }
                if let Some((job, rank)) = state.queue.give_up_load(PATIENCE) {
                    state.resolve_making(job, rank);
                    self.work.notify_all();
                } else if state.queue.is_loading() {
                    self.work.wait_for(&mut state, PATIENCE);
                } else {
                    self.work.wait(&mut state);
                }
                continue;
            };
            if state.closing {
                return;
            }
            drop(state);
            let started = Instant::now();
            let result = make(&job, &inputs, &self.cancel);
            let own = started.elapsed();
            self.busy_ns
                .fetch_add(own.as_nanos() as u64, Ordering::Relaxed);
            let cost = Cost {
                own,
                whole: own + inputs.cost,
            };
            drop(inputs);
            state = self.state.lock();
            self.keep(&mut state, &job, result, cost);
            self.tell(&mut state);
        }
    }

    /// Tells everybody that something finished.
    fn tell(&self, state: &mut MutexGuard<State>) {
        self.progress.notify_all();
        self.work.notify_all();
        self.read.notify_all();
        self.write.notify_one();
        MutexGuard::unlocked(state, || self.wake());
    }

    /// A reader: takes the first tile that may lie on disk.
    fn read_on(&self, lists: bool) {
        let mut state = self.state.lock();
        let Some(disk) = state.disk.clone() else {
            return;
        };
        if lists {
            MutexGuard::unlocked(&mut state, || disk.list());
        }
        loop {
            if state.closing {
                return;
            }
            let Some(id) = state.queue.start_load() else {
                self.read.wait(&mut state);
                continue;
            };
            let started = Instant::now();
            let found = MutexGuard::unlocked(&mut state, || disk.load(id));
            let Some((job, rank)) = state.queue.end_load(id) else {
                continue;
            };
            match found {
                Some(loaded) => {
                    state.stats.loaded += 1;
                    let cost = Cost {
                        own: started.elapsed(),
                        whole: loaded.cost,
                    };
                    state.done(&job, &TileState::Ready(Arc::new(loaded.tile)), cost);
                }
                None if state.wanted.contains(&id) || state.queue.is_read(id) => {
                    state.resolve_making(job, rank);
                }
                None => {}
            }
            self.tell(&mut state);
        }
    }

    /// The writer: stores what was dear while nothing is wanted.
    fn write_on(&self) {
        let mut state = self.state.lock();
        let Some(disk) = state.disk.clone() else {
            return;
        };
        loop {
            let due = state.storing.due_in();
            match due {
                None if state.closing => return,
                Some(wait) if !state.closing && state.is_idle() && !wait.is_zero() => {
                    self.write.wait_for(&mut state, wait);
                    continue;
                }
                Some(_) if state.closing || state.is_idle() => {}
                _ => {
                    self.write.wait(&mut state);
                    continue;
                }
            }
            let Some((next, graph)) = state.storing.next() else {
                continue;
            };
            let Some(TileState::Ready(tile)) = state.cache.get(next.id()) else {
                continue;
            };
            let stored = MutexGuard::unlocked(&mut state, || {
                next.is_of(&graph) && disk.save(next.id(), &tile, next.cost)
            });
            state.stats.stored += u64::from(stored);
        }
    }

    fn keep(&self, state: &mut State, job: &Job, result: Result<Tile, RenderError>, cost: Cost) {
        let ready = result.is_ok();
        let outcome = match result {
            Ok(tile) => {
                state.stats.made += 1;
                if state.is_dear(job.id, &tile, cost) {
                    state.storing.add(job.clone(), cost.whole);
                }
                TileState::Ready(Arc::new(tile))
            }
            Err(RenderError::Cancelled) => {
                state.queue.finish(job.id, None);
                return;
            }
            Err(error) => {
                state.stats.failed += 1;
                tracing::warn!("tile {} failed: {error}", job.key);
                TileState::Failed(Arc::new(error))
            }
        };
        if self.log {
            let kind = job.graph.node(job.node).kind();
            state.log.push(LogEntry {
                graph: Arc::downgrade(&job.graph),
                node: job.node,
                kind,
                key: job.key,
                id: job.id,
                ready,
                cost: cost.own,
            });
        }
        state.done(job, &outcome, cost);
    }

    fn wake(&self) {
        if let Some(wake) = &self.wake {
            wake();
        }
    }
}

#[cfg(test)]
mod tests;
