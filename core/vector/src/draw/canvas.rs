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

/// A cell that is being drawn.
pub(super) struct Canvas {
    mask: Mask,
    path: Path,
    /// How much of each sample the mask covers, 0 to [`FULL`].
    coverage: Vec<u16>,
    /// Rows in which there is some.
    rows: Range<usize>,
    /// Premultiplied, in linear light.
    planes: [Vec<f32>; 4],
}

/// Shapes that become one, where their windings do not cancel.
#[derive(Default)]
pub(super) struct Path {
    builder: PathBuilder,
    clipped: [Vec<DVec2>; 2],
}

impl Canvas {
    pub(super) fn new() -> Self {
        let side = (FINE * CELL) as u32;
        let mask = Mask::new(side, side);
        Self {
            mask: mask.unwrap_or_else(|| unreachable!("a cell has a size")),
            path: Path::default(),
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
        self.rows = 0..0;
        let builder = std::mem::take(&mut self.path.builder);
        let Some(path) = builder.finish() else {
            return;
        };
        let bounds = path.bounds();
        // A row more on each side: what touches an edge is rounded somewhere.
        let first = (bounds.top() / FINE as f32 - 1.0).clamp(0.0, CELL as f32) as usize;
        let last = (bounds.bottom() / FINE as f32 + 2.0).clamp(0.0, CELL as f32) as usize;
        self.rows = first..last.max(first);
        let line = FINE * CELL;
        self.mask.data_mut()[first * FINE * line..self.rows.end * FINE * line].fill(0);
        self.mask
            .fill_path(&path, FillRule::Winding, true, Transform::identity());
        for row in self.rows.clone() {
            let fine = &self.mask.data()[row * FINE * line..(row + 1) * FINE * line];
            let (above, below) = fine.split_at(line);
            let samples = &mut self.coverage[row * CELL..(row + 1) * CELL];
            let pairs = above.chunks_exact(FINE).zip(below.chunks_exact(FINE));
            for (sample, (a, b)) in samples.iter_mut().zip(pairs) {
                *sample = a.iter().chain(b).map(|v| u16::from(*v)).sum();
            }
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
            return;
        }
        let [a, b] = &mut self.clipped;
        clip(points, a, |p| p.x - low.x);
        clip(a, b, |p| high.x - p.x);
        clip(b, a, |p| p.y - low.y);
        clip(a, b, |p| high.y - p.y);
        trace(&mut self.builder, b);
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
