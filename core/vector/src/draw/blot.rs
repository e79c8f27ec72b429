//! Outlines of rings that are no wider than their stroke, as one polygon: what a city looks like from afar.

use core::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

use super::canvas::Path;
use super::stroke::arc;
use super::{Painter, Shown};
use crate::features::{Shape, on_antimeridian};

/// Longest ring that is drawn so, in samples: dents of longer ones can be seen.
const LONGEST: f64 = 4.0;

impl Painter<'_> {
    /// Adds the stroke of a small ring, if its inside is covered too: everything within half the width
    /// of the smallest convex shape around it. Whether it was.
    ///
    /// Edges are straight in the samples of the place, and dents are filled: at most a small part of a
    /// sample each, whichever cell asks.
    pub(super) fn blot(&self, shown: &Shown, half_m: f64, path: &mut Path) -> bool {
        let part = shown.part;
        let bounds = &part.bounds;
        let is_cut = || on_antimeridian(bounds.min.x) || on_antimeridian(bounds.max.x);
        if part.shape == Shape::Line || part.pole != 0 {
            return false;
        }
        let centre = bounds.centre();
        let scale = self.plane.samples_per_m(centre);
        let metres = self.plane.planet.metres_per_radian(FRAC_PI_2 - centre.y);
        let size = bounds.size() * metres * scale;
        let radii = half_m * scale;
        let covered = size.min_element() < 2.0 * radii.min_element();
        if !covered || size.max_element() > LONGEST || is_cut() {
            return false;
        }
        let turn = DVec2::new(f64::from(shown.hit.turns) * TAU, 0.0);
        let vertices = shown.sheet.features.vertices_of(part).iter();
        let samples = vertices.filter_map(|v| self.plane.sample(shown.window, *v + turn));
        // Round in units of the radius.
        let mut points: Vec<DVec2> = samples.map(|at| at / radii).collect();
        let hull = hull(&mut points);
        if hull.len() < 2 {
            return false;
        }
        let mut corners = Vec::with_capacity(3 * hull.len());
        let aside = |i: usize| {
            let (a, b) = (hull[i % hull.len()], hull[(i + 1) % hull.len()]);
            let along = (b - a).normalize_or_zero();
            DVec2::new(along.y, -along.x)
        };
        for (i, v) in hull.iter().enumerate() {
            let (from, to) = (aside(i + hull.len() - 1), aside(i));
            corners.push((*v + from) * radii);
            arc(from, to, radii.max_element(), &mut |u| {
                corners.push((*v + u) * radii);
            });
            corners.push((*v + to) * radii);
        }
        path.polygon(&corners);
        true
    }
}

/// The smallest convex polygon around points (Andrew's monotone chain), with a positive area in x right
/// and y up.
fn hull(points: &mut Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::with_capacity(points.len() + 1);
    let mut chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let first = hull.len();
        for p in points {
            while let [.., a, b] = hull[first..]
                && (b - a).perp_dot(*p - a) <= 0.0
            {
                hull.pop();
            }
            hull.push(*p);
        }
        // The last is the first of the other side.
        hull.pop();
    };
    chain(&mut points.iter());
    chain(&mut points.iter().rev());
    hull
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_hull_is_convex_and_holds_all_points(
            points in prop::collection::vec((-5.0..5.0_f64, -5.0..5.0_f64), 3..30),
        ) {
            let mut points: Vec<DVec2> = points.into_iter().map(DVec2::from).collect();
            let hull = hull(&mut points);
            for (i, a) in hull.iter().enumerate() {
                let b = hull[(i + 1) % hull.len()];
                for p in &points {
                    prop_assert!((b - *a).perp_dot(*p - *a) >= -1e-12);
                }
            }
        }
    }
}
