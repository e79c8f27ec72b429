//! What is done to the points of a tone curve. Inputs keep rising, whatever is done.

use relievo_engine::project::{CurvePoint, Extra};

/// Inputs are at least this far apart.
const APART: f64 = 0.004;

/// Most points: what files hold.
const MOST: usize = 64;

fn point([input, output]: [f64; 2]) -> CurvePoint {
    CurvePoint {
        input,
        output,
        extra: Extra::new(),
    }
}

/// With one more point, and which it is. A curve without points gets its ends first; a place that is
/// taken, or a curve that is full, gives the nearest point.
pub(super) fn added(points: &[CurvePoint], at: [f64; 2]) -> (Vec<CurvePoint>, usize) {
    let mut points = if points.is_empty() {
        vec![point([0.0; 2]), point([1.0; 2])]
    } else {
        points.to_vec()
    };
    let at = at.map(|v| v.clamp(0.0, 1.0));
    let distance = |p: &CurvePoint| (p.input - at[0]).abs();
    let nearest = (0..points.len())
        .min_by(|a, b| distance(&points[*a]).total_cmp(&distance(&points[*b])))
        .unwrap_or(0);
    if distance(&points[nearest]) < APART || points.len() >= MOST {
        points[nearest].output = at[1];
        return (points, nearest);
    }
    let index = points.partition_point(|p| p.input < at[0]);
    points.insert(index, point(at));
    (points, index)
}

/// With a point elsewhere: between its neighbours.
pub(super) fn moved(points: &[CurvePoint], index: usize, to: [f64; 2]) -> Vec<CurvePoint> {
    let mut points = points.to_vec();
    let low = index
        .checked_sub(1)
        .map_or(0.0, |i| points[i].input + APART);
    let high = points.get(index + 1).map_or(1.0, |p| p.input - APART);
    if let Some(point) = points.get_mut(index) {
        if low <= high {
            point.input = to[0].clamp(low, high);
        }
        point.output = to[1].clamp(0.0, 1.0);
    }
    points
}

/// Without a point. Of the last two both go: one alone would make everything one value.
pub(super) fn removed(points: &[CurvePoint], index: usize) -> Vec<CurvePoint> {
    if points.len() <= 2 {
        return Vec::new();
    }
    let mut points = points.to_vec();
    points.remove(index);
    points
}

/// The middle of the widest gap between inputs, on the straight line between its ends.
pub(super) fn widest_gap(points: &[CurvePoint]) -> [f64; 2] {
    let width = |pair: &&[CurvePoint]| pair[1].input - pair[0].input;
    let widest = points
        .windows(2)
        .max_by(|a, b| width(a).total_cmp(&width(b)));
    widest.map_or([0.5; 2], |pair| {
        [
            f64::midpoint(pair[0].input, pair[1].input),
            f64::midpoint(pair[0].output, pair[1].output),
        ]
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn inputs(points: &[CurvePoint]) -> Vec<f64> {
        points.iter().map(|p| p.input).collect()
    }

    #[test]
    fn the_first_point_brings_the_ends_of_the_curve() {
        let (points, index) = added(&[], [0.3, 0.6]);
        assert_eq!((inputs(&points), index), (vec![0.0, 0.3, 1.0], 1));
        assert_eq!(points[1].output, 0.6);
        assert_eq!(widest_gap(&points), [0.65, 0.8]);
    }

    #[test]
    fn without_one_of_its_last_two_points_a_curve_changes_nothing() {
        let (points, index) = added(&[], [0.3, 0.6]);
        let two = removed(&points, index);
        assert_eq!(inputs(&two), [0.0, 1.0]);
        assert_eq!(removed(&two, 0), []);
    }

    proptest! {
        #[test]
        fn inputs_rise_whatever_is_done(
            steps in prop::collection::vec((0..3, 0..80_usize, prop::array::uniform2(-0.5..1.5_f64)), 0..200),
        ) {
            let mut points: Vec<CurvePoint> = Vec::new();
            for (what, index, at) in steps {
                match (what, points.len()) {
                    (0, _) => points = added(&points, at).0,
                    (_, 0) => {}
                    (1, n) => points = moved(&points, index % n, at),
                    (_, n) => points = removed(&points, index % n),
                }
                prop_assert!(points.len() <= MOST);
                prop_assert!(points.windows(2).all(|p| p[0].input < p[1].input), "{points:?}");
                prop_assert!(points.iter().all(|p| (0.0..=1.0).contains(&p.input) && (0.0..=1.0).contains(&p.output)));
            }
        }
    }
}
