//! The image-source graph: what to compute, on which samples, and what the result is called.
//!
//! Invariant: a node is a pure function of its parameters, its inputs' samples and the grid: no
//! clock, no global state, no unseeded randomness. Same graph, same bytes, for any number of
//! threads and any order of visits.
//!
//! Absent: threads and caches (`relievo-tiles`), layers and edits (`relievo-project`).

pub mod graph;
pub mod id;
pub mod node;
pub mod nodes;
pub mod places;
pub mod roughness;

pub use graph::{Artefacts, Graph, GraphBuilder, NodeIndex, TileInputs};
pub use id::{ContentId, IdHasher};
pub use node::{Artefact, ImageNode, Job, Known, Made, RenderError};
pub use places::Pieces;
