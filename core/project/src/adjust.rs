//! Colour adjustments of a layer.

use crate::Extra;

/// Colour adjustment; the default changes nothing. Steps are made in the order of the fields, with
/// `space` saying on which values those from `mix` to `saturation` work.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjust {
    /// The values that most steps work on. Default display.
    pub space: AdjustSpace,
    /// Colour temperature of the light in the picture in kelvin, 1667 to 25,000; higher warms. Default
    /// 6504, the display's white.
    pub temperature_k: f64,
    /// Green of the light in the picture, −100 to 100; higher turns it magenta. Default 0.
    pub tint: f64,
    /// Rows of a matrix: red, green and blue out of red, green and blue, −16 to 16 each. Default the
    /// identity.
    pub mix: [[f64; 3]; 3],
    /// Factor for red, green and blue, 0 to 16 each. Default 1.
    pub gain: [f64; 3],
    /// Added to red, green and blue after the gain, −16 to 16 each. Default 0.
    pub offset: [f64; 3],
    /// Added to all channels, −1 to 1. Default 0.
    pub brightness: f64,
    /// Factor on the distance from mid grey, 0 to 4. Default 1.
    pub contrast: f64,
    /// Turn of the hue in degrees, −180 to 180. Default 0.
    pub hue_deg: f64,
    /// Factor on saturation, 0 (grey) to 4. Default 1.
    pub saturation: f64,
    /// Exponent 1/γ on display-referred values: γ 0.1 to 10, above 1 lightens. Default 1.
    pub gamma: f64,
    /// Tone curves on display values. Default none.
    pub curves: ToneCurves,
    /// Whether display values are turned over. Default no.
    pub invert: bool,
    /// A colour that becomes transparent. Default none.
    pub clear: Option<ClearColour>,
    /// How much of all that is shown, 0 to 1. Default 1.
    pub strength: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// The values that adjustments work on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AdjustSpace {
    /// Display values (sRGB encoded), as image editors do.
    #[default]
    Display,
    /// Linear light.
    Linear,
    /// Lightness, chroma and hue as the eye has them (Oklab).
    Perceptual,
}

/// Tone curves: one for all channels, then one for each; a curve without points changes nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToneCurves {
    /// Of all channels.
    pub all: Vec<CurvePoint>,
    /// Of red, green and blue, after the common one.
    pub channels: [Vec<CurvePoint>; 3],
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// A point of a tone curve. The points of a curve have rising inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePoint {
    /// Display value before, 0 to 1.
    pub input: f64,
    /// Display value after, 0 to 1.
    pub output: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// A colour that becomes transparent, and what is mixed with it in part.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearColour {
    /// The colour.
    pub colour: [u8; 3],
    /// Distance from it, 0 to 1, up to which everything goes. Default 0.
    pub from: f64,
    /// Distance, above `from` and at most 1, from which everything stays. Default 1.
    pub to: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Colour temperature that changes nothing: the display's white, kelvin.
pub const NEUTRAL_TEMPERATURE_K: f64 = 6504.0;

/// The matrix that changes nothing.
pub(crate) const UNMIXED: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Default for Adjust {
    fn default() -> Self {
        Self {
            space: AdjustSpace::Display,
            temperature_k: NEUTRAL_TEMPERATURE_K,
            tint: 0.0,
            mix: UNMIXED,
            gain: [1.0; 3],
            offset: [0.0; 3],
            brightness: 0.0,
            contrast: 1.0,
            hue_deg: 0.0,
            saturation: 1.0,
            gamma: 1.0,
            curves: ToneCurves::default(),
            invert: false,
            clear: None,
            strength: 1.0,
            extra: Extra::new(),
        }
    }
}

impl Adjust {
    /// Whether it changes no colour.
    pub fn is_identity(&self) -> bool {
        let nothing = Self {
            space: self.space,
            strength: self.strength,
            extra: self.extra.clone(),
            ..Self::default()
        };
        self.strength == 0.0 || *self == nothing
    }
}
