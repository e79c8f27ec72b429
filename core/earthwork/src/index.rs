//! Which of many elements may reach a rectangle of the map.

use core::f64::consts::TAU;

use glam::DVec2;

use crate::frame::MapRect;
use crate::tree::{Bounds, Tree};

/// Rectangles of the map, several for each element.
#[derive(Clone, Debug)]
pub struct MapIndex {
    tree: Tree,
    /// The element of each item of the tree.
    of: Vec<u32>,
}

fn bounds(rect: &MapRect, turn: f64) -> Bounds {
    Bounds::flat(
        DVec2::new(rect.west_rad + turn, rect.north_rad),
        DVec2::new(rect.east_rad + turn, rect.south_rad),
    )
}

impl MapIndex {
    /// An index of the elements' rectangles.
    pub fn new<'a>(elements: impl Iterator<Item = &'a [MapRect]>) -> Self {
        let mut all = Vec::new();
        let mut of = Vec::new();
        for (i, rects) in elements.enumerate() {
            for rect in rects {
                // Once more a turn on, where rectangles across the antimeridian end, and a turn
                // back where it crosses itself.
                for turn in [0.0, TAU] {
                    all.push(bounds(rect, turn));
                    of.push(i as u32);
                }
                if rect.east_rad >= core::f64::consts::PI {
                    all.push(bounds(rect, -TAU));
                    of.push(i as u32);
                }
            }
        }
        Self {
            tree: Tree::new(&all),
            of,
        }
    }

    /// Elements with a rectangle that overlaps `rect`, in order.
    pub fn touching(&self, rect: &MapRect) -> Vec<u32> {
        let window = bounds(rect, 0.0);
        let mut found = Vec::new();
        self.tree
            .visit(|b| b.overlaps(&window), |i| found.push(self.of[i as usize]));
        found.sort_unstable();
        found.dedup();
        found
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    fn rects() -> impl Strategy<Value = MapRect> {
        (-PI..PI, 0.0..=TAU, 0.0..3.0_f64, 0.0..0.5_f64).prop_map(|(west, width, north, height)| {
            MapRect {
                west_rad: west,
                east_rad: west + width,
                north_rad: north,
                south_rad: (north + height).min(PI),
            }
        })
    }

    proptest! {
        #[test]
        fn an_index_finds_what_overlaps_around_the_planet(all in prop::collection::vec(rects(), 0..40), window in rects()) {
            let index = MapIndex::new(all.iter().map(core::slice::from_ref));
            let exact: Vec<u32> = (0..all.len() as u32).filter(|i| all[*i as usize].overlaps(&window)).collect();
            prop_assert_eq!(index.touching(&window), exact);
        }
    }
}
