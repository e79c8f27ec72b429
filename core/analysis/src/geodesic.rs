//! Lengths, directions and areas along geodesics of the planet's ellipsoid.

use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic, PolygonArea, Winding};
use relievo_planet::{MapPoint, Planet};

/// Measures on one planet's ellipsoid (a sphere where its flattening is 0).
///
/// Source: Karney, Algorithms for geodesics, J. Geodesy 87 (2013), as `geographiclib-rs` has them:
/// about 15 nm on Earth. The series hold for flattenings up to about 1/50; beyond that lengths lose
/// accuracy (about 10⁻⁶ of them at 1/10).
#[derive(Clone, Debug)]
pub struct Measure {
    geodesic: Geodesic,
}

/// Area and perimeter of a polygon whose edges are geodesics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingArea {
    /// Area in square metres on the ellipsoid, holes taken out, never negative.
    pub area_m2: f64,
    /// Length of all its edges in metres, those of holes included.
    pub perimeter_m: f64,
}

impl Measure {
    /// Measures on a planet.
    pub fn new(planet: &Planet) -> Self {
        Self {
            geodesic: Geodesic::new(planet.equatorial_radius_m, planet.flattening),
        }
    }

    /// Length of the shortest way between two points in metres.
    pub fn distance_m(&self, from: MapPoint, to: MapPoint) -> f64 {
        self.way(from, to).0
    }

    /// Length in metres of the shortest way between two points and its azimuth at `from`, radians
    /// clockwise from north, −π to π.
    pub fn way(&self, from: MapPoint, to: MapPoint) -> (f64, f64) {
        let ((lon1, lat1), (lon2, lat2)) = (from.to_degrees(), to.to_degrees());
        let (distance_m, azimuth_deg, _, _): (f64, f64, f64, f64) =
            self.geodesic.inverse(lat1, lon1, lat2, lon2);
        (distance_m, azimuth_deg.to_radians())
    }

    /// Where one arrives after `distance_m` metres from a point towards an azimuth in radians.
    pub fn destination(&self, from: MapPoint, azimuth_rad: f64, distance_m: f64) -> MapPoint {
        let (lon, lat) = from.to_degrees();
        let (lat, lon): (f64, f64) =
            self.geodesic
                .direct(lat, lon, azimuth_rad.to_degrees(), distance_m);
        MapPoint::from_degrees(lon, lat).normalised()
    }

    /// Length of a line of geodesic legs in metres; 0 for fewer than two points.
    pub fn length_m(&self, line: &[MapPoint]) -> f64 {
        line.windows(2)
            .map(|leg| self.distance_m(leg[0], leg[1]))
            .sum()
    }

    /// Area of a polygon: `rings[0]` is the outline, the others are holes; unclosed, wound either
    /// way. A ring encloses the smaller of the two parts of the planet, so one around a pole is
    /// right too. 0 for rings of fewer than three points.
    pub fn area(&self, rings: &[Vec<MapPoint>]) -> RingArea {
        let mut sum = RingArea {
            area_m2: 0.0,
            perimeter_m: 0.0,
        };
        for (index, ring) in rings.iter().enumerate() {
            let (perimeter_m, area_m2) = self.ring(ring);
            sum.perimeter_m += perimeter_m;
            sum.area_m2 += if index == 0 { area_m2 } else { -area_m2 };
        }
        sum.area_m2 = sum.area_m2.max(0.0);
        sum
    }

    /// Perimeter and area of one ring.
    fn ring(&self, ring: &[MapPoint]) -> (f64, f64) {
        if ring.len() < 3 {
            return (self.length_m(ring), 0.0);
        }
        let mut polygon = PolygonArea::new(&self.geodesic, Winding::CounterClockwise);
        for point in ring {
            let (lon, lat) = point.to_degrees();
            polygon.add_point(lat, lon);
        }
        let (perimeter_m, area_m2, _) = polygon.compute(true);
        let area_m2 = area_m2.abs();
        (perimeter_m, area_m2.min(self.geodesic.area() - area_m2))
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    fn at(lon_deg: f64, lat_deg: f64) -> MapPoint {
        MapPoint::from_degrees(lon_deg, lat_deg)
    }

    #[test]
    fn known_lengths_come_out_to_a_micrometre() {
        let earth = Measure::new(&Planet::EARTH);
        // Quarter meridian of WGS 84.
        let quarter_m = earth.distance_m(at(0.0, 0.0), at(0.0, 90.0));
        assert!((quarter_m - 10_001_965.729_312).abs() < 1e-5, "{quarter_m}");
        // From GeographicLib's manual: JFK to LHR.
        let (length_m, azimuth) = earth.way(at(-73.8, 40.6), at(-0.5, 51.6));
        assert!((length_m - 5_551_759.400).abs() < 1e-3, "{length_m}");
        assert!((azimuth.to_degrees() - 51.198_882_846).abs() < 1e-7);
    }

    #[test]
    fn other_planets_have_their_own_lengths() {
        let moon = Measure::new(&Planet::MOON);
        let half_m = moon.distance_m(at(-90.0, 0.0), at(90.0, 0.0));
        assert!((half_m - PI * 1_737_400.0).abs() < 1e-5);
        let mars = Measure::new(&Planet::MARS);
        let degree_m = mars.distance_m(at(0.0, 0.0), at(1.0, 0.0));
        assert!((degree_m - 3_396_190.0_f64.to_radians()).abs() < 1e-6);
    }

    #[test]
    fn a_hemisphere_around_a_pole_has_half_the_area() {
        let sphere = Measure::new(&Planet::sphere(1000.0));
        let equator: Vec<_> = (0..36).map(|i| at(f64::from(i) * 10.0, 0.0)).collect();
        let half = sphere.area(&[equator]);
        assert!((half.area_m2 / (2.0 * PI * 1e6) - 1.0).abs() < 1e-12);
        assert!((half.perimeter_m / (2.0 * PI * 1000.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_ring_around_the_antimeridian_or_a_pole_is_as_large_as_elsewhere() {
        let earth = Measure::new(&Planet::EARTH);
        let square = |lon: f64| {
            vec![
                at(lon, 0.0),
                at(lon + 1.0, 0.0),
                at(lon + 1.0, 1.0),
                at(lon, 1.0),
            ]
        };
        let here = earth.area(&[square(10.0)]).area_m2;
        assert!(
            (here - 12_308_778_361.469_452).abs() < 1e-2,
            "GeographicLib's own example"
        );
        assert!((earth.area(&[square(179.5)]).area_m2 / here - 1.0).abs() < 1e-12);
        let cap: Vec<_> = (0..720).map(|i| at(-f64::from(i) * 0.5, -89.0)).collect();
        let sphere = Measure::new(&Planet::sphere(6e6));
        let exact = 2.0 * PI * 36e12 * (1.0 - libm::cos(1.0_f64.to_radians()));
        assert!((sphere.area(&[cap]).area_m2 / exact - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_hole_is_taken_out_and_slivers_are_nothing() {
        let earth = Measure::new(&Planet::EARTH);
        let outer = vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let hole = vec![at(0.2, 0.2), at(0.2, 0.4), at(0.4, 0.4), at(0.4, 0.2)];
        let alone = earth.area(std::slice::from_ref(&hole)).area_m2;
        let whole = earth.area(std::slice::from_ref(&outer)).area_m2;
        let both = earth.area(&[outer, hole]);
        assert!((both.area_m2 - (whole - alone)).abs() < 1e-3);
        assert_eq!(earth.area(&[vec![at(0.0, 0.0), at(1.0, 1.0)]]).area_m2, 0.0);
        assert_eq!(earth.area(&[]).area_m2, 0.0);
    }

    proptest! {
        #[test]
        fn a_way_that_is_gone_leads_to_its_end(
            lon in -180.0..180.0, lat in -89.0..89.0, azimuth in -PI..PI, distance in 1.0..1e6,
        ) {
            let earth = Measure::new(&Planet::EARTH);
            let from = at(lon, lat);
            let to = earth.destination(from, azimuth, distance);
            prop_assert!((earth.distance_m(from, to) - distance).abs() < 1e-6);
        }
    }
}
