//! A mask by where a source's outline lies.

use std::sync::Arc;

use relievo_planet::Grid;
use relievo_raster::edge::EdgeDistance;
use relievo_raster::warp::{Coverage, Warp};
use relievo_raster::{Bands, Block};

use super::edge_distances::place_name;
use super::memory::add_grid;
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "outline mask";

/// 1 inside a file's outline, whether it has data there or not, 0 outside. No inputs.
#[derive(Debug)]
pub struct OutlineMask {
    warp: Arc<Warp>,
    name: ContentId,
    distance: EdgeDistance,
}

impl OutlineMask {
    /// Of the file behind a geometry.
    pub fn new(warp: Arc<Warp>) -> Self {
        let distance = EdgeDistance::to_outline(&warp);
        let name = place_name(&warp);
        Self {
            warp,
            name,
            distance,
        }
    }
}

impl ImageNode for OutlineMask {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        match self.warp.coverage(grid) {
            Coverage::Outside => Known::Uniform([0.0; 4]),
            Coverage::Inside => Known::Uniform([1.0, 0.0, 0.0, 0.0]),
            Coverage::Partial => Known::Nothing,
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let distances = self.distance.distances_m(&self.warp, job.grid);
        let distances = distances.map_err(|error| RenderError::Node {
            node: KIND,
            reason: error.to_string(),
        })?;
        for (weight, distance) in out.plane_mut(0).iter_mut().zip(distances.plane(0)) {
            *weight = f32::from(u8::from(*distance > 0.0));
        }
        Ok(())
    }
}
