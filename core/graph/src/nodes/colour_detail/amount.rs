//! Where detail of colours is added.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use super::ColourDetail;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// 1 on lattices on which a [`ColourDetail`] adds something to colours that are there, 0 on those that
/// the imagery itself is fine enough for. No inputs.
#[derive(Clone, Debug)]
pub struct ColourDetailAmount(ColourDetail);

impl ColourDetail {
    /// Where this adds something.
    pub fn amount(&self) -> ColourDetailAmount {
        ColourDetailAmount(self.clone())
    }
}

impl ColourDetailAmount {
    fn value(&self, grid: &Grid) -> f32 {
        f32::from(u8::from(self.0.nesting(grid).is_some()))
    }
}

impl ImageNode for ColourDetailAmount {
    fn kind(&self) -> &'static str {
        "colour detail amount"
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.float(f64::from(self.value(grid)));
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        Known::Uniform([self.value(grid), 0.0, 0.0, 0.0])
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        out.plane_mut(0).fill(self.value(job.grid));
        Ok(())
    }
}
