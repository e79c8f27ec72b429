//! From wanted tiles to finished ones: a cache by content id and a scheduler with workers.
//!
//! Invariants: one task per content id however many ask; a caller never waits for a tile unless it
//! says so ([`Tiles::wait`]); the result of a task depends on its content id alone, never on when
//! or where it ran.
//!
//! A disk is never waited for: what it does not give soon is made, and what it holds is checked byte for
//! byte before it is shown.
//!
//! Absent: clipmaps and views. Whoever calls [`Tiles::want`] decides what is wanted and in which
//! order.

pub mod cache;
pub mod disk;
pub mod log;
mod queue;
mod reads;
mod storing;
pub mod tiles;

pub use cache::{Focus, TileState};
pub use disk::DiskOptions;
pub use log::LogEntry;
pub use tiles::{Finished, Stats, Tiles, TilesOptions, Want};
