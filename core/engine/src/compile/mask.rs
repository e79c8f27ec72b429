//! Where a layer shows: masks by height, slope, place and vector features.

use std::sync::Arc;

use relievo_graph::nodes::{
    AlphaMask, Constant, DiscMask, MaskProduct, PolygonMask, RangeMask, SlopeAngle, Vector,
};
use relievo_graph::{ImageNode, NodeIndex};
use relievo_planet::MapPoint;
use relievo_project::{Layer, LayerId, LayerKind, LensShape, Mask, Project};
use relievo_raster::SampleType;
use relievo_vector::{Drawing, Style};

use super::{Compiler, Ground};
use crate::sources::SourceState;

impl Compiler<'_> {
    /// Why a mask leaves nothing of its layer, whatever the ground, if so.
    pub(super) fn hides_all(&self, mask: &Mask, project: &Project) -> Option<&'static str> {
        if mask.invert && mask.is_everywhere() {
            return Some("masked everywhere");
        }
        let kind = &project.layer(mask.vector.as_ref()?)?.kind;
        if !matches!(kind, LayerKind::Vector(_)) {
            return None;
        }
        match self.sources.state(kind, self.folder) {
            Some(SourceState::Features(_)) => None,
            Some(SourceState::Opening(_)) => Some("the file of its mask is being opened"),
            // The vector layer says what is wrong with its file.
            Some(SourceState::Open(_) | SourceState::Failed(_)) | None => {
                Some("the file of its mask cannot be opened")
            }
        }
    }

    /// Weights of where a layer shows, `None` for everywhere; complains of a vector layer that is none.
    pub(super) fn mask(
        &mut self,
        layer: &Layer,
        project: &Project,
        ground: Ground,
    ) -> Option<NodeIndex> {
        let mask = layer.mask.as_ref()?;
        let mut weights = Vec::new();
        if let Some(range) = &mask.heights {
            let node = RangeMask::new(range.from, range.to, range.fade);
            weights.push(self.add(layer, Arc::new(node), &[ground.height]));
        }
        if let Some(range) = &mask.slopes {
            let angle = match ground.normal {
                Some(normal) => self.add(layer, Arc::new(SlopeAngle), &[normal]),
                None => self.add(layer, Arc::new(Constant::height(0.0)), &[]),
            };
            let node = RangeMask::new(range.from, range.to, range.fade);
            weights.push(self.add(layer, Arc::new(node), &[angle]));
        }
        if let Some(lens) = &mask.lens {
            let centre = MapPoint::from_degrees(lens.lon_deg, lens.lat_deg);
            let planet = &self.planet;
            let node: Arc<dyn ImageNode> = match &lens.shape {
                LensShape::Circle { radius_m } => {
                    Arc::new(DiscMask::new(planet, centre, *radius_m, lens.fade_m))
                }
                LensShape::Polygon { corners_m } => {
                    Arc::new(PolygonMask::new(planet, centre, corners_m, lens.fade_m))
                }
            };
            weights.push(self.add(layer, node, &[]));
        }
        if let Some(id) = &mask.vector {
            weights.extend(self.areas(layer, project, id, "for the mask"));
        }
        match (weights.as_slice(), mask.invert) {
            ([], _) => None,
            ([only], false) => Some(*only),
            (all, inverted) => {
                let node = MaskProduct::new(all.len(), inverted);
                Some(self.add(layer, Arc::new(node), all))
            }
        }
    }

    /// What the areas of a vector layer cover, for something of a layer; `None` where there is no such
    /// vector layer, or its file is not open.
    pub(super) fn areas(
        &mut self,
        layer: &Layer,
        project: &Project,
        id: &LayerId,
        purpose: &'static str,
    ) -> Option<NodeIndex> {
        let named = match project.named_areas(id, purpose) {
            Ok(named) => named,
            Err(wrong) => {
                self.complain(layer, wrong.to_string());
                return None;
            }
        };
        let Some(SourceState::Features(open)) = self.sources.state(&named.kind, self.folder) else {
            return None;
        };
        let features = Arc::clone(&open.features);
        let planet = self.planet;
        let name = format!("areas {} {planet:?}", Arc::as_ptr(&features).addr());
        let node = self.nodes.get(&mut self.used, name, || {
            let filled = Style {
                fill: Some([1.0; 4]),
                ..Style::default()
            };
            Arc::new(Vector::new(Arc::new(Drawing::new(
                features, filled, planet,
            ))))
        });
        let drawn = self.add(layer, node, &[]);
        // Drawing is dear, and no slider changes it.
        self.builder.cut(drawn, SampleType::Rgba8);
        Some(self.add(layer, Arc::new(AlphaMask), &[drawn]))
    }

    /// Adds weights to an overlay's inputs: its base, its top and perhaps a mask.
    pub(super) fn also_masked(
        &mut self,
        layer: &Layer,
        inputs: &mut Vec<NodeIndex>,
        weights: NodeIndex,
    ) {
        match inputs.get_mut(2) {
            Some(mask) => {
                let node = MaskProduct::new(2, false);
                *mask = self.add(layer, Arc::new(node), &[*mask, weights]);
            }
            None => inputs.push(weights),
        }
    }
}
