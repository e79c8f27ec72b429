//! How much higher one ground is than another.

use std::sync::Arc;

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use super::Earthwork;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// `height = a − b` in metres; NaN (nodata) where either is.
///
/// Inputs: heights a, heights b.
#[derive(Clone, Default)]
pub struct HeightDifference {
    /// What made a and b of the same ground.
    elements: Option<[Option<Arc<Earthwork>>; 2]>,
}

impl HeightDifference {
    /// Of any two heights.
    pub fn new() -> Self {
        Self::default()
    }

    /// Of heights that planning elements made of one and the same ground (`None`: left as it is).
    /// Where the same elements act on both, the difference is known to be 0, and whatever follows
    /// costs nothing there.
    pub fn of_elements(a: Option<Arc<Earthwork>>, b: Option<Arc<Earthwork>>) -> Self {
        Self {
            elements: Some([a, b]),
        }
    }

    /// Whether the same elements act on both.
    fn is_same(&self, grid: &Grid) -> bool {
        let Some([a, b]) = &self.elements else {
            return false;
        };
        let (a, b) = (acting(a.as_deref(), grid), acting(b.as_deref(), grid));
        a == b
    }
}

/// The prepared elements that act on a grid, by their addresses.
fn acting(earthwork: Option<&Earthwork>, grid: &Grid) -> Vec<usize> {
    let Some(earthwork) = earthwork else {
        return Vec::new();
    };
    let elements = earthwork.elements();
    let address = |i: &u32| Arc::as_ptr(&elements[*i as usize]).addr();
    earthwork.touching(grid).iter().map(address).collect()
}

impl ImageNode for HeightDifference {
    fn kind(&self) -> &'static str {
        "height difference"
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, _id: &mut IdHasher) {}

    fn known(&self, grid: &Grid, inputs: &[Known]) -> Known {
        let complete = inputs.iter().all(|i| i.is_complete(Bands::Height));
        match (inputs[0], inputs[1]) {
            (Known::Uniform(a), Known::Uniform(b)) => Known::Uniform([a[0] - b[0], 0.0, 0.0, 0.0]),
            _ if complete && self.is_same(grid) => Known::Uniform([0.0; 4]),
            _ if complete => Known::Complete,
            _ => Known::Nothing,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let (a, b) = (inputs[0].samples(), inputs[1].samples());
        for ((h, a), b) in out.samples_mut().iter_mut().zip(a).zip(b) {
            *h = a - b;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use relievo_planet::{LevelKey, SampleRect};

    use super::*;

    #[test]
    fn heights_that_nothing_tells_apart_differ_by_nothing_and_holes_stay_holes() {
        let grid = Grid::new(
            Arc::new(LevelKey::new(1, 0).lattice()),
            SampleRect::at(0, 0, 1, 1),
        );
        let node = HeightDifference::of_elements(None, None);
        let known = node.known(&grid, &[Known::Complete, Known::Complete]);
        assert_eq!(known.as_uniform(), Some([0.0; 4]));
        assert_eq!(
            node.known(&grid, &[Known::Nothing, Known::Complete]),
            Known::Nothing,
            "a hole in the ground is no difference of 0"
        );
        let any = HeightDifference::new();
        let known = any.known(&grid, &[Known::Complete, Known::Complete]);
        assert_eq!(known, Known::Complete);
        let known = any.known(
            &grid,
            &[Known::Uniform([f32::NAN; 4]), Known::Uniform([1.0; 4])],
        );
        assert!(known.is_absent(Bands::Height));
    }
}
