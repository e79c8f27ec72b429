//! The colours of a difference of heights: blue where the ground is lower, red where it is higher.

use relievo_graph::nodes::Stop;

/// Differences below this are none, metres.
const LEAST_M: f32 = 0.005;

/// Smallest and largest range, metres.
const RANGE_M: (f32, f32) = (0.1, 20_000.0);

/// Stops of the ramp on either side.
const STOPS: u8 = 12;

/// How a difference of heights is coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightDifference {
    range_m: f32,
}

impl HeightDifference {
    /// With the strongest colours from a difference of `range_m` metres on, 0.1 to 20,000; one
    /// beyond is the nearest of these.
    pub fn new(range_m: f32) -> Self {
        let range_m = if range_m.is_nan() { RANGE_M.0 } else { range_m };
        Self {
            range_m: range_m.clamp(RANGE_M.0, RANGE_M.1),
        }
    }

    /// With the first of 1, 2, 5, 10, ... metres, or parts of one, that is no less than a difference.
    pub fn that_shows(most_m: f32) -> Self {
        let (mut range_m, mut steps) = (RANGE_M.0, [2.0, 2.5, 2.0].into_iter().cycle());
        while range_m < most_m.abs() && range_m < RANGE_M.1 {
            range_m *= steps.next().unwrap_or(2.0);
        }
        Self::new(range_m)
    }

    /// From which difference on the colours are the strongest, metres.
    pub fn range_m(self) -> f32 {
        self.range_m
    }

    /// The colour, straight and display-referred with alpha, 0 to 1, of a difference as a share of
    /// the range, −1 (lower) to 1 (higher).
    pub fn colour(share: f32) -> [f32; 4] {
        let share = share.clamp(-1.0, 1.0);
        // Faint differences are seen, too.
        let strength = share.abs().sqrt();
        // The ends of ColorBrewer's red to blue.
        let end = if share > 0.0 {
            [178.0, 24.0, 43.0]
        } else {
            [33.0, 102.0, 172.0]
        };
        let [r, g, b] = end.map(|c: f32| (245.0 + (c - 245.0) * strength) / 255.0);
        [r, g, b, 0.35 + 0.5 * strength]
    }

    /// The colours by metres of difference, transparent around 0.
    pub(crate) fn stops(self) -> Vec<Stop> {
        let stop = |height_m: f32, rgba| Stop { height_m, rgba };
        // Squares, since the strength goes with the root.
        let share = |i: u8| (f32::from(i) / f32::from(STOPS)).powi(2);
        let side = |sign: f32| {
            move |i: u8| {
                let metres = (share(i) * self.range_m).max(LEAST_M);
                stop(
                    sign * metres,
                    Self::colour(sign * share(i).max(f32::MIN_POSITIVE)),
                )
            }
        };
        let clear = |sign: f32| {
            let [r, g, b, _] = Self::colour(sign * f32::MIN_POSITIVE);
            stop(sign * 0.5 * LEAST_M, [r, g, b, 0.0])
        };
        let kept = (1..=STOPS).filter(|i| *i == STOPS || share(*i) * self.range_m > LEAST_M);
        let (lower, higher): (Vec<_>, Vec<_>) = kept.map(|i| (side(-1.0)(i), side(1.0)(i))).unzip();
        let lower = lower.into_iter().rev();
        let nothing = [side(-1.0)(0), clear(-1.0), clear(1.0), side(1.0)(0)];
        lower.chain(nothing).chain(higher).collect()
    }
}

#[cfg(test)]
mod tests {
    use relievo_graph::nodes::Tint;

    use super::*;

    #[test]
    fn colours_diverge_from_nothing() {
        let (low, high) = (
            HeightDifference::colour(-1.0),
            HeightDifference::colour(1.0),
        );
        assert!(high[0] > high[2] && low[2] > low[0]);
        assert_eq!(HeightDifference::colour(7.0), high);
        assert!(HeightDifference::colour(0.01)[3] < high[3]);
    }

    #[test]
    fn a_range_is_a_round_number_that_holds_the_difference() {
        for (most_m, range_m) in [
            (0.0, 0.1),
            (0.1, 0.1),
            (0.15, 0.2),
            (3.0, 5.0),
            (13.0, 20.0),
            (1e9, 20_000.0),
            (f32::NAN, 0.1),
        ] {
            let found = HeightDifference::that_shows(most_m).range_m();
            assert!((found / range_m - 1.0).abs() < 1e-5, "{most_m}: {found}");
        }
    }

    #[test]
    fn every_range_makes_a_tint_that_is_clear_where_nothing_differs() {
        for range_m in [f32::NAN, -1.0, 0.1, 0.2, 1.0, 50.0, 20_000.0, f32::INFINITY] {
            let stops = HeightDifference::new(range_m).stops();
            assert!(Tint::new(&stops, true).is_ok(), "{range_m}: {stops:?}");
            let middle: Vec<_> = stops.iter().filter(|s| s.rgba[3] == 0.0).collect();
            assert!(middle.len() == 2 && middle[0].height_m < 0.0 && middle[1].height_m > 0.0);
        }
    }
}
