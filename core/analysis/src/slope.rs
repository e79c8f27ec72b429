//! Slope and aspect on grids.

use core::f64::consts::TAU;

use glam::DVec2;

/// Steepness and direction of the ground at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Angle against the horizontal in radians, 0 to π/2; NaN beside a missing height.
    pub slope_rad: f64,
    /// Direction in which the ground falls most, radians clockwise from north, 0 to 2π; NaN where
    /// it is level or a height is missing.
    pub aspect_rad: f64,
}

/// Slopes from heights in metres, row by row, rows southward and columns eastward.
///
/// - `width`: columns of `heights`; the result leaves out a border of one sample all around, so it
///   has `width − 2` columns and two rows fewer.
/// - `spacing_m`: metres between columns (x) and between rows (y) at a row of `heights`; both
///   positive.
///
/// Horn's weights (1, 2, 1 across both neighbours): exact on planes, second order elsewhere. Source:
/// Horn, Hill shading and the reflectance map, Proc. IEEE 69 (1981).
///
/// # Panics
/// If `width` is 0 or does not divide the number of heights.
pub fn slopes(heights: &[f32], width: usize, spacing_m: impl Fn(usize) -> DVec2) -> Vec<Slope> {
    assert!(
        width > 0 && heights.len().is_multiple_of(width),
        "whole rows"
    );
    let rows = heights.len() / width;
    let mut result = Vec::with_capacity(width.saturating_sub(2) * rows.saturating_sub(2));
    for row in 1..rows.saturating_sub(1) {
        let spacing_m = spacing_m(row);
        let h = |dx: usize, dy: usize, column: usize| {
            f64::from(heights[(row + dy - 1) * width + column + dx - 1])
        };
        for column in 1..width.saturating_sub(1) {
            let side = |dx| h(dx, 0, column) + 2.0 * h(dx, 1, column) + h(dx, 2, column);
            let end = |dy| h(0, dy, column) + 2.0 * h(1, dy, column) + h(2, dy, column);
            let east = (side(2) - side(0)) / (8.0 * spacing_m.x);
            let north = (end(0) - end(2)) / (8.0 * spacing_m.y);
            result.push(slope_of(DVec2::new(east, north)));
        }
    }
    result
}

/// Slope and aspect of a gradient: rise over run eastward (x) and northward (y).
pub fn slope_of(gradient: DVec2) -> Slope {
    let aspect_rad = if gradient == DVec2::ZERO {
        f64::NAN
    } else {
        libm::atan2(-gradient.x, -gradient.y).rem_euclid(TAU)
    };
    Slope {
        slope_rad: libm::atan(libm::hypot(gradient.x, gradient.y)),
        aspect_rad,
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_plane_has_its_own_slope_everywhere(
            east in -2.0..2.0, north in -2.0..2.0, dx in 0.5..40.0, dy in 0.5..40.0,
        ) {
            let heights: Vec<f32> = (0..30)
                .map(|i| (east * dx * f64::from(i % 6) - north * dy * f64::from(i / 6)) as f32)
                .collect();
            let found = slopes(&heights, 6, |_| DVec2::new(dx, dy));
            prop_assert_eq!(found.len(), 4 * 3);
            for slope in found {
                let expected = libm::atan(libm::hypot(east, north));
                prop_assert!((slope.slope_rad - expected).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn aspect_is_where_water_runs_to() {
        for (gradient, aspect) in [
            (DVec2::new(0.0, 1.0), PI),
            (DVec2::new(1.0, 0.0), 1.5 * PI),
            (DVec2::new(0.0, -1.0), 0.0),
            (DVec2::new(-1.0, 0.0), FRAC_PI_2),
        ] {
            assert!((slope_of(gradient).aspect_rad - aspect).abs() < 1e-12);
        }
        assert!(slope_of(DVec2::ZERO).aspect_rad.is_nan());
        assert_eq!(slope_of(DVec2::ZERO).slope_rad, 0.0);
    }

    #[test]
    fn a_missing_height_gives_no_slope_around_it() {
        let mut heights = vec![1.0_f32; 25];
        heights[0] = f32::NAN;
        let found = slopes(&heights, 5, |_| DVec2::ONE);
        assert!(found[0].slope_rad.is_nan() && found[8].slope_rad == 0.0);
    }
}
