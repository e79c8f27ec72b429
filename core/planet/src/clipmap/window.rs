//! The toroidal window of one clip level: which samples it holds, where each is stored, and what a
//! move makes new.
//!
//! Invariant: applying the rectangles of [`Window::update_from`] along any walk equals a fresh fill
//! (`tests/clipmap_laws.rs`). Absent: tiles' contents, level choice (`levels.rs`).

use glam::{DVec2, I64Vec2};

use crate::{LevelKey, MapPoint, SampleRect, TILE_SAMPLES, TileKey};

/// Windows move in steps of 1/32 of their size, so that a slow camera uploads a strip now and then
/// instead of a line of texels in every frame.
const STEPS_PER_WINDOW: i64 = 32;

/// A window of at most N × N samples of one level.
///
/// **Indices.** `rect` counts in *unwrapped* sample indices of the level: columns may be negative
/// or lie beyond the level's last column where the window crosses the antimeridian; rows are always
/// inside the level, because samples do not continue beyond a pole (they are the same rows seen
/// from the other side). A window of a level that is no wider than N samples holds the **whole
/// circle**: its columns are then always `0..columns`, wherever the focus is.
///
/// **Storage rule.** Sample (i, j) is stored at texel (i mod P, j mod N) with P = min(N, columns of
/// the level). For every window narrower than its level P = N divides the level's width, so an
/// index and its copies a whole turn away share one texel; for a whole-circle window P is the width
/// itself, so storage is unique there as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// The level whose samples it holds.
    pub level: LevelKey,
    /// N: samples along a side of its storage, a power of two, at least [`TILE_SAMPLES`].
    pub size: u32,
    /// The samples it holds, in unwrapped indices.
    pub rect: SampleRect,
}

/// One rectangular copy from a tile into a window's storage, without wrap-around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UploadPiece {
    /// Which samples of the tile, counted from the tile's first sample.
    pub in_tile: SampleRect,
    /// First texel of the storage that receives them; width and height are those of `in_tile`.
    pub storage: I64Vec2,
}

impl Window {
    /// The window of `size` samples around a focus.
    ///
    /// Its centre lies within `size / 64` samples of the focus along columns and along rows, except
    /// where rows end at a pole or columns close the circle.
    ///
    /// # Panics
    /// If `size` is not a power of two from [`TILE_SAMPLES`] to 2¹⁶.
    pub fn place(level: LevelKey, focus: MapPoint, size: u32) -> Self {
        let n = i64::from(size);
        assert!(
            size.is_power_of_two() && (TILE_SAMPLES..=1 << 16).contains(&n),
            "window size {size} is not a power of two from 256 to 65536"
        );
        let samples = level.samples();
        let step = n / STEPS_PER_WINDOW;
        let corner = (level.sample_from_map(focus) - n as f64 / 2.0) / step as f64;
        let corner = I64Vec2::new(round_to_index(corner.x), round_to_index(corner.y)) * step;
        let (column, width) = if samples.x <= n {
            (0, samples.x)
        } else {
            (corner.x, n)
        };
        let (row, height) = if samples.y <= n {
            (0, samples.y)
        } else {
            (corner.y.clamp(0, samples.y - n), n)
        };
        Self {
            level,
            size,
            rect: SampleRect::at(column, row, width, height),
        }
    }

    /// Whether it holds every column of its level.
    pub fn is_whole_circle(&self) -> bool {
        self.rect.width() == self.level.samples().x
    }

    /// After how many columns and rows storage repeats: see the storage rule.
    pub fn period(&self) -> I64Vec2 {
        let n = i64::from(self.size);
        I64Vec2::new(self.level.samples().x.min(n), n)
    }

    /// The texel of a sample (in unwrapped indices) or of a continuous sample's lower corner.
    pub fn storage_of(&self, sample: I64Vec2) -> I64Vec2 {
        sample.rem_euclid(self.period())
    }

    /// Continuous sample coordinates of a map point in the copy of the level's columns that lies
    /// nearest to the window's centre: the centre of sample i is at i + ½.
    pub fn sample_of(&self, point: MapPoint) -> DVec2 {
        let mut sample = self.level.sample_from_map(point);
        let around = self.level.samples().x as f64;
        let centre = 0.5 * (self.rect.min.x + self.rect.max.x) as f64;
        sample.x += ((centre - sample.x) / around).round() * around;
        sample
    }

    /// Rectangles of `self` (unwrapped indices) whose samples `before` did not hold: nothing when
    /// it has not moved, everything when the level or the size is another or nothing is shared.
    ///
    /// The rectangles are disjoint, non-empty, and at most four.
    pub fn update_from(&self, before: Option<&Self>) -> Vec<SampleRect> {
        let Some(before) = before.filter(|b| b.level == self.level && b.size == self.size) else {
            return vec![self.rect];
        };
        // A step over the antimeridian renames columns by a whole turn: undo it first.
        let around = self.level.samples().x;
        let turns = div_round(self.rect.min.x - before.rect.min.x, around);
        let kept = before
            .rect
            .shift(I64Vec2::new(turns * around, 0))
            .intersection(&self.rect);
        self.rect.minus(&kept)
    }

    /// Where the tile lies in the window's unwrapped indices, or `None` if it has no sample in the
    /// window or belongs to another level.
    pub fn tile_rect(&self, tile: TileKey) -> Option<SampleRect> {
        if tile.level != self.level {
            return None;
        }
        let around = self.level.samples().x;
        let rect = tile.rect();
        // The first copy whose end lies beyond the window's first column: a window that is not the
        // whole circle is at most half of it, so at most this copy overlaps.
        let turns = (self.rect.min.x - rect.max.x).div_euclid(around) + 1;
        let rect = rect.shift(I64Vec2::new(turns * around, 0));
        rect.overlaps(&self.rect).then_some(rect)
    }

    /// All tiles that the window touches, each with its rectangle in unwrapped indices.
    pub fn tiles(&self) -> impl Iterator<Item = (TileKey, SampleRect)> + use<> {
        self.level.tiles_touching(&self.rect)
    }

    /// The copies that bring a tile's samples into the window's storage, as far as they lie in
    /// `within` (unwrapped indices; pass `&window.rect` for all): at most four, split where storage
    /// wraps.
    pub fn upload_pieces(&self, tile: TileKey, within: &SampleRect) -> Vec<UploadPiece> {
        let Some(tile_rect) = self.tile_rect(tile) else {
            return Vec::new();
        };
        let part = tile_rect.intersection(&self.rect).intersection(within);
        let period = self.period();
        let mut pieces = Vec::new();
        for (top, bottom) in split_at_multiples(part.min.y, part.max.y, period.y) {
            for (left, right) in split_at_multiples(part.min.x, part.max.x, period.x) {
                let piece = SampleRect::new(I64Vec2::new(left, top), I64Vec2::new(right, bottom));
                pieces.push(UploadPiece {
                    in_tile: piece.shift(-tile_rect.min),
                    storage: self.storage_of(piece.min),
                });
            }
        }
        pieces
    }
}

/// Nearest integer; the argument is far below 2⁵³ for every level.
fn round_to_index(x: f64) -> i64 {
    libm::round(x) as i64
}

/// a / b rounded to the nearest integer, b > 0.
fn div_round(a: i64, b: i64) -> i64 {
    (2 * a + b).div_euclid(2 * b)
}

/// Splits `from..to` at the multiples of `period` inside it; nothing when it is empty.
fn split_at_multiples(from: i64, to: i64, period: i64) -> impl Iterator<Item = (i64, i64)> {
    let mut start = from;
    core::iter::from_fn(move || {
        if start >= to {
            return None;
        }
        let end = to.min((start.div_euclid(period) + 1) * period);
        let piece = (start, end);
        start = end;
        Some(piece)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_as_wide_as_its_level_never_moves_its_columns() {
        let level = LevelKey::new(0, 2);
        let a = Window::place(level, MapPoint::from_degrees(-170.0, 10.0), 256);
        let b = Window::place(level, MapPoint::from_degrees(150.0, 10.0), 256);
        assert_eq!(a, b);
        assert!(a.is_whole_circle());
        assert!(b.update_from(Some(&a)).is_empty());
    }

    #[test]
    fn rows_end_at_the_poles() {
        let level = LevelKey::new(5, 4);
        let north = Window::place(level, MapPoint::from_degrees(0.0, 90.0), 512);
        let south = Window::place(level, MapPoint::from_degrees(0.0, -90.0), 512);
        assert_eq!((north.rect.min.y, north.rect.max.y), (0, 512));
        assert_eq!((south.rect.min.y, south.rect.max.y), (4096 - 512, 4096));
    }

    #[test]
    fn a_small_step_over_the_antimeridian_is_a_small_update() {
        let level = LevelKey::new(10, 9);
        let west = Window::place(level, MapPoint::from_degrees(179.999, 3.0), 1024);
        let east = Window::place(level, MapPoint::from_degrees(-179.9, 3.0), 1024);
        let new: i64 = east
            .update_from(Some(&west))
            .iter()
            .map(SampleRect::area)
            .sum();
        assert!(new > 0 && new <= 128 * 1024, "{new}");
    }

    #[test]
    fn tiles_land_where_the_storage_rule_says() {
        let level = LevelKey::new(6, 5);
        let w = Window::place(level, MapPoint::from_degrees(-179.0, 3.0), 512);
        let mut stored = 0;
        for (key, rect) in w.tiles() {
            assert_eq!(w.tile_rect(key), Some(rect));
            for p in w.upload_pieces(key, &w.rect) {
                assert_eq!(w.storage_of(rect.min + p.in_tile.min), p.storage);
                stored += p.in_tile.area();
            }
        }
        assert_eq!(stored, w.rect.area());
    }
}
