//! Vector layers.

use super::elements::at_most;
use super::{Twin, filled, optional, source_path, unless_default};
use crate::stored::colour::StoredColour;
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::value::With;
use crate::stored::vector as stored;
use crate::{
    Casing, ClassMatch, ClassedBy, Hatch, Label, PointSymbol, StyleClass, Symbol, VectorLayer,
    VectorStyle, Width,
};

impl Twin for VectorLayer {
    type Stored = stored::Vector;

    fn from_stored(layer: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let text = |text: Option<String>, most, name| {
            text.map(|text| filled(text, most, &At::Member(at, name)))
                .transpose()
        };
        Ok(Self {
            path: source_path(layer.path, &At::Member(at, "path"))?,
            source_layer: text(layer.source_layer, range::LONGEST_NAME, "source_layer")?,
            crs: text(layer.crs, range::LONGEST_PATH, "crs")?,
            style: optional(layer.style, &At::Member(at, "style"))?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        stored::Vector {
            path: self.path.clone(),
            source_layer: self.source_layer.clone(),
            crs: self.crs.clone(),
            style: unless_default(&self.style, &&VectorStyle::default()).map(Twin::to_stored),
        }
    }
}

/// A member that has a twin and may be missing.
fn member<T: Twin>(stored: Option<T::Stored>, name: &str, at: &At<'_>) -> Result<Option<T>, Fault> {
    stored
        .map(|stored| T::from_stored(stored, &At::Member(at, name)))
        .transpose()
}

impl Twin for VectorStyle {
    type Stored = With<stored::VectorStyle>;

    fn from_stored(style: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = style;
        let default = Self::default();
        let dash = fields.dash.unwrap_or_default();
        at_most(
            dash.len(),
            range::MOST_DASHES,
            "lengths",
            &At::Member(at, "dash"),
        )?;
        Ok(Self {
            fill: fields.fill.map(|c| c.0),
            fill_opacity: fields.fill_opacity.unwrap_or(default.fill_opacity),
            stroke: fields.stroke.map(|c| c.0),
            stroke_width: member(fields.stroke_width, "stroke_width", at)?
                .unwrap_or(default.stroke_width),
            casing: member(fields.casing, "casing", at)?,
            dash,
            hatch: member(fields.hatch, "hatch", at)?,
            point: member(fields.point, "point", at)?,
            label: member(fields.label, "label", at)?,
            by: member(fields.by, "by", at)?,
            min_scale: fields.min_scale,
            max_scale: fields.max_scale,
            extrude: fields.extrude.map(|e| e.0),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: stored::VectorStyle {
                fill: self.fill.map(StoredColour),
                fill_opacity: unless_default(self.fill_opacity, &default.fill_opacity),
                stroke: self.stroke.map(StoredColour),
                stroke_width: unless_default(&self.stroke_width, &&default.stroke_width)
                    .map(Twin::to_stored),
                casing: self.casing.as_ref().map(Twin::to_stored),
                dash: (!self.dash.is_empty()).then(|| self.dash.clone()),
                hatch: self.hatch.as_ref().map(Twin::to_stored),
                point: self.point.as_ref().map(Twin::to_stored),
                label: self.label.as_ref().map(Twin::to_stored),
                by: self.by.as_ref().map(Twin::to_stored),
                min_scale: self.min_scale,
                max_scale: self.max_scale,
                extrude: self.extrude.clone().map(stored::StoredExtrude),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Width {
    type Stored = With<stored::Width>;

    fn from_stored(width: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            value: width.fields.value,
            unit: width.fields.unit.into(),
            extra: width.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Width {
                value: self.value,
                unit: self.unit.into(),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Casing {
    type Stored = With<stored::Casing>;

    fn from_stored(casing: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            colour: casing.fields.colour.0,
            width: Width::from_stored(casing.fields.width, &At::Member(at, "width"))?,
            extra: casing.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Casing {
                colour: StoredColour(self.colour),
                width: self.width.to_stored(),
            },
            extra: self.extra.clone(),
        }
    }
}

/// Direction of hatches, where a style does not say.
const HATCH_DEG: f64 = 45.0;

impl Twin for Hatch {
    type Stored = With<stored::Hatch>;

    fn from_stored(hatch: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = hatch;
        Ok(Self {
            spacing: Width::from_stored(fields.spacing, &At::Member(at, "spacing"))?,
            angle_deg: fields.angle_deg.unwrap_or(HATCH_DEG),
            colour: fields.colour.map(|c| c.0),
            width: member(fields.width, "width", at)?.unwrap_or(Width::px(1.0)),
            cross: fields.cross.unwrap_or(false),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Hatch {
                spacing: self.spacing.to_stored(),
                angle_deg: unless_default(self.angle_deg, &HATCH_DEG),
                colour: self.colour.map(StoredColour),
                width: unless_default(&self.width, &&Width::px(1.0)).map(Twin::to_stored),
                cross: unless_default(self.cross, &false),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for PointSymbol {
    type Stored = With<stored::PointSymbol>;

    fn from_stored(point: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = point;
        let default = Self::default();
        Ok(Self {
            symbol: fields.symbol.map_or(default.symbol, Into::into),
            size: member(fields.size, "size", at)?.unwrap_or(default.size),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: stored::PointSymbol {
                symbol: unless_default(self.symbol, &Symbol::default()).map(Into::into),
                size: unless_default(&self.size, &&default.size).map(Twin::to_stored),
            },
            extra: self.extra.clone(),
        }
    }
}

/// Height of letters in pixels, where a style does not say.
const LETTERS_PX: f64 = 12.0;
const BLACK: [u8; 3] = [0; 3];

impl Twin for Label {
    type Stored = With<stored::Label>;

    fn from_stored(label: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = label;
        Ok(Self {
            property: property(fields.property, at)?,
            size_px: fields.size_px.unwrap_or(LETTERS_PX),
            colour: fields.colour.map_or(BLACK, |c| c.0),
            halo: fields.halo.map(|c| c.0),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Label {
                property: self.property.clone(),
                size_px: unless_default(self.size_px, &LETTERS_PX),
                colour: unless_default(self.colour, &BLACK).map(StoredColour),
                halo: self.halo.map(StoredColour),
            },
            extra: self.extra.clone(),
        }
    }
}

fn property(name: String, at: &At<'_>) -> Result<String, Fault> {
    filled(name, range::LONGEST_NAME, &At::Member(at, "property"))
}

impl Twin for ClassedBy {
    type Stored = With<stored::ClassedBy>;

    fn from_stored(by: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = by;
        let place = At::Member(at, "classes");
        at_most(fields.classes.len(), range::MOST_CLASSES, "classes", &place)?;
        let classes = fields.classes.into_iter().enumerate();
        let classes =
            classes.map(|(i, class)| StyleClass::from_stored(class, &At::Element(&place, i)));
        Ok(Self {
            property: property(fields.property, at)?,
            classes: classes.collect::<Result<_, _>>()?,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::ClassedBy {
                property: self.property.clone(),
                classes: self.classes.iter().map(Twin::to_stored).collect(),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for StyleClass {
    type Stored = With<stored::StyleClass>;

    fn from_stored(class: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = class;
        let matches = match (fields.value, fields.min, fields.max) {
            (Some(stored::Scalar(value)), None, None) => ClassMatch::Value(value),
            (None, Some(min), Some(max)) if max < min => {
                let expected = format!("at least min, {min}");
                return Err(At::Member(at, "max").fault(expected, max.to_string()));
            }
            (None, min, max) if min.is_some() || max.is_some() => ClassMatch::Range { min, max },
            (Some(_), _, _) => return Err(at.fault("\"value\" or a range", "both")),
            (None, _, _) => return Err(at.fault("\"value\", \"min\" or \"max\"", "none")),
        };
        Ok(Self {
            matches,
            fill: fields.fill.map(|c| c.0),
            stroke: fields.stroke.map(|c| c.0),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let (value, min, max) = match &self.matches {
            ClassMatch::Value(value) => (Some(value.clone()), None, None),
            ClassMatch::Range { min, max } => (None, *min, *max),
        };
        With {
            fields: stored::StyleClass {
                value: value.map(stored::Scalar),
                min,
                max,
                fill: self.fill.map(StoredColour),
                stroke: self.stroke.map(StoredColour),
            },
            extra: self.extra.clone(),
        }
    }
}
