//! Structural similarity.

/// Half the side of the window that is compared at once.
const REACH: i64 = 5;
/// Standard deviation of the window's weights in pixels.
const SIGMA_PX: f64 = 1.5;

/// Mean structural similarity of two planes of values from 0 to `range`: 1 for equal planes, lower the
/// less the structure of one is found in the other. Windows are cut at the picture's sides.
///
/// Source: \[WBSS04\] eq. 13 to 17: Gaussian windows of 11 × 11 pixels, K1 0.01, K2 0.03.
pub fn mean_ssim(size_px: [usize; 2], first: &[f64], second: &[f64], range: f64) -> f64 {
    let product: Vec<f64> = first.iter().zip(second).map(|(a, b)| a * b).collect();
    let square = |plane: &[f64]| plane.iter().map(|v| v * v).collect::<Vec<_>>();
    let mean = |plane: &[f64]| blurred(size_px, plane);
    let (mean_a, mean_b) = (mean(first), mean(second));
    let (mean_aa, mean_bb) = (mean(&square(first)), mean(&square(second)));
    let mean_ab = mean(&product);
    let (c1, c2) = ((0.01 * range).powi(2), (0.03 * range).powi(2));
    let of = |i: usize| {
        let (a, b) = (mean_a[i], mean_b[i]);
        let (aa, bb, ab) = (mean_aa[i] - a * a, mean_bb[i] - b * b, mean_ab[i] - a * b);
        (2.0 * a * b + c1) * (2.0 * ab + c2) / ((a * a + b * b + c1) * (aa + bb + c2))
    };
    let count = mean_ab.len();
    (0..count).map(of).sum::<f64>() / count.max(1) as f64
}

/// Gaussian means along rows, then along columns.
fn blurred([width, height]: [usize; 2], plane: &[f64]) -> Vec<f64> {
    let along = |plane: &[f64], stride: usize, count: usize, i: usize| {
        let at = (i / stride % count) as i64;
        let (mut sum, mut weights) = (0.0, 0.0);
        for offset in -REACH..=REACH {
            if (0..count as i64).contains(&(at + offset)) {
                let weight = libm::exp(-0.5 * (offset as f64 / SIGMA_PX).powi(2));
                sum += weight * plane[(i as i64 + offset * stride as i64) as usize];
                weights += weight;
            }
        }
        sum / weights
    };
    let count = (width * height).min(plane.len());
    let rows: Vec<f64> = (0..count).map(|i| along(plane, 1, width, i)).collect();
    (0..count).map(|i| along(&rows, width, height, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_shift_keeps_structure_and_another_pattern_does_not() {
        let size = [24, 20];
        let wave = |phase: f64| -> Vec<f64> {
            (0..480)
                .map(|i| 50.0 + 20.0 * libm::sin(f64::from(i) * 0.7 + phase))
                .collect()
        };
        let (a, opposite) = (wave(0.0), wave(core::f64::consts::PI));
        let brighter: Vec<f64> = a.iter().map(|v| v + 5.0).collect();
        assert!((mean_ssim(size, &a, &a, 100.0) - 1.0).abs() < 1e-12);
        assert!(mean_ssim(size, &a, &brighter, 100.0) > 0.95);
        assert!(mean_ssim(size, &a, &opposite, 100.0) < 0.0);
    }

    #[test]
    fn two_flat_planes_have_the_closed_form() {
        let (a, b) = (vec![40.0; 99], vec![60.0; 99]);
        let c1 = 1.0;
        let expected = (2.0 * 40.0 * 60.0 + c1) / (40.0 * 40.0 + 60.0 * 60.0 + c1);
        assert!((mean_ssim([11, 9], &a, &b, 100.0) - expected).abs() < 1e-9);
    }
}
