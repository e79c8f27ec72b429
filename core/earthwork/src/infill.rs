//! Smooth infill: a membrane through the ground's heights at the boundary.
//!
//! Laplace's equation by linear finite elements on a Delaunay mesh of boundary corners and a hexagonal
//! lattice inside; solved by [`harmonic`].

use glam::DVec2;

use crate::envelope::{Envelope, Segment};
use crate::harmonic::harmonic;
use crate::rings::Rings;
use crate::tin::{Corner, Tin, triangulate};

/// Nodes inside, at most.
const MOST_NODES: f64 = 30_000.0;

/// The membrane through the corners on the boundary; `None` where there is no mesh.
pub(crate) fn membrane(
    corners: &[Corner],
    boundary: &[[u32; 2]],
    rings: &Rings,
    spacing_m: f64,
) -> Option<Tin> {
    let mut nodes: Vec<Corner> = corners.to_vec();
    let fixed = nodes.len();
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for c in corners {
        min = min.min(c.at);
        max = max.max(c.at);
    }
    let size = max - min;
    let spacing = spacing_m.max((size.x * size.y / MOST_NODES).sqrt());
    let segments: Vec<Segment> = boundary
        .iter()
        .map(|[a, b]| Segment {
            from: corners[*a as usize].at,
            to: corners[*b as usize].at,
            from_m: 0.0,
            to_m: 0.0,
        })
        .collect();
    let near = Envelope::new(&segments, None);
    let rise = spacing * 0.75_f64.sqrt();
    let rows = (size.y / rise).ceil().min(1e4) as usize;
    let columns = (size.x / spacing).ceil().min(1e4) as usize;
    for row in 0..=rows {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for column in 0..=columns {
            let at = min + DVec2::new((column as f64 + shift) * spacing, row as f64 * rise);
            if rings.contains(at) && near.distance(at) > 0.6 * spacing {
                nodes.push(Corner { at, height_m: 0.0 });
            }
        }
    }
    let at: Vec<DVec2> = nodes.iter().map(|n| n.at).collect();
    let lines: Vec<[usize; 2]> = boundary.iter().map(|b| b.map(|k| k as usize)).collect();
    let (triangles, _) = triangulate(&at, &lines)?;
    let inside: Vec<[usize; 3]> = triangles
        .into_iter()
        .filter(|t| rings.contains((at[t[0]] + at[t[1]] + at[t[2]]) / 3.0))
        .collect();
    let known_m: Vec<Option<f64>> = nodes
        .iter()
        .enumerate()
        .map(|(i, c)| (i < fixed).then_some(c.height_m))
        .collect();
    for (node, height_m) in nodes.iter_mut().zip(harmonic(&at, &inside, &known_m)) {
        node.height_m = height_m;
    }
    Some(Tin::new(&nodes, &inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_membrane_keeps_a_harmonic_function_to_second_order() {
        // x² − y² is harmonic; on a square of 2 by 2.
        let exact = |p: DVec2| p.x * p.x - p.y * p.y;
        let error = |parts: usize| {
            let mut corners = Vec::new();
            let side = [
                DVec2::new(-1.0, -1.0),
                DVec2::new(1.0, -1.0),
                DVec2::new(1.0, 1.0),
                DVec2::new(-1.0, 1.0),
            ];
            for k in 0..4 {
                for i in 0..parts {
                    let at = side[k] + (side[(k + 1) % 4] - side[k]) * (i as f64 / parts as f64);
                    corners.push(Corner {
                        at,
                        height_m: 500.0 + exact(at),
                    });
                }
            }
            let n = corners.len() as u32;
            let boundary: Vec<[u32; 2]> = (0..n).map(|i| [i, (i + 1) % n]).collect();
            let rings = Rings::new(&side, &[]);
            let tin = membrane(&corners, &boundary, &rings, 2.0 / parts as f64).unwrap();
            let mut found = Vec::new();
            let mut worst: f64 = 0.0;
            for i in 0..40 {
                for k in 0..40 {
                    let p =
                        DVec2::new(-0.97 + f64::from(i) * 0.0497, -0.97 + f64::from(k) * 0.0497);
                    tin.gather(p, p, &mut found);
                    worst = worst.max((tin.height_m(p, &found).unwrap() - 500.0 - exact(p)).abs());
                }
            }
            worst
        };
        let errors = [error(10), error(20), error(40)];
        let order = libm::log2(errors[0] / errors[2]) / 2.0;
        assert!(errors[2] < 2e-3 && order > 1.6, "{errors:?} order {order}");
    }
}
