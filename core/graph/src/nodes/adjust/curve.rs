//! Tone curves: a smooth line through points that never swings past them.

/// Parts of the axis from 0 to 1 in which a table follows a curve straight.
const PARTS: usize = 1024;

/// A curve through points, from values 0 to 1 to values 0 to 1; none is the identity.
///
/// Between points a cubic whose slopes keep it monotone where the points are, so that it never leaves the
/// range of its neighbours; before the first and beyond the last point it is level.
///
/// Source: \[FC80\], with weighted harmonic means as slopes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    points: Vec<[f64; 2]>,
}

impl Curve {
    /// One that changes nothing.
    pub const fn new() -> Self {
        Self { points: Vec::new() }
    }

    /// Through points (input, output). Those that are no numbers are left out, others clamped to 0 to 1
    /// and put in order; of several at one input the last counts.
    pub fn through(points: &[[f64; 2]]) -> Self {
        let finite = points
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite());
        let mut points: Vec<[f64; 2]> = finite.map(|p| p.map(|v| v.clamp(0.0, 1.0))).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(points.len());
        for point in points {
            match kept.last_mut() {
                Some(last) if point[0] - last[0] < 1e-9 => *last = point,
                _ => kept.push(point),
            }
        }
        Self { points: kept }
    }

    /// Its points, in order.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Whether it changes nothing from 0 to 1: none of its points leaves the diagonal, which it reaches
    /// from end to end.
    pub fn is_identity(&self) -> bool {
        match self.points.as_slice() {
            [] => true,
            [first, .., last] => {
                *first == [0.0; 2] && *last == [1.0; 2] && self.points.iter().all(|p| p[0] == p[1])
            }
            [_] => false,
        }
    }

    /// The output for an input.
    pub fn at(&self, x: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return x;
        };
        if x <= first[0] {
            return first[1];
        }
        if x >= last[0] {
            return last[1];
        }
        let i = self.points.partition_point(|p| p[0] <= x) - 1;
        let ([x0, y0], [x1, y1]) = (self.points[i], self.points[i + 1]);
        let (h, t) = (x1 - x0, (x - x0) / (x1 - x0));
        let (m0, m1) = (self.slope(i) * h, self.slope(i + 1) * h);
        let (u, v) = (t * t, 1.0 - t);
        // Hermite's basis.
        y0 * (1.0 + 2.0 * t) * v * v + m0 * t * v * v + y1 * u * (3.0 - 2.0 * t) - m1 * u * v
    }

    /// Slope at a point: none at an extremum, else a mean that no neighbour's grade is a third of.
    fn slope(&self, i: usize) -> f64 {
        let grade = |k: usize| {
            let ([x0, y0], [x1, y1]) = (self.points[k], self.points[k + 1]);
            (x1 - x0, (y1 - y0) / (x1 - x0))
        };
        if i == 0 {
            return grade(0).1;
        }
        if i + 1 == self.points.len() {
            return grade(i - 1).1;
        }
        let ((h0, d0), (h1, d1)) = (grade(i - 1), grade(i));
        if d0 * d1 <= 0.0 {
            return 0.0;
        }
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / d0 + w1 / d1)
    }
}

/// A curve, straight between 1025 places: within 10⁻⁵ of curves whose slope changes by less than 80 over
/// the whole axis.
#[derive(Clone, Debug)]
pub(super) struct Table(Vec<f32>);

impl Table {
    /// Of what is done to values from 0 to 1.
    pub(super) fn of(curve: impl Fn(f64) -> f64) -> Self {
        let at = |k: usize| curve(k as f64 / PARTS as f64) as f32;
        Self((0..=PARTS).map(at).collect())
    }

    /// The output for an input; beyond 0 to 1 that at the end.
    #[inline(always)]
    pub(super) fn at(&self, x: f32) -> f32 {
        // Not a number becomes 0.
        let place = (x.clamp(0.0, 1.0) * PARTS as f32).max(0.0);
        let k = (place as usize).min(PARTS - 1);
        let part = place - k as f32;
        self.0[k] + (self.0[k + 1] - self.0[k]) * part
    }

    pub(super) fn values(&self) -> &[f32] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points() -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 1..9)
    }

    proptest! {
        #[test]
        fn a_curve_goes_through_its_points_and_stays_between_neighbours(points in points(), x in -0.2..1.2_f64) {
            let curve = Curve::through(&points);
            for [px, py] in curve.points() {
                prop_assert!((curve.at(*px) - py).abs() < 1e-12);
            }
            let after = curve.points().partition_point(|p| p[0] <= x);
            let around = [after.saturating_sub(1), after.min(curve.points().len() - 1)].map(|i| curve.points()[i][1]);
            let (low, high) = (around[0].min(around[1]), around[0].max(around[1]));
            let y = curve.at(x);
            prop_assert!((low - 1e-12..=high + 1e-12).contains(&y), "{curve:?} {x} {y}");
        }

        #[test]
        fn tables_follow_gentle_curves(lift in -0.15..0.15_f64, x in 0.0..1.0_f32) {
            let curve = Curve::through(&[[0.0, 0.0], [0.5, 0.5 + lift], [1.0, 1.0]]);
            let exact = curve.at(f64::from(x));
            prop_assert!((f64::from(Table::of(|x| curve.at(x)).at(x)) - exact).abs() < 1e-5);
        }
    }

    #[test]
    fn no_points_and_points_of_the_diagonal_change_nothing() {
        assert!(Curve::default().is_identity() && Curve::default().at(7.5) == 7.5);
        assert!(Curve::through(&[[0.0, 0.0], [0.3, 0.3], [1.0, 1.0]]).is_identity());
        assert!(!Curve::through(&[[0.1, 0.1], [1.0, 1.0]]).is_identity());
        assert!(!Curve::through(&[[0.5, 0.5]]).is_identity());
    }

    #[test]
    fn points_of_any_kind_make_a_curve() {
        let odd = [
            [f64::NAN, 0.0],
            [2.0, -1.0],
            [0.5, 0.2],
            [0.5, 0.8],
            [-3.0, 0.1],
        ];
        let curve = Curve::through(&odd);
        assert_eq!(curve.points(), [[0.0, 0.1], [0.5, 0.8], [1.0, 0.0]]);
        assert_eq!(Table::of(|x| curve.at(x)).at(f32::NAN), 0.1);
        assert_eq!(Table::of(|x| curve.at(x)).at(f32::INFINITY), 0.0);
    }
}
