//! Laplace's equation on a mesh of triangles, solved without a subtraction.
//!
//! Linear finite elements make a mesh a network of conductances (cotangent weights). Unknown nodes
//! are taken out one by one, a star of conductances becoming the mesh of all pairs of its ends, and
//! come back in reverse order as weighted means of their neighbours. With conductances that are not
//! negative every sum has terms of one sign, so that no digit cancels: the error is a few rounding
//! errors per node however ill conditioned the network is, and no height leaves the range of the known
//! ones. A solver that forms residuals loses as many digits as the condition number has.
//!
//! Sources: W. K. Grassmann, M. I. Taksar, D. P. Heyman: Regenerative Analysis and Steady State
//! Distributions for Markov Chains (Operations Research 33(5), 1985); A. George: Nested Dissection of
//! a Regular Finite Element Mesh (SIAM J. Numer. Anal. 10(2), 1973), which the order follows.

mod conductance;
mod order;

use glam::DVec2;

use conductance::conductances;
use order::elimination_order;

/// Heights of the membrane through known heights.
///
/// - `at`: nodes of the mesh, metres; any unit will do.
/// - `triangles`: indices of nodes, in any order and either way round.
/// - `known_m`: a height where it is given, finite. As many as nodes.
///
/// The others become harmonic: the mean of their neighbours, weighted as linear finite elements do.
/// Edges that are not Delaunay and would repel count for nothing, so that heights stay between the
/// lowest and the highest known one on any mesh. Nodes that no edge leads to from a known one get the
/// mean of all known ones, and 0 where none is known.
///
/// # Panics
/// If there are not as many heights as nodes, or a triangle names a node that is not there.
pub fn harmonic(at: &[DVec2], triangles: &[[usize; 3]], known_m: &[Option<f64>]) -> Vec<f64> {
    assert_eq!(at.len(), known_m.len(), "a height or none a node");
    let known = || known_m.iter().flatten();
    let count = known().count();
    let lowest_m = known().copied().fold(f64::INFINITY, f64::min);
    let mean_m = if count == 0 {
        0.0
    } else {
        known().map(|h| (h - lowest_m) / count as f64).sum::<f64>() + lowest_m
    };
    let mut height_m: Vec<f64> = known_m.iter().map(|h| h.unwrap_or(mean_m)).collect();
    if count == 0 || count == at.len() {
        return height_m;
    }
    let edges = conductances(at, triangles);
    let order = elimination_order(at, &edges, |i| known_m[i].is_none());
    let mut network = Network::new(at.len(), &order);
    for (a, b, conductance) in edges {
        match (known_m[a], known_m[b]) {
            (None, None) => network.join(a, b, conductance),
            // Above the lowest: not negative either.
            (None, Some(h)) => network.hold(a, conductance, h - lowest_m),
            (Some(h), None) => network.hold(b, conductance, h - lowest_m),
            (Some(_), Some(_)) => {}
        }
    }
    for (i, above_m) in order.iter().zip(network.solve()) {
        if let Some(above_m) = above_m {
            height_m[*i] = lowest_m + above_m;
        }
    }
    height_m
}

/// What an unknown node is tied to.
#[derive(Clone, Debug, Default)]
struct Star {
    /// Nodes that are taken out later, by their turn, ascending once this one is out.
    later: Vec<(usize, f64)>,
    /// Conductance to all known nodes together.
    held: f64,
    /// The same times their heights.
    pull: f64,
    /// Sum of all conductances.
    total: f64,
}

/// Unknown nodes in the order in which they are taken out.
struct Network {
    /// Turn of each node of the mesh.
    turn: Vec<usize>,
    stars: Vec<Star>,
}

impl Network {
    fn new(nodes: usize, order: &[usize]) -> Self {
        let mut turn = vec![usize::MAX; nodes];
        for (k, i) in order.iter().enumerate() {
            turn[*i] = k;
        }
        Self {
            turn,
            stars: vec![Star::default(); order.len()],
        }
    }

    fn join(&mut self, a: usize, b: usize, conductance: f64) {
        let (a, b) = (self.turn[a], self.turn[b]);
        self.stars[a.min(b)].later.push((a.max(b), conductance));
    }

    fn hold(&mut self, a: usize, conductance: f64, above_m: f64) {
        let star = &mut self.stars[self.turn[a]];
        star.held += conductance;
        star.pull += conductance * above_m;
    }

    /// Heights in the order of elimination; `None` for what nothing known is tied to.
    fn solve(mut self) -> Vec<Option<f64>> {
        self.eliminate();
        let mut found: Vec<Option<f64>> = vec![None; self.stars.len()];
        for (k, star) in self.stars.iter().enumerate().rev() {
            let (mut pull, mut total) = (star.pull, star.held);
            for (i, conductance) in &star.later {
                if let Some(above_m) = found[*i] {
                    pull += conductance * above_m;
                    total += conductance;
                }
            }
            found[k] = (total > 0.0).then(|| pull / total);
        }
        found
    }

    /// Completes each star by what the nodes before it leave behind.
    fn eliminate(&mut self) {
        const NONE: usize = usize::MAX;
        let count = self.stars.len();
        // Stars whose next end is this node, as linked lists, and how far into each we are.
        let (mut first, mut next) = (vec![NONE; count], vec![NONE; count]);
        let mut reached = vec![0; count];
        let mut sum = vec![0.0; count];
        let mut is_new = vec![true; count];
        for k in 0..count {
            let mut star = core::mem::take(&mut self.stars[k]);
            let mut ends = Vec::with_capacity(star.later.len());
            let mut add = |i: usize, conductance: f64| {
                if core::mem::replace(&mut is_new[i], false) {
                    ends.push(i);
                }
                sum[i] += conductance;
            };
            for (i, conductance) in &star.later {
                add(*i, *conductance);
            }
            let mut from = core::mem::replace(&mut first[k], NONE);
            while from != NONE {
                let following = next[from];
                let gone = &self.stars[from];
                let own = reached[from];
                let share = gone.later[own].1 / gone.total;
                star.held += share * gone.held;
                star.pull += share * gone.pull;
                for (i, conductance) in &gone.later[own + 1..] {
                    add(*i, share * conductance);
                }
                reached[from] = own + 1;
                if let Some((i, _)) = gone.later.get(own + 1) {
                    next[from] = core::mem::replace(&mut first[*i], from);
                }
                from = following;
            }
            ends.sort_unstable();
            star.total = star.held;
            star.later.clear();
            for i in ends {
                is_new[i] = true;
                let conductance = core::mem::take(&mut sum[i]);
                if conductance > 0.0 {
                    star.total += conductance;
                    star.later.push((i, conductance));
                }
            }
            if let Some((i, _)) = star.later.first() {
                next[k] = core::mem::replace(&mut first[*i], k);
            }
            self.stars[k] = star;
        }
    }
}

#[cfg(test)]
mod tests;
