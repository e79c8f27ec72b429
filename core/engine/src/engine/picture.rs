//! What is drawn of it all: the frame, its light and its air.

use std::sync::Arc;

use glam::DVec3;
use relievo_planet::{Camera, MapPoint};
use relievo_project::{Body, Project};

use super::Engine;
use crate::frame::{Frame, Sun, Upload};
use crate::masses::MassMesh;
use crate::masses::making::Bodies;
use crate::view::View;

impl Engine {
    pub(super) fn frame(
        &self,
        view: &View,
        uploads: Vec<Upload>,
        masses: Vec<Arc<MassMesh>>,
    ) -> Frame {
        let settings = &self.project.planet;
        let planet = settings.body.figure();
        let plan = self.plan.clone().expect("replan made one just before");
        Frame {
            revision: self.shown.revision,
            planet,
            exaggeration: self.exaggeration(),
            camera: view.camera,
            viewport_px: view.viewport_px,
            near_m: (plan.clearance_m * 0.25).max(0.05),
            height_window: view.layout.height_window,
            colour_window: view.colour_window,
            heights: self.stacks.height.views(),
            colours: self.stacks.colour.views(),
            normals: self.stacks.normal.views(),
            sun: sun(&self.project, &view.camera),
            air: air(settings.body),
            masses,
            uploads,
            pending: self.pending
                + self.bodies.as_ref().map_or(0, Bodies::pending)
                + usize::from(self.is_busy() || self.dirty),
            plan,
        }
    }
}

/// Density of a body's air at the datum relative to Earth's. Mars has 1.6 % of Earth's, but its dust
/// makes the sky twice as bright as so much clear air would.
pub(crate) fn air(body: Body) -> f32 {
    match body {
        Body::Earth | Body::Custom(_) => 1.0,
        Body::Mars => 0.03,
        Body::Moon => 0.0,
    }
}

/// Direction and strength of the light: azimuth and elevation hold at the anchor.
pub(crate) fn sun(project: &Project, camera: &Camera) -> Sun {
    let settings = &project.sun;
    let at = match settings.anchor {
        relievo_project::SunAnchor::Viewer => MapPoint::new(
            camera.lon_rad,
            core::f64::consts::FRAC_PI_2 - camera.lat_rad,
        ),
        relievo_project::SunAnchor::Place { lon_deg, lat_deg } => {
            MapPoint::from_degrees(lon_deg, lat_deg)
        }
    };
    let up = at.to_unit();
    let east = DVec3::new(-at.lon_rad.sin(), at.lon_rad.cos(), 0.0);
    let north = up.cross(east);
    let (azimuth, elevation) = (
        settings.azimuth_deg.to_radians(),
        settings.elevation_deg.to_radians(),
    );
    let level = north * azimuth.cos() + east * azimuth.sin();
    Sun {
        direction_in_world: level * elevation.cos() + up * elevation.sin(),
        ambient: settings.ambient as f32,
    }
}
