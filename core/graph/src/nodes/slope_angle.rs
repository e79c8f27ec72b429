//! The steepness of the ground, to be coloured.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// Angle of the surface against the horizontal in degrees, 0 to 90. Input: normals.
///
/// Given as heights, so that a [`Tint`](super::Tint) with stops in degrees colours it.
#[derive(Clone, Copy, Debug)]
pub struct SlopeAngle;

/// From the east and north component of a unit normal.
fn angle_deg(east: f32, north: f32) -> f32 {
    // The sine of the angle; rounding may take it past 1.
    let sine = (east * east + north * north).sqrt().min(1.0);
    libm::asinf(sine).to_degrees()
}

impl ImageNode for SlopeAngle {
    fn kind(&self) -> &'static str {
        "slope angle"
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
                Known::Uniform([angle_deg(east, north), 0.0, 0.0, 0.0])
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
            *angle = angle_deg(*east, *north);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_normal() {
        assert_eq!(angle_deg(0.0, 0.0), 0.0);
        for degrees in [0.01_f32, 1.0, 30.0, 45.0, 80.0] {
            let sine = libm::sinf(degrees.to_radians());
            for (east, north) in [(sine, 0.0), (0.0, -sine), (0.6 * sine, 0.8 * sine)] {
                assert!((angle_deg(east, north) - degrees).abs() < 1e-3 * degrees.max(0.1));
            }
        }
        assert_eq!(angle_deg(1.0, 1.0), 90.0);
    }
}
