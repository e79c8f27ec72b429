//! The one door of core: open a project, apply edits, set the view, drain what to upload.
//!
//! Invariants: only [`Engine::apply`] (and undo, redo) changes a project; nothing here waits for a
//! tile on the caller's thread; nothing here knows a window or a GPU.

pub mod analysis;
pub mod bake;
mod compile;
mod difference;
mod element_answers;
mod element_colours;
mod elements;
pub mod engine;
pub mod export;
pub mod frame;
pub mod histogram;
mod labels;
mod marks;
mod masses;
mod matching;
mod message;
pub mod query;
pub mod reference;
pub mod relink;
mod residency;
mod sampling;
mod scenarios;
mod scene;
mod sources;
mod terrain;
mod vectors;
mod view;

pub use bake::{Bake, BakeError, Output};
pub use difference::HeightDifference;
pub use element_answers::ElementAnswer;
pub use engine::{
    DEFAULT_DISK_CACHE_BYTES, Engine, EngineOptions, EngineStats, Guarded, Kept, OpenError,
    default_cache_folder, default_state_folder, folder_of,
};
pub use engine::{Made, NodeReport};
pub use frame::{ClipKind, Frame, LevelView, Sun, Upload};
pub use labels::PlacedLabel;
pub use marks::Mark;
pub use masses::{MassMesh, MassVertex};
pub use matching::{Balanced, ColourBalance, ColourMatch, MatchTarget, OverlapDifference};
pub use message::{Message, Severity};
pub use query::{Maker, PlaceAnswer, Questions};
pub use reference::{Confirmation, Offset, Reference, ReferencePicture, ReferenceSettings};
pub use relievo_planet::clipmap::Layout;
pub use sampling::Stage;
pub use scenarios::as_shown;
pub use sources::{SourceState, Sources};
pub use vectors::OpenFeatures;
pub use view::View;

/// Types of frames and views, for rooms that may depend on the engine only.
/// Types of tiles, likewise.
// A front-end needs their types, and this is the only door.
pub use relievo_analysis::{Measure, Profile, ProfileSettings};
pub use {
    relievo_earthwork as earthwork, relievo_graph as graph, relievo_planet as planet,
    relievo_project as project, relievo_raster as raster, relievo_tiles as tiles,
    relievo_vector as vector,
};
