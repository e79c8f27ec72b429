//! Layers that are drawn from the shape of the shown ground, planning elements included.

use crate::{Adjust, Blend, Extra};

/// Colours from heights.
#[derive(Clone, Debug, PartialEq)]
pub struct TintLayer {
    /// The colours.
    pub tint: Tint,
    /// How it meets the layers below.
    pub blend: Blend,
    /// Colour adjustment.
    pub adjust: Adjust,
}

/// A table of colours by height.
#[derive(Clone, Debug, PartialEq)]
pub struct Tint {
    /// 1 to 1000 stops, heights strictly rising. Below the first and above the last their colours
    /// continue.
    pub stops: Vec<TintStop>,
    /// What happens between stops. Default smooth.
    pub interpolation: TintInterpolation,
}

/// The colour at a height.
#[derive(Clone, Debug, PartialEq)]
pub struct TintStop {
    /// Metres, −10⁷ to 10⁷.
    pub height_m: f64,
    /// sRGB red, green, blue.
    pub colour: [u8; 3],
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl TintStop {
    /// A stop.
    pub fn new(height_m: f64, colour: [u8; 3]) -> Self {
        Self {
            height_m,
            colour,
            extra: Extra::new(),
        }
    }
}

/// What happens between two stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum TintInterpolation {
    /// Colours change linearly.
    #[default]
    Smooth,
    /// The lower stop's colour holds up to the next.
    Stepped,
}

/// Colours by the angle of the ground against the horizontal.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeLayer {
    /// 1 to 1000 stops, angles strictly rising. Below the first and above the last their colours
    /// continue.
    pub stops: Vec<SlopeStop>,
    /// What happens between stops. Default stepped: classes.
    pub interpolation: TintInterpolation,
    /// What people read and type slopes in; no pixel depends on it. Default degrees.
    pub unit: SlopeUnit,
    /// How the colour meets the layers below.
    pub blend: Blend,
}

impl Default for SlopeLayer {
    /// Classes of building ground: up to 5 % as it is, then from easy to steep.
    fn default() -> Self {
        let stop = |percent: f64, colour, opacity| SlopeStop {
            opacity,
            ..SlopeStop::new(SlopeUnit::Percent.to_deg(percent), colour)
        };
        Self {
            stops: vec![
                stop(0.0, [0x1a, 0x98, 0x50], 0.0),
                stop(5.0, [0x91, 0xcf, 0x60], 1.0),
                stop(10.0, [0xfe, 0xe0, 0x8b], 1.0),
                stop(20.0, [0xfc, 0x8d, 0x59], 1.0),
                stop(35.0, [0xd7, 0x30, 0x27], 1.0),
                stop(60.0, [0x7f, 0x1d, 0x4e], 1.0),
            ],
            interpolation: TintInterpolation::Stepped,
            unit: SlopeUnit::Percent,
            blend: Blend::Normal,
        }
    }
}

/// The colour at a slope.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeStop {
    /// Degrees against the horizontal, 0 to 90.
    pub slope_deg: f64,
    /// sRGB red, green, blue.
    pub colour: [u8; 3],
    /// How much of it covers, 0 to 1. Default 1.
    pub opacity: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl SlopeStop {
    /// An opaque stop.
    pub fn new(slope_deg: f64, colour: [u8; 3]) -> Self {
        Self {
            slope_deg,
            colour,
            opacity: 1.0,
            extra: Extra::new(),
        }
    }
}

/// What people read and type slopes in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum SlopeUnit {
    /// Angle against the horizontal.
    #[default]
    Degrees,
    /// Rise over run, 100 at 45°.
    Percent,
}

impl SlopeUnit {
    /// A slope of this unit in degrees.
    pub fn to_deg(self, slope: f64) -> f64 {
        match self {
            Self::Degrees => slope,
            Self::Percent => libm::atan(slope / 100.0).to_degrees(),
        }
    }

    /// Degrees in this unit; a wall has no end of percents.
    pub fn from_deg(self, slope_deg: f64) -> f64 {
        match self {
            Self::Degrees => slope_deg,
            Self::Percent => 100.0 * libm::tan(slope_deg.to_radians()),
        }
    }
}

/// Lines of equal height.
#[derive(Clone, Debug, PartialEq)]
pub struct ContoursLayer {
    /// Metres between lines, 10⁻³ to 10⁶. `None`: as the distance of the viewer asks for.
    pub interval_m: Option<f64>,
    /// A height in metres that has a line; index lines are counted from it. Default 0.
    pub base_m: f64,
    /// Every how many lines one is an index line, 0 (none) to 1000. Default 5.
    pub index_every: u32,
    /// sRGB red, green, blue.
    pub colour: [u8; 3],
    /// Width of lines in pixels of the picture, 0 to 100. Default 1.
    pub width_px: f64,
    /// Width of index lines in pixels of the picture, 0 to 100. Default 2.
    pub index_width_px: f64,
    /// How they meet the layers below.
    pub blend: Blend,
}

impl Default for ContoursLayer {
    fn default() -> Self {
        Self {
            interval_m: None,
            base_m: 0.0,
            index_every: 5,
            colour: [0x6b, 0x43, 0x1f],
            width_px: 1.0,
            index_width_px: 2.0,
            blend: Blend::Normal,
        }
    }
}
