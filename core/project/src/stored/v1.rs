//! Version 1 of the file. Released: nothing here changes its meaning again; fields may be added.
//!
//! The documentation of a field is its description in the JSON Schema.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::elements::Element;
use super::fault::{At, Fault, quote};
use super::mask::Mask;
use super::noise::{Detail, Noise};
use super::range;
use super::rasters::{Height, Imagery};
use super::relief::{Contours, Slope, Tint};
use super::scenarios::{Bookmark, Scenario};
use super::series::{Dated, StoredDate};
use super::settings::{Camera, Planet, Quality, Sun};
use super::value::{Fields, Stored, With, object, put_extra};
use super::vector::Vector;
use crate::Extra;

/// The number of this version.
pub(crate) const VERSION: u32 = 1;

fields! {
    /// A Relievo project. Members that are left out have their defaults; members that a program does
    /// not know are kept.
    #[schemars(title = "Relievo project")]
    Project {
        /// Version of the format.
        version: u32 = VERSION_RANGE,
        /// The planet; Earth where left out.
        planet: Option<With<Planet>>,
        /// Where the viewer is when the project opens.
        camera: Option<With<Camera>>,
        /// How fine the picture is drawn.
        quality: Option<With<Quality>>,
        /// The light.
        sun: Option<With<Sun>>,
        /// All layers, the bottom one first. Ids are unique.
        layers: Option<Vec<Layer>>,
        /// Planning elements of the base, the bottom one first; later ones win. Ids are unique.
        #[schemars(length(max = range::MOST_ELEMENTS))]
        elements: Option<Vec<Element>>,
        /// Named deltas on the base. Ids are unique, parents form a tree.
        #[schemars(length(max = range::MOST_SCENARIOS))]
        scenarios: Option<Vec<With<Scenario>>>,
        /// Id of the scenario that is shown; the base where left out.
        scenario: Option<String>,
        /// The day that series of layers are shown at; their latest where left out.
        date: Option<StoredDate>,
        /// Places to go back to.
        #[schemars(length(max = range::MOST_BOOKMARKS))]
        bookmarks: Option<Vec<With<Bookmark>>>,
    }
}

/// Only this version.
const VERSION_RANGE: range::Range<u32> = range::Range {
    min: VERSION,
    max: VERSION,
};

fields! {
    /// What every layer has.
    LayerBase {
        /// Stable id, unique in the project: letters, digits, `-`, `_` and `.`.
        #[schemars(regex(pattern = r"^[A-Za-z0-9._-]{1,64}$"))]
        id: String,
        /// What people call it; the id where left out.
        #[schemars(length(max = range::LONGEST_NAME))]
        name: Option<String>,
        /// `imagery`, `height`, `noise`, `detail`, `tint`, `slope`, `contours`, `vector`; layers of other kinds are kept and have no effect.
        kind: String,
        /// Whether the layer takes part; true where left out.
        visible: Option<bool>,
        /// How much of it covers what lies below; 1 where left out.
        opacity: Option<f64> = range::SHARE,
        /// Whether edits in the window are refused; false where left out.
        locked: Option<bool>,
        /// Where a layer with colours shows; everywhere where left out.
        mask: Option<With<Mask>>,
        /// The layer's place in a series of pictures of one ground at different times; none where left out.
        dated: Option<With<Dated>>,
    }
}

/// A layer: what all have, and what its kind has, in one object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layer {
    /// What every layer has.
    pub(crate) base: LayerBase,
    /// What its kind has.
    pub(crate) kind: LayerKind,
    /// The rest.
    pub(crate) extra: Extra,
}

/// What a kind of layer has of its own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LayerKind {
    /// `imagery`.
    Imagery(Box<Imagery>),
    /// `height`.
    Height(Height),
    /// `noise`.
    Noise(Noise),
    /// `detail`.
    Detail(Detail),
    /// `tint`.
    Tint(Box<Tint>),
    /// `slope`.
    Slope(Slope),
    /// `contours`.
    Contours(Contours),
    /// `vector`.
    Vector(Box<Vector>),
    /// Any other: everything is in [`Layer::extra`].
    Unknown,
}

/// Kinds of layers that this version knows.
pub(crate) const KINDS: [&str; 8] = [
    "imagery", "height", "noise", "detail", "tint", "slope", "contours", "vector",
];

impl Stored for Layer {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let mut map = object(value, at)?;
        let base = LayerBase::take(&mut map, at)?;
        let kind = match base.kind.as_str() {
            "imagery" => LayerKind::Imagery(Box::new(Imagery::take(&mut map, at)?)),
            "height" => LayerKind::Height(Height::take(&mut map, at)?),
            "noise" => LayerKind::Noise(Noise::take(&mut map, at)?),
            "detail" => LayerKind::Detail(Detail::take(&mut map, at)?),
            "tint" => LayerKind::Tint(Box::new(Tint::take(&mut map, at)?)),
            "slope" => LayerKind::Slope(Slope::take(&mut map, at)?),
            "contours" => LayerKind::Contours(Contours::take(&mut map, at)?),
            "vector" => LayerKind::Vector(Box::new(Vector::take(&mut map, at)?)),
            "" => return Err(At::Member(at, "kind").fault("a kind of layer", quote(&base.kind))),
            _ => LayerKind::Unknown,
        };
        Ok(Self {
            base,
            kind,
            extra: map,
        })
    }

    fn write(&self) -> Value {
        let mut map = Extra::new();
        self.base.put(&mut map);
        let own = match &self.kind {
            LayerKind::Imagery(imagery) => put(imagery.as_ref(), &mut map),
            LayerKind::Height(height) => put(height, &mut map),
            LayerKind::Noise(noise) => put(noise, &mut map),
            LayerKind::Detail(detail) => put(detail, &mut map),
            LayerKind::Tint(tint) => put(&**tint, &mut map),
            LayerKind::Slope(slope) => put(slope, &mut map),
            LayerKind::Contours(contours) => put(contours, &mut map),
            LayerKind::Vector(vector) => put(vector.as_ref(), &mut map),
            LayerKind::Unknown => &[],
        };
        put_extra(&self.extra, &[LayerBase::NAMES, own], &mut map);
        Value::Object(map)
    }
}

/// Puts the fields and gives their names.
fn put<T: Fields>(fields: &T, map: &mut Extra) -> &'static [&'static str] {
    fields.put(map);
    T::NAMES
}

impl JsonSchema for Layer {
    fn schema_name() -> Cow<'static, str> {
        "Layer".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut all = vec![generator.subschema_for::<LayerBase>().to_value()];
        let kinds = [
            generator.subschema_for::<Imagery>(),
            generator.subschema_for::<Height>(),
            generator.subschema_for::<Noise>(),
            generator.subschema_for::<Detail>(),
            generator.subschema_for::<Tint>(),
            generator.subschema_for::<Slope>(),
            generator.subschema_for::<Contours>(),
            generator.subschema_for::<Vector>(),
        ];
        for (kind, fields) in KINDS.iter().zip(kinds) {
            all.push(serde_json::json!({
                "if": { "properties": { "kind": { "const": kind } }, "required": ["kind"] },
                "then": fields,
            }));
        }
        json_schema!({ "description": "One layer of the stack.", "type": "object", "allOf": all })
    }
}
