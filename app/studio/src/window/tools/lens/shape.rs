//! The shape of a lens: what becomes of it when it is dragged, drawn or turned into another one.
//!
//! Corners are metres east and north in the frame at the lens's centre; places are on the map.

use glam::{DVec2, DVec3};
use relievo_engine::earthwork::Frame;
use relievo_engine::planet::{MapPoint, Planet};
use relievo_engine::project::{Lens, LensShape};

/// Corners of the polygon that a circle becomes.
const CORNERS_OF_CIRCLE: u32 = 6;

/// Steps that a drag takes until the pointer is where the lens was taken.
const MOST_STEPS: usize = 8;

/// The plane of a lens's corners.
pub(super) fn frame(planet: Planet, lens: &Lens) -> Frame {
    Frame::new(planet, MapPoint::from_degrees(lens.lon_deg, lens.lat_deg))
}

/// The corners of a polygon.
pub(super) fn corners(lens: &Lens) -> Option<&[[f64; 2]]> {
    match &lens.shape {
        LensShape::Polygon { corners_m } => Some(corners_m),
        LensShape::Circle { .. } => None,
    }
}

fn with_corners(lens: &Lens, corners_m: Vec<[f64; 2]>) -> Lens {
    Lens {
        shape: LensShape::Polygon { corners_m },
        ..lens.clone()
    }
}

/// The lens with its centre elsewhere.
pub(super) fn centred(lens: &Lens, place: MapPoint) -> Lens {
    let (lon_deg, lat_deg) = place.to_degrees();
    Lens {
        lon_deg,
        lat_deg,
        ..lens.clone()
    }
}

/// The lens moved until a place of its plane is at a place of the map.
pub(super) fn carried(planet: Planet, lens: &Lens, taken_m: DVec2, to: MapPoint) -> Lens {
    // The frame turns a little as it moves, so that the way back from the place is not quite the way.
    let mut centre = Frame::new(planet, to).to_map(-taken_m);
    for _ in 0..MOST_STEPS {
        let at = Frame::new(planet, centre);
        let miss_m = at.from_map(to) - taken_m;
        if miss_m.length() <= 1e-9 * planet.radius_m {
            break;
        }
        centre = at.to_map(miss_m);
    }
    centred(lens, centre)
}

/// The lens with a corner at a place.
pub(super) fn with_corner(planet: Planet, lens: &Lens, index: usize, place: MapPoint) -> Lens {
    let mut corners_m = corners(lens).unwrap_or_default().to_vec();
    if let Some(corner) = corners_m.get_mut(index) {
        *corner = storable(frame(planet, lens).from_map(place));
    }
    with_corners(lens, corners_m)
}

/// The lens with a corner more in the middle of the edge after one; `None` where it has as many as may be.
pub(super) fn inserted(lens: &Lens, after: usize) -> Option<Lens> {
    let mut corners_m = corners(lens)?.to_vec();
    if corners_m.len() >= LensShape::MOST_CORNERS {
        return None;
    }
    let middle = middle_m(&corners_m, after)?;
    corners_m.insert(after + 1, storable(middle));
    Some(with_corners(lens, corners_m))
}

/// The lens with a corner less; `None` where too few would be left.
pub(super) fn removed(lens: &Lens, index: usize) -> Option<Lens> {
    let mut corners_m = corners(lens)?.to_vec();
    if corners_m.len() <= LensShape::LEAST_CORNERS || index >= corners_m.len() {
        return None;
    }
    corners_m.remove(index);
    Some(with_corners(lens, corners_m))
}

/// The middle of the edge after a corner.
pub(super) fn middle_m(corners_m: &[[f64; 2]], after: usize) -> Option<DVec2> {
    let a = corners_m.get(after)?;
    let b = corners_m.get(after + 1).or(corners_m.first())?;
    Some(DVec2::from_array(*a).midpoint(DVec2::from_array(*b)))
}

/// Whether a place of the plane lies inside, by the even-odd rule.
pub(super) fn contains(corners_m: &[[f64; 2]], point: DVec2) -> bool {
    let next = corners_m.iter().cycle().skip(1);
    let crossed = corners_m.iter().zip(next).filter(|(a, b)| {
        (a[1] > point.y) != (b[1] > point.y)
            && a[0] + (point.y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > point.x
    });
    crossed.count() % 2 == 1
}

/// Distance of the farthest corner from the centre, metres.
pub(super) fn reach_m(corners_m: &[[f64; 2]]) -> f64 {
    let distances = corners_m.iter().map(|c| c[0].hypot(c[1]));
    distances.fold(0.0, f64::max)
}

/// Square metres inside, in the lens's own plane.
pub(in crate::window) fn area_m2(shape: &LensShape) -> f64 {
    match shape {
        LensShape::Circle { radius_m } => core::f64::consts::PI * radius_m * radius_m,
        LensShape::Polygon { corners_m } => {
            let corners: Vec<DVec2> = corners_m.iter().map(|c| DVec2::from_array(*c)).collect();
            even_odd_area_m2(&corners)
        }
    }
}

/// Area by the even-odd rule: exact, in strips between the heights at which the outline bends or crosses
/// itself.
fn even_odd_area_m2(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let edges: Vec<(DVec2, DVec2)> = corners
        .iter()
        .zip(next)
        .map(|(a, b)| if a.y <= b.y { (*a, *b) } else { (*b, *a) })
        .filter(|(a, b)| a.y < b.y)
        .collect();
    let mut levels: Vec<f64> = corners.iter().map(|c| c.y).collect();
    for (i, (a, b)) in edges.iter().enumerate() {
        for (c, d) in &edges[i + 1..] {
            let (along, other) = (*b - *a, *d - *c);
            let share = (*c - *a).perp_dot(other) / along.perp_dot(other);
            let crossing = a.y + share * along.y;
            if crossing > a.y.max(c.y) && crossing < b.y.min(d.y) {
                levels.push(crossing);
            }
        }
    }
    levels.sort_by(f64::total_cmp);
    let x = |(a, b): &(DVec2, DVec2), y: f64| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    let mut area_m2 = 0.0;
    for pair in levels.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        let middle = 0.5 * (low + high);
        let crossed = edges.iter().filter(|(a, b)| a.y <= middle && middle < b.y);
        let mut xs: Vec<f64> = crossed.map(|edge| x(edge, middle)).collect();
        xs.sort_by(f64::total_cmp);
        let widths = xs.chunks_exact(2).map(|pair| pair[1] - pair[0]);
        area_m2 += widths.sum::<f64>() * (high - low);
    }
    area_m2
}

/// The lens as a hexagon of its area.
pub(in crate::window) fn as_polygon(lens: &Lens) -> Lens {
    let LensShape::Circle { radius_m } = lens.shape else {
        return lens.clone();
    };
    let step = core::f64::consts::TAU / f64::from(CORNERS_OF_CIRCLE);
    // A regular polygon has the area ½ n R² sin(2π / n).
    let widen = (step / step.sin()).sqrt();
    let farthest_m = (radius_m * widen).clamp(1.0, LensShape::FARTHEST_M);
    let corner = |k: u32| {
        let (sin, cos) = (step * f64::from(k)).sin_cos();
        storable(DVec2::new(-sin, cos) * farthest_m)
    };
    with_corners(lens, (0..CORNERS_OF_CIRCLE).map(corner).collect())
}

/// The lens as a circle of its area around the middle of it.
pub(in crate::window) fn as_circle(planet: Planet, lens: &Lens) -> Lens {
    let Some(corners_m) = corners(lens) else {
        return lens.clone();
    };
    let radius_m = (area_m2(&lens.shape) / core::f64::consts::PI).sqrt();
    let points: Vec<DVec2> = corners_m.iter().map(|c| DVec2::from_array(*c)).collect();
    let centre_m = centroid(&points);
    // Where it is in the middle already, not a digit of its place changes.
    let (lon_deg, lat_deg) = if centre_m.length() < 1e-3 {
        (lens.lon_deg, lens.lat_deg)
    } else {
        frame(planet, lens).to_map(centre_m).to_degrees()
    };
    Lens {
        lon_deg,
        lat_deg,
        shape: LensShape::Circle {
            radius_m: millimetres(radius_m),
        },
        ..lens.clone()
    }
}

/// A polygon through places of the map, around its centroid.
pub(super) fn drawn(planet: Planet, places: &[MapPoint]) -> (MapPoint, LensShape) {
    let sum: DVec3 = places.iter().map(|p| p.to_unit()).sum();
    let about = MapPoint::from_direction(sum.try_normalize().unwrap_or(DVec3::X));
    let at = Frame::new(planet, about);
    let points: Vec<DVec2> = places.iter().map(|p| at.from_map(*p)).collect();
    let centre = at.to_map(centroid(&points));
    let at = Frame::new(planet, centre);
    let corners_m = places.iter().map(|p| storable(at.from_map(*p))).collect();
    (centre, LensShape::Polygon { corners_m })
}

/// The centre of mass of an outline's inside; of its corners where it crosses itself so that the former
/// would lie outside of all of them, or has no inside.
fn centroid(points: &[DVec2]) -> DVec2 {
    let mean = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
    let next = points.iter().cycle().skip(1);
    let (mut twice_area, mut sum) = (0.0, DVec2::ZERO);
    for (a, b) in points.iter().zip(next) {
        let (a, b) = (*a - mean, *b - mean);
        let part = a.perp_dot(b);
        twice_area += part;
        sum += (a + b) * part;
    }
    let centre = mean + sum / (3.0 * twice_area);
    let low = points.iter().copied().fold(mean, DVec2::min);
    let high = points.iter().copied().fold(mean, DVec2::max);
    let is_within = centre.is_finite() && centre.cmpge(low).all() && centre.cmple(high).all();
    if is_within { centre } else { mean }
}

/// A point as it is stored: in range, to the millimetre.
fn storable(point: DVec2) -> [f64; 2] {
    let most = DVec2::splat(LensShape::FARTHEST_M);
    let point = point.clamp(-most, most);
    [millimetres(point.x), millimetres(point.y)]
}

fn millimetres(length_m: f64) -> f64 {
    // No negative zero: it would be written as one.
    (length_m * 1e3).round() / 1e3 + 0.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_engine::project::Extra;

    use super::*;

    fn polygon(lon_deg: f64, lat_deg: f64, corners_m: &[[f64; 2]]) -> Lens {
        Lens {
            lon_deg,
            lat_deg,
            fade_m: 5.0,
            shape: LensShape::Polygon {
                corners_m: corners_m.to_vec(),
            },
            extra: Extra::new(),
        }
    }

    const SQUARE: [[f64; 2]; 4] = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]];

    #[test]
    fn a_circle_becomes_a_hexagon_of_its_area_and_comes_back() {
        let circle = Lens {
            shape: LensShape::Circle { radius_m: 1234.5 },
            ..polygon(7.0, 46.0, &SQUARE)
        };
        let hexagon = as_polygon(&circle);
        assert_eq!(corners(&hexagon).unwrap().len(), 6);
        let areas = [&circle, &hexagon].map(|l| area_m2(&l.shape));
        assert!((areas[0] / areas[1] - 1.0).abs() < 1e-6, "{areas:?}");
        assert_eq!(as_circle(Planet::EARTH, &hexagon), circle);
        // None so small or large that it could not be taken or stored.
        for (radius_m, farthest_m) in [(0.0, 1.0), (1e10, 1e7)] {
            let lens = Lens {
                shape: LensShape::Circle { radius_m },
                ..circle.clone()
            };
            let reach_m = reach_m(corners(&as_polygon(&lens)).unwrap());
            assert!((reach_m / farthest_m - 1.0).abs() < 1e-2, "{reach_m}");
        }
    }

    #[test]
    fn an_outline_that_crosses_itself_has_the_area_of_its_parts() {
        let area = |corners: &[[f64; 2]]| area_m2(&polygon(0.0, 0.0, corners).shape);
        assert_eq!(area(&SQUARE), 1e4);
        let bow = [[-50.0, -50.0], [50.0, 50.0], [50.0, -50.0], [-50.0, 50.0]];
        assert!((area(&bow) - 5e3).abs() < 1e-6);
        // Twice around: nothing is inside.
        let twice: Vec<[f64; 2]> = SQUARE.iter().chain(&SQUARE).copied().collect();
        assert!(area(&twice).abs() < 1e-6);
    }

    #[test]
    fn a_corner_is_put_on_every_edge_and_taken_down_to_three() {
        let square = polygon(0.0, 0.0, &SQUARE);
        let more = inserted(&square, 3).unwrap();
        assert_eq!(corners(&more).unwrap()[4], [-50.0, 0.0]);
        let three = removed(&square, 0).unwrap();
        assert!(removed(&three, 0).is_none() && removed(&square, 4).is_none());
        let full = polygon(0.0, 0.0, &[[1.0, 2.0]; 256]);
        assert!(inserted(&full, 0).is_none());
    }

    #[test]
    fn what_is_drawn_lies_around_its_centroid_where_it_was_drawn() {
        let planet = Planet::EARTH;
        let places = [(179.9, 10.0), (-179.9, 10.0), (-179.9, 10.1), (179.9, 10.1)]
            .map(|(lon, lat)| MapPoint::from_degrees(lon, lat));
        let (centre, shape) = drawn(planet, &places);
        let (lon_deg, lat_deg) = centre.to_degrees();
        assert!(
            lon_deg.abs() > 179.9999 && (lat_deg - 10.05).abs() < 1e-4,
            "{centre:?}"
        );
        let lens = Lens {
            shape,
            ..polygon(lon_deg, lat_deg, &[])
        };
        let at = frame(planet, &lens);
        for (corner, place) in corners(&lens).unwrap().iter().zip(places) {
            let miss_m = at.to_map(DVec2::from_array(*corner)).angle_to(place) * planet.radius_m;
            assert!(miss_m < 1e-3, "{miss_m}");
        }
        // A bow tie has no centre of mass; its corners have.
        let bow = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        let bow = bow.map(|(lon, lat)| MapPoint::from_degrees(lon, lat));
        let (lon_deg, lat_deg) = drawn(planet, &bow).0.to_degrees();
        assert!((lon_deg - 0.5).abs() < 0.01 && (lat_deg - 0.5).abs() < 0.01);
    }

    proptest! {
        #[test]
        fn a_lens_that_is_carried_has_the_place_where_it_was_taken_under_the_pointer(
            lat in -85.0..85.0_f64, lon in -180.0..180.0_f64, x in -1e5..1e5_f64, y in -1e5..1e5_f64,
            east in -1e5..1e5_f64, north in -1e5..1e5_f64,
        ) {
            let planet = Planet::EARTH;
            let lens = polygon(lon, lat, &SQUARE);
            let to = frame(planet, &lens).to_map(DVec2::new(east, north));
            let carried = carried(planet, &lens, DVec2::new(x, y), to);
            let there = frame(planet, &carried).from_map(to);
            prop_assert!((there - DVec2::new(x, y)).length() < 0.1, "{}", there);
            prop_assert_eq!(&carried.shape, &lens.shape);
        }
    }

    #[test]
    fn a_circle_lies_where_the_polygon_was_that_it_comes_from() {
        let corners_m = SQUARE.map(|[east, north]| [east + 5000.0, north]);
        let lens = polygon(7.0, 46.0, &corners_m);
        let circle = as_circle(Planet::EARTH, &lens);
        let at_m = frame(Planet::EARTH, &lens)
            .from_map(MapPoint::from_degrees(circle.lon_deg, circle.lat_deg));
        assert!((at_m - DVec2::new(5000.0, 0.0)).length() < 1e-3, "{at_m}");
    }
}
