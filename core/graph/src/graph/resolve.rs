//! What decides a node's samples on a rectangle, before any is made.
//!
//! A node resolves to a [`Source`]: one value, the node's own samples, or the stored samples of a
//! cut point. Nodes that are the identity resolve to what their input does, so everything after
//! (ids, dependencies, making) never sees them.
//!
//! Walks use a stack of their own, not recursion, along runs of pointwise nodes: a project with
//! thousands of layers must not overflow a worker's stack.

mod names;

use std::collections::HashSet;
use std::sync::Arc;

use relievo_planet::{Grid, Lattice, LevelKey, SampleRect, TileKey};
use relievo_raster::{Bands, SampleType};

use super::regions::{Region, regions, tile_key};
use super::{Graph, NodeIndex, round};
use crate::{ContentId, Known};

/// Where the samples of a node come from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    /// Every sample has this value.
    Uniform([f32; 4]),
    /// What the node makes, not rounded.
    Raw(NodeIndex),
    /// What the cut point stores.
    Cut(NodeIndex),
}

/// A node's result on a rectangle, before any sample is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Value {
    pub(super) source: Source,
    pub(super) known: Known,
}

/// What was found out about a node on one rectangle.
#[derive(Clone, Copy, Default)]
struct Slot {
    /// Before rounding.
    raw: Option<Value>,
    /// As others read it.
    out: Option<Value>,
    raw_id: Option<ContentId>,
    cut_id: Option<ContentId>,
}

/// Resolves nodes of a graph on rectangles of one lattice and remembers the results.
pub(super) struct Resolver<'a> {
    pub(super) graph: &'a Graph,
    lattice: Arc<Lattice>,
    level: Option<LevelKey>,
    places: Vec<Place>,
}

/// A rectangle, and what was found out about each node on it.
struct Place {
    rect: SampleRect,
    /// Name of its grid.
    grid: Option<ContentId>,
    /// As far as the last node that was asked for.
    slots: Vec<Slot>,
}

impl<'a> Resolver<'a> {
    /// Rectangles are split into tiles of `level` where one is given.
    pub(super) fn new(graph: &'a Graph, lattice: Arc<Lattice>, level: Option<LevelKey>) -> Self {
        Self {
            graph,
            lattice,
            level,
            places: Vec::new(),
        }
    }

    /// A short name for a rectangle inside the lattice's extent.
    pub(super) fn place(&mut self, rect: SampleRect) -> usize {
        if let Some(at) = self.places.iter().position(|place| place.rect == rect) {
            return at;
        }
        self.places.push(Place {
            rect,
            grid: None,
            slots: Vec::new(),
        });
        self.places.len() - 1
    }

    /// The rectangle of a place.
    pub(super) fn rect(&self, at: usize) -> SampleRect {
        self.places[at].rect
    }

    /// The grid of a place.
    pub(super) fn grid(&self, at: usize) -> Grid {
        Grid::new(Arc::clone(&self.lattice), self.rect(at))
    }

    /// The tile that a place is; only where a level was given.
    pub(super) fn tile(&self, at: usize) -> TileKey {
        tile_key(self.level.expect("tiles of a level"), &self.rect(at))
    }

    /// The pieces that a rectangle anywhere is put together from.
    pub(super) fn regions(&self, rect: &SampleRect) -> Vec<Region> {
        regions(&self.lattice, self.level, rect)
    }

    fn slot(&self, node: NodeIndex, at: usize) -> Option<&Slot> {
        self.places[at].slots.get(node.at())
    }

    fn slot_mut(&mut self, node: NodeIndex, at: usize) -> &mut Slot {
        let slots = &mut self.places[at].slots;
        if slots.len() <= node.at() {
            slots.resize(node.at() + 1, Slot::default());
        }
        &mut slots[node.at()]
    }

    fn resolved(&self, node: NodeIndex, at: usize) -> Option<Value> {
        self.slot(node, at)?.out
    }

    /// A node's result as others read it: rounded if it is a cut point.
    pub(super) fn resolve(&mut self, node: NodeIndex, at: usize) -> Value {
        if let Some(value) = self.resolved(node, at) {
            return value;
        }
        let graph = self.graph;
        // Inputs have lower indices: room for all of them at once.
        self.slot_mut(node, at);
        let mut stack = vec![node];
        while let Some(&top) = stack.last() {
            if self.resolved(top, at).is_none() {
                let entry = graph.entry(top);
                let before = stack.len();
                if entry.node.is_pointwise() {
                    stack.extend(
                        entry
                            .inputs
                            .iter()
                            .filter(|i| self.resolved(**i, at).is_none()),
                    );
                }
                if stack.len() > before {
                    continue;
                }
                let raw = self.compute(top, at);
                let out = rounded(graph, top, raw);
                let slot = self.slot_mut(top, at);
                slot.raw = Some(raw);
                slot.out = Some(out);
            }
            stack.pop();
        }
        self.resolved(node, at).expect("just resolved")
    }

    /// A node's result before it is rounded.
    pub(super) fn raw(&mut self, node: NodeIndex, at: usize) -> Value {
        self.resolve(node, at);
        self.slot(node, at)
            .and_then(|slot| slot.raw)
            .expect("just resolved")
    }

    /// A node's result from its inputs' results, which are there already if it is pointwise.
    fn compute(&mut self, node: NodeIndex, at: usize) -> Value {
        let entry = self.graph.entry(node);
        let grid = self.grid(at);
        let mut inputs = [Known::Nothing; 4];
        let mut more = Vec::new();
        let known: &[Known] = if entry.inputs.len() <= inputs.len() {
            for (k, input) in entry.inputs.iter().enumerate() {
                inputs[k] = self.known_of_input(node, k, *input, at);
            }
            &inputs[..entry.inputs.len()]
        } else {
            for (k, input) in entry.inputs.iter().enumerate() {
                more.push(self.known_of_input(node, k, *input, at));
            }
            &more
        };
        if let Some(k) = entry.node.identity(&grid, known) {
            return self.resolve(entry.inputs[k], at);
        }
        match entry.node.known(&grid, known) {
            Known::Uniform(value) => {
                // Zeros of one kind, as if it were stored exactly: then a pin changes nothing.
                let value = if entry.node.output() == Bands::Colour {
                    round::value(value, SampleType::Rgba32F)
                } else {
                    value
                };
                Value {
                    source: Source::Uniform(value),
                    known: Known::Uniform(value),
                }
            }
            known @ (Known::Nothing | Known::Complete) => Value {
                source: Source::Raw(node),
                known,
            },
        }
    }

    fn known_of_input(&mut self, node: NodeIndex, k: usize, input: NodeIndex, at: usize) -> Known {
        let reader = &self.graph.entry(node).node;
        if reader.is_pointwise() {
            self.resolve(input, at).known
        } else {
            let rect = reader.required(k, self.rect(at));
            self.known_over(input, &rect)
        }
    }

    /// What is known of a node on a rectangle anywhere.
    pub(super) fn known_over(&mut self, node: NodeIndex, rect: &SampleRect) -> Known {
        let bands = self.graph.entry(node).node.output();
        let mut all: Option<Known> = None;
        for region in self.regions(rect) {
            let at = self.place(region.piece);
            let mut known = self.resolve(node, at).known;
            if let Known::Uniform(v) = known
                && bands == Bands::Normal
                && region.over_pole
                && (v[0] != 0.0 || v[1] != 0.0)
            {
                known = Known::Nothing; // turned around there
            }
            all = Some(all.map_or(known, |a| a.and(known, bands)));
            if all == Some(Known::Nothing) {
                break;
            }
        }
        all.unwrap_or(Known::Nothing)
    }

    /// Calls `each` with what `source` reads on the same rectangle.
    fn for_each_source_here(
        &mut self,
        source: Source,
        at: usize,
        mut each: impl FnMut(&mut Self, Source),
    ) {
        match source {
            Source::Uniform(_) => {}
            Source::Cut(node) => {
                let raw = self.raw(node, at).source;
                each(self, raw);
            }
            Source::Raw(node) => {
                let entry = self.graph.entry(node);
                if entry.node.is_pointwise() {
                    for input in &entry.inputs {
                        let source = self.resolve(*input, at).source;
                        each(self, source);
                    }
                }
            }
        }
    }

    /// Nodes that make `source` on a place, inputs first: those that `make` runs, as far as samples
    /// at the same place go. Sources that are read as a whole come as they are.
    pub(super) fn run_of(&mut self, source: Source, at: usize) -> Vec<NodeIndex> {
        let mut nodes = Vec::new();
        let mut stack = vec![source];
        while let Some(top) = stack.pop() {
            if let Source::Raw(node) = top
                && !nodes.contains(&node)
            {
                nodes.push(node);
                self.for_each_source_here(top, at, |_, source| stack.push(source));
            }
        }
        nodes.sort_unstable(); // inputs have lower indices
        nodes
    }

    /// The tiles that are read to make `source`.
    pub(super) fn tiles_read(&mut self, source: Source, at: usize) -> Vec<(NodeIndex, TileKey)> {
        let mut tiles = Vec::new();
        if let Source::Cut(cut) = source {
            tiles.push((cut, self.tile(at)));
        }
        for node in self.run_of(source, at) {
            let entry = self.graph.entry(node);
            for (k, input) in entry.inputs.iter().enumerate() {
                let pieces = if entry.node.is_pointwise() {
                    vec![at]
                } else {
                    let regions = self.regions(&entry.node.required(k, self.rect(at)));
                    regions
                        .iter()
                        .map(|region| self.place(region.piece))
                        .collect()
                };
                for piece in pieces {
                    if let Source::Cut(cut) = self.resolve(*input, piece).source {
                        tiles.push((cut, self.tile(piece)));
                    }
                }
            }
        }
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// Nodes that decide samples of a rectangle anywhere, inputs first.
    pub(super) fn made_by(&mut self, node: NodeIndex, rect: &SampleRect) -> Vec<NodeIndex> {
        let graph = self.graph;
        let mut nodes = Vec::new();
        let mut seen = HashSet::new();
        let mut stack: Vec<(NodeIndex, usize)> = Vec::new();
        for region in self.regions(rect) {
            stack.push((node, self.place(region.piece)));
        }
        while let Some((node, at)) = stack.pop() {
            if !seen.insert((node, at)) {
                continue;
            }
            let entry = graph.entry(node);
            if self.resolve(node, at).known.is_absent(entry.node.output()) {
                continue;
            }
            let grid = self.grid(at);
            let known: Vec<Known> = entry
                .inputs
                .iter()
                .enumerate()
                .map(|(k, i)| self.known_of_input(node, k, *i, at))
                .collect();
            if let Some(k) = entry.node.identity(&grid, &known) {
                stack.push((entry.inputs[k], at));
                continue;
            }
            nodes.push(node);
            for (k, input) in entry.inputs.iter().enumerate() {
                if entry.node.is_pointwise() {
                    stack.push((*input, at));
                } else {
                    for region in self.regions(&entry.node.required(k, self.rect(at))) {
                        stack.push((*input, self.place(region.piece)));
                    }
                }
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// What a cut point makes of its node's result: rounding what is already rounded so adds nothing.
fn rounded(graph: &Graph, node: NodeIndex, raw: Value) -> Value {
    let Some(to) = graph.entry(node).cut else {
        return raw;
    };
    match raw.source {
        // Kept exactly, it is what others read without the cut point.
        Source::Cut(_) if to.is_exact() => raw,
        Source::Uniform(value) => {
            let value = round::value(value, to);
            Value {
                source: Source::Uniform(value),
                known: Known::Uniform(value),
            }
        }
        Source::Cut(inner) if graph.entry(inner).cut == Some(to) => raw,
        Source::Raw(_) | Source::Cut(_) => Value {
            source: Source::Cut(node),
            known: raw.known,
        },
    }
}
