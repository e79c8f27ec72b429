//! The colour difference CIEDE2000.

use core::f64::consts::{PI, TAU};

use super::Lab;

/// Difference of two colours as an eye sees it, with all weights 1: about 1 is just noticeable side by
/// side.
///
/// Source: \[SWD05\] eq. 2 to 22.
pub fn ciede2000(first: Lab, second: Lab) -> f64 {
    let seventh = |c: f64| {
        let c7 = c.powi(7);
        (c7 / (c7 + 25.0_f64.powi(7))).sqrt()
    };
    let mean_chroma = 0.5 * (libm::hypot(first.a, first.b) + libm::hypot(second.a, second.b));
    let stretch = 1.5 - 0.5 * seventh(mean_chroma);
    let polar = |lab: Lab| {
        let a = lab.a * stretch;
        let hue = if a == 0.0 && lab.b == 0.0 {
            0.0
        } else {
            libm::atan2(lab.b, a).rem_euclid(TAU)
        };
        (libm::hypot(a, lab.b), hue)
    };
    let ((c1, h1), (c2, h2)) = (polar(first), polar(second));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        turn if turn > PI => turn - TAU,
        turn if turn < -PI => turn + TAU,
        turn => turn,
    };
    let mean_hue = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= PI => 0.5 * sum,
        sum if sum < TAU => 0.5 * (sum + TAU),
        sum => 0.5 * (sum - TAU),
    };
    let (mean_l, mean_c) = (0.5 * (first.l + second.l), 0.5 * (c1 + c2));
    let degrees = |d: f64| d.to_radians();
    let t = 1.0 - 0.17 * libm::cos(mean_hue - degrees(30.0))
        + 0.24 * libm::cos(2.0 * mean_hue)
        + 0.32 * libm::cos(3.0 * mean_hue + degrees(6.0))
        - 0.20 * libm::cos(4.0 * mean_hue - degrees(63.0));
    let from_blue = (mean_hue.to_degrees() - 275.0) / 25.0;
    let rotation = degrees(60.0 * libm::exp(-from_blue * from_blue));
    let off_middle = (mean_l - 50.0).powi(2);
    let lightness = (second.l - first.l) / (1.0 + 0.015 * off_middle / (20.0 + off_middle).sqrt());
    let chroma = (c2 - c1) / (1.0 + 0.045 * mean_c);
    let hue = 2.0 * (c1 * c2).sqrt() * libm::sin(0.5 * turn) / (1.0 + 0.015 * mean_c * t);
    let crossed = -2.0 * seventh(mean_c) * libm::sin(rotation) * chroma * hue;
    (lightness * lightness + chroma * chroma + hue * hue + crossed)
        .max(0.0)
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// \[SWD05\] table 1.
    const PUBLISHED: [([f64; 3], [f64; 3], f64); 34] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
        ([50.0, 2.8361, -74.02], [50.0, 0.0, -82.7485], 3.4412),
        ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, -1.1848, -84.8006], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, -0.9009, -85.5211], [50.0, 0.0, -82.7485], 1.0),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.001], 7.1792),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
        ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0012], 7.2195),
        ([50.0, -0.001, 2.49], [50.0, 0.0009, -2.49], 4.8045),
        ([50.0, -0.001, 2.49], [50.0, 0.001, -2.49], 4.8045),
        ([50.0, -0.001, 2.49], [50.0, 0.0011, -2.49], 4.7461),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
        ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.903),
        ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 3.2972, 0.0], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 1.8634, 0.5757], 1.0),
        ([50.0, 2.5, 0.0], [50.0, 3.2592, 0.335], 1.0),
        (
            [60.2574, -34.0099, 36.2677],
            [60.4626, -34.1751, 39.4387],
            1.2644,
        ),
        (
            [63.0109, -31.0961, -5.8663],
            [62.8187, -29.7946, -4.0864],
            1.263,
        ),
        ([61.2901, 3.7196, -5.3901], [61.4292, 2.248, -4.962], 1.8731),
        (
            [35.0831, -44.1164, 3.7933],
            [35.0232, -40.0716, 1.5901],
            1.8645,
        ),
        (
            [22.7233, 20.0904, -46.694],
            [23.0331, 14.973, -42.5619],
            2.0373,
        ),
        (
            [36.4612, 47.858, 18.3852],
            [36.2715, 50.5065, 21.2231],
            1.4146,
        ),
        (
            [90.8027, -2.0831, 1.441],
            [91.1528, -1.6435, 0.0447],
            1.4441,
        ),
        (
            [90.9257, -0.5406, -0.9208],
            [88.6381, -0.8985, -0.7239],
            1.5381,
        ),
        (
            [6.7747, -0.2908, -2.4247],
            [5.8714, -0.0985, -2.2286],
            0.6377,
        ),
        ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    #[test]
    fn all_published_pairs_have_their_published_difference_both_ways() {
        let lab = |[l, a, b]: [f64; 3]| Lab { l, a, b };
        for (first, second, expected) in PUBLISHED {
            for found in [
                ciede2000(lab(first), lab(second)),
                ciede2000(lab(second), lab(first)),
            ] {
                assert!(
                    (found - expected).abs() < 6e-5,
                    "{first:?} {second:?}: {found}, {expected}"
                );
            }
        }
    }
}
