//! The steepness of the ground, to be coloured.

use relievo_planet::Grid;
use relievo_raster::normal::slope_rad;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// Angle of the surface against the horizontal in degrees, 0 to 90. Input: normals.
///
/// Given as heights, so that a [`Tint`](super::Tint) with stops in degrees colours it.
#[derive(Clone, Copy, Debug)]
pub struct SlopeAngle;

impl ImageNode for SlopeAngle {
    fn kind(&self) -> &'static str {
        "slope angle"
    }

    fn version(&self) -> u32 {
        2
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, _id: &mut IdHasher) {}

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform([east, north, ..]) => {
                Known::Uniform([slope_rad([east, north]).to_degrees(), 0.0, 0.0, 0.0])
            }
            // Normals are everywhere.
            Known::Complete | Known::Nothing => Known::Complete,
        }
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        if job.cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        let (east, north) = (inputs[0].plane(0), inputs[0].plane(1));
        let samples = out.plane_mut(0).iter_mut().zip(east.iter().zip(north));
        for (angle, (east, north)) in samples {
            *angle = slope_rad([*east, *north]).to_degrees();
        }
        Ok(())
    }
}
