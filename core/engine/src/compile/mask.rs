//! Where a layer shows: masks by height, slope, place and vector features.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{
    AlphaMask, Constant, DiscMask, MaskProduct, RangeMask, SlopeAngle, Vector,
};
use relievo_planet::MapPoint;
use relievo_project::{Layer, LayerId, LayerKind, Mask, Project};
use relievo_raster::SampleType;
use relievo_vector::{Drawing, Style};

use super::{Compiler, Ground};
use crate::sources::SourceState;

/// Where a layer shows.
pub(super) enum Shows {
    Everywhere,
    /// With these weights.
    By(NodeIndex),
    /// Nowhere, and why.
    Nowhere(&'static str),
}

impl Compiler<'_> {
    /// Where a layer shows; complains of what its mask asks for and cannot have.
    pub(super) fn shows(&mut self, layer: &Layer, project: &Project, ground: Ground) -> Shows {
        let Some(mask) = &layer.mask else {
            return Shows::Everywhere;
        };
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
        if let Some(circle) = &mask.circle {
            let centre = MapPoint::from_degrees(circle.lon_deg, circle.lat_deg);
            let node = DiscMask::new(&self.planet, centre, circle.radius_m, circle.fade_m);
            weights.push(self.add(layer, Arc::new(node), &[]));
        }
        if let Some(id) = &mask.vector {
            match self.areas(layer, project, id) {
                Ok(Some(node)) => weights.push(node),
                Ok(None) => {}
                Err(reason) => return Shows::Nowhere(reason),
            }
        }
        match (weights.as_slice(), mask.invert) {
            ([], false) => Shows::Everywhere,
            ([], true) => Shows::Nowhere("masked everywhere"),
            ([only], false) => Shows::By(*only),
            (all, inverted) => {
                let node = MaskProduct::new(all.len(), inverted);
                Shows::By(self.add(layer, Arc::new(node), all))
            }
        }
    }

    /// What the areas of a vector layer cover; `None` where there is no such layer.
    fn areas(
        &mut self,
        layer: &Layer,
        project: &Project,
        id: &LayerId,
    ) -> Result<Option<NodeIndex>, &'static str> {
        let found = project.layer(id).map(|other| &other.kind);
        let Some(kind @ LayerKind::Vector(_)) = found else {
            let found = found.map_or("none".to_owned(), |kind| {
                format!("one of kind {}", kind.name())
            });
            let expected = format!("expected a vector layer {:?} for the mask", id.0.as_str());
            self.complain(layer, format!("{expected}, found {found}"));
            return Ok(None);
        };
        let features = match self.sources.state(kind, self.folder) {
            Some(SourceState::Features(open)) => Arc::clone(&open.features),
            Some(SourceState::Opening(_)) => return Err("the file of its mask is being opened"),
            Some(SourceState::Open(_) | SourceState::Failed(_)) | None => {
                // The vector layer says what is wrong with its file.
                return Err("the file of its mask cannot be opened");
            }
        };
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
        Ok(Some(self.add(layer, Arc::new(AlphaMask), &[drawn])))
    }

    /// Inputs of an overlay that already has its base, its top and perhaps a mask, with another mask.
    pub(super) fn also_masked(
        &mut self,
        layer: &Layer,
        mut inputs: Vec<NodeIndex>,
        shows: &Shows,
    ) -> (Vec<NodeIndex>, bool) {
        if let Shows::By(weights) = shows {
            match inputs.get_mut(2) {
                Some(mask) => {
                    let node = MaskProduct::new(2, false);
                    let both = [*mask, *weights];
                    *mask = self.builder.add(Arc::new(node), &both);
                    self.layers.insert(*mask, layer.id.clone());
                }
                None => inputs.push(*weights),
            }
        }
        let masked = inputs.len() == 3;
        (inputs, masked)
    }
}

/// Whether a mask leaves nothing of a layer, whatever the ground.
pub(super) fn hides_all(mask: &Mask) -> bool {
    mask.invert && mask.is_everywhere()
}
