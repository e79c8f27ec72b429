//! Workers, the manager that resolves what they need, and the door to both.

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex};
use relievo_graph::{ContentId, Graph, NodeIndex, RenderError};
use relievo_planet::{MapPoint, TileKey};
use relievo_raster::{Cancel, Tile};
use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::cache::{Cache, TileState};
use crate::log::LogEntry;
use crate::queue::{Inputs, Job, Queue};

/// How a [`Tiles`] works.
pub struct TilesOptions {
    /// Worker threads, at least 1.
    pub threads: usize,
    /// Bound of the cache in bytes.
    pub memory: usize,
    /// Whether [`Tiles::take_log`] records.
    pub log: bool,
    /// Called from a worker after each tile that somebody wants, for a window to wake up.
    pub wake: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Default for TilesOptions {
    /// All cores but one, 1 GiB.
    fn default() -> Self {
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        Self {
            threads: (cores - 1).max(1),
            memory: 1 << 30,
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
    inbox: Option<(Vec<Want>, MapPoint)>,
    managing: bool,
    finished: Vec<Finished>,
    log: Vec<LogEntry>,
    stats: Stats,
    closing: bool,
}

struct Shared {
    state: Mutex<State>,
    /// Signals the manager: wants came.
    asked: Condvar,
    /// Signals workers: tasks can run.
    work: Condvar,
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
}

impl Tiles {
    /// Starts the threads.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(options: TilesOptions) -> std::io::Result<Self> {
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
            }),
            asked: Condvar::new(),
            work: Condvar::new(),
            progress: Condvar::new(),
            cancel: Cancel::default(),
            log: options.log,
            wake: options.wake,
            busy_ns: AtomicU64::new(0),
        });
        let mut tiles = Self {
            shared,
            threads: Vec::new(),
        };
        tiles.spawn("relievo-manager".to_owned(), Shared::manage)?;
        for n in 0..options.threads.max(1) {
            tiles.spawn(format!("relievo-worker-{n}"), |shared| {
                // Refused in some sandboxes; the work is the same, only less polite.
                if let Err(error) = set_current_thread_priority(below_normal()) {
                    tracing::debug!("workers keep their priority: {error:?}");
                }
                shared.work_on();
            })?;
        }
        Ok(tiles)
    }

    fn spawn(
        &mut self,
        name: String,
        body: impl FnOnce(&Shared) + Send + 'static,
    ) -> std::io::Result<()> {
        let shared = Arc::clone(&self.shared);
        self.threads.push(
            std::thread::Builder::new()
                .name(name)
                .spawn(move || body(&shared))?,
        );
        Ok(())
    }

    /// Replaces what is wanted, most urgent first. Tasks that nobody wants any more are dropped,
    /// running ones finish. Returns at once.
    pub fn want(&self, wants: Vec<Want>, focus: MapPoint) {
        let mut state = self.shared.state.lock();
        state.inbox = Some((wants, focus));
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
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a tile thread ended by a panic");
            }
        }
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
    let tile_of = |node, key| Arc::clone(&inputs[&(node, key)]);
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

    /// Adds the task for `job` and for everything it depends on, depth first, each id once.
    fn resolve(&mut self, job: Job) {
        if self.cache.contains(job.id) || self.queue.contains(job.id) {
            return;
        }
        let mut inputs = Inputs::default();
        let mut missing = Vec::new();
        for (node, key) in job.graph.dependencies(job.node, job.key) {
            let id = job.graph.content_id(node, key);
            if let Some(TileState::Ready(tile)) = self.cache.get(id) {
                inputs.insert((node, key), tile);
                continue;
            }
            self.resolve(Job {
                graph: Arc::clone(&job.graph),
                node,
                key,
                id,
            });
            if let Some(TileState::Failed(error)) = self.cache.get(id) {
                self.fail(&job, &error);
                return;
            }
            missing.push((id, (node, key)));
        }
        self.queue.add(job, inputs, &missing);
    }

    fn fail(&mut self, job: &Job, error: &Arc<RenderError>) {
        self.stats.failed += 1;
        self.done(job, &TileState::Failed(Arc::clone(error)), Duration::ZERO);
    }

    /// Stores a result, tells who wants it and who reads it.
    fn done(&mut self, job: &Job, state: &TileState, cost: Duration) {
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
            TileState::Ready(tile) => self.queue.finish(job.id, Some(tile)),
            TileState::Failed(_) => self.queue.finish(job.id, None),
        };
        if let TileState::Failed(error) = state {
            for reader in lost {
                self.fail(&reader, error);
            }
        }
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
            let wanted: HashSet<_> = wants.iter().map(|w| w.id).collect();
            state.cache.set_wanted(|id| wanted.contains(&id), focus);
            state.wanted = wanted;
            let mut told = HashSet::new();
            for want in wants {
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
                state.resolve(Job {
                    graph,
                    node,
                    key,
                    id,
                });
                self.work.notify_one();
                // Others must get the lock between two wants, or drawing would stall on a long list.
                parking_lot::MutexGuard::bump(&mut state);
            }
            state.managing = false;
            self.progress.notify_all();
            self.work.notify_all();
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
                self.work.wait(&mut state);
                continue;
            };
            if state.closing {
                return;
            }
            drop(state);
            let started = Instant::now();
            let result = make(&job, &inputs, &self.cancel);
            let cost = started.elapsed();
            self.busy_ns
                .fetch_add(cost.as_nanos() as u64, Ordering::Relaxed);
            state = self.state.lock();
            self.store(&mut state, &job, result, cost);
            self.progress.notify_all();
            self.work.notify_all();
            parking_lot::MutexGuard::unlocked(&mut state, || self.wake());
        }
    }

    fn store(
        &self,
        state: &mut State,
        job: &Job,
        result: Result<Tile, RenderError>,
        cost: Duration,
    ) {
        let ready = result.is_ok();
        let outcome = match result {
            Ok(tile) => {
                state.stats.made += 1;
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
                node: job.node,
                kind,
                key: job.key,
                id: job.id,
                ready,
                cost,
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
