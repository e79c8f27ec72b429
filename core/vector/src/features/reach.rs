//! Which features touch a box.

use core::ops::ControlFlow;

use glam::DVec2;

use super::{Bounds, Features, Part, Shape, Visit, Walker};

/// A part that may show in a box, moved eastward by whole turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Hit {
    pub(crate) part: u32,
    pub(crate) turns: i32,
}

impl Features {
    /// Parts whose boxes overlap a box, in the file's order.
    pub(crate) fn hits(&self, wanted: &Bounds) -> Vec<Hit> {
        let mut hits = Vec::new();
        let Some(all) = self.bounds() else {
            return hits;
        };
        for turns in all.turns_onto(wanted) {
            self.index.overlapping(&wanted.turned(-turns), &mut |part| {
                hits.push(Hit { part, turns });
                true
            });
        }
        hits.sort_unstable();
        hits
    }

    /// Calls `found` with every feature that has a point in the box, once and in the file's order,
    /// until it breaks. `areas` says whether the inside of polygons counts.
    pub(crate) fn reaching(
        &self,
        wanted: &Bounds,
        areas: bool,
        mut found: impl FnMut(usize) -> ControlFlow<()>,
    ) {
        let hits = self.hits(wanted);
        let feature = |hit: &Hit| self.part(hit.part).feature;
        for group in hits.chunk_by(|a, b| feature(a) == feature(b)) {
            if self.group_reaches(group, wanted, areas)
                && found(feature(&group[0]) as usize).is_break()
            {
                return;
            }
        }
    }

    /// Whether a feature of which these parts' boxes overlap the box has a point in it.
    fn group_reaches(&self, group: &[Hit], wanted: &Bounds, areas: bool) -> bool {
        let mut winding = 0;
        for hit in group {
            let part = self.part(hit.part);
            let wanted = wanted.turned(-hit.turns);
            if wanted.contains(&part.bounds) && (part.shape != Shape::Hole || !areas) {
                return true;
            }
            let mut edges = Edges {
                wanted,
                points: part.shape == Shape::Points,
                touched: false,
            };
            self.walk(part, &mut edges);
            if edges.touched {
                return true;
            }
            if areas && matches!(part.shape, Shape::Outer | Shape::Hole) {
                winding += self.winding(part, wanted.centre());
            }
        }
        winding != 0
    }

    /// How often a ring goes around a point.
    pub(crate) fn winding(&self, part: &Part, point: DVec2) -> i32 {
        let mut ray = Ray { point, winding: 0 };
        self.walk(part, &mut ray);
        if part.pole != 0 {
            let vertices = self.vertices_of(part);
            let y = f64::from(part.pole) * core::f64::consts::FRAC_PI_2;
            let (first, last) = (vertices[0], vertices[vertices.len() - 1]);
            let closure = [last, DVec2::new(last.x, y), DVec2::new(first.x, y), first];
            ray.chain(&closure, 0, 1);
        }
        ray.winding
    }
}

/// Looks for an edge in a box.
struct Edges {
    wanted: Bounds,
    points: bool,
    touched: bool,
}

impl Walker for Edges {
    fn look(&mut self, bounds: &Bounds) -> Visit {
        if self.wanted.overlaps(bounds) {
            Visit::Open
        } else {
            Visit::Skip
        }
    }

    fn chain(&mut self, vertices: &[DVec2], _at: usize, _stride: usize) -> bool {
        let inside = |v: &DVec2| self.wanted.overlaps(&Bounds { min: *v, max: *v });
        self.touched = if self.points || vertices.len() < 2 {
            vertices.iter().any(inside)
        } else {
            vertices.windows(2).any(|e| self.wanted.touches(e[0], e[1]))
        };
        !self.touched
    }
}

/// Counts crossings of the ray from a point eastward.
struct Ray {
    point: DVec2,
    winding: i32,
}

impl Walker for Ray {
    fn look(&mut self, bounds: &Bounds) -> Visit {
        let p = self.point;
        if bounds.max.x < p.x || bounds.max.y < p.y || bounds.min.y > p.y {
            Visit::Skip
        } else if bounds.min.x > p.x {
            // Wholly east of the point: only where it begins and ends matters.
            Visit::Chord
        } else {
            Visit::Open
        }
    }

    fn chain(&mut self, vertices: &[DVec2], _at: usize, _stride: usize) -> bool {
        let p = self.point;
        for edge in vertices.windows(2) {
            let (a, b) = (edge[0], edge[1]);
            if (a.y <= p.y) == (b.y <= p.y) {
                continue;
            }
            let left = (b.x - a.x) * (p.y - a.y) - (p.x - a.x) * (b.y - a.y);
            if b.y > a.y && left > 0.0 {
                self.winding += 1;
            } else if b.y < a.y && left < 0.0 {
                self.winding -= 1;
            }
        }
        true
    }
}
