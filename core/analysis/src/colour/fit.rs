//! What makes the colours of one picture look like those of another, and how good it is.

mod histograms;

use core::convert::identity;

use glam::DVec3;

use super::ColourPair;
use super::ground::{CommonGround, Difference};
use super::map::{ColourMap, vector};
pub use histograms::{FIT_BINS, FitHistograms};

/// How colours are matched, from the fewest parameters to the most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MatchMethod {
    /// A gain and an offset a channel, so that means and standard deviations agree.
    MeanAndSpread,
    /// A tone curve a channel, so that histograms agree.
    Histogram,
    /// A 3 × 4 map, so that colours agree place by place in the least squares.
    Regression,
}

/// What makes one picture look like the other; steps in the order of the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourChange {
    /// Mix and offset on display values: channels alone for all methods but the regression.
    pub map: ColourMap,
    /// A tone curve a channel after the map: points (input, output) with rising inputs; empty curves
    /// change nothing. How a curve runs between its points is decided by who draws it.
    pub curves: [Vec<[f64; 2]>; 3],
}

/// How well one picture, its colours changed, looks like the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourFit {
    /// Number of pairs.
    pub pairs: usize,
    /// Of these, how many were taken to show the same ground.
    pub same: usize,
    /// Difference before.
    pub before: Difference,
    /// Difference after.
    pub after: Difference,
    /// How often each value is seen where both show the same ground.
    pub histograms: FitHistograms,
}

impl CommonGround {
    /// What makes the first picture look like the second, from the pairs that show the same ground alone,
    /// whatever the method.
    pub fn change(&self, method: MatchMethod) -> ColourChange {
        let pairs: Vec<(&ColourPair, f64)> = self.weighted().collect();
        let none = || core::array::from_fn(|_| Vec::new());
        let (map, curves) = match method {
            MatchMethod::Regression => (self.agreed, none()),
            MatchMethod::MeanAndSpread => (spread(&pairs), none()),
            MatchMethod::Histogram => (
                ColourMap::IDENTITY,
                core::array::from_fn(|channel| quantiles(&pairs, channel)),
            ),
        };
        ColourChange { map, curves }
    }

    /// How good a change of the first picture is. `shown` is the change as it is drawn: display values to
    /// display values.
    pub fn fit(&self, shown: impl Fn([f32; 3]) -> [f32; 3]) -> ColourFit {
        ColourFit {
            pairs: self.places(),
            same: self.same(),
            before: self.difference(identity, identity),
            after: self.difference(&shown, identity),
            histograms: FitHistograms::of(self, shown),
        }
    }

    /// Pairs and how much each counts.
    fn weighted(&self) -> impl Iterator<Item = (&ColourPair, f64)> {
        self.pairs.iter().zip(self.weights.iter().copied())
    }
}

/// Weighted means and standard deviations agree.
fn spread(pairs: &[(&ColourPair, f64)]) -> ColourMap {
    /// Standard deviation below which a channel has no spread: a step of 8 bits.
    const FLAT: f64 = 1.0 / 255.0;
    let weight: f64 = pairs.iter().map(|(_, w)| w).sum();
    let mean = |of: &dyn Fn(&ColourPair) -> DVec3| {
        pairs.iter().map(|(pair, w)| *w * of(pair)).sum::<DVec3>() / weight
    };
    let (from, to) = (
        |p: &ColourPair| vector(p.from),
        |p: &ColourPair| vector(p.to),
    );
    let (mean_from, mean_to) = (mean(&from), mean(&to));
    let deviation = |of: &dyn Fn(&ColourPair) -> DVec3, around: DVec3| {
        mean(&|pair| (of(pair) - around).powf(2.0)).map(f64::sqrt)
    };
    let (own, wanted) = (deviation(&from, mean_from), deviation(&to, mean_to));
    let gain = DVec3::from_array(core::array::from_fn(|c| {
        if own[c] > FLAT {
            wanted[c] / own[c]
        } else {
            1.0
        }
    }));
    ColourMap {
        matrix: glam::DMat3::from_diagonal(gain),
        offset: mean_to - gain * mean_from,
    }
}

/// A curve through the quantiles of a channel, continued to both ends by its own grade there.
fn quantiles(pairs: &[(&ColourPair, f64)], channel: usize) -> Vec<[f64; 2]> {
    /// Shares of the pairs.
    const SHARES: [f64; 11] = [
        0.01, 0.05, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 0.95, 0.99,
    ];
    /// Inputs closer than this are one point.
    const APART: f64 = 0.015;
    let sorted = |of: &dyn Fn(&ColourPair) -> f32| {
        let mut values: Vec<(f64, f64)> = pairs
            .iter()
            .filter(|(_, w)| *w > 0.0)
            .map(|(pair, w)| (f64::from(of(pair)).clamp(0.0, 1.0), *w))
            .collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        values
    };
    let at = |values: &[(f64, f64)], share: f64| {
        let total: f64 = values.iter().map(|(_, w)| w).sum();
        let mut sum = 0.0;
        let reached = values.iter().find(|(_, w)| {
            sum += w;
            sum >= share * total
        });
        reached.or(values.last()).map_or(0.0, |(v, _)| *v)
    };
    let (from, to) = (
        sorted(&|pair| pair.from[channel]),
        sorted(&|pair| pair.to[channel]),
    );
    let mut points: Vec<[f64; 2]> = Vec::new();
    for share in SHARES {
        let point = [at(&from, share), at(&to, share)];
        if points.last().is_none_or(|last| point[0] - last[0] >= APART) {
            points.push(point);
        }
    }
    let [Some(first), Some(last)] = [points.first().copied(), points.last().copied()] else {
        return points;
    };
    // One colour everywhere: all the curve can do is shift.
    let grade = if last[0] > first[0] {
        ((last[1] - first[1]) / (last[0] - first[0])).clamp(0.25, 4.0)
    } else {
        1.0
    };
    let black = [0.0, (first[1] - grade * first[0]).clamp(0.0, first[1])];
    let white = [1.0, (last[1] + grade * (1.0 - last[0])).clamp(last[1], 1.0)];
    if first[0] >= APART {
        points.insert(0, black);
    }
    if last[0] <= 1.0 - APART {
        points.push(white);
    }
    points
}

#[cfg(test)]
mod tests;
