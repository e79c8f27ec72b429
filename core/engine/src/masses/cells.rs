//! Which features stand in which part of the map.

use std::collections::HashMap;
use std::sync::Arc;

use core::f64::consts::FRAC_PI_2;

use relievo_planet::{LevelKey, MapPoint, TileKey};
use relievo_vector::Features;

/// Level whose tiles are the cells: 2.4 km from north to south on Earth.
pub(super) const CELL_LEVEL: u8 = 13;

/// The cell of a place.
pub(super) fn cell_of(point: MapPoint) -> Option<TileKey> {
    let level = LevelKey::new(CELL_LEVEL, CELL_LEVEL);
    let sample = level.sample_from_map(point).floor().as_i64vec2();
    let sample = sample.clamp(glam::I64Vec2::ZERO, level.samples() - 1);
    let tile = sample / relievo_planet::TILE_SAMPLES;
    TileKey::new(level, tile.x, tile.y)
}

/// Middle of a cell.
pub(super) fn middle_of(cell: TileKey) -> MapPoint {
    let grid = cell.grid();
    let middle = 0.5 * (grid.rect.min + grid.rect.max).as_dvec2();
    let at = grid.lattice.origin + middle * grid.lattice.step;
    MapPoint::new(at.x, at.y).normalised()
}

/// Features by the cell of their middle, in the file's order.
#[derive(Debug, Default)]
pub(crate) struct Cells(HashMap<TileKey, Arc<[u32]>>);

impl Cells {
    /// Sorts all features.
    pub(super) fn new(features: &Features) -> Self {
        let mut cells: HashMap<TileKey, Vec<u32>> = HashMap::new();
        for feature in 0..features.len() {
            let Some(bounds) = features.bounds_of(feature) else {
                continue;
            };
            let centre = bounds.centre();
            let point = MapPoint::new(centre.x, FRAC_PI_2 - centre.y).normalised();
            if let Some(cell) = cell_of(point) {
                cells.entry(cell).or_default().push(feature as u32);
            }
        }
        let shared = cells.into_iter().map(|(key, list)| (key, list.into()));
        Self(shared.collect())
    }

    /// The features of a cell.
    pub(super) fn members(&self, cell: TileKey) -> Option<&Arc<[u32]>> {
        self.0.get(&cell)
    }

    /// Cells with features, those nearest to a place first, at most `most` and no farther than
    /// `reach_rad`.
    pub(super) fn near(&self, place: MapPoint, reach_rad: f64, most: usize) -> Vec<TileKey> {
        let mut near: Vec<(f64, TileKey)> = self
            .0
            .keys()
            .map(|cell| (middle_of(*cell).angle_to(place), *cell))
            .filter(|(angle, _)| *angle <= reach_rad)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(most);
        near.into_iter().map(|(_, cell)| cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_lies_in_its_cell_at_poles_and_seams_too() {
        for (lon, lat) in [
            (0.0, 0.0),
            (179.9999, 12.0),
            (-180.0, -40.0),
            (5.0, 90.0),
            (5.0, -90.0),
        ] {
            let point = MapPoint::from_degrees(lon, lat).normalised();
            let cell = cell_of(point).expect("a cell");
            let rect = cell.rect();
            let at = cell.level.sample_from_map(point);
            assert!(
                at.x >= rect.min.x as f64 && at.x <= rect.max.x as f64,
                "{lon} {lat}"
            );
            assert!(middle_of(cell).angle_to(point) < 6e-4, "{lon} {lat}");
        }
    }
}
