//! The task queue: which tasks wait, which can run, which run. Knows no threads.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::TileKey;
use relievo_raster::Tile;

/// One tile to make.
#[derive(Clone)]
pub(crate) struct Job {
    pub(crate) graph: Arc<Graph>,
    pub(crate) node: NodeIndex,
    pub(crate) key: TileKey,
    pub(crate) id: ContentId,
}

/// What a job reads, by the names it uses for it, and what it cost to make all of it.
#[derive(Default)]
pub(crate) struct Inputs {
    pub(crate) tiles: HashMap<(NodeIndex, TileKey), Arc<Tile>>,
    pub(crate) cost: Duration,
}

/// The want that a task serves, counted in the order of wants.
pub(crate) type Rank = u32;

/// Position of a task: its want's, and inputs before what reads them.
type Order = (Rank, u64);

struct Task {
    job: Job,
    order: Order,
    /// Inputs that are there already.
    inputs: Inputs,
    /// Inputs that are still being made.
    missing: usize,
}

/// A tile that lies on disk.
struct Load {
    job: Job,
    order: Order,
    /// When it was asked for; then when a reader took it.
    since: Instant,
    reading: bool,
}

/// A task that waits for an input, and the name it uses for it.
type Reader = (ContentId, (NodeIndex, TileKey));

/// All tasks. They run in the order in which the wants were given (coarse before fine, visible
/// before prefetched), each preceded by what it depends on.
#[derive(Default)]
pub(crate) struct Queue {
    tasks: HashMap<ContentId, Task>,
    ready: BTreeMap<Order, ContentId>,
    readers: HashMap<ContentId, Vec<Reader>>,
    running: HashSet<ContentId>,
    loads: HashMap<ContentId, Load>,
    to_load: BTreeMap<Order, ContentId>,
    added: u64,
}

impl Queue {
    /// Drops every task that does not run; running ones finish.
    pub(crate) fn clear(&mut self) {
        self.tasks.clear();
        self.ready.clear();
        self.readers.clear();
        self.to_load.clear();
        self.loads.retain(|_, load| load.reading);
    }

    /// Number of tasks that wait or run.
    pub(crate) fn len(&self) -> usize {
        self.tasks.len() + self.running.len() + self.loads.len()
    }

    /// Whether a task for this content exists.
    pub(crate) fn contains(&self, id: ContentId) -> bool {
        self.tasks.contains_key(&id) || self.running.contains(&id) || self.loads.contains_key(&id)
    }

    /// Whether some task waits for this content.
    pub(crate) fn is_read(&self, id: ContentId) -> bool {
        self.readers.contains_key(&id)
    }

    fn next_order(&mut self, rank: Rank) -> Order {
        self.added += 1;
        (rank, self.added)
    }

    /// Adds a task. `inputs` are there, `missing` are ids whose tasks were added before.
    pub(crate) fn add(
        &mut self,
        job: Job,
        rank: Rank,
        inputs: Inputs,
        missing: &[(ContentId, (NodeIndex, TileKey))],
    ) {
        let (id, order) = (job.id, self.next_order(rank));
        for (input, name) in missing {
            self.readers.entry(*input).or_default().push((id, *name));
        }
        if missing.is_empty() {
            self.ready.insert(order, id);
        }
        self.tasks.insert(
            id,
            Task {
                job,
                order,
                inputs,
                missing: missing.len(),
            },
        );
    }

    /// Adds a tile that can be read from disk.
    pub(crate) fn add_load(&mut self, job: Job, rank: Rank) {
        let (id, order) = (job.id, self.next_order(rank));
        self.to_load.insert(order, id);
        let load = Load {
            job,
            order,
            since: Instant::now(),
            reading: false,
        };
        self.loads.insert(id, load);
    }

    /// The first tile to read, now counted as being read.
    pub(crate) fn start_load(&mut self) -> Option<ContentId> {
        let (_, id) = self.to_load.pop_first()?;
        let load = self.loads.get_mut(&id)?;
        load.reading = true;
        load.since = Instant::now();
        Some(id)
    }

    /// A reader is done with a tile: its job and rank, unless somebody lost patience meanwhile.
    pub(crate) fn end_load(&mut self, id: ContentId) -> Option<(Job, Rank)> {
        let load = self.loads.remove(&id)?;
        Some((load.job, load.order.0))
    }

    /// Whether tiles are still to be read.
    pub(crate) fn is_loading(&self) -> bool {
        !self.loads.is_empty()
    }

    /// The most urgent tile that has been read, or has waited to be read, for longer than `patience`:
    /// no longer to be read.
    pub(crate) fn give_up_load(&mut self, patience: Duration) -> Option<(Job, Rank)> {
        let late = self.loads.values().filter(|l| l.since.elapsed() > patience);
        let first = late.min_by_key(|l| l.order)?;
        let (id, order) = (first.job.id, first.order);
        self.to_load.remove(&order);
        self.end_load(id)
    }

    /// The first task that can run, now counted as running.
    pub(crate) fn start(&mut self) -> Option<(Job, Inputs)> {
        while let Some((_, id)) = self.ready.pop_first() {
            if let Some(task) = self.tasks.remove(&id) {
                self.running.insert(id);
                return Some((task.job, task.inputs));
            }
        }
        None
    }

    /// A running task ended. `Some` tile and its cost go to the tasks that wait for it; with `None`
    /// they can never run and are removed and returned.
    pub(crate) fn finish(
        &mut self,
        id: ContentId,
        tile: Option<(&Arc<Tile>, Duration)>,
    ) -> Vec<Job> {
        self.running.remove(&id);
        let mut lost = Vec::new();
        for (reader, name) in self.readers.remove(&id).unwrap_or_default() {
            let Some(task) = self.tasks.get_mut(&reader) else {
                continue;
            };
            if let Some((tile, cost)) = tile {
                task.inputs.tiles.insert(name, Arc::clone(tile));
                task.inputs.cost += cost;
                task.missing -= 1;
                if task.missing == 0 {
                    self.ready.insert(task.order, reader);
                }
            } else if let Some(task) = self.tasks.remove(&reader) {
                lost.push(task.job);
            }
        }
        lost
    }
}
