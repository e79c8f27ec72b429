//! Values of a fit before, after and as they should be.

use super::CommonGround;

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
    pub(super) fn of(ground: &CommonGround, shown: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        let mut all = Self {
            before: [[0; FIT_BINS]; 3],
            after: [[0; FIT_BINS]; 3],
            target: [[0; FIT_BINS]; 3],
        };
        for (pair, _) in ground.weighted().filter(|(_, w)| *w > 0.0) {
            let counted = [
                (&mut all.before, pair.from),
                (&mut all.after, shown(pair.from)),
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
