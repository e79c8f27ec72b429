//! Planet, camera, quality and sun.

use relievo_planet::Planet;

use super::{Twin, unless_default};
use crate::stored::fault::{At, Fault};
use crate::stored::settings;
use crate::stored::value::With;
use crate::{Aim, Auto, Body, CameraSettings, PlanetSettings, Quality, Sun, SunAnchor};

impl Twin for PlanetSettings {
    type Stored = With<settings::Planet>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let figure_given = fields.radius_m.is_some()
            || fields.equatorial_radius_m.is_some()
            || fields.flattening.is_some();
        let body = match (fields.preset, fields.radius_m) {
            (Some(_), _) if figure_given => {
                return Err(at.fault("a preset or a figure", "both"));
            }
            (Some(settings::Preset::Earth), _) => Body::Earth,
            (Some(settings::Preset::Mars), _) => Body::Mars,
            (Some(settings::Preset::Moon), _) => Body::Moon,
            (None, Some(radius_m)) => Body::Custom(Planet {
                radius_m,
                equatorial_radius_m: fields.equatorial_radius_m.unwrap_or(radius_m),
                flattening: fields.flattening.unwrap_or(0.0),
            }),
            (None, None) => {
                return Err(at.fault("a member \"preset\" or \"radius_m\"", "none"));
            }
        };
        Ok(Self {
            body,
            vertical_exaggeration: fields.vertical_exaggeration.unwrap_or(1.0),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let preset = match self.body {
            Body::Earth => Some(settings::Preset::Earth),
            Body::Mars => Some(settings::Preset::Mars),
            Body::Moon => Some(settings::Preset::Moon),
            Body::Custom(_) => None,
        };
        let figure = match self.body {
            Body::Custom(figure) => Some(figure),
            Body::Earth | Body::Mars | Body::Moon => None,
        };
        With {
            fields: settings::Planet {
                preset,
                radius_m: figure.map(|f| f.radius_m),
                equatorial_radius_m: figure
                    .and_then(|f| unless_default(f.equatorial_radius_m, &f.radius_m)),
                flattening: figure.and_then(|f| unless_default(f.flattening, &0.0)),
                vertical_exaggeration: unless_default(self.vertical_exaggeration, &1.0),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for CameraSettings {
    type Stored = With<settings::Camera>;

    fn from_stored(stored: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let default = Self::default();
        Ok(Self {
            lon_deg: fields.lon_deg,
            lat_deg: fields.lat_deg,
            altitude_m: fields.altitude_m,
            heading_deg: fields.heading_deg.unwrap_or(default.heading_deg),
            pitch_deg: fields.pitch_deg.unwrap_or(default.pitch_deg),
            fov_deg: fields.fov_deg.unwrap_or(default.fov_deg),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: settings::Camera {
                lon_deg: self.lon_deg,
                lat_deg: self.lat_deg,
                altitude_m: self.altitude_m,
                heading_deg: unless_default(self.heading_deg, &default.heading_deg),
                pitch_deg: unless_default(self.pitch_deg, &default.pitch_deg),
                fov_deg: unless_default(self.fov_deg, &default.fov_deg),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Quality {
    type Stored = With<settings::Quality>;

    fn from_stored(stored: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let default = Self::default();
        Ok(Self {
            aim: match fields.aim {
                None | Some(settings::Aim::Adapter) => Aim::Adapter,
                Some(settings::Aim::Error) => Aim::Error,
                Some(settings::Aim::FrameTime) => Aim::FrameTime,
            },
            error_px: fields.error_px.unwrap_or(default.error_px),
            colour_window_samples: match fields.colour_window_samples {
                None | Some(settings::ColourWindow::Auto) => Auto::Auto,
                Some(settings::ColourWindow::Samples(samples)) => Auto::Value(samples),
            },
            texel_px: fields.texel_px.unwrap_or(default.texel_px),
            mesh_density: match fields.mesh_density {
                None | Some(settings::MeshDensity::Auto) => Auto::Auto,
                Some(settings::MeshDensity::Factor(factor)) => Auto::Value(factor),
            },
            frame_budget_ms: fields.frame_budget_ms.unwrap_or(default.frame_budget_ms),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: settings::Quality {
                aim: match self.aim {
                    Aim::Adapter => None,
                    Aim::Error => Some(settings::Aim::Error),
                    Aim::FrameTime => Some(settings::Aim::FrameTime),
                },
                error_px: unless_default(self.error_px, &default.error_px),
                colour_window_samples: match self.colour_window_samples {
                    Auto::Auto => None,
                    Auto::Value(samples) => Some(settings::ColourWindow::Samples(samples)),
                },
                texel_px: unless_default(self.texel_px, &default.texel_px),
                mesh_density: match self.mesh_density {
                    Auto::Auto => None,
                    Auto::Value(factor) => Some(settings::MeshDensity::Factor(factor)),
                },
                frame_budget_ms: unless_default(self.frame_budget_ms, &default.frame_budget_ms),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Sun {
    type Stored = With<settings::Sun>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let default = Self::default();
        let anchor = match (fields.anchor_lon_deg, fields.anchor_lat_deg) {
            (None, None) => SunAnchor::Viewer,
            (Some(lon_deg), Some(lat_deg)) => SunAnchor::Place { lon_deg, lat_deg },
            (Some(_), None) | (None, Some(_)) => {
                return Err(at.fault(
                    "both \"anchor_lon_deg\" and \"anchor_lat_deg\", or neither",
                    "one of them",
                ));
            }
        };
        Ok(Self {
            azimuth_deg: fields.azimuth_deg.unwrap_or(default.azimuth_deg),
            elevation_deg: fields.elevation_deg.unwrap_or(default.elevation_deg),
            ambient: fields.ambient.unwrap_or(default.ambient),
            anchor,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        let (anchor_lon_deg, anchor_lat_deg) = match self.anchor {
            SunAnchor::Viewer => (None, None),
            SunAnchor::Place { lon_deg, lat_deg } => (Some(lon_deg), Some(lat_deg)),
        };
        With {
            fields: settings::Sun {
                azimuth_deg: unless_default(self.azimuth_deg, &default.azimuth_deg),
                elevation_deg: unless_default(self.elevation_deg, &default.elevation_deg),
                ambient: unless_default(self.ambient, &default.ambient),
                anchor_lon_deg,
                anchor_lat_deg,
            },
            extra: self.extra.clone(),
        }
    }
}
