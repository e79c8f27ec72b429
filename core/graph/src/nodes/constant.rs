//! The same sample everywhere.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// A source that gives one value everywhere: a base height, a background colour.
#[derive(Clone, Copy, Debug)]
pub struct Constant {
    bands: Bands,
    value: [f32; 4],
}

impl Constant {
    /// One height in metres; NaN for none.
    pub fn height(height_m: f32) -> Self {
        Self {
            bands: Bands::Height,
            value: [height_m, 0.0, 0.0, 0.0],
        }
    }

    /// One straight, display-referred colour; where alpha is 0 it is nothing.
    pub fn colour(rgba: [f32; 4]) -> Self {
        Self {
            bands: Bands::Colour,
            value: if rgba[3] > 0.0 { rgba } else { [0.0; 4] },
        }
    }

    /// One weight, 0 to 1.
    pub fn mask(weight: f32) -> Self {
        Self {
            bands: Bands::Mask,
            value: [weight, 0.0, 0.0, 0.0],
        }
    }
}

impl ImageNode for Constant {
    fn kind(&self) -> &'static str {
        "constant"
    }

    fn output(&self) -> Bands {
        self.bands
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.int(self.bands.planes() as i64);
        for v in self.value {
            id.float(f64::from(v));
        }
    }

    fn known(&self, _grid: &Grid, _inputs: &[Known]) -> Known {
        Known::Uniform(self.value)
    }

    fn render(&self, _job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        for (plane, v) in self.value.into_iter().enumerate().take(self.bands.planes()) {
            out.plane_mut(plane).fill(v);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transparent_colour_is_nothing() {
        let node = Constant::colour([0.5, 0.5, 0.5, 0.0]);
        let grid = relievo_planet::TileKey::new(relievo_planet::LevelKey::new(1, 0), 0, 0)
            .unwrap()
            .grid();
        assert_eq!(node.known(&grid, &[]), Known::Uniform([0.0; 4]));
    }
}
