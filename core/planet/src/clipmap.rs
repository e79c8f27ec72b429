//! Clipmap geometry: which samples each clip level holds around the focus, what of it a view needs,
//! and the static mesh that is draped over it.
//!
//! ```text
//! PlanInput --Planner::plan--> Plan { focus, rings, sectors, heights, colours }
//!                              each LevelPlan: window, selected tiles, wanted rectangle
//! resident tiles + LevelPlan --valid--> LevelView (uniforms) --choose--> level of a vertex, a fragment
//! ```
//!
//! Absent: pixels, textures, caches. Source: \[CH06\], \[CH07\].

pub mod choose;
pub mod cull;
pub mod focus;
pub mod levels;
pub mod plan;
pub mod planner;
pub mod rings;
mod select;
pub mod tile_set;
pub mod valid;
pub mod view;
pub mod window;

pub use choose::{LevelChoice, LevelView, colour_level_for, height_level_for};
pub use focus::FocusRule;
pub use plan::{
    ClipKind, HeightRange, Layout, LevelPlan, Plan, PlanInput, Quality, RingSectors, TerrainBounds,
};
pub use planner::Planner;
pub use rings::{RingMesh, RingVertex};
pub use tile_set::TileSet;
pub use valid::{ValidRect, valid_rect};
pub use window::{UploadPiece, Window};
