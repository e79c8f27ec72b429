//! Where a layer shows.

use crate::{Extra, LayerId};

/// Where a layer shows: where all that is given holds at once; without anything, everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mask {
    /// Heights of the shown ground in metres, −10⁷ to 10⁷.
    pub heights: Option<MaskRange>,
    /// Steepness of the shown ground in degrees, 0 to 90.
    pub slopes: Option<MaskRange>,
    /// A circle on the ground. Layers with the same one share a lens, which moves for all of them.
    pub circle: Option<MaskCircle>,
    /// A vector layer, hidden or not, whose areas count.
    pub vector: Option<LayerId>,
    /// Whether the layer shows everywhere else instead.
    pub invert: bool,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Mask {
    /// Whether the layer shows everywhere, or with `invert` nowhere.
    pub fn is_everywhere(&self) -> bool {
        self.heights.is_none()
            && self.slopes.is_none()
            && self.circle.is_none()
            && self.vector.is_none()
    }
}

/// Values from one to another, fading out beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskRange {
    /// Lowest value that shows fully.
    pub from: f64,
    /// Highest value that shows fully, at least `from`.
    pub to: f64,
    /// How far beyond either end the layer fades out, in the same unit. Default 0.
    pub fade: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// A circle on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskCircle {
    /// Longitude of its centre in degrees, east positive.
    pub lon_deg: f64,
    /// Latitude of its centre in degrees.
    pub lat_deg: f64,
    /// Radius in metres along the ground, 0 to 10¹⁰.
    pub radius_m: f64,
    /// How far beyond it the layer fades out, metres. Default 0.
    pub fade_m: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}
