//! Asks what is under the pointer at the data's own resolution.

use relievo_engine::PlaceAnswer;
use relievo_engine::planet::MapPoint;

use super::latest::Latest;

/// A place in a state of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// Where.
    pub(crate) point: MapPoint,
    /// Which state of the project.
    pub(crate) revision: u64,
}

/// Answers about the latest spot; `None` where a source cannot be read.
pub(crate) type Probe = Latest<Spot, Option<PlaceAnswer>>;
