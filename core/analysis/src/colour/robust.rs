//! Which pairs show the same ground: clouds, shadows and what was built since are outliers.

use super::ColourPair;
use super::map::ColourMap;

/// Pairs that starts are tried on.
const TRIED: usize = 2000;
/// Pairs in a start: four points in general position fix a map, twice as many make it less wild.
const START: usize = 8;
/// Starts. With a third of the pairs outlying, one in 26 starts has none: 200 fail together once in
/// 2000 times, and steps lead many of the others to the same map.
const STARTS: usize = 200;
/// Starts that are followed to their end.
const FOLLOWED: usize = 8;
/// Part of the pairs that a map has to fit.
const KEPT: f64 = 0.6;
/// Residuals beyond so many standard deviations count for nothing.
const CUT: f64 = 4.0;
/// Median of a distance in three dimensions in standard deviations of each.
const MEDIAN_DISTANCE: f64 = 1.538_172;
/// Standard deviation that residuals have at least, in steps of 8 bits: noise, and what a camera bends that
/// no affine map follows. Twelve steps off is still the same ground.
const LEAST_DEVIATION: f64 = 3.0 / 255.0;

/// The map that most pairs agree on, and how much each pair counts, 0 to 1.
///
/// Least trimmed squares by concentration steps from many starts (\[RD06\]), then Tukey's biweight with the deviation of the
/// residuals' median. The same pairs give the same map: starts follow a fixed sequence.
pub(super) fn agreed(pairs: &[ColourPair]) -> (ColourMap, Vec<f64>) {
    let every = pairs.len().div_ceil(TRIED).max(1);
    let tried: Vec<&ColourPair> = pairs.iter().step_by(every).collect();
    let mut numbers = Sequence(0x2545_F491_4F6C_DD1D);
    let mut found: Vec<(f64, ColourMap)> = (0..STARTS)
        .map(|_| {
            let start = (0..START).map(|_| (tried[numbers.below(tried.len())], 1.0));
            let start: Vec<_> = start.collect();
            let map = ColourMap::least_squares(start.into_iter());
            let (_, map) = concentrated(&tried, map);
            concentrated(&tried, map)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(FOLLOWED);
    // As they are does not have to be found by chance.
    found.push(concentrated(&tried, ColourMap::IDENTITY));
    for candidate in &mut found {
        for _ in 0..20 {
            let next = concentrated(&tried, candidate.1);
            if next.0 >= candidate.0 {
                break;
            }
            *candidate = next;
        }
    }
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let mut map = best.map_or(ColourMap::IDENTITY, |(_, map)| map);
    let mut weights = weights(pairs, &map);
    for _ in 0..10 {
        map = ColourMap::least_squares(pairs.iter().zip(weights.iter().copied()));
        weights = self::weights(pairs, &map);
    }
    (map, weights)
}

/// A concentration step: the sum of squares of the pairs that a map fits best, and the map of least squares
/// through these. From step to step the sum never grows.
fn concentrated(pairs: &[&ColourPair], map: ColourMap) -> (f64, ColourMap) {
    let mut by_residual: Vec<(f64, &ColourPair)> = pairs
        .iter()
        .map(|pair| (map.residual(pair), *pair))
        .collect();
    let kept = ((pairs.len() as f64 * KEPT) as usize).clamp(1, pairs.len());
    by_residual.select_nth_unstable_by(kept - 1, |a, b| a.0.total_cmp(&b.0));
    by_residual.truncate(kept);
    let sum = by_residual.iter().map(|(r, _)| r * r).sum();
    let map = ColourMap::least_squares(by_residual.iter().map(|(_, pair)| (*pair, 1.0)));
    (sum, map)
}

/// How much each pair counts for a map.
fn weights(pairs: &[ColourPair], map: &ColourMap) -> Vec<f64> {
    let residuals: Vec<f64> = pairs.iter().map(|pair| map.residual(pair)).collect();
    let mut sorted = residuals.clone();
    // Of those that the map has to fit, so that outliers do not widen it.
    let kept = ((pairs.len() as f64 * KEPT) as usize).clamp(1, pairs.len());
    let (_, middle, _) = sorted.select_nth_unstable_by(kept / 2, f64::total_cmp);
    // The 30th percentile of a distance in three dimensions is 0.77 of its median.
    let deviation = (*middle / (0.773 * MEDIAN_DISTANCE)).max(LEAST_DEVIATION);
    let weight = |r: &f64| {
        let share = r / (CUT * deviation);
        if share < 1.0 {
            (1.0 - share * share).powi(2)
        } else {
            0.0
        }
    };
    residuals.iter().map(weight).collect()
}

/// Numbers without order, always the same (xorshift64*).
struct Sequence(u64);

impl Sequence {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let high = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33;
        (high % end as u64) as usize
    }
}
