//! Edits as JSON: objects with a member `edit` that names the kind, as `relievo apply` reads them.
//!
//! Unlike in a project, a member that is not known is an error: a script's slip of the pen would
//! otherwise pass in silence.

mod convert;

pub(crate) use convert::check;

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::fault::{At, Fault, describe, quote};
use super::stretch::StoredStretch;
use super::value::{Fields, Stored, With, object};
use super::{range, v1};
use crate::Extra;

macro_rules! stored_edits {
    ($($(#[$doc:meta])* $name:ident = $tag:literal { $($body:tt)* })*) => {
        $(fields! { $(#[$doc])* $name { $($body)* } })*

        /// One edit.
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) enum StoredEdit {
            $($(#[$doc])* $name($name),)*
        }

        impl StoredEdit {
            fn take(tag: &str, map: &mut Extra, at: &At<'_>) -> Option<Result<Self, Fault>> {
                match tag {
                    $($tag => Some($name::take(map, at).map(Self::$name)),)*
                    _ => None,
                }
            }

            fn put(&self, map: &mut Extra) {
                match self {
                    $(Self::$name(edit) => {
                        map.insert("edit".to_owned(), $tag.into());
                        edit.put(map);
                    })*
                }
            }
        }

        impl JsonSchema for StoredEdit {
            fn schema_name() -> Cow<'static, str> {
                "Edit".into()
            }

            fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                let all = vec![$(tagged($name::json_schema(generator), $tag),)*];
                json_schema!({ "description": "One change of a project.", "oneOf": all })
            }
        }
    };
}

/// The schema of an edit's fields with the member that names its kind, and no others.
fn tagged(mut schema: Schema, tag: &str) -> Schema {
    let members = schema.ensure_object();
    let properties = members
        .entry("properties")
        .or_insert_with(|| Extra::new().into());
    if let Value::Object(properties) = properties {
        properties.insert("edit".to_owned(), serde_json::json!({ "const": tag }));
    }
    let required = members
        .entry("required")
        .or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(required) = required {
        required.insert(0, "edit".into());
    }
    members.insert("additionalProperties".to_owned(), false.into());
    schema
}

stored_edits! {
    /// Adds a layer at a position counted from the bottom; on top where `index` is left out.
    AddLayer = "add_layer" { index: Option<u32>, layer: v1::Layer, }
    /// Removes a layer.
    RemoveLayer = "remove_layer" { id: String, }
    /// Moves a layer to a position counted from the bottom, the layer itself taken out first.
    MoveLayer = "move_layer" { id: String, index: u32, }
    /// Changes what people call a layer.
    SetName = "set_name" { id: String, name: String, }
    /// Shows or hides a layer.
    SetVisible = "set_visible" { id: String, visible: bool, }
    /// Changes a layer's opacity.
    SetOpacity = "set_opacity" { id: String, opacity: f64 = range::SHARE, }
    /// Locks or unlocks a layer.
    SetLocked = "set_locked" { id: String, locked: bool, }
    /// Changes how an imagery or tint layer meets the layers below.
    SetBlend = "set_blend" { id: String, blend: v1::Blend, }
    /// Replaces the colour adjustment of an imagery or tint layer.
    SetAdjust = "set_adjust" { id: String, adjust: With<v1::Adjust>, }
    /// Changes how samples between a file's pixels are made.
    SetResampling = "set_resampling" { id: String, resampling: v1::Resampling, }
    /// Changes the width in metres over which a file's edge fades.
    SetEdgeFade = "set_edge_fade" { id: String, edge_fade_m: f64 = range::EDGE_FADE_M, }
    /// Links an imagery or height layer to another file.
    SetPath = "set_path" { id: String, path: String, }
    /// Places a file; as it says itself where `georeference` is left out.
    SetGeoreference = "set_georeference" { id: String, georeference: Option<With<v1::Georeference>>, }
    /// Changes the value that means "no data"; the file's own where `nodata` is left out.
    SetNodata = "set_nodata" { id: String, nodata: Option<f64> = range::NODATA, }
    /// Changes how a set of tiles is read: as it says itself where a member is left out.
    SetTiles = "set_tiles" {
        id: String,
        encoding: Option<v1::HeightEncoding>,
        tile_rows: Option<v1::TileRows>,
    }
    /// Chooses bands, counted from 1; as the file says where `bands` is left out.
    SetBands = "set_bands" { id: String, bands: Option<Vec<u32>> => range::BAND, }
    /// Changes how stored numbers of an imagery layer become colours; auto where `stretch` is left out.
    SetStretch = "set_stretch" { id: String, stretch: Option<StoredStretch>, }
    /// Changes how a height layer's values become metres.
    SetHeightScale = "set_height_scale" {
        id: String,
        vertical_scale: f64 = range::VERTICAL_SCALE,
        offset_m: f64 = range::HEIGHT_M,
    }
    /// Replaces a noise layer's parameters.
    SetNoise = "set_noise" { id: String, noise: With<v1::Noise>, }
    /// Replaces a tint layer's colours.
    SetTint = "set_tint" {
        id: String,
        stops: Vec<With<v1::TintStop>>,
        interpolation: Option<v1::TintInterpolation>,
    }
    /// Replaces the planet and the exaggeration.
    SetPlanet = "set_planet" { planet: With<v1::Planet>, }
    /// Changes the exaggeration alone.
    SetExaggeration = "set_exaggeration" { vertical_exaggeration: f64 = range::EXAGGERATION, }
    /// Moves the viewer.
    SetCamera = "set_camera" { camera: With<v1::Camera>, }
    /// Replaces the light.
    SetSun = "set_sun" { sun: With<v1::Sun>, }
    /// Replaces the quality of the picture.
    SetQuality = "set_quality" { quality: With<v1::Quality>, }
    /// Several edits as one.
    Batch = "batch" { label: Option<String>, edits: Vec<StoredEdit>, }
}

impl Stored for StoredEdit {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let mut map = object(value, at)?;
        let tag = String::read_member(map.shift_remove("edit"), "edit", at)?;
        let Some(edit) = Self::take(&tag, &mut map, at) else {
            return Err(At::Member(at, "edit")
                .fault("the name of an edit, such as set_opacity", quote(&tag)));
        };
        let edit = edit?;
        if let Some((name, value)) = map.into_iter().next() {
            return Err(
                At::Member(at, &name).fault(format!("no such member in {tag}"), describe(&value))
            );
        }
        Ok(edit)
    }

    fn write(&self) -> Value {
        let mut map = Extra::new();
        self.put(&mut map);
        Value::Object(map)
    }
}
