//! Planning surfaces: stiff infills, needles, crowds of corners, steep boundaries.

use std::sync::Arc;

use glam::DVec2;
use relievo_engine::earthwork::{
    Design, Element, Frame, Polygon, Prepared, Shape, Side, Surface, Vertex, harmonic,
};
use relievo_engine::planet::{MapPoint, Planet};

use super::{Case, Extent, Found, worse, worst};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "smooth infill, stretched cells, condition number to 10¹²",
        truth: "a plane, which every mesh holds exactly",
        unit: "parts of the plane's height",
        limit: 1e-12,
        degrades: "not at all: elimination without a subtraction; textbook: conjugate gradients",
        measure: stretched_infill,
    },
    Case {
        name: "smooth infill, cells graded by 10⁶",
        truth: "a plane, which every mesh holds exactly",
        unit: "parts of the plane's height",
        limit: 1e-12,
        degrades: "not at all: elimination without a subtraction; textbook: conjugate gradients",
        measure: graded_infill,
    },
    Case {
        name: "long thin polygons, 1 km by 1 m to 1 mm: batters",
        truth: "closed form of the distance to a rectangle",
        unit: "m",
        limit: 1e-6,
        degrades: "not at all; corners nearer to each other than 1 µm are one",
        measure: thin_polygons,
    },
    Case {
        name: "10⁶ corners on one line of an outline: batters",
        truth: "closed form of the distance to a rectangle",
        unit: "m",
        limit: 1e-6,
        degrades: "not at all; time grows with the number of corners",
        measure: collinear_corners,
    },
    Case {
        name: "corners 10⁻⁹ m to 10⁻³ m apart in a triangulation: heights of a plane",
        truth: "the plane",
        unit: "m",
        limit: 1e-5,
        degrades: "corners nearer to each other than 1 µm are one",
        measure: crowded_corners,
    },
    Case {
        name: "boundaries up to a hundred times as steep as their batters: batters",
        truth: "search for the lowest cone along each edge",
        unit: "m",
        limit: 1e-6,
        degrades: "where a fill would lie above a cut, the nearest edge decides and ends in a wall",
        measure: steep_boundaries,
    },
];

/// Right triangles over cells between the given lines, and which nodes lie on the rim.
fn cells(x: &[f64], y: &[f64]) -> (Vec<DVec2>, Vec<[usize; 3]>, Vec<bool>) {
    let (columns, rows) = (x.len() - 1, y.len() - 1);
    let index = |c: usize, r: usize| r * (columns + 1) + c;
    let (mut at, mut triangles, mut is_rim) = (Vec::new(), Vec::new(), Vec::new());
    for (r, y) in y.iter().enumerate() {
        for (c, x) in x.iter().enumerate() {
            at.push(DVec2::new(*x, *y));
            is_rim.push(c == 0 || r == 0 || c == columns || r == rows);
            if c < columns && r < rows {
                let [a, b, d, e] =
                    [(c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)].map(|(c, r)| index(c, r));
                triangles.extend([[a, b, e], [a, e, d]]);
            }
        }
    }
    (at, triangles, is_rim)
}

/// Error of a plane of height 1 given at the rim: of the program's solver, and of conjugate gradients.
fn plane_error(x: &[f64], y: &[f64], gradient: DVec2) -> Found {
    let (at, triangles, is_rim) = cells(x, y);
    let plane: Vec<f64> = at.iter().map(|p| 250.0 + gradient.dot(*p)).collect();
    let known: Vec<Option<f64>> = plane
        .iter()
        .zip(&is_rim)
        .map(|(h, rim)| rim.then_some(*h))
        .collect();
    let error = |found: &[f64]| worst(found.iter().zip(&plane).map(|(f, p)| (f - p).abs()));
    Found {
        worst: error(&harmonic(&at, &triangles, &known)),
        plain: Some(error(&conjugate_gradients(&at, &triangles, &known))),
    }
}

/// The textbook's solver: cotangents added up, Jacobi's preconditioner, residual of 10⁻⁹ or 5000 steps.
fn conjugate_gradients(at: &[DVec2], triangles: &[[usize; 3]], known: &[Option<f64>]) -> Vec<f64> {
    let n = at.len();
    let mut entries: Vec<(usize, usize, f64)> = Vec::new();
    for t in triangles {
        for k in 0..3 {
            let (tip, a, b) = (at[t[k]], t[(k + 1) % 3], t[(k + 2) % 3]);
            let (u, v) = (at[a] - tip, at[b] - tip);
            let weight = 0.5 * u.dot(v) / u.perp_dot(v).abs();
            entries.extend([
                (a, b, -weight),
                (b, a, -weight),
                (a, a, weight),
                (b, b, weight),
            ]);
        }
    }
    let times = |x: &[f64]| {
        let mut out = vec![0.0; n];
        for (i, k, v) in &entries {
            out[*i] += v * x[*k];
        }
        for (o, known) in out.iter_mut().zip(known) {
            if known.is_some() {
                *o = 0.0;
            }
        }
        out
    };
    let mut diagonal = vec![0.0; n];
    for (i, _, v) in entries.iter().filter(|(i, k, _)| i == k) {
        diagonal[*i] += v;
    }
    let count = known.iter().flatten().count() as f64;
    let mean = known.iter().flatten().sum::<f64>() / count;
    let mut x: Vec<f64> = known.iter().map(|h| h.map_or(0.0, |h| h - mean)).collect();
    let mut residual: Vec<f64> = times(&x).iter().map(|v| -v).collect();
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut direction = scaled(&residual);
    let mut size = dot(&residual, &direction);
    let enough = size * 1e-18;
    for _ in 0..5_000 {
        let product = times(&direction);
        let curvature = dot(&direction, &product);
        if size <= enough || curvature <= 0.0 {
            break;
        }
        let step = size / curvature;
        for i in 0..n {
            x[i] += step * direction[i];
            residual[i] -= step * product[i];
        }
        let next = scaled(&residual);
        let next_size = dot(&residual, &next);
        for i in 0..n {
            direction[i] = next[i] + next_size / size * direction[i];
        }
        size = next_size;
    }
    x.iter().map(|x| x + mean).collect()
}

/// Worst of both.
fn both(found: impl IntoIterator<Item = Found>) -> Found {
    found.into_iter().fold(
        Found {
            worst: 0.0,
            plain: Some(0.0),
        },
        |a, b| Found {
            worst: worse(a.worst, b.worst),
            plain: a.plain.zip(b.plain).map(|(a, b)| worse(a, b)),
        },
    )
}

fn stretched_infill(extent: Extent) -> Found {
    let count: u32 = extent.pick(24, 80);
    let x: Vec<f64> = (0..=count)
        .map(|i| f64::from(i) / f64::from(count))
        .collect();
    both([1.0, 1e-3, 1e-6].into_iter().flat_map(|stretch| {
        let y: Vec<f64> = x.iter().map(|y| y * stretch).collect();
        [DVec2::X, DVec2::Y / stretch].map(|gradient| plane_error(&x, &y, gradient))
    }))
}

fn graded_infill(extent: Extent) -> Found {
    let count: u32 = extent.pick(24, 80);
    let grow = libm::pow(1e6, 1.0 / f64::from(count - 1));
    let mut x = vec![0.0];
    let mut step = 1.0;
    for _ in 0..count {
        x.push(x[x.len() - 1] + step);
        step *= grow;
    }
    let length = x[x.len() - 1];
    for x in &mut x {
        *x /= length;
    }
    both([DVec2::X, DVec2::new(0.5, -0.5)].map(|gradient| plane_error(&x, &x, gradient)))
}

fn alps() -> Frame {
    Frame::new(Planet::EARTH, MapPoint::from_degrees(11.4, 47.2))
}

fn design(frame: &Frame, outline: &[(DVec2, Option<f64>)], surface: Surface, side: Side) -> Design {
    let outline = outline
        .iter()
        .map(|(at, height_m)| Vertex {
            place: frame.to_map(*at),
            height_m: *height_m,
        })
        .collect();
    let polygon = Polygon {
        outline,
        holes: Vec::new(),
        breaklines: Vec::new(),
        surface,
    };
    let element = Element {
        shape: Shape::Polygon(polygon),
        side,
    };
    let shaped = Prepared::new(Planet::EARTH, Arc::new(element)).shape(&[]);
    Design::new(Planet::EARTH, vec![shaped])
}

const SIDE: Side = Side {
    cut_slope: 0.5,
    fill_slope: 0.25,
    wall: false,
    max_reach_m: 300.0,
};

/// Error of a platform 20 m over or under a level ground, around a rectangle about the origin.
fn rectangle_error(outline: &[(DVec2, Option<f64>)], half: DVec2, samples: u32) -> f64 {
    let frame = alps();
    let platform = design(&frame, outline, Surface::Platform { height_m: 500.0 }, SIDE);
    worst((0..samples).flat_map(|k| {
        let k = f64::from(k);
        let p = DVec2::new(
            (2.0 * (k * 0.618_034).fract() - 1.0) * (half.x + 90.0),
            (2.0 * (k * 0.754_878).fract() - 1.0) * (half.y + 90.0),
        );
        let distance = (p.abs() - half).max(DVec2::ZERO).length();
        [480.0, 520.0].map(|ground_m: f64| {
            let exact = ground_m.clamp(
                500.0 - SIDE.fill_slope * distance,
                500.0 + SIDE.cut_slope * distance,
            );
            (platform.height(frame.to_map(p), ground_m).height_m - exact).abs()
        })
    }))
}

fn rectangle(half: DVec2) -> Vec<(DVec2, Option<f64>)> {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| (DVec2::new(x, y) * half, None))
        .to_vec()
}

fn thin_polygons(extent: Extent) -> Found {
    let samples = extent.pick(300, 20_000);
    Found::only(worst([1.0, 1e-2, 1e-3].map(|width| {
        let half = DVec2::new(500.0, width / 2.0);
        rectangle_error(&rectangle(half), half, samples)
    })))
}

fn collinear_corners(extent: Extent) -> Found {
    let count: u32 = extent.pick(20_000, 1_000_000);
    let half = DVec2::new(500.0, 40.0);
    let mut outline = rectangle(half);
    let side = (1..count).map(|k| {
        let share = f64::from(k) / f64::from(count);
        (DVec2::new(half.x * (2.0 * share - 1.0), -half.y), None)
    });
    outline.splice(1..1, side);
    Found::only(rectangle_error(&outline, half, extent.pick(200, 2000)))
}

fn crowded_corners(extent: Extent) -> Found {
    let frame = alps();
    let plane = |p: DVec2| 700.0 + 0.3 * p.x - 0.2 * p.y;
    let apart = [1e-9, 1e-7, 2e-6, 1e-5, 1e-3];
    let samples = extent.pick(100, 5000);
    Found::only(worst(apart.map(|apart| {
        // A square whose corners are crowds.
        let corners = rectangle(DVec2::splat(200.0));
        let outline: Vec<(DVec2, Option<f64>)> = corners
            .iter()
            .flat_map(|(corner, _)| {
                (0..12).map(move |k| {
                    let turn = f64::from(k) / 11.0 - 0.5;
                    let along =
                        corner.perp().normalize() * turn + corner.normalize() * 0.3 * turn * turn;
                    *corner + along * apart * 12.0
                })
            })
            .map(|at| (at, Some(plane(at))))
            .collect();
        let tin = design(&frame, &outline, Surface::Tin, SIDE);
        worst((0..samples).map(|k| {
            let k = f64::from(k);
            let p =
                DVec2::new((k * 0.618_034).fract() - 0.5, (k * 0.754_878).fract() - 0.5) * 398.0;
            (tin.height(frame.to_map(p), 0.0).height_m - plane(p)).abs()
        }))
    })))
}

/// Lowest value over a segment of height plus slope times distance: convex, so searched by thirds.
fn lowest_cone(a: (DVec2, f64), b: (DVec2, f64), p: DVec2, slope: f64) -> f64 {
    let at = |t: f64| a.1 + t * (b.1 - a.1) + slope * (a.0.lerp(b.0, t) - p).length();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..120 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(left) <= at(right) {
            high = right;
        } else {
            low = left;
        }
    }
    at(low).min(at(high)).min(at(0.0)).min(at(1.0))
}

fn steep_boundaries(extent: Extent) -> Found {
    let frame = alps();
    let samples = extent.pick(150, 6000);
    // Rises along the sides, next to the slopes and far beyond them.
    let rises = [
        0.25,
        0.25 * (1.0 + 1e-15),
        0.25 * (1.0 - 1e-12),
        0.5,
        0.5 * (1.0 - 1e-15),
        0.7,
        5.0,
        50.0,
    ];
    Found::only(worst(rises.map(|rise| {
        let half = DVec2::new(30.0, 20.0);
        let outline: Vec<(DVec2, Option<f64>)> = rectangle(half)
            .into_iter()
            .map(|(at, _)| (at, Some(500.0 + rise * at.x)))
            .collect();
        let ends: Vec<(DVec2, f64)> = outline
            .iter()
            .map(|(at, h)| (*at, h.unwrap_or(0.0)))
            .collect();
        let tin = design(&frame, &outline, Surface::Tin, SIDE);
        worst((0..samples).filter_map(|k| {
            let k = f64::from(k);
            let p =
                DVec2::new((k * 0.618_034).fract() - 0.5, (k * 0.754_878).fract() - 0.5) * 260.0;
            if (p.abs() - half).max_element() <= 0.0 {
                return None;
            }
            let edges = || (0..4).map(|i| (ends[i], ends[(i + 1) % 4]));
            let upper = edges()
                .map(|(a, b)| lowest_cone(a, b, p, SIDE.cut_slope))
                .fold(f64::INFINITY, f64::min);
            let lower = edges()
                .map(|(a, b)| -lowest_cone((a.0, -a.1), (b.0, -b.1), p, SIDE.fill_slope))
                .fold(f64::NEG_INFINITY, f64::max);
            // Contradictions have a rule of their own, and so does the end of the reach.
            let away = (p.abs() - half).max(DVec2::ZERO).length();
            if lower > upper || away > SIDE.max_reach_m {
                return None;
            }
            let each = [-2000.0, 500.0, 3000.0].map(|ground_m: f64| {
                (tin.height(frame.to_map(p), ground_m).height_m - ground_m.clamp(lower, upper))
                    .abs()
            });
            Some(worst(each))
        }))
    })))
}
