//! A packed R-tree over boxes: filled once, never changed, the same for the same boxes.
//!
//! Boxes are sorted along a Hilbert curve through their middles and grouped by sixteen, level by
//! level. Source: I. Kamel, C. Faloutsos, "On packing R-trees", CIKM 1993.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Bounds;

/// Boxes below a node.
const FAN: usize = 16;

/// Order of the Hilbert curve: cells of 20 m on the Earth would need 21; 16 is fine enough to sort by.
const ORDER: u32 = 16;

#[derive(Debug, Default)]
pub(super) struct Index {
    /// The boxes in the curve's order, then their nodes, level by level, up to the root.
    boxes: Vec<Bounds>,
    /// Number of entries of each level.
    counts: Vec<usize>,
    /// Which box each of the first level is.
    items: Vec<u32>,
}

impl Index {
    pub(super) fn new(boxes: impl ExactSizeIterator<Item = Bounds>) -> Self {
        let mut sorted: Vec<(u64, u32, Bounds)> = boxes
            .enumerate()
            .map(|(i, b)| (along_curve(&b), i as u32, b))
            .collect();
        sorted.sort_unstable_by_key(|(d, i, _)| (*d, *i));
        let items: Vec<u32> = sorted.iter().map(|(_, i, _)| *i).collect();
        let mut boxes: Vec<Bounds> = sorted.into_iter().map(|(_, _, b)| b).collect();
        if boxes.is_empty() {
            return Self::default();
        }
        let mut counts = vec![boxes.len()];
        let mut first = 0;
        while boxes.len() - first > 1 {
            let last = boxes.len();
            for at in (first..last).step_by(FAN) {
                let group = boxes[at..last.min(at + FAN)].iter().copied();
                let around = group.reduce(|a, b| a.union(&b));
                boxes.extend(around);
            }
            counts.push(boxes.len() - last);
            first = last;
        }
        Self {
            boxes,
            counts,
            items,
        }
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        self.boxes.last().copied()
    }

    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.boxes) + size_of_val(&*self.items)
    }

    /// Calls `found` with every box that overlaps; stops when it says no. Whether it never did.
    pub(super) fn overlapping(&self, wanted: &Bounds, found: &mut impl FnMut(u32) -> bool) -> bool {
        if self.items.is_empty() {
            return true;
        }
        let top = self.counts.len() - 1;
        self.visit(top, self.boxes.len() - 1, wanted, found)
    }

    fn visit(
        &self,
        level: usize,
        at: usize,
        wanted: &Bounds,
        found: &mut impl FnMut(u32) -> bool,
    ) -> bool {
        if !self.boxes[at].overlaps(wanted) {
            return true;
        }
        if level == 0 {
            return found(self.items[at]);
        }
        let own: usize = self.counts[..level].iter().sum();
        let below = own - self.counts[level - 1];
        let first = (at - own) * FAN;
        let last = self.counts[level - 1].min(first + FAN);
        (first..last).all(|child| self.visit(level - 1, below + child, wanted, found))
    }
}

/// Where the middle of a box lies along the curve.
fn along_curve(bounds: &Bounds) -> u64 {
    let centre = bounds.centre();
    let side = 1_u32 << ORDER;
    let cell = |share: f64| ((share * f64::from(side)) as u32).min(side - 1);
    let mut x = cell((centre.x + PI).rem_euclid(TAU) / TAU);
    let mut y = cell((centre.y + FRAC_PI_2) / PI);
    let mut d = 0_u64;
    let mut s = side / 2;
    while s > 0 {
        let (rx, ry) = (u32::from(x & s > 0), u32::from(y & s > 0));
        d += u64::from(s) * u64::from(s) * u64::from((3 * rx) ^ ry);
        if ry == 0 {
            if rx == 1 {
                x = (side - 1) - x;
                y = (side - 1) - y;
            }
            core::mem::swap(&mut x, &mut y);
        }
        s /= 2;
    }
    d
}
