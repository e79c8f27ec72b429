//! The samples of one layer on a grid, before and after its own adjustment.

use relievo_graph::{NodeIndex, RenderError};
use relievo_planet::Grid;
use relievo_project::LayerId;
use relievo_raster::{Block, Cancel};

use crate::Questions;

/// Where in a layer's way samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// As the file, the noise or the colours by height give them.
    Source,
    /// Adjusted, before holes are filled and seams blended.
    Adjusted,
    /// As they meet what lies below.
    Over,
    /// What lies below.
    Below,
}

impl Questions {
    /// Samples of a layer on a grid; `None` where the layer takes no part in the picture.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn layer_samples(
        &self,
        layer: &LayerId,
        stage: Stage,
        grid: &Grid,
        cancel: &Cancel,
    ) -> Result<Option<Block>, RenderError> {
        let Some(node) = self.stage_of(layer, stage) else {
            return Ok(None);
        };
        self.scene.graph.evaluate(node, grid, cancel).map(Some)
    }

    /// The node behind a stage: a layer's first node makes its samples, its last one lays them over
    /// what is below (its first input).
    pub(crate) fn stage_of(&self, layer: &LayerId, stage: Stage) -> Option<NodeIndex> {
        let graph = &self.scene.graph;
        let mut own = graph
            .nodes()
            .filter(|n| self.scene.layers.of.get(n) == Some(layer));
        let first = own.next()?;
        // What continues other layers is one node for each of them.
        let last = own.last().unwrap_or(first);
        match stage {
            Stage::Source => Some(first),
            Stage::Adjusted => {
                let own = self.scene.layers.adjusted.get(layer).copied();
                own.or_else(|| graph.inputs(last).get(1).copied())
            }
            Stage::Over => graph.inputs(last).get(1).copied(),
            Stage::Below => graph.inputs(last).first().copied(),
        }
    }
}
