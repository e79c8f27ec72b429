//! The compiled graph: nodes, their inputs, and the cut points at which results are stored.

use std::sync::Arc;

use relievo_planet::{Grid, TileKey};
use relievo_raster::{Block, Cancel, SampleType, Tile};

use crate::{ContentId, ImageNode, Known, RenderError};

/// Names a node of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeIndex(pub u32);

/// Gives the tiles that [`Graph::dependencies`] named.
pub type TileInputs<'a> = dyn Fn(NodeIndex, TileKey) -> Arc<Tile> + 'a;

/// Puts a graph together; inputs come before what reads them.
#[derive(Default)]
pub struct GraphBuilder {}

/// An immutable graph of nodes.
pub struct Graph {}

#[expect(unused_variables, reason = "contract first")]
impl GraphBuilder {
    /// Adds a node that reads `inputs`.
    ///
    /// # Panics
    /// If an input does not exist yet.
    pub fn add(&mut self, node: Arc<dyn ImageNode>, inputs: &[NodeIndex]) -> NodeIndex {
        todo!()
    }

    /// Makes a node a cut point: its samples are rounded to `to` and stored as tiles.
    pub fn cut(&mut self, node: NodeIndex, to: SampleType) {
        todo!()
    }

    /// The graph. Inputs of nodes that are not pointwise become cut points where they are not yet
    /// (heights and normals as their type, colours as `Rgba32F`, which is exact).
    pub fn build(self) -> Graph {
        todo!()
    }
}

#[expect(unused_variables, reason = "contract first")]
impl Graph {
    /// How a cut point stores its samples; `None` for other nodes.
    pub fn cut_type(&self, node: NodeIndex) -> Option<SampleType> {
        todo!()
    }

    /// The node itself.
    pub fn node(&self, node: NodeIndex) -> &dyn ImageNode {
        todo!()
    }

    /// What is known of a node's samples on a grid.
    pub fn known(&self, node: NodeIndex, grid: &Grid) -> Known {
        todo!()
    }

    /// Name of what cut point `node` gives on a tile. Makes no sample.
    pub fn content_id(&self, node: NodeIndex, key: TileKey) -> ContentId {
        todo!()
    }

    /// Tiles of other cut points that [`Graph::make`] reads: after leaving out identities,
    /// invisible nodes and uniform inputs. Sorted, without duplicates.
    pub fn dependencies(&self, node: NodeIndex, key: TileKey) -> Vec<(NodeIndex, TileKey)> {
        todo!()
    }

    /// Makes a tile of cut point `node` from its dependencies: runs of pointwise nodes in one pass
    /// over strips of rows.
    ///
    /// # Errors
    /// [`RenderError`] from a node, or `Cancelled`.
    pub fn make(&self, node: NodeIndex, key: TileKey, inputs: &TileInputs, cancel: &Cancel) -> Result<Tile, RenderError> {
        todo!()
    }

    /// Evaluates any node on any grid, without tiles: what `bake` and `sample` use. Equal bit for
    /// bit to tiles where the grid is a tile's, since cut points round here too.
    ///
    /// # Errors
    /// [`RenderError`] from a node, or `Cancelled`.
    pub fn evaluate(&self, node: NodeIndex, grid: &Grid, cancel: &Cancel) -> Result<Block, RenderError> {
        todo!()
    }

    /// Kinds of the nodes that decide a sample of `grid`, in order of evaluation: what a user sees
    /// as "made by". Left-out nodes are not named.
    pub fn made_by(&self, node: NodeIndex, grid: &Grid) -> Vec<NodeIndex> {
        todo!()
    }
}
