//! Masks that hold together.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// The product of masks: what all of them show; or the rest of it. Inputs: masks.
#[derive(Clone, Copy, Debug)]
pub struct MaskProduct {
    count: usize,
    inverted: bool,
}

impl MaskProduct {
    /// Of so many masks; `inverted` gives 1 − the product. Of none the product is 1.
    pub fn new(count: usize, inverted: bool) -> Self {
        Self { count, inverted }
    }

    fn turned(self, product: f32) -> f32 {
        if self.inverted {
            1.0 - product
        } else {
            product
        }
    }
}

impl ImageNode for MaskProduct {
    fn kind(&self) -> &'static str {
        "mask product"
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.int(self.count as i64).int(i64::from(self.inverted));
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        let uniform = |v: f32| Known::Uniform([self.turned(v), 0.0, 0.0, 0.0]);
        if inputs.iter().any(|i| i.is_absent(Bands::Mask)) {
            return uniform(0.0);
        }
        if inputs.iter().all(|i| i.is_complete(Bands::Mask)) {
            return uniform(1.0);
        }
        let values: Option<Vec<f32>> = inputs
            .iter()
            .map(|i| i.as_uniform().map(|v| v[0]))
            .collect();
        values.map_or(Known::Nothing, |values| uniform(values.iter().product()))
    }

    fn identity(&self, _grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let mut partial = (0..inputs.len()).filter(|i| !inputs[*i].is_complete(Bands::Mask));
        match (self.inverted, partial.next(), partial.next()) {
            (false, Some(only), None) => Some(only),
            _ => None,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        for (i, product) in out.plane_mut(0).iter_mut().enumerate() {
            let all = inputs.iter().map(|input| input.plane(0)[i]).product();
            *product = self.turned(all);
        }
        Ok(())
    }
}
