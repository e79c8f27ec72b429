//! What the nodes of the shown revision are and what they made, for who wants to see how a picture
//! comes about.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::{Graph, NodeIndex};
use relievo_project::LayerId;
use relievo_raster::SampleType;

use super::Engine;
use crate::ClipKind;
use crate::scene::Scene;

/// What a node made since the engine started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Made {
    /// Tiles that were made.
    pub tiles: u64,
    /// Tiles that could not be made.
    pub failed: u64,
    /// Time that the threads spent on them, without their inputs.
    pub time: Duration,
}

/// A node of the graph behind the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeReport {
    /// Its kind.
    pub kind: &'static str,
    /// The layer it belongs to.
    pub layer: Option<LayerId>,
    /// Positions in the list of what it reads, each before its own.
    pub inputs: Vec<usize>,
    /// How its tiles are stored; `None` where it is made on the way to another.
    pub stored: Option<SampleType>,
    /// What of the picture it is.
    pub shows: Option<ClipKind>,
    /// What it made. Nodes of one kind of one layer that store alike count together, over all
    /// revisions.
    pub made: Made,
}

/// Names a node over revisions.
type Name = (&'static str, Option<LayerId>, Option<SampleType>);

/// Counts what nodes made.
#[derive(Default)]
pub(super) struct Tally(HashMap<Name, Made>);

impl Engine {
    /// The nodes of the shown revision, inputs before what reads them. What they made is counted
    /// only with [`EngineOptions::tally`](super::EngineOptions::tally).
    pub fn nodes(&self) -> Vec<NodeReport> {
        let scene = &self.shown;
        let report = |node: NodeIndex| {
            let name = name(scene, node);
            let made = self.tally.as_ref().and_then(|t| t.0.get(&name));
            let shows = [ClipKind::Height, ClipKind::Colour, ClipKind::Normal];
            let inputs = scene.graph.inputs(node).iter();
            NodeReport {
                inputs: inputs.map(|i| i.0 as usize).collect(),
                shows: shows.into_iter().find(|k| scene.root(*k) == Some(node)),
                made: made.copied().unwrap_or_default(),
                kind: name.0,
                layer: name.1,
                stored: name.2,
            }
        };
        scene.graph.nodes().map(report).collect()
    }

    /// Takes in what was made since the last call.
    pub(super) fn count_made(&mut self) {
        let Some(tally) = &mut self.tally else { return };
        let scenes = [Some(&self.shown), self.making.as_ref()];
        for entry in self.tiles.take_log() {
            let is_of = |graph: &Arc<Graph>| entry.graph.as_ptr() == Arc::as_ptr(graph);
            let scene = scenes.into_iter().flatten().find(|s| is_of(&s.graph));
            // A tile of a revision that is gone already says nothing of those that are there.
            let Some(scene) = scene else { continue };
            let made = tally.0.entry(name(scene, entry.node)).or_default();
            if entry.ready {
                made.tiles += 1;
            } else {
                made.failed += 1;
            }
            made.time += entry.cost;
        }
    }
}

fn name(scene: &Scene, node: NodeIndex) -> Name {
    (
        scene.graph.node(node).kind(),
        scene.layers.of.get(&node).cloned(),
        scene.graph.cut_type(node),
    )
}
