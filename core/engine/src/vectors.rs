//! Vector layers: from what a project says of a style to what is drawn.

use std::sync::Arc;

use relievo_project::{
    ClassMatch, PointSymbol, Symbol as ProjectSymbol, VectorStyle, Width, WidthUnit,
};
use relievo_vector::style::{
    By, Class, ClassOf, Colour, Hatch, Length, Style, Symbol, SymbolShape,
};
use relievo_vector::{Features, Summary, Value};

/// Metres of a pixel on a map of scale 1 : 1, at 96 dots per inch.
const PIXEL_M: f64 = 0.0254 / 96.0;

/// Samples finer than this show nothing new of a line, in metres.
pub(crate) const FINEST_M: f64 = 0.05;

/// A vector file that is open.
#[derive(Debug)]
pub struct OpenFeatures {
    /// What it holds.
    pub features: Arc<Features>,
    /// What it says of itself.
    pub summary: Summary,
}

/// A project's style as features are drawn with.
pub(crate) fn style(from: &VectorStyle) -> Style {
    let fill = |c: [u8; 3]| colour(c, from.fill_opacity);
    Style {
        fill: from.fill.map(fill),
        stroke: from.stroke.map(opaque),
        stroke_width: Some(length(&from.stroke_width)),
        casing: from
            .casing
            .as_ref()
            .map(|c| (opaque(c.colour), length(&c.width))),
        dash: from.dash.clone(),
        hatch: from.hatch.as_ref().map(|h| Hatch {
            colour: opaque(h.colour.or(from.stroke).unwrap_or_default()),
            spacing: length(&h.spacing),
            width: length(&h.width),
            angle_deg: h.angle_deg,
            crossed: h.cross,
        }),
        symbol: from.point.as_ref().map(symbol),
        by: from.by.as_ref().map(|by| By {
            property: by.property.clone(),
            classes: by
                .classes
                .iter()
                .map(|class| Class {
                    of: match &class.matches {
                        ClassMatch::Value(value) => ClassOf::Equals(of_json(value)),
                        ClassMatch::Range { min, max } => ClassOf::Range {
                            min: *min,
                            max: *max,
                        },
                    },
                    fill: class.fill.map(fill),
                    stroke: class.stroke.map(opaque),
                })
                .collect(),
        }),
        min_sample_m: from.min_scale.map(|n| n * PIXEL_M),
        max_sample_m: from.max_scale.map(|n| n * PIXEL_M),
    }
}

fn colour(rgb: [u8; 3], alpha: f64) -> Colour {
    let [r, g, b] = rgb.map(relievo_raster::colour::from_u8);
    [r, g, b, alpha as f32]
}

fn opaque(rgb: [u8; 3]) -> Colour {
    colour(rgb, 1.0)
}

fn length(width: &Width) -> Length {
    match width.unit {
        WidthUnit::Metres => Length::Metres(width.value),
        WidthUnit::Pixels => Length::Pixels(width.value),
    }
}

fn symbol(point: &PointSymbol) -> Symbol {
    Symbol {
        shape: match point.symbol {
            ProjectSymbol::Circle => SymbolShape::Circle,
            ProjectSymbol::Square => SymbolShape::Square,
            ProjectSymbol::Diamond => SymbolShape::Diamond,
            ProjectSymbol::Triangle => SymbolShape::Triangle,
            ProjectSymbol::Cross => SymbolShape::Cross,
            ProjectSymbol::Star => SymbolShape::Star,
        },
        size: length(&point.size),
    }
}

/// A value of a class; lists and objects are compared by their text, as readers keep them.
fn of_json(value: &serde_json::Value) -> Value {
    match value {
        serde_json::Value::Null => Value::Null,
        serde_json::Value::Bool(v) => Value::Bool(*v),
        serde_json::Value::Number(v) => match (v.as_i64(), v.as_f64()) {
            (Some(v), _) => Value::Int(v),
            (None, Some(v)) => Value::Float(v),
            (None, None) => Value::Null,
        },
        serde_json::Value::String(v) => Value::from(v.as_str()),
        other @ (serde_json::Value::Array(_) | serde_json::Value::Object(_)) => {
            Value::from(other.to_string().as_str())
        }
    }
}
