//! Where a layer shows as it lies in version 1 of the file.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::fault::{At, Fault, describe};
use super::range;
use super::value::{InRange as _, Stored, With};

fields! {
    /// Where a layer shows: where all that is given holds at once.
    Mask {
        /// Heights of the shown ground; any where left out.
        heights: Option<With<MaskHeights>>,
        /// Steepness of the shown ground; any where left out.
        slopes: Option<With<MaskSlopes>>,
        /// A circle on the ground; anywhere where left out.
        circle: Option<With<MaskCircle>>,
        /// A polygon on the ground, never beside a circle; anywhere where left out.
        polygon: Option<With<MaskPolygon>>,
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

fields! {
    /// A polygon on the ground.
    MaskPolygon {
        /// Longitude of the place that its corners are measured from, in degrees, east positive.
        lon_deg: f64 = range::TURN_DEG,
        /// Latitude of that place in degrees.
        lat_deg: f64 = range::LATITUDE_DEG,
        /// Its corners.
        corners_m: StoredCorners,
        /// Metres beyond it over which the layer fades out; 0 where left out.
        fade_m: Option<f64> = range::LENS_M,
    }
}

/// The corners of a polygon as they are stored: an array of `[east, north]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StoredCorners(pub(crate) Vec<[f64; 2]>);

impl Stored for StoredCorners {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let Value::Array(items) = value else {
            return Err(at.fault("an array of corners", describe(&value)));
        };
        let (least, most) = (range::CORNERS.min, range::CORNERS.max);
        if !(least..=most).contains(&items.len()) {
            let expected = format!("{least} to {most} corners");
            return Err(at.fault(expected, items.len().to_string()));
        }
        let corners = items.iter().enumerate();
        let corners = corners.map(|(i, item)| corner(item, &At::Element(at, i)));
        Ok(Self(corners.collect::<Result<_, _>>()?))
    }

    fn write(&self) -> Value {
        let corner = |corner: &[f64; 2]| -> Value { corner.iter().map(Stored::write).collect() };
        self.0.iter().map(corner).collect()
    }
}

fn corner(item: &Value, at: &At<'_>) -> Result<[f64; 2], Fault> {
    const EXPECTED: &str = "[east, north] in metres";
    let Some([east, north]) = item.as_array().map(Vec::as_slice) else {
        return Err(at.fault(EXPECTED, describe(item)));
    };
    let (Some(east_m), Some(north_m)) = (east.as_f64(), north.as_f64()) else {
        return Err(at.fault(EXPECTED, item.to_string()));
    };
    east_m.check(&range::CORNER_M, &At::Element(at, 0))?;
    north_m.check(&range::CORNER_M, &At::Element(at, 1))?;
    Ok([east_m, north_m])
}

impl JsonSchema for StoredCorners {
    fn schema_name() -> Cow<'static, str> {
        "Corners".into()
    }

    fn json_schema(_generator: &mut SchemaGenerator) -> Schema {
        let number = json!({
            "type": "number",
            "minimum": range::CORNER_M.min,
            "maximum": range::CORNER_M.max,
        });
        json_schema!({
            "description": "Corners of a polygon: metres east and north of its place, in an azimuthal equidistant frame on the ellipsoid. Inside is by the even-odd rule.",
            "type": "array",
            "items": {
                "type": "array",
                "items": number,
                "minItems": 2,
                "maxItems": 2,
            },
            "minItems": range::CORNERS.min,
            "maxItems": range::CORNERS.max,
        })
    }
}
