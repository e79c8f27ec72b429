//! Flat frames in metres around a place.

use std::sync::Arc;

use glam::DVec2;
use relievo_planet::{GridCrs, Lattice, MapPoint, Planet};

use crate::geodesic::Measure;

/// An azimuthal equidistant frame on the ellipsoid: x metres east, y metres north of a centre.
/// Distances and directions from the centre are true everywhere, also at a pole and across the
/// antimeridian.
#[derive(Clone, Debug)]
pub struct LocalFrame {
    /// The centre.
    pub centre: MapPoint,
    planet: Planet,
    measure: Measure,
    definition: Arc<str>,
}

impl LocalFrame {
    /// The frame around a point of a planet.
    pub fn new(planet: Planet, centre: MapPoint) -> Self {
        let centre = centre.normalised();
        let (lon_deg, lat_deg) = centre.to_degrees();
        let polar_m = planet.equatorial_radius_m * (1.0 - planet.flattening);
        let name = format!(
            "+proj=aeqd +lat_0={lat_deg} +lon_0={lon_deg} +x_0=0 +y_0=0 +a={} +b={polar_m} +units=m +no_defs",
            planet.equatorial_radius_m
        );
        Self {
            centre,
            planet,
            measure: Measure::new(&planet),
            definition: Arc::from(name),
        }
    }

    /// The frame as a proj string.
    pub fn definition(&self) -> &str {
        &self.definition
    }

    /// The planet's figure.
    pub fn planet(&self) -> &Planet {
        &self.planet
    }

    /// A lattice of square samples of `spacing_m`, rows southward: the corner that sample (0, 0)
    /// shares with its north-western neighbours lies at `corner_m`.
    pub fn lattice(&self, corner_m: DVec2, spacing_m: f64) -> Lattice {
        Lattice {
            crs: GridCrs::Projected(Arc::clone(&self.definition)),
            origin: corner_m,
            step: DVec2::new(spacing_m, -spacing_m),
            columns_around: None,
        }
    }

    /// The place at a point of the frame.
    pub fn place(&self, at_m: DVec2) -> MapPoint {
        let distance_m = at_m.length();
        if distance_m == 0.0 {
            return self.centre;
        }
        self.measure
            .destination(self.centre, libm::atan2(at_m.x, at_m.y), distance_m)
    }

    /// Where a place lies in the frame.
    pub fn point_m(&self, place: MapPoint) -> DVec2 {
        let (distance_m, azimuth_rad) = self.measure.way(self.centre, place);
        let (sin, cos) = libm::sincos(azimuth_rad);
        DVec2::new(sin, cos) * distance_m
    }

    /// Square metres on the ellipsoid per square metre of the frame at a point: below 1 away from
    /// the centre, where circles around it are drawn too long. Exact on a sphere; within 10⁻⁵ of
    /// its difference from 1 per kilometre on Earth's ellipsoid.
    pub fn area_scale(&self, at_m: DVec2) -> f64 {
        let angle = at_m.length() / self.mean_radius_m();
        if angle < 1e-4 {
            return 1.0 - angle * angle / 6.0;
        }
        libm::sin(angle) / angle
    }

    /// Gauss's mean radius of curvature at the centre in metres.
    pub fn mean_radius_m(&self) -> f64 {
        let lat_rad = self.centre.lat_rad();
        let meridian_m = self.planet.meridian_radius_m(lat_rad);
        (meridian_m * self.planet.prime_vertical_radius_m(lat_rad)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn places_come_back_to_their_point(
            lon in -180.0..180.0, lat in -90.0..=90.0, x in -5e4..5e4, y in -5e4..5e4,
        ) {
            let frame = LocalFrame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
            let at = DVec2::new(x, y);
            prop_assert!((frame.point_m(frame.place(at)) - at).length() < 1e-5);
        }
    }

    #[test]
    fn a_small_square_far_from_the_centre_has_the_area_its_scale_says() {
        let frame = LocalFrame::new(Planet::EARTH, MapPoint::from_degrees(11.0, 47.0));
        let measure = Measure::new(&Planet::EARTH);
        for at in [
            DVec2::new(0.0, 0.0),
            DVec2::new(3e5, 1e5),
            DVec2::new(-2e4, 5e5),
        ] {
            let ring: Vec<_> = [(0.0, 0.0), (1e3, 0.0), (1e3, 1e3), (0.0, 1e3)]
                .into_iter()
                .map(|(x, y)| frame.place(at + DVec2::new(x, y)))
                .collect();
            let area = measure.area(&[ring]).area_m2;
            let scale = frame.area_scale(at + 500.0);
            assert!(
                (area / 1e6 / scale - 1.0).abs() < 2e-6,
                "{at}: {area} {scale}"
            );
        }
    }
}
