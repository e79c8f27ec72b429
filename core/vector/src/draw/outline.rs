//! Insides of polygons.

use core::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::canvas::{Canvas, Path};
use super::plane::{Plane, Window};
use super::{DrawError, Painter, Shown};
use crate::features::{Bounds, Hit, Shape, Visit, Walker};

/// Vertices closer than this many samples become one, in shapes of some samples' size.
pub(super) const TOLERANCE: f64 = 0.1;

/// Shapes smaller than this many samples are drawn by their area, in the sample where they lie.
const SPECK: f64 = 0.5;

/// Halvings of an edge that a projection bends, at most.
const HALVINGS: u32 = 8;

impl Painter<'_> {
    /// The mask of the insides of polygons, as one shape.
    pub(super) fn fill(&self, shown: &[Shown], canvas: &mut Canvas) -> Result<(), DrawError> {
        let path = canvas.path();
        let mut outline = Vec::new();
        let mut samples = Vec::new();
        let areas = |shape| matches!(shape, Shape::Outer | Shape::Hole);
        let mut feature = None;
        self.each(shown, areas, |shown| {
            let Shown {
                sheet,
                window,
                hit,
                part,
            } = *shown;
            // Holes are holes of their own polygons only.
            let here = (core::ptr::from_ref(sheet), window.bounds, part.feature);
            if feature.replace(here) != Some(here) {
                path.close();
            }
            let clip = window.reached.turned(-hit.turns);
            let tolerance = self.tolerance(&clip);
            if part.pole == 0 && part.bounds.size().cmplt(self.speck(&clip)).all() {
                self.speckle(shown, path);
                return;
            }
            let small = part.bounds.size().cmplt(tolerance * 20.0).all();
            let mut walker = Simplifier {
                clip,
                tolerance: if small { DVec2::ZERO } else { tolerance },
                out: &mut outline,
            };
            walker.out.clear();
            sheet.features.walk(part, &mut walker);
            if part.pole != 0 {
                let y = f64::from(part.pole) * FRAC_PI_2;
                let ends = (outline.first().copied(), outline.last().copied());
                if let (Some(first), Some(last)) = ends {
                    outline.extend([DVec2::new(last.x, y), DVec2::new(first.x, y)]);
                }
            }
            self.place(window, hit, &clip, &mut outline, &mut samples);
            path.ring(&samples);
        })?;
        path.close();
        canvas.fill();
        Ok(())
    }

    /// Size in radians below which something is drawn by its area only.
    pub(super) fn speck(&self, clip: &Bounds) -> DVec2 {
        self.tolerance(clip) * (SPECK / TOLERANCE)
    }

    /// A polygon's ring by its area.
    fn speckle(&self, shown: &Shown, path: &mut Path) {
        let (window, part) = (shown.window, shown.part);
        let turn = DVec2::new(f64::from(shown.hit.turns) * core::f64::consts::TAU, 0.0);
        let Some(at) = self.plane.sample(window, part.bounds.centre() + turn) else {
            return;
        };
        let vertices = shown.sheet.features.vertices_of(part);
        let first = vertices[0];
        let twice: f64 = vertices
            .windows(2)
            .map(|e| (e[0] - first).perp_dot(e[1] - first))
            .sum();
        let metres = self
            .plane
            .planet
            .metres_per_radian(FRAC_PI_2 - part.bounds.centre().y);
        let samples = self.plane.samples_per_m(part.bounds.centre());
        let to_samples = metres * samples;
        path.speck(at, 0.5 * twice * to_samples.x * to_samples.y);
    }

    /// What cannot be seen, in radians of longitude and latitude.
    pub(super) fn tolerance(&self, clip: &Bounds) -> DVec2 {
        if self.plane.is_map() {
            return self.plane.lattice().step.abs() * TOLERANCE;
        }
        // The finest that it can be in the box.
        let metres = self
            .plane
            .planet
            .metres_per_radian(FRAC_PI_2 - clip.centre().y);
        DVec2::splat(TOLERANCE * self.plane.sample_m / metres.max_element())
    }

    /// Samples of an outline; a projected one is cut to what is wanted first, because projections
    /// end somewhere, and bent as the projection bends it.
    fn place(
        &self,
        window: &Window,
        hit: Hit,
        clip: &Bounds,
        outline: &mut Vec<DVec2>,
        samples: &mut Vec<DVec2>,
    ) {
        samples.clear();
        let turn = DVec2::new(f64::from(hit.turns) * core::f64::consts::TAU, 0.0);
        if self.plane.is_map() {
            samples.extend(
                outline
                    .iter()
                    .filter_map(|v| self.plane.sample(window, *v + turn)),
            );
            return;
        }
        cut(outline, clip);
        let Some(mut before) = outline.last().copied() else {
            return;
        };
        for v in outline.iter() {
            bend(
                self.plane,
                window,
                before + turn,
                *v + turn,
                HALVINGS,
                samples,
            );
            samples.extend(self.plane.sample(window, *v + turn));
            before = *v;
        }
    }
}

/// Samples between two vertices where the straight edge would miss them by more than a quarter.
pub(super) fn bend(
    plane: &Plane,
    window: &Window,
    a: DVec2,
    b: DVec2,
    halvings: u32,
    samples: &mut Vec<DVec2>,
) {
    let middle = 0.5 * (a + b);
    let place = |v| plane.sample(window, v);
    let (Some(pa), Some(pm), Some(pb)) = (place(a), place(middle), place(b)) else {
        return;
    };
    // Long edges may bend twice and look straight in the middle.
    let long = (pb - pa).abs().max_element() > 128.0;
    if halvings == 0 || (!long && (pm - 0.5 * (pa + pb)).length_squared() < 0.0625) {
        return;
    }
    bend(plane, window, a, middle, halvings - 1, samples);
    samples.push(pm);
    bend(plane, window, middle, b, halvings - 1, samples);
}

/// The part of a polygon in a box.
fn cut(points: &mut Vec<DVec2>, clip: &Bounds) {
    for (axis, sign, edge) in [
        (0, 1.0, clip.min.x),
        (0, -1.0, clip.max.x),
        (1, 1.0, clip.min.y),
        (1, -1.0, clip.max.y),
    ] {
        let depth = |p: &DVec2| sign * (p[axis] - edge);
        let before = std::mem::take(points);
        for (i, p) in before.iter().enumerate() {
            let q = before[(i + before.len() - 1) % before.len()];
            let (d, e) = (depth(p), depth(&q));
            if (d < 0.0) != (e < 0.0) {
                points.push(q + (*p - q) * (e / (e - d)));
            }
            if d >= 0.0 {
                points.push(*p);
            }
        }
    }
}

/// Collects what a box shows of a ring.
struct Simplifier<'a> {
    clip: Bounds,
    tolerance: DVec2,
    out: &'a mut Vec<DVec2>,
}

impl Walker for Simplifier<'_> {
    fn look(&mut self, bounds: &Bounds) -> Visit {
        if !self.clip.overlaps(bounds) {
            // A box beside another is on one side of it: a chord goes around the same points.
            return Visit::Chord;
        }
        if bounds.size().cmplt(self.tolerance).all() {
            Visit::Chord
        } else {
            Visit::Open
        }
    }

    fn chain(&mut self, vertices: &[DVec2], _at: usize, _stride: usize) -> bool {
        let Some((first, rest)) = vertices.split_first() else {
            return true;
        };
        if self.out.last() != Some(first) {
            self.out.push(*first);
        }
        let mut kept = *first;
        let last = rest.len();
        for (i, v) in rest.iter().enumerate() {
            // The last one is the first of the next run: every run thins out by itself, so that it
            // looks the same in every tile.
            if i + 1 == last || !(*v - kept).abs().cmplt(self.tolerance).all() {
                self.out.push(*v);
                kept = *v;
            }
        }
        true
    }
}
