//! Local frames: metres east and north of an origin.

use core::f64::consts::{PI, TAU};

use glam::DVec2;
use relievo_planet::map::wrap_longitude;
use relievo_planet::{MapPoint, Planet};

/// An azimuthal equidistant frame on the ellipsoid: x metres east, y metres north of its origin.
///
/// Azimuthal equidistant on the sphere of directions, scaled by the radii of curvature half way:
/// distances from the origin are off by about 10⁻⁹ at 1 km and 10⁻⁵ at 100 km on Earth. Smooth
/// everywhere but at the antipode, also across the antimeridian and at the poles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    planet: Planet,
    origin: MapPoint,
    sin: f64,
    cos: f64,
}

/// What all places of one colatitude share.
#[derive(Clone, Copy, Debug)]
pub struct FrameRow {
    sin: f64,
    north: f64,
    up: f64,
    cos_sum_squared: f64,
}

/// What all places of one longitude share.
#[derive(Clone, Copy, Debug)]
pub struct FrameColumn {
    sin: f64,
    versine: f64,
}

impl Frame {
    /// The frame at a place.
    pub fn new(planet: Planet, origin: MapPoint) -> Self {
        let origin = origin.normalised();
        let (sin, cos) = libm::sincos(origin.colat_rad);
        Self {
            planet,
            origin,
            sin,
            cos,
        }
    }

    /// The place at (0, 0).
    pub fn origin(&self) -> MapPoint {
        self.origin
    }

    /// What places of a colatitude share.
    pub fn row(&self, colat_rad: f64) -> FrameRow {
        let (sin, cos) = libm::sincos(colat_rad);
        let (north, up) = libm::sincos(self.origin.colat_rad - colat_rad);
        FrameRow {
            sin,
            north,
            up,
            cos_sum_squared: (self.cos + cos) * (self.cos + cos),
        }
    }

    /// What places of a longitude share.
    pub fn column(&self, lon_rad: f64) -> FrameColumn {
        let lon = wrap_longitude(lon_rad - self.origin.lon_rad);
        let (sin_half, cos_half) = libm::sincos(lon / 2.0);
        FrameColumn {
            sin: 2.0 * sin_half * cos_half,
            versine: 2.0 * sin_half * sin_half,
        }
    }

    /// Where a row and a column meet. Bit for bit what [`Self::from_map`] gives.
    #[inline]
    pub fn at(&self, row: &FrameRow, column: &FrameColumn) -> DVec2 {
        let east = row.sin * column.sin;
        let bend = row.sin * column.versine;
        let north = row.north + self.cos * bend;
        let up = row.up - self.sin * bend;
        let sine_squared = east * east + north * north;
        // Radii of curvature at the middle of the way.
        let e2 = self.planet.eccentricity_squared();
        let cos2 = row.cos_sum_squared / (2.0 * (1.0 + up)).max(1e-12);
        let q = 1.0 - e2 * cos2.min(1.0);
        let prime_m = self.planet.equatorial_radius_m / q.sqrt();
        let meridian_m = prime_m * (1.0 - e2) / q;
        let per_sine = if sine_squared < 4e-4 && up > 0.0 {
            // asin(s) / s; the next term is below 10⁻¹⁵.
            1.0 + sine_squared
                * (1.0 / 6.0
                    + sine_squared
                        * (3.0 / 40.0
                            + sine_squared * (15.0 / 336.0 + sine_squared * 105.0 / 3456.0)))
        } else {
            let sine = sine_squared.sqrt();
            if sine == 0.0 {
                return DVec2::new(0.0, PI * meridian_m);
            }
            libm::atan2(sine, up) / sine
        };
        DVec2::new(east * prime_m, north * meridian_m) * per_sine
    }

    /// A place in the frame, metres.
    pub fn from_map(&self, place: MapPoint) -> DVec2 {
        let place = place.normalised();
        self.at(&self.row(place.colat_rad), &self.column(place.lon_rad))
    }

    /// The place of a point of the frame; the inverse of [`Self::from_map`] to a nanometre within
    /// 1000 km.
    pub fn to_map(&self, point: DVec2) -> MapPoint {
        let lat = PI / 2.0 - self.origin.colat_rad;
        let radii = DVec2::new(
            self.planet.prime_vertical_radius_m(lat),
            self.planet.meridian_radius_m(lat),
        );
        let mut target = point;
        let mut place = self.origin;
        for _ in 0..8 {
            place = self.spherical(target / radii);
            let miss = point - self.from_map(place);
            if miss.length_squared() < 1e-20 {
                break;
            }
            target += miss;
        }
        place
    }

    /// Along the sphere of directions: east and north in radians of arc.
    fn spherical(&self, arc: DVec2) -> MapPoint {
        let angle = arc.length();
        let (sin, cos) = libm::sincos(angle);
        let scale = if angle > 1e-12 { sin / angle } else { 1.0 };
        let (east, north) = (arc.x * scale, arc.y * scale);
        // Across (towards the origin's meridian), along the axis.
        let out = cos * self.sin - north * self.cos;
        let z = cos * self.cos + north * self.sin;
        MapPoint::new(
            self.origin.lon_rad + libm::atan2(east, out),
            libm::atan2(libm::hypot(out, east), z),
        )
        .normalised()
    }
}

/// A rectangle of the map: all longitudes from `west_rad` eastward to `east_rad`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapRect {
    /// −π ≤ west < π.
    pub west_rad: f64,
    /// West of it by at most a whole turn: may exceed π.
    pub east_rad: f64,
    /// Northern border, colatitude.
    pub north_rad: f64,
    /// Southern border, colatitude.
    pub south_rad: f64,
}

impl MapRect {
    /// Whether both have a place in common, around the planet.
    pub fn overlaps(&self, other: &Self) -> bool {
        if self.north_rad > other.south_rad || other.north_rad > self.south_rad {
            return false;
        }
        let shift = (other.west_rad - self.west_rad).rem_euclid(TAU);
        shift <= self.east_rad - self.west_rad || TAU - shift <= other.east_rad - other.west_rad
    }

    /// Whether all of `other` lies inside, around the planet.
    pub fn contains(&self, other: &Self) -> bool {
        let shift = (other.west_rad - self.west_rad).rem_euclid(TAU);
        let width = self.east_rad - self.west_rad;
        self.north_rad <= other.north_rad
            && self.south_rad >= other.south_rad
            && (width >= TAU || shift + (other.east_rad - other.west_rad) <= width)
    }

    /// Grown by as much as `margin_m` metres are, at least.
    #[must_use]
    pub fn grow(&self, planet: &Planet, margin_m: f64) -> Self {
        let e2 = planet.eccentricity_squared();
        let margin = margin_m * (1.0 + 1e-3) / (planet.equatorial_radius_m * (1.0 - e2));
        let (north, south) = (self.north_rad - margin, self.south_rad + margin);
        let narrowest = libm::sin(north.max(0.0)).min(libm::sin(south.min(PI)));
        let reach = libm::sin(margin.min(PI / 2.0)) / narrowest.max(1e-300);
        let turn = if reach < 1.0 { libm::asin(reach) } else { PI };
        let width = self.east_rad - self.west_rad + 2.0 * turn;
        if north <= 0.0 || south >= PI || width >= TAU {
            return Self {
                west_rad: -PI,
                east_rad: PI,
                north_rad: north.max(0.0),
                south_rad: south.min(PI),
            };
        }
        let west = wrap_longitude(self.west_rad - turn);
        Self {
            west_rad: west,
            east_rad: west + width,
            north_rad: north,
            south_rad: south,
        }
    }

    /// The rectangle around places that lie close together; all longitudes if one is at a pole.
    pub fn of_places(places: impl Iterator<Item = MapPoint>) -> Option<Self> {
        let mut rect: Option<(f64, Self)> = None;
        for p in places {
            let p = p.normalised();
            match &mut rect {
                None => {
                    let at = Self {
                        west_rad: 0.0,
                        east_rad: 0.0,
                        north_rad: p.colat_rad,
                        south_rad: p.colat_rad,
                    };
                    rect = Some((p.lon_rad, at));
                }
                Some((first, r)) => {
                    let lon = wrap_longitude(p.lon_rad - *first);
                    r.west_rad = r.west_rad.min(lon);
                    r.east_rad = r.east_rad.max(lon);
                    r.north_rad = r.north_rad.min(p.colat_rad);
                    r.south_rad = r.south_rad.max(p.colat_rad);
                }
            }
        }
        let (first, r) = rect?;
        let width = r.east_rad - r.west_rad;
        // Next to a pole places all around are close together.
        if width > PI / 2.0 {
            return Some(Self {
                west_rad: -PI,
                east_rad: PI,
                ..r
            });
        }
        let west = wrap_longitude(first + r.west_rad);
        Some(Self {
            west_rad: west,
            east_rad: west + width,
            ..r
        })
    }

    /// The rectangle around the places of a frame within `margin_m` of `points`, which is complete
    /// when pieces between the points are no longer than the margin allows; `encloses` are poles
    /// (north, south) known to lie inside.
    pub(crate) fn around(
        frame: &Frame,
        points: impl Iterator<Item = MapPoint>,
        margin_m: f64,
        encloses: (bool, bool),
    ) -> Option<Self> {
        let origin = frame.origin;
        let (mut north, mut south) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in points {
            let p = p.normalised();
            north = north.min(p.colat_rad);
            south = south.max(p.colat_rad);
            let lon = wrap_longitude(p.lon_rad - origin.lon_rad);
            west = west.min(lon);
            east = east.max(lon);
        }
        if north > south {
            return None;
        }
        // Smallest radius of curvature: that of the meridian at the equator, or at the pole of an
        // odd planet.
        let e2 = frame.planet.eccentricity_squared();
        let smallest_m = frame.planet.equatorial_radius_m * (1.0 - e2);
        let margin = margin_m * (1.0 + 1e-3) / smallest_m;
        let (mut north, mut south) = (north - margin, south + margin);
        let mut all_around = encloses.0 || encloses.1;
        if north <= 0.0 || encloses.0 {
            north = 0.0;
            all_around = true;
        }
        if south >= PI || encloses.1 {
            south = PI;
            all_around = true;
        }
        let narrowest = libm::sin(north).min(libm::sin(south));
        // How far a circle of the margin's radius reaches in longitude.
        let reach = libm::sin(margin.min(PI / 2.0)) / narrowest.max(1e-300);
        let turn = if reach < 1.0 { libm::asin(reach) } else { PI };
        if all_around || east - west + 2.0 * turn >= TAU {
            return Some(Self {
                west_rad: -PI,
                east_rad: PI,
                north_rad: north,
                south_rad: south,
            });
        }
        let first = wrap_longitude(origin.lon_rad + west - turn);
        Some(Self {
            west_rad: first,
            east_rad: first + (east - west + 2.0 * turn),
            north_rad: north,
            south_rad: south,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_frame_and_the_map_round_trip_also_at_poles_and_the_antimeridian(
            lon in -PI..PI, colat in prop_oneof![Just(0.0), Just(PI), 0.0..PI],
            x in -3e5..3e5, y in -3e5..3e5,
        ) {
            let frame = Frame::new(Planet::EARTH, MapPoint::new(lon, colat));
            let point = DVec2::new(x, y);
            let back = frame.from_map(frame.to_map(point));
            prop_assert!((back - point).length() < 1e-6, "{point} {back}");
        }

        #[test]
        fn near_its_origin_a_frame_is_the_planets_offset(
            lon in -PI..PI, colat in 0.001..3.13, east in -1e-4..1e-4, south in -1e-4..1e-4,
        ) {
            let from = MapPoint::new(lon, colat);
            let to = MapPoint::new(lon + east, colat + south).normalised();
            let a = Frame::new(Planet::EARTH, from).from_map(to);
            let b = Planet::EARTH.offset_m(from, to);
            prop_assert!((a - b).length() <= 1e-6 * b.length() + 1e-6, "{a} {b}");
        }

        #[test]
        fn a_rectangle_holds_what_lies_within_its_margin(
            lon in -PI..PI, colat in prop_oneof![0.0..0.01, 0.0..PI, 3.13..PI],
            angle in -PI..PI, part in 0.0..1.0, margin in 1.0..2e5,
        ) {
            let frame = Frame::new(Planet::EARTH, MapPoint::new(lon, colat));
            let rect = MapRect::around(&frame, [frame.origin()].into_iter(), margin, (false, false)).unwrap();
            let p = frame.to_map(DVec2::new(libm::cos(angle), libm::sin(angle)) * margin * part);
            let there = MapRect { west_rad: p.lon_rad, east_rad: p.lon_rad, north_rad: p.colat_rad, south_rad: p.colat_rad };
            prop_assert!(rect.overlaps(&there) && there.overlaps(&rect), "{rect:?} {there:?}");
        }
    }
}
