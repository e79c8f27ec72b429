//! The planet, the viewer, the light and the quality as they lie in version 1 of the file.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::fault::{At, Fault, describe};
use super::range;
use super::value::{InRange as _, Stored};

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
