//! The planet's shape: a sphere that places vertices, an ellipsoid that measures.

use core::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::MapPoint;

/// A planet's figure.
///
/// Only the placement of vertices uses the sphere; every metre that a user sees comes from the
/// ellipsoid, whose geodetic latitude is the map's latitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planet {
    /// Radius of the sphere in metres, finite, 1 to 10⁹.
    pub radius_m: f64,
    /// Equatorial radius of the ellipsoid in metres.
    pub equatorial_radius_m: f64,
    /// Flattening (a − b) / a of the ellipsoid, 0 ≤ f < 1.
    pub flattening: f64,
}

/// No ground is drawn nearer to the planet's centre than this part of its radius.
pub const LEAST_RADIUS_SHARE: f64 = 0.1;

/// Why a planet's figure is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanetError {
    /// The sphere's radius is out of range.
    Radius(f64),
    /// The ellipsoid's equatorial radius is out of range.
    EquatorialRadius(f64),
    /// The flattening is out of range.
    Flattening(f64),
}

impl core::fmt::Display for PlanetError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Radius(found) => {
                write!(
                    f,
                    "a planet's radius is 1 to 1e9 metres, this one is {found}"
                )
            }
            Self::EquatorialRadius(found) => {
                write!(
                    f,
                    "a planet's equatorial radius is 1 to 1e9 metres, this one is {found}"
                )
            }
            Self::Flattening(found) => {
                write!(
                    f,
                    "a planet's flattening is at least 0 and below 1, this one is {found}"
                )
            }
        }
    }
}

impl core::error::Error for PlanetError {}

impl Planet {
    /// The greatest factor e on heights for which the lowest ground stays above a tenth of the radius:
    /// R + e · h ≥ 0.1 R. Infinite where no ground lies below the datum.
    ///
    /// - `lowest_m`: lowest height above the datum, metres.
    pub fn greatest_exaggeration(&self, lowest_m: f64) -> f64 {
        if lowest_m < 0.0 {
            (1.0 - LEAST_RADIUS_SHARE) * self.radius_m / -lowest_m
        } else {
            f64::INFINITY
        }
    }

    /// Earth: sphere of the mean radius, WGS 84 ellipsoid.
    pub const EARTH: Self = Self {
        radius_m: 6_371_008.8,
        equatorial_radius_m: 6_378_137.0,
        flattening: 1.0 / 298.257_223_563,
    };

    /// Mars: sphere of the mean radius, IAU 2000 ellipsoid.
    pub const MARS: Self = Self {
        radius_m: 3_389_500.0,
        equatorial_radius_m: 3_396_190.0,
        flattening: 1.0 / 169.894_447_223_612,
    };

    /// The Moon: IAU sphere, also as the ellipsoid.
    pub const MOON: Self = Self::sphere(1_737_400.0);

    /// Smallest and largest radius of a planet in metres.
    pub const RADIUS_RANGE_M: core::ops::RangeInclusive<f64> = 1.0..=1e9;

    /// A planet of checked figure: radii in metres, flattening without unit.
    ///
    /// # Errors
    /// If a radius is not finite or not 1 to 10⁹ m, or unless 0 ≤ `flattening` < 1.
    pub fn new(
        radius_m: f64,
        equatorial_radius_m: f64,
        flattening: f64,
    ) -> Result<Self, PlanetError> {
        if !Self::RADIUS_RANGE_M.contains(&radius_m) {
            return Err(PlanetError::Radius(radius_m));
        }
        if !Self::RADIUS_RANGE_M.contains(&equatorial_radius_m) {
            return Err(PlanetError::EquatorialRadius(equatorial_radius_m));
        }
        if !(0.0..1.0).contains(&flattening) {
            return Err(PlanetError::Flattening(flattening));
        }
        Ok(Self {
            radius_m,
            equatorial_radius_m,
            flattening,
        })
    }

    /// A sphere of the given radius.
    pub const fn sphere(radius_m: f64) -> Self {
        Self {
            radius_m,
            equatorial_radius_m: radius_m,
            flattening: 0.0,
        }
    }

    /// World position of a point `height_m` metres above the sphere.
    pub fn position(&self, point: MapPoint, height_m: f64) -> DVec3 {
        point.to_unit() * (self.radius_m + height_m)
    }

    /// Square of the ellipsoid's first eccentricity, e² = f (2 − f).
    pub fn eccentricity_squared(&self) -> f64 {
        self.flattening * (2.0 - self.flattening)
    }

    /// Radius of curvature M of the meridian at a geodetic latitude in radians, metres.
    pub fn meridian_radius_m(&self, lat_rad: f64) -> f64 {
        let e2 = self.eccentricity_squared();
        let sin_lat = libm::sin(lat_rad);
        let q = 1.0 - e2 * sin_lat * sin_lat;
        self.equatorial_radius_m * (1.0 - e2) / (q * q.sqrt())
    }

    /// Radius of curvature N in the prime vertical at a geodetic latitude in radians, metres.
    pub fn prime_vertical_radius_m(&self, lat_rad: f64) -> f64 {
        let sin_lat = libm::sin(lat_rad);
        let q = 1.0 - self.eccentricity_squared() * sin_lat * sin_lat;
        self.equatorial_radius_m / q.sqrt()
    }

    /// Metres on the ellipsoid per radian of longitude (x) and of colatitude (y) at a colatitude
    /// (0 to π): N sin θ, which is 0 at the poles, and M.
    pub fn metres_per_radian(&self, colat_rad: f64) -> DVec2 {
        // The colatitude's own sine keeps the circles of latitude right down to the pole.
        let (sin_colat, cos_colat) = libm::sincos(colat_rad);
        let e2 = self.eccentricity_squared();
        let q = 1.0 - e2 * cos_colat * cos_colat;
        let prime_vertical_m = self.equatorial_radius_m / q.sqrt();
        DVec2::new(
            prime_vertical_m * sin_colat,
            prime_vertical_m * (1.0 - e2) / q,
        )
    }

    /// How far `to` lies from `from` along the ellipsoid: metres east (x) and north (y) in the
    /// frame at `from`.
    ///
    /// Azimuthal equidistant on the sphere of directions, scaled by the radii of curvature at the
    /// latitude half way: exact in the limit of near points and for them free of cancellation
    /// (1 nm apart is as good as 1 km), off by about 10⁻⁹ of the distance at 1 km and 10⁻⁴ at
    /// 1000 km on Earth. At a pole, where M = N, directions are those of `from`'s own meridian.
    /// Finite for any two points; the antipode comes out due north.
    pub fn offset_m(&self, from: MapPoint, to: MapPoint) -> DVec2 {
        let (sin_from, cos_from) = libm::sincos(from.colat_rad);
        let (sin_to, cos_to) = libm::sincos(to.colat_rad);
        let lon_rad = to.lon_rad - from.lon_rad;
        let sin_half = libm::sin(lon_rad / 2.0);
        let versine = 2.0 * sin_half * sin_half;
        let north = libm::sin(from.colat_rad - to.colat_rad) + cos_from * sin_to * versine;
        let east = sin_to * libm::sin(lon_rad);
        let up = libm::cos(from.colat_rad - to.colat_rad) - sin_from * sin_to * versine;
        let sine = libm::hypot(east, north);
        let middle = {
            let colat = f64::midpoint(from.colat_rad, to.colat_rad);
            // Over a pole the middle of the way is not the mean of the colatitudes; in doubt the
            // start counts.
            if lon_rad.abs() < 1.0 || cos_to == 0.0 {
                colat
            } else {
                from.colat_rad
            }
        };
        let lat_rad = PI / 2.0 - middle;
        let (meridian_m, prime_m) = (
            self.meridian_radius_m(lat_rad),
            self.prime_vertical_radius_m(lat_rad),
        );
        if sine == 0.0 {
            return DVec2::new(0.0, if up < 0.0 { PI * meridian_m } else { 0.0 });
        }
        let angle_per_sine = libm::atan2(sine, up) / sine;
        DVec2::new(east * prime_m, north * meridian_m) * angle_per_sine
    }

    /// Angle at the planet's centre from a viewer `height_m` above the sphere to the horizon:
    /// acos(R / (R + h)) without its cancellation, radians, 0 below the surface.
    pub fn horizon_angle_rad(&self, height_m: f64) -> f64 {
        let h = height_m.max(0.0);
        2.0 * libm::asin((h / (2.0 * (self.radius_m + h))).sqrt())
    }

    /// Distance to the horizon along the sphere in metres; see [`Self::horizon_angle_rad`].
    pub fn horizon_distance_m(&self, height_m: f64) -> f64 {
        self.radius_m * self.horizon_angle_rad(height_m)
    }
}

/// Distance in metres along a ray to its nearest hit, 0 or more, of the sphere of `radius_m`
/// around the world's origin; `None` for a miss, a sphere behind the eye, or a direction or eye
/// that is not finite or has no length.
///
/// - `direction`: any length but zero; the distance is in metres all the same.
///
/// From inside the hit is where the ray leaves. The quadratic is solved from the ray's point of
/// closest approach and by the root that adds, so that neither a grazing ray nor an eye 1 m above
/// a radius of 10⁹ m cancels.
pub fn ray_sphere(eye: DVec3, direction: DVec3, radius_m: f64) -> Option<f64> {
    let direction = direction.try_normalize()?;
    let eye_m = eye.length();
    if !eye_m.is_finite() || !radius_m.is_finite() {
        return None;
    }
    let along = eye.dot(direction);
    let miss_m = (eye - along * direction).length();
    let half_chord_squared = (radius_m - miss_m) * (radius_m + miss_m);
    if half_chord_squared < 0.0 {
        return None;
    }
    let half_chord = half_chord_squared.sqrt();
    // The product of both roots: positive outside.
    let product = (eye_m - radius_m) * (eye_m + radius_m);
    if along < 0.0 {
        let far = half_chord - along;
        Some(if product >= 0.0 { product / far } else { far })
    } else if product > 0.0 {
        None
    } else {
        let sum = along + half_chord;
        // On the surface and level with it: the eye itself.
        Some(if sum > 0.0 { -product / sum } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn radii_m() -> impl Strategy<Value = f64> {
        (0.0..9.0_f64).prop_map(libm::exp10)
    }

    #[test]
    fn a_figure_out_of_range_is_refused_in_one_line() {
        assert!(Planet::new(6e6, 6e6, 0.003).is_ok());
        for (r, a, f) in [
            (0.5, 6e6, 0.0),
            (f64::NAN, 6e6, 0.0),
            (2e9, 6e6, 0.0),
            (6e6, f64::INFINITY, 0.0),
            (6e6, 6e6, 1.0),
            (6e6, 6e6, -0.1),
        ] {
            let message = Planet::new(r, a, f).expect_err("out of range").to_string();
            assert!(
                !message.contains('\n') && message.contains("this one is"),
                "{message}"
            );
        }
    }

    #[test]
    fn earths_radii_of_curvature_are_those_of_the_tables() {
        // WGS 84 at 45°: M = 6 367 381.816 m, N = 6 388 838.290 m.
        assert!((Planet::EARTH.meridian_radius_m(PI / 4.0) - 6_367_381.816).abs() < 1e-3);
        assert!((Planet::EARTH.prime_vertical_radius_m(PI / 4.0) - 6_388_838.290).abs() < 1e-3);
        for lat in [-1.5, -0.3, 0.7, 1.2] {
            let metres = Planet::EARTH.metres_per_radian(PI / 2.0 - lat);
            assert!((metres.y - Planet::EARTH.meridian_radius_m(lat)).abs() < 1e-8);
            let circle_m = Planet::EARTH.prime_vertical_radius_m(lat) * libm::cos(lat);
            assert!((metres.x - circle_m).abs() < 1e-8);
        }
    }

    #[test]
    fn at_the_pole_both_radii_of_curvature_agree() {
        let (m, n) = (
            Planet::EARTH.meridian_radius_m(PI / 2.0),
            Planet::EARTH.prime_vertical_radius_m(-PI / 2.0),
        );
        assert!((m - n).abs() < 1e-6 && (n - 6_399_593.626).abs() < 1e-3);
    }

    #[test]
    fn across_the_pole_is_straight_ahead() {
        let from = MapPoint::new(0.3, 1e-6);
        let to = MapPoint::new(0.3 + PI, 1e-6);
        let offset = Planet::EARTH.offset_m(from, to);
        assert!(
            (offset.y - 2e-6 * 6_399_593.6).abs() < 1e-3 && offset.x.abs() < 1e-6,
            "{offset}"
        );
    }

    #[test]
    fn an_antimeridian_between_two_points_does_not_part_them() {
        let from = MapPoint::new(PI - 1e-6, 1.0);
        let offset = Planet::EARTH.offset_m(from, MapPoint::new(-PI + 1e-6, 1.0));
        let metres = Planet::EARTH.metres_per_radian(1.0);
        assert!((offset.x - 2e-6 * metres.x).abs() < 1e-4, "{offset}");
    }

    #[test]
    fn one_metre_of_height_shows_its_horizon_even_on_the_largest_planet() {
        let planet = Planet::sphere(1e9);
        let truth = (2.0_f64 * 1e9).sqrt();
        assert!((planet.horizon_distance_m(1.0) / truth - 1.0).abs() < 1e-8);
        assert_eq!(planet.horizon_angle_rad(-5.0), 0.0);
        assert!((Planet::sphere(1.0).horizon_angle_rad(1e300) - PI / 2.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn near_points_are_apart_by_the_radii_of_curvature(
            lon in -PI..PI, colat in 0.01..3.13, size in 1e-12..1e-7, azimuth in -PI..PI,
        ) {
            let from = MapPoint::new(lon, colat);
            let step = DVec2::new(size * libm::cos(azimuth) / libm::sin(colat), size * libm::sin(azimuth));
            let to = MapPoint::new(lon + step.x, colat + step.y);
            // What the two stored points really are apart.
            let step = DVec2::new(to.lon_rad - from.lon_rad, to.colat_rad - from.colat_rad);
            let middle = f64::midpoint(from.colat_rad, to.colat_rad);
            let metres = Planet::EARTH.metres_per_radian(middle) * step;
            let offset = Planet::EARTH.offset_m(from, to);
            prop_assert!((offset - DVec2::new(metres.x, -metres.y)).length() < 2e-5 * metres.length());
        }

        #[test]
        fn on_a_sphere_the_offset_is_as_long_as_the_way(
            a in (-PI..PI, 0.0..PI), b in (-PI..PI, 0.0..PI),
        ) {
            let (from, to) = (MapPoint::new(a.0, a.1), MapPoint::new(b.0, b.1));
            let offset = Planet::sphere(1.0).offset_m(from, to);
            prop_assert!((offset.length() - from.angle_to(to)).abs() < 1e-7);
        }

        #[test]
        fn any_two_points_have_a_finite_offset(
            a in (-9.0..9.0, prop_oneof![Just(0.0), Just(PI), 0.0..PI]),
            b in (-9.0..9.0, prop_oneof![Just(0.0), Just(PI), 0.0..PI]),
        ) {
            let offset = Planet::EARTH.offset_m(MapPoint::new(a.0, a.1), MapPoint::new(b.0, b.1));
            prop_assert!(offset.is_finite());
        }

        #[test]
        fn a_hit_lies_on_the_sphere_at_any_scale(
            radius in radii_m(),
            height in (0.0..8.0_f64).prop_map(libm::exp10),
            place in (-PI..PI, 0.0..PI),
            target in (-PI..PI, 0.0..0.99_f64),
        ) {
            // Towards a point of the cap that the eye sees.
            let planet = Planet::sphere(radius);
            let eye = planet.position(MapPoint::new(place.0, place.1), height);
            let up = eye.normalize();
            let (east, north) = up.any_orthonormal_pair();
            let angle = planet.horizon_angle_rad(height) * target.1;
            let (sin_a, cos_a) = libm::sincos(angle);
            let (sin_t, cos_t) = libm::sincos(target.0);
            let ground = radius * (cos_a * up + sin_a * (cos_t * east + sin_t * north));
            let t = ray_sphere(eye, ground - eye, radius).expect("a point in sight is hit");
            let truth = eye.distance(ground);
            // The eye's own rounding, seen at the ray's slope on the ground, is all that may be lost.
            let slope = (eye - ground).normalize().dot(ground / radius).max(1e-12);
            let rounding_m = 1e-15 * (radius + height) / slope;
            prop_assert!((t - truth).abs() <= 1e-12 * truth + rounding_m, "{t} {truth}");
        }

        #[test]
        fn one_metre_above_the_ground_looking_down_is_one_metre(radius in radii_m()) {
            let eye = DVec3::new(0.0, 0.0, radius + 1.0);
            let t = ray_sphere(eye, -DVec3::Z * 3.0, radius).expect("straight down hits");
            prop_assert!((t - 1.0).abs() < 1e-6, "{t}");
            prop_assert_eq!(ray_sphere(eye, DVec3::Z, radius), None);
            prop_assert_eq!(ray_sphere(eye, DVec3::ZERO, radius), None);
        }

        #[test]
        fn from_inside_every_ray_leaves(
            radius in radii_m(), share in 0.0..0.999, lon in -PI..PI, colat in 0.0..PI,
        ) {
            let eye = DVec3::X * radius * share;
            let direction = MapPoint::new(lon, colat).to_unit();
            let t = ray_sphere(eye, direction, radius).expect("inside");
            prop_assert!(((eye + t * direction).length() / radius - 1.0).abs() < 1e-12);
        }
    }
}
