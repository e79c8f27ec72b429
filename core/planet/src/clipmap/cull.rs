//! Conservative culling of pieces of terrain against the frustum and the horizon.
//!
//! Law: a piece that holds a visible point is never culled (`tests/clipmap_laws.rs`).

use core::f64::consts::{PI, TAU};

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
    sin_radius: f64,
    cos_radius: f64,
}

impl Patch {
    /// The cap of radius `radius_rad` (0 to π) about a direction (unit).
    pub fn new(centre: DVec3, radius_rad: f64) -> Self {
        let (sin_radius, cos_radius) = libm::sincos(radius_rad);
        Self {
            centre,
            radius_rad,
            sin_radius,
            cos_radius,
        }
    }

    /// The cap around a sector of an annulus about a frame's point: angles `inner_rad..=outer_rad`
    /// (at most π) and azimuths `from_rad..=to_rad` (at most π/2 apart).
    pub fn sector(
        frame: &FocusFrame,
        (inner_rad, outer_rad): (f64, f64),
        (from_rad, to_rad): (f64, f64),
    ) -> Self {
        let middle = 0.5 * (inner_rad + outer_rad);
        let centre = frame.direction(middle, 0.5 * (from_rad + to_rad));
        Self::new(
            centre,
            sector_radius(inner_rad, outer_rad, 0.5 * (to_rad - from_rad)),
        )
    }

    /// The caps around all of `count` (at least 4) equal sectors of an annulus, beginning at azimuth
    /// 0: as [`Self::sector`], but cheaper.
    pub fn sectors(
        frame: &FocusFrame,
        (inner_rad, outer_rad): (f64, f64),
        count: u32,
    ) -> impl Iterator<Item = Self> {
        let step = TAU / f64::from(count);
        let (sin_middle, cos_middle) = libm::sincos(0.5 * (inner_rad + outer_rad));
        let first = Self::new(frame.up, sector_radius(inner_rad, outer_rad, 0.5 * step));
        let frame = *frame;
        (0..count).map(move |k| {
            let (sin_azimuth, cos_azimuth) = libm::sincos((f64::from(k) + 0.5) * step);
            let aside = frame.south * cos_azimuth + frame.east * sin_azimuth;
            Self {
                centre: frame.up * cos_middle + aside * sin_middle,
                ..first
            }
        })
    }

    /// Greatest scalar product of a unit vector with a direction inside the cap.
    fn support(&self, unit: DVec3) -> f64 {
        let along = unit.dot(self.centre);
        // Inside the cap the vector's own direction is the best. (Where rounding decides, both
        // answers agree to the last digits.)
        if along >= self.cos_radius {
            return 1.0;
        }
        along * self.cos_radius + unit.cross(self.centre).length() * self.sin_radius
    }
}

/// Radius of the cap around a sector, about the middle of its angles and azimuths: the distance grows
/// along each side towards a corner, and both corners of an arc are equally far.
fn sector_radius(inner_rad: f64, outer_rad: f64, half_azimuth_rad: f64) -> f64 {
    let middle = 0.5 * (inner_rad + outer_rad);
    let inner = between(middle, inner_rad, half_azimuth_rad);
    let outer = between(middle, outer_rad, half_azimuth_rad);
    (inner.max(outer) * (1.0 + 1e-9)).min(PI)
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
    eye_horizon_rad: f64,
    zenith: DVec3,
}

impl Culler {
    /// For a view of a planet whose terrain is nowhere lower than `lowest_m` (drawn heights, metres
    /// above the sphere).
    pub fn new(view: View, planet: &Planet, lowest_m: f64) -> Self {
        let eye_m = view.eye.length();
        let occluder_m = planet.radius_m + lowest_m;
        Self {
            view,
            radius_m: planet.radius_m,
            occluder_m,
            eye_m,
            eye_horizon_rad: horizon_rad(eye_m, occluder_m, occluder_m),
            zenith: view.eye / eye_m,
        }
    }

    /// The part of a range of (drawn) heights at which terrain inside the patch can be seen, or
    /// `None` when none can; may answer too much, never too little.
    ///
    /// A height is ruled out when at that height the whole patch lies outside one side of the
    /// frustum, behind the eye, or below the horizon. Ruling out heights one by one rather than the
    /// piece as a whole is what culls a narrow column of unknown height next to the eye.
    pub fn sees(&self, patch: &Patch, heights: &HeightRange) -> Option<HeightRange> {
        let mut low = self.radius_m + heights.min_m;
        let mut high = self.radius_m + heights.max_m;
        for &normal in self.view.sides.iter().chain([&self.view.forward]) {
            // Inside at distance r from the planet's centre: r · support ≥ normal · eye.
            let support = patch.support(normal);
            let bound = normal.dot(self.view.eye) - self.rounding_m(high);
            if support > 0.0 {
                low = low.max(bound / support);
            } else if support < 0.0 {
                high = high.min(bound / support);
            } else if bound > 0.0 {
                return None;
            }
            if low > high {
                return None;
            }
        }
        let nearest = angle(self.zenith, patch.centre) - patch.radius_rad;
        let behind = nearest - self.eye_horizon_rad;
        if behind > 0.0 && behind > libm::acos((self.occluder_m / high).min(1.0)) {
            return None;
        }
        Some(HeightRange {
            min_m: low - self.radius_m,
            max_m: high - self.radius_m,
        })
    }

    /// Smallest and largest view depth (distance along the direction of view) of terrain of the
    /// given (drawn) heights inside the patch, metres; negative behind the eye.
    pub fn depth_range(&self, patch: &Patch, heights: &HeightRange) -> (f64, f64) {
        let (low, high) = (self.radius_m + heights.min_m, self.radius_m + heights.max_m);
        let farthest = |normal: DVec3| {
            let support = patch.support(normal);
            let reach = if support > 0.0 { high } else { low } * support;
            reach - normal.dot(self.view.eye) + self.rounding_m(high)
        };
        (-farthest(-self.view.forward), farthest(self.view.forward))
    }

    /// What rounding can take away from a distance to a plane, metres.
    fn rounding_m(&self, high_m: f64) -> f64 {
        2e-15 * (high_m + self.eye_m) + 1e-6
    }
}

/// Angle between two unit vectors, accurate when small.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}
