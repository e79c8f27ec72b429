//! Where a layer shows.

use crate::{Extra, LayerId};

/// Where a layer shows: where all that is given holds at once; without anything, everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mask {
    /// Heights of the shown ground in metres, −10⁷ to 10⁷.
    pub heights: Option<MaskRange>,
    /// Steepness of the shown ground in degrees, 0 to 90.
    pub slopes: Option<MaskRange>,
    /// A part of the ground that moves. Layers with the same lens share it: it moves for all of them.
    pub lens: Option<Lens>,
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
            && self.lens.is_none()
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

/// A circle or polygon on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Longitude of its centre in degrees, east positive.
    pub lon_deg: f64,
    /// Latitude of its centre in degrees.
    pub lat_deg: f64,
    /// How far beyond its edge the layer fades out, metres, 0 to 10¹⁰. Default 0.
    pub fade_m: f64,
    /// What lies inside.
    pub shape: LensShape,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// The shape of a lens around its centre.
#[derive(Clone, Debug, PartialEq)]
pub enum LensShape {
    /// All places within a distance.
    Circle {
        /// Radius in metres along the ground, 0 to 10¹⁰.
        radius_m: f64,
    },
    /// The inside of an outline by the even-odd rule, so that it may cross itself.
    Polygon {
        /// 3 to 256 corners in metres east and north of the centre, each −10⁷ to 10⁷: in an azimuthal
        /// equidistant frame on the ellipsoid, so that what moves keeps its shape.
        corners_m: Vec<[f64; 2]>,
    },
}

impl LensShape {
    /// Fewest corners of a polygon.
    pub const LEAST_CORNERS: usize = 3;
    /// Most corners of a polygon.
    pub const MOST_CORNERS: usize = 256;
    /// How far east, west, north or south of the centre a corner may be, metres.
    pub const FARTHEST_M: f64 = 1e7;
}
