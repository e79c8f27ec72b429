//! Samples held in memory.

use std::sync::Arc;

use relievo_planet::{Grid, Lattice, SampleRect};
use relievo_raster::{Bands, Block};

use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

/// A source that gives the nearest of the samples it holds, absent (NaN, alpha 0, mask 0, level
/// normal) beyond them: small masks, pasted pieces, tests.
///
/// It works on every lattice of its own plane; on others it gives nothing.
#[derive(Clone, Debug)]
pub struct Memory {
    lattice: Arc<Lattice>,
    rect: SampleRect,
    samples: Arc<Block>,
    name: ContentId,
}

impl Memory {
    /// Holds the samples `grid.rect` of `grid.lattice`.
    ///
    /// # Panics
    /// If the block has another size than the rectangle.
    pub fn new(grid: &Grid, samples: Block) -> Self {
        let size = (samples.width() as i64, samples.height() as i64);
        assert_eq!(
            size,
            (grid.rect.width(), grid.rect.height()),
            "a sample for each place"
        );
        let mut id = IdHasher::default();
        id.lattice(&grid.lattice);
        for corner in [grid.rect.min, grid.rect.max] {
            id.int(corner.x).int(corner.y);
        }
        id.int(samples.bands() as i64);
        for v in samples.samples() {
            id.float(f64::from(*v));
        }
        Self {
            lattice: Arc::clone(&grid.lattice),
            rect: grid.rect,
            samples: Arc::new(samples),
            name: id.finish(),
        }
    }

    fn absent(&self) -> f32 {
        if self.samples.bands() == Bands::Height {
            f32::NAN
        } else {
            0.0
        }
    }

    /// Places of the held samples along one axis, for indices `range` of the grid's lattice.
    fn places(
        &self,
        axis: usize,
        lattice: &Lattice,
        range: core::ops::Range<i64>,
    ) -> Vec<Option<usize>> {
        let own = &self.lattice;
        let around = own.columns_around.filter(|_| axis == 0);
        let (min, max) = (self.rect.min[axis], self.rect.max[axis]);
        range
            .map(|i| {
                let plane = lattice.origin[axis] + (i as f64 + 0.5) * lattice.step[axis];
                let mut index = libm::floor((plane - own.origin[axis]) / own.step[axis]) as i64;
                if let Some(columns) = around {
                    index = (index - min).rem_euclid(columns) + min;
                }
                (min..max).contains(&index).then(|| (index - min) as usize)
            })
            .collect()
    }
}

/// Adds a grid: its lattice and its rectangle.
pub(crate) fn add_grid(grid: &Grid, id: &mut IdHasher) {
    id.grid(grid);
}

impl ImageNode for Memory {
    fn kind(&self) -> &'static str {
        "memory"
    }

    fn output(&self) -> Bands {
        self.samples.bands()
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        let absent = Known::Uniform([self.absent(), 0.0, 0.0, 0.0]);
        if grid.lattice.crs != self.lattice.crs {
            return absent;
        }
        let columns = self.places(0, &grid.lattice, grid.rect.min.x..grid.rect.max.x);
        let rows = self.places(1, &grid.lattice, grid.rect.min.y..grid.rect.max.y);
        if [columns, rows]
            .iter()
            .any(|places| places.iter().all(Option::is_none))
        {
            absent
        } else {
            Known::Nothing
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let rect = job.grid.rect;
        let absent = self.absent();
        if job.grid.lattice.crs != self.lattice.crs {
            out.samples_mut().fill(absent);
            return Ok(());
        }
        let columns = self.places(0, &job.grid.lattice, rect.min.x..rect.max.x);
        let rows = self.places(1, &job.grid.lattice, rect.min.y..rect.max.y);
        let width = self.samples.width();
        for plane in 0..out.bands().planes() {
            let held = self.samples.plane(plane);
            let row_length = columns.len().max(1);
            for (line, row) in out.plane_mut(plane).chunks_exact_mut(row_length).zip(&rows) {
                for (v, column) in line.iter_mut().zip(&columns) {
                    *v = match (row, column) {
                        (Some(y), Some(x)) => held[y * width + x],
                        _ => absent,
                    };
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use relievo_planet::LevelKey;
    use relievo_raster::Cancel;

    use super::*;

    #[test]
    fn a_finer_lattice_repeats_the_nearest_sample_and_ends_where_samples_end() {
        let coarse = Grid::new(
            Arc::new(LevelKey::new(0, 0).lattice()),
            SampleRect::at(3, 4, 2, 1),
        );
        let mut samples = Block::new(Bands::Height, 2, 1);
        samples.samples_mut().copy_from_slice(&[7.0, 8.0]);
        let node = Memory::new(&coarse, samples);
        let fine = Grid::new(
            Arc::new(LevelKey::new(1, 0).lattice()),
            SampleRect::at(5, 4, 6, 1),
        );
        let mut out = Block::new(Bands::Height, 6, 1);
        node.render(
            &Job {
                grid: &fine,
                cancel: &Cancel::default(),
            },
            &[],
            &mut out,
        )
        .unwrap();
        assert!(out.samples()[0].is_nan() && out.samples()[5].is_nan());
        assert_eq!(out.samples()[1..5], [7.0, 7.0, 8.0, 8.0]);
    }
}
