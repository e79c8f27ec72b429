//! Smooth infill: a membrane through the ground's heights at the boundary.
//!
//! Laplace's equation by linear finite elements on a Delaunay mesh of boundary corners and a hexagonal
//! lattice inside, solved by conjugate gradients.

use glam::DVec2;

use crate::envelope::{Envelope, Segment};
use crate::rings::Rings;
use crate::tin::{Corner, Tin, triangulate};

/// Residual at which the solution is taken, relative to the start's.
pub(crate) const RESIDUAL: f64 = 1e-9;

/// Steps after which it is taken anyway.
const MOST_STEPS: usize = 5_000;

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
    solve(&mut nodes, fixed, &inside);
    Some(Tin::new(&nodes, &inside))
}

/// A symmetric matrix by rows.
struct Stiffness {
    rows: Vec<Vec<(usize, f64)>>,
}

impl Stiffness {
    /// Cotangent weights of the triangles.
    fn new(nodes: &[Corner], triangles: &[[usize; 3]]) -> Self {
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); nodes.len()];
        let mut add = |i: usize, k: usize, v: f64| match rows[i].iter_mut().find(|(at, _)| *at == k)
        {
            Some((_, sum)) => *sum += v,
            None => rows[i].push((k, v)),
        };
        for t in triangles {
            for k in 0..3 {
                let (tip, a, b) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                let (u, v) = (nodes[a].at - nodes[tip].at, nodes[b].at - nodes[tip].at);
                let area = u.perp_dot(v).abs();
                if area < 1e-12 {
                    continue;
                }
                let weight = (u.dot(v) / area * 0.5).clamp(-1e3, 1e3);
                add(a, b, -weight);
                add(b, a, -weight);
                add(a, a, weight);
                add(b, b, weight);
            }
        }
        Self { rows }
    }

    fn times(&self, from: usize, x: &[f64], out: &mut [f64]) {
        for (row, out) in self.rows[from..].iter().zip(&mut out[from..]) {
            *out = row.iter().map(|(k, v)| v * x[*k]).sum();
        }
    }
}

/// Solves for the nodes from `fixed` on; the others keep their heights.
fn solve(nodes: &mut [Corner], fixed: usize, triangles: &[[usize; 3]]) {
    let n = nodes.len();
    if fixed == 0 || fixed == n {
        return;
    }
    let mean = nodes[..fixed].iter().map(|c| c.height_m).sum::<f64>() / fixed as f64;
    // Heights above the mean: fewer digits to lose.
    let mut x: Vec<f64> = nodes
        .iter()
        .enumerate()
        .map(|(i, c)| if i < fixed { c.height_m - mean } else { 0.0 })
        .collect();
    let matrix = Stiffness::new(nodes, triangles);
    let diagonal: Vec<f64> = (0..n)
        .map(|i| {
            let own = matrix.rows[i].iter().find(|(k, _)| *k == i);
            own.map_or(1.0, |(_, v)| v.max(1e-9))
        })
        .collect();
    let mut product = vec![0.0; n];
    matrix.times(fixed, &x, &mut product);
    let mut residual: Vec<f64> = product.iter().map(|v| -v).collect();
    residual[..fixed].fill(0.0);
    let mut direction: Vec<f64> = residual.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let scaled = |r: &[f64]| -> f64 { r.iter().zip(&diagonal).map(|(r, d)| r * r / d).sum() };
    let mut size = scaled(&residual);
    let enough = size * RESIDUAL * RESIDUAL;
    for _ in 0..MOST_STEPS {
        if size <= enough || size == 0.0 {
            break;
        }
        matrix.times(fixed, &direction, &mut product);
        let curvature = dot(&direction[fixed..], &product[fixed..]);
        if curvature <= 0.0 {
            break;
        }
        let step = size / curvature;
        for i in fixed..n {
            x[i] += step * direction[i];
            residual[i] -= step * product[i];
        }
        let next = scaled(&residual);
        let keep = next / size;
        for i in fixed..n {
            direction[i] = residual[i] / diagonal[i] + keep * direction[i];
        }
        size = next;
    }
    for (node, x) in nodes.iter_mut().zip(x).skip(fixed) {
        node.height_m = mean + x;
    }
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
