//! Where a layer shows as it lies in version 1 of the file.

use super::range;
use super::value::With;

fields! {
    /// Where a layer shows: where all that is given holds at once.
    Mask {
        /// Heights of the shown ground; any where left out.
        heights: Option<With<MaskHeights>>,
        /// Steepness of the shown ground; any where left out.
        slopes: Option<With<MaskSlopes>>,
        /// A circle on the ground; anywhere where left out.
        circle: Option<With<MaskCircle>>,
        /// Id of a vector layer, hidden or not, whose areas count; none where left out.
        vector: Option<String>,
        /// Whether the layer shows everywhere else instead; not where left out.
        invert: Option<bool>,
    }
}

fields! {
    /// A range of heights.
    #[expect(clippy::struct_field_names, reason = "each name carries its unit")]
    MaskHeights {
        /// Lowest height in metres that shows fully.
        from_m: f64 = range::HEIGHT_M,
        /// Highest height in metres that shows fully, not below `from_m`.
        to_m: f64 = range::HEIGHT_M,
        /// Metres beyond either end over which the layer fades out; 0 where left out.
        fade_m: Option<f64> = range::MASK_FADE_M,
    }
}

fields! {
    /// A range of slopes.
    #[expect(clippy::struct_field_names, reason = "each name carries its unit")]
    MaskSlopes {
        /// Least slope in degrees that shows fully.
        from_deg: f64 = range::SLOPE_DEG,
        /// Greatest slope in degrees that shows fully, not below `from_deg`.
        to_deg: f64 = range::SLOPE_DEG,
        /// Degrees beyond either end over which the layer fades out; 0 where left out.
        fade_deg: Option<f64> = range::SLOPE_DEG,
    }
}

fields! {
    /// A circle on the ground.
    MaskCircle {
        /// Longitude of its centre in degrees, east positive.
        lon_deg: f64 = range::TURN_DEG,
        /// Latitude of its centre in degrees.
        lat_deg: f64 = range::LATITUDE_DEG,
        /// Radius in metres along the ground.
        radius_m: f64 = range::LENS_M,
        /// Metres beyond it over which the layer fades out; 0 where left out.
        fade_m: Option<f64> = range::LENS_M,
    }
}
