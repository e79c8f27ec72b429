//! The compiled graph: nodes, their inputs, and the cut points at which results are stored.
//!
//! Every request first resolves what decides the wanted samples (`resolve`): identities, invisible
//! nodes and uniform inputs drop out before any sample is made. What is left is named (content ids)
//! or made (`run`).

mod artefacts;
mod regions;
mod resolve;
mod round;
mod run;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_planet::{Grid, TileKey};
use relievo_raster::{Bands, Block, Cancel, SampleType, Tile};

use crate::{ContentId, IdHasher, ImageNode, Known, RenderError};
pub use artefacts::Artefacts;
use resolve::{Resolver, Source};
use run::{Maker, Reader};

/// Names a node of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeIndex(pub u32);

impl NodeIndex {
    fn at(self) -> usize {
        self.0 as usize
    }
}

/// Gives the tiles that [`Graph::dependencies`] named.
pub type TileInputs<'a> = dyn Fn(NodeIndex, TileKey) -> Arc<Tile> + 'a;

/// A node, what it reads, and whether its result is stored.
struct Entry {
    node: Arc<dyn ImageNode>,
    inputs: Vec<NodeIndex>,
    cut: Option<SampleType>,
}

/// Puts a graph together; inputs come before what reads them.
#[derive(Default)]
pub struct GraphBuilder {
    entries: Vec<Entry>,
    artefacts: Arc<Artefacts>,
}

/// An immutable graph of nodes.
pub struct Graph {
    entries: Vec<Entry>,
    artefacts: Arc<Artefacts>,
    /// Names of the artefacts that were asked for.
    artefact_names: Mutex<HashMap<(NodeIndex, ContentId), ContentId>>,
}

impl GraphBuilder {
    /// Keeps artefacts in a store that other graphs may share, so that what does not change from
    /// revision to revision is made once.
    pub fn keep_artefacts(&mut self, store: &Arc<Artefacts>) {
        self.artefacts = Arc::clone(store);
    }

    /// Adds a node that reads `inputs`.
    ///
    /// # Panics
    /// If an input does not exist yet.
    pub fn add(&mut self, node: Arc<dyn ImageNode>, inputs: &[NodeIndex]) -> NodeIndex {
        assert!(
            inputs.iter().all(|i| i.at() < self.entries.len()),
            "inputs come before what reads them"
        );
        self.entries.push(Entry {
            node,
            inputs: inputs.to_vec(),
            cut: None,
        });
        NodeIndex((self.entries.len() - 1) as u32)
    }

    /// Makes a node a cut point: its samples are rounded to `to` and stored as tiles.
    ///
    /// # Panics
    /// If the node does not exist or gives other bands than `to` stores.
    pub fn cut(&mut self, node: NodeIndex, to: SampleType) {
        let entry = &mut self.entries[node.at()];
        assert_eq!(entry.node.output(), to.bands(), "bands of the sample type");
        entry.cut = Some(to);
    }

    /// The graph. Inputs of nodes that are not pointwise become cut points where they are not yet
    /// (heights and normals as their type, colours and masks exactly).
    pub fn build(mut self) -> Graph {
        let around: Vec<NodeIndex> = self
            .entries
            .iter()
            .filter(|e| !e.node.is_pointwise())
            .flat_map(|e| e.inputs.iter().copied())
            .collect();
        for input in around {
            let entry = &mut self.entries[input.at()];
            entry.cut = entry.cut.or(Some(match entry.node.output() {
                Bands::Height => SampleType::Height,
                Bands::Colour => SampleType::Rgba32F,
                Bands::Mask => SampleType::Mask32F,
                Bands::Normal => SampleType::Normal,
            }));
        }
        Graph {
            entries: self.entries,
            artefacts: self.artefacts,
            artefact_names: Mutex::default(),
        }
    }
}

impl Graph {
    fn entry(&self, node: NodeIndex) -> &Entry {
        &self.entries[node.at()]
    }

    /// How a cut point stores its samples; `None` for other nodes.
    ///
    /// # Panics
    /// Here and below: if the node is not one of this graph's.
    pub fn cut_type(&self, node: NodeIndex) -> Option<SampleType> {
        self.entry(node).cut
    }

    /// All cut points, inputs first.
    pub fn cuts(&self) -> impl Iterator<Item = NodeIndex> + '_ {
        let nodes = self.entries.iter().enumerate();
        nodes.filter_map(|(i, e)| e.cut.map(|_| NodeIndex(i as u32)))
    }

    /// All nodes, inputs before what reads them.
    pub fn nodes(&self) -> impl Iterator<Item = NodeIndex> + use<> {
        (0..self.entries.len()).map(|i| NodeIndex(i as u32))
    }

    /// What a node reads.
    pub fn inputs(&self, node: NodeIndex) -> &[NodeIndex] {
        &self.entry(node).inputs
    }

    /// The node itself.
    pub fn node(&self, node: NodeIndex) -> &dyn ImageNode {
        &*self.entry(node).node
    }

    /// Nodes that another graph has too: the very same node under the same number, stored the same way and
    /// reading the same. What they give has the same names.
    pub fn shared_with(&self, other: &Self) -> HashSet<NodeIndex> {
        let mut shared = HashSet::new();
        for (i, (own, others)) in self.entries.iter().zip(&other.entries).enumerate() {
            let is_same = Arc::ptr_eq(&own.node, &others.node)
                && own.cut == others.cut
                && own.inputs == others.inputs
                && own.inputs.iter().all(|input| shared.contains(input));
            if is_same {
                shared.insert(NodeIndex(i as u32));
            }
        }
        shared
    }

    /// What is known of a node's samples on a grid.
    pub fn known(&self, node: NodeIndex, grid: &Grid) -> Known {
        Resolver::new(self, Arc::clone(&grid.lattice), None).known_over(node, &grid.rect)
    }

    /// Name of what cut point `node` gives on a tile. Makes no sample.
    ///
    /// # Panics
    /// If the node is not a cut point.
    pub fn content_id(&self, node: NodeIndex, key: TileKey) -> ContentId {
        let stored = self.stored_as(node);
        let (mut resolver, at) = self.resolver(key);
        let source = resolver.resolve(node, at).source;
        resolver.tile_id(source, stored, at)
    }

    /// Tiles of other cut points that [`Graph::make`] reads: after leaving out identities,
    /// invisible nodes and uniform inputs. Sorted, without duplicates.
    ///
    /// No dependency has the content id of the tile itself.
    pub fn dependencies(&self, node: NodeIndex, key: TileKey) -> Vec<(NodeIndex, TileKey)> {
        let (mut resolver, at) = self.resolver(key);
        // What another cut point hands through unchanged is made as that one is made.
        let source = match resolver.resolve(node, at).source {
            Source::Cut(content) => resolver.raw(content, at).source,
            uniform_or_uncut @ (Source::Uniform(_) | Source::Raw(_)) => uniform_or_uncut,
        };
        resolver.tiles_read(source, at)
    }

    /// Makes a tile of cut point `node` from its dependencies: runs of pointwise nodes in one pass
    /// over strips of rows.
    ///
    /// # Errors
    /// [`RenderError`] from a node, or `Cancelled`.
    ///
    /// # Panics
    /// If the node is not a cut point, or `inputs` gives tiles of another type than the cut point's.
    pub fn make(
        &self,
        node: NodeIndex,
        key: TileKey,
        inputs: &TileInputs,
        cancel: &Cancel,
    ) -> Result<Tile, RenderError> {
        let stored = self.stored_as(node);
        let (mut resolver, at) = self.resolver(key);
        let source = match resolver.resolve(node, at).source {
            Source::Uniform(value) => return Ok(Tile::uniform(round::sample(value, stored))),
            Source::Cut(content) => resolver.raw(content, at).source,
            Source::Raw(raw) => Source::Raw(raw),
        };
        Maker::new(resolver, Reader::Tiles(inputs), cancel).make_tile(source, stored, at)
    }

    /// Evaluates any node on any grid, without tiles: what `bake` and `sample` use. Equal bit for
    /// bit to tiles where the grid is a tile's, since cut points round here too.
    ///
    /// # Errors
    /// [`RenderError`] from a node, or `Cancelled`.
    pub fn evaluate(
        &self,
        node: NodeIndex,
        grid: &Grid,
        cancel: &Cancel,
    ) -> Result<Block, RenderError> {
        let resolver = Resolver::new(self, Arc::clone(&grid.lattice), None);
        Maker::new(resolver, Reader::Evaluate, cancel).gather(node, &grid.rect)
    }

    /// Name of what [`Graph::evaluate`] gives on a grid, however large: makes no sample. Equal names
    /// mean equal samples, so work on a region can go on after a stop.
    pub fn evaluation_id(&self, node: NodeIndex, grid: &Grid) -> ContentId {
        let mut id = IdHasher::on(IdHasher::grid_name(grid));
        Resolver::new(self, Arc::clone(&grid.lattice), None)
            .add_surroundings(node, &grid.rect, &mut id);
        id.finish()
    }

    /// Kinds of the nodes that decide a sample of `grid`, in order of evaluation: what a user sees
    /// as "made by". Left-out nodes are not named, nor are those known to give nothing there.
    pub fn made_by(&self, node: NodeIndex, grid: &Grid) -> Vec<NodeIndex> {
        Resolver::new(self, Arc::clone(&grid.lattice), None).made_by(node, &grid.rect)
    }

    fn stored_as(&self, node: NodeIndex) -> SampleType {
        self.cut_type(node)
            .expect("tiles are asked of cut points only")
    }

    /// A resolver for the tiles of a level, and the place of one of them in it.
    fn resolver(&self, key: TileKey) -> (Resolver<'_>, usize) {
        let mut resolver = Resolver::new(self, Arc::new(key.level.lattice()), Some(key.level));
        let at = resolver.place(key.rect());
        (resolver, at)
    }
}

#[cfg(test)]
mod tests;
