//! Which levels a clipmap has in a view, and how wide each window is in longitude.
//!
//! A level n is bound to a ring of the mesh by its rows: ring i reads the level whose N rows span
//! 2^(1 − i) π, of which the ring takes κ. What is left to choose is m, the exponent of columns.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use super::rings::KAPPA;
use crate::TILE_SAMPLES;

/// A wider reach by this factor must fit before m rises: hysteresis.
const RISE_MARGIN: f64 = 1.15;

/// Texels of a window kept free beyond its ring for filtering.
const SPARE_TEXELS: f64 = 2.0;

/// Level n0 whose rows fill a window of `size` samples exactly: log2(size / 256).
pub fn coarsest_level(size: u32) -> u8 {
    (size.max(256) / 256).ilog2() as u8
}

/// Size of a sample of level n in radians of colatitude.
pub fn texel_rad(n: u8) -> f64 {
    PI / (TILE_SAMPLES as f64 * libm::exp2(f64::from(n)))
}

/// Central angle from the focus up to which level n of a window of `size` samples is needed: the
/// outer radius of its ring; for the coarsest level that of the widest ring.
pub fn reach_rad(n: u8, size: u32) -> f64 {
    if n <= coarsest_level(size) {
        return KAPPA * PI;
    }
    KAPPA * 0.5 * f64::from(size) * texel_rad(n)
}

/// Largest difference of longitude from the focus inside a circle of radius `reach_rad` around it,
/// radians: asin(sin θ̃ / sin θv), or π when the circle holds a pole.
///
/// Source: tangent meridians of a small circle; cf. \[CH06\] 4.1, which takes the whole circle for
/// any ring that reaches a pole likewise.
pub fn longitude_half_width(colat_rad: f64, reach_rad: f64) -> f64 {
    let pole = colat_rad.min(PI - colat_rad);
    if reach_rad >= pole || reach_rad >= FRAC_PI_2 {
        return PI;
    }
    let ratio = libm::sin(reach_rad) / libm::sin(colat_rad);
    if ratio >= 1.0 { PI } else { libm::asin(ratio) }
}

/// Exponent m for a level n: the largest, not above n + 1, for which the window's half width holds
/// the ring's longitudes with texels to spare; else the whole circle, m = log2(size / 256).
///
/// - `colat_rad`: colatitude of the focus, 0 to π.
/// - `reach_rad`: outer radius of the ring, radians, see [`reach_rad`].
/// - `size`: N of the window.
pub fn columns_exponent(n: u8, colat_rad: f64, reach_rad: f64, size: u32) -> u8 {
    let whole = coarsest_level(size);
    let half_width = longitude_half_width(colat_rad, reach_rad);
    if half_width >= PI {
        return whole;
    }
    // A window's centre is up to size / 64 samples beside the focus.
    let texels = f64::from(size) * (0.5 - 1.0 / 64.0) - SPARE_TEXELS;
    let columns = texels * TAU / half_width;
    let m = libm::floor(libm::log2(columns / TILE_SAMPLES as f64));
    // A level as wide as the window is the whole circle, which always fits.
    m.clamp(f64::from(whole), f64::from(n + 1).max(f64::from(whole))) as u8
}

/// The exponent to use next for a level that now uses `in_use`, and whether it is final.
///
/// With no exponent in use the ideal one is taken. Otherwise it is kept as long as the ring fits and
/// the next finer one would not fit amply, and changes by one.
pub fn next_columns_exponent(
    in_use: Option<u8>,
    n: u8,
    colat_rad: f64,
    reach_rad: f64,
    size: u32,
) -> (u8, bool) {
    let largest = columns_exponent(n, colat_rad, reach_rad, size);
    let ample = columns_exponent(n, colat_rad, (reach_rad * RISE_MARGIN).min(PI), size);
    match in_use {
        None => (largest, true),
        Some(m) if m > largest => (m - 1, m - 1 == largest),
        Some(m) if m < ample => (m + 1, m + 1 == ample),
        Some(m) => (m, true),
    }
}

/// Finest level: the largest n whose texel, seen from `distance_m`, still covers `texel_px` pixels.
///
/// - `distance_m`: the shortest distance at which ground can be seen, usually the height above the
///   *terrain*; positive.
/// - `pixel_rad`: angle of a pixel.
/// - Clamped to `coarsest..=cap` (and to `coarsest` when `cap` lies below it).
///
/// Source: \[CH06\] eq. 7; eq. 8 as printed lets triangles be as small as a ring's radius of one pixel.
pub fn finest_level(
    distance_m: f64,
    pixel_rad: f64,
    texel_px: f64,
    radius_m: f64,
    coarsest: u8,
    cap: u8,
) -> u8 {
    let smallest_rad = distance_m * pixel_rad * texel_px / radius_m;
    let n = libm::floor(libm::log2(texel_rad(0) / smallest_rad));
    n.clamp(f64::from(coarsest), f64::from(cap.max(coarsest))) as u8
}

/// Central angle from the nadir beyond which no terrain shows above the horizon, radians.
///
/// - `eye_m`, `highest_m`: distances of the eye and of the highest terrain from the planet's centre.
/// - `occluder_m`: radius of the sphere of the lowest terrain, which hides what is behind it.
/// - π when the eye is inside the occluder.
///
/// Source: \[CH06\] eq. 5 and 6 for the eye, and once more for the terrain; may exceed π/2.
pub fn horizon_rad(eye_m: f64, highest_m: f64, occluder_m: f64) -> f64 {
    if eye_m <= occluder_m {
        return PI;
    }
    libm::acos(occluder_m / eye_m) + libm::acos((occluder_m / highest_m).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_aspect_of_a_sample_stays_near_one_away_from_the_poles() {
        for size in [256, 1024, 4096] {
            for n in coarsest_level(size) + 4..20 {
                for degrees in 15..=165 {
                    let colat = f64::from(degrees).to_radians();
                    let m = columns_exponent(n, colat, reach_rad(n, size), size);
                    let width = TAU / (256.0 * libm::exp2(f64::from(m))) * libm::sin(colat);
                    let aspect = width / texel_rad(n);
                    assert!(
                        (0.66..=1.5).contains(&aspect),
                        "n {n} colat {degrees}: {aspect}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_window_always_holds_its_ring() {
        for size in [256, 1024] {
            for n in coarsest_level(size)..20 {
                for step in 0..=2000 {
                    let colat = PI * f64::from(step) / 2000.0;
                    let reach = reach_rad(n, size);
                    let m = columns_exponent(n, colat, reach, size);
                    let half = f64::from(size) / 2.0 * TAU / (256.0 * libm::exp2(f64::from(m)));
                    assert!(
                        half >= PI || half >= longitude_half_width(colat, reach),
                        "{n} {step}"
                    );
                }
            }
        }
    }

    #[test]
    fn trembling_about_a_threshold_changes_the_exponent_once() {
        let (n, size) = (9, 256);
        let reach = reach_rad(n, size);
        let mut m = None;
        let mut changes = 0;
        for step in 0..20_000 {
            // A slow walk to the pole that goes back and forth all the time.
            let tremble = 1.0 + 0.03 * libm::sin(f64::from(step));
            let colat = 1.2 * libm::exp(-5e-4 * f64::from(step)) * tremble;
            let (next, _) = next_columns_exponent(m, n, colat, reach, size);
            changes += u32::from(m.is_some_and(|m| m != next));
            m = Some(next);
        }
        assert_eq!(m, Some(0), "the whole circle at the pole");
        assert!(changes <= 10, "from 10 to 0, one at a time: {changes}");
    }

    #[test]
    fn the_finest_texel_covers_a_pixel_and_the_next_would_not() {
        for height in [1.0, 37.0, 1e4, 1e6] {
            let n = finest_level(height, 1e-3, 1.0, 6.371e6, 0, 30);
            assert!(texel_rad(n) * 6.371e6 >= height * 1e-3);
            assert!(texel_rad(n + 1) * 6.371e6 < height * 1e-3);
        }
    }

    #[test]
    fn the_horizon_passes_ninety_degrees_when_mountains_demand_it() {
        assert!(horizon_rad(1e9, 1.2e6, 1e6) > FRAC_PI_2 + 0.5);
        assert_eq!(horizon_rad(1.0, 3.0, 2.0), PI);
    }
}
