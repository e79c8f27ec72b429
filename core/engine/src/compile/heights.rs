//! The shown ground: height layers from the bottom up, planning elements over them, and normals.

use std::sync::Arc;

use relievo_graph::nodes::{AddHeights, Constant, Noise, NoiseParams, Normals, OverlayHeights};
use relievo_graph::{ImageNode, NodeIndex};
use relievo_project::{Layer, LayerKind, NoiseMode, Project};
use relievo_raster::SampleType;

use super::{Compiler, level_of_step};
use crate::message::{Message, Severity};
use crate::scene::{Detail, Elements};

impl Compiler<'_> {
    pub(super) fn heights(&mut self, project: &Project) -> NodeIndex {
        // Where no source has a height the ground is at the datum, so that there is no hole in it.
        let datum = self.same("datum".into(), || Constant::height(0.0));
        let mut below = self.builder.add(datum, &[]);
        for (layer, detail) in self.height_layers(project) {
            if let Some(over) = self.height_layer(layer, detail, below) {
                below = over;
            }
        }
        self.builder.cut(below, SampleType::Height);
        below
    }

    /// What the planning elements of the shown scenario make of the ground.
    pub(super) fn elements(
        &mut self,
        project: &Project,
        ground: NodeIndex,
    ) -> (NodeIndex, Elements) {
        let elements = project.elements_in(project.scenario.as_ref());
        let plan = self.nodes.elements.plan(self.planet, &elements);
        for (element, text) in &plan.warnings {
            self.problems.push(Message {
                severity: Severity::Warning,
                layer: None,
                element: Some(element.clone()),
                text: text.clone(),
            });
        }
        let Some(node) = plan.node.clone() else {
            return (ground, Elements::default());
        };
        let planned = self
            .builder
            .add(Arc::clone(&node) as Arc<dyn ImageNode>, &[ground]);
        self.builder.cut(planned, SampleType::Height);
        if let Some(detail_m) = plan.detail_m() {
            self.details.push(Detail {
                node: planned,
                finest: level_of_step(detail_m / self.planet.radius_m),
                within: Some(Arc::clone(&node)),
                synthesised_below_m: None,
            });
        }
        let elements = Elements {
            node: Some(node),
            all: plan.placed.into_iter().map(|(e, _)| e).collect(),
        };
        (planned, elements)
    }

    fn height_layer(
        &mut self,
        layer: &Layer,
        detail: Option<&Layer>,
        below: NodeIndex,
    ) -> Option<NodeIndex> {
        let opacity = layer.opacity as f32;
        match &layer.kind {
            LayerKind::Height(height) => {
                let file = self.open(layer)?;
                let step_rad = self.warp(layer, &file, &height.source)?.finest_step_rad();
                let finest = level_of_step(step_rad);
                let (scale, offset) = (height.vertical_scale, height.offset_m);
                let top = self.file_node(layer, &file, &height.source, (scale, offset))?;
                self.builder.cut(top, SampleType::Height);
                self.details.push(Detail::everywhere(top, finest));
                let top = self.continued(detail, top, step_rad * self.planet.radius_m);
                let inputs = self.with_fade(layer, &file, &height.source, below, top)?;
                let masked = inputs.len() == 3;
                let over = self.over_heights(opacity, masked);
                Some(self.add(layer, over, &inputs))
            }
            LayerKind::Noise(noise) => {
                let params = &noise.noise;
                // Noise that adds is scaled by its opacity, so that half of it is half as high.
                let share = if params.mode == NoiseMode::Add {
                    layer.opacity
                } else {
                    1.0
                };
                let planet = self.planet;
                let noise = NoiseParams {
                    seed: u64::from(params.seed),
                    amplitude_m: params.amplitude_m * share,
                    wavelength_m: params.wavelength_m,
                    octaves: params.octaves,
                    lacunarity: params.lacunarity,
                    gain: params.gain,
                    ridged: params.ridged,
                };
                let name = format!("{noise:?} {planet:?}");
                let node = self.same(name, || Noise::new(planet, &noise));
                let mut top = self.add(layer, node, &[]);
                self.builder.cut(top, SampleType::Height);
                let shortest_m = params.wavelength_m
                    / params
                        .lacunarity
                        .powi(params.octaves.saturating_sub(1) as i32);
                let step_rad = shortest_m / (4.0 * self.planet.radius_m);
                self.details
                    .push(Detail::everywhere(top, level_of_step(step_rad)));
                if params.offset_m != 0.0 {
                    let offset_m = (params.offset_m * share) as f32;
                    let offset =
                        self.same(format!("offset {offset_m}"), || Constant::height(offset_m));
                    let offset = self.add(layer, offset, &[]);
                    let sum = self.same("add heights".into(), || AddHeights);
                    top = self.add(layer, sum, &[top, offset]);
                }
                let over = match params.mode {
                    NoiseMode::Replace => self.over_heights(opacity, false),
                    NoiseMode::Add => self.same("add heights".into(), || AddHeights),
                };
                Some(self.add(layer, over, &[below, top]))
            }
            LayerKind::Detail(_)
            | LayerKind::Imagery(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. } => None,
        }
    }

    fn over_heights(&mut self, opacity: f32, masked: bool) -> Arc<dyn ImageNode> {
        let name = format!("over heights {opacity} {masked}");
        self.same(name, || OverlayHeights::new(opacity, masked))
    }

    /// Normals of the ground as it is; front-ends steepen them with the heights they draw.
    pub(super) fn normals(&mut self, height: NodeIndex) -> Option<NodeIndex> {
        if self.details.is_empty() {
            return None;
        }
        let planet = self.planet;
        let normals = self.same(format!("normals {planet:?}"), || Normals::new(planet, 1.0));
        let node = self.builder.add(normals, &[height]);
        self.builder.cut(node, SampleType::Normal);
        Some(node)
    }
}
