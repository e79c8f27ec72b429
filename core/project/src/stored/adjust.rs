//! Colour adjustments as they lie in version 1 of the file.

use super::colour::StoredColour;
use super::range;
use super::value::With;

fields! {
    /// Colour adjustment; members left out change nothing.
    Adjust {
        /// Added to all channels; 0 where left out.
        brightness: Option<f64> = range::SIGNED_SHARE,
        /// Factor on the distance from mid grey; 1 where left out.
        contrast: Option<f64> = range::FACTOR,
        /// Turn of the hue in degrees; 0 where left out.
        hue_deg: Option<f64> = range::HUE_DEG,
        /// Factor on saturation; 1 where left out.
        saturation: Option<f64> = range::FACTOR,
        /// Display values are raised to the power of 1/gamma; 1 where left out.
        gamma: Option<f64> = range::GAMMA,
        /// Factor for red, green and blue; 1 where left out.
        gain: Option<[f64; 3]> => range::GAIN,
        /// Added to red, green and blue after the gain; 0 where left out.
        offset: Option<[f64; 3]> => range::SIGNED_GAIN,
        /// The values that the steps from mix to saturation work on; display where left out.
        space: Option<AdjustSpace>,
        /// Colour temperature of the light in the picture in kelvin, higher warms; 6504 where left out.
        temperature_k: Option<f64> = range::TEMPERATURE_K,
        /// Green of the light in the picture, higher turns it magenta; 0 where left out.
        tint: Option<f64> = range::LIGHT_TINT,
        /// Factors of red, green and blue that make red; red alone where left out.
        mix_red: Option<[f64; 3]> => range::SIGNED_GAIN,
        /// Factors of red, green and blue that make green; green alone where left out.
        mix_green: Option<[f64; 3]> => range::SIGNED_GAIN,
        /// Factors of red, green and blue that make blue; blue alone where left out.
        mix_blue: Option<[f64; 3]> => range::SIGNED_GAIN,
        /// Tone curves on display values; none where left out.
        curves: Option<With<ToneCurves>>,
        /// Whether display values are turned over; not where left out.
        invert: Option<bool>,
        /// A colour that becomes transparent; none where left out.
        clear: Option<With<ClearColour>>,
        /// How much of all that is shown; 1 where left out.
        strength: Option<f64> = range::SHARE,
    }
}

names! {
    /// The values that adjustments work on.
    AdjustSpace for crate::AdjustSpace {
        /// Display values (sRGB encoded).
        Display = "display",
        /// Linear light.
        Linear = "linear",
        /// Lightness, chroma and hue as the eye has them (Oklab).
        Perceptual = "perceptual",
    }
}

fields! {
    /// Tone curves, each smooth through its points; level before the first and beyond the last.
    ToneCurves {
        /// Of all channels.
        #[schemars(length(max = range::MOST_CURVE_POINTS))]
        all: Option<Vec<With<CurvePoint>>>,
        /// Of red, after the common one.
        #[schemars(length(max = range::MOST_CURVE_POINTS))]
        red: Option<Vec<With<CurvePoint>>>,
        /// Of green, after the common one.
        #[schemars(length(max = range::MOST_CURVE_POINTS))]
        green: Option<Vec<With<CurvePoint>>>,
        /// Of blue, after the common one.
        #[schemars(length(max = range::MOST_CURVE_POINTS))]
        blue: Option<Vec<With<CurvePoint>>>,
    }
}

fields! {
    /// A point of a tone curve; inputs rise strictly from point to point.
    CurvePoint {
        /// Display value before.
        input: f64 = range::SHARE,
        /// Display value after.
        output: f64 = range::SHARE,
    }
}

fields! {
    /// A colour that becomes transparent, and what is mixed with it in part.
    ClearColour {
        /// The colour.
        colour: StoredColour,
        /// Distance from it up to which everything goes; 0 where left out.
        from: Option<f64> = range::SHARE,
        /// Distance from which everything stays, above `from`; 1 where left out.
        to: Option<f64> = range::SHARE,
    }
}
