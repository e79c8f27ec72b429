//! One cell: a mask of coverage, and the colours that it has brought together.

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

/// A cell that is being drawn.
pub(super) struct Canvas {
    mask: Mask,
    path: Path,
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
        let side = CELL as u32;
        let mask = Mask::new(side, side);
        Self {
            mask: mask.unwrap_or_else(|| unreachable!("a cell has a size")),
            path: Path::default(),
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

    /// Turns the shapes into the mask.
    pub(super) fn fill(&mut self) {
        self.mask.clear();
        let builder = std::mem::take(&mut self.path.builder);
        if let Some(path) = builder.finish() {
            self.mask
                .fill_path(&path, FillRule::Winding, true, Transform::identity());
        }
    }

    /// The mask's samples, row by row.
    pub(super) fn mask_mut(&mut self) -> &mut [u8] {
        self.mask.data_mut()
    }

    /// Puts a colour over what is there, where the mask is.
    pub(super) fn blend(&mut self, colour: Colour, fade: f64) {
        let [r, g, b, a] = colour;
        let linear = [r, g, b].map(linear_from_srgb);
        let alpha = a * fade as f32;
        if !(alpha > 0.0) {
            return;
        }
        // Most masks have few different values.
        let weights: [f32; 256] = core::array::from_fn(|m| alpha.min(1.0) * (m as f32 / 255.0));
        let [red, green, blue, alphas] = &mut self.planes;
        for (i, m) in self.mask.data().iter().enumerate() {
            if *m == 0 {
                continue;
            }
            let over = weights[usize::from(*m)];
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
        let at = [p.x, p.y].map(|v| (libm::round(v * GRAIN) / GRAIN) as f32);
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
