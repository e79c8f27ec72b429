//! Colours of a raster file: from the file to what is laid over the layers below.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{
    AlphaMask, BlendMode, ColourDetail, ColourDetailParams, ColourDetailSource, Constant,
    ExampleAt, Overlay, OverlayHeights, RangeMask, SeamBlend,
};
use relievo_project::{
    Blend, ColourDetail as ProjectDetail, DetailBy, ImageryLayer, Layer, LayerId, LayerKind,
    Project,
};
use relievo_raster::{RasterFile, SampleType};

use super::{Compiler, Ground, ToEdge, level_of_step};
use crate::scene::Detail;
use crate::sources::SourceState;

/// Colour noise goes on until samples are so many times as fine as the file's.
const NOISE_FINER: f64 = 64.0;

/// A finer picture of such ground.
struct Example {
    /// Its adjusted colours.
    colours: NodeIndex,
    at: ExampleAt,
    finest_rad: f64,
}

/// What continues the colours of a file.
struct MadeDetail {
    /// Says all that decides the node.
    name: String,
    node: ColourDetail,
    /// Where it does.
    areas: Option<NodeIndex>,
    examples: Vec<NodeIndex>,
    /// Spacing of the finest samples that it is worth.
    as_fine_rad: f64,
}

impl Compiler<'_> {
    /// A file's colours, continued, adjusted, its holes filled.
    pub(super) fn imagery(
        &mut self,
        layer: &Layer,
        imagery: &ImageryLayer,
        project: &Project,
    ) -> Option<NodeIndex> {
        let file = self.open(layer)?;
        let finest_rad = self.warp(layer, &file, &imagery.source)?.finest_step_rad();
        let source = self.file_colours(layer, imagery, &file)?;
        let finest = level_of_step(finest_rad);
        self.details.push(Detail::everywhere(source, finest));
        // Before the adjustment, so that no slider makes detail again.
        let detailed = imagery.detail.iter().fold(source, |below, detail| {
            let made = self.colour_detail(layer, detail, project, (below, finest_rad));
            if let Some(made) = made {
                self.builder.cut(made, depth(&file));
            }
            made.unwrap_or(below)
        });
        let top = self.adjusted(layer, &imagery.adjust, detailed);
        self.layers.adjusted.insert(layer.id.clone(), top);
        self.with_holes_filled(layer, imagery, &file, top)
    }

    /// The colours as the file has them.
    fn file_colours(
        &mut self,
        layer: &Layer,
        imagery: &ImageryLayer,
        file: &Arc<dyn RasterFile>,
    ) -> Option<NodeIndex> {
        let source = self.file_node(layer, file, &imagery.source, (1.0, 0.0))?;
        self.builder.cut(source, depth(file));
        Some(source)
    }

    /// Colours of a file with samples so far apart, continued; `None` where nothing is added.
    fn colour_detail(
        &mut self,
        layer: &Layer,
        detail: &ProjectDetail,
        project: &Project,
        (below, finest_rad): (NodeIndex, f64),
    ) -> Option<NodeIndex> {
        let made = self.continuing(layer, detail, project, finest_rad)?;
        let below_m = 2.0 * made.node.synthesised_below_m()?;
        // Kept with what it found out about its examples.
        let node = self
            .nodes
            .get(&mut self.used, made.name, || Arc::new(made.node));
        let inputs: Vec<NodeIndex> = core::iter::once(below)
            .chain(made.areas)
            .chain(made.examples)
            .collect();
        let index = self.add(layer, node, &inputs);
        self.details.push(Detail {
            synthesised_below_m: Some(below_m),
            ..Detail::everywhere(index, level_of_step(made.as_fine_rad))
        });
        Some(index)
    }

    /// Where the colours of imagery are synthesised, from 0 to 1, as far as the grids of a level go; `None`
    /// if no layer adds detail.
    pub(super) fn synthesised_colours(
        &mut self,
        project: &Project,
        ground: Ground,
    ) -> Option<NodeIndex> {
        let mut any = false;
        let mut amount = self.builder.add(Arc::new(Constant::height(0.0)), &[]);
        for layer in &project.layers {
            let LayerKind::Imagery(imagery) = &layer.kind else {
                continue;
            };
            if !self.takes_part(project, layer) {
                continue;
            }
            let Some(file) = self.open(layer) else {
                continue;
            };
            let Some(warp) = self.warp(layer, &file, &imagery.source) else {
                continue;
            };
            let Some(source) = self.file_colours(layer, imagery, &file) else {
                continue;
            };
            let finest_rad = warp.finest_step_rad();
            // What is not continued covers what is.
            let mut own = if imagery.blend == Blend::Normal {
                self.builder.add(Arc::new(Constant::height(0.0)), &[])
            } else {
                // Seen through.
                amount
            };
            for detail in &imagery.detail {
                let made = self.continuing(layer, detail, project, finest_rad);
                let made = made.filter(|made| made.node.synthesised_below_m().is_some());
                let Some(made) = made else { continue };
                any = true;
                let adds = self.builder.add(Arc::new(made.node.amount()), &[]);
                let over = OverlayHeights::new(1.0, made.areas.is_some());
                let inputs: Vec<NodeIndex> = [own, adds].into_iter().chain(made.areas).collect();
                own = self.builder.add(Arc::new(over), &inputs);
            }
            let alpha = self.builder.add(Arc::new(AlphaMask), &[source]);
            let inputs = self.with_fade(layer, &file, &imagery.source, amount, own);
            let Some(mut inputs) = inputs else { continue };
            self.also_masked(layer, &mut inputs, alpha);
            if let Some(weights) = self.mask(layer, project, ground) {
                self.also_masked(layer, &mut inputs, weights);
            }
            let over = OverlayHeights::new(layer.opacity as f32, true);
            amount = self.builder.add(Arc::new(over), &inputs);
        }
        any.then_some(amount)
    }

    /// The node that continues colours and what it reads besides; `None` where it would add nothing.
    fn continuing(
        &mut self,
        layer: &Layer,
        detail: &ProjectDetail,
        project: &Project,
        finest_rad: f64,
    ) -> Option<MadeDetail> {
        if detail.strength <= 0.0 {
            return None;
        }
        let areas = match &detail.areas {
            Some(id) => Some(self.areas(layer, project, id, "for the detail")?),
            None => None,
        };
        let (by, tolerance, examples) = match &detail.by {
            DetailBy::Noise => (ColourDetailSource::Noise, DetailBy::TOLERANCE, vec![]),
            DetailBy::Examples { layers, tolerance } => {
                let found = layers
                    .iter()
                    .filter_map(|id| self.example(layer, id, project))
                    .collect();
                (ColourDetailSource::Examples, *tolerance, found)
            }
        };
        let params = ColourDetailParams {
            by,
            seed: u64::from(detail.seed),
            coarse_spacing_m: finest_rad * self.planet.radius_m,
            strength: detail.strength,
            tolerance,
        };
        let as_fine_rad = match by {
            ColourDetailSource::Noise => finest_rad / NOISE_FINER,
            ColourDetailSource::Examples => {
                let each = examples.iter().map(|example| example.finest_rad);
                each.fold(finest_rad, f64::min)
            }
        };
        let colours = examples.iter().map(|example| example.colours).collect();
        let read: Vec<ExampleAt> = examples.into_iter().map(|example| example.at).collect();
        let (planet, masked) = (self.planet, areas.is_some());
        let name = format!("colour detail {params:?} {read:?} {masked} {planet:?}");
        Some(MadeDetail {
            name,
            node: ColourDetail::new(planet, &params, read, masked),
            areas,
            examples: colours,
            as_fine_rad,
        })
    }

    /// The middle of another layer's file, adjusted as that layer is; complains of what is no imagery.
    fn example(&mut self, layer: &Layer, id: &LayerId, project: &Project) -> Option<Example> {
        let (named, imagery) = match project.named_example(&layer.id, id) {
            Ok(named) => named,
            Err(wrong) => {
                self.complain(layer, wrong.to_string());
                return None;
            }
        };
        // That layer says itself when its file cannot be opened.
        let Some(SourceState::Open(file)) = self.sources.state(&named.kind, self.folder) else {
            return None;
        };
        let warp = self.warp(layer, &file, &imagery.source)?;
        let finest_rad = warp.finest_step_rad();
        let spacing_m = finest_rad * self.planet.radius_m;
        let (centre, size_m) = warp.middle()?;
        let most = size_m.map(|side_m| (side_m / spacing_m) as u32);
        let at = ExampleAt::around(&self.planet, centre, spacing_m, most);
        // Of the layer that is continued: nothing of the other one is shown here.
        let source = self.file_colours(layer, imagery, &file)?;
        let colours = self.adjusted(layer, &imagery.adjust, source);
        Some(Example {
            colours,
            at,
            finest_rad,
        })
    }

    /// Colours over what the layer shows where its file has no data.
    fn with_holes_filled(
        &mut self,
        layer: &Layer,
        imagery: &ImageryLayer,
        file: &Arc<dyn RasterFile>,
        top: NodeIndex,
    ) -> Option<NodeIndex> {
        let Some(missing) = imagery.missing else {
            return Some(top);
        };
        let [r, g, b] = missing.map(|v| f32::from(v) / 255.0);
        let none = self.add(layer, Arc::new(Constant::colour([0.0; 4])), &[]);
        let colour = self.add(layer, Arc::new(Constant::colour([r, g, b, 1.0])), &[]);
        let distances = self.edge_distances(layer, file, &imagery.source, ToEdge::Outline(1.0))?;
        let inside = RangeMask::new(f64::from(f32::MIN_POSITIVE), f64::NAN, 0.0);
        let outline = self.add(layer, Arc::new(inside), &[distances]);
        let fill = Overlay::new(BlendMode::Normal, 1.0, true);
        let filled = self.add(layer, Arc::new(fill), &[none, colour, outline]);
        let over = Overlay::new(BlendMode::Normal, 1.0, false);
        Some(self.add(layer, Arc::new(over), &[filled, top]))
    }

    /// A layer's colours, bent to those below along the edge of its data.
    pub(super) fn with_seams_blended(
        &mut self,
        layer: &Layer,
        below: Option<NodeIndex>,
        top: NodeIndex,
        mask: Option<NodeIndex>,
    ) -> NodeIndex {
        let reach_m = match &layer.kind {
            LayerKind::Imagery(imagery) => imagery.seam_blend_m,
            LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. } => 0.0,
        };
        // Over nothing there is no seam.
        let Some(below) = below.filter(|_| reach_m > 0.0) else {
            return top;
        };
        let node = SeamBlend::new(self.planet, reach_m, mask.is_some());
        let mut inputs = vec![below, top];
        inputs.extend(mask);
        self.add(layer, Arc::new(node), &inputs)
    }
}

/// How exactly a file's colours are stored between nodes.
fn depth(file: &Arc<dyn RasterFile>) -> SampleType {
    if file.info().deep_colour {
        SampleType::Rgba16F
    } else {
        SampleType::Rgba8
    }
}
