//! Vector layers of version 1.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::colour::StoredColour;
use super::fault::{At, Fault, describe};
use super::range;
use super::value::{Stored, With};

fields! {
    /// Features from a vector file.
    Vector {
        /// The file: relative to the project's folder with forward slashes, or absolute.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        path: String,
        /// Which layer of a file that holds several; the first where left out.
        #[schemars(length(min = 1, max = range::LONGEST_NAME))]
        source_layer: Option<String>,
        /// The coordinate system, `EPSG:n`, `ESRI:n` or a proj string; the file's own where left out.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        crs: Option<String>,
        /// How features are drawn.
        style: Option<With<VectorStyle>>,
    }
}

fields! {
    /// How features are drawn.
    VectorStyle {
        /// Inside areas; not filled where left out.
        fill: Option<StoredColour>,
        /// How much the fill covers; 1 where left out.
        fill_opacity: Option<f64> = range::SHARE,
        /// Along lines and boundaries; not stroked where left out.
        stroke: Option<StoredColour>,
        /// Width of the stroke; 1 px where left out.
        stroke_width: Option<With<Width>>,
        /// A wider line below the stroke; none where left out.
        casing: Option<With<Casing>>,
        /// Lengths of strokes and gaps in turn, in the unit of the stroke's width; solid where left out.
        #[schemars(length(max = range::MOST_DASHES))]
        dash: Option<Vec<f64>> => range::WIDTH,
        /// Lines across areas; none where left out.
        hatch: Option<With<Hatch>>,
        /// Symbols at points; none where left out.
        point: Option<With<PointSymbol>>,
        /// Texts at features; none where left out.
        label: Option<With<Label>>,
        /// Colours by a property; all features alike where left out.
        by: Option<With<ClassedBy>>,
        /// Drawn only where the map's scale is 1 : n with n at least this.
        min_scale: Option<f64> = range::SCALE,
        /// Drawn only where the map's scale is 1 : n with n at most this.
        max_scale: Option<f64> = range::SCALE,
        /// How high areas stand as masses; flat where left out.
        extrude: Option<StoredExtrude>,
    }
}

names! {
    /// What a width is measured in.
    WidthUnit for crate::WidthUnit {
        /// Metres on the ground.
        Metres = "m",
        /// Pixels on the screen.
        Pixels = "px",
    }
}

fields! {
    /// A width on the ground or on the screen.
    Width {
        /// In `unit`.
        value: f64 = range::WIDTH,
        /// Metres or pixels.
        unit: WidthUnit,
    }
}

fields! {
    /// A wider line below a stroke.
    Casing {
        /// Its colour.
        colour: StoredColour,
        /// How far it stands out on each side of the stroke.
        width: With<Width>,
    }
}

fields! {
    /// Parallel lines across areas.
    Hatch {
        /// Distance between lines.
        spacing: With<Width>,
        /// Direction of the lines in degrees clockwise from north; 45 where left out.
        angle_deg: Option<f64> = range::TURN_DEG,
        /// Their colour; the stroke's where left out.
        colour: Option<StoredColour>,
        /// Their width; 1 px where left out.
        width: Option<With<Width>>,
        /// Whether a second set crosses the first at a right angle; false where left out.
        cross: Option<bool>,
    }
}

names! {
    /// The shape of a point symbol.
    Symbol for crate::Symbol {
        /// A disc.
        Circle = "circle",
        /// A square on its side.
        Square = "square",
        /// A square on its corner.
        Diamond = "diamond",
        /// A triangle, pointing up.
        Triangle = "triangle",
        /// An upright cross.
        Cross = "cross",
        /// A star of five points.
        Star = "star",
    }
}

fields! {
    /// A symbol at a point.
    PointSymbol {
        /// Its shape; a circle where left out.
        symbol: Option<Symbol>,
        /// Its diameter; 6 px where left out.
        size: Option<With<Width>>,
    }
}

fields! {
    /// Texts at features.
    Label {
        /// The property that holds the text.
        #[schemars(length(min = 1, max = range::LONGEST_NAME))]
        property: String,
        /// Height of the letters in pixels; 12 where left out.
        size_px: Option<f64> = range::LABEL_PX,
        /// Colour of the letters; black where left out.
        colour: Option<StoredColour>,
        /// Colour around the letters; none where left out.
        halo: Option<StoredColour>,
    }
}

fields! {
    /// Colours by a property of the features; the first class that fits counts.
    ClassedBy {
        /// The property.
        #[schemars(length(min = 1, max = range::LONGEST_NAME))]
        property: String,
        /// The classes.
        #[schemars(length(max = range::MOST_CLASSES))]
        classes: Vec<With<StyleClass>>,
    }
}

fields! {
    /// Features of a property's value, or of numbers from `min` (included) to `max` (excluded).
    StyleClass {
        /// A text, a number, true or false.
        value: Option<Scalar>,
        /// Lowest number inside; no limit where left out.
        min: Option<f64> = range::NODATA,
        /// Lowest number above; no limit where left out.
        max: Option<f64> = range::NODATA,
        /// Inside areas; the style's where left out.
        fill: Option<StoredColour>,
        /// Along lines and boundaries; the style's where left out.
        stroke: Option<StoredColour>,
    }
}

/// A text, a number, true or false.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scalar(pub(crate) Value);

impl Stored for Scalar {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        match value {
            Value::Bool(_) | Value::Number(_) | Value::String(_) => Ok(Self(value)),
            Value::Null | Value::Array(_) | Value::Object(_) => {
                Err(at.fault("a text, a number, true or false", describe(&value)))
            }
        }
    }

    fn write(&self) -> Value {
        self.0.clone()
    }
}

impl JsonSchema for Scalar {
    fn schema_name() -> Cow<'static, str> {
        "Scalar".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["string", "number", "boolean"] })
    }
}

/// How high areas stand: `{"height_m": n}` or `{"property": "name"}`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StoredExtrude(pub(crate) crate::Extrude);

impl Stored for StoredExtrude {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let one = |name: &str| value.as_object().filter(|o| o.len() == 1)?.get(name);
        let most = range::REACH_M.max;
        let height_m = one("height_m").and_then(Value::as_f64);
        let property = one("property").and_then(Value::as_str);
        let is_name = |name: &&str| (1..=range::LONGEST_NAME).contains(&name.len());
        match (height_m, property.filter(is_name)) {
            (Some(height_m), _) if (0.0..=most).contains(&height_m) => {
                Ok(Self(crate::Extrude::HeightM(height_m)))
            }
            (_, Some(property)) => Ok(Self(crate::Extrude::Property(property.to_owned()))),
            _ => Err(at.fault(
                format!("{{\"height_m\": 0 to {most}}} or {{\"property\": a name}}"),
                value.to_string().chars().take(60).collect::<String>(),
            )),
        }
    }

    fn write(&self) -> Value {
        match &self.0 {
            crate::Extrude::HeightM(height_m) => serde_json::json!({ "height_m": height_m }),
            crate::Extrude::Property(property) => serde_json::json!({ "property": property }),
        }
    }
}

impl JsonSchema for StoredExtrude {
    fn schema_name() -> Cow<'static, str> {
        "Extrude".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let one = |name: &str, schema: Value| {
            serde_json::json!({
                "type": "object",
                "properties": { name: schema },
                "required": [name],
                "additionalProperties": false,
            })
        };
        let height =
            serde_json::json!({ "type": "number", "minimum": 0.0, "maximum": range::REACH_M.max });
        let name = serde_json::json!({ "type": "string", "minLength": 1, "maxLength": range::LONGEST_NAME });
        json_schema!({
            "description": "How high areas stand as masses: metres above the ground, or a property that holds them.",
            "anyOf": [one("height_m", height), one("property", name)],
        })
    }
}
