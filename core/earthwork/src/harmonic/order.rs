//! In which order nodes are taken out: nested dissection by their places.

use glam::DVec2;

/// Parts this small are taken out as they come.
const SMALL: usize = 24;

/// The nodes that `is_unknown`, so that few new edges arise when they are taken out in this order:
/// both sides of a line before the nodes that stand on it, and so on within them.
///
/// A function of places and edges alone.
pub(super) fn elimination_order(
    at: &[DVec2],
    edges: &[(usize, usize, f64)],
    is_unknown: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); at.len()];
    for (a, b, _) in edges {
        neighbours[*a].push(*b);
        neighbours[*b].push(*a);
    }
    let mut all: Vec<usize> = (0..at.len()).filter(|i| is_unknown(*i)).collect();
    let mut dissection = Dissection {
        at,
        neighbours,
        side: vec![0; at.len()],
        sides: 0,
        order: Vec::with_capacity(all.len()),
    };
    dissection.part(&mut all);
    dissection.order
}

struct Dissection<'a> {
    at: &'a [DVec2],
    neighbours: Vec<Vec<usize>>,
    /// Number of the first side that a node was last on.
    side: Vec<u32>,
    sides: u32,
    order: Vec<usize>,
}

impl Dissection<'_> {
    fn part(&mut self, nodes: &mut [usize]) {
        if nodes.len() <= SMALL {
            nodes.sort_unstable();
            self.order.extend_from_slice(nodes);
            return;
        }
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for i in &*nodes {
            min = min.min(self.at[*i]);
            max = max.max(self.at[*i]);
        }
        let is_wide = max.x - min.x >= max.y - min.y;
        let along = |i: usize| {
            let p = self.at[i];
            if is_wide { p.x } else { p.y }
        };
        let middle = nodes.len() / 2;
        nodes.select_nth_unstable_by(middle, |a, b| {
            along(*a).total_cmp(&along(*b)).then(a.cmp(b))
        });
        let (near, far) = nodes.split_at_mut(middle);
        self.sides += 1;
        for i in &*near {
            self.side[*i] = self.sides;
        }
        // Nodes beyond the line with a neighbour before it part the two sides.
        let mut line = Vec::new();
        let mut beyond = Vec::with_capacity(far.len());
        for i in far {
            let touches = self.neighbours[*i]
                .iter()
                .any(|k| self.side[*k] == self.sides);
            if touches { &mut line } else { &mut beyond }.push(*i);
        }
        line.sort_unstable();
        self.part(near);
        self.part(&mut beyond);
        self.order.append(&mut line);
    }
}
