//! One file per node. Each says what it computes, its ranges and its source.

pub mod add_heights;
pub mod adjust;
pub mod constant;
pub mod contour_lines;
pub mod earthwork;
pub mod edge_fade;
pub mod example_detail;
pub mod file;
mod ground;
pub mod height_difference;
mod lanes;
pub mod memory;
pub mod noise;
pub mod normals;
pub mod overlay;
pub mod overlay_heights;
pub mod slope_angle;
pub mod tint;
pub mod vector;

pub use add_heights::AddHeights;
pub use adjust::{Adjust, AdjustParams, AdjustSpace, Clear, Curve, WhiteBalance};
pub use constant::Constant;
pub use contour_lines::{ContourLines, ContourStyle, ContourStyleError};
pub use earthwork::{Earthwork, PlacedElement};
pub use edge_fade::EdgeFade;
pub use example_detail::{ExampleDetail, ExampleDetailParams, Exemplar, ExemplarError};
pub use file::FileSource;
pub use height_difference::HeightDifference;
pub use memory::Memory;
pub use noise::{Noise, NoiseParams};
pub use normals::Normals;
pub use overlay::{BlendMode, Overlay};
pub use overlay_heights::OverlayHeights;
pub use slope_angle::SlopeAngle;
pub use tint::{Stop, Tint, TintError};
pub use vector::Vector;
