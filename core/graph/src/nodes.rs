//! One file per node. Each says what it computes, its ranges and its source.

pub mod add_heights;
pub mod adjust;
pub mod alpha_mask;
pub mod colour_detail;
pub mod constant;
pub mod contour_lines;
pub mod detail;
pub mod disc_mask;
pub mod earthwork;
pub mod edge_distances;
pub mod file;
mod ground;
pub mod height_difference;
mod lanes;
pub mod mask_product;
pub mod memory;
pub mod noise;
pub mod normals;
pub mod overlay;
pub mod overlay_heights;
pub mod polygon_mask;
pub mod range_mask;
pub mod seam_blend;
pub mod slope_angle;
pub mod tint;
pub mod vector;

pub use add_heights::AddHeights;
pub use adjust::{Adjust, AdjustParams, AdjustSpace, Clear, Curve, WhiteBalance};
pub use alpha_mask::AlphaMask;
pub use colour_detail::{
    ColourDetail, ColourDetailAmount, ColourDetailParams, ColourDetailSource, ExampleAt,
};
pub use constant::Constant;
pub use contour_lines::{ContourLines, ContourStyle, ContourStyleError};
pub use detail::{Detail, DetailMethod, DetailParams};
pub use disc_mask::DiscMask;
pub use earthwork::{Earthwork, PlacedElement};
pub use edge_distances::EdgeDistances;
pub use file::FileSource;
pub use height_difference::HeightDifference;
pub use mask_product::MaskProduct;
pub use memory::Memory;
pub use noise::{Noise, NoiseParams};
pub use normals::Normals;
pub use overlay::{BlendMode, Overlay};
pub use overlay_heights::OverlayHeights;
pub use polygon_mask::PolygonMask;
pub use range_mask::RangeMask;
pub use seam_blend::SeamBlend;
pub use slope_angle::SlopeAngle;
pub use tint::{Stop, Tint, TintError};
pub use vector::Vector;
