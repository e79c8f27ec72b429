//! Where the viewer is, where it looks, and how it moves.
//!
//! A camera never rolls: its right vector is level, and at a pole its heading counts from the
//! meridian of its own longitude, so that every orientation has exactly one smooth reading.
//!
//! Invariant: with finite fields nothing here gives NaN, at any altitude from 1 m to 10⁸ m, on
//! planets of 1 km to 70 000 km, the poles included. Absent: input devices and clocks; callers
//! hand in pointer places and frame times.

mod aim;
mod fly;
mod go_to;
mod orbit;
mod parse;
mod path;
mod projection;

use core::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use crate::{MapPoint, Planet};

pub use fly::{Fly, FlyInput};
pub use go_to::GoTo;
pub use parse::CameraError;
pub use path::PathAhead;
pub use projection::near_plane_m;

/// Least height of the eye above the ground in metres.
pub const MIN_HEIGHT_M: f64 = 1.0;

/// Greatest altitude of the eye in metres.
pub const MAX_ALTITUDE_M: f64 = 1e8;

/// Steepest view upward in radians (89°); downward the limit is −π/2.
pub const MAX_PITCH_RAD: f64 = 89.0 * PI / 180.0;

/// Field of view unless another is asked for, radians (60°).
pub const DEFAULT_FOV_Y_RAD: f64 = PI / 3.0;

/// Where the viewer is and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Longitude below the eye, radians.
    pub lon_rad: f64,
    /// Latitude below the eye, radians, −π/2 to π/2.
    pub lat_rad: f64,
    /// Height of the eye above the sphere (the datum) in metres.
    pub altitude_m: f64,
    /// Direction of view clockwise from north, radians.
    pub heading_rad: f64,
    /// Elevation of the view direction: −π/2 looks down, 0 to the horizontal.
    pub pitch_rad: f64,
    /// Vertical field of view, radians.
    pub fov_y_rad: f64,
}

/// An orthonormal frame in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// To the right of the picture (or east).
    pub right: DVec3,
    /// To the top of the picture (or north).
    pub up: DVec3,
    /// Into the picture (for the local frame: down).
    pub forward: DVec3,
}

/// East, north and up at a place, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    pub(crate) east: DVec3,
    pub(crate) north: DVec3,
    pub(crate) up: DVec3,
}

impl LocalFrame {
    /// The frame at a longitude and latitude; at a pole, that of the longitude's meridian.
    pub(crate) fn new(lon_rad: f64, lat_rad: f64) -> Self {
        let (sin_lon, cos_lon) = libm::sincos(lon_rad);
        let (sin_lat, cos_lat) = libm::sincos(lat_rad);
        Self {
            east: DVec3::new(-sin_lon, cos_lon, 0.0),
            north: DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            up: DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
        }
    }

    /// The frame below a world-space direction, with its longitude and latitude.
    pub(crate) fn at(direction: DVec3) -> (Self, f64, f64) {
        let lon_rad = libm::atan2(direction.y, direction.x);
        let lat_rad = libm::atan2(direction.z, libm::hypot(direction.x, direction.y));
        (Self::new(lon_rad, lat_rad), lon_rad, lat_rad)
    }

    /// Components (east, north, up) of a world-space vector.
    pub(crate) fn components(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.east), v.dot(self.north), v.dot(self.up))
    }
}

impl Camera {
    /// The map point below the eye.
    pub fn map_point(&self) -> MapPoint {
        MapPoint::new(self.lon_rad, FRAC_PI_2 - self.lat_rad)
    }

    /// World position of the eye in metres.
    pub fn eye(&self, planet: &Planet) -> DVec3 {
        self.local_frame().up * (planet.radius_m + self.altitude_m)
    }

    /// The picture's axes in world space, orthonormal: right × up = −forward.
    ///
    /// The vertical is the sphere's, so that the planet's size plays no part; it is asked for
    /// because the vertical is the figure's to say.
    pub fn basis(&self, _planet: &Planet) -> Basis {
        self.axes()
    }

    /// World direction of unit length through a place of the picture.
    ///
    /// - `x_ndc`, `y_ndc`: −1 to 1, right and up; values outside are outside the picture.
    /// - `aspect`: width / height of the picture.
    pub fn ray(&self, x_ndc: f64, y_ndc: f64, aspect: f64) -> DVec3 {
        self.axes()
            .world_from_view(self.view_ray(DVec2::new(x_ndc, y_ndc), aspect))
    }

    /// Where a place of the picture shows the sphere `ground_m` above the datum: the direction of
    /// that point from the planet's centre, of unit length; `None` for the sky.
    pub fn ground_at(
        &self,
        planet: &Planet,
        ground_m: f64,
        ndc: DVec2,
        aspect: f64,
    ) -> Option<DVec3> {
        let eye = self.eye(planet);
        let ray = self.ray(ndc.x, ndc.y, aspect);
        let distance_m = crate::ellipsoid::ray_sphere(eye, ray, planet.radius_m + ground_m)?;
        (eye + distance_m * ray).try_normalize()
    }

    /// The same eye, turned so that `target` (world, metres) is in the middle of the picture, as
    /// nearly as the limits of pitch allow. Unchanged when the target is the eye itself.
    #[must_use]
    pub fn looking_at(&self, planet: &Planet, target: DVec3) -> Self {
        match (target - self.eye(planet)).try_normalize() {
            Some(direction) => self.aimed(direction, DVec3::Z),
            None => *self,
        }
    }

    /// The same view with the eye raised, where it must be, to [`MIN_HEIGHT_M`] above a ground
    /// `ground_m` above the datum, or lowered to [`MAX_ALTITUDE_M`].
    #[must_use]
    pub fn above_ground(&self, ground_m: f64) -> Self {
        Self {
            altitude_m: clamp_altitude(self.altitude_m, ground_m),
            ..*self
        }
    }

    /// Turned by the given angles in radians, clockwise and upward, within the limits of pitch.
    #[must_use]
    pub fn turned(&self, heading_rad: f64, pitch_rad: f64) -> Self {
        Self {
            heading_rad: wrap_heading(self.heading_rad + heading_rad),
            pitch_rad: clamp_pitch(self.pitch_rad + pitch_rad),
            ..*self
        }
    }

    /// East, north and up at the eye.
    pub(crate) fn local_frame(&self) -> LocalFrame {
        LocalFrame::new(self.lon_rad, self.lat_rad)
    }

    /// The picture's axes in world space.
    pub(crate) fn axes(&self) -> Basis {
        let local = self.local_frame();
        let (sin_h, cos_h) = libm::sincos(self.heading_rad);
        let (sin_p, cos_p) = libm::sincos(self.pitch_rad);
        let level = sin_h * local.east + cos_h * local.north;
        Basis {
            right: cos_h * local.east - sin_h * local.north,
            up: cos_p * local.up - sin_p * level,
            forward: cos_p * level + sin_p * local.up,
        }
    }

    /// Direction through a place of the picture in view space: x right, y up, z forward.
    pub(crate) fn view_ray(&self, ndc: DVec2, aspect: f64) -> DVec3 {
        let half = libm::tan(self.fov_y_rad / 2.0);
        DVec3::new(ndc.x * half * aspect, ndc.y * half, 1.0).normalize()
    }
}

impl Basis {
    /// A vector of view space (x right, y up, z forward) in world space.
    pub fn world_from_view(&self, v: DVec3) -> DVec3 {
        v.x * self.right + v.y * self.up + v.z * self.forward
    }
}

/// A pitch within its limits.
pub(crate) fn clamp_pitch(pitch_rad: f64) -> f64 {
    pitch_rad.clamp(-FRAC_PI_2, MAX_PITCH_RAD)
}

/// A heading brought to 0 ≤ x < 2π.
pub(crate) fn wrap_heading(heading_rad: f64) -> f64 {
    let wrapped = heading_rad.rem_euclid(2.0 * PI);
    if wrapped >= 2.0 * PI { 0.0 } else { wrapped }
}

/// An altitude within the limits above the ground.
pub(crate) fn clamp_altitude(altitude_m: f64, ground_m: f64) -> f64 {
    altitude_m.min(MAX_ALTITUDE_M).max(ground_m + MIN_HEIGHT_M)
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Planets from 1 km to 70 000 km.
    pub(crate) fn planets() -> impl Strategy<Value = Planet> {
        prop_oneof![
            Just(Planet::EARTH),
            Just(Planet::sphere(1e3)),
            Just(Planet::sphere(7e7)),
            (3.0..7.8_f64).prop_map(|e| Planet::sphere(libm::exp10(e))),
        ]
    }

    /// Cameras anywhere, poles and antimeridian included, 1 m to 10⁸ m up.
    pub(crate) fn cameras() -> impl Strategy<Value = Camera> {
        (
            prop_oneof![Just(-PI), Just(PI), Just(0.0), -PI..PI],
            prop_oneof![
                Just(FRAC_PI_2),
                Just(-FRAC_PI_2),
                Just(0.0),
                Just(FRAC_PI_2 - 1e-9),
                -FRAC_PI_2..FRAC_PI_2
            ],
            0.1..8.0_f64,
            0.0..2.0 * PI,
            prop_oneof![Just(-FRAC_PI_2), Just(0.0), -FRAC_PI_2..MAX_PITCH_RAD],
            0.3..2.0_f64,
        )
            .prop_map(
                |(lon_rad, lat_rad, exponent, heading_rad, pitch_rad, fov_y_rad)| Camera {
                    lon_rad,
                    lat_rad,
                    altitude_m: libm::exp10(exponent),
                    heading_rad,
                    pitch_rad,
                    fov_y_rad,
                },
            )
    }

    /// Places of the picture.
    pub(crate) fn ndcs() -> impl Strategy<Value = DVec2> {
        prop_oneof![
            Just(DVec2::ZERO),
            (-1.0..1.0_f64, -1.0..1.0_f64).prop_map(|(x, y)| DVec2::new(x, y)),
        ]
    }

    /// Every field finite and within its limits.
    pub(crate) fn is_sane(camera: &Camera) -> bool {
        camera.lon_rad.is_finite()
            && camera.lat_rad.abs() <= FRAC_PI_2
            && camera.altitude_m.is_finite()
            && camera.heading_rad.is_finite()
            && (-FRAC_PI_2..=MAX_PITCH_RAD).contains(&camera.pitch_rad)
    }

    #[test]
    fn looking_north_from_the_equator_has_the_pole_ahead_and_east_to_the_right() {
        let camera = Camera::from_degrees(0.0, 0.0, 1e3, 0.0, 0.0, 60.0).expect("valid");
        let basis = camera.basis(&Planet::EARTH);
        assert!((basis.forward - DVec3::Z).length() < 1e-15);
        assert!((basis.right - DVec3::Y).length() < 1e-15);
        assert!((basis.up - DVec3::X).length() < 1e-15);
    }

    #[test]
    fn at_the_pole_the_heading_counts_from_the_cameras_own_meridian() {
        let camera = Camera::from_degrees(90.0, 90.0, 1e3, 0.0, 0.0, 60.0).expect("valid");
        // North along longitude 90° continues, at the pole, towards longitude −90°.
        assert!((camera.axes().forward - -DVec3::Y).length() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_basis_is_orthonormal_everywhere(camera in cameras()) {
            let b = camera.axes();
            prop_assert!((b.right.cross(b.up) + b.forward).length() < 1e-14);
            prop_assert!((b.right.length() - 1.0).abs() < 1e-14 && b.right.dot(b.up).abs() < 1e-14);
            prop_assert!(b.right.dot(camera.local_frame().up).abs() < 1e-14, "the horizon is level");
        }

        #[test]
        fn looking_at_a_point_puts_it_in_the_middle(
            planet in planets(), camera in cameras(), lon in -PI..PI, colat in 0.0..PI,
        ) {
            let target = planet.position(MapPoint::new(lon, colat), 0.0);
            let turned = camera.looking_at(&planet, target);
            prop_assert!(is_sane(&turned));
            let direction = (target - camera.eye(&planet)).normalize();
            prop_assert!((turned.ray(0.0, 0.0, 1.5) - direction).length() < 1e-6);
        }
    }
}
