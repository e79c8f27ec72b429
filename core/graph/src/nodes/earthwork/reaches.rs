//! Which elements may reach a rectangle of the map, from list to list of elements.

use std::sync::Arc;

use relievo_earthwork::{MapIndex, MapRect};

use super::PlacedElement;

/// Elements that are looked at one by one before a new index is made of all.
const MOST_CHANGED: usize = 64;

/// An index of elements, and which of the present list it does not know.
pub(super) struct Reaches {
    base: Arc<Base>,
    /// Positions at which the list has another element than the index, rising.
    changed: Vec<u32>,
}

struct Base {
    elements: Vec<Arc<PlacedElement>>,
    index: MapIndex,
}

impl Reaches {
    pub(super) fn new(elements: &[Arc<PlacedElement>]) -> Self {
        let base = Base {
            elements: elements.to_vec(),
            index: MapIndex::new(elements.iter().map(|e| e.prepared.reach())),
        };
        Self {
            base: Arc::new(base),
            changed: Vec::new(),
        }
    }

    /// The same of another list, with the same index while few elements differ.
    pub(super) fn follow(&self, elements: &[Arc<PlacedElement>]) -> Self {
        let known = |i: usize, e: &Arc<PlacedElement>| {
            let base = self.base.elements.get(i);
            base.is_some_and(|base| Arc::ptr_eq(base, e))
        };
        let all = elements.iter().enumerate();
        let changed = all.filter(|(i, e)| !known(*i, e)).map(|(i, _)| i as u32);
        let changed: Vec<u32> = changed.take(MOST_CHANGED + 1).collect();
        if changed.len() > MOST_CHANGED {
            return Self::new(elements);
        }
        Self {
            base: Arc::clone(&self.base),
            changed,
        }
    }

    /// Positions in the list of elements with a rectangle that overlaps `rect`, in no order.
    pub(super) fn touching(&self, rect: &MapRect, elements: &[Arc<PlacedElement>]) -> Vec<u32> {
        let mut found = self.base.index.touching(rect);
        let is_here = |i: &u32| (*i as usize) < elements.len();
        found.retain(|i| is_here(i) && self.changed.binary_search(i).is_err());
        let reached = |i: &&u32| {
            let reach = elements[**i as usize].prepared.reach();
            reach.iter().any(|r| r.overlaps(rect))
        };
        found.extend(self.changed.iter().filter(reached));
        found
    }
}
