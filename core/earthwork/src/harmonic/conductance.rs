//! Conductances of a mesh's edges: ½ (cot α + cot β) of the angles opposite to them, without the ½.
//!
//! In a stretched mesh two cotangents of 10⁶ differ by 10⁻⁶. Their sum is therefore formed as one
//! fraction with twofold precision (about 32 digits), exact where coordinates are.

use glam::DVec2;

use crate::twofold::Twofold;

/// (a, b, conductance) of all edges with a < b, each once, in order; none is negative.
pub(super) fn conductances(at: &[DVec2], triangles: &[[usize; 3]]) -> Vec<(usize, usize, f64)> {
    let mut sides: Vec<(usize, usize, usize)> = triangles
        .iter()
        .flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3], t[(k + 2) % 3])))
        .map(|(a, b, tip)| (a.min(b), a.max(b), tip))
        .collect();
    sides.sort_unstable();
    sides
        .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
        .map(|same| {
            let (a, b, _) = same[0];
            // Degenerate triangles have no area, and no part in the integral.
            let angles = same
                .iter()
                .map(|(_, _, tip)| Angle::at(at[*tip], at[a], at[b]))
                .filter(|angle| angle.cross.value() > 0.0);
            let sum = angles.reduce(|x, y| Angle {
                dot: x.dot * y.cross + y.dot * x.cross,
                cross: x.cross * y.cross,
            });
            (a, b, sum.map_or(0.0, |s| s.dot.value() / s.cross.value()))
        })
        .filter(|(_, _, conductance)| *conductance > 0.0 && conductance.is_finite())
        .collect()
}

/// An angle, or a sum of two, by what its cotangent is a quotient of.
#[derive(Clone, Copy)]
struct Angle {
    dot: Twofold,
    cross: Twofold,
}

impl Angle {
    fn at(tip: DVec2, a: DVec2, b: DVec2) -> Self {
        let [ux, uy, vx, vy] = [(a.x, tip.x), (a.y, tip.y), (b.x, tip.x), (b.y, tip.y)]
            .map(|(p, q)| Twofold::difference(p, q));
        let cross = ux * vy - uy * vx;
        Self {
            dot: ux * vx + uy * vy,
            cross: if cross.value() < 0.0 { -cross } else { cross },
        }
    }
}
