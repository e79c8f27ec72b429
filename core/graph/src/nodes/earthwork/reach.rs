//! Where a grid lies on the map.

use core::f64::consts::{PI, TAU};

use glam::DVec2;
use relievo_earthwork::MapRect;
use relievo_planet::map::wrap_longitude;
use relievo_planet::{Grid, GridCrs, MapPoint};

use super::super::ground::Ground;

const EVERYWHERE: MapRect = MapRect {
    west_rad: -PI,
    east_rad: PI,
    north_rad: 0.0,
    south_rad: PI,
};

/// Rectangles that hold all samples of a grid.
pub(super) fn map_rects(grid: &Grid) -> Vec<MapRect> {
    let Grid { lattice, rect } = grid;
    if lattice.crs != GridCrs::Map {
        return vec![around(grid).unwrap_or(EVERYWHERE)];
    }
    let a = lattice.origin + rect.min.as_dvec2() * lattice.step;
    let b = lattice.origin + rect.max.as_dvec2() * lattice.step;
    let (min, max) = (a.min(b), a.max(b));
    if max.y - min.y > PI {
        return vec![EVERYWHERE];
    }
    let turned = |beyond: f64| {
        let width = (max.x - min.x).min(TAU);
        let west = wrap_longitude(min.x + beyond);
        (west, west + width)
    };
    // Rows beyond a pole lie on the opposite meridian.
    let mut all = Vec::new();
    let mut add = |beyond: f64, north: f64, south: f64| {
        let (north, south) = (north.clamp(0.0, PI), south.clamp(0.0, PI));
        if north < south {
            let (west_rad, east_rad) = turned(beyond);
            all.push(MapRect {
                west_rad,
                east_rad,
                north_rad: north,
                south_rad: south,
            });
        }
    };
    add(0.0, min.y, max.y);
    add(PI, -max.y.min(0.0), -min.y);
    add(PI, TAU - max.y, TAU - min.y.max(PI));
    if all.is_empty() {
        all.push(EVERYWHERE);
    }
    all
}

/// Places along each side that are looked at.
const LOOKS: usize = 16;

/// A rectangle around a grid of another plane; `None` where the plane shows no place, or all around.
fn around(grid: &Grid) -> Option<MapRect> {
    let ground = Ground::new(&grid.lattice, "earthwork").ok()?;
    let (min, max) = (grid.rect.min.as_dvec2(), grid.rect.max.as_dvec2());
    let mut places = Vec::new();
    for j in 0..=LOOKS {
        for i in 0..=LOOKS {
            let share = DVec2::new(i as f64, j as f64) / LOOKS as f64;
            places.push(ground.point(min + (max - min) * share)?);
        }
    }
    let first = places[0];
    let east_of = |p: &MapPoint| wrap_longitude(p.lon_rad - first.lon_rad);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in &places {
        let at = DVec2::new(east_of(p), p.colat_rad);
        low = low.min(at);
        high = high.max(at);
    }
    // Between the places that were looked at the plane may bend by as much as they are apart.
    let side = LOOKS + 1;
    let mut apart = DVec2::ZERO;
    for (k, p) in places.iter().enumerate() {
        let right = (k % side + 1 < side).then(|| &places[k + 1]);
        let below = places.get(k + side);
        for next in [right, below].into_iter().flatten() {
            let step = DVec2::new(
                wrap_longitude(next.lon_rad - p.lon_rad),
                next.colat_rad - p.colat_rad,
            );
            apart = apart.max(step.abs());
        }
    }
    let (low, high) = (low - apart, high + apart);
    if low.y <= 0.0 || high.y >= PI || high.x - low.x >= PI {
        return Some(MapRect {
            west_rad: -PI,
            east_rad: PI,
            north_rad: low.y.max(0.0),
            south_rad: high.y.min(PI),
        });
    }
    let west = wrap_longitude(first.lon_rad + low.x);
    Some(MapRect {
        west_rad: west,
        east_rad: west + (high.x - low.x),
        north_rad: low.y,
        south_rad: high.y,
    })
}
