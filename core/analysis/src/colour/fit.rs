//! What makes the colours of one picture look like those of another.

mod histograms;

use glam::DVec3;

use super::map::{ColourMap, vector};
use super::robust::agreed;
use super::{ColourPair, Lab, ciede2000};
pub use histograms::{FIT_BINS, FitHistograms};

/// Fewest pairs that a match is made from.
pub const FEWEST_PAIRS: usize = 50;

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

/// Too few places have both colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected at least {FEWEST_PAIRS} places with both colours, found {found}")]
pub struct TooFewPairs {
    /// How many have.
    pub found: usize,
}

/// Colour differences (CIEDE2000) over pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Over all pairs.
    pub mean: f64,
    /// One in twenty pairs differs by more.
    pub p95: f64,
    /// Over the pairs that show the same ground.
    pub mean_of_same: f64,
}

/// What makes one picture look like the other; steps in the order of the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourFit {
    /// Mix and offset on display values: channels alone for all methods but the regression.
    pub map: ColourMap,
    /// A tone curve a channel after the map: points (input, output) with rising inputs; empty curves
    /// change nothing.
    pub curves: [Vec<[f64; 2]>; 3],
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

/// Fits. Pairs that do not show the same ground (clouds, shadows, what was built since) are found by a
/// robust regression first and left out, whatever the method.
///
/// # Errors
/// [`TooFewPairs`] below [`FEWEST_PAIRS`]; pairs with values that are no numbers do not count.
pub fn fit(pairs: &[ColourPair], method: MatchMethod) -> Result<ColourFit, TooFewPairs> {
    let pairs = finite(pairs)?;
    let (regression, weights) = agreed(&pairs);
    let same: Vec<(&ColourPair, f64)> = pairs.iter().zip(weights.iter().copied()).collect();
    let none = || core::array::from_fn(|_| Vec::new());
    let (map, curves) = match method {
        MatchMethod::Regression => (regression, none()),
        MatchMethod::MeanAndSpread => (spread(&same), none()),
        MatchMethod::Histogram => (
            ColourMap::IDENTITY,
            core::array::from_fn(|channel| quantiles(&same, channel)),
        ),
    };
    let shown = |pair: &ColourPair| {
        let mapped = map.apply(pair.from).to_array();
        core::array::from_fn(|c| followed(&curves[c], mapped[c].clamp(0.0, 1.0)) as f32)
    };
    Ok(ColourFit {
        pairs: pairs.len(),
        same: weights.iter().filter(|w| **w > 0.0).count(),
        before: difference(&pairs, &weights, |pair| pair.from),
        after: difference(&pairs, &weights, shown),
        histograms: FitHistograms::of(&pairs, &weights, shown),
        map,
        curves,
    })
}

/// Differences of pairs as they are.
///
/// # Errors
/// As for [`fit()`].
pub fn colour_difference(pairs: &[ColourPair]) -> Result<Difference, TooFewPairs> {
    let pairs = finite(pairs)?;
    let (_, weights) = agreed(&pairs);
    Ok(difference(&pairs, &weights, |pair| pair.from))
}

pub(super) fn finite(pairs: &[ColourPair]) -> Result<Vec<ColourPair>, TooFewPairs> {
    let finite = |pair: &&ColourPair| pair.from.iter().chain(&pair.to).all(|v| v.is_finite());
    let pairs: Vec<ColourPair> = pairs.iter().filter(finite).copied().collect();
    if pairs.len() < FEWEST_PAIRS {
        return Err(TooFewPairs { found: pairs.len() });
    }
    Ok(pairs)
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

/// A curve's output, straight between points: how a fit is judged, not how it is drawn.
fn followed(points: &[[f64; 2]], x: f64) -> f64 {
    let after = points.partition_point(|p| p[0] <= x);
    match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
        (None, None) => x,
        (Some(only), None) => only[1],
        (None, Some(only)) => only[1],
        (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
    }
}

pub(super) fn difference(
    pairs: &[ColourPair],
    weights: &[f64],
    shown: impl Fn(&ColourPair) -> [f32; 3],
) -> Difference {
    let of = |pair: &ColourPair| ciede2000(Lab::from_srgb(shown(pair)), Lab::from_srgb(pair.to));
    let mut all: Vec<f64> = pairs.iter().map(of).collect();
    let same = all.iter().zip(weights).filter(|(_, w)| **w > 0.0);
    let (sum, count) = same.fold((0.0, 0_usize), |(sum, n), (d, _)| (sum + d, n + 1));
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    all.sort_by(f64::total_cmp);
    let p95 = all.get((all.len() * 95 / 100).min(all.len().saturating_sub(1)));
    Difference {
        mean,
        p95: p95.copied().unwrap_or(0.0),
        mean_of_same: sum / count.max(1) as f64,
    }
}

#[cfg(test)]
mod tests;
