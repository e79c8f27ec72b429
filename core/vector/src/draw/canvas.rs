//! One cell: a mask of coverage, and the colours that it has brought together.

use core::ops::Range;

use glam::DVec2;
use relievo_planet::SampleRect;
use relievo_raster::Block;
use relievo_raster::colour::{encode_each, linear_from_srgb};
use tiny_skia::{FillRule, Mask, PathBuilder, Transform};

use crate::style::Colour;

/// Samples along a side.
pub(super) const CELL: usize = 256;

/// Vertices are rounded to this part of a sample: what tiny-skia's fills see.
const GRAIN: f64 = 256.0;

/// How far beyond the cell shapes are cut off, in samples.
const PAD: f64 = 4.0;

/// Samples of the mask along a side of a sample. tiny-skia tells four steps of coverage apart along
/// an axis; twice as many keep thin lines even.
const FINE: usize = 2;

/// Coverage of a sample that is wholly covered.
const FULL: u16 = (FINE * FINE * 255) as u16;

/// Edges that are filled together. tiny-skia keeps the edges of a row in a sorted list, which takes
/// the square of their number where all lie in one place; shapes beyond this are filled in batches.
const BATCH: usize = 8192;

/// A cell that is being drawn.
pub(super) struct Canvas {
    path: Path,
    /// How much of each sample is covered, 0 to [`FULL`].
    coverage: Vec<u16>,
    /// Rows in which there is some.
    rows: Range<usize>,
    /// Premultiplied, in linear light.
    planes: [Vec<f32>; 4],
}

/// Shapes that become one, where their windings do not cancel.
pub(super) struct Path {
    mask: Mask,
    builder: PathBuilder,
    /// Edges in the builder.
    edges: usize,
    /// Rows of samples that the mask or the specks touch.
    rows: Range<usize>,
    /// Samples that specks cover, by sample.
    specks: Vec<f32>,
    clipped: [Vec<DVec2>; 2],
}

impl Canvas {
    pub(super) fn new() -> Self {
        let side = (FINE * CELL) as u32;
        let mask = Mask::new(side, side);
        Self {
            path: Path {
                mask: mask.unwrap_or_else(|| unreachable!("a cell has a size")),
                builder: PathBuilder::new(),
                edges: 0,
                rows: 0..0,
                specks: vec![0.0; CELL * CELL],
                clipped: [Vec::new(), Vec::new()],
            },
            coverage: vec![0; CELL * CELL],
            rows: 0..0,
            planes: core::array::from_fn(|_| vec![0.0; CELL * CELL]),
        }
    }

    pub(super) fn clear(&mut self) {
        for plane in &mut self.planes {
            plane.fill(0.0);
        }
    }

    /// Where shapes go until [`Self::fill`].
    pub(super) fn path(&mut self) -> &mut Path {
        &mut self.path
    }

    /// Turns the shapes into coverage.
    pub(super) fn fill(&mut self) {
        self.path.flush();
        self.rows = std::mem::take(&mut self.path.rows);
        let line = FINE * CELL;
        for row in self.rows.clone() {
            let fine = &mut self.path.mask.data_mut()[row * FINE * line..(row + 1) * FINE * line];
            let specks = &mut self.path.specks[row * CELL..(row + 1) * CELL];
            let samples = &mut self.coverage[row * CELL..(row + 1) * CELL];
            let (above, below) = fine.split_at(line);
            let pairs = above.chunks_exact(FINE).zip(below.chunks_exact(FINE));
            for ((sample, (a, b)), speck) in samples.iter_mut().zip(pairs).zip(&*specks) {
                let covered: u16 = a.iter().chain(b).map(|v| u16::from(*v)).sum();
                let specks = (speck.clamp(0.0, 1.0) * f32::from(FULL) + 0.5) as u16;
                *sample = (covered + specks).min(FULL);
            }
            // As the next shapes expect it.
            fine.fill(0);
            specks.fill(0.0);
        }
    }

    /// Multiplies the coverage of each covered sample, by its column and row, by 0 to 1.
    pub(super) fn thin(&mut self, share: impl Fn(usize, usize) -> f64) {
        for row in self.rows.clone() {
            let samples = &mut self.coverage[row * CELL..(row + 1) * CELL];
            for (column, sample) in samples.iter_mut().enumerate() {
                if *sample > 0 {
                    *sample = libm::round(f64::from(*sample) * share(column, row)) as u16;
                }
            }
        }
    }

    /// Puts a colour over what is there, where there is coverage.
    pub(super) fn blend(&mut self, colour: Colour, fade: f64) {
        let [r, g, b, a] = colour;
        let linear = [r, g, b].map(linear_from_srgb);
        let alpha = (f64::from(a) * fade).min(1.0) as f32;
        if alpha <= 0.0 || alpha.is_nan() {
            return;
        }
        let [red, green, blue, alphas] = &mut self.planes;
        let range = self.rows.start * CELL..self.rows.end * CELL;
        for (i, covered) in range.clone().zip(&self.coverage[range]) {
            if *covered == 0 {
                continue;
            }
            let over = if *covered == FULL {
                alpha
            } else {
                alpha * (f32::from(*covered) / f32::from(FULL))
            };
            let under = 1.0 - over;
            red[i] = linear[0] * over + red[i] * under;
            green[i] = linear[1] * over + green[i] * under;
            blue[i] = linear[2] * over + blue[i] * under;
            alphas[i] = over + alphas[i] * under;
        }
    }

    /// Copies samples `from` of the cell to samples `to` of a block, straight and display-referred.
    pub(super) fn copy_to(&self, from: SampleRect, to: SampleRect, out: &mut Block) {
        let width = from.width() as usize;
        let stride = out.width();
        let mut line = vec![0.0_f32; width];
        for row in 0..from.height() as usize {
            let first = (from.min.y as usize + row) * CELL + from.min.x as usize;
            let at = (to.min.y as usize + row) * stride + to.min.x as usize;
            let alphas = &self.planes[3][first..first + width];
            for plane in 0..3 {
                let values = &self.planes[plane][first..first + width];
                for ((l, v), a) in line.iter_mut().zip(values).zip(alphas) {
                    *l = if *a > 0.0 { v / a } else { 0.0 };
                }
                encode_each(&mut line);
                for (l, a) in line.iter_mut().zip(alphas) {
                    if *a <= 0.0 {
                        *l = 0.0;
                    }
                }
                out.plane_mut(plane)[at..at + width].copy_from_slice(&line);
            }
            out.plane_mut(3)[at..at + width].copy_from_slice(alphas);
        }
    }
}

impl Path {
    /// Fills what was gathered.
    fn flush(&mut self) {
        self.edges = 0;
        let builder = std::mem::take(&mut self.builder);
        let Some(path) = builder.finish() else {
            return;
        };
        let bounds = path.bounds();
        // A row more on each side: what touches an edge is rounded somewhere.
        let first = (bounds.top() / FINE as f32 - 1.0).clamp(0.0, CELL as f32) as usize;
        let last = (bounds.bottom() / FINE as f32 + 2.0).clamp(0.0, CELL as f32) as usize;
        self.touch(first..last);
        self.mask
            .fill_path(&path, FillRule::Winding, true, Transform::identity());
    }

    fn touch(&mut self, rows: Range<usize>) {
        self.rows = if self.rows.is_empty() {
            rows
        } else {
            self.rows.start.min(rows.start)..self.rows.end.max(rows.end)
        };
    }

    /// Adds something much smaller than a sample by its area in samples, which may be negative for
    /// a hole: thousands of them in a sample cost no more than one.
    pub(super) fn speck(&mut self, at: DVec2, area: f64) {
        let side = CELL as f64;
        if at.cmpge(DVec2::ZERO).all() && at.cmplt(DVec2::splat(side)).all() {
            let (column, row) = (at.x as usize, at.y as usize);
            self.specks[row * CELL + column] += area as f32;
            self.touch(row..row + 1);
        }
    }

    /// Adds a polygon in samples of the cell, closed by itself, cut off a little beyond the cell.
    pub(super) fn polygon(&mut self, points: &[DVec2]) {
        let low = DVec2::splat(-PAD);
        let high = DVec2::splat(CELL as f64 + PAD);
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in points {
            least = least.min(*p);
            most = most.max(*p);
        }
        // Written so that NaN is outside.
        if points.len() < 3 || !(least.cmple(high).all() && most.cmpge(low).all()) {
            return;
        }
        if least.cmpge(low).all() && most.cmple(high).all() {
            trace(&mut self.builder, points);
            self.edges += points.len();
        } else {
            self.cut(points, low, high);
        }
        if self.edges > BATCH {
            self.flush();
        }
    }

    /// Adds the part of a polygon between two corners.
    fn cut(&mut self, points: &[DVec2], low: DVec2, high: DVec2) {
        let [a, b] = &mut self.clipped;
        clip(points, a, |p| p.x - low.x);
        clip(a, b, |p| high.x - p.x);
        clip(b, a, |p| p.y - low.y);
        clip(a, b, |p| high.y - p.y);
        trace(&mut self.builder, b);
        self.edges += b.len();
    }
}

/// The part of a polygon where `inside` is not negative (Sutherland and Hodgman).
fn clip(points: &[DVec2], out: &mut Vec<DVec2>, inside: impl Fn(DVec2) -> f64) {
    out.clear();
    let Some(mut before) = points.last().copied() else {
        return;
    };
    let mut depth_before = inside(before);
    for p in points {
        let depth = inside(*p);
        if (depth < 0.0) != (depth_before < 0.0) {
            let share = depth_before / (depth_before - depth);
            out.push(before + (*p - before) * share);
        }
        if depth >= 0.0 {
            out.push(*p);
        }
        (before, depth_before) = (*p, depth);
    }
}

fn trace(builder: &mut PathBuilder, points: &[DVec2]) {
    let mut before = None;
    for p in points {
        let at = [p.x, p.y].map(|v| (libm::round(v * GRAIN) * (FINE as f64 / GRAIN)) as f32);
        if before == Some(at) {
            continue;
        }
        match before {
            None => builder.move_to(at[0], at[1]),
            Some(_) => builder.line_to(at[0], at[1]),
        }
        before = Some(at);
    }
    if before.is_some() {
        builder.close();
    }
}
