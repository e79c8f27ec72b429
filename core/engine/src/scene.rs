//! One revision of a project, compiled: the graph, its roots, and the names of their tiles.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_graph::nodes::Earthwork;
use relievo_graph::{ContentId, Graph, NodeIndex};
use relievo_planet::clipmap::Window;
use relievo_planet::clipmap::levels::{columns_exponent, reach_rad};
use relievo_planet::{Grid, LevelKey, MapPoint, TileKey};
use relievo_project::{Element, LayerId};
use relievo_raster::Bands;
use relievo_tiles::Want;
use rustc_hash::FxHashMap;

use crate::ClipKind;

/// Names of a node's tiles are forgotten beyond this many; a view needs a few thousand.
const NAMES_KEPT: usize = 20_000;

/// A compiled revision. Immutable but for the memory of tile names.
pub(crate) struct Scene {
    /// Counts revisions.
    pub(crate) revision: u64,
    pub(crate) graph: Arc<Graph>,
    pub(crate) roots: Roots,
    /// Which nodes belong to which layers.
    pub(crate) layers: LayerNodes,
    /// The planning elements that take part.
    pub(crate) elements: Elements,
    /// How fine each source is.
    details: Vec<Detail>,
    /// Layers that the graph leaves out, and why.
    pub(crate) left_out: Vec<(LayerId, &'static str)>,
    /// Whether layers were mixed by themselves before they went over those below: colours round otherwise.
    pub(crate) mixed_apart: bool,
    /// The drag of which it is a moment, counted.
    pub(crate) drag: Option<u64>,
    names: Mutex<FxHashMap<NodeIndex, Names>>,
}

/// Names of a node's tiles, shared with later revisions for which they are the same.
type Names = Arc<Mutex<FxHashMap<TileKey, ContentId>>>;

/// The cut points that are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Roots {
    /// The heights of all height layers together, without planning elements.
    pub(crate) ground: NodeIndex,
    /// The heights that are shown.
    pub(crate) height: NodeIndex,
    /// `None` when no layer gives colour.
    pub(crate) colour: Option<NodeIndex>,
    /// `None` when no layer gives heights: a smooth ball needs no normals.
    pub(crate) normal: Option<NodeIndex>,
}

/// Which nodes belong to which layers.
#[derive(Clone, Default)]
pub(crate) struct LayerNodes {
    /// The layer behind each node, where one is.
    pub(crate) of: HashMap<NodeIndex, LayerId>,
    /// What gives the adjusted colours of imagery, before its holes are filled and its seams bent.
    pub(crate) adjusted: HashMap<LayerId, NodeIndex>,
}

/// How fine one source is.
#[derive(Clone)]
pub(crate) struct Detail {
    /// The node that reads or makes it.
    pub(crate) node: NodeIndex,
    /// Finest level n that it is worth.
    pub(crate) finest: u8,
    /// Where these elements act only; elsewhere the node hands something coarser through.
    pub(crate) within: Option<Arc<Earthwork>>,
    /// Wavelengths below this are made up by the node, metres.
    pub(crate) synthesised_below_m: Option<f64>,
}

impl Detail {
    /// Wherever the node gives anything.
    pub(crate) fn everywhere(node: NodeIndex, finest: u8) -> Self {
        Self {
            node,
            finest,
            within: None,
            synthesised_below_m: None,
        }
    }
}

/// Planning elements of a scene.
#[derive(Clone, Default)]
pub(crate) struct Elements {
    /// The node that makes their heights; `None` without elements.
    pub(crate) node: Option<Arc<Earthwork>>,
    /// All of them in the order of the node's list.
    pub(crate) all: Vec<Arc<Element>>,
}

impl Scene {
    /// `last`: the revision before, whose names hold for what both have.
    pub(crate) fn new(
        (revision, last): (u64, Option<&Self>),
        graph: Arc<Graph>,
        roots: Roots,
        elements: Elements,
        layers: LayerNodes,
        details: Vec<Detail>,
        left_out: Vec<(LayerId, &'static str)>,
    ) -> Self {
        let mut names = FxHashMap::default();
        if let Some(last) = last {
            let shared = graph.shared_with(&last.graph);
            let known = last.names.lock();
            let kept = known.iter().filter(|(node, _)| shared.contains(node));
            names.extend(kept.map(|(node, names)| (*node, Arc::clone(names))));
        }
        Self {
            revision,
            graph,
            roots,
            elements,
            layers,
            details,
            left_out,
            mixed_apart: false,
            drag: None,
            names: Mutex::new(names),
        }
    }

    /// Finest level n that some source is worth anywhere.
    pub(crate) fn finest(&self) -> u8 {
        self.details.iter().map(|d| d.finest).max().unwrap_or(0)
    }

    /// Finest level n that heights, or colours by files alone, are worth anywhere: colours that are made up
    /// make no place finer.
    pub(crate) fn finest_of_ground(&self) -> u8 {
        let counts = |d: &&Detail| {
            d.synthesised_below_m.is_none() || self.graph.node(d.node).output() == Bands::Height
        };
        let finest = self.details.iter().filter(counts).map(|d| d.finest);
        finest.max().unwrap_or(0)
    }

    /// Finest level n that is worth showing in windows of `size` samples around a focus: some source
    /// as fine as the level reaches into its window. A coarser level shows the same, magnified.
    pub(crate) fn finest_near(&self, focus: MapPoint, size: u32) -> u8 {
        self.finest_in(None, |n| {
            let level = LevelKey::new(
                columns_exponent(n, focus.colat_rad, reach_rad(n, size), size),
                n,
            );
            Grid::new(
                Arc::new(level.lattice()),
                Window::place(level, focus, size).rect,
            )
        })
    }

    /// Finest level n for which some source as fine as that reaches into a grid of the level. With
    /// `heights` only sources of heights count, and planning elements, which are exact, as no finer than
    /// that level.
    pub(crate) fn finest_in(&self, heights: Option<u8>, grid_of: impl Fn(u8) -> Grid) -> u8 {
        let finest = |detail: &Detail| match (heights, &detail.within) {
            (Some(exact), Some(_)) => detail.finest.min(exact),
            (Some(_), None) if self.graph.node(detail.node).output() != Bands::Height => 0,
            _ => detail.finest,
        };
        let roots = [
            Some(self.roots.height),
            self.roots.colour,
            self.roots.normal,
        ];
        // What is absent there, or covered, is not worth a level.
        let decides = |n: u8| {
            let grid = grid_of(n);
            let roots = roots.into_iter().flatten();
            let made_by: HashSet<NodeIndex> = roots
                .flat_map(|root| self.graph.made_by(root, &grid))
                .collect();
            move |node: NodeIndex| made_by.contains(&node)
        };
        (1..=self.finest())
            .rev()
            .find(|n| {
                let mut fine = self.details.iter().filter(|d| finest(d) >= *n).peekable();
                if fine.peek().is_none() {
                    return false;
                }
                let decides = decides(*n);
                fine.any(|d| decides(d.node))
            })
            .unwrap_or(0)
    }

    /// Whether any of it is made up beyond the data's own resolution.
    pub(crate) fn is_synthesised(&self) -> bool {
        self.details.iter().any(|d| d.synthesised_below_m.is_some())
    }

    /// Below which wavelength, in metres, what a node gives is made up.
    pub(crate) fn synthesised_below_m(&self, node: NodeIndex) -> Option<f64> {
        let detail = self.details.iter().find(|d| d.node == node)?;
        detail.synthesised_below_m
    }

    /// The cut point behind a clipmap.
    pub(crate) fn root(&self, kind: ClipKind) -> Option<NodeIndex> {
        match kind {
            ClipKind::Height => Some(self.roots.height),
            ClipKind::Colour => self.roots.colour,
            ClipKind::Normal => self.roots.normal,
        }
    }

    /// Name of a tile of a root.
    pub(crate) fn name(&self, node: NodeIndex, key: TileKey) -> ContentId {
        let names = Arc::clone(self.names.lock().entry(node).or_default());
        if let Some(id) = names.lock().get(&key) {
            return *id;
        }
        let id = self.graph.content_id(node, key);
        let mut names = names.lock();
        if names.len() >= NAMES_KEPT {
            names.clear();
        }
        names.insert(key, id);
        id
    }

    /// Number of names that are remembered.
    pub(crate) fn names(&self) -> usize {
        self.names
            .lock()
            .values()
            .map(|names| names.lock().len())
            .sum()
    }

    /// What to ask the scheduler for.
    pub(crate) fn want(&self, node: NodeIndex, key: TileKey) -> Want {
        Want {
            graph: Arc::clone(&self.graph),
            node,
            key,
            id: self.name(node, key),
        }
    }
}
