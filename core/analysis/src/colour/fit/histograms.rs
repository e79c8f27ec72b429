//! Values of a fit before, after and as they should be.

use super::super::ColourPair;

/// Bins from black to white.
pub const FIT_BINS: usize = 64;

/// Counts of the pairs that show the same ground: red, green, blue; bins of display values from 0 to 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FitHistograms {
    /// As they are.
    pub before: [[u32; FIT_BINS]; 3],
    /// As they are shown.
    pub after: [[u32; FIT_BINS]; 3],
    /// As they should look.
    pub target: [[u32; FIT_BINS]; 3],
}

impl FitHistograms {
    pub(super) fn of(
        pairs: &[ColourPair],
        weights: &[f64],
        shown: impl Fn(&ColourPair) -> [f32; 3],
    ) -> Self {
        let mut all = Self {
            before: [[0; FIT_BINS]; 3],
            after: [[0; FIT_BINS]; 3],
            target: [[0; FIT_BINS]; 3],
        };
        let same = pairs.iter().zip(weights).filter(|(_, w)| **w > 0.0);
        for (pair, _) in same {
            let counted = [
                (&mut all.before, pair.from),
                (&mut all.after, shown(pair)),
                (&mut all.target, pair.to),
            ];
            for (bins, rgb) in counted {
                for (bins, value) in bins.iter_mut().zip(rgb) {
                    let bin = (value.clamp(0.0, 1.0) * FIT_BINS as f32) as usize;
                    bins[bin.min(FIT_BINS - 1)] += 1;
                }
            }
        }
        all
    }
}
