//! The cache on disk: tiles that were dear to make, kept from run to run.
//!
//! Of the same shape as the one in memory: tiles by content id, bounded by bytes, least valuable
//! first. A cache is never needed: whatever is missing, damaged or unreadable is made again, and a
//! folder that cannot be written turns storing off with one warning.
//!
//! Absent: threads and the decision what is stored when (`tiles`).

mod entry;
mod folder;

use std::path::PathBuf;
use std::time::Duration;

use relievo_graph::ContentId;
use relievo_raster::Tile;

pub(crate) use folder::Folder;

/// Where and how much to keep on disk.
#[derive(Clone, Debug)]
pub struct DiskOptions {
    /// The folder, made if it is not there. Programs may share it. Only files that look like this
    /// cache's own are ever touched in it.
    pub folder: PathBuf,
    /// Bound in bytes of what lies in the folder. Each program that shares it may go beyond by a
    /// sixteenth for a while.
    pub bytes: u64,
    /// Least time to make a tile that is stored; what is made sooner is as good as read.
    pub dear: Duration,
    /// Tiles are written once nothing was asked for or made for so long, and when the program ends.
    pub calm: Duration,
}

impl DiskOptions {
    /// A folder, with the bound and the least cost that suit most machines: 2 GiB, 1 ms; written after 0.3 s
    /// of calm.
    pub fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            bytes: 2 << 30,
            dear: Duration::from_millis(1),
            calm: Duration::from_millis(300),
        }
    }
}

/// What was read of a tile.
pub(crate) struct Loaded {
    pub(crate) tile: Tile,
    /// What it cost to make once, with everything that it reads.
    pub(crate) cost: Duration,
}

/// Where finished tiles are kept: a folder, or something slow in a test.
pub(crate) trait Shelf: Send + Sync {
    /// Finds out what is there. Until that is done [`Self::may_have`] says yes to everything.
    fn list(&self);

    /// Whether it is worth a look. Answers at once.
    fn may_have(&self, id: ContentId) -> bool;

    /// A tile, if it is there and in order.
    fn load(&self, id: ContentId) -> Option<Loaded>;

    /// Keeps a tile that cost so much, if it can; `true` if it is now there.
    fn save(&self, id: ContentId, tile: &Tile, cost: Duration) -> bool;
}
