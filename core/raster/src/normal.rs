//! Unit surface normals in two numbers that are as exact on level ground as on a cliff.
//!
//! The numbers are the normal's stereographic coordinates: the place where the line from the nadir of
//! the unit sphere through the normal meets the plane of the horizon,
//!
//! - (e, n) / (1 + u), within the unit disc for ground that does not overhang; its distance from the
//!   origin is the tangent of half the slope.
//! - back: (2 x, 2 y, 1 − x² − y²) / (1 + x² + y²), without a root.
//!
//! Rounding a coordinate by δ turns the normal by at most 2 δ. With (e, n) alone u = √(1 − e² − n²)
//! would lose half of its digits where the ground is steep: up to 1.3° in half floats, here 0.03°.

use glam::DVec3;

/// Coordinates of a normal (east, north, up) of any length but zero, up ≥ 0.
pub fn coordinates(normal: DVec3) -> [f32; 2] {
    let unit = normal.normalize_or(DVec3::Z);
    [unit.x, unit.y].map(|v| (v / (1.0 + unit.z)) as f32)
}

/// Coordinates of the normal of a surface that rises by `zx` a metre towards east and by `zy` a metre
/// towards north. Both finite.
#[inline(always)]
pub fn coordinates_of_slope(zx: f32, zy: f32) -> [f32; 2] {
    // The steepest finite slopes must not overflow to NaN.
    let (zx, zy) = (zx.clamp(-1e18, 1e18), zy.clamp(-1e18, 1e18));
    let scale = 1.0 / (1.0 + (1.0 + zx * zx + zy * zy).sqrt());
    [0.0 - zx * scale, 0.0 - zy * scale]
}

/// The unit normal (east, north, up) of coordinates.
pub fn unit([x, y]: [f32; 2]) -> DVec3 {
    let (x, y) = (f64::from(x), f64::from(y));
    let square = x * x + y * y;
    DVec3::new(2.0 * x, 2.0 * y, 1.0 - square) / (1.0 + square)
}

/// Angle of the surface against the horizontal, radians, 0 to π/2.
pub fn slope_rad([x, y]: [f32; 2]) -> f32 {
    (2.0 * libm::atanf((x * x + y * y).sqrt())).min(core::f32::consts::FRAC_PI_2)
}

/// What the surface rises over a metre along its steepest line; infinite on a vertical one.
pub fn rise([x, y]: [f32; 2]) -> f64 {
    let (x, y) = (f64::from(x), f64::from(y));
    let square = (x * x + y * y).min(1.0);
    2.0 * square.sqrt() / (1.0 - square)
}

#[cfg(test)]
mod tests {
    use half::f16;
    use proptest::prelude::*;

    use super::*;

    /// A normal by its slope and azimuth, degrees.
    fn normal(slope_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(slope_deg.to_radians());
        let (sin_a, cos_a) = libm::sincos(azimuth_deg.to_radians());
        DVec3::new(sin * sin_a, sin * cos_a, cos)
    }

    fn angle_deg(a: DVec3, b: DVec3) -> f64 {
        libm::atan2(a.cross(b).length(), a.dot(b)).to_degrees()
    }

    proptest! {
        #[test]
        fn half_floats_keep_normals_of_any_slope_to_0_03_degrees(slope in 0.0..90.0_f64, azimuth in 0.0..360.0_f64) {
            let exact = normal(slope, azimuth);
            let stored = coordinates(exact).map(|v| f16::from_f32(v).to_f32());
            prop_assert!(angle_deg(unit(stored), exact) < 0.03);
        }

        #[test]
        fn coordinates_give_back_the_normal_the_slope_and_the_rise(slope in 0.0..89.0_f64, azimuth in 0.0..360.0_f64) {
            let exact = normal(slope, azimuth);
            let at = coordinates(exact);
            prop_assert!(angle_deg(unit(at), exact) < 1e-5);
            prop_assert!((f64::from(slope_rad(at)).to_degrees() - slope).abs() < 2e-5);
            let tangent = libm::tan(slope.to_radians());
            prop_assert!((rise(at) - tangent).abs() <= 1e-5 * (1.0 + tangent * tangent));
            let of_slope = coordinates_of_slope((-exact.x / exact.z) as f32, (-exact.y / exact.z) as f32);
            prop_assert!((of_slope[0] - at[0]).abs() < 1e-6 && (of_slope[1] - at[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn a_vertical_wall_is_kept() {
        assert_eq!(coordinates(DVec3::new(0.0, -3.0, 0.0)), [0.0, -1.0]);
        assert_eq!(unit([0.0, -1.0]), DVec3::new(0.0, -1.0, 0.0));
        assert_eq!(slope_rad([1.0, 0.0]).to_degrees(), 90.0);
        assert_eq!(rise([1.0, 0.0]), f64::INFINITY);
        assert_eq!(coordinates_of_slope(f32::MAX, 0.0), [-1.0, 0.0]);
    }
}
