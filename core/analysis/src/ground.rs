//! What analyses ask of a ground, and how they are watched and stopped.

use relievo_planet::{Grid, Planet};

use crate::map_box::MapBox;

/// Heights of one planet, evaluated wherever they are asked for.
pub trait Ground: Sync {
    /// The planet's figure.
    fn planet(&self) -> Planet;

    /// Finest level n of the tile grid that some data inside `area` are worth: the spacing of its
    /// samples is the data's own.
    fn finest_level(&self, area: &MapBox) -> u8;

    /// Heights in metres at the centres of a grid's samples, row by row; NaN where there are none.
    /// On the lattice of a level, columns beyond its ends wrap and rows reflect over the poles.
    ///
    /// # Errors
    /// [`AnalysisError::Ground`] when they cannot be made, [`AnalysisError::Cancelled`] when
    /// somebody asked to stop meanwhile.
    fn heights(&self, grid: &Grid) -> Result<Vec<f32>, AnalysisError>;
}

/// Somebody who waits for an analysis.
pub trait Watch: Sync {
    /// Whether the work should stop; asked many times a second.
    fn is_cancelled(&self) -> bool;

    /// Told the part that is done, 0 to 1, from whichever thread did it.
    fn progress(&self, share: f64);
}

/// Nobody waits, nobody stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn is_cancelled(&self) -> bool {
        false
    }

    fn progress(&self, _share: f64) {}
}

/// An error if the watch asks to stop.
pub(crate) fn go_on(watch: &dyn Watch) -> Result<(), AnalysisError> {
    if watch.is_cancelled() {
        return Err(AnalysisError::Cancelled);
    }
    Ok(())
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The request makes no sense or exceeds a limit: what was expected, what was found.
    #[error("{0}")]
    Refused(String),
    /// The ground could not be evaluated.
    #[error("{0}")]
    Ground(#[source] Box<dyn core::error::Error + Send + Sync>),
}
