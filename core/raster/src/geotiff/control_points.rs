//! Ground control points: the affine map that fits them best, if it fits.

use glam::{DMat3, DVec3};

/// Where a file says that a pixel lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ControlPoint {
    /// Column and row, corners of pixels at integers.
    pub(super) pixel: (f64, f64),
    /// Plane coordinates.
    pub(super) plane: (f64, f64),
}

/// The affine map that fits points best, and how well it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// See [`crate::file::Georeference::plane_from_pixel`].
    pub(super) plane_from_pixel: [f64; 6],
    /// Distance in pixels between the worst point and where the map puts it.
    pub(super) worst_px: f64,
}

/// Fits by least squares; `None` for points that lie on one line or are not finite.
pub(super) fn fit(points: &[ControlPoint]) -> Option<Fit> {
    let n = points.len() as f64;
    let mean = points.iter().fold([0.0; 4], |[c, r, x, y], p| {
        [
            c + p.pixel.0 / n,
            r + p.pixel.1 / n,
            x + p.plane.0 / n,
            y + p.plane.1 / n,
        ]
    });
    let [mean_column, mean_row, mean_x, mean_y] = mean;
    // Around the means and in units of the spread, so that the normal equations stay well conditioned.
    let spread = points.iter().fold(0.0f64, |s, p| {
        s.max((p.pixel.0 - mean_column).abs())
            .max((p.pixel.1 - mean_row).abs())
    });
    if !(spread > 0.0 && spread.is_finite()) {
        return None;
    }
    let (mut normal, mut right_x, mut right_y) = (DMat3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for p in points {
        let row = DVec3::new(
            1.0,
            (p.pixel.0 - mean_column) / spread,
            (p.pixel.1 - mean_row) / spread,
        );
        normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right_x += row * (p.plane.0 - mean_x);
        right_y += row * (p.plane.1 - mean_y);
    }
    // Of points on one line the determinant is rounding.
    if normal.determinant().abs() < 1e-9 * n * n * n || !normal.is_finite() {
        return None;
    }
    let inverse = normal.inverse();
    let (x, y) = (inverse * right_x, inverse * right_y);
    let (xc, xr, yc, yr) = (x.y / spread, x.z / spread, y.y / spread, y.z / spread);
    let plane_from_pixel = [
        mean_x + x.x - xc * mean_column - xr * mean_row,
        xc,
        xr,
        mean_y + y.x - yc * mean_column - yr * mean_row,
        yc,
        yr,
    ];
    let area = xc * yr - xr * yc;
    let worst_px = points
        .iter()
        .map(|p| {
            let dx = p.plane.0
                - mean_x
                - x.x
                - xc * (p.pixel.0 - mean_column)
                - xr * (p.pixel.1 - mean_row);
            let dy = p.plane.1
                - mean_y
                - y.x
                - yc * (p.pixel.0 - mean_column)
                - yr * (p.pixel.1 - mean_row);
            libm::hypot((dx * yr - dy * xr) / area, (dy * xc - dx * yc) / area)
        })
        .fold(0.0f64, f64::max);
    let finite = worst_px.is_finite() && plane_from_pixel.iter().all(|v| v.is_finite());
    finite.then_some(Fit {
        plane_from_pixel,
        worst_px,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn along(affine: [f64; 6], pixel: (f64, f64)) -> ControlPoint {
        let [x0, xc, xr, y0, yc, yr] = affine;
        let plane = (
            x0 + xc * pixel.0 + xr * pixel.1,
            y0 + yc * pixel.0 + yr * pixel.1,
        );
        ControlPoint { pixel, plane }
    }

    #[test]
    fn the_worst_point_is_measured_in_pixels() {
        let affine = [440_000.0, 30.0, 0.0, 4_485_000.0, 0.0, -30.0];
        let corners = [(0.0, 0.0), (100.0, 0.0), (0.0, 100.0), (100.0, 100.0)];
        let mut points = corners.map(|pixel| along(affine, pixel));
        // One corner out by four pixels: least squares shares it among all four.
        points[3].plane.0 += 120.0;
        let fit = fit(&points).expect("four corners");
        // The pixels of the fitted map are a little wider.
        assert!((fit.worst_px - 1.0).abs() < 0.03, "{fit:?}");
    }

    #[test]
    fn points_on_a_line_fit_nothing() {
        let affine = [0.0, 1.0, 0.2, 0.0, 0.1, -1.0];
        for points in [
            vec![],
            vec![along(affine, (3.0, 4.0)); 5],
            (0..9)
                .map(|i| along(affine, (f64::from(i) * 1000.0, f64::from(i) * 333.0)))
                .collect(),
            vec![
                along(affine, (f64::NAN, 1.0)),
                along(affine, (0.0, 1.0)),
                along(affine, (9.0, 4.0)),
            ],
        ] {
            assert_eq!(fit(&points), None, "{points:?}");
        }
    }

    proptest! {
        #[test]
        fn points_of_an_affine_map_give_it_back(
            angle in 0.0..6.3f64, size in 1e-5..1e3f64, shear in -0.5..0.5f64,
            x0 in -1e6..1e6f64, y0 in -1e7..1e7f64, far in 100.0..1e5f64,
        ) {
            let (s, c) = (libm::sin(angle) * size, libm::cos(angle) * size);
            let affine = [x0, c, -s + shear * c, y0, s, c + shear * s];
            let points: Vec<_> = [(0.0, 0.0), (1.0, 0.1), (0.3, 1.0), (0.8, 0.9), (0.5, 0.4)]
                .map(|(u, v)| along(affine, (u * far, v * far)))
                .to_vec();
            let fit = fit(&points).expect("spread over the plane");
            prop_assert!(fit.worst_px < 1e-3, "{:?}", fit);
            for (found, expected) in fit.plane_from_pixel.iter().zip(affine) {
                prop_assert!((found - expected).abs() < 1e-9 * (x0.abs() + y0.abs() + size * far));
            }
        }
    }
}
