//! Version 1 of the file. Released: nothing here changes its meaning again; fields may be added.
//!
//! The documentation of a field is its description in the JSON Schema.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::adjust::Adjust;
use super::colour::StoredColour;
use super::colour_detail::ColourDetail;
use super::elements::Element;
use super::fault::{At, Fault, describe, quote};
use super::mask::Mask;
use super::range;
use super::relief::{Contours, Slope, Tint};
use super::scenarios::{Bookmark, Scenario};
use super::series::{Dated, StoredDate};
use super::stretch::StoredStretch;
use super::value::{Fields, InRange as _, Stored, With, object, put_extra};
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
    /// A planet: either `preset` or `radius_m`.
    Planet {
        /// A planet by name.
        preset: Option<Preset>,
        /// Radius in metres of the sphere that places the ground.
        radius_m: Option<f64> = range::RADIUS_M,
        /// Equatorial radius in metres of the ellipsoid that measures; `radius_m` where left out.
        equatorial_radius_m: Option<f64> = range::RADIUS_M,
        /// Flattening (a − b) / a of the ellipsoid; 0 where left out.
        flattening: Option<f64> = range::FLATTENING,
        /// Factor on heights in the picture; 1 where left out. Measurements are not exaggerated.
        vertical_exaggeration: Option<f64> = range::EXAGGERATION,
    }
}

/// A planet by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub(crate) enum Preset {
    /// Mean radius 6 371 008.8 m, WGS 84.
    Earth,
    /// IAU 2015.
    Mars,
    /// IAU 2015.
    Moon,
}

impl Stored for Preset {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        match value.as_str() {
            Some("earth") => Ok(Self::Earth),
            Some("mars") => Ok(Self::Mars),
            Some("moon") => Ok(Self::Moon),
            _ => Err(at.fault("one of earth mars moon", describe(&value))),
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Earth => "earth".into(),
            Self::Mars => "mars".into(),
            Self::Moon => "moon".into(),
        }
    }
}

fields! {
    /// Where the viewer is and looks.
    Camera {
        /// Longitude below the eye in degrees, east positive.
        lon_deg: f64 = range::TURN_DEG,
        /// Latitude below the eye in degrees.
        lat_deg: f64 = range::LATITUDE_DEG,
        /// Height of the eye above the datum in metres.
        altitude_m: f64 = range::ALTITUDE_M,
        /// Direction of view in degrees clockwise from north; 0 where left out.
        heading_deg: Option<f64> = range::TURN_DEG,
        /// Elevation of the view direction in degrees: −90 (where left out) looks down, 0 to the horizontal.
        pitch_deg: Option<f64> = range::LATITUDE_DEG,
        /// Vertical field of view in degrees; 60 where left out.
        fov_deg: Option<f64> = range::FIELD_OF_VIEW_DEG,
    }
}

fields! {
    /// How fine the picture is drawn.
    Quality {
        /// What decides how fine the picture is drawn; `adapter` where left out.
        aim: Option<Aim>,
        /// Error on the screen in pixels that the aim `error` allows; 0.5 where left out.
        error_px: Option<f64> = range::ERROR_PX,
        /// Samples along a side of a colour window; `auto` where left out.
        colour_window_samples: Option<ColourWindow>,
        /// Screen pixels that the finest texel should cover; 1 where left out.
        texel_px: Option<f64> = range::TEXEL_PX,
        /// Factor on the number of triangles of the automatic mesh; `auto` where left out.
        mesh_density: Option<MeshDensity>,
        /// Time on the graphics device in milliseconds that the aim `frame_time` allows a frame; 16 where left out.
        frame_budget_ms: Option<f64> = range::FRAME_BUDGET_MS,
    }
}

/// What decides how fine the picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub(crate) enum Aim {
    /// The graphics adapter, changed by `texel_px` and `mesh_density`.
    Adapter,
    /// The least cost at which errors stay below `error_px`.
    Error,
    /// The least error at which frames take no longer than `frame_budget_ms`.
    FrameTime,
}

impl Stored for Aim {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        match value.as_str() {
            Some("adapter") => Ok(Self::Adapter),
            Some("error") => Ok(Self::Error),
            Some("frame_time") => Ok(Self::FrameTime),
            _ => Err(at.fault("one of adapter error frame_time", describe(&value))),
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Adapter => "adapter".into(),
            Self::Error => "error".into(),
            Self::FrameTime => "frame_time".into(),
        }
    }
}

/// Samples along a side of a colour window, or the program's choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ColourWindow {
    /// The program chooses.
    Auto,
    /// One of [`range::COLOUR_WINDOWS`].
    Samples(u32),
}

impl Stored for ColourWindow {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        if value == "auto" {
            return Ok(Self::Auto);
        }
        let samples = value.as_u64().and_then(|n| u32::try_from(n).ok());
        samples
            .filter(|n| range::COLOUR_WINDOWS.contains(n))
            .map(Self::Samples)
            .ok_or_else(|| at.fault("\"auto\", 256, 512, 1024, 2048 or 4096", describe(&value)))
    }

    fn write(&self) -> Value {
        match self {
            Self::Auto => "auto".into(),
            Self::Samples(samples) => (*samples).into(),
        }
    }
}

impl JsonSchema for ColourWindow {
    fn schema_name() -> Cow<'static, str> {
        "ColourWindow".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut values = vec![Value::from("auto")];
        values.extend(range::COLOUR_WINDOWS.map(Value::from));
        json_schema!({ "enum": values })
    }
}

/// Factor on the number of triangles, or the program's choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MeshDensity {
    /// The program chooses.
    Auto,
    /// In [`range::MESH_DENSITY`].
    Factor(f64),
}

impl Stored for MeshDensity {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        if value == "auto" {
            return Ok(Self::Auto);
        }
        let Some(factor) = value.as_f64() else {
            return Err(at.fault("\"auto\" or a number", describe(&value)));
        };
        factor.check(&range::MESH_DENSITY, at)?;
        Ok(Self::Factor(factor))
    }

    fn write(&self) -> Value {
        match self {
            Self::Auto => "auto".into(),
            Self::Factor(factor) => factor.write(),
        }
    }
}

impl JsonSchema for MeshDensity {
    fn schema_name() -> Cow<'static, str> {
        "MeshDensity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [
            { "const": "auto" },
            { "type": "number", "minimum": range::MESH_DENSITY.min, "maximum": range::MESH_DENSITY.max },
        ]})
    }
}

fields! {
    /// A distant sun and an even sky.
    Sun {
        /// Direction towards the sun in degrees clockwise from north; 315 where left out.
        azimuth_deg: Option<f64> = range::TURN_DEG,
        /// Elevation of the sun above the horizontal in degrees; 45 where left out.
        elevation_deg: Option<f64> = range::LATITUDE_DEG,
        /// Share of light that comes evenly from the sky; 0.3 where left out.
        ambient: Option<f64> = range::SHARE,
        /// Longitude in degrees of the place where azimuth and elevation hold; with `anchor_lat_deg`.
        /// Below the viewer where both are left out.
        anchor_lon_deg: Option<f64> = range::TURN_DEG,
        /// Latitude in degrees of that place.
        anchor_lat_deg: Option<f64> = range::LATITUDE_DEG,
    }
}

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

fields! {
    /// Colours from a raster file.
    Imagery {
        /// The file: relative to the project's folder with forward slashes, or absolute.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        path: String,
        /// Replaces what the file says about its place.
        georeference: Option<With<Georeference>>,
        /// The value that means "no data", instead of the file's own.
        nodata: Option<f64> = range::NODATA,
        /// From where rows of a set of tiles count; as the set says where left out.
        tile_rows: Option<TileRows>,
        /// Which bands are red, green, blue (and alpha), counted from 1: one (grey), three or four.
        #[schemars(length(min = 1, max = 4))]
        bands: Option<Vec<u32>> => range::BAND,
        /// How stored numbers become colours; auto where left out.
        stretch: Option<StoredStretch>,
        /// How samples between pixels are made; bilinear where left out.
        resampling: Option<Resampling>,
        /// Width in metres over which the layer fades in from its edge; 0 where left out.
        edge_fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Metres from the edge of its data within which the layer's colours bend to those below; 0 where
        /// left out.
        seam_blend_m: Option<f64> = range::EDGE_FADE_M,
        /// Colour of what has no data within the file; what lies below shows where left out.
        missing: Option<StoredColour>,
        /// Detail beyond the file's resolution, the first at the bottom; none where left out.
        #[schemars(length(max = range::MOST_DETAILS))]
        detail: Option<Vec<With<ColourDetail>>>,
        /// How the colour meets what lies below; normal where left out.
        blend: Option<Blend>,
        /// Colour adjustment; none where left out.
        adjust: Option<With<Adjust>>,
    }
}

fields! {
    /// Heights from a raster file.
    Height {
        /// The file: relative to the project's folder with forward slashes, or absolute.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        path: String,
        /// Replaces what the file says about its place.
        georeference: Option<With<Georeference>>,
        /// The value that means "no data", instead of the file's own.
        nodata: Option<f64> = range::NODATA,
        /// How the colours of a set of tiles mean heights; as the set says where left out.
        encoding: Option<HeightEncoding>,
        /// From where rows of a set of tiles count; as the set says where left out.
        tile_rows: Option<TileRows>,
        /// Which band, counted from 1; the first where left out.
        band: Option<u32> = range::BAND,
        /// How samples between pixels are made; bilinear where left out.
        resampling: Option<Resampling>,
        /// Width in metres over which the layer fades in from its edge; 0 where left out.
        edge_fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Metres per unit of the file; 1 where left out.
        vertical_scale: Option<f64> = range::VERTICAL_SCALE,
        /// Metres added after scaling; 0 where left out.
        offset_m: Option<f64> = range::HEIGHT_M,
    }
}

fields! {
    /// Heights from fractal 3-D simplex noise.
    Noise {
        /// Chooses the pattern; 0 where left out.
        seed: Option<u32>,
        /// Largest height of the first octave in metres.
        amplitude_m: f64 = range::AMPLITUDE_M,
        /// Wavelength of the first octave in metres.
        wavelength_m: f64 = range::WAVELENGTH_M,
        /// Number of octaves; 8 where left out.
        octaves: Option<u32> = range::OCTAVES,
        /// Factor on the frequency from octave to octave; 2 where left out.
        lacunarity: Option<f64> = range::LACUNARITY,
        /// Factor on the amplitude from octave to octave; 0.5 where left out.
        gain: Option<f64> = range::SHARE,
        /// Whether octaves are folded to sharp ridges; false where left out.
        ridged: Option<bool>,
        /// Metres added to the noise; 0 where left out.
        offset_m: Option<f64> = range::HEIGHT_M,
        /// Whether the noise adds to the heights below or replaces them; add where left out.
        mode: Option<NoiseMode>,
    }
}

fields! {
    /// Replaces what a file says about its place: `crs`, or all four edges, or both. Edges are in
    /// degrees in geographic systems, else in the system's unit.
    Georeference {
        /// The coordinate system: `EPSG:n`, `ESRI:n` or a proj string.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        crs: Option<String>,
        /// Left edge of the image.
        west: Option<f64> = range::COORDINATE,
        /// Bottom edge of the image.
        south: Option<f64> = range::COORDINATE,
        /// Right edge of the image, above `west`.
        east: Option<f64> = range::COORDINATE,
        /// Top edge of the image, above `south`.
        north: Option<f64> = range::COORDINATE,
    }
}

names! {
    /// How the colours of a set of tiles mean heights.
    HeightEncoding for crate::HeightEncoding {
        /// Mapbox Terrain-RGB: −10 000 m + (65 536 R + 256 G + B) · 0.1 m.
        TerrainRgb = "terrain-rgb",
        /// 256 R + G + B / 256 − 32 768 m.
        Terrarium = "terrarium",
    }
}

names! {
    /// From where rows of a set of tiles count.
    TileRows for crate::TileRows {
        /// From north.
        Xyz = "xyz",
        /// From south.
        Tms = "tms",
    }
}

names! {
    /// How samples between pixels are made.
    Resampling for crate::Resampling {
        /// The nearest pixel.
        Nearest = "nearest",
        /// Linear between 2 × 2 pixels.
        Bilinear = "bilinear",
        /// Cubic between 4 × 4 pixels.
        Bicubic = "bicubic",
    }
}

names! {
    /// How a colour meets what lies below.
    Blend for crate::Blend {
        /// Covers.
        Normal = "normal",
        /// Product: darkens.
        Multiply = "multiply",
        /// Sum: lightens.
        Add = "add",
        /// Inverted product of the inverses: lightens gently.
        Screen = "screen",
        /// Multiply in shadows, screen in lights.
        Overlay = "overlay",
        /// Less the layer: darkens.
        Subtract = "subtract",
        /// How far the two are apart.
        Difference = "difference",
        /// Like the difference, with less contrast.
        Exclusion = "exclusion",
        /// The darker of each channel.
        Darken = "darken",
        /// The lighter of each channel.
        Lighten = "lighten",
        /// What lies below is lightened to reflect the layer.
        ColourDodge = "colour_dodge",
        /// What lies below is darkened to reflect the layer.
        ColourBurn = "colour_burn",
        /// Multiply where the layer is dark, screen where it is light.
        HardLight = "hard_light",
        /// Darkens or lightens gently, as the layer says.
        SoftLight = "soft_light",
        /// The layer's hue alone.
        Hue = "hue",
        /// The layer's saturation alone.
        Saturation = "saturation",
        /// The layer's hue and saturation.
        Colour = "colour",
        /// The layer's luminosity alone.
        Luminosity = "luminosity",
    }
}

fields! {
    /// Heights of the layers below, continued beyond their own resolution by the power law that they follow.
    Detail {
        /// Chooses the pattern; 0 where left out.
        seed: Option<u32>,
        /// Factor on the heights that are added; 1 where left out.
        strength: Option<f64> = range::FACTOR,
        /// How octaves are made; simplex where left out.
        method: Option<DetailMethod>,
        /// How much steeper ground is rougher; 0.5 where left out.
        slope: Option<f64> = range::SHARE,
        /// Lowest ground in metres that gets detail; any where left out.
        lowest_m: Option<f64> = range::HEIGHT_M,
        /// Highest ground in metres that gets detail, above `lowest_m`; any where left out.
        highest_m: Option<f64> = range::HEIGHT_M,
        /// Metres of height within these bounds over which it fades in; 50 where left out.
        fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Shortest wavelength in metres; 1 where left out.
        shortest_m: Option<f64> = range::WAVELENGTH_M,
    }
}

names! {
    /// How octaves of detail are made.
    DetailMethod for crate::DetailMethod {
        /// 3-D simplex noise.
        Simplex = "simplex",
        /// Sums of waves of all lengths.
        Spectral = "spectral",
    }
}

names! {
    /// How noise meets the heights below.
    NoiseMode for crate::NoiseMode {
        /// Replaces them.
        Replace = "replace",
        /// Adds to them.
        Add = "add",
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
