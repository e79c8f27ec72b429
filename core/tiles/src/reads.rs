//! What tiles read, remembered: while a camera moves the same tiles are wanted again each frame.

use std::collections::HashMap;
use std::sync::Arc;

use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::TileKey;

use crate::queue::Job;

/// Tiles whose inputs are remembered; each takes about 200 bytes.
const REMEMBERED: usize = 20_000;

/// The tiles that a tile reads, and their names.
type Inputs = Arc<[(NodeIndex, TileKey, ContentId)]>;

/// Inputs of tiles of one graph.
#[derive(Default)]
pub(crate) struct Reads {
    graph: Option<Arc<Graph>>,
    inputs: HashMap<(NodeIndex, TileKey), Inputs>,
}

impl Reads {
    /// The tiles that a job reads.
    pub(crate) fn of(&mut self, job: &Job) -> Inputs {
        let is_same = |graph: &Arc<Graph>| Arc::ptr_eq(graph, &job.graph);
        if !self.graph.as_ref().is_some_and(is_same) || self.inputs.len() >= REMEMBERED {
            self.inputs.clear();
            self.graph = Some(Arc::clone(&job.graph));
        }
        let inputs = self.inputs.entry((job.node, job.key)).or_insert_with(|| {
            let tiles = job.graph.dependencies(job.node, job.key);
            let named = tiles
                .into_iter()
                .map(|(node, key)| (node, key, job.graph.content_id(node, key)));
            named.collect()
        });
        Arc::clone(inputs)
    }
}
