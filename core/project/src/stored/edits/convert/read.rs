//! From stored to runtime edits.

use std::sync::Arc;

use crate::stored::convert::{
    Twin, bands, changes, details, element_id, filled, layer_id, layer_name, scenario_id,
    source_path, tint,
};
use crate::stored::edits::{SetChange, SetScenarioLayer, StoredEdit};
use crate::stored::elements;
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::stored::value::With;
use crate::{
    Adjust, Bookmark, CameraSettings, Change, Dated, Edit, Element, ElementStyle, Georeference,
    Layer, LayerOverride, Mask, PlanetSettings, Quality, Scenario, ScenarioId, Stretch, Sun,
    VectorStyle,
};

#[expect(clippy::too_many_lines, reason = "one arm for each edit")]
pub(super) fn edit(stored: StoredEdit, at: &At<'_>) -> Result<Edit, Fault> {
    let id = |id: String| layer_id(id, &At::Member(at, "id"));
    Ok(match stored {
        StoredEdit::AddLayer(e) => {
            let layer = Layer::from_stored(e.layer, &At::Member(at, "layer"))?;
            Edit::AddLayer {
                index: e.index.map(|i| i as usize),
                layer: Box::new(layer),
            }
        }
        StoredEdit::RemoveLayer(e) => Edit::RemoveLayer { id: id(e.id)? },
        StoredEdit::MoveLayer(e) => Edit::MoveLayer {
            id: id(e.id)?,
            index: e.index as usize,
        },
        StoredEdit::SetName(e) => Edit::SetName {
            id: id(e.id)?,
            name: layer_name(e.name, &At::Member(at, "name"))?,
        },
        StoredEdit::SetVisible(e) => Edit::SetVisible {
            id: id(e.id)?,
            visible: e.visible,
        },
        StoredEdit::SetOpacity(e) => Edit::SetOpacity {
            id: id(e.id)?,
            opacity: e.opacity,
        },
        StoredEdit::SetLocked(e) => Edit::SetLocked {
            id: id(e.id)?,
            locked: e.locked,
        },
        StoredEdit::SetBlend(e) => Edit::SetBlend {
            id: id(e.id)?,
            blend: e.blend.into(),
        },
        StoredEdit::SetDated(e) => {
            let at = At::Member(at, "dated");
            let dated = e.dated.map(|dated| Dated::from_stored(dated, &at));
            Edit::SetDated {
                id: id(e.id)?,
                dated: dated.transpose()?,
            }
        }
        StoredEdit::ShowDate(e) => Edit::ShowDate {
            date: e.date.map(|date| date.0),
        },
        StoredEdit::SetMask(e) => {
            let at = At::Member(at, "mask");
            let mask = e
                .mask
                .map(|mask| Mask::from_stored(mask, &at))
                .transpose()?;
            Edit::SetMask {
                id: id(e.id)?,
                mask: mask.map(Box::new),
            }
        }
        StoredEdit::SetAdjust(e) => {
            let adjust = Adjust::from_stored(e.adjust, &At::Member(at, "adjust"))?;
            Edit::SetAdjust {
                id: id(e.id)?,
                adjust,
            }
        }
        StoredEdit::SetResampling(e) => Edit::SetResampling {
            id: id(e.id)?,
            resampling: e.resampling.into(),
        },
        StoredEdit::SetEdgeFade(e) => Edit::SetEdgeFade {
            id: id(e.id)?,
            edge_fade_m: e.edge_fade_m,
        },
        StoredEdit::SetSeamBlend(e) => Edit::SetSeamBlend {
            id: id(e.id)?,
            seam_blend_m: e.seam_blend_m,
        },
        StoredEdit::SetMissing(e) => Edit::SetMissing {
            id: id(e.id)?,
            missing: e.missing.map(|colour| colour.0),
        },
        StoredEdit::SetColourDetail(e) => Edit::SetColourDetail {
            id: id(e.id)?,
            detail: details(e.detail, &At::Member(at, "detail"))?,
        },
        StoredEdit::SetPath(e) => Edit::SetPath {
            id: id(e.id)?,
            path: source_path(e.path, &At::Member(at, "path"))?,
        },
        StoredEdit::SetGeoreference(e) => {
            let place = At::Member(at, "georeference");
            let georeference = e
                .georeference
                .map(|g| Georeference::from_stored(g, &place))
                .transpose()?;
            Edit::SetGeoreference {
                id: id(e.id)?,
                georeference,
            }
        }
        StoredEdit::SetNodata(e) => Edit::SetNodata {
            id: id(e.id)?,
            nodata: e.nodata,
        },
        StoredEdit::SetTiles(e) => Edit::SetTiles {
            id: id(e.id)?,
            encoding: e.encoding.map(Into::into),
            tile_rows: e.tile_rows.map(Into::into),
        },
        StoredEdit::SetStretch(e) => Edit::SetStretch {
            id: id(e.id)?,
            stretch: e.stretch.map_or(Stretch::Auto, |s| s.0),
        },
        StoredEdit::SetBands(e) => {
            let place = At::Member(at, "bands");
            let bands = e.bands.map(|given| bands(&given, &place)).transpose()?;
            Edit::SetBands {
                id: id(e.id)?,
                bands,
            }
        }
        StoredEdit::SetHeightScale(e) => Edit::SetHeightScale {
            id: id(e.id)?,
            vertical_scale: e.vertical_scale,
            offset_m: e.offset_m,
        },
        StoredEdit::SetNoise(e) => Edit::SetNoise {
            id: id(e.id)?,
            noise: whole(e.noise, "noise", at)?,
        },
        StoredEdit::SetDetail(e) => Edit::SetDetail {
            id: id(e.id)?,
            detail: whole(e.detail, "detail", at)?,
        },
        StoredEdit::SetTint(e) => Edit::SetTint {
            id: id(e.id)?,
            tint: tint(e.stops, e.interpolation, at)?,
        },
        StoredEdit::SetSlope(e) => Edit::SetSlope {
            id: id(e.id)?,
            slope: whole(e.slope, "slope", at)?,
        },
        StoredEdit::SetContours(e) => Edit::SetContours {
            id: id(e.id)?,
            contours: whole(e.contours, "contours", at)?,
        },
        StoredEdit::SetPlanet(e) => Edit::SetPlanet {
            planet: PlanetSettings::from_stored(e.planet, &At::Member(at, "planet"))?,
        },
        StoredEdit::SetExaggeration(e) => Edit::SetExaggeration {
            vertical_exaggeration: e.vertical_exaggeration,
        },
        StoredEdit::SetCamera(e) => Edit::SetCamera {
            camera: CameraSettings::from_stored(e.camera, &At::Member(at, "camera"))?,
        },
        StoredEdit::SetSun(e) => Edit::SetSun {
            sun: Sun::from_stored(e.sun, &At::Member(at, "sun"))?,
        },
        StoredEdit::SetQuality(e) => Edit::SetQuality {
            quality: Quality::from_stored(e.quality, &At::Member(at, "quality"))?,
        },
        StoredEdit::SetVectorStyle(e) => Edit::SetVectorStyle {
            id: id(e.id)?,
            style: Box::new(VectorStyle::from_stored(e.style, &At::Member(at, "style"))?),
        },
        StoredEdit::SetVectorSource(e) => Edit::SetVectorSource {
            id: id(e.id)?,
            source_layer: vector_text(e.source_layer, range::LONGEST_NAME, "source_layer", at)?,
            crs: vector_text(e.crs, range::LONGEST_PATH, "crs", at)?,
        },
        StoredEdit::AddElement(e) => Edit::AddElement {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            index: e.index.map(|i| i as usize),
            element: element(e.element, at)?,
        },
        StoredEdit::RemoveElement(e) => Edit::RemoveElement {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
        },
        StoredEdit::ReplaceElement(e) => Edit::ReplaceElement {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            element: element(e.element, at)?,
        },
        StoredEdit::MoveElement(e) => Edit::MoveElement {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
            index: e.index as usize,
        },
        StoredEdit::SetElementName(e) => Edit::SetElementName {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
            name: layer_name(e.name, &At::Member(at, "name"))?,
        },
        StoredEdit::SetElementVisible(e) => Edit::SetElementVisible {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
            visible: e.visible,
        },
        StoredEdit::SetElementLocked(e) => Edit::SetElementLocked {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
            locked: e.locked,
        },
        StoredEdit::SetElementStyle(e) => Edit::SetElementStyle {
            scenario: of_scenario(e.scenario, "scenario", at)?,
            id: element_id(e.id, &At::Member(at, "id"))?,
            style: ElementStyle::from_stored(e.style, &At::Member(at, "style"))?,
        },
        StoredEdit::SetChange(e) => set_change(e, at)?,
        StoredEdit::SetChanges(e) => Edit::SetChanges {
            scenario: scenario_id(e.scenario, &At::Member(at, "scenario"))?,
            changes: changes(Some(e.changes), &At::Member(at, "changes"))?,
        },
        StoredEdit::AddScenario(e) => Edit::AddScenario {
            index: e.index.map(|i| i as usize),
            scenario: Box::new(Scenario::from_stored(
                e.scenario,
                &At::Member(at, "scenario"),
            )?),
        },
        StoredEdit::RemoveScenario(e) => Edit::RemoveScenario {
            id: scenario_id(e.id, &At::Member(at, "id"))?,
        },
        StoredEdit::RenameScenario(e) => Edit::RenameScenario {
            id: scenario_id(e.id, &At::Member(at, "id"))?,
            name: layer_name(e.name, &At::Member(at, "name"))?,
        },
        StoredEdit::DuplicateScenario(e) => Edit::DuplicateScenario {
            id: scenario_id(e.id, &At::Member(at, "id"))?,
            new_id: scenario_id(e.new_id, &At::Member(at, "new_id"))?,
            name: layer_name(e.name, &At::Member(at, "name"))?,
        },
        StoredEdit::MergeScenario(e) => Edit::MergeScenario {
            id: scenario_id(e.id, &At::Member(at, "id"))?,
        },
        StoredEdit::SetScenarioParent(e) => Edit::SetScenarioParent {
            id: scenario_id(e.id, &At::Member(at, "id"))?,
            parent: of_scenario(e.parent, "parent", at)?,
        },
        StoredEdit::SetScenarioLayer(e) => set_scenario_layer(e, at)?,
        StoredEdit::ShowScenario(e) => Edit::ShowScenario {
            id: of_scenario(e.id, "id", at)?,
        },
        StoredEdit::AddBookmark(e) => Edit::AddBookmark {
            index: e.index.map(|i| i as usize),
            bookmark: Bookmark::from_stored(e.bookmark, &At::Member(at, "bookmark"))?,
        },
        StoredEdit::RemoveBookmark(e) => Edit::RemoveBookmark {
            index: e.index as usize,
        },
        StoredEdit::ReplaceBookmark(e) => Edit::ReplaceBookmark {
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
            let edits = edits.map(|(i, stored)| edit(stored, &At::Element(&place, i)));
            Edit::Batch {
                label: e.label.unwrap_or_default(),
                edits: edits.collect::<Result<_, _>>()?,
            }
        }
    })
}

/// A layer's parameters, of which no member may be unknown.
fn whole<T: Twin>(stored: With<T::Stored>, name: &str, at: &At<'_>) -> Result<T, Fault> {
    let place = At::Member(at, name);
    if let Some(unknown) = stored.extra.keys().next() {
        let expected = format!("no such member of {name}");
        return Err(At::Member(&place, unknown).fault(expected, "one"));
    }
    T::from_stored(stored.fields, &place)
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
