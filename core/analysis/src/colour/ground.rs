//! What two pictures show of the same ground, and how far they are apart there.

use super::map::ColourMap;
use super::robust::agreed;
use super::{ColourPair, Lab, ciede2000};

/// Fewest pairs that anything is said from.
pub const FEWEST_PAIRS: usize = 50;

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

/// Places that two pictures show, and how much each counts: those that do not show the same ground (clouds,
/// shadows, what was built since) do not.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonGround {
    pub(super) pairs: Vec<ColourPair>,
    /// 0 to 1, one a pair.
    pub(super) weights: Vec<f64>,
    /// The affine map that most pairs agree on.
    pub(super) agreed: ColourMap,
}

impl CommonGround {
    /// Of pairs: `from` in the first picture, `to` in the second. What shows the same ground is found by a
    /// robust regression.
    ///
    /// # Errors
    /// [`TooFewPairs`] below [`FEWEST_PAIRS`]; pairs with values that are no numbers do not count.
    pub fn of(pairs: &[ColourPair]) -> Result<Self, TooFewPairs> {
        let finite = |pair: &&ColourPair| pair.from.iter().chain(&pair.to).all(|v| v.is_finite());
        let pairs: Vec<ColourPair> = pairs.iter().filter(finite).copied().collect();
        if pairs.len() < FEWEST_PAIRS {
            return Err(TooFewPairs { found: pairs.len() });
        }
        let (agreed, weights) = agreed(&pairs);
        Ok(Self {
            pairs,
            weights,
            agreed,
        })
    }

    /// How many places there are.
    pub fn places(&self) -> usize {
        self.pairs.len()
    }

    /// At how many of them both pictures show the same ground.
    pub fn same(&self) -> usize {
        self.weights.iter().filter(|w| **w > 0.0).count()
    }

    /// How far the pictures are apart, their colours changed by `first` and `second`: display values to
    /// display values, of which what lies beyond 0 to 1 is seen as 0 or 1.
    pub fn difference(
        &self,
        first: impl Fn([f32; 3]) -> [f32; 3],
        second: impl Fn([f32; 3]) -> [f32; 3],
    ) -> Difference {
        let seen = |rgb: [f32; 3]| Lab::from_srgb(rgb.map(|v| v.clamp(0.0, 1.0)));
        let of = |pair: &ColourPair| ciede2000(seen(first(pair.from)), seen(second(pair.to)));
        let mut all: Vec<f64> = self.pairs.iter().map(of).collect();
        let same = all.iter().zip(&self.weights).filter(|(_, w)| **w > 0.0);
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
}
