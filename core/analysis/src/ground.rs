//! What analyses ask of a ground, and how they are watched and stopped.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use relievo_planet::map::wrap_longitude;
use relievo_planet::{Grid, LevelKey, MapPoint, Planet};

/// Heights of one planet, evaluated wherever they are asked for.
pub trait Ground: Sync {
    /// The planet's figure.
    fn planet(&self) -> Planet;

    /// Finest level n of the tile grid that some data inside `area` are worth: the spacing of its
    /// samples is the data's own.
    fn finest_level(&self, area: &MapBox) -> u8;

    /// Heights in metres at the centres of a grid's samples, row by row; NaN where there are none.
    /// On the lattice of a level, columns beyond its ends wrap and rows reflect over the poles.
    ///
    /// # Errors
    /// [`AnalysisError::Ground`] when they cannot be made, [`AnalysisError::Cancelled`] when
    /// somebody asked to stop meanwhile.
    fn heights(&self, grid: &Grid) -> Result<Vec<f32>, AnalysisError>;
}

/// Somebody who waits for an analysis.
pub trait Watch: Sync {
    /// Whether the work should stop; asked many times a second.
    fn is_cancelled(&self) -> bool;

    /// Told the part that is done, 0 to 1, from whichever thread did it.
    fn progress(&self, share: f64);
}

/// Nobody waits, nobody stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn is_cancelled(&self) -> bool {
        false
    }

    fn progress(&self, _share: f64) {}
}

/// An error if the watch asks to stop.
pub(crate) fn go_on(watch: &dyn Watch) -> Result<(), AnalysisError> {
    if watch.is_cancelled() {
        return Err(AnalysisError::Cancelled);
    }
    Ok(())
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The request makes no sense or exceeds a limit: what was expected, what was found.
    #[error("{0}")]
    Refused(String),
    /// The ground could not be evaluated.
    #[error("{0}")]
    Ground(#[source] Box<dyn core::error::Error + Send + Sync>),
}

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
