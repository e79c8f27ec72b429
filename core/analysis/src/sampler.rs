//! Heights at single places, read through blocks that are kept for a while.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, Lattice, LevelKey, MapPoint, SampleRect};

use crate::ground::{AnalysisError, Ground};
use crate::map_box::level_at;

/// Blocks that are kept: neighbours of a line of any direction.
const KEPT: usize = 48;

/// Heights at places: bilinear between the samples of the level that the data are worth, which are
/// those of the tiles too. The same place has the same height whatever was asked before.
pub struct Sampler<'a> {
    ground: &'a dyn Ground,
    /// Cells along a side of a block.
    block: i64,
    blocks: BTreeMap<(LevelKey, i64, i64), Arc<Vec<f32>>>,
    order: VecDeque<(LevelKey, i64, i64)>,
    lattices: BTreeMap<LevelKey, Arc<Lattice>>,
}

impl<'a> Sampler<'a> {
    /// A sampler for places that lie about `spacing_cells` cells of the data apart: many near places
    /// share blocks, far ones are read one by one.
    pub fn new(ground: &'a dyn Ground, spacing_cells: f64) -> Self {
        Self {
            ground,
            block: if spacing_cells > 24.0 { 1 } else { 64 },
            blocks: BTreeMap::new(),
            order: VecDeque::new(),
            lattices: BTreeMap::new(),
        }
    }

    /// Height in metres at a place, read at rows of level `n`; NaN where one of the four samples
    /// around it is.
    ///
    /// # Errors
    /// What [`Ground::heights`] returns.
    pub fn height_m(&mut self, place: MapPoint, n: u8) -> Result<f64, AnalysisError> {
        let place = place.normalised();
        let level = level_at(n, libm::sin(place.colat_rad));
        let at = level.sample_from_map(place) - 0.5;
        let corner = at.floor();
        let f = at - corner;
        let corner = corner.as_i64vec2();
        let block = corner.div_euclid(I64Vec2::splat(self.block));
        let heights = self.block(level, block)?;
        let local = corner - block * self.block;
        let width = self.block as usize + 1;
        let first = local.y as usize * width + local.x as usize;
        let h = |i: usize| f64::from(heights[i]);
        let north = h(first) + (h(first + 1) - h(first)) * f.x;
        let south = h(first + width) + (h(first + width + 1) - h(first + width)) * f.x;
        Ok(north + (south - north) * f.y)
    }

    fn block(&mut self, level: LevelKey, at: I64Vec2) -> Result<Arc<Vec<f32>>, AnalysisError> {
        let key = (level, at.x, at.y);
        if let Some(heights) = self.blocks.get(&key) {
            return Ok(Arc::clone(heights));
        }
        let lattice = self
            .lattices
            .entry(level)
            .or_insert_with(|| Arc::new(level.lattice()));
        let side = self.block + 1;
        let rect = SampleRect::at(at.x * self.block, at.y * self.block, side, side);
        let heights = Arc::new(self.ground.heights(&Grid::new(Arc::clone(lattice), rect))?);
        if self.order.len() >= KEPT
            && let Some(oldest) = self.order.pop_front()
        {
            self.blocks.remove(&oldest);
        }
        self.order.push_back(key);
        self.blocks.insert(key, Arc::clone(&heights));
        Ok(heights)
    }
}
