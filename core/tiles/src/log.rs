//! What the scheduler did: tests assert this, never timing.

use std::sync::Weak;
use std::time::Duration;

use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::TileKey;

/// One tile that was made, in order of completion.
#[derive(Clone, Debug)]
pub struct LogEntry {
    /// The graph that the cut point belongs to.
    pub graph: Weak<Graph>,
    /// The cut point.
    pub node: NodeIndex,
    /// The node's kind.
    pub kind: &'static str,
    /// The tile.
    pub key: TileKey,
    /// Its name.
    pub id: ContentId,
    /// Whether it could be made.
    pub ready: bool,
    /// How long it took.
    pub cost: Duration,
}

impl PartialEq for LogEntry {
    fn eq(&self, other: &Self) -> bool {
        let of = |e: &Self| (e.node, e.kind, e.key, e.id, e.ready, e.cost);
        self.graph.ptr_eq(&other.graph) && of(self) == of(other)
    }
}

impl Eq for LogEntry {}
