//! Boxes around runs of vertices, so that a part of a million vertices is touched only where a tile
//! shows it, and only as finely as the tile shows it.

use glam::DVec2;

use super::{Bounds, Features, Part};

/// Edges in a run.
const RUN: usize = 16;

/// Runs below a box of the next level.
const FAN: usize = 8;

/// Parts with fewer vertices have no boxes but their own.
const SHORT: usize = 48;

/// What to do with a run of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visit {
    /// Leave it out.
    Skip,
    /// One edge from its first to its last vertex instead.
    Chord,
    /// All of its edges.
    Open,
}

/// Who walks along a part.
pub(crate) trait Walker {
    /// What to do with the edges in a box.
    fn look(&mut self, bounds: &Bounds) -> Visit;

    /// A chain of vertices; the first is the last of the chain before, unless something was skipped.
    /// `at` is the first one's place in the part, `stride` how far the next is from it. Whether to go
    /// on.
    fn chain(&mut self, vertices: &[DVec2], at: usize, stride: usize) -> bool;

    /// Edges were left out.
    fn skipped(&mut self) {}
}

/// Boxes of a part, appended: runs first, then their groups, up to one box.
pub(super) fn append(vertices: &[DVec2], chunks: &mut Vec<Bounds>) {
    if vertices.len() < SHORT {
        return;
    }
    let mut first = chunks.len();
    for at in (0..vertices.len() - 1).step_by(RUN) {
        let run = &vertices[at..vertices.len().min(at + RUN + 1)];
        chunks.extend(Bounds::around(run.iter().copied()));
    }
    while chunks.len() - first > 1 {
        let last = chunks.len();
        for at in (first..last).step_by(FAN) {
            let group = chunks[at..last.min(at + FAN)].iter().copied();
            let around = group.reduce(|a, b| a.union(&b));
            chunks.extend(around);
        }
        first = last;
    }
}

impl Features {
    /// Walks along a part from its first vertex to its last. Whether it came there.
    pub(crate) fn walk(&self, part: &Part, walker: &mut impl Walker) -> bool {
        let vertices = self.vertices_of(part);
        if vertices.len() < SHORT {
            return match walker.look(&part.bounds) {
                Visit::Skip => {
                    walker.skipped();
                    true
                }
                Visit::Chord if vertices.len() > 1 => {
                    let last = vertices.len() - 1;
                    walker.chain(&[vertices[0], vertices[last]], 0, last)
                }
                Visit::Chord | Visit::Open => walker.chain(vertices, 0, 1),
            };
        }
        let mut counts = vec![(vertices.len() - 1).div_ceil(RUN)];
        while let Some(last) = counts.last().copied().filter(|c| *c > 1) {
            counts.push(last.div_ceil(FAN));
        }
        let top = counts.len() - 1;
        let chunks = &self.chunks[part.chunks as usize..][..counts.iter().sum()];
        let tree = Tree {
            vertices,
            chunks,
            counts,
        };
        tree.visit(top, 0, walker)
    }
}

struct Tree<'a> {
    vertices: &'a [DVec2],
    chunks: &'a [Bounds],
    /// Boxes of each level, runs first.
    counts: Vec<usize>,
}

impl Tree<'_> {
    fn visit(&self, level: usize, at: usize, walker: &mut impl Walker) -> bool {
        let before: usize = self.counts[..level].iter().sum();
        let edges = RUN * FAN.pow(level as u32);
        let first = at * edges;
        let last = (first + edges).min(self.vertices.len() - 1);
        match walker.look(&self.chunks[before + at]) {
            Visit::Skip => {
                walker.skipped();
                true
            }
            Visit::Chord => {
                let ends = [self.vertices[first], self.vertices[last]];
                walker.chain(&ends, first, last - first)
            }
            Visit::Open if level == 0 => walker.chain(&self.vertices[first..=last], first, 1),
            Visit::Open => {
                let children = at * FAN..self.counts[level - 1].min((at + 1) * FAN);
                children
                    .into_iter()
                    .all(|child| self.visit(level - 1, child, walker))
            }
        }
    }
}
