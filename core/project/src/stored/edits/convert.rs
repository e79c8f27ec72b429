//! Between stored and runtime edits.

use std::borrow::Cow;
use std::sync::Arc;

use super::{
    AddBookmark, AddElement, AddLayer, AddScenario, Batch, DuplicateScenario, MergeScenario,
    MoveElement, MoveLayer, RemoveBookmark, RemoveElement, RemoveLayer, RemoveScenario,
    RenameScenario, ReplaceBookmark, ReplaceElement, SetAdjust, SetBands, SetBlend, SetCamera,
    SetChange, SetChanges, SetEdgeFade, SetElementLocked, SetElementName, SetElementStyle,
    SetElementVisible, SetExaggeration, SetGeoreference, SetHeightScale, SetLocked, SetName,
    SetNodata, SetNoise, SetOpacity, SetPath, SetPlanet, SetQuality, SetResampling,
    SetScenarioLayer, SetScenarioParent, SetStretch, SetSun, SetTiles, SetTint, SetVectorSource,
    SetVectorStyle, SetVisible, ShowScenario, StoredEdit,
};
use crate::stored::convert::{
    Twin, bands, changes, check_change, check_element, element_id, filled, layer_id, layer_name,
    position, scenario_id, source_path, stored_tint, tint, unknown_is_unknown,
};
use crate::stored::elements;
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::stretch::StoredStretch;
use crate::stored::value::With;
use crate::{
    Adjust, Bookmark, CameraSettings, Change, ChangeKind, Edit, Element, ElementStyle, Extra,
    Georeference, Layer, LayerId, LayerOverride, Noise, PlanetSettings, Quality, Scenario,
    ScenarioId, Stretch, Sun, VectorStyle, Vertices,
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
            StoredEdit::SetVectorStyle(e) => Self::SetVectorStyle {
                id: id(e.id)?,
                style: Box::new(VectorStyle::from_stored(e.style, &At::Member(at, "style"))?),
            },
            StoredEdit::SetVectorSource(e) => Self::SetVectorSource {
                id: id(e.id)?,
                source_layer: vector_text(e.source_layer, range::LONGEST_NAME, "source_layer", at)?,
                crs: vector_text(e.crs, range::LONGEST_PATH, "crs", at)?,
            },
            StoredEdit::AddElement(e) => Self::AddElement {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                index: e.index.map(|i| i as usize),
                element: element(e.element, at)?,
            },
            StoredEdit::RemoveElement(e) => Self::RemoveElement {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
            },
            StoredEdit::ReplaceElement(e) => Self::ReplaceElement {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                element: element(e.element, at)?,
            },
            StoredEdit::MoveElement(e) => Self::MoveElement {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
                index: e.index as usize,
            },
            StoredEdit::SetElementName(e) => Self::SetElementName {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
                name: layer_name(e.name, &At::Member(at, "name"))?,
            },
            StoredEdit::SetElementVisible(e) => Self::SetElementVisible {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
                visible: e.visible,
            },
            StoredEdit::SetElementLocked(e) => Self::SetElementLocked {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
                locked: e.locked,
            },
            StoredEdit::SetElementStyle(e) => Self::SetElementStyle {
                scenario: of_scenario(e.scenario, "scenario", at)?,
                id: element_id(e.id, &At::Member(at, "id"))?,
                style: ElementStyle::from_stored(e.style, &At::Member(at, "style"))?,
            },
            StoredEdit::SetChange(e) => set_change(e, at)?,
            StoredEdit::SetChanges(e) => Self::SetChanges {
                scenario: scenario_id(e.scenario, &At::Member(at, "scenario"))?,
                changes: changes(Some(e.changes), &At::Member(at, "changes"))?,
            },
            StoredEdit::AddScenario(e) => Self::AddScenario {
                index: e.index.map(|i| i as usize),
                scenario: Box::new(Scenario::from_stored(
                    e.scenario,
                    &At::Member(at, "scenario"),
                )?),
            },
            StoredEdit::RemoveScenario(e) => Self::RemoveScenario {
                id: scenario_id(e.id, &At::Member(at, "id"))?,
            },
            StoredEdit::RenameScenario(e) => Self::RenameScenario {
                id: scenario_id(e.id, &At::Member(at, "id"))?,
                name: layer_name(e.name, &At::Member(at, "name"))?,
            },
            StoredEdit::DuplicateScenario(e) => Self::DuplicateScenario {
                id: scenario_id(e.id, &At::Member(at, "id"))?,
                new_id: scenario_id(e.new_id, &At::Member(at, "new_id"))?,
                name: layer_name(e.name, &At::Member(at, "name"))?,
            },
            StoredEdit::MergeScenario(e) => Self::MergeScenario {
                id: scenario_id(e.id, &At::Member(at, "id"))?,
            },
            StoredEdit::SetScenarioParent(e) => Self::SetScenarioParent {
                id: scenario_id(e.id, &At::Member(at, "id"))?,
                parent: of_scenario(e.parent, "parent", at)?,
            },
            StoredEdit::SetScenarioLayer(e) => set_scenario_layer(e, at)?,
            StoredEdit::ShowScenario(e) => Self::ShowScenario {
                id: of_scenario(e.id, "id", at)?,
            },
            StoredEdit::AddBookmark(e) => Self::AddBookmark {
                index: e.index.map(|i| i as usize),
                bookmark: Bookmark::from_stored(e.bookmark, &At::Member(at, "bookmark"))?,
            },
            StoredEdit::RemoveBookmark(e) => Self::RemoveBookmark {
                index: e.index as usize,
            },
            StoredEdit::ReplaceBookmark(e) => Self::ReplaceBookmark {
                index: e.index as usize,
                bookmark: Bookmark::from_stored(e.bookmark, &At::Member(at, "bookmark"))?,
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
            Self::SetVectorStyle { id, style } => StoredEdit::SetVectorStyle(SetVectorStyle {
                id: text(id),
                style: style.to_stored(),
            }),
            Self::SetVectorSource {
                id,
                source_layer,
                crs,
            } => StoredEdit::SetVectorSource(SetVectorSource {
                id: text(id),
                source_layer: source_layer.clone(),
                crs: crs.clone(),
            }),
            Self::AddElement {
                scenario,
                index,
                element,
            } => StoredEdit::AddElement(AddElement {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                index: index.map(position),
                element: element.to_stored(),
            }),
            Self::RemoveElement { scenario, id } => StoredEdit::RemoveElement(RemoveElement {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                id: id.0.clone(),
            }),
            Self::ReplaceElement { scenario, element } => {
                StoredEdit::ReplaceElement(ReplaceElement {
                    scenario: scenario.as_ref().map(|s| s.0.clone()),
                    element: element.to_stored(),
                })
            }
            Self::MoveElement {
                scenario,
                id,
                index,
            } => StoredEdit::MoveElement(MoveElement {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                id: id.0.clone(),
                index: position(*index),
            }),
            Self::SetElementName { scenario, id, name } => {
                StoredEdit::SetElementName(SetElementName {
                    scenario: scenario.as_ref().map(|s| s.0.clone()),
                    id: id.0.clone(),
                    name: name.clone(),
                })
            }
            Self::SetElementVisible {
                scenario,
                id,
                visible,
            } => StoredEdit::SetElementVisible(SetElementVisible {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                id: id.0.clone(),
                visible: *visible,
            }),
            Self::SetElementLocked {
                scenario,
                id,
                locked,
            } => StoredEdit::SetElementLocked(SetElementLocked {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                id: id.0.clone(),
                locked: *locked,
            }),
            Self::SetElementStyle {
                scenario,
                id,
                style,
            } => StoredEdit::SetElementStyle(SetElementStyle {
                scenario: scenario.as_ref().map(|s| s.0.clone()),
                id: id.0.clone(),
                style: style.to_stored(),
            }),
            Self::SetChange {
                scenario,
                id,
                index,
                change,
            } => StoredEdit::SetChange(SetChange {
                scenario: scenario.0.clone(),
                id: id.0.clone(),
                index: index.map(position),
                change: change.as_ref().map(Twin::to_stored),
            }),
            Self::SetChanges { scenario, changes } => StoredEdit::SetChanges(SetChanges {
                scenario: scenario.0.clone(),
                changes: changes.iter().map(Twin::to_stored).collect(),
            }),
            Self::AddScenario { index, scenario } => StoredEdit::AddScenario(AddScenario {
                index: index.map(position),
                scenario: scenario.to_stored(),
            }),
            Self::RemoveScenario { id } => {
                StoredEdit::RemoveScenario(RemoveScenario { id: id.0.clone() })
            }
            Self::RenameScenario { id, name } => StoredEdit::RenameScenario(RenameScenario {
                id: id.0.clone(),
                name: name.clone(),
            }),
            Self::DuplicateScenario { id, new_id, name } => {
                StoredEdit::DuplicateScenario(DuplicateScenario {
                    id: id.0.clone(),
                    new_id: new_id.0.clone(),
                    name: name.clone(),
                })
            }
            Self::MergeScenario { id } => {
                StoredEdit::MergeScenario(MergeScenario { id: id.0.clone() })
            }
            Self::SetScenarioParent { id, parent } => {
                StoredEdit::SetScenarioParent(SetScenarioParent {
                    id: id.0.clone(),
                    parent: parent.as_ref().map(|s| s.0.clone()),
                })
            }
            Self::SetScenarioLayer {
                scenario,
                id,
                index,
                layer,
            } => StoredEdit::SetScenarioLayer(SetScenarioLayer {
                scenario: scenario.0.clone(),
                id: id.0.clone(),
                index: index.map(position),
                layer: layer.as_ref().map(Twin::to_stored),
            }),
            Self::ShowScenario { id } => StoredEdit::ShowScenario(ShowScenario {
                id: id.as_ref().map(|s| s.0.clone()),
            }),
            Self::AddBookmark { index, bookmark } => StoredEdit::AddBookmark(AddBookmark {
                index: index.map(position),
                bookmark: bookmark.to_stored(),
            }),
            Self::RemoveBookmark { index } => StoredEdit::RemoveBookmark(RemoveBookmark {
                index: position(*index),
            }),
            Self::ReplaceBookmark { index, bookmark } => {
                StoredEdit::ReplaceBookmark(ReplaceBookmark {
                    index: position(*index),
                    bookmark: bookmark.to_stored(),
                })
            }
            Self::Batch { label, edits } => StoredEdit::Batch(Batch {
                label: (!label.is_empty()).then(|| label.clone()),
                edits: edits.iter().map(Twin::to_stored).collect(),
            }),
        }
    }
}

fn vector_text(
    text: Option<String>,
    most_bytes: usize,
    name: &str,
    at: &At<'_>,
) -> Result<Option<String>, Fault> {
    text.map(|text| filled(text, most_bytes, &At::Member(at, name)))
        .transpose()
}

fn of_scenario(id: Option<String>, name: &str, at: &At<'_>) -> Result<Option<ScenarioId>, Fault> {
    id.map(|id| scenario_id(id, &At::Member(at, name)))
        .transpose()
}

fn element(stored: elements::Element, at: &At<'_>) -> Result<Arc<Element>, Fault> {
    Element::from_stored(stored, &At::Member(at, "element")).map(Arc::new)
}

fn set_change(e: SetChange, at: &At<'_>) -> Result<Edit, Fault> {
    let id = element_id(e.id, &At::Member(at, "id"))?;
    let place = At::Member(at, "change");
    let change = e
        .change
        .map(|change| Change::from_stored(change, &place))
        .transpose()?;
    if let Some(change) = &change {
        let found = change.element_id().map(|id| id.0.as_str());
        if found != Some(id.0.as_str()) {
            let expected = format!("a change of element {:?}", id.0);
            let found = found.unwrap_or("a kind that is not known");
            return Err(place.fault(expected, found));
        }
    }
    Ok(Edit::SetChange {
        scenario: scenario_id(e.scenario, &At::Member(at, "scenario"))?,
        id,
        index: e.index.map(|i| i as usize),
        change,
    })
}

fn set_scenario_layer(e: SetScenarioLayer, at: &At<'_>) -> Result<Edit, Fault> {
    let id = layer_id(e.id, &At::Member(at, "id"))?;
    let place = At::Member(at, "layer");
    let layer = e
        .layer
        .map(|layer| LayerOverride::from_stored(layer, &place))
        .transpose()?;
    if let Some(layer) = layer.as_ref().filter(|layer| layer.id != id) {
        let expected = format!("the id {:?}", id.0);
        return Err(At::Member(&place, "id").fault(expected, layer.id.0.clone()));
    }
    Ok(Edit::SetScenarioLayer {
        scenario: scenario_id(e.scenario, &At::Member(at, "scenario"))?,
        id,
        index: e.index.map(|i| i as usize),
        layer,
    })
}

/// Checks an edit's own values (not whether it fits a project) by the reader's rules. Geometry takes
/// no detour through JSON, which a vertex of a long outline could not be dragged with.
pub(crate) fn check(edit: &Edit, at: &At<'_>) -> Result<(), Fault> {
    use crate::stored::value::Stored as _;
    if let Edit::Batch { edits, label: _ } = edit {
        let place = At::Member(at, "edits");
        if edits.len() > range::MOST_EDITS {
            let most = format!("at most {} edits", range::MOST_EDITS);
            return Err(place.fault(most, edits.len().to_string()));
        }
        let mut edits = edits.iter().enumerate();
        return edits.try_for_each(|(i, edit)| check(edit, &At::Element(&place, i)));
    }
    if let Edit::AddElement { element, .. } | Edit::ReplaceElement { element, .. } = edit {
        check_element(element, &At::Member(at, "element"))?;
    }
    if let Edit::SetChange {
        change: Some(change),
        ..
    } = edit
    {
        check_change(change, &At::Member(at, "change"))?;
    }
    if let Edit::SetChanges { changes, .. } = edit {
        let place = At::Member(at, "changes");
        let mut changes = changes.iter().enumerate();
        changes.try_for_each(|(i, change)| check_change(change, &At::Element(&place, i)))?;
    }
    if let Edit::AddScenario { scenario, .. } = edit {
        let place = At::Member(at, "scenario");
        let place = At::Member(&place, "changes");
        let mut changes = scenario.changes.iter().enumerate();
        changes.try_for_each(|(i, change)| check_change(change, &At::Element(&place, i)))?;
    }
    if let Edit::AddLayer { layer, .. } = edit {
        unknown_is_unknown(layer)?;
    }
    let stored = StoredEdit::read(without_vertices(edit).to_stored().write(), at)?;
    Edit::from_stored(stored, at).map(drop)
}

/// The edit with lists of vertices left empty, and the elements that it holds.
pub(crate) fn apart(edit: &Edit) -> (Cow<'_, Edit>, Vec<&Element>) {
    fn of(changes: &[Change]) -> Vec<&Element> {
        let elements = changes.iter().filter_map(|change| change.element());
        elements.map(|element| &**element).collect()
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "the others hold no element")]
    fn elements(edit: &Edit) -> Vec<&Element> {
        match edit {
            Edit::AddElement { element, .. } | Edit::ReplaceElement { element, .. } => {
                vec![element]
            }
            Edit::SetChange { change, .. } => of(change.as_slice()),
            Edit::SetChanges { changes, .. } => of(changes),
            Edit::AddScenario { scenario, .. } => of(&scenario.changes),
            _others => Vec::new(),
        }
    }
    if let Edit::Batch { label, edits } = edit {
        let (bare, all): (Vec<Edit>, Vec<Vec<&Element>>) = edits
            .iter()
            .map(|edit| {
                let (bare, elements) = apart(edit);
                (bare.into_owned(), elements)
            })
            .unzip();
        let label = label.clone();
        let batch = Edit::Batch { label, edits: bare };
        return (Cow::Owned(batch), all.concat());
    }
    (without_vertices(edit), elements(edit))
}

/// The edit with lists of vertices left empty, which are checked already.
fn without_vertices(edit: &Edit) -> Cow<'_, Edit> {
    let bare = |element: &mut Arc<Element>| {
        for list in Arc::make_mut(element).vertex_lists_mut() {
            *list = Vertices::default();
        }
    };
    let bare_change = |change: &mut Change| {
        if let ChangeKind::Add { element, .. } | ChangeKind::Replace { element, .. } =
            &mut change.kind
        {
            bare(element);
        }
    };
    let mut edit = Cow::Borrowed(edit);
    if matches!(
        *edit,
        Edit::AddElement { .. }
            | Edit::ReplaceElement { .. }
            | Edit::SetChange { .. }
            | Edit::SetChanges { .. }
            | Edit::AddScenario { .. }
    ) {
        let edit = edit.to_mut();
        if let Edit::AddElement { element, .. } | Edit::ReplaceElement { element, .. } = edit {
            bare(element);
        }
        if let Edit::SetChange {
            change: Some(change),
            ..
        } = edit
        {
            bare_change(change);
        }
        if let Edit::SetChanges { changes, .. } = edit {
            changes.iter_mut().for_each(bare_change);
        }
        if let Edit::AddScenario { scenario, .. } = edit {
            scenario.changes.iter_mut().for_each(bare_change);
        }
    }
    edit
}
