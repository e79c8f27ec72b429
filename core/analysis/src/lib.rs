//! What users measure on the ground: lengths, areas, profiles, contours, sight, water, volumes; and how
//! the colours of two pictures of it differ and are matched ([`colour`]).
//!
//! Pure functions over a [`Ground`], which gives heights on any grid, or over pairs of colours. Heights are evaluated at the
//! spacing of the data (or finer, where a measure converges) and never on what a screen shows, so
//! that no answer depends on the zoom. Every metre is one of the planet's ellipsoid.
//!
//! Invariant: memory is bounded by limits that are stated with each request, never by what was
//! asked for; a request beyond them is refused in one line. Same ground, same answer, bit for bit,
//! for any number of threads.
//!
//! Absent: where heights come from (`relievo-engine` lends its graph), files, pixels.

pub mod colour;
pub mod contours;
pub mod flood;
pub mod frame;
pub mod geodesic;
pub mod ground;
pub mod map_box;
mod parallel;
pub mod profile;
mod sampler;
pub mod slope;
mod triangle;
pub mod viewshed;
pub mod volume;

pub use contours::{ContourLine, ContourSettings, contours};
pub use flood::{Flood, FloodSettings, Water, flood};
pub use frame::LocalFrame;
pub use geodesic::{Measure, RingArea};
pub use ground::{AnalysisError, Ground, Unwatched, Watch};
pub use map_box::MapBox;
pub use profile::{Profile, ProfilePoint, ProfileSettings, profile};
pub use sampler::Sampler;
pub use slope::{Slope, slopes};
pub use viewshed::{Sight, Viewshed, ViewshedSettings, viewshed};
pub use volume::{Amount, Between, Change, VolumeSettings, Volumes, volumes};
