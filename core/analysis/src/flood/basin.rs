//! Samples under water, tile by tile as the water reaches them.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, Lattice, LevelKey, SampleRect};

use super::water::Water;
use crate::ground::{AnalysisError, Ground, Watch, go_on};

/// Samples along a side of a tile.
pub(super) const TILE: i64 = 128;

/// Samples of a tile.
const SAMPLES: usize = (TILE * TILE) as usize;

struct Tile {
    heights: Vec<f32>,
    /// One bit a sample.
    wet: Vec<u64>,
}

impl Tile {
    fn is_wet(&self, index: usize) -> bool {
        self.wet[index / 64] >> (index % 64) & 1 == 1
    }
}

pub(super) struct Basin<'a> {
    ground: &'a dyn Ground,
    level: LevelKey,
    lattice: Arc<Lattice>,
    level_m: f64,
    max_tiles: usize,
    tiles: BTreeMap<(i64, i64), Tile>,
}

impl<'a> Basin<'a> {
    pub(super) fn new(
        ground: &'a dyn Ground,
        level: LevelKey,
        level_m: f64,
        max_samples: u64,
    ) -> Self {
        Self {
            ground,
            level,
            lattice: Arc::new(level.lattice()),
            level_m,
            max_tiles: (max_samples / SAMPLES as u64).max(4) as usize,
            tiles: BTreeMap::new(),
        }
    }

    /// Height of a sample inside the level.
    pub(super) fn height_m(&mut self, node: I64Vec2) -> Result<f32, AnalysisError> {
        let (key, index) = place(node);
        Ok(self.tile(key)?.heights[index])
    }

    /// Whether the water has reached a sample inside the level.
    pub(super) fn is_wet(&self, node: I64Vec2) -> bool {
        let (key, index) = place(node);
        self.tiles.get(&key).is_some_and(|tile| tile.is_wet(index))
    }

    /// All samples under water, in the order of their tiles.
    pub(super) fn wet_nodes(&self) -> Vec<I64Vec2> {
        let mut nodes = Vec::new();
        for ((row, column), tile) in &self.tiles {
            let first = I64Vec2::new(*column, *row) * TILE;
            for index in (0..SAMPLES).filter(|index| tile.is_wet(*index)) {
                let index = index as i64;
                nodes.push(first + I64Vec2::new(index % TILE, index / TILE));
            }
        }
        nodes
    }

    /// What is under water.
    pub(super) fn water(self) -> Water {
        let depths = |tile: Tile| -> Vec<f32> {
            let mut depths = tile.heights;
            for (index, depth) in depths.iter_mut().enumerate() {
                let is_wet = tile.wet[index / 64] >> (index % 64) & 1 == 1;
                *depth = if is_wet {
                    (self.level_m - f64::from(*depth)) as f32
                } else {
                    f32::NAN
                };
            }
            depths
        };
        let wet = self.tiles.into_iter();
        let wet = wet.filter(|(_, tile)| tile.wet.iter().any(|bits| *bits != 0));
        Water::new(
            self.level,
            wet.map(|(key, tile)| (key, depths(tile))).collect(),
        )
    }

    /// Colatitude of the middle of the water's northernmost tile.
    pub(super) fn colat_rad(&self) -> f64 {
        let row = self
            .tiles
            .keys()
            .next()
            .map_or(0, |(row, _)| row * TILE + TILE / 2);
        self.lattice.centre(I64Vec2::new(0, row)).y
    }

    /// Lets water in at a sample.
    pub(super) fn fill(&mut self, seed: I64Vec2, watch: &dyn Watch) -> Result<(), AnalysisError> {
        let (key, index) = place(seed);
        // Samples at which water enters a tile, by tile.
        let mut entries: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
        entries.insert(key, vec![index as u32]);
        while let Some((key, starts)) = entries.pop_first() {
            go_on(watch)?;
            let share = self.tiles.len() as f64 / self.max_tiles as f64;
            watch.progress((0.7 * share).min(0.7));
            for node in self.fill_tile(key, starts)? {
                let (next, index) = place(node);
                entries.entry(next).or_default().push(index as u32);
            }
        }
        Ok(())
    }

    /// Fills a tile from where water enters; returns the samples of other tiles that it
    /// reaches.
    fn fill_tile(
        &mut self,
        key: (i64, i64),
        mut open: Vec<u32>,
    ) -> Result<Vec<I64Vec2>, AnalysisError> {
        let level_m = self.level_m;
        let level = self.level;
        let tile = self.tile(key)?;
        let first = I64Vec2::new(key.1, key.0) * TILE;
        let mut beyond = Vec::new();
        while let Some(index) = open.pop() {
            let at = index as usize;
            if tile.is_wet(at)
                || tile.heights[at].is_nan()
                || f64::from(tile.heights[at]) >= level_m
            {
                continue;
            }
            tile.wet[at / 64] |= 1 << (at % 64);
            let local = I64Vec2::new(i64::from(index) % TILE, i64::from(index) / TILE);
            for step in [I64Vec2::X, I64Vec2::NEG_X, I64Vec2::Y, I64Vec2::NEG_Y] {
                let next = local + step;
                if next.cmpge(I64Vec2::ZERO).all() && next.cmplt(I64Vec2::splat(TILE)).all() {
                    open.push((next.y * TILE + next.x) as u32);
                } else {
                    // A tile that is its own neighbour, on the coarsest levels, goes on by itself.
                    let node = level.wrap_sample(first + next);
                    let (there, index) = place(node);
                    if there == key {
                        open.push(index as u32);
                    } else {
                        beyond.push(node);
                    }
                }
            }
        }
        Ok(beyond)
    }

    fn tile(&mut self, key: (i64, i64)) -> Result<&mut Tile, AnalysisError> {
        if !self.tiles.contains_key(&key) {
            if self.tiles.len() >= self.max_tiles {
                return Err(AnalysisError::Refused(format!(
                    "expected water of at most {} samples, found it spread farther at {} m: lower the level or flood a place that is enclosed",
                    self.max_tiles * SAMPLES,
                    self.level_m
                )));
            }
            let rect = SampleRect::at(key.1 * TILE, key.0 * TILE, TILE, TILE);
            let heights = self
                .ground
                .heights(&Grid::new(Arc::clone(&self.lattice), rect))?;
            let tile = Tile {
                heights,
                wet: vec![0; SAMPLES / 64],
            };
            self.tiles.insert(key, tile);
        }
        Ok(self.tiles.get_mut(&key).expect("inserted above"))
    }
}

/// A sample's tile (row, column) and place in it.
fn place(node: I64Vec2) -> ((i64, i64), usize) {
    let tile = node.div_euclid(I64Vec2::splat(TILE));
    let local = node - tile * TILE;
    ((tile.y, tile.x), (local.y * TILE + local.x) as usize)
}
