//! Conservative culling of pieces of terrain against the frustum and the horizon.
//!
//! Law: a piece that holds a visible point is never culled (`tests/clipmap_laws.rs`).

use glam::DVec3;

use super::levels::horizon_rad;
use super::plan::HeightRange;
use super::view::{FocusFrame, View};
use crate::Planet;

/// A cap of the unit sphere that bounds a piece of terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Direction of the cap's centre from the planet's centre, unit.
    pub centre: DVec3,
    /// Radius as a central angle, radians.
    pub radius_rad: f64,
}

impl Patch {
    /// The cap around a sector of an annulus about a frame's point: angles `inner_rad..=outer_rad`
    /// (at most π) and azimuths `from_rad..=to_rad` (at most π/2 apart).
    pub fn sector(
        frame: &FocusFrame,
        (inner_rad, outer_rad): (f64, f64),
        (from_rad, to_rad): (f64, f64),
    ) -> Self {
        let middle = 0.5 * (inner_rad + outer_rad);
        let centre = frame.direction(middle, 0.5 * (from_rad + to_rad));
        // The distance from the centre grows along each side towards a corner, and both corners of
        // an arc are equally far.
        let half = 0.5 * (to_rad - from_rad);
        let radius_rad =
            between(middle, inner_rad, half).max(between(middle, outer_rad, half)) * (1.0 + 1e-9);
        Self { centre, radius_rad }
    }

    /// The cap of radius `radius_rad` about a frame's point.
    pub fn disc(frame: &FocusFrame, radius_rad: f64) -> Self {
        Self {
            centre: frame.up,
            radius_rad,
        }
    }

    /// Greatest scalar product of a vector with a direction inside the cap.
    fn support(&self, vector: DVec3) -> f64 {
        let along = vector.dot(self.centre);
        let across = vector.cross(self.centre).length();
        let (sin_radius, cos_radius) = libm::sincos(self.radius_rad);
        // Inside the cap, the vector's own direction is the best: its angle from the centre,
        // atan2(across, along), is then no larger than the radius.
        if libm::atan2(across, along) <= self.radius_rad {
            return vector.length();
        }
        along * cos_radius + across * sin_radius
    }
}

/// Central angle between two places at `a` and `b` from a point, in azimuths `azimuth` apart.
fn between(a: f64, b: f64, azimuth: f64) -> f64 {
    let half = |x: f64| {
        let s = libm::sin(0.5 * x);
        s * s
    };
    let h = half(a - b) + libm::sin(a) * libm::sin(b) * half(azimuth);
    2.0 * libm::asin(h.clamp(0.0, 1.0).sqrt())
}

/// Culls for one view.
#[derive(Clone, Copy, Debug)]
pub struct Culler {
    view: View,
    radius_m: f64,
    occluder_m: f64,
    eye_m: f64,
    zenith: DVec3,
}

impl Culler {
    /// For a view of a planet whose terrain is nowhere lower than `lowest_m` (drawn heights, metres
    /// above the sphere).
    pub fn new(view: View, planet: &Planet, lowest_m: f64) -> Self {
        let eye_m = view.eye.length();
        Self {
            view,
            radius_m: planet.radius_m,
            occluder_m: planet.radius_m + lowest_m,
            eye_m,
            zenith: view.eye / eye_m,
        }
    }

    /// Whether terrain of the given (drawn) heights inside the patch can be seen; may say yes where
    /// it cannot.
    pub fn sees(&self, patch: &Patch, heights: &HeightRange) -> bool {
        let low = self.radius_m + heights.min_m;
        let high = self.radius_m + heights.max_m;
        let in_frustum = self
            .view
            .sides
            .iter()
            .all(|&side| self.reach(patch, low, high, side) >= 0.0);
        in_frustum && {
            let nearest = angle(self.zenith, patch.centre) - patch.radius_rad;
            nearest <= horizon_rad(self.eye_m, high, self.occluder_m)
        }
    }

    /// Smallest and largest view depth (distance along the direction of view) of such terrain,
    /// metres; negative behind the eye.
    pub fn depth_range(&self, patch: &Patch, heights: &HeightRange) -> (f64, f64) {
        let low = self.radius_m + heights.min_m;
        let high = self.radius_m + heights.max_m;
        let forward = self.view.forward;
        (
            -self.reach(patch, low, high, -forward),
            self.reach(patch, low, high, forward),
        )
    }

    /// Greatest signed distance of the piece from the plane through the eye with the given normal,
    /// metres, widened by what rounding can take away.
    fn reach(&self, patch: &Patch, low_m: f64, high_m: f64, normal: DVec3) -> f64 {
        let support = patch.support(normal);
        let farthest = if support > 0.0 { high_m } else { low_m } * support;
        farthest - normal.dot(self.view.eye) + 1e-15 * (high_m + self.eye_m) + 1e-6
    }
}

/// Angle between two unit vectors, accurate when small.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}
