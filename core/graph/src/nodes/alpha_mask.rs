//! A mask by what colours cover.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// The alpha of colours: what drawn features cover. Input: colours.
#[derive(Clone, Copy, Debug)]
pub struct AlphaMask;

impl ImageNode for AlphaMask {
    fn kind(&self) -> &'static str {
        "alpha mask"
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, _id: &mut IdHasher) {}

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform([.., alpha]) => Known::Uniform([alpha, 0.0, 0.0, 0.0]),
            Known::Complete => Known::Complete,
            Known::Nothing => Known::Nothing,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        out.plane_mut(0).copy_from_slice(inputs[0].plane(3));
        Ok(())
    }
}
