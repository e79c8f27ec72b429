//! The task queue: which tasks wait, which can run, which run. Knows no threads.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

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

/// Tiles that a job reads, by the names it uses for them.
pub(crate) type Inputs = HashMap<(NodeIndex, TileKey), Arc<Tile>>;

struct Task {
    job: Job,
    /// Position in the order of wants; inputs come before what reads them.
    order: u64,
    /// Inputs that are there already.
    inputs: Inputs,
    /// Inputs that are still being made.
    missing: usize,
}

/// A task that waits for an input, and the name it uses for it.
type Reader = (ContentId, (NodeIndex, TileKey));

/// All tasks. Sequence numbers order them: coarse before fine and visible before prefetched, as the
/// wants were given, each preceded by what it depends on.
#[derive(Default)]
pub(crate) struct Queue {
    tasks: HashMap<ContentId, Task>,
    ready: BTreeMap<u64, ContentId>,
    readers: HashMap<ContentId, Vec<Reader>>,
    running: HashSet<ContentId>,
    next_order: u64,
}

impl Queue {
    /// Drops every task that does not run; running ones finish.
    pub(crate) fn clear(&mut self) {
        self.tasks.clear();
        self.ready.clear();
        self.readers.clear();
    }

    /// Number of tasks that wait or run.
    pub(crate) fn len(&self) -> usize {
        self.tasks.len() + self.running.len()
    }

    /// Whether a task for this content exists.
    pub(crate) fn contains(&self, id: ContentId) -> bool {
        self.tasks.contains_key(&id) || self.running.contains(&id)
    }

    /// Whether some task waits for this content.
    pub(crate) fn is_read(&self, id: ContentId) -> bool {
        self.readers.contains_key(&id)
    }

    /// Adds a task. `inputs` are there, `missing` are ids whose tasks were added before.
    pub(crate) fn add(
        &mut self,
        job: Job,
        inputs: Inputs,
        missing: &[(ContentId, (NodeIndex, TileKey))],
    ) {
        let (id, order) = (job.id, self.next_order);
        self.next_order += 1;
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

    /// A running task ended. `Some` tile goes to the tasks that wait for it; with `None` they can
    /// never run and are removed and returned.
    pub(crate) fn finish(&mut self, id: ContentId, tile: Option<&Arc<Tile>>) -> Vec<Job> {
        self.running.remove(&id);
        let mut lost = Vec::new();
        for (reader, name) in self.readers.remove(&id).unwrap_or_default() {
            let Some(task) = self.tasks.get_mut(&reader) else {
                continue;
            };
            if let Some(tile) = tile {
                task.inputs.insert(name, Arc::clone(tile));
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
