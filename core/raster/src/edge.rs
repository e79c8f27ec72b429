//! Edges of a source: how far it is from a place to the nearest one where the source ends.
//!
//! A fine source fades into a coarser one over a width in metres. The distance is to the source's
//! outline (exactly, in its own plane) and to holes inside of it (on a coarse copy of its mask,
//! exact between the copy's pixels). Bits depend on places only, so blocks and wholes agree.

use glam::DVec2;
use relievo_planet::Grid;

use crate::file::{Cancel, PixelRect, ReadError};
use crate::warp::{Warp, WarpError};
use crate::{Bands, Block};

/// Longest side in pixels of the coarse copy in which holes are looked for.
const COARSE_SIDE: u32 = 1024;
/// Places are approximated by less, in pixels.
const SLACK_PX: f64 = 1.0;
/// A pixel of the copy is a hole where less than this share of it is valid.
const VALID_SHARE: f32 = 0.5;

/// Distances to the edge of a source, prepared once.
///
/// The coarse copy is the finest overview with at most 1024 pixels on its longer side, or the
/// coarsest one shrunk by whole numbers of pixels to that. Holes narrower than about half a pixel
/// of it are not seen.
#[derive(Clone, Debug)]
pub struct EdgeDistance {
    /// `None` if there are no holes.
    holes: Option<Holes>,
    /// Whether the source ends at its sides, at its first row and at its last.
    has_outline: [bool; 3],
}

#[derive(Clone, Debug)]
struct Holes {
    width: usize,
    height: usize,
    /// Longest half side of a pixel: from a hole's centre to where it ends.
    half_pixel_m: f64,
    /// Metres from the centre of every pixel to the nearest centre of a hole.
    distance_m: Vec<f32>,
}

impl EdgeDistance {
    /// Looks for the holes of a source.
    ///
    /// # Errors
    /// [`ReadError`] when the file is damaged or gone or work was cancelled.
    pub fn new(warp: &Warp, cancel: &Cancel) -> Result<Self, ReadError> {
        let has_outline = warp.outline();
        let (mask, width, height) = coarse_mask(warp, cancel)?;
        if mask.iter().all(|valid| *valid) {
            return Ok(Self {
                holes: None,
                has_outline,
            });
        }
        let full = warp.file().info().overviews[0];
        let pixels = [
            f64::from(full.width) / width as f64,
            f64::from(full.height) / height as f64,
        ];
        let row_m: Vec<[f64; 2]> = (0..height)
            .map(|y| {
                let [x_m, y_m] = warp.pixel_size_m((y as f64 + 0.5) * pixels[1]);
                [x_m * pixels[0], y_m * pixels[1]]
            })
            .collect();
        let half_pixel_m = row_m.iter().flatten().fold(0.0, |a: f64, b| a.max(0.5 * b));
        let distance_m = distances(&mask, width, &row_m, !has_outline[0]);
        Ok(Self {
            holes: Some(Holes {
                width,
                height,
                half_pixel_m,
                distance_m,
            }),
            has_outline,
        })
    }

    /// Distances to the outline alone, as if there were no holes.
    pub fn to_outline(warp: &Warp) -> Self {
        Self {
            holes: None,
            has_outline: warp.outline(),
        }
    }

    /// Whether there is no edge at all: a globe without holes.
    pub fn is_endless(&self) -> bool {
        self.holes.is_none() && self.has_outline == [false; 3]
    }

    /// Metres from the outline that all samples of a grid have at least, holes or not, without looking at any:
    /// the same each time, and never too many. 0 where nothing is known.
    pub fn least_m(warp: &Warp, grid: &Grid) -> f64 {
        if warp.outline() == [false; 3] {
            return f64::INFINITY;
        }
        let Some([low, high]) = warp.span(grid) else {
            return 0.0;
        };
        let full = warp.file().info().overviews[0];
        let size = DVec2::new(f64::from(full.width), f64::from(full.height));
        let (west_north, east_south) = (low - SLACK_PX, size - high - SLACK_PX);
        let [sides, first, last] = warp.outline();
        // Pixels of a geographic source are narrowest where it is nearest to a pole: at an end.
        let ends = [low.y, high.y].map(|row| warp.pixel_size_m(row.clamp(0.0, size.y)));
        let pixel_m = DVec2::from_array(ends[0]).min(DVec2::from_array(ends[1]));
        let beyond = |is_edge: bool, m: f64| if is_edge { m } else { f64::INFINITY };
        beyond(sides, west_north.x.min(east_south.x) * pixel_m.x)
            .min(beyond(first, west_north.y * pixel_m.y))
            .min(beyond(last, east_south.y * pixel_m.y))
            .max(0.0)
    }

    /// Metres from each sample of a grid to the edge ([`Bands::Height`]): 0 and below outside, [`f32::MAX`]
    /// without an edge.
    ///
    /// # Errors
    /// [`WarpError`] when the grid's coordinate system is not known.
    pub fn distances_m(&self, warp: &Warp, grid: &Grid) -> Result<Block, WarpError> {
        let mut block = Block::new(
            Bands::Height,
            grid.rect.width() as usize,
            grid.rect.height() as usize,
        );
        let out = block.plane_mut(0);
        if self.is_endless() {
            out.fill(f32::MAX);
            return Ok(block);
        }
        out.fill(0.0);
        let full = warp.file().info().overviews[0];
        let (width, height) = (f64::from(full.width), f64::from(full.height));
        // Of the row before: rows of a source that lies as the grid does are all one latitude, and
        // in a projected one all pixels are alike.
        let alike = warp.pixels_are_alike();
        let mut row = (0.0, warp.pixel_size_m(0.0));
        warp.for_each_place(grid, |sample, place| {
            let (x, y) = (place.x, place.y);
            let inside = y.clamp(0.0, height);
            if !alike && inside != row.0 {
                row = (inside, warp.pixel_size_m(inside));
            }
            let [x_m, y_m] = row.1;
            let mut distance = f64::INFINITY;
            if self.has_outline[0] {
                distance = distance.min(x.min(width - x) * x_m);
            }
            if self.has_outline[1] {
                distance = distance.min(y * y_m);
            }
            if self.has_outline[2] {
                distance = distance.min((height - y) * y_m);
            }
            if let Some(holes) = &self.holes {
                distance = distance.min(
                    holes.at(x / width, y / height, !self.has_outline[0]) - holes.half_pixel_m,
                );
            }
            out[sample] = distance as f32;
        })?;
        Ok(block)
    }
}

impl Holes {
    /// Distance at a place given as parts of width and height: bilinear between centres.
    fn at(&self, u: f64, v: f64, wraps: bool) -> f64 {
        let (x, y) = (
            u * self.width as f64 - 0.5,
            (v * self.height as f64 - 0.5).clamp(0.0, self.height as f64 - 1.0),
        );
        let (column, row) = (x.floor(), y.floor());
        let (fx, fy) = (x - column, y - row);
        let wrap = |c: i64| {
            let width = self.width as i64;
            (if wraps {
                c.rem_euclid(width)
            } else {
                c.clamp(0, width - 1)
            }) as usize
        };
        let (west, east) = (wrap(column as i64), wrap(column as i64 + 1));
        let (north, south) = (row as usize, (row as usize + 1).min(self.height - 1));
        let at = |x: usize, y: usize| f64::from(self.distance_m[y * self.width + x]);
        let n = at(west, north) + (at(east, north) - at(west, north)) * fx;
        let s = at(west, south) + (at(east, south) - at(west, south)) * fx;
        n + (s - n) * fy
    }
}

/// Which pixels of the coarse copy are valid, its width and height.
fn coarse_mask(warp: &Warp, cancel: &Cancel) -> Result<(Vec<bool>, usize, usize), ReadError> {
    let info = warp.file().info();
    let fits = |o: &crate::file::OverviewInfo| o.width.max(o.height) <= COARSE_SIDE;
    let overview = info
        .overviews
        .iter()
        .position(fits)
        .unwrap_or(info.overviews.len() - 1);
    let from = info.overviews[overview];
    let shrink = from.width.max(from.height).div_ceil(COARSE_SIDE).max(1);
    let (width, height) = (
        from.width.div_ceil(shrink) as usize,
        from.height.div_ceil(shrink) as usize,
    );
    let mut mask = Vec::with_capacity(width * height);
    let mut strip = Block::new(info.bands, 0, 0);
    for y in (0..from.height).step_by(shrink as usize) {
        if cancel.is_cancelled() {
            return Err(ReadError::Cancelled);
        }
        let rows = shrink.min(from.height - y);
        let rect = PixelRect {
            x: 0,
            y,
            width: from.width,
            height: rows,
        };
        warp.file().read(overview, rect, &mut strip, cancel)?;
        let (plane, is_height) = match info.bands {
            Bands::Colour => (strip.plane(3), false),
            Bands::Height | Bands::Mask | Bands::Normal => (strip.plane(0), true),
        };
        for column in 0..width {
            let first = column * shrink as usize;
            let last = (first + shrink as usize).min(strip.width());
            let (mut valid, mut all) = (0.0, 0.0);
            for row in plane.chunks_exact(strip.width()) {
                for v in &row[first..last] {
                    valid += if is_height {
                        f32::from(u8::from(!v.is_nan()))
                    } else {
                        *v
                    };
                    all += 1.0;
                }
            }
            mask.push(valid >= VALID_SHARE * all);
        }
    }
    Ok((mask, width, height))
}

/// Metres from every pixel to the nearest invalid one: exact squared distances, first along
/// columns, then along rows. `row_m` is the size of a pixel of each row; a row's own width is used
/// for all of its distances.
///
/// Source: P. Felzenszwalb and D. Huttenlocher, Distance transforms of sampled functions, 2012.
fn distances(mask: &[bool], width: usize, row_m: &[[f64; 2]], wraps: bool) -> Vec<f32> {
    let height = row_m.len();
    let mut squared = vec![f64::INFINITY; width * height];
    for x in 0..width {
        // Along a column the nearest hole above and below decides.
        for order in [false, true] {
            let mut distance = f64::INFINITY;
            for i in 0..height {
                let y = if order { height - 1 - i } else { i };
                let at = y * width + x;
                distance = if mask[at] {
                    distance + row_m[y][1]
                } else {
                    0.0
                };
                squared[at] = squared[at].min(distance * distance);
            }
        }
    }
    // Around the globe a row is its own neighbour: half a turn to either side is enough.
    let margin = if wraps { width / 2 } else { 0 };
    let mut out = Vec::with_capacity(width * height);
    let mut line = vec![0.0; width + 2 * margin];
    let mut result = line.clone();
    for (row, m) in squared.chunks_exact(width).zip(row_m) {
        for (i, v) in line.iter_mut().enumerate() {
            *v = row[(i + width - margin) % width];
        }
        envelope(&line, m[0], &mut result);
        out.extend(
            result[margin..margin + width]
                .iter()
                .map(|v| v.sqrt() as f32),
        );
    }
    out
}

/// Lower envelope of parabolas: `out[i]` = min over j of `values[j]` + (`pitch` (i − j))².
fn envelope(values: &[f64], pitch: f64, out: &mut [f64]) {
    let square = |i: usize| (i as f64 * pitch) * (i as f64 * pitch);
    let mut hull: Vec<(usize, f64)> = Vec::with_capacity(values.len());
    for (q, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        let mut from = f64::NEG_INFINITY;
        while let Some((p, start)) = hull.last().copied() {
            // Where the parabola of q falls below that of p, in samples.
            from = ((v + square(q)) - (values[p] + square(p)))
                / (2.0 * pitch * pitch * (q - p) as f64);
            if from > start {
                break;
            }
            hull.pop();
            from = f64::NEG_INFINITY;
        }
        hull.push((q, from));
    }
    let mut k = 0;
    for (i, o) in out.iter_mut().enumerate() {
        while k + 1 < hull.len() && hull[k + 1].1 < i as f64 {
            k += 1;
        }
        *o = hull
            .get(k)
            .map_or(f64::INFINITY, |(p, _)| values[*p] + square(i.abs_diff(*p)));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn distances_are_those_of_a_search_over_all_holes(
            holes in prop::collection::vec(prop::bool::weighted(0.9), 12 * 9), pitch in (0.1..5.0_f64, 0.1..5.0_f64),
        ) {
            let row_m = vec![[pitch.0, pitch.1]; 9];
            let found = distances(&holes, 12, &row_m, false);
            for (i, d) in found.iter().enumerate() {
                let nearest = (0..holes.len()).filter(|j| !holes[*j]).map(|j| {
                    let dx = ((i % 12) as f64 - (j % 12) as f64) * pitch.0;
                    let dy = ((i / 12) as f64 - (j / 12) as f64) * pitch.1;
                    libm::hypot(dx, dy)
                }).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest == f64::from(*d) || (nearest - f64::from(*d)).abs() < 1e-5 * (1.0 + nearest));
            }
        }
    }

    #[test]
    fn a_hole_is_near_from_both_sides_of_the_seam() {
        let mut mask = vec![true; 10];
        mask[0] = false;
        let d = distances(&mask, 10, &[[1.0, 1.0]], true);
        assert_eq!((d[9], d[1], d[5]), (1.0, 1.0, 5.0));
    }
}
