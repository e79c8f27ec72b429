//! Areas of the map, and the levels on which grounds are read.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use relievo_planet::map::wrap_longitude;
use relievo_planet::{LevelKey, MapPoint};

use crate::ground::AnalysisError;

/// An area of the map between two meridians and two circles of latitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapBox {
    /// West edge in radians, −π ≤ west < π.
    pub west_rad: f64,
    /// East edge in radians, west < east ≤ west + 2π: beyond π where the antimeridian is crossed.
    pub east_rad: f64,
    /// Colatitude of the north edge in radians, 0 or more.
    pub north_colat_rad: f64,
    /// Colatitude of the south edge in radians, beyond the north one, at most π.
    pub south_colat_rad: f64,
}

impl MapBox {
    /// From edges west, south, east, north in degrees; west at or beyond east crosses the
    /// antimeridian.
    ///
    /// # Errors
    /// [`AnalysisError::Refused`] unless edges are finite, south < north within ±90°, and at most
    /// once around.
    pub fn from_degrees([west, south, east, north]: [f64; 4]) -> Result<Self, AnalysisError> {
        let refused = |expected: &str| {
            AnalysisError::Refused(format!(
                "expected bounds W,S,E,N {expected}, found {west},{south},{east},{north}"
            ))
        };
        if ![west, south, east, north].iter().all(|b| b.is_finite()) {
            return Err(refused("in finite degrees"));
        }
        if !(-90.0..=90.0).contains(&south) || !(-90.0..=90.0).contains(&north) || south >= north {
            return Err(refused("with N beyond S, from −90° to 90°"));
        }
        let width = if east > west {
            east - west
        } else {
            east - west + 360.0
        };
        if !(width > 0.0 && width <= 360.0) {
            return Err(refused("at most 360° wide"));
        }
        let west_rad = wrap_longitude(west.to_radians());
        Ok(Self {
            west_rad,
            east_rad: west_rad + width.to_radians(),
            north_colat_rad: (90.0 - north).to_radians(),
            south_colat_rad: (90.0 - south).to_radians(),
        })
    }

    /// The box of a circle of `radius_rad` (an angle at the planet's centre) around a point: once
    /// around where it reaches a pole.
    pub fn around(centre: MapPoint, radius_rad: f64) -> Self {
        let centre = centre.normalised();
        let (north, south) = (centre.colat_rad - radius_rad, centre.colat_rad + radius_rad);
        let half_width = if north <= 0.0 || south >= PI || radius_rad >= FRAC_PI_2 {
            PI
        } else {
            libm::asin((libm::sin(radius_rad) / libm::sin(centre.colat_rad)).min(1.0))
        };
        let west_rad = wrap_longitude(centre.lon_rad - half_width);
        Self {
            west_rad,
            east_rad: west_rad + (2.0 * half_width).clamp(f64::EPSILON, TAU),
            north_colat_rad: north.max(0.0),
            south_colat_rad: south.min(PI).max(north.max(0.0) + f64::EPSILON),
        }
    }

    /// Width in radians of longitude, at most 2π.
    pub fn width_rad(&self) -> f64 {
        self.east_rad - self.west_rad
    }

    /// What two areas share: nothing, one part, or two where both go far around.
    pub fn shared(&self, other: &Self) -> Vec<Self> {
        let north_colat_rad = self.north_colat_rad.max(other.north_colat_rad);
        let south_colat_rad = self.south_colat_rad.min(other.south_colat_rad);
        if north_colat_rad >= south_colat_rad {
            return Vec::new();
        }
        let apart = (other.west_rad - self.west_rad).rem_euclid(TAU);
        let parts = [apart, apart - TAU].into_iter().filter_map(|first| {
            let (west, east) = (
                first.max(0.0),
                (first + other.width_rad()).min(self.width_rad()),
            );
            let west_rad = wrap_longitude(self.west_rad + west);
            (west < east).then_some(Self {
                west_rad,
                east_rad: west_rad + (east - west),
                north_colat_rad,
                south_colat_rad,
            })
        });
        parts.collect()
    }

    /// The smallest area that holds two.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        let from = |a: &Self, b: &Self| {
            let apart = (b.west_rad - a.west_rad).rem_euclid(TAU);
            (a.width_rad().max(apart + b.width_rad()), a.west_rad)
        };
        let (here, there) = (from(self, other), from(other, self));
        let (width_rad, west_rad) = if here.0 <= there.0 { here } else { there };
        Self {
            west_rad,
            east_rad: west_rad + width_rad.min(TAU),
            north_colat_rad: self.north_colat_rad.min(other.north_colat_rad),
            south_colat_rad: self.south_colat_rad.max(other.south_colat_rad),
        }
    }

    /// Largest sine of a colatitude inside: where circles of latitude are longest.
    pub fn widest_sine(&self) -> f64 {
        if (self.north_colat_rad..=self.south_colat_rad).contains(&FRAC_PI_2) {
            return 1.0;
        }
        libm::sin(self.north_colat_rad).max(libm::sin(self.south_colat_rad))
    }

    /// The level on whose lattice a ground is read inside the area: rows `n` as fine as the data,
    /// columns nowhere longer on the ground than rows (up to a factor of 2 shorter at the widest
    /// latitude, more towards a pole).
    pub fn level(&self, n: u8) -> LevelKey {
        level_at(n, self.widest_sine())
    }
}

/// The level with rows `n` whose columns, at a colatitude of sine `sin_colat`, are no longer on the
/// ground than its rows.
pub(crate) fn level_at(n: u8, sin_colat: f64) -> LevelKey {
    let finest = f64::from(n) + 1.0;
    let narrower = libm::log2(sin_colat.max(1e-12)) * (1.0 - 1e-12);
    let m = libm::ceil(finest + narrower - 1e-9).clamp(0.0, finest);
    LevelKey::new((m as u8).min(relievo_planet::tile::MAX_EXPONENT), n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_across_the_antimeridian_run_east() {
        let area = MapBox::from_degrees([179.0, -1.0, -179.0, 1.0]).expect("sense");
        assert!((area.width_rad().to_degrees() - 2.0).abs() < 1e-9);
        assert!(area.east_rad > PI);
        let whole = MapBox::from_degrees([-180.0, -90.0, 180.0, 90.0]).expect("sense");
        assert!((whole.width_rad() - TAU).abs() < 1e-12);
    }

    #[test]
    fn bounds_without_sense_are_refused_in_one_line() {
        for bounds in [
            [0.0, 1.0, 1.0, 0.0],
            [0.0, -91.0, 1.0, 0.0],
            [f64::NAN, 0.0, 1.0, 1.0],
            [0.0, 0.0, 500.0, 1.0],
        ] {
            let line = MapBox::from_degrees(bounds)
                .expect_err("no sense")
                .to_string();
            assert!(
                line.contains("expected bounds") && !line.contains('\n'),
                "{line}"
            );
        }
    }

    fn degrees(bounds: [f64; 4]) -> MapBox {
        MapBox::from_degrees(bounds).expect("sense")
    }

    #[test]
    fn what_two_areas_share_lies_in_both_across_the_antimeridian_too() {
        let seam = degrees([170.0, -10.0, -170.0, 10.0]);
        let close = |a: f64, deg: f64| (a - deg.to_radians()).abs() < 1e-12;
        let parts = seam.shared(&degrees([-175.0, 0.0, 100.0, 20.0]));
        assert_eq!(parts.len(), 1);
        assert!(close(parts[0].west_rad, -175.0) && close(parts[0].east_rad, -170.0));
        assert!(close(parts[0].north_colat_rad, 80.0) && close(parts[0].south_colat_rad, 90.0));
        assert_eq!(seam.shared(&degrees([-175.0, 0.0, 175.0, 20.0])).len(), 2);
        assert_eq!(seam.shared(&seam), vec![seam]);
        assert!(seam.shared(&degrees([-169.0, 0.0, 169.0, 20.0])).is_empty());
        assert!(seam.shared(&degrees([175.0, 10.0, 176.0, 20.0])).is_empty());
        let whole = degrees([-180.0, -90.0, 180.0, 90.0]);
        let area = |b: &MapBox| b.width_rad() * (b.south_colat_rad - b.north_colat_rad);
        let all: f64 = whole.shared(&seam).iter().map(area).sum();
        assert!((all - area(&seam)).abs() < 1e-12);
    }

    #[test]
    fn a_joined_area_goes_the_short_way_around() {
        let joined = degrees([179.0, 0.0, 179.5, 1.0]).joined(&degrees([-179.0, 2.0, -178.0, 3.0]));
        assert!((joined.width_rad().to_degrees() - 3.0).abs() < 1e-9);
        let half = |west: f64, east: f64| degrees([west, 0.0, east, 1.0]);
        let around = half(-90.0, 100.0).joined(&half(90.0, -80.0));
        assert!((around.width_rad() - TAU).abs() < 1e-9);
        let inside = half(0.0, 50.0).joined(&half(10.0, 20.0));
        assert!((inside.width_rad().to_degrees() - 50.0).abs() < 1e-9);
    }

    #[test]
    fn columns_are_never_longer_on_the_ground_than_rows() {
        for n in [3, 10, 20] {
            for colat_deg in [0.01_f64, 1.0, 30.0, 45.0, 89.0, 90.0] {
                let sin_colat = libm::sin(colat_deg.to_radians());
                let step = level_at(n, sin_colat).step_rad();
                let ratio = step.x * sin_colat / step.y;
                assert!(ratio <= 1.0 + 1e-6, "{n} {colat_deg}: {ratio}");
                assert!(
                    ratio > 0.49 || level_at(n, sin_colat).m == 0,
                    "{n} {colat_deg}: {ratio}"
                );
            }
        }
    }

    #[test]
    fn a_circle_that_reaches_a_pole_goes_once_around() {
        let area = MapBox::around(MapPoint::from_degrees(10.0, 89.9), 0.01);
        assert!((area.width_rad() - TAU).abs() < 1e-9 && area.north_colat_rad == 0.0);
        let small = MapBox::around(MapPoint::from_degrees(179.99, 0.0), 0.001);
        assert!((small.width_rad() - 0.002).abs() < 1e-9 && small.east_rad > PI);
    }
}
