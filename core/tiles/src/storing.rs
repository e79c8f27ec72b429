//! What is to be written to disk, and when: never while tiles are wanted, and never what an edit
//! has replaced already.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use relievo_graph::{ContentId, Graph};

use crate::queue::Job;

/// Tiles that may wait to be written; the oldest give way.
const WAITING: usize = 4096;

/// A tile that waits to be written. It is looked up in the memory cache when its turn comes, so that
/// waiting takes no memory; what has left the cache by then is not written.
pub(crate) struct Waiting {
    pub(crate) job: Job,
    /// What it cost with everything it reads.
    pub(crate) cost: Duration,
}

/// The tiles that wait.
pub(crate) struct Storing {
    waiting: VecDeque<Waiting>,
    graph: Option<Arc<Graph>>,
    /// Nothing is written sooner than this after wants or tiles came, so that a drag writes nothing.
    calm: Duration,
    active: Instant,
}

impl Storing {
    pub(crate) fn new(calm: Duration) -> Self {
        Self {
            waiting: VecDeque::new(),
            graph: None,
            calm,
            active: Instant::now(),
        }
    }

    /// Notes which graph the latest wants are of.
    pub(crate) fn follow(&mut self, graph: &Arc<Graph>) {
        self.active = Instant::now();
        self.graph = Some(Arc::clone(graph));
    }

    /// Adds a tile.
    pub(crate) fn add(&mut self, job: Job, cost: Duration) {
        self.active = Instant::now();
        if self.waiting.len() >= WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(Waiting { job, cost });
    }

    /// How long to wait before anything is written; `None` while there is nothing.
    pub(crate) fn due_in(&self) -> Option<Duration> {
        (!self.waiting.is_empty()).then(|| self.calm.saturating_sub(self.active.elapsed()))
    }

    /// The next tile, and the graph that must still name it.
    pub(crate) fn next(&mut self) -> Option<(Waiting, Arc<Graph>)> {
        let next = self.waiting.pop_front()?;
        let graph = self.graph.clone().unwrap_or(Arc::clone(&next.job.graph));
        Some((next, graph))
    }
}

impl Waiting {
    /// Whether a graph still gives this tile, so that it can be asked for again.
    pub(crate) fn is_of(&self, graph: &Arc<Graph>) -> bool {
        let named = |g: &Graph, node| g.content_id(node, self.job.key) == self.job.id;
        Arc::ptr_eq(graph, &self.job.graph) || graph.cuts().any(|node| named(graph, node))
    }

    /// The tile's name.
    pub(crate) fn id(&self) -> ContentId {
        self.job.id
    }
}
