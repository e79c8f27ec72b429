//! Colour layers from the bottom up, over each other, and planning elements' own colours on top.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{Adjust, BlendMode, Constant, Overlay, SlopeAngle, Vector};
use relievo_project::{Adjust as ProjectAdjust, Blend, Layer, LayerKind, Project, VectorLayer};
use relievo_raster::SampleType;
use relievo_vector::Drawing;

use super::adjustment;
use super::{Compiler, Ground, Pinned, level_of_step, relief};
use crate::message::{Message, Severity};
use crate::scene::Detail;
use crate::sources::SourceState;
use crate::{element_colours, vectors};

impl Compiler<'_> {
    pub(super) fn colours(
        &mut self,
        project: &Project,
        ground: Ground,
        pinned: Option<Pinned<'_>>,
    ) -> Option<NodeIndex> {
        let mut below: Option<NodeIndex> = None;
        // Layers above a dragged one, put together by themselves.
        let mut above: Option<NodeIndex> = None;
        let mut is_above = false;
        for layer in &project.layers {
            let is_colour = matches!(
                layer.kind,
                LayerKind::Imagery(_)
                    | LayerKind::Tint(_)
                    | LayerKind::Slope(_)
                    | LayerKind::Contours(_)
                    | LayerKind::Vector(_)
            );
            if !is_colour || !self.takes_part(project, layer) {
                continue;
            }
            if is_above && mixes_alone(layer) {
                above = self.colour_layer(layer, project, above, ground).or(above);
                continue;
            }
            below = self.lay_kept_over(below, above.take());
            let is_lowest = pinned.is_some_and(|pinned| *pinned.lowest == layer.id);
            if let (true, Some(below)) = (is_lowest, below) {
                // What lies below the layer that is being edited is kept as exact f32, so that a
                // slider never evaluates it again. Exact, so no byte of the result changes.
                self.pin(below);
            }
            is_above |= pinned.is_some_and(|pinned| pinned.dragged && *pinned.topmost == layer.id);
            below = self.colour_layer(layer, project, below, ground).or(below);
        }
        below = self.lay_kept_over(below, above);
        self.element_colours(project, below)
    }

    /// Layers that were put together by themselves over what lies below them: kept, so that what changes
    /// below is mixed with all of them at once. To mix is associative, its rounding is not: colours
    /// differ by some 10⁻⁶ from those of layer after layer.
    fn lay_kept_over(
        &mut self,
        below: Option<NodeIndex>,
        above: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        let Some(above) = above else { return below };
        self.pin(above);
        self.mixed_apart = true;
        Some(self.lay_over(below, above))
    }

    /// Planning elements' own colours over all layers.
    fn element_colours(
        &mut self,
        project: &Project,
        mut below: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        let elements = project.elements_in(project.scenario.as_ref());
        let runs = element_colours::painted(&elements);
        for drawing in self.nodes.painted.drawings(runs, self.planet) {
            let node = match drawing {
                Ok(drawing) => Arc::new(Vector::new(drawing)),
                Err(text) => {
                    self.problems.push(Message {
                        severity: Severity::Warning,
                        layer: None,
                        element: None,
                        text: format!("colours of planning elements: {text}"),
                    });
                    continue;
                }
            };
            let top = self.builder.add(node, &[]);
            self.builder.cut(top, SampleType::Rgba8);
            let finest = level_of_step(vectors::FINEST_M / self.planet.radius_m);
            self.details.push(Detail::everywhere(top, finest));
            below = Some(self.lay_over(below, top));
        }
        below
    }

    /// Colours that are there so far; transparent where there are none.
    fn or_clear(&mut self, below: Option<NodeIndex>) -> NodeIndex {
        below.unwrap_or_else(|| self.builder.add(Arc::new(Constant::colour([0.0; 4])), &[]))
    }

    /// Colours over those that are there so far.
    pub(super) fn lay_over(&mut self, below: Option<NodeIndex>, top: NodeIndex) -> NodeIndex {
        let base = self.or_clear(below);
        let overlay = Overlay::new(BlendMode::Normal, 1.0, false);
        self.builder.add(Arc::new(overlay), &[base, top])
    }

    /// The same, and a tile that `top` leaves alone is the one that is shown without it.
    pub(super) fn lay_over_shown(&mut self, below: Option<NodeIndex>, top: NodeIndex) -> NodeIndex {
        if let Some(below) = below {
            self.builder.cut(below, SampleType::Rgba8);
        }
        self.lay_over(below, top)
    }

    fn pin(&mut self, node: NodeIndex) {
        self.builder.cut(node, SampleType::Rgba32F);
    }

    fn colour_layer(
        &mut self,
        layer: &Layer,
        project: &Project,
        below: Option<NodeIndex>,
        ground: Ground,
    ) -> Option<NodeIndex> {
        let base = self.or_clear(below);
        let (top, blend) = self.top(layer, project, ground)?;
        let mask = self.mask(layer, project, ground);
        let top = self.with_seams_blended(layer, below, top, mask);
        let mut inputs = match &layer.kind {
            LayerKind::Imagery(imagery) => {
                let file = self.open(layer)?;
                self.with_fade(layer, &file, &imagery.source, base, top)?
            }
            LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Unknown { .. } => vec![base, top],
        };
        if let Some(weights) = mask {
            self.also_masked(layer, &mut inputs, weights);
        }
        let masked = inputs.len() == 3;
        let overlay = Overlay::new(blend_mode(blend), layer.opacity as f32, masked);
        Some(self.add(layer, Arc::new(overlay), &inputs))
    }

    /// A layer's own colours, adjusted, and how they meet what lies below.
    fn top(
        &mut self,
        layer: &Layer,
        project: &Project,
        ground: Ground,
    ) -> Option<(NodeIndex, Blend)> {
        match &layer.kind {
            LayerKind::Imagery(imagery) => {
                Some((self.imagery(layer, imagery, project)?, imagery.blend))
            }
            LayerKind::Tint(tint) => {
                let node = self.keep(layer, relief::tint(&tint.tint))?;
                let top = self.add(layer, node, &[ground.height]);
                let adjusted = self.adjusted(layer, &tint.adjust, top);
                Some((adjusted, tint.blend))
            }
            LayerKind::Slope(slope) => {
                let normal = self.normal_of(layer, ground)?;
                let node = self.keep(layer, relief::slope(slope))?;
                let angle = self.add(layer, Arc::new(SlopeAngle), &[normal]);
                let top = self.add(layer, node, &[angle]);
                Some((top, slope.blend))
            }
            LayerKind::Contours(contours) => {
                let normal = self.normal_of(layer, ground)?;
                let node = self.keep(layer, relief::contours(contours, self.planet))?;
                let top = self.add(layer, node, &[ground.height, normal]);
                // Lines stay thin where the view is nearer than the data are fine.
                let finest = level_of_step(relief::FINEST_CONTOURS_M / self.planet.radius_m);
                self.details.push(Detail::everywhere(top, finest));
                Some((top, contours.blend))
            }
            LayerKind::Vector(vector) => {
                let top = self.vector_node(layer, vector)?;
                self.builder.cut(top, SampleType::Rgba8);
                let finest = level_of_step(vectors::FINEST_M / self.planet.radius_m);
                self.details.push(Detail::everywhere(top, finest));
                Some((top, Blend::Normal))
            }
            LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Unknown { .. } => None,
        }
    }

    /// Normals of the shown ground; notes where it has none because it is level everywhere.
    fn normal_of(&mut self, layer: &Layer, ground: Ground) -> Option<NodeIndex> {
        if ground.normal.is_none() {
            self.left_out.push((layer.id.clone(), "no heights"));
        }
        ground.normal
    }

    pub(super) fn adjusted(
        &mut self,
        layer: &Layer,
        adjust: &ProjectAdjust,
        top: NodeIndex,
    ) -> NodeIndex {
        if adjust.is_identity() {
            return top;
        }
        self.add(layer, Arc::new(Adjust::new(&adjustment(adjust))), &[top])
    }

    /// A vector layer's features in its style; kept while neither changes.
    fn vector_node(&mut self, layer: &Layer, vector: &VectorLayer) -> Option<NodeIndex> {
        let SourceState::Features(open) = self.ready(layer)? else {
            return None;
        };
        let features = Arc::clone(&open.features);
        let style = vectors::style(&vector.style);
        let address = Arc::as_ptr(&features).addr();
        let planet = self.planet;
        let name = format!("vector {address} {style:?} {planet:?}");
        let node = self.nodes.get(&mut self.used, name, || {
            Arc::new(Vector::new(Arc::new(Drawing::new(features, style, planet))))
        });
        Some(self.add(layer, node, &[]))
    }
}

/// Whether a layer only covers what lies below it, more or less, without looking at it.
fn mixes_alone(layer: &Layer) -> bool {
    let blend = match &layer.kind {
        LayerKind::Imagery(imagery) if imagery.seam_blend_m > 0.0 => return false,
        LayerKind::Imagery(imagery) => imagery.blend,
        LayerKind::Tint(tint) => tint.blend,
        LayerKind::Slope(slope) => slope.blend,
        LayerKind::Contours(contours) => contours.blend,
        LayerKind::Vector(_)
        | LayerKind::Height(_)
        | LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Unknown { .. } => Blend::Normal,
    };
    blend == Blend::Normal
}

fn blend_mode(blend: Blend) -> BlendMode {
    match blend {
        Blend::Normal => BlendMode::Normal,
        Blend::Multiply => BlendMode::Multiply,
        Blend::Add => BlendMode::Add,
        Blend::Screen => BlendMode::Screen,
        Blend::Overlay => BlendMode::Overlay,
        Blend::Subtract => BlendMode::Subtract,
        Blend::Difference => BlendMode::Difference,
        Blend::Exclusion => BlendMode::Exclusion,
        Blend::Darken => BlendMode::Darken,
        Blend::Lighten => BlendMode::Lighten,
        Blend::ColourDodge => BlendMode::ColourDodge,
        Blend::ColourBurn => BlendMode::ColourBurn,
        Blend::HardLight => BlendMode::HardLight,
        Blend::SoftLight => BlendMode::SoftLight,
        Blend::Hue => BlendMode::Hue,
        Blend::Saturation => BlendMode::Saturation,
        Blend::Colour => BlendMode::Colour,
        Blend::Luminosity => BlendMode::Luminosity,
    }
}
