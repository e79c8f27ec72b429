//! What was found out about grids, to be asked again.

use std::collections::HashMap;
use std::sync::Arc;

use crate::{Grid, Lattice, SampleRect};

/// Remembers a value for each of the grids that were asked about, up to a number of them.
#[derive(Clone, Debug)]
pub struct GridMemory<T> {
    by_rect: HashMap<SampleRect, Vec<(Arc<Lattice>, T)>>,
    grids: usize,
    most: usize,
}

impl<T> GridMemory<T> {
    /// Room for `most` grids, at least one.
    pub fn new(most: usize) -> Self {
        Self {
            by_rect: HashMap::new(),
            grids: 0,
            most: most.max(1),
        }
    }

    /// What is remembered for a grid.
    pub fn get(&self, grid: &Grid) -> Option<&T> {
        let of_rect = self.by_rect.get(&grid.rect)?;
        let is_on = |lattice: &Arc<Lattice>| {
            Arc::ptr_eq(lattice, &grid.lattice) || **lattice == *grid.lattice
        };
        of_rect
            .iter()
            .find(|(l, _)| is_on(l))
            .map(|(_, value)| value)
    }

    /// Remembers a value for a grid that [`Self::get`] does not know. Where there is no room left,
    /// all others are forgotten: who asks, asks about the same few thousand grids again and again.
    pub fn insert(&mut self, grid: &Grid, value: T) {
        if self.grids >= self.most {
            self.by_rect.clear();
            self.grids = 0;
        }
        self.grids += 1;
        let of_rect = self.by_rect.entry(grid.rect).or_default();
        of_rect.push((Arc::clone(&grid.lattice), value));
    }

    /// Number of grids that are remembered.
    pub fn len(&self) -> usize {
        self.grids
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.grids == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LevelKey;

    #[test]
    fn grids_are_told_apart_by_lattice_and_rectangle() {
        let grid = |n: u8, x: i64| {
            let lattice = Arc::new(LevelKey::new(n, n).lattice());
            Grid::new(lattice, SampleRect::at(x, 0, 10, 10))
        };
        let mut memory = GridMemory::new(100);
        for n in 3..6 {
            for x in 0..10 {
                memory.insert(&grid(n, x), (n, x));
            }
        }
        for n in 3..6 {
            for x in 0..10 {
                assert_eq!(memory.get(&grid(n, x)), Some(&(n, x)));
            }
        }
        assert_eq!(memory.get(&grid(6, 0)), None);
        assert_eq!(memory.len(), 30);
    }

    #[test]
    fn no_more_grids_are_kept_than_there_is_room_for() {
        let lattice = Arc::new(LevelKey::new(9, 9).lattice());
        let grid = |x: i64| Grid::new(Arc::clone(&lattice), SampleRect::at(x, 0, 1, 1));
        let mut memory = GridMemory::new(7);
        for x in 0..50 {
            memory.insert(&grid(x), x);
            assert_eq!(memory.get(&grid(x)), Some(&x));
            assert!(memory.len() <= 7);
        }
    }
}
