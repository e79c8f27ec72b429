//! Moves of an orbiting camera: pan, orbit, zoom. Each keeps a grabbed ground point under the
//! pointer, never rolls, and is a function of the camera before and the pointer alone.

use core::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};

use super::aim::shortest_rotation;
use super::{Camera, MAX_ALTITUDE_M, MAX_PITCH_RAD, MIN_HEIGHT_M, clamp_altitude};
use crate::Planet;
use crate::ellipsoid::ray_sphere;

/// Distance to the ground that one wheel step takes away, as a factor.
const ZOOM_PER_STEP: f64 = 0.8;

/// Most wheel steps that one call follows, so that a mad device cannot overflow the exponential.
const MAX_STEPS: f64 = 1e3;

impl Camera {
    /// Moved around the planet so that the ground point `grabbed` comes under the pointer, with
    /// altitude and pitch kept. Dragging on the sky pulls by the horizon's nearest point.
    ///
    /// - `grabbed`: from [`Camera::ground_at`] when the button went down.
    /// - `ground_m`: height above the datum of the sphere that was grabbed.
    ///
    /// Unchanged where the pointer shows neither ground nor horizon, or from below the ground.
    #[must_use]
    pub fn panned(
        &self,
        planet: &Planet,
        ground_m: f64,
        grabbed: DVec3,
        ndc: DVec2,
        aspect: f64,
    ) -> Self {
        let Some(grabbed) = grabbed.try_normalize() else {
            return *self;
        };
        let eye = self.eye(planet);
        let radius_m = planet.radius_m + ground_m;
        if self.altitude_m <= ground_m || radius_m <= 0.0 {
            return *self;
        }
        let ray = self.ray(ndc.x, ndc.y, aspect);
        let distance_m = ray_sphere(eye, ray, radius_m).unwrap_or_else(|| -eye.dot(ray));
        if !(distance_m.is_finite() && distance_m >= 0.0) {
            return *self;
        }
        let Some(shown) = (eye + distance_m * ray).try_normalize() else {
            return *self;
        };
        // One rotation of the whole camera about the planet's centre takes the shown point to the
        // grabbed one: a rigid motion, hence exact, and altitude and pitch stay by themselves.
        let rotation = shortest_rotation(shown, grabbed);
        let up = rotation * self.local_frame().up;
        self.with_frame(
            up.normalize(),
            rotation * self.axes().right,
            self.altitude_m,
        )
    }

    /// Turned about a ground point that keeps its place in the picture.
    ///
    /// - `pivot`: the point's direction from the planet's centre, from [`Camera::ground_at`];
    ///   `ground_m`: its height above the datum.
    /// - `heading_rad`: clockwise turn of the view as seen from above the pivot; `pitch_rad`:
    ///   upward turn of the view, which lowers the eye.
    ///
    /// Turns stop at the limits of pitch and [`super::MIN_HEIGHT_M`] above `ground_m`. When the
    /// pivot is not in front of the eye this looks around instead.
    #[must_use]
    pub fn orbited(
        &self,
        planet: &Planet,
        ground_m: f64,
        pivot: DVec3,
        heading_rad: f64,
        pitch_rad: f64,
    ) -> Self {
        let above = self.above_ground(ground_m);
        let Some(pivot_up) = pivot.try_normalize() else {
            return above;
        };
        if !(heading_rad.is_finite() && pitch_rad.is_finite()) {
            return above;
        }
        let pivot = pivot_up * (planet.radius_m + ground_m);
        let axes = above.axes();
        let Some(sight) = (pivot - above.eye(planet)).try_normalize() else {
            return above.turned(heading_rad, pitch_rad);
        };
        let view = axes.view_from_world(sight);
        if view.z <= 0.0 {
            return above.turned(heading_rad, pitch_rad);
        }
        let tilt = pitch_rad.clamp(
            (-FRAC_PI_2 - above.pitch_rad).min(0.0),
            (MAX_PITCH_RAD - above.pitch_rad).max(0.0),
        );
        // The axis of tilting lies level at the pivot.
        let level = axes.right - axes.right.dot(pivot_up) * pivot_up;
        let axis = level.try_normalize().unwrap_or(axes.right);
        // Clockwise from above is a negative turn about the vertical.
        let turn = DQuat::from_axis_angle(pivot_up, -heading_rad);
        let offset = above.eye(planet) - pivot;
        let tilted = |share: f64| {
            let eye = pivot + turn * (DQuat::from_axis_angle(axis, tilt * share) * offset);
            (eye, eye.length() - planet.radius_m)
        };
        let (lowest_m, highest_m) = (
            ground_m + MIN_HEIGHT_M,
            MAX_ALTITUDE_M.max(above.altitude_m),
        );
        let share = largest_share(|share| (lowest_m..=highest_m).contains(&tilted(share).1));
        let (eye, _) = tilted(share);
        let sight = (pivot - eye).normalize_or(sight);
        let turned = above.carried_turned(planet, eye, turn, tilt * share);
        let aimed = turned.aimed(sight, view);
        Self {
            altitude_m: clamp_altitude(aimed.altitude_m, ground_m),
            ..aimed
        }
    }

    /// The camera at `eye` turned with `turn` about the vertical and tilted: a start for aiming
    /// that is right but for the planet's curvature between eye and pivot.
    fn carried_turned(&self, planet: &Planet, eye: DVec3, turn: DQuat, tilt_rad: f64) -> Self {
        let right = turn * self.axes().right;
        let Some(up) = eye.try_normalize() else {
            return *self;
        };
        let level = (right - right.dot(up) * up).normalize_or(right);
        let moved = self.with_frame(up, level, eye.length() - planet.radius_m);
        Self {
            pitch_rad: super::clamp_pitch(self.pitch_rad + tilt_rad),
            ..moved
        }
    }

    /// Moved towards (`steps` > 0) or away from the ground point under the pointer, which keeps
    /// its place in the picture; each step leaves 0.8 of the distance. On the sky the height
    /// above the ground changes by the same factor.
    ///
    /// - `ground_m`: height of the ground above the datum; the eye stays between
    ///   [`super::MIN_HEIGHT_M`] above it and [`MAX_ALTITUDE_M`] above the datum.
    #[must_use]
    pub fn zoomed(
        &self,
        planet: &Planet,
        ground_m: f64,
        ndc: DVec2,
        aspect: f64,
        steps: f64,
    ) -> Self {
        if !steps.is_finite() {
            return *self;
        }
        let factor = libm::pow(ZOOM_PER_STEP, steps.clamp(-MAX_STEPS, MAX_STEPS));
        let above = self.above_ground(ground_m);
        let height_m = above.altitude_m - ground_m;
        let target_m = |height_m: f64| clamp_altitude(ground_m + height_m, ground_m);
        let ray = above.ray(ndc.x, ndc.y, aspect);
        let eye = above.eye(planet);
        let Some(distance_m) = ray_sphere(eye, ray, planet.radius_m + ground_m) else {
            return Self {
                altitude_m: target_m(height_m * factor),
                ..above
            };
        };
        // Nearer or farther with the same heading and pitch, then moved around the planet until the
        // point is under the pointer again: nothing turns, not even straight above the ground,
        // where the heading of a sight is next to nothing.
        let scaled = Self {
            altitude_m: target_m(height_m * factor),
            ..above
        };
        let (scaled_ray, radius_m) = (scaled.ray(ndc.x, ndc.y, aspect), planet.radius_m + ground_m);
        if ray_sphere(scaled.eye(planet), scaled_ray, radius_m).is_some() {
            return scaled.panned(planet, ground_m, eye + ray * distance_m, ndc, aspect);
        }
        // From out there the place of the pointer shows the sky; the camera has to tilt. Along its
        // sight the ground point stays in one world direction, which the moved camera
        // then aims at. Rounding of a point metres below an eye 10⁷ m from the centre so plays no
        // part.
        let moved_m = |distance_m: f64, factor: f64| eye + ray * (distance_m * (1.0 - factor));
        let altitude = |factor: f64| moved_m(distance_m, factor).length() - planet.radius_m;
        let factor = if factor < 1.0 {
            let lowest_m = ground_m + MIN_HEIGHT_M;
            1.0 - (1.0 - factor)
                * largest_share(|share| altitude(1.0 - (1.0 - factor) * share) >= lowest_m)
        } else {
            let grown =
                factor.min(2.0 * (MAX_ALTITUDE_M + planet.radius_m) / distance_m.max(1e-9) + 1.0);
            1.0 + (grown - 1.0)
                * largest_share(|share| altitude(1.0 + (grown - 1.0) * share) <= MAX_ALTITUDE_M)
        };
        let view = above.view_ray(ndc, aspect);
        let moved = above
            .carried(planet, moved_m(distance_m, factor))
            .aimed(ray, view);
        Self {
            altitude_m: clamp_altitude(moved.altitude_m, ground_m),
            ..moved
        }
    }
}

/// The largest share of a move, 0 to 1, up to which `allowed` holds without a break, to one part
/// in 2⁵⁰; 0 where even the start is not allowed.
fn largest_share(allowed: impl Fn(f64) -> bool) -> f64 {
    if allowed(1.0) {
        return 1.0;
    }
    let (mut inside, mut outside) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = f64::midpoint(inside, outside);
        if allowed(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::{cameras, is_sane, ndcs, planets};
    use super::*;

    /// Angle between where a ground point is and where the picture's place `ndc` looks.
    fn miss_rad(camera: &Camera, planet: &Planet, ground_m: f64, point: DVec3, ndc: DVec2) -> f64 {
        let sight = point * (planet.radius_m + ground_m) - camera.eye(planet);
        let ray = camera.ray(ndc.x, ndc.y, 1.5);
        libm::atan2(sight.cross(ray).length(), sight.dot(ray))
    }

    /// How precisely a point can be seen at all: a world coordinate's rounding over its distance.
    fn noise_rad(camera: &Camera, planet: &Planet, point: DVec3) -> f64 {
        let size_m = planet.radius_m + camera.altitude_m;
        let distance_m = (point * planet.radius_m - camera.eye(planet)).length();
        1e-8 + 1e-14 * size_m / distance_m
    }

    /// Away from the limb, where a hair's breadth of the pointer is half a continent.
    fn is_well_seen(camera: &Camera, planet: &Planet, point: DVec3) -> bool {
        let sight = (camera.eye(planet) - point * planet.radius_m).normalize();
        sight.dot(point) > 1e-3
    }

    proptest! {
        #[test]
        fn a_pan_keeps_the_grabbed_point_under_the_pointer(
            planet in planets(), camera in cameras(), from in ndcs(), to in ndcs(),
        ) {
            let Some(grabbed) = camera.ground_at(&planet, 0.0, from, 1.5) else { return Ok(()) };
            let panned = camera.panned(&planet, 0.0, grabbed, to, 1.5);
            prop_assert!(is_sane(&panned));
            prop_assert_eq!((panned.altitude_m, panned.pitch_rad), (camera.altitude_m, camera.pitch_rad));
            if camera.ground_at(&planet, 0.0, to, 1.5).is_some() && is_well_seen(&panned, &planet, grabbed) {
                let miss = miss_rad(&panned, &planet, 0.0, grabbed, to);
                prop_assert!(miss < 1e3 * noise_rad(&panned, &planet, grabbed), "{:e}", miss);
            }
        }

        #[test]
        fn a_pan_without_a_move_changes_nothing(planet in planets(), camera in cameras(), at in ndcs()) {
            let Some(grabbed) = camera.ground_at(&planet, 0.0, at, 1.5) else { return Ok(()) };
            let panned = camera.panned(&planet, 0.0, grabbed, at, 1.5);
            let (before, after) = (camera.axes(), panned.axes());
            prop_assert!((before.right - after.right).length() < 1e-9);
            prop_assert!((before.forward - after.forward).length() < 1e-9);
        }

        #[test]
        fn an_orbit_keeps_its_pivot_in_place(
            planet in planets(), camera in cameras(), at in ndcs(),
            heading in -3.0..3.0, pitch in -1.0..1.0,
        ) {
            let Some(pivot) = camera.ground_at(&planet, 0.0, at, 1.5) else { return Ok(()) };
            let orbited = camera.orbited(&planet, 0.0, pivot, heading, pitch);
            prop_assert!(is_sane(&orbited));
            prop_assert!(orbited.altitude_m >= 0.999);
            let inside = orbited.pitch_rad > -FRAC_PI_2 + 1e-6 && orbited.pitch_rad < MAX_PITCH_RAD - 1e-6;
            if inside && is_well_seen(&camera, &planet, pivot) && is_solvable(&orbited, &planet, pivot, at) {
                let miss = miss_rad(&orbited, &planet, 0.0, pivot, at);
                prop_assert!(miss < 1e3 * noise_rad(&orbited, &planet, pivot), "{:e} {:?}", miss, orbited);
            }
        }

        #[test]
        fn a_zoom_keeps_the_pointed_ground_in_place(
            planet in planets(), camera in cameras(), at in ndcs(), steps in -20.0..20.0,
        ) {
            let zoomed = camera.zoomed(&planet, 0.0, at, 1.5, steps);
            prop_assert!(is_sane(&zoomed));
            prop_assert!(zoomed.altitude_m >= MIN_HEIGHT_M && zoomed.altitude_m <= MAX_ALTITUDE_M);
            let Some(pointed) = camera.ground_at(&planet, 0.0, at, 1.5) else { return Ok(()) };
            let inside = zoomed.pitch_rad > -FRAC_PI_2 + 1e-6 && zoomed.pitch_rad < MAX_PITCH_RAD - 1e-6;
            if inside && is_well_seen(&camera, &planet, pointed) && is_solvable(&zoomed, &planet, pointed, at) {
                let miss = miss_rad(&zoomed, &planet, 0.0, pointed, at);
                prop_assert!(miss < 1e3 * noise_rad(&zoomed, &planet, pointed), "{:e} {:?}", miss, zoomed);
            }
        }

        #[test]
        fn moves_above_high_or_deep_ground_stay_above_it(
            camera in cameras(), ground_m in -400.0..8000.0, at in ndcs(), steps in -100.0..100.0,
            heading in -9.0..9.0, pitch in -9.0..9.0,
        ) {
            let planet = Planet::EARTH;
            let zoomed = camera.zoomed(&planet, ground_m, at, 1.5, steps);
            prop_assert!(is_sane(&zoomed) && zoomed.altitude_m >= ground_m + MIN_HEIGHT_M);
            let pivot = camera.ground_at(&planet, ground_m, at, 1.5).unwrap_or(DVec3::Z);
            let orbited = camera.orbited(&planet, ground_m, pivot, heading, pitch);
            prop_assert!(is_sane(&orbited) && orbited.altitude_m >= ground_m + MIN_HEIGHT_M);
        }
    }

    /// Whether a level camera can show the point at the place at all: a place far off the middle
    /// of the picture cannot look straight down.
    fn is_solvable(camera: &Camera, planet: &Planet, point: DVec3, ndc: DVec2) -> bool {
        let sight = (point * planet.radius_m - camera.eye(planet)).normalize();
        let local = camera.local_frame().components(sight);
        let view = camera.view_ray(ndc, 1.5);
        libm::hypot(local.x, local.y) > view.x.abs() + 1e-9
    }

    #[test]
    fn zooming_straight_down_beside_the_pointer_does_not_spin() {
        let mut camera = Camera::from_degrees(20.0, 50.0, 2e5, 30.0, -90.0, 60.0).unwrap();
        for _ in 0..30 {
            camera = camera.zoomed(&Planet::EARTH, 0.0, DVec2::new(0.6, 0.4), 1.5, 1.0);
            // Only meridians that converge turn it, a degree or so on the way there.
            let turn = camera.heading_rad.to_degrees() - 30.0;
            assert!(turn.abs() < 3.0, "turned by {turn}°");
        }
        assert!(camera.altitude_m < 300.0);
    }

    #[test]
    fn zooming_in_and_out_at_the_pole_returns_to_the_start() {
        let camera = Camera::from_degrees(0.0, 90.0, 1e6, 30.0, -60.0, 60.0).expect("valid");
        let at = DVec2::new(0.2, -0.1);
        let there = camera.zoomed(&Planet::EARTH, 0.0, at, 1.5, 10.0);
        assert!(there.altitude_m < 0.2 * camera.altitude_m);
        let back = there.zoomed(&Planet::EARTH, 0.0, at, 1.5, -10.0);
        assert!((back.eye(&Planet::EARTH) - camera.eye(&Planet::EARTH)).length() < 0.1);
        assert!((back.axes().forward - camera.axes().forward).length() < 1e-8);
    }
}
