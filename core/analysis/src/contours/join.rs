//! Segments joined into lines and rings.

use glam::DVec2;

/// A directed segment between two edges of the lattice, with its place on each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) from: u64,
    pub(crate) to: u64,
    pub(crate) from_share: f64,
    pub(crate) to_share: f64,
}

/// A line of lattice positions: node (column, row) is at whole numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chain {
    pub(crate) points: Vec<DVec2>,
    pub(crate) closed: bool,
}

/// Joins segments of one height. An edge is the end of at most one and the start of at most one, so
/// there is one way to do it; lines come first, then rings, each in the order of their first edge.
pub(crate) fn join(segments: &[Segment], width: u64) -> Vec<Chain> {
    let mut by_start: Vec<u32> = (0..segments.len() as u32).collect();
    by_start.sort_unstable_by_key(|i| segments[*i as usize].from);
    let mut ends: Vec<u64> = segments.iter().map(|s| s.to).collect();
    ends.sort_unstable();
    let starting_at = |edge: u64| {
        let found = by_start.binary_search_by_key(&edge, |i| segments[*i as usize].from);
        found.ok().map(|at| by_start[at] as usize)
    };
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    let opens = |i: &&u32| ends.binary_search(&segments[**i as usize].from).is_err();
    let firsts: Vec<u32> = by_start.iter().filter(opens).copied().collect();
    for first in firsts.iter().chain(&by_start) {
        let mut at = *first as usize;
        if used[at] {
            continue;
        }
        let mut points = vec![position(segments[at].from, segments[at].from_share, width)];
        let closed = loop {
            used[at] = true;
            let segment = &segments[at];
            match starting_at(segment.to) {
                Some(next) if !used[next] => {
                    points.push(position(segment.to, segment.to_share, width));
                    at = next;
                }
                Some(_) => break true,
                None => {
                    points.push(position(segment.to, segment.to_share, width));
                    break false;
                }
            }
        };
        chains.push(Chain { points, closed });
    }
    chains
}

/// Where an edge is crossed.
fn position(edge: u64, share: f64, width: u64) -> DVec2 {
    let node = edge / 2;
    let at = DVec2::new((node % width) as f64, (node / width) as f64);
    if edge.is_multiple_of(2) {
        at + DVec2::new(share, 0.0)
    } else {
        at + DVec2::new(0.0, share)
    }
}
