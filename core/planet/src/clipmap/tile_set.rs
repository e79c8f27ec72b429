//! Sets of tiles of one window.

use glam::I64Vec2;

use super::window::Window;
use crate::{SampleRect, TILE_SAMPLES};

/// Some of the tiles that a window touches: one bit a tile, rows first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileSet {
    /// Unwrapped tile indices of the first bit.
    first: I64Vec2,
    columns: i64,
    rows: i64,
    bits: Vec<u64>,
}

impl TileSet {
    /// The empty set of a window's tiles.
    pub fn none_of(window: &Window) -> Self {
        let tiles = tiles_of(&window.rect);
        let bits = (tiles.width() * tiles.height()) as usize;
        Self {
            first: tiles.min,
            columns: tiles.width(),
            rows: tiles.height(),
            bits: vec![0; bits.div_ceil(64)],
        }
    }

    /// Adds all tiles that a rectangle of samples (in the window's unwrapped indices) touches; parts
    /// outside the window's tiles are left out.
    pub fn insert(&mut self, samples: &SampleRect) {
        if samples.is_empty() {
            return;
        }
        let all = SampleRect::at(self.first.x, self.first.y, self.columns, self.rows);
        let tiles = tiles_of(samples).intersection(&all).shift(-self.first);
        for row in tiles.min.y..tiles.max.y {
            for column in tiles.min.x..tiles.max.x {
                let bit = (row * self.columns + column) as usize;
                self.bits[bit / 64] |= 1 << (bit % 64);
            }
        }
    }

    /// Whether it holds the tile with this rectangle (in the window's unwrapped indices).
    pub fn contains(&self, tile: &SampleRect) -> bool {
        let at = tile.min.div_euclid(I64Vec2::splat(TILE_SAMPLES)) - self.first;
        let inside = at.cmpge(I64Vec2::ZERO).all() && at.x < self.columns && at.y < self.rows;
        inside && {
            let bit = (at.y * self.columns + at.x) as usize;
            self.bits[bit / 64] & (1 << (bit % 64)) != 0
        }
    }

    /// Number of tiles in it.
    pub fn len(&self) -> usize {
        self.bits.iter().map(|b| b.count_ones() as usize).sum()
    }

    /// Whether no tile is in it.
    pub fn is_empty(&self) -> bool {
        self.bits.iter().all(|b| *b == 0)
    }
}

/// The tile indices that a rectangle of samples touches.
fn tiles_of(samples: &SampleRect) -> SampleRect {
    let tile = I64Vec2::splat(TILE_SAMPLES);
    SampleRect::new(
        samples.min.div_euclid(tile),
        (samples.max + (TILE_SAMPLES - 1)).div_euclid(tile),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LevelKey, MapPoint};

    #[test]
    fn a_set_holds_the_tiles_that_a_rectangle_touches_and_no_others() {
        // Across the antimeridian, where unwrapped columns leave the level.
        let level = LevelKey::new(8, 7);
        let window = Window::place(level, MapPoint::from_degrees(179.9, 20.0), 1024);
        let mut set = TileSet::none_of(&window);
        assert!(set.is_empty());
        let tiles: Vec<SampleRect> = window.tiles().map(|(_, rect)| rect).collect();
        let some = SampleRect::new(tiles[1].min + 200, tiles[1].max + 1);
        set.insert(&some);
        for tile in &tiles {
            assert_eq!(set.contains(tile), tile.overlaps(&some), "{tile:?}");
        }
        assert_eq!(
            set.len(),
            tiles.iter().filter(|t| t.overlaps(&some)).count()
        );
    }

    #[test]
    fn what_lies_outside_the_window_is_left_out() {
        let window = Window::place(LevelKey::new(8, 7), MapPoint::from_degrees(0.0, 0.0), 256);
        let mut set = TileSet::none_of(&window);
        set.insert(&window.rect.grow(100_000));
        assert_eq!(set.len(), window.tiles().count());
        let beyond = window.rect.shift((TILE_SAMPLES * 50, 0).into());
        assert!(!set.contains(&beyond));
    }
}
