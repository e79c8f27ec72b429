//! What the threads share, and what becomes of it when something is wanted, finished or fails.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::{ContentId, RenderError};
use relievo_raster::Tile;

use super::{Finished, Stats, Want};
use crate::cache::{Cache, Cost, Focus, TileState};
use crate::disk::Shelf;
use crate::log::LogEntry;
use crate::queue::{Inputs, Job, Queue, Rank};
use crate::reads::Reads;
use crate::storing::Storing;

/// A tile that is only read by others is stored if it cost so many times more than one that is
/// shown: on reopening it is not needed.
const INPUT_FACTOR: u32 = 4;

/// What all threads share, under one lock.
pub(super) struct State {
    pub(super) queue: Queue,
    pub(super) cache: Cache,
    /// What the latest call of `want` named.
    pub(super) wanted: HashSet<ContentId>,
    /// Wants that the manager has not looked at yet.
    pub(super) inbox: Option<(Vec<Want>, Focus)>,
    /// What nobody will want again.
    pub(super) forgotten: Vec<ContentId>,
    pub(super) managing: bool,
    pub(super) finished: Vec<Finished>,
    pub(super) log: Vec<LogEntry>,
    pub(super) stats: Stats,
    pub(super) closing: bool,
    pub(super) storing: Storing,
    pub(super) reads: Reads,
    /// Least cost of a tile that is stored; `None` without a disk.
    pub(super) dear: Option<Duration>,
    pub(super) disk: Option<Arc<dyn Shelf>>,
}

impl State {
    /// Nothing is wanted yet. `memory` bounds the cache in bytes; what costs at least `dear` is stored once
    /// nothing was done for `calm`.
    pub(super) fn new(
        memory: usize,
        calm: Duration,
        dear: Option<Duration>,
        disk: Option<Arc<dyn Shelf>>,
    ) -> Self {
        Self {
            queue: Queue::default(),
            cache: Cache::new(memory),
            wanted: HashSet::new(),
            inbox: None,
            forgotten: Vec::new(),
            managing: false,
            finished: Vec::new(),
            log: Vec::new(),
            stats: Stats::default(),
            closing: false,
            storing: Storing::new(calm),
            reads: Reads::default(),
            dear,
            disk,
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        self.inbox.is_none() && !self.managing && self.queue.len() == 0
    }

    /// Adds the task for `job` and for everything it depends on, depth first, each id once. What may
    /// lie on disk is looked for there, and needs nothing else.
    pub(super) fn resolve(&mut self, job: Job, rank: Rank) {
        if self.cache.contains(job.id) || self.queue.contains(job.id) {
            return;
        }
        if self.disk.as_ref().is_some_and(|d| d.may_have(job.id)) {
            self.queue.add_load(job, rank);
        } else {
            self.resolve_making(job, rank);
        }
    }

    pub(super) fn resolve_making(&mut self, job: Job, rank: Rank) {
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
    pub(super) fn done(&mut self, job: &Job, state: &TileState, cost: Cost) {
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
    pub(super) fn is_dear(&self, id: ContentId, tile: &Tile, cost: Cost) -> bool {
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
