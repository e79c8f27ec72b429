//! Between stored and runtime edits.

use super::{
    AddLayer, Batch, MoveLayer, RemoveLayer, SetAdjust, SetBands, SetBlend, SetCamera, SetEdgeFade,
    SetExaggeration, SetGeoreference, SetHeightScale, SetLocked, SetName, SetNodata, SetNoise,
    SetOpacity, SetPath, SetPlanet, SetQuality, SetResampling, SetStretch, SetSun, SetTiles,
    SetTint, SetVisible, StoredEdit,
};
use crate::stored::convert::{
    Twin, bands, layer_id, layer_name, source_path, stored_tint, tint, unknown_is_unknown,
};
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::stretch::StoredStretch;
use crate::stored::value::With;
use crate::{
    Adjust, CameraSettings, Edit, Extra, Georeference, Layer, LayerId, Noise, PlanetSettings,
    Quality, Stretch, Sun,
};

impl Twin for Edit {
    type Stored = StoredEdit;

    #[expect(clippy::too_many_lines, reason = "one arm for each edit")]
    fn from_stored(stored: StoredEdit, at: &At<'_>) -> Result<Self, Fault> {
        let id = |id: String| layer_id(id, &At::Member(at, "id"));
        Ok(match stored {
            StoredEdit::AddLayer(e) => {
                let layer = Layer::from_stored(e.layer, &At::Member(at, "layer"))?;
                Self::AddLayer {
                    index: e.index.map(|i| i as usize),
                    layer: Box::new(layer),
                }
            }
            StoredEdit::RemoveLayer(e) => Self::RemoveLayer { id: id(e.id)? },
            StoredEdit::MoveLayer(e) => Self::MoveLayer {
                id: id(e.id)?,
                index: e.index as usize,
            },
            StoredEdit::SetName(e) => Self::SetName {
                id: id(e.id)?,
                name: layer_name(e.name, &At::Member(at, "name"))?,
            },
            StoredEdit::SetVisible(e) => Self::SetVisible {
                id: id(e.id)?,
                visible: e.visible,
            },
            StoredEdit::SetOpacity(e) => Self::SetOpacity {
                id: id(e.id)?,
                opacity: e.opacity,
            },
            StoredEdit::SetLocked(e) => Self::SetLocked {
                id: id(e.id)?,
                locked: e.locked,
            },
            StoredEdit::SetBlend(e) => Self::SetBlend {
                id: id(e.id)?,
                blend: e.blend.into(),
            },
            StoredEdit::SetAdjust(e) => {
                let adjust = Adjust::from_stored(e.adjust, &At::Member(at, "adjust"))?;
                Self::SetAdjust {
                    id: id(e.id)?,
                    adjust,
                }
            }
            StoredEdit::SetResampling(e) => Self::SetResampling {
                id: id(e.id)?,
                resampling: e.resampling.into(),
            },
            StoredEdit::SetEdgeFade(e) => Self::SetEdgeFade {
                id: id(e.id)?,
                edge_fade_m: e.edge_fade_m,
            },
            StoredEdit::SetPath(e) => Self::SetPath {
                id: id(e.id)?,
                path: source_path(e.path, &At::Member(at, "path"))?,
            },
            StoredEdit::SetGeoreference(e) => {
                let place = At::Member(at, "georeference");
                let georeference = e
                    .georeference
                    .map(|g| Georeference::from_stored(g, &place))
                    .transpose()?;
                Self::SetGeoreference {
                    id: id(e.id)?,
                    georeference,
                }
            }
            StoredEdit::SetNodata(e) => Self::SetNodata {
                id: id(e.id)?,
                nodata: e.nodata,
            },
            StoredEdit::SetTiles(e) => Self::SetTiles {
                id: id(e.id)?,
                encoding: e.encoding.map(Into::into),
                tile_rows: e.tile_rows.map(Into::into),
            },
            StoredEdit::SetStretch(e) => Self::SetStretch {
                id: id(e.id)?,
                stretch: e.stretch.map_or(Stretch::Auto, |s| s.0),
            },
            StoredEdit::SetBands(e) => {
                let place = At::Member(at, "bands");
                let bands = e.bands.map(|given| bands(&given, &place)).transpose()?;
                Self::SetBands {
                    id: id(e.id)?,
                    bands,
                }
            }
            StoredEdit::SetHeightScale(e) => Self::SetHeightScale {
                id: id(e.id)?,
                vertical_scale: e.vertical_scale,
                offset_m: e.offset_m,
            },
            StoredEdit::SetNoise(e) => {
                let place = At::Member(at, "noise");
                if let Some(name) = e.noise.extra.keys().next() {
                    return Err(At::Member(&place, name).fault("no such member of noise", "one"));
                }
                Self::SetNoise {
                    id: id(e.id)?,
                    noise: Noise::from_stored(e.noise.fields, &place)?,
                }
            }
            StoredEdit::SetTint(e) => Self::SetTint {
                id: id(e.id)?,
                tint: tint(e.stops, e.interpolation, at)?,
            },
            StoredEdit::SetPlanet(e) => Self::SetPlanet {
                planet: PlanetSettings::from_stored(e.planet, &At::Member(at, "planet"))?,
            },
            StoredEdit::SetExaggeration(e) => Self::SetExaggeration {
                vertical_exaggeration: e.vertical_exaggeration,
            },
            StoredEdit::SetCamera(e) => Self::SetCamera {
                camera: CameraSettings::from_stored(e.camera, &At::Member(at, "camera"))?,
            },
            StoredEdit::SetSun(e) => Self::SetSun {
                sun: Sun::from_stored(e.sun, &At::Member(at, "sun"))?,
            },
            StoredEdit::SetQuality(e) => Self::SetQuality {
                quality: Quality::from_stored(e.quality, &At::Member(at, "quality"))?,
            },
            StoredEdit::Batch(e) => {
                let place = At::Member(at, "edits");
                if e.edits.len() > range::MOST_EDITS {
                    let most = format!("at most {} edits", range::MOST_EDITS);
                    return Err(place.fault(most, e.edits.len().to_string()));
                }
                let edits = e.edits.into_iter().enumerate();
                let edits = edits.map(|(i, edit)| Self::from_stored(edit, &At::Element(&place, i)));
                Self::Batch {
                    label: e.label.unwrap_or_default(),
                    edits: edits.collect::<Result<_, _>>()?,
                }
            }
        })
    }

    #[expect(clippy::too_many_lines, reason = "one arm for each edit")]
    fn to_stored(&self) -> StoredEdit {
        let text = |id: &LayerId| id.0.clone();
        match self {
            Self::AddLayer { index, layer } => StoredEdit::AddLayer(AddLayer {
                index: index.map(position),
                layer: layer.to_stored(),
            }),
            Self::RemoveLayer { id } => StoredEdit::RemoveLayer(RemoveLayer { id: text(id) }),
            Self::MoveLayer { id, index } => StoredEdit::MoveLayer(MoveLayer {
                id: text(id),
                index: position(*index),
            }),
            Self::SetName { id, name } => StoredEdit::SetName(SetName {
                id: text(id),
                name: name.clone(),
            }),
            Self::SetVisible { id, visible } => StoredEdit::SetVisible(SetVisible {
                id: text(id),
                visible: *visible,
            }),
            Self::SetOpacity { id, opacity } => StoredEdit::SetOpacity(SetOpacity {
                id: text(id),
                opacity: *opacity,
            }),
            Self::SetLocked { id, locked } => StoredEdit::SetLocked(SetLocked {
                id: text(id),
                locked: *locked,
            }),
            Self::SetBlend { id, blend } => StoredEdit::SetBlend(SetBlend {
                id: text(id),
                blend: (*blend).into(),
            }),
            Self::SetAdjust { id, adjust } => StoredEdit::SetAdjust(SetAdjust {
                id: text(id),
                adjust: adjust.to_stored(),
            }),
            Self::SetResampling { id, resampling } => StoredEdit::SetResampling(SetResampling {
                id: text(id),
                resampling: (*resampling).into(),
            }),
            Self::SetEdgeFade { id, edge_fade_m } => StoredEdit::SetEdgeFade(SetEdgeFade {
                id: text(id),
                edge_fade_m: *edge_fade_m,
            }),
            Self::SetPath { id, path } => StoredEdit::SetPath(SetPath {
                id: text(id),
                path: path.clone(),
            }),
            Self::SetGeoreference { id, georeference } => {
                StoredEdit::SetGeoreference(SetGeoreference {
                    id: text(id),
                    georeference: georeference.as_ref().map(Twin::to_stored),
                })
            }
            Self::SetNodata { id, nodata } => StoredEdit::SetNodata(SetNodata {
                id: text(id),
                nodata: *nodata,
            }),
            Self::SetTiles {
                id,
                encoding,
                tile_rows,
            } => StoredEdit::SetTiles(SetTiles {
                id: id.0.clone(),
                encoding: encoding.map(Into::into),
                tile_rows: tile_rows.map(Into::into),
            }),
            Self::SetStretch { id, stretch } => StoredEdit::SetStretch(SetStretch {
                id: text(id),
                stretch: Some(StoredStretch(*stretch)),
            }),
            Self::SetBands { id, bands } => StoredEdit::SetBands(SetBands {
                id: text(id),
                bands: bands
                    .as_ref()
                    .map(|bands| bands.iter().copied().map(u32::from).collect()),
            }),
            Self::SetHeightScale {
                id,
                vertical_scale,
                offset_m,
            } => StoredEdit::SetHeightScale(SetHeightScale {
                id: text(id),
                vertical_scale: *vertical_scale,
                offset_m: *offset_m,
            }),
            Self::SetNoise { id, noise } => StoredEdit::SetNoise(SetNoise {
                id: text(id),
                noise: With {
                    fields: noise.to_stored(),
                    extra: Extra::new(),
                },
            }),
            Self::SetTint { id, tint } => {
                let (stops, interpolation) = stored_tint(tint);
                StoredEdit::SetTint(SetTint {
                    id: text(id),
                    stops,
                    interpolation,
                })
            }
            Self::SetPlanet { planet } => StoredEdit::SetPlanet(SetPlanet {
                planet: planet.to_stored(),
            }),
            Self::SetExaggeration {
                vertical_exaggeration,
            } => StoredEdit::SetExaggeration(SetExaggeration {
                vertical_exaggeration: *vertical_exaggeration,
            }),
            Self::SetCamera { camera } => StoredEdit::SetCamera(SetCamera {
                camera: camera.to_stored(),
            }),
            Self::SetSun { sun } => StoredEdit::SetSun(SetSun {
                sun: sun.to_stored(),
            }),
            Self::SetQuality { quality } => StoredEdit::SetQuality(SetQuality {
                quality: quality.to_stored(),
            }),
            Self::Batch { label, edits } => StoredEdit::Batch(Batch {
                label: (!label.is_empty()).then(|| label.clone()),
                edits: edits.iter().map(Twin::to_stored).collect(),
            }),
        }
    }
}

/// A position as it is stored; one beyond 32 bits is out of every project anyway.
fn position(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// Checks an edit's own values (not whether it fits a project) by the reader's rules.
pub(crate) fn check(edit: &Edit) -> Result<(), Fault> {
    use crate::stored::value::Stored as _;
    unknown_layers_are_unknown(edit)?;
    let stored = StoredEdit::read(edit.to_stored().write(), &At::Root)?;
    Edit::from_stored(stored, &At::Root).map(drop)
}

/// An added layer that claims to be unknown but names a known kind could not be read back as it is.
fn unknown_layers_are_unknown(edit: &Edit) -> Result<(), Fault> {
    if let Edit::Batch { edits, .. } = edit {
        edits.iter().try_for_each(unknown_layers_are_unknown)?;
    }
    if let Edit::AddLayer { layer, .. } = edit {
        unknown_is_unknown(layer)?;
    }
    Ok(())
}
