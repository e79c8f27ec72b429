//! The node contract.

use std::any::Any;
use std::sync::Arc;

use relievo_planet::{Grid, SampleRect};
use relievo_raster::file::ReadError;
use relievo_raster::{Bands, Block, Cancel};

use crate::IdHasher;

/// What is known of a node's samples on a grid before any is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Nothing.
    Nothing,
    /// Every sample is there: a height is not NaN, a colour has alpha 1, a mask is 1.
    Complete,
    /// Every sample has this value (one entry a plane, the rest 0).
    Uniform([f32; 4]),
}

impl Known {
    /// Whether every sample is known to be absent: NaN height or alpha 0.
    pub fn is_absent(self, bands: Bands) -> bool {
        match (self, bands) {
            (Self::Uniform(v), Bands::Height) => v[0].is_nan(),
            (Self::Uniform(v), Bands::Colour) => v[3] == 0.0,
            (Self::Uniform(v), Bands::Mask) => v[0] == 0.0,
            _ => false,
        }
    }

    /// Whether every sample is known to be there: no NaN height, alpha 1, mask 1.
    pub fn is_complete(self, bands: Bands) -> bool {
        match (self, bands) {
            (Self::Complete, _) | (Self::Uniform(_), Bands::Normal) => true,
            (Self::Uniform(v), Bands::Height) => !v[0].is_nan(),
            (Self::Uniform(v), Bands::Colour) => v[3] == 1.0,
            (Self::Uniform(v), Bands::Mask) => v[0] == 1.0,
            (Self::Nothing, _) => false,
        }
    }

    /// The value that every sample has, if it is known.
    pub fn as_uniform(self) -> Option<[f32; 4]> {
        if let Self::Uniform(value) = self {
            Some(value)
        } else {
            None
        }
    }

    /// What is known of samples of which some are known as `self` and the others as `other`.
    #[must_use]
    pub fn and(self, other: Self, bands: Bands) -> Self {
        match (self, other) {
            (Self::Uniform(a), Self::Uniform(b)) if a.map(f32::to_bits) == b.map(f32::to_bits) => {
                self
            }
            _ if self.is_complete(bands) && other.is_complete(bands) => Self::Complete,
            _ => Self::Nothing,
        }
    }
}

/// One request to render.
pub struct Job<'a> {
    /// The samples to make.
    pub grid: &'a Grid,
    /// Asks to stop.
    pub cancel: &'a Cancel,
}

/// Why samples could not be made.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RenderError {
    /// Nobody wants them any more.
    #[error("cancelled")]
    Cancelled,
    /// A source could not be read.
    #[error(transparent)]
    Read(ReadError),
    /// A node cannot work with what it was given.
    #[error("{node}: {reason}")]
    Node {
        /// The node's kind.
        node: &'static str,
        /// Expected and found.
        reason: String,
    },
}

impl From<ReadError> for RenderError {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Cancelled => Self::Cancelled,
            other @ (ReadError::Io { .. } | ReadError::Damaged { .. }) => Self::Read(other),
        }
    }
}

/// A pure function from blocks of samples to a block of samples.
///
/// The shared laws (`core/graph/tests/laws.rs`) hold for every node: `required` and `invalidated` agree;
/// samples outside `required` do not matter; a whole equals its tiles bit for bit.
pub trait ImageNode: Send + Sync {
    /// Name of the kind, unique and stable: part of every content id.
    fn kind(&self) -> &'static str;

    /// Raised whenever the same parameters give other samples than before.
    fn version(&self) -> u32 {
        1
    }

    /// What the output's planes mean.
    fn output(&self) -> Bands;

    /// Whether output sample (i, j) depends on nothing but input samples (i, j): such nodes fuse.
    /// `required` and `invalidated` must then be the identity.
    fn is_pointwise(&self) -> bool;

    /// Samples of `input` that decide the output samples `out`.
    fn required(&self, input: usize, out: SampleRect) -> SampleRect {
        let _ = input;
        out
    }

    /// Output samples that may differ once the samples `changed` of `input` differ.
    fn invalidated(&self, input: usize, changed: SampleRect) -> SampleRect {
        let _ = input;
        changed
    }

    /// Adds every parameter that can touch the grid's samples; the grid itself too, as integers and
    /// step bits, when the node depends on position ([`IdHasher::grid`]). Names are asked for much
    /// more often than samples: hash long parameters once, when the node is made.
    fn identify(&self, grid: &Grid, id: &mut IdHasher);

    /// What is known of the output, given what is known of the inputs on their required samples.
    fn known(&self, grid: &Grid, inputs: &[Known]) -> Known {
        let _ = (grid, inputs);
        Known::Nothing
    }

    /// `Some(k)` if the output equals input k bit for bit on this grid: the node is then left out
    /// and costs nothing.
    fn identity(&self, grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let _ = (grid, inputs);
        None
    }

    /// Makes the samples `job.grid.rect` into `out`, which has their size and the node's bands.
    /// `inputs[k]` holds the samples `required(k, job.grid.rect)`.
    ///
    /// # Errors
    /// [`RenderError`]; `Cancelled` soon after `job.cancel` asks for it.
    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError>;

    /// What must have been made before the grid's samples can be: whatever depends on more than a
    /// tile's surroundings. Their names go into the id of what the node gives. For nodes that are not
    /// pointwise only.
    fn artefacts(&self, grid: &Grid) -> Vec<Arc<dyn Artefact>> {
        let _ = grid;
        Vec::new()
    }

    /// [`Self::render`] with what [`Self::artefacts`] named for the grid, in the same order.
    ///
    /// # Errors
    /// As [`Self::render`].
    fn render_from(
        &self,
        job: &Job,
        artefacts: &[Made],
        inputs: &[&Block],
        out: &mut Block,
    ) -> Result<(), RenderError> {
        let _ = artefacts;
        self.render(job, inputs, out)
    }
}

/// Something that was made once; the node that asked for it knows its type.
pub type Made = Arc<dyn Any + Send + Sync>;

/// Something that a node's tiles have in common and that is made once for all of them, from samples
/// on grids that it states itself: a solved infill, heights along a boundary.
///
/// A pure function of its parameters and of those samples, for every zoom the same.
pub trait Artefact: Send + Sync {
    /// Adds every parameter that can touch what is made.
    fn identify(&self, id: &mut IdHasher);

    /// The samples that decide it: the input's number, and where.
    fn reads(&self) -> Vec<(usize, Grid)>;

    /// Makes it from blocks of those samples in their order.
    ///
    /// # Errors
    /// [`RenderError`]; `Cancelled` soon after `cancel` asks for it.
    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError>;

    /// About how many bytes it takes once made.
    fn bytes(&self) -> usize;
}
