//! Detail of imagery as it lies in version 1 of the file.

use super::range;

names! {
    /// What fine colours are modelled on.
    By for ByName {
        /// Noise by the power law that the imagery follows.
        Noise = "noise",
        /// Pieces of finer imagery.
        Examples = "examples",
    }
}

/// [`crate::DetailBy`] without what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByName {
    /// Noise.
    Noise,
    /// Examples.
    Examples,
}

fields! {
    /// Colours finer than the file has them.
    ColourDetail {
        /// What they are modelled on.
        by: By,
        /// Ids of imagery layers, hidden or not, that are examples; required for those, and only there.
        #[schemars(length(min = 1, max = range::MOST_EXAMPLES))]
        layers: Option<Vec<String>>,
        /// How far an example's mean colour may be from the imagery's; 0.15 where left out. Only for examples.
        tolerance: Option<f64> = range::TOLERANCE,
        /// Id of a vector layer, hidden or not, in whose areas detail is; everywhere where left out.
        areas: Option<String>,
        /// Factor on the contrast; 1 where left out.
        strength: Option<f64> = range::FACTOR,
        /// Chooses the pattern; 0 where left out.
        seed: Option<u32>,
    }
}
