//! Geometries whose longitudes go on beyond ±180° as parts within (RFC 7946, 3.1.9).

use std::borrow::Cow;

use super::{Geometry, Position};

/// A geometry with longitudes from −180 to 180: lines and polygons that go on beyond are cut at the
/// antimeridian, and a polygon that goes once around a pole reaches it.
///
/// Neighbours must lie less than 180° of longitude apart where they go beyond.
pub(super) fn within(geometry: &Geometry) -> Cow<'_, Geometry> {
    let outside = |p: &Position| !(-180.0..=180.0).contains(&p.lon_deg);
    let goes_around = match geometry {
        Geometry::Polygons(polygons) => polygons.iter().flatten().any(|ring| turn(ring) != 0.0),
        Geometry::Points(_) | Geometry::Lines(_) => false,
    };
    if !goes_around && !geometry.positions().any(outside) {
        return Cow::Borrowed(geometry);
    }
    Cow::Owned(match geometry {
        Geometry::Points(points) => {
            let wrapped = points.iter().map(|p| Position {
                lon_deg: (p.lon_deg + 180.0).rem_euclid(360.0) - 180.0,
                ..*p
            });
            Geometry::Points(wrapped.collect())
        }
        Geometry::Lines(lines) => Geometry::Lines(lines.iter().flat_map(|l| line(l)).collect()),
        Geometry::Polygons(polygons) => {
            Geometry::Polygons(polygons.iter().flat_map(|rings| polygon(rings)).collect())
        }
    })
}

/// Which turn around the planet a longitude lies in, 0 from −180 to 180.
fn turn_of(lon_deg: f64) -> f64 {
    ((lon_deg + 180.0) / 360.0).floor()
}

/// The place between two where the longitude is `lon_deg`.
fn between(from: &Position, to: &Position, lon_deg: f64) -> Position {
    let share = (lon_deg - from.lon_deg) / (to.lon_deg - from.lon_deg);
    Position {
        lon_deg,
        lat_deg: from.lat_deg + (to.lat_deg - from.lat_deg) * share,
        height_m: from
            .height_m
            .zip(to.height_m)
            .map(|(from, to)| from + (to - from) * share),
    }
}

fn shifted(p: &Position, turn: f64) -> Position {
    Position {
        lon_deg: (p.lon_deg - 360.0 * turn).clamp(-180.0, 180.0),
        ..*p
    }
}

fn line(points: &[Position]) -> Vec<Vec<Position>> {
    let mut parts = Vec::new();
    let mut part: Vec<Position> = Vec::new();
    for (i, point) in points.iter().enumerate() {
        let turn = turn_of(point.lon_deg);
        if let Some(before) = i.checked_sub(1).map(|i| &points[i]) {
            let from = turn_of(before.lon_deg);
            if from != turn {
                let edge = between(before, point, 360.0 * from.max(turn) - 180.0);
                let end = shifted(&edge, from);
                if part.last() != Some(&end) {
                    part.push(end);
                }
                parts.push(std::mem::take(&mut part));
                part.push(shifted(&edge, turn));
            }
        }
        part.push(shifted(point, turn));
    }
    // What touches the edge with its end only has no length beyond.
    parts.push(part);
    parts.retain(|part| part.len() != 2 || part[0] != part[1]);
    parts
}

/// By how much a ring goes around, in degrees: ±360 around a pole, else 0.
fn turn(ring: &[Position]) -> f64 {
    let (Some(first), Some(last)) = (ring.first(), ring.last()) else {
        return 0.0;
    };
    let step = first.lon_deg - last.lon_deg;
    // A closed ring ends where it begins, an open one less than half a turn from there.
    -(step / 360.0).round() * 360.0
}

/// A ring that is whole on the unrolled map: one around a pole goes along that, the nearer one.
fn unrolled(ring: &[Position]) -> Vec<Position> {
    let around = turn(ring);
    let mut ring = ring.to_vec();
    if around == 0.0 {
        return ring;
    }
    let mean = ring.iter().map(|p| p.lat_deg).sum::<f64>() / ring.len() as f64;
    let first = ring[0];
    let end = Position {
        lon_deg: first.lon_deg + around,
        ..first
    };
    let pole = |p: Position| Position {
        lat_deg: 90.0_f64.copysign(mean),
        ..p
    };
    ring.extend([end, pole(end), pole(first)]);
    ring
}

fn polygon(rings: &[Vec<Position>]) -> Vec<Vec<Vec<Position>>> {
    let Some((outer, holes)) = rings.split_first() else {
        return Vec::new();
    };
    let outer = unrolled(outer);
    let range = |ring: &[Position]| {
        let lon = ring.iter().map(|p| p.lon_deg);
        (
            lon.clone().fold(f64::INFINITY, f64::min),
            lon.fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (low, high) = range(&outer);
    // Holes may be counted from another turn than their outline.
    let beside = |hole: &Vec<Position>| -> Vec<Position> {
        let hole = unrolled(hole);
        let (west, east) = range(&hole);
        let lies = |by: &f64| west + by >= low - 1e-9 && east + by <= high + 1e-9;
        let by = [0.0, -360.0, 360.0].into_iter().find(lies).unwrap_or(0.0);
        let moved = hole.iter().map(|p| Position {
            lon_deg: p.lon_deg + by,
            ..*p
        });
        moved.collect()
    };
    let holes: Vec<Vec<Position>> = holes.iter().map(beside).collect();
    // One that ends at an edge has nothing beyond.
    let (first, last) = (turn_of(low), -turn_of(-high));
    let mut parts = Vec::new();
    let mut turn = first;
    while turn <= last {
        let cut = |ring: &[Position]| -> Vec<Position> {
            let (west, east) = (360.0 * turn - 180.0, 360.0 * turn + 180.0);
            let ring = clipped(&clipped(ring, west, 1.0), east, -1.0);
            ring.iter().map(|p| shifted(p, turn)).collect()
        };
        let part = cut(&outer);
        if part.len() >= 3 {
            let holes = holes.iter().map(|hole| cut(hole));
            let mut rings = vec![part];
            rings.extend(holes.filter(|ring| ring.len() >= 3));
            parts.push(rings);
        }
        turn += 1.0;
    }
    parts
}

/// The part of a ring east (`side` 1) or west (−1) of a meridian (Sutherland and Hodgman 1974); empty
/// where it only touches it.
fn clipped(ring: &[Position], lon_deg: f64, side: f64) -> Vec<Position> {
    let inside = |p: &Position| (p.lon_deg - lon_deg) * side >= 0.0;
    if !ring.iter().any(|p| (p.lon_deg - lon_deg) * side > 0.0) {
        return Vec::new();
    }
    let mut kept = Vec::new();
    for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        if inside(from) {
            kept.push(*from);
        }
        if inside(from) != inside(to) && from.lon_deg != lon_deg && to.lon_deg != lon_deg {
            kept.push(between(from, to, lon_deg));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(points: &[[f64; 2]]) -> Vec<Position> {
        points.iter().map(|p| Position::new(p[0], p[1])).collect()
    }

    /// Twice the area in square degrees.
    fn twice(ring: &[Position]) -> f64 {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        edges
            .map(|(a, b)| a.lon_deg * b.lat_deg - b.lon_deg * a.lat_deg)
            .sum::<f64>()
            .abs()
    }

    #[test]
    fn a_line_across_the_antimeridian_is_cut_there() {
        let cut = |points: &[[f64; 2]]| within(&Geometry::Lines(vec![places(points)])).into_owned();
        assert_eq!(
            cut(&[[179.0, 0.0], [181.0, 2.0]]),
            Geometry::Lines(vec![
                places(&[[179.0, 0.0], [180.0, 1.0]]),
                places(&[[-180.0, 1.0], [-179.0, 2.0]]),
            ])
        );
        assert_eq!(
            cut(&[[-179.0, 0.0], [-180.0, 1.0], [-181.0, 2.0]]),
            Geometry::Lines(vec![
                places(&[[-179.0, 0.0], [-180.0, 1.0]]),
                places(&[[180.0, 1.0], [179.0, 2.0]]),
            ])
        );
        let inside = Geometry::Lines(vec![places(&[[-180.0, 0.0], [180.0, 0.0]])]);
        assert_eq!(*within(&inside), inside);
    }

    #[test]
    fn heights_are_carried_over_the_cut() {
        let mut line = places(&[[170.0, 0.0], [190.0, 0.0]]);
        (line[0].height_m, line[1].height_m) = (Some(10.0), Some(30.0));
        let Geometry::Lines(parts) = within(&Geometry::Lines(vec![line])).into_owned() else {
            panic!("lines stay lines")
        };
        assert_eq!(parts[0][1].height_m, Some(20.0));
        assert_eq!(parts[1][0].height_m, Some(20.0));
    }

    #[test]
    fn the_parts_of_a_polygon_and_its_hole_have_the_area_of_the_whole() {
        let outer = places(&[[170.0, 0.0], [200.0, 0.0], [200.0, 10.0], [170.0, 10.0]]);
        // The hole is counted from the other side.
        let hole = places(&[[-185.0, 2.0], [-185.0, 4.0], [-175.0, 4.0], [-175.0, 2.0]]);
        let whole = twice(&outer) - twice(&hole);
        let Geometry::Polygons(parts) =
            within(&Geometry::Polygons(vec![vec![outer, hole]])).into_owned()
        else {
            panic!("polygons stay polygons")
        };
        assert_eq!(parts.len(), 2);
        let area = |rings: &Vec<Vec<Position>>| {
            twice(&rings[0]) - rings[1..].iter().map(|r| twice(r)).sum::<f64>()
        };
        let all: f64 = parts.iter().map(area).sum();
        assert!((all - whole).abs() < 1e-9, "{parts:?}");
        let lon = parts.iter().flatten().flatten().map(|p| p.lon_deg);
        assert!(lon.clone().all(|l| (-180.0..=180.0).contains(&l)));
    }

    #[test]
    fn a_ring_around_a_pole_reaches_it() {
        let ring = places(&[[-90.0, -80.0], [0.0, -80.0], [90.0, -80.0], [180.0, -80.0]]);
        let Geometry::Polygons(parts) = within(&Geometry::Polygons(vec![vec![ring]])).into_owned()
        else {
            panic!("polygons stay polygons")
        };
        let all: f64 = parts.iter().map(|rings| twice(&rings[0])).sum();
        assert!((all - 2.0 * 360.0 * 10.0).abs() < 1e-9, "{parts:?}");
        let lowest = parts.iter().flatten().flatten().map(|p| p.lat_deg);
        assert_eq!(lowest.fold(0.0, f64::min), -90.0);
    }
}
