//! Level orientation from what a place of the picture shall show.

use glam::{DQuat, DVec3};

use super::{Basis, Camera, LocalFrame, clamp_pitch, wrap_heading};
use crate::Planet;

/// Below this horizontal share of a ray its azimuth says nothing about the heading.
const LEVEL_EPSILON: f64 = 1e-9;

impl Camera {
    /// The same eye, turned about as little as needed so that the view ray `view` (unit length, x
    /// right, y up, z forward) points along `direction` (world, unit length) with a level horizon.
    ///
    /// Exact wherever such an orientation exists within the limits of pitch, else the nearest.
    /// A ray straight up or down leaves the heading alone.
    pub(super) fn aimed(&self, direction: DVec3, view: DVec3) -> Self {
        let d = self.local_frame().components(direction);
        let horizontal = libm::hypot(d.x, d.y);
        // Pitch: view.y cos p + view.z sin p = d.z, that is sin(p + φ) = d.z / √(y² + z²). The
        // cosine comes from the horizontal parts, as near −90° d.z alone says too little.
        let phase = libm::atan2(view.y, view.z);
        let cosine = ((horizontal - view.x) * (horizontal + view.x))
            .max(0.0)
            .sqrt();
        let near = |p: f64| {
            let p = crate::map::wrap_longitude(p - phase);
            (p, crate::map::wrap_longitude(p - self.pitch_rad).abs())
        };
        let (forward, back) = (
            near(libm::atan2(d.z, cosine)),
            near(libm::atan2(d.z, -cosine)),
        );
        let allowed = |p: f64| {
            (-core::f64::consts::FRAC_PI_2 - 1e-9..=super::MAX_PITCH_RAD + 1e-9).contains(&p)
        };
        let pitch_rad = match (allowed(forward.0), allowed(back.0)) {
            (true, false) => forward.0,
            (false, true) => back.0,
            _ if forward.1 <= back.1 => forward.0,
            _ => back.0,
        };
        let pitch_rad = clamp_pitch(pitch_rad);
        let (sin_p, cos_p) = libm::sincos(pitch_rad);
        let ahead = view.z * cos_p - view.y * sin_p;
        let heading_rad =
            if horizontal < LEVEL_EPSILON || libm::hypot(view.x, ahead) < LEVEL_EPSILON {
                self.heading_rad
            } else {
                wrap_heading(libm::atan2(d.x, d.y) - libm::atan2(view.x, ahead))
            };
        Self {
            heading_rad,
            pitch_rad,
            ..*self
        }
    }

    /// The camera moved to `eye` (world, metres), its pitch kept and its heading carried along
    /// the great circle without turning, so that no pole makes it spin. Unchanged at the planet's
    /// centre.
    pub(super) fn carried(&self, planet: &Planet, eye: DVec3) -> Self {
        let Some(up) = eye.try_normalize() else {
            return *self;
        };
        let from = self.local_frame().up;
        let rotation = shortest_rotation(from, up);
        let altitude_m = eye.length() - planet.radius_m;
        self.with_frame(up, rotation * self.axes().right, altitude_m)
    }

    /// The camera above the direction `up` with the heading that has `right` on its right hand;
    /// pitch and field of view stay.
    pub(super) fn with_frame(&self, up: DVec3, right: DVec3, altitude_m: f64) -> Self {
        let (local, lon_rad, lat_rad) = LocalFrame::at(up);
        let right = local.components(right);
        Self {
            lon_rad,
            lat_rad,
            altitude_m,
            heading_rad: wrap_heading(libm::atan2(-right.y, right.x)),
            ..*self
        }
    }
}

/// The shortest rotation that takes one unit vector to another.
///
/// Not glam's `from_rotation_arc`, which gives the identity below 3·10⁻⁸ rad: 20 cm on Earth, so
/// that nothing would move for an eye near the ground.
pub(super) fn shortest_rotation(from: DVec3, to: DVec3) -> DQuat {
    let cross = from.cross(to);
    let real = 1.0 + from.dot(to);
    if real < 1e-12 {
        return DQuat::from_axis_angle(from.any_orthonormal_vector(), core::f64::consts::PI);
    }
    DQuat::from_xyzw(cross.x, cross.y, cross.z, real).normalize()
}

impl Basis {
    /// A world-space vector in view space: x right, y up, z forward.
    pub fn view_from_world(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.forward))
    }
}
