//! Where a stored element can change the ground, and where it is narrow.

use glam::{DVec2, DVec3};
use relievo_analysis::MapBox;
use relievo_planet::{MapPoint, Planet};
use relievo_project::{Corridor, Element, ElementKind, Polygon, SectionKind, Vertices};

/// Legs of a line that make one area at most as often.
const MOST_AREAS: usize = 256;

/// The area outside of which an element changes nothing; `None` for one without vertices or of an
/// unknown kind, which changes nothing anywhere.
pub(super) fn reach(element: &Element, planet: &Planet) -> Option<MapBox> {
    let lists = element.vertex_lists();
    let places: Vec<MapPoint> = lists.iter().flat_map(|list| places(list)).collect();
    let middle: DVec3 = places.iter().map(|p| p.to_unit()).sum();
    let centre = MapPoint::from_direction(middle.try_normalize()?).normalised();
    let away_m = |place: &MapPoint| planet.offset_m(centre, *place).length();
    let farthest_m = places.iter().map(away_m).fold(0.0, f64::max);
    let side = &element.side;
    let batter_m = if side.wall { 0.0 } else { side.max_reach_m };
    let beside_m = match &element.kind {
        ElementKind::Polygon(_) => batter_m,
        ElementKind::Corridor(corridor) => 0.5 * section_m(corridor)?[1] + batter_m,
        ElementKind::Brush(brush) => {
            let radii = brush.strokes.iter().map(|s| s.radius_m);
            radii.fold(0.0, f64::max)
        }
        ElementKind::Unknown { .. } => return None,
    };
    // Offsets are right to about 10⁻⁴ at 1000 km, the sphere's angles to 1/2 %; more costs nothing.
    let radius_m = (farthest_m + beside_m) * 1.01 + 1.0;
    Some(MapBox::around(centre, radius_m / planet.radius_m))
}

/// Areas that hold an element without its side slopes, each with the smallest width in metres that
/// decides heights there.
pub(super) fn narrow(element: &Element, planet: &Planet) -> Vec<(MapBox, f64)> {
    match &element.kind {
        ElementKind::Polygon(polygon) => {
            let area = places(&polygon.outline)
                .map(|place| MapBox::around(place, 1.0 / planet.radius_m))
                .reduce(|one, other| one.joined(&other));
            area.map(|area| (area, width_of(polygon, planet)))
                .into_iter()
                .collect()
        }
        ElementKind::Corridor(corridor) => section_m(corridor)
            .map(|[narrow_m, wide_m]| along(&corridor.line, 0.5 * wide_m, narrow_m, planet))
            .unwrap_or_default(),
        ElementKind::Brush(brush) => {
            let strokes = brush.strokes.iter();
            strokes
                .flat_map(|s| along(&s.points, s.radius_m, s.radius_m, planet))
                .collect()
        }
        ElementKind::Unknown { .. } => Vec::new(),
    }
}

/// Areas along a line.
fn along(line: &Vertices, half_m: f64, width_m: f64, planet: &Planet) -> Vec<(MapBox, f64)> {
    let areas: Vec<MapBox> = places(line)
        .map(|place| MapBox::around(place, (half_m * 1.01 + 1.0) / planet.radius_m))
        .collect();
    let legs = areas.len().saturating_sub(1).max(1);
    let step = legs.div_ceil(MOST_AREAS);
    let first = (0..areas.len()).step_by(step);
    first
        .filter(|first| *first == 0 || first + 1 < areas.len())
        .filter_map(|first| {
            let last = (first + step + 1).min(areas.len());
            let held = areas[first..last].iter().copied();
            Some((held.reduce(|one, other| one.joined(&other))?, width_m))
        })
        .collect()
}

/// Narrowest part of a corridor's section and its whole width without side slopes, metres.
fn section_m(corridor: &Corridor) -> Option<[f64; 2]> {
    Some(match corridor.section.kind {
        SectionKind::Road { width_m, .. } => [width_m; 2],
        SectionKind::Dam { crest_width_m } => [crest_width_m; 2],
        SectionKind::Trench {
            bottom_width_m,
            depth_m: _,
        } => [bottom_width_m; 2],
        SectionKind::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => {
            let bank_m = depth_m / bank_slope.max(0.01);
            [bottom_width_m + bank_m, bottom_width_m + 2.0 * bank_m]
        }
        SectionKind::Unknown { .. } => return None,
    })
}

fn places(list: &Vertices) -> impl Iterator<Item = MapPoint> + '_ {
    list.as_slice()
        .iter()
        .map(|v| MapPoint::from_degrees(v.lon_deg, v.lat_deg))
}

/// Twice the area per perimeter: the width of a long rectangle, half of a square's.
fn width_of(polygon: &Polygon, planet: &Planet) -> f64 {
    let Some(centre) = places(&polygon.outline).next() else {
        return 0.0;
    };
    let corners: Vec<DVec2> = places(&polygon.outline)
        .map(|place| planet.offset_m(centre, place))
        .collect();
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let (mut twice_m2, mut perimeter_m) = (0.0, 0.0);
    for (from, to) in edges {
        twice_m2 += from.perp_dot(*to);
        perimeter_m += from.distance(*to);
    }
    if perimeter_m > 0.0 {
        f64::abs(twice_m2) / perimeter_m
    } else {
        0.0
    }
}
