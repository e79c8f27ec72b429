//! What tests and benches of planning have in common.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;
use std::time::Duration;

use relievo_engine::Engine;
use relievo_engine::planet::{MapPoint, TileKey};
use relievo_engine::project::{Element, ElementId, ElementKind, Polygon, SurfaceKind, Vertex};

pub(crate) const LON: f64 = 10.0;
pub(crate) const LAT: f64 = 45.0;

/// Metres to a degree of longitude and latitude there, on the WGS 84 ellipsoid.
pub(crate) const METRES: (f64, f64) = (78_847.0, 111_132.0);

/// A square platform some metres east and north of the middle, with side slopes of one in two.
pub(crate) fn platform(id: &str, at_m: (f64, f64), half_m: f64, height_m: f64) -> Arc<Element> {
    let (lon, lat) = (LON + at_m.0 / METRES.0, LAT + at_m.1 / METRES.1);
    let (dx, dy) = (half_m / METRES.0, half_m / METRES.1);
    let corners =
        [(-dx, -dy), (dx, -dy), (dx, dy), (-dx, dy)].map(|(x, y)| Vertex::new(lon + x, lat + y));
    let polygon = Polygon::new(corners.to_vec(), SurfaceKind::Platform { height_m });
    let kind = ElementKind::Polygon(polygon);
    let mut element = Element::new(ElementId::from(id), id, kind);
    element.side.fill_slope = 0.5;
    element.side.cut_slope = 0.5;
    Arc::new(element)
}

/// Drains until the picture is whole and nothing is being made.
pub(crate) fn converge(engine: &mut Engine) {
    for _ in 0..4000 {
        let whole = engine.drain(f32::INFINITY).unwrap().is_converged();
        if engine.wait(Duration::from_millis(50)) && whole {
            return;
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

/// Whether a tile has a sample within some metres of a place, or beside one that has.
pub(crate) fn is_within(key: TileKey, at_m: (f64, f64), reach_m: f64) -> bool {
    const RADIUS_M: f64 = 6_371_000.0;
    let place = MapPoint::from_degrees(LON + at_m.0 / METRES.0, LAT + at_m.1 / METRES.1);
    let lattice = key.level.lattice();
    let (rect, step) = (key.rect(), lattice.step);
    // Normals read a sample beside their own; on a sphere lengths are half a percent off.
    let by = 1.01 * reach_m / RADIUS_M + 2.0 * step.y;
    let across = 1.01 * reach_m / RADIUS_M / place.colat_rad.sin() + 2.0 * step.x;
    let low = lattice.origin + rect.min.as_dvec2() * step;
    let high = lattice.origin + rect.max.as_dvec2() * step;
    (low.x - across..=high.x + across).contains(&place.lon_rad)
        && (low.y - by..=high.y + by).contains(&place.colat_rad)
}

/// The same of a tile or one beside it: what reads samples of the tiles around its own is named after
/// them, and made again with them, though it may come out as before.
pub(crate) fn is_beside(key: TileKey, at_m: (f64, f64), reach_m: f64) -> bool {
    let mut around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| key.neighbour(x, y)));
    around.any(|key| is_within(key, at_m, reach_m))
}
