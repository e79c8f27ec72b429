//! Which elements may change samples of a grid, from list to list of elements.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use parking_lot::Mutex;
use relievo_earthwork::{MapIndex, MapRect};
use relievo_planet::{Grid, GridMemory};

use super::{PlacedElement, reach};
use crate::{ContentId, IdHasher};

/// Elements that are looked at one by one before a new index is made of all.
const MOST_CHANGED: usize = 64;

/// Grids for which an index remembers what touches them: those of a few views.
const MOST_GRIDS: usize = 8192;

/// The elements that may change samples of a grid.
#[derive(Clone, Debug)]
pub(super) struct Touching {
    /// Their positions in the list, rising.
    pub(super) positions: Arc<[u32]>,
    /// Name of all of them together, in the order of the list.
    pub(super) name: ContentId,
}

impl Touching {
    fn new(positions: Vec<u32>, elements: &[Arc<PlacedElement>]) -> Self {
        let mut id = IdHasher::default();
        id.int(positions.len() as i64);
        for i in &positions {
            id.id(elements[*i as usize].name);
        }
        Self {
            positions: positions.into(),
            name: id.finish(),
        }
    }
}

/// An index of a list of elements, and how the present list differs from that one.
pub(super) struct Reaches {
    base: Arc<Base>,
    /// Positions in the index's list of elements that are gone, rising.
    gone: Vec<u32>,
    /// Positions in the present list of elements that the index does not know, rising.
    added: Vec<u32>,
    /// Where each element of the index's list is in the present one; `None`: where it was.
    now_at: Option<Vec<u32>>,
    /// Of the present list, where it is not as in the index's.
    known: Mutex<GridMemory<Touching>>,
}

struct Base {
    elements: Vec<Arc<PlacedElement>>,
    index: MapIndex,
    /// What of `elements` touches grids that were asked about.
    known: Mutex<GridMemory<Touching>>,
    /// Positions of elements by their addresses.
    position_of: OnceLock<HashMap<usize, u32>>,
}

impl Base {
    fn position_of(&self, element: &Arc<PlacedElement>) -> Option<u32> {
        let all = self.position_of.get_or_init(|| {
            let all = self.elements.iter().enumerate();
            all.map(|(i, e)| (Arc::as_ptr(e).addr(), i as u32))
                .collect()
        });
        all.get(&Arc::as_ptr(element).addr()).copied()
    }

    /// What touches a grid, remembered.
    fn touching(&self, grid: &Grid, place: &mut Place) -> Touching {
        if let Some(known) = self.known.lock().get(grid) {
            return known.clone();
        }
        let mut found = Vec::new();
        for rect in place.rects(grid) {
            found.extend(self.index.touching(rect));
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|i| place.is_touched(&self.elements[*i as usize], grid));
        let found = Touching::new(found, &self.elements);
        remember(&self.known, grid, &found);
        found
    }
}

fn remember(known: &Mutex<GridMemory<Touching>>, grid: &Grid, found: &Touching) {
    let mut known = known.lock();
    // Another thread may have been quicker.
    if known.get(grid).is_none() {
        known.insert(grid, found.clone());
    }
}

/// Where a grid lies on the map, found out when it is first needed.
struct Place {
    spacing_m: f64,
    rects: Option<Vec<MapRect>>,
}

impl Place {
    fn rects(&mut self, grid: &Grid) -> &[MapRect] {
        // Elements narrower than two samples also act on samples next to them.
        self.rects
            .get_or_insert_with(|| reach::map_rects(&grid.with_rect(grid.rect.grow(1))))
    }

    fn is_touched(&mut self, element: &PlacedElement, grid: &Grid) -> bool {
        let prepared = &element.prepared;
        prepared.matters_at(self.spacing_m)
            && self.rects(grid).iter().any(|rect| prepared.touches(rect))
    }
}

impl Reaches {
    pub(super) fn new(elements: &[Arc<PlacedElement>]) -> Self {
        let base = Base {
            elements: elements.to_vec(),
            index: MapIndex::new(elements.iter().map(|e| e.prepared.reach())),
            known: Mutex::new(GridMemory::new(MOST_GRIDS)),
            position_of: OnceLock::new(),
        };
        Self {
            base: Arc::new(base),
            gone: Vec::new(),
            added: Vec::new(),
            now_at: None,
            known: Mutex::new(GridMemory::new(MOST_GRIDS)),
        }
    }

    /// The same of another list, with the same index while few elements differ.
    pub(super) fn follow(&self, elements: &[Arc<PlacedElement>]) -> Self {
        let base = &self.base;
        let mut now_at = vec![u32::MAX; base.elements.len()];
        let (mut added, mut kept) = (Vec::new(), 0);
        // The first element of the index's list that may come next.
        let mut next = 0;
        for (i, element) in elements.iter().enumerate() {
            let expected = base.elements.get(next);
            let at = if expected.is_some_and(|e| Arc::ptr_eq(e, element)) {
                Some(next)
            } else {
                let at = base.position_of(element).map(|at| at as usize);
                at.filter(|at| *at >= next)
            };
            if let Some(at) = at {
                now_at[at] = i as u32;
                next = at + 1;
                kept += 1;
            } else {
                added.push(i as u32);
            }
            if added.len() > MOST_CHANGED {
                return Self::new(elements);
            }
        }
        if base.elements.len() - kept > MOST_CHANGED {
            return Self::new(elements);
        }
        let all = now_at.iter().enumerate();
        let gone = all.clone().filter(|(_, now)| **now == u32::MAX);
        let moved = all
            .clone()
            .any(|(was, now)| *now != u32::MAX && *now != was as u32);
        Self {
            base: Arc::clone(base),
            gone: gone.map(|(was, _)| was as u32).collect(),
            added,
            now_at: moved.then_some(now_at),
            known: Mutex::new(GridMemory::new(MOST_GRIDS)),
        }
    }

    /// Those of the present list that may change samples of a grid whose samples are `spacing_m` wide
    /// on the ground.
    pub(super) fn touching(
        &self,
        grid: &Grid,
        spacing_m: f64,
        elements: &[Arc<PlacedElement>],
    ) -> Touching {
        let mut place = Place {
            spacing_m,
            rects: None,
        };
        if self.added.is_empty() && self.gone.is_empty() {
            return self.base.touching(grid, &mut place);
        }
        if let Some(known) = self.known.lock().get(grid) {
            return known.clone();
        }
        let found = self.patched(grid, &mut place, elements);
        remember(&self.known, grid, &found);
        found
    }

    /// What the index knows, put right.
    fn patched(&self, grid: &Grid, place: &mut Place, elements: &[Arc<PlacedElement>]) -> Touching {
        let known = self.base.touching(grid, place);
        let is_gone = |i: &u32| self.gone.binary_search(i).is_ok();
        let added = self.added.iter().copied();
        let added: Vec<u32> = added
            .filter(|i| place.is_touched(&elements[*i as usize], grid))
            .collect();
        let fewer = self
            .gone
            .iter()
            .any(|i| known.positions.binary_search(i).is_ok());
        if added.is_empty() && !fewer && self.now_at.is_none() {
            return known;
        }
        let kept = known.positions.iter().copied().filter(|i| !is_gone(i));
        let kept = kept.map(|was| self.now_at.as_ref().map_or(was, |now| now[was as usize]));
        let mut positions: Vec<u32> = kept.collect();
        if added.is_empty() && !fewer {
            return Touching {
                positions: positions.into(),
                ..known
            };
        }
        positions.extend(added);
        positions.sort_unstable();
        Touching::new(positions, elements)
    }
}
