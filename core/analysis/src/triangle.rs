//! Integrals of the positive part of a linear function over triangles, and of cells made of them.

/// Share of a triangle's area on which the linear function with these corner values is positive, and
/// the mean over the whole triangle of its positive part. Exact.
pub(crate) fn positive_part(corners: [f64; 3]) -> (f64, f64) {
    let [a, b, c] = sorted(corners);
    if c <= 0.0 {
        return (0.0, 0.0);
    }
    let mean = (a + b + c) / 3.0;
    if a >= 0.0 {
        return (1.0, mean);
    }
    if b <= 0.0 {
        // The corner c alone stands out: a smaller triangle with the corner values c, 0, 0.
        let share = (c / (c - a)) * (c / (c - b));
        return (share, share * c / 3.0);
    }
    // The corner a alone lies below: the whole minus a triangle with the corner values a, 0, 0.
    let share = (a / (a - b)) * (a / (a - c));
    (1.0 - share, mean - share * a / 3.0)
}

fn sorted([a, b, c]: [f64; 3]) -> [f64; 3] {
    let (low, high) = (a.min(b), a.max(b));
    if c <= low {
        [c, low, high]
    } else if c >= high {
        [low, high, c]
    } else {
        [low, c, high]
    }
}

/// As [`positive_part`] for a square cell: four triangles around its centre, which has the mean of
/// the corners (clockwise or counter-clockwise).
pub(crate) fn positive_part_of_cell(corners: [f64; 4]) -> (f64, f64) {
    let centre = corners.iter().sum::<f64>() / 4.0;
    if corners.iter().all(|d| *d >= 0.0) && centre > 0.0 {
        return (1.0, centre);
    }
    if corners.iter().all(|d| *d <= 0.0) {
        return (0.0, 0.0);
    }
    let mut sum = (0.0, 0.0);
    for i in 0..4 {
        let (share, mean) = positive_part([corners[i], corners[(i + 1) % 4], centre]);
        sum = (sum.0 + share / 4.0, sum.1 + mean / 4.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_positive_part_is_what_fine_sampling_finds(
            a in -1.0..1.0, b in -1.0..1.0, c in -1.0..1.0,
        ) {
            let (share, mean) = positive_part([a, b, c]);
            let (mut hits, mut sum, mut all) = (0.0, 0.0, 0.0);
            for i in 0..200 {
                for j in 0..200 - i {
                    let (u, v) = ((f64::from(i) + 0.33) / 200.0, (f64::from(j) + 0.33) / 200.0);
                    let value = a + (b - a) * u + (c - a) * v;
                    all += 1.0;
                    hits += f64::from(u8::from(value > 0.0));
                    sum += f64::max(value, 0.0);
                }
            }
            prop_assert!((share - hits / all).abs() < 0.02 && (mean - sum / all).abs() < 0.01);
        }

        #[test]
        fn above_minus_below_is_the_mean(
            corners in prop::array::uniform4(-5.0..5.0_f64),
        ) {
            let (up_share, up) = positive_part_of_cell(corners);
            let (down_share, down) = positive_part_of_cell(corners.map(|d| -d));
            prop_assert!((up - down - corners.iter().sum::<f64>() / 4.0).abs() < 1e-12);
            prop_assert!((up_share + down_share - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_cell_that_is_nowhere_positive_gives_nothing() {
        assert_eq!(positive_part_of_cell([0.0; 4]), (0.0, 0.0));
        assert_eq!(positive_part_of_cell([-1.0, 0.0, 0.0, -2.0]), (0.0, 0.0));
    }
}
