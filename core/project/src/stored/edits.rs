//! Edits as JSON: objects with a member `edit` that names the kind, as `relievo apply` reads them.
//!
//! Unlike in a project, a member that is not known is an error: a script's slip of the pen would
//! otherwise pass in silence.

mod check;
mod convert;

pub(crate) use check::{apart, check};

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::adjust::Adjust;
use super::colour::StoredColour;
use super::colour_detail::ColourDetail;
use super::elements::{Element, ElementStyle};
use super::fault::{At, Fault, describe, quote};
use super::mask::Mask;
use super::scenarios::{Bookmark, Change, LayerOverride, Scenario};
use super::series::{Dated, StoredDate};
use super::stretch::StoredStretch;
use super::value::{Fields, Stored, With, object};
use super::vector::VectorStyle;
use super::{blend, noise, range, rasters, relief, settings, v1};
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
    /// Changes how an imagery, tint, slope or contours layer meets the layers below.
    SetBlend = "set_blend" { id: String, blend: blend::Blend, }
    /// Gives a layer its place in a series of pictures of one ground at different times; in none where
    /// `dated` is left out.
    SetDated = "set_dated" { id: String, dated: Option<With<Dated>>, }
    /// Chooses the day that series of layers are shown at; the latest of each where `date` is left out.
    ShowDate = "show_date" { date: Option<StoredDate>, }
    /// Changes where a layer with colours shows; everywhere where `mask` is left out.
    SetMask = "set_mask" { id: String, mask: Option<With<Mask>>, }
    /// Replaces the colour adjustment of an imagery or tint layer.
    SetAdjust = "set_adjust" { id: String, adjust: With<Adjust>, }
    /// Changes how samples between a file's pixels are made.
    SetResampling = "set_resampling" { id: String, resampling: rasters::Resampling, }
    /// Changes the width in metres over which a file's edge fades.
    SetEdgeFade = "set_edge_fade" { id: String, edge_fade_m: f64 = range::EDGE_FADE_M, }
    /// Changes how many metres from the edge of its data an imagery layer bends to the colours below.
    SetSeamBlend = "set_seam_blend" { id: String, seam_blend_m: f64 = range::EDGE_FADE_M, }
    /// Changes the colour of what has no data in an imagery layer's file; what lies below where
    /// `missing` is left out.
    SetMissing = "set_missing" { id: String, missing: Option<StoredColour>, }
    /// Replaces the detail of an imagery layer beyond its file's resolution.
    SetColourDetail = "set_colour_detail" { id: String, detail: Vec<With<ColourDetail>>, }
    /// Links an imagery or height layer to another file.
    SetPath = "set_path" { id: String, path: String, }
    /// Places a file; as it says itself where `georeference` is left out.
    SetGeoreference = "set_georeference" { id: String, georeference: Option<With<rasters::Georeference>>, }
    /// Changes the value that means "no data"; the file's own where `nodata` is left out.
    SetNodata = "set_nodata" { id: String, nodata: Option<f64> = range::NODATA, }
    /// Changes how a set of tiles is read: as it says itself where a member is left out.
    SetTiles = "set_tiles" {
        id: String,
        encoding: Option<rasters::HeightEncoding>,
        tile_rows: Option<rasters::TileRows>,
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
    SetNoise = "set_noise" { id: String, noise: With<noise::Noise>, }
    /// Replaces a detail layer's parameters.
    SetDetail = "set_detail" { id: String, detail: With<noise::Detail>, }
    /// Replaces a tint layer's colours.
    SetTint = "set_tint" {
        id: String,
        stops: Vec<With<relief::TintStop>>,
        interpolation: Option<relief::TintInterpolation>,
    }
    /// Replaces a slope layer's colours.
    SetSlope = "set_slope" { id: String, slope: With<relief::Slope>, }
    /// Replaces what a layer of contour lines looks like.
    SetContours = "set_contours" { id: String, contours: With<relief::Contours>, }
    /// Replaces the planet and the exaggeration.
    SetPlanet = "set_planet" { planet: With<settings::Planet>, }
    /// Changes the exaggeration alone.
    SetExaggeration = "set_exaggeration" { vertical_exaggeration: f64 = range::EXAGGERATION, }
    /// Moves the viewer.
    SetCamera = "set_camera" { camera: With<settings::Camera>, }
    /// Replaces the light.
    SetSun = "set_sun" { sun: With<settings::Sun>, }
    /// Replaces the quality of the picture.
    SetQuality = "set_quality" { quality: With<settings::Quality>, }
    /// Replaces the style of a vector layer.
    SetVectorStyle = "set_vector_style" { id: String, style: With<VectorStyle>, }
    /// Changes how a vector layer's file is read: as it says itself where a member is left out.
    SetVectorSource = "set_vector_source" { id: String, source_layer: Option<String>, crs: Option<String>, }
    /// Adds a planning element to the base or to `scenario`, at a position counted from the bottom; on
    /// top where `index` is left out.
    AddElement = "add_element" { scenario: Option<String>, index: Option<u32>, element: Element, }
    /// Removes a planning element of the base or of `scenario`.
    RemoveElement = "remove_element" { scenario: Option<String>, id: String, }
    /// Puts a planning element in the place of the one with its id.
    ReplaceElement = "replace_element" { scenario: Option<String>, element: Element, }
    /// Moves a planning element to a position counted from the bottom, itself taken out first.
    MoveElement = "move_element" { scenario: Option<String>, id: String, index: u32, }
    /// Changes what people call a planning element.
    SetElementName = "set_element_name" { scenario: Option<String>, id: String, name: String, }
    /// Shows or hides a planning element.
    SetElementVisible = "set_element_visible" { scenario: Option<String>, id: String, visible: bool, }
    /// Locks or unlocks a planning element.
    SetElementLocked = "set_element_locked" { scenario: Option<String>, id: String, locked: bool, }
    /// Replaces the colours of a planning element.
    SetElementStyle = "set_element_style" { scenario: Option<String>, id: String, style: With<ElementStyle>, }
    /// Sets what a scenario changes about one element; as in its parent where `change` is left out.
    SetChange = "set_change" { scenario: String, id: String, index: Option<u32>, change: Option<Change>, }
    /// Sets everything that a scenario changes.
    SetChanges = "set_changes" { scenario: String, changes: Vec<Change>, }
    /// Adds a scenario at a position in the list; at the end where `index` is left out.
    AddScenario = "add_scenario" { index: Option<u32>, scenario: With<Scenario>, }
    /// Removes a scenario that no other is based on.
    RemoveScenario = "remove_scenario" { id: String, }
    /// Changes what people call a scenario.
    RenameScenario = "rename_scenario" { id: String, name: String, }
    /// Makes a copy of a scenario.
    DuplicateScenario = "duplicate_scenario" { id: String, new_id: String, name: String, }
    /// Makes the changes of a scenario in its parent or the base and removes the scenario.
    MergeScenario = "merge_scenario" { id: String, }
    /// Bases a scenario on another; on the base where `parent` is left out.
    SetScenarioParent = "set_scenario_parent" { id: String, parent: Option<String>, }
    /// Sets how a scenario shows one layer; as in its parent where `layer` is left out.
    SetScenarioLayer = "set_scenario_layer" {
        scenario: String,
        id: String,
        index: Option<u32>,
        layer: Option<With<LayerOverride>>,
    }
    /// Shows a scenario; the base where `id` is left out.
    ShowScenario = "show_scenario" { id: Option<String>, }
    /// Adds a bookmark at a position in the list; at the end where `index` is left out.
    AddBookmark = "add_bookmark" { index: Option<u32>, bookmark: With<Bookmark>, }
    /// Removes the bookmark at a position in the list.
    RemoveBookmark = "remove_bookmark" { index: u32, }
    /// Replaces the bookmark at a position in the list.
    ReplaceBookmark = "replace_bookmark" { index: u32, bookmark: With<Bookmark>, }
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
