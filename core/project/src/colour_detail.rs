//! Imagery continued beyond its own resolution.

use crate::{Extra, LayerId};

/// Colours finer than a file has them, in the whole layer or in the areas of a vector layer; reduced to
/// the file's resolution they are the file's. Synthesised: measurements leave them out.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourDetail {
    /// What fine ground looks like.
    pub by: DetailBy,
    /// A vector layer, hidden or not, in whose areas detail is. `None`: everywhere.
    pub areas: Option<LayerId>,
    /// Contrast of detail: 0 (none) to 4. Default 1, as the examples have it or the power law says.
    pub strength: f64,
    /// Chooses the pattern.
    pub seed: u32,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl ColourDetail {
    /// Most kinds of detail of a layer.
    pub const MOST: usize = 16;

    /// Everywhere, as strong as its model.
    pub fn new(by: DetailBy) -> Self {
        Self {
            by,
            areas: None,
            strength: 1.0,
            seed: 0,
            extra: Extra::new(),
        }
    }
}

/// What fine colours are modelled on.
#[derive(Clone, Debug, PartialEq)]
pub enum DetailBy {
    /// Noise by the power law that the imagery itself follows around a place.
    Noise,
    /// Pieces of finer imagery that look like it.
    Examples {
        /// Imagery layers, hidden or not: the middle of each file shows what fine ground looks like.
        layers: Vec<LayerId>,
        /// How far a piece's mean colour may be from the imagery's, 0 to 2 (black to white is √3).
        /// Default [`DetailBy::TOLERANCE`].
        tolerance: f64,
    },
}

impl DetailBy {
    /// Most layers that are examples of one kind of detail.
    pub const MOST_EXAMPLES: usize = 16;
    /// Usual distance of colours up to which a piece is used as it is.
    pub const TOLERANCE: f64 = 0.15;
}
