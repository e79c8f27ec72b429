//! What the resident heights say about the ground: for cameras, culling and pointers.
//!
//! Everything here answers at once from tiles that are on the screen. Exact values at the data's own
//! resolution come from `query`.

use glam::DVec3;
use relievo_planet::clipmap::plan::{HeightRange, TerrainBounds};
use relievo_planet::{MapPoint, Planet, TILE_SAMPLES, TileKey};
use relievo_raster::{Sample, Tile};

use crate::residency::Stack;

/// Bounds of everything that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds(pub(crate) HeightRange);

impl TerrainBounds for Bounds {
    fn everywhere(&self) -> HeightRange {
        self.0
    }
}

/// Lowest and highest height of any resident tile; the datum while there is none.
pub(crate) fn bounds(heights: &Stack) -> Bounds {
    let (low, high) = heights.height_range_m().unwrap_or((0.0, 0.0));
    Bounds(HeightRange {
        min_m: f64::from(low).min(0.0),
        max_m: f64::from(high).max(0.0),
    })
}

/// Height of the ground at a point in metres without exaggeration, bilinear in the finest resident
/// tile; 0 where nothing is resident.
pub(crate) fn ground_m(heights: &Stack, point: MapPoint) -> f64 {
    heights
        .tile_at(point)
        .map_or(0.0, |(key, tile)| height_in_tile(key, tile, point))
}

/// Bilinear height inside a tile; its border samples are continued outward by half a sample.
fn height_in_tile(key: TileKey, tile: &Tile, point: MapPoint) -> f64 {
    let last = TILE_SAMPLES as f64 - 1.0;
    let at = key.level.sample_from_map(point) - key.rect().min.as_dvec2() - 0.5;
    let at = at.clamp(glam::DVec2::ZERO, glam::DVec2::splat(last));
    let corner = at.floor().min(glam::DVec2::splat(last - 1.0));
    let f = at - corner;
    let (x, y) = (corner.x as usize, corner.y as usize);
    let h = |dx, dy| {
        if let Sample::Height(h) = tile.sample(x + dx, y + dy)
            && h.is_finite()
        {
            return f64::from(h);
        }
        0.0
    };
    let north = h(0, 0) + (h(1, 0) - h(0, 0)) * f.x;
    let south = h(0, 1) + (h(1, 1) - h(0, 1)) * f.x;
    north + (south - north) * f.y
}

/// Where a ray first meets the drawn ground, or `None` if it misses the planet.
///
/// Marches in steps that shrink with the clearance above the ground and then bisects; a ridge
/// narrower than a hundredth of its distance may be missed, as it would be by the eye.
pub(crate) fn cast(
    heights: &Stack,
    planet: Planet,
    exaggeration: f64,
    eye: DVec3,
    direction: DVec3,
) -> Option<(MapPoint, f64)> {
    let top = planet.radius_m + bounds(heights).0.max_m * exaggeration;
    let direction = direction.normalize_or_zero();
    let clearance = |t: f64| {
        let p = eye + direction * t;
        let point = MapPoint::from_direction(p);
        p.length() - (planet.radius_m + ground_m(heights, point) * exaggeration)
    };
    let towards = eye.dot(direction);
    let mut t = if eye.length() > top {
        // Enter the shell below the highest terrain.
        let closest_sq = eye.length_squared() - towards * towards;
        if towards > 0.0 || closest_sq > top * top {
            return None;
        }
        -towards - (top * top - closest_sq).sqrt()
    } else {
        0.0
    };
    let leave = {
        let closest_sq = (eye.length_squared() - towards * towards).max(0.0);
        -towards + (top * top - closest_sq).max(0.0).sqrt()
    };
    let mut before = t;
    while t <= leave {
        let gap = clearance(t);
        if gap <= 0.0 {
            let (mut above, mut below) = (before, t);
            for _ in 0..60 {
                let middle = 0.5 * (above + below);
                if clearance(middle) > 0.0 {
                    above = middle;
                } else {
                    below = middle;
                }
            }
            let point = MapPoint::from_direction(eye + direction * below);
            return Some((point, ground_m(heights, point)));
        }
        before = t;
        t += (gap * 0.5).max(t * 0.01).max(0.05);
    }
    None
}
