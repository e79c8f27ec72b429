//! Triangles through heights.

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::tree::{Bounds, Tree};

/// A corner of a triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) at: DVec2,
    pub(crate) height_m: f64,
}

struct Indexed {
    at: Point2<f64>,
    index: usize,
}

impl HasPosition for Indexed {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Triangles as indices of corners, counter-clockwise, of the constrained Delaunay triangulation;
/// and how many of `lines` could not be kept. Lines must not cross; corners are finite.
///
/// `None` when all corners stand on one line.
pub(crate) fn triangulate(
    corners: &[DVec2],
    lines: &[[usize; 2]],
) -> Option<(Vec<[usize; 3]>, usize)> {
    // Spade refuses numbers this small.
    let clean = |v: f64| if v.abs() < 1e-30 { 0.0 } else { v };
    let vertices: Vec<Indexed> = corners
        .iter()
        .enumerate()
        .map(|(index, p)| Indexed {
            at: Point2::new(clean(p.x), clean(p.y)),
            index,
        })
        .collect();
    let edges: Vec<[usize; 2]> = lines
        .iter()
        .copied()
        .filter(|[a, b]| a != b && *a < corners.len() && *b < corners.len())
        .collect();
    let mut dropped = 0;
    let cdt = ConstrainedDelaunayTriangulation::<Indexed>::try_bulk_load_cdt(
        vertices,
        edges,
        |_conflict| dropped += 1,
    )
    .ok()?;
    let mut triangles: Vec<[usize; 3]> = cdt
        .inner_faces()
        .map(|f| f.vertices().map(|v| v.data().index))
        .collect();
    // An order that depends on nothing but the corners.
    for t in &mut triangles {
        let first = (0..3).min_by_key(|k| t[*k]).unwrap_or(0);
        t.rotate_left(first);
    }
    triangles.sort_unstable();
    (!triangles.is_empty()).then_some((triangles, dropped))
}

/// A surface of triangles.
#[derive(Clone, Debug)]
pub(crate) struct Tin {
    triangles: Vec<[Corner; 3]>,
    tree: Tree,
}

impl Tin {
    pub(crate) fn new(corners: &[Corner], triangles: &[[usize; 3]]) -> Self {
        let triangles: Vec<[Corner; 3]> = triangles
            .iter()
            .map(|t| shortest_first(t.map(|k| corners[k])))
            .collect();
        let bounds: Vec<Bounds> = triangles
            .iter()
            .map(|[a, b, c]| {
                Bounds::flat(
                    a.at.min(b.at).min(c.at) - SLACK_M,
                    a.at.max(b.at).max(c.at) + SLACK_M,
                )
            })
            .collect();
        Self {
            tree: Tree::new(&bounds),
            triangles,
        }
    }

    /// Triangles that touch a rectangle, in order.
    pub(crate) fn gather(&self, min: DVec2, max: DVec2, found: &mut Vec<u32>) {
        found.clear();
        let window = Bounds::flat(min - 2.0 * SLACK_M, max + 2.0 * SLACK_M);
        self.tree.visit(|b| b.overlaps(&window), |i| found.push(i));
        found.sort_unstable();
    }

    /// Height at a point from what was gathered around it; `None` outside of all triangles.
    pub(crate) fn height_m(&self, p: DVec2, found: &[u32]) -> Option<f64> {
        let mut near: Option<(f64, f64)> = None;
        for i in found {
            let [a, b, c] = &self.triangles[*i as usize];
            let area = (b.at - a.at).perp_dot(c.at - a.at);
            if area == 0.0 {
                continue;
            }
            let wb = (p - a.at).perp_dot(c.at - a.at) / area;
            let wc = (b.at - a.at).perp_dot(p - a.at) / area;
            let wa = 1.0 - wb - wc;
            let least = wa.min(wb).min(wc);
            let height =
                a.height_m + wb * (b.height_m - a.height_m) + wc * (c.height_m - a.height_m);
            if least >= 0.0 {
                return Some(height);
            }
            // A point on an edge may lie outside of both triangles by rounding.
            let longest = (b.at - a.at)
                .length_squared()
                .max((c.at - a.at).length_squared())
                .max((c.at - b.at).length_squared());
            let off = least * area.abs() / longest.sqrt();
            if off > -SLACK_M && near.is_none_or(|(best, _)| off > best) {
                near = Some((off, height));
            }
        }
        near.map(|(_, height)| height)
    }
}

/// The same triangle, turned so that its first two corners are the two nearest to each other.
///
/// Weights are quotients by the area. In a needle the area keeps its digits only as the cross product
/// of the short edge with a long one, and what two long edges say of the far end's weight is noise.
fn shortest_first(mut corners: [Corner; 3]) -> [Corner; 3] {
    let length = |k: usize| (corners[(k + 1) % 3].at - corners[k].at).length_squared();
    let shortest = (0..3).min_by(|a, b| length(*a).total_cmp(&length(*b)));
    corners.rotate_left(shortest.unwrap_or(0));
    corners
}

/// How far outside of all triangles a point still belongs to one, metres.
const SLACK_M: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needles_keep_the_plane_through_their_corners_in_any_order_of_corners() {
        // A kilometre long and from a nanometre to a metre wide, away from the origin.
        let plane = |p: DVec2| 300.0 + 0.7 * p.x - 1.3 * p.y;
        let far = DVec2::new(-1203.3, 877.1);
        let along = DVec2::new(0.6, 0.8);
        for width in [1e-9, 1e-6, 1e-3, 1.0] {
            let at = [far, far + along.perp() * width, far + along * 1000.0];
            let corners = at.map(|at| Corner {
                at,
                height_m: plane(at),
            });
            for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                let tin = Tin::new(&corners, &[order]);
                for k in 0..=50 {
                    let p = at[0].lerp(at[2], f64::from(k) / 50.0);
                    let height_m = tin.height_m(p, &[0]).expect("on the edge");
                    assert!(
                        (height_m - plane(p)).abs() < 1e-9,
                        "{width} {order:?} {k}: {height_m}"
                    );
                }
            }
        }
    }
}
