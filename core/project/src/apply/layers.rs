//! Layers and their parts, as edits find and change them.

use core::mem;

use super::EditError;
use crate::{
    Adjust, Blend, Edit, Fault, ImageryLayer, Layer, LayerId, LayerKind, Mask, Project, Source,
    VectorLayer,
};

impl Project {
    pub(super) fn add_layer(
        &mut self,
        index: Option<usize>,
        layer: Layer,
    ) -> Result<Edit, EditError> {
        let last = self.layers.len();
        let index = index.unwrap_or(last);
        if self.layer(&layer.id).is_some() {
            return Err(EditError::IdInUse { id: layer.id.0 });
        }
        if last >= crate::stored::range::MOST_LAYERS {
            return Err(EditError::TooManyLayers {
                most: crate::stored::range::MOST_LAYERS,
            });
        }
        if index > last {
            return Err(EditError::Position { last, index });
        }
        let id = layer.id.clone();
        self.layers.insert(index, layer);
        Ok(Edit::RemoveLayer { id })
    }

    pub(super) fn set_bands(
        &mut self,
        id: LayerId,
        bands: Option<Vec<u16>>,
    ) -> Result<Edit, EditError> {
        let layer = self.layer_mut(&id)?;
        let bands = match &mut layer.kind {
            LayerKind::Imagery(imagery) => mem::replace(&mut imagery.bands, bands),
            LayerKind::Height(height) => {
                let band = match bands.as_deref() {
                    None => None,
                    Some([band]) => Some(*band),
                    Some(several) => {
                        return Err(EditError::Invalid(Fault {
                            pointer: "/bands".to_owned(),
                            expected: "one band for a height layer".to_owned(),
                            found: several.len().to_string(),
                        }));
                    }
                };
                mem::replace(&mut height.band, band).map(|band| vec![band])
            }
            LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. } => {
                return Err(wrong_kind(layer, "bands", "an imagery or height layer"));
            }
        };
        Ok(Edit::SetBands { id, bands })
    }

    pub(super) fn index(&self, id: &LayerId) -> Result<usize, EditError> {
        self.layer_index(id)
            .ok_or_else(|| EditError::NoSuchLayer { id: id.0.clone() })
    }

    pub(super) fn layer_mut(&mut self, id: &LayerId) -> Result<&mut Layer, EditError> {
        let index = self.index(id)?;
        Ok(&mut self.layers[index])
    }

    pub(super) fn source_mut(
        &mut self,
        id: &LayerId,
        what: &'static str,
    ) -> Result<&mut Source, EditError> {
        let layer = self.layer_mut(id)?;
        match &mut layer.kind {
            LayerKind::Imagery(imagery) => Ok(&mut imagery.source),
            LayerKind::Height(height) => Ok(&mut height.source),
            kind @ (LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. }) => Err(EditError::WrongKind {
                id: id.0.clone(),
                what,
                expected: "an imagery or height layer",
                kind: kind.name().to_owned(),
            }),
        }
    }

    pub(super) fn blend_mut(&mut self, id: &LayerId) -> Result<&mut Blend, EditError> {
        let layer = self.layer_mut(id)?;
        match &mut layer.kind {
            LayerKind::Imagery(imagery) => Ok(&mut imagery.blend),
            LayerKind::Tint(tint) => Ok(&mut tint.blend),
            LayerKind::Slope(slope) => Ok(&mut slope.blend),
            LayerKind::Contours(contours) => Ok(&mut contours.blend),
            kind @ (LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. }) => Err(EditError::WrongKind {
                id: id.0.clone(),
                what: "blend mode",
                expected: "an imagery, tint, slope or contours layer",
                kind: kind.name().to_owned(),
            }),
        }
    }

    pub(super) fn mask_mut(&mut self, id: &LayerId) -> Result<&mut Option<Mask>, EditError> {
        let layer = self.layer_mut(id)?;
        if layer.kind.may_be_masked() {
            Ok(&mut layer.mask)
        } else {
            Err(EditError::WrongKind {
                id: id.0.clone(),
                what: "mask",
                expected: "an imagery, tint, slope, contours or vector layer",
                kind: layer.kind.name().to_owned(),
            })
        }
    }

    pub(super) fn adjust_mut(&mut self, id: &LayerId) -> Result<&mut Adjust, EditError> {
        let layer = self.layer_mut(id)?;
        match &mut layer.kind {
            LayerKind::Imagery(imagery) => Ok(&mut imagery.adjust),
            LayerKind::Tint(tint) => Ok(&mut tint.adjust),
            kind @ (LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. }) => Err(EditError::WrongKind {
                id: id.0.clone(),
                what: "adjustment",
                expected: "an imagery or tint layer",
                kind: kind.name().to_owned(),
            }),
        }
    }

    /// Sets a value of an imagery layer; what it was.
    pub(super) fn set_imagery<T>(
        &mut self,
        id: &LayerId,
        what: &'static str,
        slot: impl FnOnce(&mut ImageryLayer) -> &mut T,
        value: T,
    ) -> Result<T, EditError> {
        let layer = self.layer_mut(id)?;
        if let LayerKind::Imagery(imagery) = &mut layer.kind {
            return Ok(mem::replace(slot(imagery), value));
        }
        Err(wrong_kind(layer, what, "an imagery layer"))
    }

    pub(super) fn vector_mut(
        &mut self,
        id: &LayerId,
        what: &'static str,
    ) -> Result<&mut VectorLayer, EditError> {
        let layer = self.layer_mut(id)?;
        if !matches!(layer.kind, LayerKind::Vector(_)) {
            return Err(wrong_kind(layer, what, "a vector layer"));
        }
        let LayerKind::Vector(vector) = &mut layer.kind else {
            unreachable!("a vector layer")
        };
        Ok(vector)
    }
}

pub(super) fn wrong_kind(layer: &Layer, what: &'static str, expected: &'static str) -> EditError {
    EditError::WrongKind {
        id: layer.id.0.clone(),
        what,
        expected,
        kind: layer.kind.name().to_owned(),
    }
}
