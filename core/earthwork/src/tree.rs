//! A packed tree of rectangles, each with a range of heights: built once, never changed.

use glam::DVec2;

/// Children of a node.
const FAN: usize = 8;

/// A rectangle, and the range of heights of what lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Bounds {
    const NOTHING: Self = Self {
        min: DVec2::INFINITY,
        max: DVec2::NEG_INFINITY,
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    /// A rectangle without heights.
    pub(crate) fn flat(min: DVec2, max: DVec2) -> Self {
        Self {
            min,
            max,
            low: 0.0,
            high: 0.0,
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Distance of a point, 0 inside.
    #[inline]
    pub(crate) fn distance(&self, p: DVec2) -> f64 {
        (self.min - p).max(p - self.max).max(DVec2::ZERO).length()
    }

    /// Whether both have a point in common.
    #[inline]
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// The tree. Items are numbers in the order in which their bounds were given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// Items in the order of the leaves.
    items: Vec<u32>,
    /// Bounds level by level, leaves first.
    levels: Vec<Vec<Bounds>>,
}

impl Tree {
    pub(crate) fn new(bounds: &[Bounds]) -> Self {
        let all = bounds.iter().fold(Bounds::NOTHING, |a, b| a.and(*b));
        let size = (all.max - all.min).max_element().max(f64::MIN_POSITIVE);
        let mut keyed: Vec<(u64, u32)> = bounds
            .iter()
            .enumerate()
            .map(|(i, b)| {
                let at = ((b.min + b.max) * 0.5 - all.min) / size * 65_535.0;
                (spread(at.x) | spread(at.y) << 1, i as u32)
            })
            .collect();
        keyed.sort_unstable();
        let items: Vec<u32> = keyed.into_iter().map(|(_, i)| i).collect();
        let mut levels = vec![
            items
                .iter()
                .map(|i| bounds[*i as usize])
                .collect::<Vec<_>>(),
        ];
        while levels.last().is_some_and(|top| top.len() > FAN) {
            let top = &levels[levels.len() - 1];
            let above = top
                .chunks(FAN)
                .map(|c| c.iter().fold(Bounds::NOTHING, |a, b| a.and(*b)))
                .collect();
            levels.push(above);
        }
        Self { items, levels }
    }

    /// Calls `item` with every item whose bounds, and those of all nodes above it, `descend` accepts.
    pub(crate) fn visit(&self, descend: impl Fn(&Bounds) -> bool, mut item: impl FnMut(u32)) {
        let mut stack = [(0_usize, 0_usize); 256];
        let mut used = 0;
        let top = self.levels.len() - 1;
        // At most FAN at each level wait, and 2³² items have 11 levels.
        for (i, b) in self.levels[top].iter().enumerate() {
            if descend(b) {
                stack[used] = (top, i);
                used += 1;
            }
        }
        while used > 0 {
            used -= 1;
            let (level, i) = stack[used];
            if level == 0 {
                item(self.items[i]);
                continue;
            }
            let below = &self.levels[level - 1];
            let end = ((i + 1) * FAN).min(below.len());
            for (k, b) in below[i * FAN..end].iter().enumerate() {
                if descend(b) {
                    stack[used] = (level - 1, i * FAN + k);
                    used += 1;
                }
            }
        }
    }

    /// The smallest of `value`, which is nowhere below `bound` of its bounds; infinite if there is
    /// no item.
    pub(crate) fn least(&self, bound: impl Fn(&Bounds) -> f64, value: impl Fn(u32) -> f64) -> f64 {
        let mut best = f64::INFINITY;
        if self.items.is_empty() {
            return best;
        }
        let mut stack: Vec<(f64, usize, usize)> = Vec::with_capacity(64);
        let top = self.levels.len() - 1;
        let push = |stack: &mut Vec<_>, level: usize, from: usize, to: usize, best: f64| {
            let start = stack.len();
            for (k, b) in self.levels[level][from..to].iter().enumerate() {
                let bound = bound(b);
                if bound < best {
                    stack.push((bound, level, from + k));
                }
            }
            // The most promising comes off the stack first.
            stack[start..].sort_by(|a: &(f64, usize, usize), b| b.0.total_cmp(&a.0));
        };
        push(&mut stack, top, 0, self.levels[top].len(), best);
        while let Some((bound, level, i)) = stack.pop() {
            if bound >= best {
                continue;
            }
            if level == 0 {
                best = best.min(value(self.items[i]));
            } else {
                let end = ((i + 1) * FAN).min(self.levels[level - 1].len());
                push(&mut stack, level - 1, i * FAN, end, best);
            }
        }
        best
    }
}

/// Spreads 16 bits to every second place.
fn spread(v: f64) -> u64 {
    let mut x = v.clamp(0.0, 65_535.0) as u64;
    x = (x | x << 8) & 0x00FF_00FF;
    x = (x | x << 4) & 0x0F0F_0F0F;
    x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn boxes() -> impl Strategy<Value = Vec<Bounds>> {
        let one = (-99.0..99.0_f64, -99.0..99.0_f64, 0.0..9.0_f64, 0.0..9.0_f64);
        prop::collection::vec(one, 0..300).prop_map(|all| {
            all.into_iter()
                .map(|(x, y, w, h)| Bounds::flat(DVec2::new(x, y), DVec2::new(x + w, y + h)))
                .collect()
        })
    }

    proptest! {
        #[test]
        fn a_tree_finds_what_a_look_at_all_finds(
            boxes in boxes(), x in -99.0..99.0_f64, y in -99.0..99.0_f64, w in 0.0..50.0_f64,
        ) {
            let tree = Tree::new(&boxes);
            let p = DVec2::new(x, y);
            let window = Bounds::flat(p, p + w);
            let mut found = Vec::new();
            tree.visit(|b| b.overlaps(&window), |i| found.push(i as usize));
            found.sort_unstable();
            let all: Vec<usize> = (0..boxes.len()).filter(|i| boxes[*i].overlaps(&window)).collect();
            prop_assert_eq!(found, all);
            let least = boxes.iter().map(|b| b.distance(p)).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(tree.least(|b| b.distance(p), |i| boxes[i as usize].distance(p)), least);
        }
    }
}
