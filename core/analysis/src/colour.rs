//! Colours of one picture against those of another: differences as an eye sees them, and what makes one
//! look like the other.

pub mod balance;
mod ciede2000;
mod fit;
mod ground;
mod lab;
mod map;
mod robust;

pub use balance::{Balance, BalanceError, MOST_PICTURES, Overlap, balance};
pub use ciede2000::ciede2000;
pub use fit::{ColourChange, ColourFit, FIT_BINS, FitHistograms, MatchMethod};
pub use ground::{CommonGround, Difference, FEWEST_PAIRS, TooFewPairs};
pub use lab::Lab;
pub use map::ColourMap;

/// Colours of one place in two pictures: display values (sRGB encoded), 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourPair {
    /// In the picture that is to change.
    pub from: [f32; 3],
    /// In the one that it is to look like.
    pub to: [f32; 3],
}
