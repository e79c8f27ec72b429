//! One cell: a mask of coverage, and the colours that it has brought together.

use core::ops::Range;

use glam::DVec2;
use relievo_planet::SampleRect;
use relievo_raster::Block;
use relievo_raster::colour::{encode_each, linear_from_srgb};

use super::raster::{POINTS, Raster};
use crate::style::Colour;

/// Samples along a side.
pub(super) const CELL: usize = 256;

/// Coverage of a sample that is wholly covered: finer than the points of a sample, because specks are.
const FULL: u16 = POINTS * SPECKS;

/// Steps of coverage to a point.
const SPECKS: u16 = 16;

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

/// Shapes that become one.
pub(super) struct Path {
    raster: Raster,
    /// Samples that specks cover, by sample.
    specks: Vec<f32>,
}

impl Canvas {
    pub(super) fn new() -> Self {
        Self {
            path: Path {
                raster: Raster::new(),
                specks: vec![0.0; CELL * CELL],
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
        self.rows = self.path.raster.take_rows();
        let mut points = [0; CELL];
        for row in self.rows.clone() {
            self.path.raster.take_row(row, &mut points);
            let specks = &mut self.path.specks[row * CELL..(row + 1) * CELL];
            let samples = &mut self.coverage[row * CELL..(row + 1) * CELL];
            for ((sample, covered), speck) in samples.iter_mut().zip(points).zip(&*specks) {
                let specks = (speck.clamp(0.0, 1.0) * f32::from(FULL) + 0.5) as u16;
                *sample = (u16::from(covered) * SPECKS + specks).min(FULL);
            }
            // As the next shapes expect it.
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
    /// Adds something much smaller than a sample by its area in samples, which may be negative for
    /// a hole: thousands of them in a sample cost no more than one.
    pub(super) fn speck(&mut self, at: DVec2, area: f64) {
        let side = CELL as f64;
        if at.cmpge(DVec2::ZERO).all() && at.cmplt(DVec2::splat(side)).all() {
            let (column, row) = (at.x as usize, at.y as usize);
            self.specks[row * CELL + column] += area as f32;
            self.raster.touch(row..row + 1);
        }
    }

    /// Adds a ring of a polygon in samples of the cell, closed by itself.
    pub(super) fn ring(&mut self, points: &[DVec2]) {
        self.raster.ring(points);
    }

    /// The rings since the last polygon are one.
    pub(super) fn close(&mut self) {
        self.raster.fill();
    }

    /// Adds a polygon of one ring.
    pub(super) fn polygon(&mut self, points: &[DVec2]) {
        self.ring(points);
        self.close();
    }
}
