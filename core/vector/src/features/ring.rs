//! Rings and lines on a globe: across the antimeridian, around a pole.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

/// Longitudes that close to the antimeridian lie on it: files have it rounded.
const ON_ANTIMERIDIAN_RAD: f64 = 1e-9;

/// Whether a longitude is the antimeridian's.
pub(crate) fn on_antimeridian(lon_rad: f64) -> bool {
    let turned = (lon_rad / TAU + 0.5).rem_euclid(1.0);
    turned.min(1.0 - turned) * TAU < ON_ANTIMERIDIAN_RAD
}

/// Brings longitudes to run on from vertex to vertex: where two differ by more than half a turn
/// the edge crosses the antimeridian the short way, unless both lie on it (as the corners of a map
/// of the world do).
pub(super) fn unwrap(vertices: &mut [DVec2]) {
    let mut turn = 0.0;
    for i in 1..vertices.len() {
        let before = vertices[i - 1].x;
        let here = vertices[i].x;
        let step = here + turn - before;
        if step.abs() > PI && !(on_antimeridian(before) && on_antimeridian(here)) {
            turn -= TAU * libm::round(step / TAU);
        }
        vertices[i].x = here + turn;
    }
}

/// A ring as it is kept.
pub(super) struct Ring {
    /// Closed: the last is the first, or the first a turn further on. Counterclockwise (seen from
    /// above) for outer rings, clockwise for holes.
    pub(super) vertices: Vec<DVec2>,
    /// 1 if the inside reaches to the north pole, −1 if to the south pole, else 0.
    pub(super) pole: i8,
}

/// Closes a ring and finds out what is inside of it. `encloses_north` says which pole a ring that
/// goes around the globe encloses, where the file's own plane shows it; otherwise the nearer one
/// counts, and near the equator the one to the left of an outer ring (RFC 7946).
pub(super) fn ring(
    mut vertices: Vec<DVec2>,
    is_hole: bool,
    encloses_north: Option<bool>,
) -> Option<Ring> {
    vertices.dedup();
    let first = *vertices.first()?;
    vertices.push(first);
    unwrap(&mut vertices);
    let count = vertices.len();
    let turn = vertices[count - 1].x - first.x;
    let goes_around = turn.abs() > PI;
    if count >= 2 && !goes_around && vertices[count - 2] == vertices[count - 1] {
        vertices.pop();
    }
    let mut pole = 0_i8;
    if goes_around {
        let middle = vertices.iter().map(|v| v.y).sum::<f64>() / count as f64;
        let north = encloses_north.unwrap_or_else(|| {
            if middle.abs() > PI / 6.0 {
                middle > 0.0
            } else {
                (turn > 0.0) != is_hole
            }
        });
        pole = if north { 1 } else { -1 };
    }
    if !goes_around && vertices.len() < 4 {
        return None;
    }
    if (area(&vertices, pole) < 0.0) != is_hole {
        vertices.reverse();
    }
    Some(Ring { vertices, pole })
}

/// Signed area in the plane of longitude and latitude, with the way to the pole and back.
fn area(closed: &[DVec2], pole: i8) -> f64 {
    let (first, last) = (closed[0], closed[closed.len() - 1]);
    let cross = |a: DVec2, b: DVec2| {
        let (a, b) = (a - first, b - first);
        a.x * b.y - a.y * b.x
    };
    let along: f64 = closed.windows(2).map(|e| cross(e[0], e[1])).sum();
    if pole == 0 {
        return 0.5 * along;
    }
    let y = f64::from(pole) * FRAC_PI_2;
    let (above_last, above_first) = (DVec2::new(last.x, y), DVec2::new(first.x, y));
    0.5 * (along + cross(last, above_last) + cross(above_last, above_first))
}
