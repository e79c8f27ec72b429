//! What the scheduler did: tests assert this, never timing.

use std::sync::Weak;
use std::time::Duration;

use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::TileKey;

/// One tile that was made, in order of completion.
#[derive(Clone)]
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
