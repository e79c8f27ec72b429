//! Symbols of points.

use std::collections::HashSet;

use core::f64::consts::{PI, TAU};

use glam::{DVec2, I64Vec2};

use super::canvas::Canvas;
use super::stroke::{circle, outline_of};
use super::{DrawError, Painter, Shown};
use crate::features::Shape;
use crate::style::{Symbol, SymbolShape};

/// Symbols are drawn once where they are closer than this part of their size, or of a sample.
const SAME: f64 = 0.25;

impl Painter<'_> {
    /// The mask of the points' symbols. Returns how much of the colour shows: symbols smaller than
    /// a sample are drawn a sample wide and fainter.
    pub(super) fn symbols(
        &self,
        shown: &[Shown],
        symbol: &Symbol,
        canvas: &mut Canvas,
    ) -> Result<f64, DrawError> {
        let (drawn_m, fade) = self.size(symbol);
        let mut points = Vec::new();
        self.each_point(shown, drawn_m, |at, scale| points.push((at, scale)))?;
        let path = canvas.path();
        for (at, scale) in points {
            path.polygon(&corners(symbol.shape, at, 0.5 * drawn_m * scale));
        }
        canvas.fill();
        Ok(fade)
    }

    /// The mask of the symbols' outlines.
    pub(super) fn symbol_outlines(
        &self,
        shown: &[Shown],
        symbol: &Symbol,
        width_m: f64,
        canvas: &mut Canvas,
    ) -> Result<f64, DrawError> {
        let (drawn_m, fade) = self.size(symbol);
        let stroke_m = width_m.max(self.plane.sample_m);
        let mut points = Vec::new();
        self.each_point(shown, drawn_m, |at, scale| points.push((at, scale)))?;
        let path = canvas.path();
        for (at, scale) in points {
            let polygon = corners(symbol.shape, at, 0.5 * drawn_m * scale);
            outline_of(path, &polygon, scale, stroke_m);
        }
        canvas.fill();
        Ok(fade * width_m / stroke_m)
    }

    fn size(&self, symbol: &Symbol) -> (f64, f64) {
        let size_m = symbol.size.metres(self.plane.sample_m);
        let drawn_m = size_m.max(self.plane.sample_m);
        let share = size_m / drawn_m;
        (drawn_m, share * share)
    }

    /// Calls `draw` with each point in samples, and samples to a metre there.
    fn each_point(
        &self,
        shown: &[Shown],
        drawn_m: f64,
        mut draw: impl FnMut(DVec2, DVec2),
    ) -> Result<(), DrawError> {
        let apart = SAME * (drawn_m / self.plane.sample_m).max(1.0);
        let mut seen = HashSet::new();
        let points = |shape| shape == Shape::Points;
        self.each(shown, points, |shown| {
            let (window, hit) = (shown.window, shown.hit);
            let clip = window.reached;
            let turn = DVec2::new(f64::from(hit.turns) * TAU, 0.0);
            for v in shown.sheet.features.vertices_of(shown.part) {
                let place = *v + turn;
                let inside = place.cmpge(clip.min).all() && place.cmple(clip.max).all();
                let Some(at) = self.plane.sample(window, place).filter(|_| inside) else {
                    continue;
                };
                // Counted from the lattice's origin, so that all cells leave out the same.
                let whole = (at + window.origin()) / apart;
                let bucket = I64Vec2::new(libm::floor(whole.x) as i64, libm::floor(whole.y) as i64);
                if seen.insert(bucket) {
                    draw(at, self.plane.samples_per_m(place));
                }
            }
        })
    }
}

/// Corners of a symbol around a point, in the direction of circles.
fn corners(shape: SymbolShape, at: DVec2, radii: DVec2) -> Vec<DVec2> {
    let place = |u: DVec2| at + u * radii;
    let around = |count: u32, radius: fn(u32) -> f64| -> Vec<DVec2> {
        (0..count)
            .map(|i| {
                let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(count) - 0.5 * PI);
                place(radius(i) * DVec2::new(cos, sin))
            })
            .collect()
    };
    match shape {
        SymbolShape::Circle => circle(radii.max_element())
            .iter()
            .map(|u| place(*u))
            .collect(),
        SymbolShape::Square => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|u| place(0.886 * DVec2::from(u)))
            .to_vec(),
        SymbolShape::Diamond => around(4, |_| 1.25),
        SymbolShape::Triangle => around(3, |_| 1.15),
        SymbolShape::Star => around(10, |i| if i % 2 == 0 { 1.2 } else { 0.48 }),
        SymbolShape::Cross => {
            let (a, b) = (0.3, 1.0);
            [
                (-a, -b),
                (a, -b),
                (a, -a),
                (b, -a),
                (b, a),
                (a, a),
                (a, b),
                (-a, b),
                (-a, a),
                (-b, a),
                (-b, -a),
                (-a, -a),
            ]
            .map(|u| place(DVec2::from(u)))
            .to_vec()
        }
    }
}
