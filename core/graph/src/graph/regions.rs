//! Where the samples of a rectangle come from: around the planet, over the poles, tile by tile.
//!
//! The one border policy: on a lattice that closes upon itself columns wrap and rows reflect over
//! the poles onto the opposite meridian, by index, so that a sample has the same bits wherever it
//! is read from. On other lattices a rectangle is what it says.

use core::f64::consts::PI;

use relievo_planet::{Lattice, LevelKey, SampleRect, TILE_SAMPLES, TileKey};
use relievo_raster::{Bands, Block, Tile};

/// A part of a rectangle that comes from one piece of the lattice's extent, in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    /// The piece: a tile of the level, or just the samples needed.
    pub(super) piece: SampleRect,
    /// First column and row needed, relative to the piece.
    pub(super) from: (usize, usize),
    /// Where they go, relative to the rectangle.
    pub(super) to: (usize, usize),
    /// Columns and rows.
    pub(super) size: (usize, usize),
    /// Whether they lie beyond a pole: rows run backwards, east is west and north is south.
    pub(super) over_pole: bool,
}

/// The regions of `rect`, which may lie anywhere; pieces are tiles when `level` is given.
pub(super) fn regions(
    lattice: &Lattice,
    level: Option<LevelKey>,
    rect: &SampleRect,
) -> Vec<Region> {
    if rect.is_empty() {
        return Vec::new();
    }
    let Some(columns) = lattice.columns_around else {
        let size = (rect.width() as usize, rect.height() as usize);
        return vec![Region {
            piece: *rect,
            from: (0, 0),
            to: (0, 0),
            size,
            over_pole: false,
        }];
    };
    let rows = (PI / lattice.step.y.abs()).round().max(1.0) as i64;
    let side = if level.is_some() {
        TILE_SAMPLES
    } else {
        i64::MAX
    };
    let mut all = Vec::new();
    let mut y = rect.min.y;
    while y < rect.max.y {
        let phase = y.rem_euclid(2 * rows);
        let over_pole = phase >= rows;
        // The extent's row that comes first in the rectangle; beyond a pole the next ones lie above.
        let row = if over_pole {
            2 * rows - 1 - phase
        } else {
            phase
        };
        let until_end = if over_pole {
            row % side + 1
        } else {
            (side - row % side).min(rows - row)
        };
        let height = until_end.min(rect.max.y - y);
        let first_row = if over_pole { row + 1 - height } else { row };
        let mut x = rect.min.x;
        while x < rect.max.x {
            let column = (x + if over_pole { columns / 2 } else { 0 }).rem_euclid(columns);
            let width = (side - column % side)
                .min(columns - column)
                .min(rect.max.x - x);
            let piece = if level.is_some() {
                SampleRect::at(column / side * side, first_row / side * side, side, side)
            } else {
                SampleRect::at(column, first_row, width, height)
            };
            all.push(Region {
                piece,
                from: (
                    (column - piece.min.x) as usize,
                    (first_row - piece.min.y) as usize,
                ),
                to: ((x - rect.min.x) as usize, (y - rect.min.y) as usize),
                size: (width as usize, height as usize),
                over_pole,
            });
            x += width;
        }
        y += height;
    }
    all
}

/// The tile that a piece is.
pub(super) fn tile_key(level: LevelKey, piece: &SampleRect) -> TileKey {
    TileKey::new(
        level,
        piece.min.x / TILE_SAMPLES,
        piece.min.y / TILE_SAMPLES,
    )
    .expect("pieces are tiles of the level")
}

impl Region {
    /// Whether it is one piece as it stands, for a rectangle of the same size.
    pub(super) fn is_whole(&self, rect: &SampleRect) -> bool {
        !self.over_pole && self.to == (0, 0) && self.from == (0, 0) && {
            let size = (rect.width(), rect.height());
            size == (self.size.0 as i64, self.size.1 as i64)
                && size == (self.piece.width(), self.piece.height())
        }
    }

    /// Fills the region's place in `out`.
    pub(super) fn fill(&self, value: [f32; 4], out: &mut Block) {
        let width = out.width();
        for (plane, v) in value.into_iter().enumerate().take(out.bands().planes()) {
            for row in self.to.1..self.to.1 + self.size.1 {
                let start = row * width + self.to.0;
                out.plane_mut(plane)[start..start + self.size.0].fill(v);
            }
        }
        self.turn(out);
    }

    /// Copies from a block of the piece's samples.
    pub(super) fn copy_block(&self, piece: &Block, out: &mut Block) {
        self.copy(out, |from, out, to, size| {
            out.copy_from(piece, from, to, size);
        });
    }

    /// Copies from the tile that the piece is.
    pub(super) fn copy_tile(&self, tile: &Tile, out: &mut Block) {
        self.copy(out, |from, out, to, size| tile.copy_to(from, out, to, size));
    }

    fn copy(
        &self,
        out: &mut Block,
        copy: impl Fn((usize, usize), &mut Block, (usize, usize), (usize, usize)),
    ) {
        if self.over_pole {
            for row in 0..self.size.1 {
                let from = (self.from.0, self.from.1 + self.size.1 - 1 - row);
                copy(from, out, (self.to.0, self.to.1 + row), (self.size.0, 1));
            }
            self.turn(out);
        } else {
            copy(self.from, out, self.to, self.size);
        }
    }

    /// Beyond a pole the axes of a normal point the other way.
    fn turn(&self, out: &mut Block) {
        if !self.over_pole || out.bands() != Bands::Normal {
            return;
        }
        let width = out.width();
        for plane in 0..2 {
            for row in self.to.1..self.to.1 + self.size.1 {
                let start = row * width + self.to.0;
                for v in &mut out.plane_mut(plane)[start..start + self.size.0] {
                    *v = 0.0 - *v;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::I64Vec2;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_sample_comes_from_where_the_level_says(
            m in 0..4_u8, n in 0..4_u8, x in -3000..3000_i64, y in -3000..3000_i64,
            w in 1..600_i64, h in 1..600_i64, tiled in any::<bool>(),
        ) {
            let level = LevelKey::new(m, n);
            let rect = SampleRect::at(x, y, w, h);
            let all = regions(&level.lattice(), tiled.then_some(level), &rect);
            prop_assert_eq!(all.iter().map(|r| r.size.0 * r.size.1).sum::<usize>() as i64, rect.area());
            for r in all {
                prop_assert!(level.extent().contains_rect(&r.piece));
                for (dx, dy) in [(0, 0), (r.size.0 - 1, r.size.1 - 1)] {
                    let out = rect.min + I64Vec2::new((r.to.0 + dx) as i64, (r.to.1 + dy) as i64);
                    let row = if r.over_pole { r.size.1 - 1 - dy } else { dy };
                    let source = r.piece.min + I64Vec2::new((r.from.0 + dx) as i64, (r.from.1 + row) as i64);
                    prop_assert_eq!(level.wrap_sample(out), source);
                    prop_assert!(r.piece.contains(source));
                }
            }
        }
    }

    #[test]
    fn a_lattice_that_does_not_close_is_read_as_it_is() {
        let mut lattice = LevelKey::new(1, 1).lattice();
        lattice.columns_around = None;
        let rect = SampleRect::at(-9, -9, 4, 3);
        assert_eq!(regions(&lattice, None, &rect)[0].piece, rect);
    }
}
