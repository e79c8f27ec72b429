//! What the scheduler did: tests assert this, never timing.

use std::time::Duration;

use relievo_graph::{ContentId, NodeIndex};
use relievo_planet::TileKey;

/// One tile that was made, in order of completion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogEntry {
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
