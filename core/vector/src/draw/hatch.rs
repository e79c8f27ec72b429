//! Lines over the inside of polygons.

use glam::{DVec2, I64Vec2};
use relievo_planet::SampleRect;

use core::f64::consts::FRAC_PI_2;

use super::canvas::Canvas;
use super::plane::Plane;
use crate::style::Hatch;

/// Hatches with a period below this many samples are drawn as an even, lighter area.
const FINEST_PERIOD: f64 = 2.0;

/// Thins the mask out to the lines of a hatch. Returns how much of the colour shows.
///
/// Lines are straight in longitude and latitude, at their stated angle and distance at latitude
/// `lat_rad`, and the same in all cells.
pub(super) fn pattern(
    hatch: &Hatch,
    plane: &Plane,
    cell: SampleRect,
    lat_rad: f64,
    canvas: &mut Canvas,
) -> f64 {
    let sample_m = plane.sample_m;
    let spacing_m = hatch.spacing.metres(sample_m);
    let width_m = hatch.width.metres(sample_m).min(spacing_m);
    if spacing_m <= 0.0 || width_m <= 0.0 {
        return 0.0;
    }
    let sets = if hatch.crossed { 2.0 } else { 1.0 };
    if spacing_m < FINEST_PERIOD * sample_m {
        return (sets * width_m / spacing_m).min(1.0);
    }
    let drawn_m = width_m.max(sample_m);
    let (sin, cos) = libm::sincos(hatch.angle_deg.to_radians());
    let metres = if plane.is_map() {
        plane.planet.metres_per_radian(FRAC_PI_2 - lat_rad)
    } else {
        DVec2::splat(sample_m / plane.lattice().step.y.abs())
    };
    // Distance from a line, across it.
    let line = |across: DVec2, place: DVec2| {
        let t = across.dot(place) / spacing_m;
        (t - libm::round(t)).abs() * spacing_m
    };
    let cover = |distance_m: f64| ((0.5 * drawn_m - distance_m) / sample_m + 0.5).clamp(0.0, 1.0);
    canvas.thin(|column, row| {
        let sample = cell.min + I64Vec2::new(column as i64, row as i64);
        let place = if plane.is_map() {
            let p = plane.lattice().map_point(sample);
            DVec2::new(p.lon_rad, p.lat_rad())
        } else {
            plane.lattice().centre(sample)
        } * metres;
        let mut covered = cover(line(DVec2::new(cos, -sin), place));
        if hatch.crossed {
            covered = covered.max(cover(line(DVec2::new(sin, cos), place)));
        }
        covered
    });
    width_m / drawn_m
}
