//! Vector features as colours.

use std::sync::Arc;

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};
use relievo_vector::Drawing;
use relievo_vector::draw::DrawError;

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// Features in a style. No inputs; transparent beside them.
///
/// Its name on a grid hashes only the features that may show there, strokes included, so that an
/// edit of one feature makes only the tiles again that show it; where none does, the node is
/// uniform and costs nothing.
#[derive(Clone, Debug)]
pub struct Vector {
    drawing: Arc<Drawing>,
}

impl Vector {
    /// Draws what the drawing holds.
    pub fn new(drawing: Arc<Drawing>) -> Self {
        Self { drawing }
    }

    /// The features and their style.
    pub fn drawing(&self) -> &Arc<Drawing> {
        &self.drawing
    }
}

impl ImageNode for Vector {
    fn kind(&self) -> &'static str {
        "vector"
    }

    fn version(&self) -> u32 {
        2
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.bytes(&self.drawing.fingerprint(grid)).grid(grid);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        if self.drawing.reaches(grid) {
            Known::Nothing
        } else {
            Known::Uniform([0.0; 4])
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let drawn = self.drawing.render(job.grid, out, job.cancel);
        drawn.map_err(|error| match error {
            DrawError::Cancelled => RenderError::Cancelled,
            DrawError::Grid(reason) => RenderError::Node {
                node: "vector",
                reason,
            },
        })
    }
}
