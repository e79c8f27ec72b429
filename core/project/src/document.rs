//! The runtime document: plain values that the engine compiles and the window shows.

use std::sync::Arc;

use relievo_planet::{Camera, Planet};

use crate::{Date, Element, ElementId, Layer, LayerId, Scenario, ScenarioId};

/// Fields of the file that this version does not know, in their order. They are written back as
/// they came.
pub type Extra = serde_json::Map<String, serde_json::Value>;

/// A project: everything that decides the picture.
///
/// Fields are public to read; to change a project, apply an [`Edit`](crate::Edit), which checks
/// values and can be undone.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Project {
    /// The planet's figure and exaggeration.
    pub planet: PlanetSettings,
    /// Where the viewer is when the project opens.
    pub camera: CameraSettings,
    /// How fine the picture is drawn.
    pub quality: Quality,
    /// The light.
    pub sun: Sun,
    /// All layers, the bottom one first. Ids are unique.
    pub layers: Vec<Layer>,
    /// Planning elements of the base, the bottom one first; later ones win. Ids are unique. What a
    /// scenario makes of them: [`Project::elements_in`].
    pub elements: Vec<Arc<Element>>,
    /// Named deltas on the base. Ids are unique, parents exist and form a tree.
    pub scenarios: Vec<Scenario>,
    /// The scenario that is shown. `None`: the base.
    pub scenario: Option<ScenarioId>,
    /// The day that series of layers are shown at. `None`: the latest of each.
    pub date: Option<Date>,
    /// Places to go back to.
    pub bookmarks: Vec<Bookmark>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Project {
    /// The layer with this id.
    pub fn layer(&self, id: &LayerId) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.id == *id)
    }

    /// Whether it differs from what was saved in more than the camera. Elements that both share cost
    /// no comparison.
    pub fn differs_from(&self, saved: &Self) -> bool {
        let same_elements = self.elements.len() == saved.elements.len()
            && self
                .elements
                .iter()
                .zip(&saved.elements)
                .all(|(a, b)| Arc::ptr_eq(a, b) || a == b);
        !same_elements
            || self.layers != saved.layers
            || self.scenarios != saved.scenarios
            || self.scenario != saved.scenario
            || self.date != saved.date
            || self.bookmarks != saved.bookmarks
            || self.planet != saved.planet
            || self.sun != saved.sun
            || self.quality != saved.quality
            || self.extra != saved.extra
    }

    /// Position of the layer with this id, counted from the bottom.
    pub fn layer_index(&self, id: &LayerId) -> Option<usize> {
        self.layers.iter().position(|layer| layer.id == *id)
    }

    /// Position of the base's element with this id, counted from the bottom.
    pub fn element_index(&self, id: &ElementId) -> Option<usize> {
        self.elements.iter().position(|element| element.id == *id)
    }
}

/// A named place of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub struct Bookmark {
    /// What people call it; up to 1000 bytes.
    pub name: String,
    /// Where the viewer is.
    pub camera: CameraSettings,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// The planet's figure and how heights are shown on it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanetSettings {
    /// Which planet.
    pub body: Body,
    /// Factor on heights in the picture only, 0 to 100; measurements are not exaggerated. Default 1.
    pub vertical_exaggeration: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for PlanetSettings {
    fn default() -> Self {
        Self {
            body: Body::Earth,
            vertical_exaggeration: 1.0,
            extra: Extra::new(),
        }
    }
}

/// A planet by name or by its figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// Earth: mean radius, WGS 84 ellipsoid.
    Earth,
    /// Mars, IAU 2015: mean radius 3 389 500 m, equatorial 3 396 190 m, polar 3 376 200 m.
    Mars,
    /// The Moon, IAU 2015: a sphere of 1 737 400 m.
    Moon,
    /// Any other figure; radii 1 to 10⁹ m, flattening 0 ≤ f ≤ 0.5.
    Custom(Planet),
}

impl Body {
    /// The figure in metres.
    pub fn figure(&self) -> Planet {
        match self {
            Self::Earth => Planet::EARTH,
            Self::Mars => Planet {
                radius_m: 3_389_500.0,
                equatorial_radius_m: 3_396_190.0,
                flattening: (3_396_190.0 - 3_376_200.0) / 3_396_190.0,
            },
            Self::Moon => Planet::sphere(1_737_400.0),
            Self::Custom(planet) => *planet,
        }
    }
}

/// Where the viewer is and looks, in degrees as users write them.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    /// Longitude below the eye in degrees, −360 to 360.
    pub lon_deg: f64,
    /// Latitude below the eye in degrees, −90 to 90.
    pub lat_deg: f64,
    /// Height of the eye above the datum in metres, −100 000 to 10⁹.
    pub altitude_m: f64,
    /// Direction of view in degrees clockwise from north, −360 to 360. Default 0.
    pub heading_deg: f64,
    /// Elevation of the view direction in degrees: −90 (the default) looks down, 0 to the horizontal.
    pub pitch_deg: f64,
    /// Vertical field of view in degrees, 1 to 170. Default 60.
    pub fov_deg: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            lon_deg: 0.0,
            lat_deg: 0.0,
            altitude_m: 15_000_000.0,
            heading_deg: 0.0,
            pitch_deg: -90.0,
            fov_deg: 60.0,
            extra: Extra::new(),
        }
    }
}

impl CameraSettings {
    /// The camera in radians, as the geometry takes it.
    pub fn to_camera(&self) -> Camera {
        Camera {
            lon_rad: self.lon_deg.to_radians(),
            lat_rad: self.lat_deg.to_radians(),
            altitude_m: self.altitude_m,
            heading_rad: self.heading_deg.to_radians(),
            pitch_rad: self.pitch_deg.to_radians(),
            fov_y_rad: self.fov_deg.to_radians(),
        }
    }

    /// Settings for a camera; unknown fields are taken from `self`.
    #[must_use]
    pub fn with_camera(&self, camera: &Camera) -> Self {
        Self {
            lon_deg: camera.lon_rad.to_degrees(),
            lat_deg: camera.lat_rad.to_degrees(),
            altitude_m: camera.altitude_m,
            heading_deg: camera.heading_rad.to_degrees(),
            pitch_deg: camera.pitch_rad.to_degrees(),
            fov_deg: camera.fov_y_rad.to_degrees(),
            extra: self.extra.clone(),
        }
    }
}

/// A value, or the program's choice for the device it runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Auto<T> {
    /// The program chooses.
    #[default]
    Auto,
    /// This value.
    Value(T),
}

impl<T> Auto<T> {
    /// The value, or `choice` where the program chooses.
    pub fn unwrap_or(self, choice: T) -> T {
        match self {
            Self::Auto => choice,
            Self::Value(value) => value,
        }
    }
}

/// What decides how fine the picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Aim {
    /// The graphics adapter, changed by [`Quality::texel_px`] and [`Quality::mesh_density`].
    #[default]
    Adapter,
    /// The least cost at which errors stay below [`Quality::error_px`].
    Error,
    /// The least error at which frames take no longer than [`Quality::frame_budget_ms`].
    FrameTime,
}

/// How fine the picture is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// What decides. Whatever it is, the other members are kept for when it is another.
    pub aim: Aim,
    /// Error on the screen in pixels that [`Aim::Error`] allows, 0.01 to 100. Default 0.5.
    pub error_px: f64,
    /// Samples along a side of a colour window: 256, 512, 1024, 2048 or 4096.
    pub colour_window_samples: Auto<u32>,
    /// Screen pixels that the finest texel should cover, 0.25 to 16. Default 1; larger is coarser
    /// and faster.
    pub texel_px: f64,
    /// Factor on the number of triangles of the automatic mesh, 0.1 to 10.
    pub mesh_density: Auto<f64>,
    /// Time on the graphics device that [`Aim::FrameTime`] allows a frame, milliseconds, 1 to 1000.
    /// Default 16.
    pub frame_budget_ms: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            aim: Aim::Adapter,
            error_px: 0.5,
            colour_window_samples: Auto::Auto,
            texel_px: 1.0,
            mesh_density: Auto::Auto,
            frame_budget_ms: 16.0,
            extra: Extra::new(),
        }
    }
}

/// The light: a distant sun and an even sky.
#[derive(Clone, Debug, PartialEq)]
pub struct Sun {
    /// Direction towards the sun in degrees clockwise from north, −360 to 360. Default 315.
    pub azimuth_deg: f64,
    /// Elevation of the sun above the horizontal in degrees, −90 to 90. Default 45.
    pub elevation_deg: f64,
    /// Share of light that comes evenly from the sky, 0 to 1. Default 0.3.
    pub ambient: f64,
    /// Where azimuth and elevation hold.
    pub anchor: SunAnchor,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for Sun {
    fn default() -> Self {
        Self {
            azimuth_deg: 315.0,
            elevation_deg: 45.0,
            ambient: 0.3,
            anchor: SunAnchor::Viewer,
            extra: Extra::new(),
        }
    }
}

/// Where on the ground the sun's azimuth and elevation hold.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum SunAnchor {
    /// Below the viewer, wherever they go: what they see is always lit the same way.
    #[default]
    Viewer,
    /// At one place: the planet has a day and a night side.
    Place {
        /// Longitude in degrees, −360 to 360.
        lon_deg: f64,
        /// Latitude in degrees, −90 to 90.
        lat_deg: f64,
    },
}
