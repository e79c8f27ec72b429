//! Detail added to heights.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// `height = base + detail`, both in metres; NaN (nodata) in either gives the base.
///
/// Inputs: base heights, detail heights (noise).
#[derive(Clone, Copy, Debug, Default)]
pub struct AddHeights;

impl ImageNode for AddHeights {
    fn kind(&self) -> &'static str {
        "add heights"
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, _id: &mut IdHasher) {}

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match (inputs[0], inputs[1]) {
            (Known::Uniform(base), Known::Uniform(detail)) => {
                Known::Uniform([sum(base[0], detail[0]), 0.0, 0.0, 0.0])
            }
            (base, _) if base.is_complete(Bands::Height) => Known::Complete,
            _ => Known::Nothing,
        }
    }

    fn identity(&self, _grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let nothing = inputs[1]
            .as_uniform()
            .is_some_and(|v| v[0] == 0.0 || v[0].is_nan());
        (nothing || inputs[0].is_absent(Bands::Height)).then_some(0)
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let (base, detail) = (inputs[0].samples(), inputs[1].samples());
        for ((h, b), d) in out.samples_mut().iter_mut().zip(base).zip(detail) {
            *h = sum(*b, *d);
        }
        Ok(())
    }
}

/// A detail of nothing leaves every bit of the base, also of −0.
#[inline]
fn sum(base: f32, detail: f32) -> f32 {
    if detail == 0.0 || detail.is_nan() {
        base
    } else {
        base + detail
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_in_the_detail_keeps_the_ground_and_a_hole_in_the_ground_stays() {
        assert_eq!(sum(5.0, f32::NAN), 5.0);
        assert!(sum(f32::NAN, 5.0).is_nan());
        assert_eq!(sum(5.0, -1.5), 3.5);
    }
}
