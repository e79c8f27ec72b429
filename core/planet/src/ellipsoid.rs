//! The planet's shape: a sphere that places vertices, an ellipsoid that measures.

use glam::DVec3;

use crate::MapPoint;

/// A planet's figure.
///
/// Only the placement of vertices uses the sphere; every metre that a user sees comes from the
/// ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planet {
    /// Radius of the sphere in metres, finite, 1 to 10⁹.
    pub radius_m: f64,
    /// Equatorial radius of the ellipsoid in metres.
    pub equatorial_radius_m: f64,
    /// Flattening (a − b) / a of the ellipsoid, 0 ≤ f < 1.
    pub flattening: f64,
}

impl Planet {
    /// Earth: sphere of the mean radius, WGS 84 ellipsoid.
    pub const EARTH: Self = Self {
        radius_m: 6_371_008.8,
        equatorial_radius_m: 6_378_137.0,
        flattening: 1.0 / 298.257_223_563,
    };

    /// A sphere of the given radius.
    pub const fn sphere(radius_m: f64) -> Self {
        Self { radius_m, equatorial_radius_m: radius_m, flattening: 0.0 }
    }

    /// World position of a point `height_m` metres above the sphere.
    pub fn position(&self, point: MapPoint, height_m: f64) -> DVec3 {
        point.to_unit() * (self.radius_m + height_m)
    }
}
