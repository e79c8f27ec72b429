//! Clipmap geometry: which samples each clip level holds around the focus, what of it a view needs,
//! and the static mesh that is draped over it.
//!
//! ```text
//! PlanInput --Planner::plan--> Plan { focus, rings, sectors, heights, colours }
//!                              each LevelPlan: window, wanted rectangle -> tile keys
//! resident tiles + LevelPlan --valid--> LevelView (uniforms) --choose--> level of a vertex, a fragment
//! ```
//!
//! Absent: pixels, textures, caches. Source: [CH06], [CH07] and section 6 of the design.

pub mod choose;
pub mod plan;
pub mod rings;
pub mod window;

pub use plan::{
    ClipKind, HeightRange, LevelPlan, Plan, PlanInput, Quality, RingSectors, TerrainBounds,
};
pub use window::{UploadPiece, Window};
