//! Layers drawn from the shape of the ground as they lie in version 1 of the file.

use super::adjust::Adjust;
use super::colour::StoredColour;
use super::value::With;
use super::{blend, range};

fields! {
    /// Colours from heights.
    Tint {
        /// Colours by height, heights strictly rising.
        #[schemars(length(min = 1, max = range::MOST_STOPS))]
        stops: Vec<With<TintStop>>,
        /// What happens between stops; smooth where left out.
        interpolation: Option<TintInterpolation>,
        /// How the colour meets what lies below; normal where left out.
        blend: Option<blend::Blend>,
        /// Colour adjustment; none where left out.
        adjust: Option<With<Adjust>>,
    }
}

fields! {
    /// The colour at a height.
    TintStop {
        /// Metres.
        height_m: f64 = range::HEIGHT_M,
        /// Its colour.
        colour: StoredColour,
    }
}

fields! {
    /// Colours from steepness.
    Slope {
        /// Colours by angle against the horizontal, angles strictly rising.
        #[schemars(length(min = 1, max = range::MOST_STOPS))]
        stops: Vec<With<SlopeStop>>,
        /// What happens between stops; stepped where left out.
        interpolation: Option<TintInterpolation>,
        /// What people read and type slopes in; degrees where left out.
        unit: Option<SlopeUnit>,
        /// How the colour meets what lies below; normal where left out.
        blend: Option<blend::Blend>,
    }
}

fields! {
    /// The colour at a slope.
    SlopeStop {
        /// Degrees against the horizontal.
        slope_deg: f64 = range::SLOPE_DEG,
        /// Its colour.
        colour: StoredColour,
        /// How much of it covers; 1 where left out.
        opacity: Option<f64> = range::SHARE,
    }
}

fields! {
    /// Lines of equal height.
    Contours {
        /// Metres between lines; as the distance of the viewer asks for where left out.
        interval_m: Option<f64> = range::INTERVAL_M,
        /// A height in metres that has a line, from which index lines count; 0 where left out.
        base_m: Option<f64> = range::HEIGHT_M,
        /// Every how many lines one is an index line, 0 for none; 5 where left out.
        index_every: Option<u32> = range::INDEX_EVERY,
        /// Their colour; brown where left out.
        colour: Option<StoredColour>,
        /// Width of lines in pixels of the picture; 1 where left out.
        width_px: Option<f64> = range::LINE_PX,
        /// Width of index lines in pixels of the picture; 2 where left out.
        index_width_px: Option<f64> = range::LINE_PX,
        /// How they meet what lies below; normal where left out.
        blend: Option<blend::Blend>,
    }
}

names! {
    /// What happens between two stops.
    TintInterpolation for crate::TintInterpolation {
        /// Colours change linearly.
        Smooth = "smooth",
        /// The lower stop's colour holds up to the next.
        Stepped = "stepped",
    }
}

names! {
    /// What people read and type slopes in.
    SlopeUnit for crate::SlopeUnit {
        /// Angle against the horizontal.
        Degrees = "degrees",
        /// Rise over run.
        Percent = "percent",
    }
}
