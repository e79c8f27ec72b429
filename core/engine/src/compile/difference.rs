//! How the ground of what is shown differs from another project's, as colours over all others.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{self, Tint};
use relievo_project::{Layer, LayerKind, Project};

use super::Compiler;
use crate::difference::HeightDifference;
use crate::scene::Elements;

/// The heights that are shown.
pub(super) struct Shown<'a> {
    pub(super) project: &'a Project,
    /// Without planning elements.
    pub(super) ground: NodeIndex,
    pub(super) height: NodeIndex,
    pub(super) elements: &'a Elements,
}

impl Compiler<'_> {
    /// Colours of the shown heights less those of `other`, over `below`.
    pub(super) fn difference(
        &mut self,
        shown: &Shown<'_>,
        other: &Project,
        difference: HeightDifference,
        below: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        let (said, left_out) = (self.problems.len(), self.left_out.len());
        let same_ground = heights(shown.project).eq(heights(other));
        let ground = if same_ground {
            shown.ground
        } else {
            self.heights(other)
        };
        let (height, elements) = self.elements(other, ground);
        // What is odd about the other one is told where it is shown.
        self.problems.truncate(said);
        self.left_out.truncate(left_out);
        let node = if same_ground {
            nodes::HeightDifference::of_elements(shown.elements.node.clone(), elements.node)
        } else {
            nodes::HeightDifference::new()
        };
        let metres = self.builder.add(Arc::new(node), &[shown.height, height]);
        // Stops that are made here always rise.
        let Ok(tint) = Tint::new(&difference.stops(), true) else {
            return below;
        };
        let colours = self.builder.add(Arc::new(tint), &[metres]);
        Some(self.lay_over_shown(below, colours))
    }
}

/// The layers that make the ground.
fn heights(project: &Project) -> impl Iterator<Item = &Layer> {
    let layers = project.layers.iter();
    layers.filter(|l| {
        let gives = matches!(
            l.kind,
            LayerKind::Height(_) | LayerKind::Noise(_) | LayerKind::Detail(_)
        );
        gives && l.visible && l.opacity > 0.0
    })
}
