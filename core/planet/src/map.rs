//! Points of the map.

use core::f64::consts::{PI, TAU};

use glam::DVec3;

/// A point of the map: longitude and colatitude in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPoint {
    /// Longitude, east positive. Any finite value; [`MapPoint::normalised`] gives −π ≤ lon < π.
    pub lon_rad: f64,
    /// Colatitude: 0 at the north pole, π at the south pole. Values outside reflect over the pole.
    pub colat_rad: f64,
}

impl MapPoint {
    /// From longitude and colatitude in radians.
    pub const fn new(lon_rad: f64, colat_rad: f64) -> Self {
        Self { lon_rad, colat_rad }
    }

    /// From longitude and latitude in degrees, as users write them.
    pub fn from_degrees(lon_deg: f64, lat_deg: f64) -> Self {
        Self::new(lon_deg.to_radians(), (90.0 - lat_deg).to_radians())
    }

    /// Latitude in radians.
    pub fn lat_rad(&self) -> f64 {
        PI / 2.0 - self.colat_rad
    }

    /// Longitude and latitude in degrees, longitude in −180 ≤ lon < 180.
    pub fn to_degrees(self) -> (f64, f64) {
        let p = self.normalised();
        (p.lon_rad.to_degrees(), 90.0 - p.colat_rad.to_degrees())
    }

    /// The same place with −π ≤ lon < π and 0 ≤ colat ≤ π: rows beyond a pole come back on the
    /// opposite meridian. Values already in range are returned bit for bit.
    #[must_use]
    pub fn normalised(self) -> Self {
        let mut p = self;
        if !(0.0..=PI).contains(&p.colat_rad) {
            p.colat_rad = p.colat_rad.rem_euclid(TAU);
            if p.colat_rad > PI {
                p.colat_rad = TAU - p.colat_rad;
                p.lon_rad += PI;
            }
        }
        if !(-PI..PI).contains(&p.lon_rad) {
            p.lon_rad = wrap_longitude(p.lon_rad);
        }
        p
    }

    /// Unit vector in world space.
    pub fn to_unit(self) -> DVec3 {
        let (sin_colat, cos_colat) = libm::sincos(self.colat_rad);
        let (sin_lon, cos_lon) = libm::sincos(self.lon_rad);
        DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat)
    }

    /// The point below a world-space direction of any length but zero.
    pub fn from_direction(direction: DVec3) -> Self {
        let horizontal = libm::hypot(direction.x, direction.y);
        Self::new(
            libm::atan2(direction.y, direction.x),
            libm::atan2(horizontal, direction.z),
        )
    }

    /// Central angle to another point in radians, accurate for tiny and for near-antipodal ones.
    pub fn angle_to(self, other: Self) -> f64 {
        let (a, b) = (self.to_unit(), other.to_unit());
        libm::atan2(a.cross(b).length(), a.dot(b))
    }
}

/// A longitude or a difference of longitudes brought to −π ≤ x < π.
pub fn wrap_longitude(lon_rad: f64) -> f64 {
    let wrapped = (lon_rad + PI).rem_euclid(TAU) - PI;
    // rem_euclid may round up to TAU itself.
    if wrapped >= PI { -PI } else { wrapped }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_row_beyond_the_pole_comes_back_on_the_opposite_meridian() {
        let p = MapPoint::new(0.5, -0.25).normalised();
        assert!((p.colat_rad - 0.25).abs() < 1e-15 && (p.lon_rad - (0.5 - PI)).abs() < 1e-15);
        let q = MapPoint::new(0.5, PI + 0.25).normalised();
        assert!((q.colat_rad - (PI - 0.25)).abs() < 1e-15);
    }

    #[test]
    fn directions_and_points_round_trip_even_at_the_poles() {
        for colat in [0.0, 1e-9, 0.3, 1.5, 3.0, PI - 1e-9, PI] {
            for lon in [-PI, -1.0, 0.0, 2.0] {
                let p = MapPoint::new(lon, colat);
                let back = MapPoint::from_direction(p.to_unit() * 7.0);
                assert!(p.angle_to(back) < 1e-15, "{p:?} -> {back:?}");
            }
        }
    }

    #[test]
    fn a_point_in_range_is_returned_bit_for_bit() {
        for p in [
            MapPoint::new(-PI, 0.0),
            MapPoint::new(0.1, PI),
            MapPoint::new(3.1, 1e-300),
        ] {
            assert_eq!(p.normalised(), p);
        }
    }

    proptest! {
        #[test]
        fn normalising_keeps_the_place_and_reaches_the_range(lon in -50.0..50.0, colat in -20.0..20.0) {
            let p = MapPoint::new(lon, colat);
            let q = p.normalised();
            prop_assert!((-PI..PI).contains(&q.lon_rad) && (0.0..=PI).contains(&q.colat_rad));
            prop_assert!(p.to_unit().distance(q.to_unit()) < 1e-13);
            prop_assert_eq!(q.normalised(), q);
        }

        #[test]
        fn degrees_round_trip(lon in -180.0..180.0, lat in -90.0..90.0) {
            let (lon_back, lat_back) = MapPoint::from_degrees(lon, lat).to_degrees();
            prop_assert!((lon_back - lon).abs() < 1e-12 && (lat_back - lat).abs() < 1e-12);
        }

        #[test]
        fn a_wrapped_longitude_is_in_range_and_differs_by_whole_turns(lon in -1e4..1e4) {
            let wrapped = wrap_longitude(lon);
            prop_assert!((-PI..PI).contains(&wrapped));
            let turns = (lon - wrapped) / TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-10);
        }
    }
}
