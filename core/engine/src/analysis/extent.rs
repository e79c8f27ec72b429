//! Where a stored element can change the ground, and how narrow it is.

use glam::{DVec2, DVec3};
use relievo_planet::{MapPoint, Planet};
use relievo_project::{Element, ElementKind, Polygon, SectionKind, Vertices};

/// A circle outside of which an element changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub(super) centre: MapPoint,
    pub(super) radius_m: f64,
    /// Smallest width in metres that decides its volume.
    pub(super) width_m: f64,
}

impl Extent {
    /// `None` for an element without vertices or of an unknown kind, which changes nothing.
    pub(super) fn of(element: &Element, planet: &Planet) -> Option<Self> {
        let lists = element.vertex_lists();
        let places: Vec<MapPoint> = lists.iter().flat_map(|list| places(list)).collect();
        let middle: DVec3 = places.iter().map(|p| p.to_unit()).sum();
        let centre = MapPoint::from_direction(middle.try_normalize()?).normalised();
        let away_m = |place: &MapPoint| planet.offset_m(centre, *place).length();
        let farthest_m = places.iter().map(away_m).fold(0.0, f64::max);
        let side = &element.side;
        let batter_m = if side.wall { 0.0 } else { side.max_reach_m };
        let (beside_m, width_m) = match &element.kind {
            ElementKind::Polygon(polygon) => (batter_m, width_of(polygon, planet, centre)),
            ElementKind::Corridor(corridor) => {
                let (half_m, width_m) = match corridor.section.kind {
                    SectionKind::Road { width_m, .. } => (0.5 * width_m, width_m),
                    SectionKind::Dam { crest_width_m } => (0.5 * crest_width_m, crest_width_m),
                    SectionKind::Trench {
                        bottom_width_m,
                        depth_m,
                    } => (0.5 * bottom_width_m, bottom_width_m + depth_m),
                    SectionKind::Channel {
                        bottom_width_m,
                        depth_m,
                        bank_slope,
                    } => {
                        let bank_m = depth_m / bank_slope.max(0.01);
                        (0.5 * bottom_width_m + bank_m, bottom_width_m + bank_m)
                    }
                    SectionKind::Unknown { .. } => return None,
                };
                (half_m + batter_m, width_m)
            }
            ElementKind::Brush(brush) => {
                let radii = brush.strokes.iter().map(|s| s.radius_m);
                let least = radii.clone().fold(f64::INFINITY, f64::min);
                (radii.fold(0.0, f64::max), least)
            }
            ElementKind::Unknown { .. } => return None,
        };
        Some(Self {
            centre,
            // Offsets are right to about 10⁻⁴ at 1000 km; a little more costs nothing.
            radius_m: (farthest_m + beside_m) * 1.01 + 1.0,
            width_m: if width_m.is_finite() {
                width_m
            } else {
                beside_m
            },
        })
    }
}

fn places(list: &Vertices) -> impl Iterator<Item = MapPoint> + '_ {
    list.as_slice()
        .iter()
        .map(|v| MapPoint::from_degrees(v.lon_deg, v.lat_deg))
}

/// Twice the area per perimeter: the width of a long rectangle, half of a square's.
fn width_of(polygon: &Polygon, planet: &Planet, centre: MapPoint) -> f64 {
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
