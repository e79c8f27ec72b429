//! What the picture does without: layers that are not compiled, and layers that decide no visible
//! sample.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use relievo_graph::{ContentId, NodeIndex};
use relievo_planet::TileKey;
use relievo_planet::clipmap::Plan;
use relievo_project::LayerId;
use relievo_raster::Bands;

use super::Engine;
use super::asking::named;
use crate::frame::ClipKind;
use crate::scene::Scene;

/// Layers that decide nothing visible, of a revision and a plan.
pub(super) type Unseen = (Arc<Scene>, Arc<Plan>, Vec<(LayerId, &'static str)>);

impl Engine {
    /// Layers that the shown picture leaves out, and why: hidden, opacity 0, without effect, no file.
    /// They are no part of the graph.
    pub fn left_out(&self) -> &[(LayerId, &'static str)] {
        &self.shown.left_out
    }

    /// Layers of the graph that decide no sample of any visible tile, and why: off the screen, or
    /// covered. Nothing of them is read or made for the picture. Empty until a view is planned.
    ///
    /// Found out once for a revision and a plan; costs as much as naming all visible tiles anew.
    pub fn unseen(&self) -> Vec<(LayerId, &'static str)> {
        let Some(plan) = &self.plan else {
            return Vec::new();
        };
        let mut known = self.unseen.lock();
        if let Some((of, at, layers)) = &*known
            && (Arc::ptr_eq(of, &self.shown) && Arc::ptr_eq(at, plan))
        {
            return layers.clone();
        }
        let layers = self.find_unseen(plan);
        *known = Some((Arc::clone(&self.shown), Arc::clone(plan), layers.clone()));
        layers
    }

    fn find_unseen(&self, plan: &Plan) -> Vec<(LayerId, &'static str)> {
        let (scene, graph) = (&self.shown, &self.shown.graph);
        let grids: Vec<_> = plan
            .selected_tiles()
            .into_iter()
            .flat_map(|(kind, key)| named(scene, kind, key))
            .filter_map(|(kind, key, _)| Some((scene.root(kind)?, key.grid())))
            .collect();
        let seen: HashSet<NodeIndex> = grids
            .iter()
            .flat_map(|(root, grid)| graph.made_by(*root, grid))
            .collect();
        let mut layers: BTreeMap<&LayerId, Vec<NodeIndex>> = BTreeMap::new();
        let mut owned: Vec<_> = scene.layers.of.iter().collect();
        owned.sort_unstable_by_key(|(node, _)| **node);
        for (node, layer) in owned {
            layers.entry(layer).or_default().push(*node);
        }
        let unseen = layers
            .into_iter()
            .filter(|(_, nodes)| nodes.iter().all(|n| !seen.contains(n)));
        unseen
            .map(|(layer, nodes)| {
                // The first node of a layer reads or makes what it shows.
                let bands = graph.node(nodes[0]).output();
                // Colours are no part of the tiles of heights and normals.
                let is_here = grids.iter().any(|(root, grid)| {
                    (bands == Bands::Height || scene.roots.colour == Some(*root))
                        && !graph.known(nodes[0], grid).is_absent(bands)
                });
                let reason = if is_here { "covered" } else { "off the screen" };
                (layer.clone(), reason)
            })
            .collect()
    }

    /// The visible tiles of the shown revision and their names, as they are asked for: equal names mean
    /// equal samples. Empty until a view is planned.
    pub fn visible_tiles(&self) -> Vec<(ClipKind, TileKey, ContentId)> {
        let plan = self.plan.iter();
        plan.flat_map(|p| p.selected_tiles())
            .flat_map(|(kind, key)| named(&self.shown, kind, key))
            .collect()
    }
}
