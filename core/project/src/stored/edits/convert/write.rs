//! From runtime to stored edits.

use crate::stored::colour::StoredColour;
use crate::stored::convert::{Twin, position, stored_tint};
use crate::stored::edits::{
    AddBookmark, AddElement, AddLayer, AddScenario, Batch, DuplicateScenario, MergeScenario,
    MoveElement, MoveLayer, RemoveBookmark, RemoveElement, RemoveLayer, RemoveScenario,
    RenameScenario, ReplaceBookmark, ReplaceElement, SetAdjust, SetBands, SetBlend, SetCamera,
    SetChange, SetChanges, SetColourDetail, SetContours, SetDated, SetDetail, SetEdgeFade,
    SetElementLocked, SetElementName, SetElementStyle, SetElementVisible, SetExaggeration,
    SetGeoreference, SetHeightScale, SetLocked, SetMask, SetMissing, SetName, SetNodata, SetNoise,
    SetOpacity, SetPath, SetPlanet, SetQuality, SetResampling, SetScenarioLayer, SetScenarioParent,
    SetSeamBlend, SetSlope, SetStretch, SetSun, SetTiles, SetTint, SetVectorSource, SetVectorStyle,
    SetVisible, ShowDate, ShowScenario, StoredEdit,
};
use crate::stored::series::StoredDate;
use crate::stored::stretch::StoredStretch;
use crate::stored::value::With;
use crate::{Edit, Extra, LayerId};

#[expect(clippy::too_many_lines, reason = "one arm for each edit")]
pub(super) fn edit(edit: &Edit) -> StoredEdit {
    let text = |id: &LayerId| id.0.clone();
    match edit {
        Edit::AddLayer { index, layer } => StoredEdit::AddLayer(AddLayer {
            index: index.map(position),
            layer: layer.to_stored(),
        }),
        Edit::RemoveLayer { id } => StoredEdit::RemoveLayer(RemoveLayer { id: text(id) }),
        Edit::MoveLayer { id, index } => StoredEdit::MoveLayer(MoveLayer {
            id: text(id),
            index: position(*index),
        }),
        Edit::SetName { id, name } => StoredEdit::SetName(SetName {
            id: text(id),
            name: name.clone(),
        }),
        Edit::SetVisible { id, visible } => StoredEdit::SetVisible(SetVisible {
            id: text(id),
            visible: *visible,
        }),
        Edit::SetOpacity { id, opacity } => StoredEdit::SetOpacity(SetOpacity {
            id: text(id),
            opacity: *opacity,
        }),
        Edit::SetLocked { id, locked } => StoredEdit::SetLocked(SetLocked {
            id: text(id),
            locked: *locked,
        }),
        Edit::SetBlend { id, blend } => StoredEdit::SetBlend(SetBlend {
            id: text(id),
            blend: (*blend).into(),
        }),
        Edit::SetDated { id, dated } => StoredEdit::SetDated(SetDated {
            id: text(id),
            dated: dated.as_ref().map(Twin::to_stored),
        }),
        Edit::ShowDate { date } => StoredEdit::ShowDate(ShowDate {
            date: date.map(StoredDate),
        }),
        Edit::SetMask { id, mask } => StoredEdit::SetMask(SetMask {
            id: text(id),
            mask: mask.as_ref().map(|mask| mask.to_stored()),
        }),
        Edit::SetAdjust { id, adjust } => StoredEdit::SetAdjust(SetAdjust {
            id: text(id),
            adjust: adjust.to_stored(),
        }),
        Edit::SetResampling { id, resampling } => StoredEdit::SetResampling(SetResampling {
            id: text(id),
            resampling: (*resampling).into(),
        }),
        Edit::SetEdgeFade { id, edge_fade_m } => StoredEdit::SetEdgeFade(SetEdgeFade {
            id: text(id),
            edge_fade_m: *edge_fade_m,
        }),
        Edit::SetSeamBlend { id, seam_blend_m } => StoredEdit::SetSeamBlend(SetSeamBlend {
            id: text(id),
            seam_blend_m: *seam_blend_m,
        }),
        Edit::SetMissing { id, missing } => StoredEdit::SetMissing(SetMissing {
            id: text(id),
            missing: missing.map(StoredColour),
        }),
        Edit::SetColourDetail { id, detail } => StoredEdit::SetColourDetail(SetColourDetail {
            id: text(id),
            detail: detail.iter().map(Twin::to_stored).collect(),
        }),
        Edit::SetPath { id, path } => StoredEdit::SetPath(SetPath {
            id: text(id),
            path: path.clone(),
        }),
        Edit::SetGeoreference { id, georeference } => {
            StoredEdit::SetGeoreference(SetGeoreference {
                id: text(id),
                georeference: georeference.as_ref().map(Twin::to_stored),
            })
        }
        Edit::SetNodata { id, nodata } => StoredEdit::SetNodata(SetNodata {
            id: text(id),
            nodata: *nodata,
        }),
        Edit::SetTiles {
            id,
            encoding,
            tile_rows,
        } => StoredEdit::SetTiles(SetTiles {
            id: id.0.clone(),
            encoding: encoding.map(Into::into),
            tile_rows: tile_rows.map(Into::into),
        }),
        Edit::SetStretch { id, stretch } => StoredEdit::SetStretch(SetStretch {
            id: text(id),
            stretch: Some(StoredStretch(*stretch)),
        }),
        Edit::SetBands { id, bands } => StoredEdit::SetBands(SetBands {
            id: text(id),
            bands: bands
                .as_ref()
                .map(|bands| bands.iter().copied().map(u32::from).collect()),
        }),
        Edit::SetHeightScale {
            id,
            vertical_scale,
            offset_m,
        } => StoredEdit::SetHeightScale(SetHeightScale {
            id: text(id),
            vertical_scale: *vertical_scale,
            offset_m: *offset_m,
        }),
        Edit::SetNoise { id, noise } => StoredEdit::SetNoise(SetNoise {
            id: text(id),
            noise: alone(noise),
        }),
        Edit::SetDetail { id, detail } => StoredEdit::SetDetail(SetDetail {
            id: text(id),
            detail: alone(detail),
        }),
        Edit::SetSlope { id, slope } => StoredEdit::SetSlope(SetSlope {
            id: text(id),
            slope: alone(slope),
        }),
        Edit::SetContours { id, contours } => StoredEdit::SetContours(SetContours {
            id: text(id),
            contours: alone(contours),
        }),
        Edit::SetTint { id, tint } => {
            let (stops, interpolation) = stored_tint(tint);
            StoredEdit::SetTint(SetTint {
                id: text(id),
                stops,
                interpolation,
            })
        }
        Edit::SetPlanet { planet } => StoredEdit::SetPlanet(SetPlanet {
            planet: planet.to_stored(),
        }),
        Edit::SetExaggeration {
            vertical_exaggeration,
        } => StoredEdit::SetExaggeration(SetExaggeration {
            vertical_exaggeration: *vertical_exaggeration,
        }),
        Edit::SetCamera { camera } => StoredEdit::SetCamera(SetCamera {
            camera: camera.to_stored(),
        }),
        Edit::SetSun { sun } => StoredEdit::SetSun(SetSun {
            sun: sun.to_stored(),
        }),
        Edit::SetQuality { quality } => StoredEdit::SetQuality(SetQuality {
            quality: quality.to_stored(),
        }),
        Edit::SetVectorStyle { id, style } => StoredEdit::SetVectorStyle(SetVectorStyle {
            id: text(id),
            style: style.to_stored(),
        }),
        Edit::SetVectorSource {
            id,
            source_layer,
            crs,
        } => StoredEdit::SetVectorSource(SetVectorSource {
            id: text(id),
            source_layer: source_layer.clone(),
            crs: crs.clone(),
        }),
        Edit::AddElement {
            scenario,
            index,
            element,
        } => StoredEdit::AddElement(AddElement {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            index: index.map(position),
            element: element.to_stored(),
        }),
        Edit::RemoveElement { scenario, id } => StoredEdit::RemoveElement(RemoveElement {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
        }),
        Edit::ReplaceElement { scenario, element } => StoredEdit::ReplaceElement(ReplaceElement {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            element: element.to_stored(),
        }),
        Edit::MoveElement {
            scenario,
            id,
            index,
        } => StoredEdit::MoveElement(MoveElement {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
            index: position(*index),
        }),
        Edit::SetElementName { scenario, id, name } => StoredEdit::SetElementName(SetElementName {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
            name: name.clone(),
        }),
        Edit::SetElementVisible {
            scenario,
            id,
            visible,
        } => StoredEdit::SetElementVisible(SetElementVisible {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
            visible: *visible,
        }),
        Edit::SetElementLocked {
            scenario,
            id,
            locked,
        } => StoredEdit::SetElementLocked(SetElementLocked {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
            locked: *locked,
        }),
        Edit::SetElementStyle {
            scenario,
            id,
            style,
        } => StoredEdit::SetElementStyle(SetElementStyle {
            scenario: scenario.as_ref().map(|s| s.0.clone()),
            id: id.0.clone(),
            style: style.to_stored(),
        }),
        Edit::SetChange {
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
        Edit::SetChanges { scenario, changes } => StoredEdit::SetChanges(SetChanges {
            scenario: scenario.0.clone(),
            changes: changes.iter().map(Twin::to_stored).collect(),
        }),
        Edit::AddScenario { index, scenario } => StoredEdit::AddScenario(AddScenario {
            index: index.map(position),
            scenario: scenario.to_stored(),
        }),
        Edit::RemoveScenario { id } => {
            StoredEdit::RemoveScenario(RemoveScenario { id: id.0.clone() })
        }
        Edit::RenameScenario { id, name } => StoredEdit::RenameScenario(RenameScenario {
            id: id.0.clone(),
            name: name.clone(),
        }),
        Edit::DuplicateScenario { id, new_id, name } => {
            StoredEdit::DuplicateScenario(DuplicateScenario {
                id: id.0.clone(),
                new_id: new_id.0.clone(),
                name: name.clone(),
            })
        }
        Edit::MergeScenario { id } => StoredEdit::MergeScenario(MergeScenario { id: id.0.clone() }),
        Edit::SetScenarioParent { id, parent } => {
            StoredEdit::SetScenarioParent(SetScenarioParent {
                id: id.0.clone(),
                parent: parent.as_ref().map(|s| s.0.clone()),
            })
        }
        Edit::SetScenarioLayer {
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
        Edit::ShowScenario { id } => StoredEdit::ShowScenario(ShowScenario {
            id: id.as_ref().map(|s| s.0.clone()),
        }),
        Edit::AddBookmark { index, bookmark } => StoredEdit::AddBookmark(AddBookmark {
            index: index.map(position),
            bookmark: bookmark.to_stored(),
        }),
        Edit::RemoveBookmark { index } => StoredEdit::RemoveBookmark(RemoveBookmark {
            index: position(*index),
        }),
        Edit::ReplaceBookmark { index, bookmark } => StoredEdit::ReplaceBookmark(ReplaceBookmark {
            index: position(*index),
            bookmark: bookmark.to_stored(),
        }),
        Edit::Batch { label, edits } => StoredEdit::Batch(Batch {
            label: (!label.is_empty()).then(|| label.clone()),
            edits: edits.iter().map(Twin::to_stored).collect(),
        }),
    }
}

fn alone<T: Twin>(parameters: &T) -> With<T::Stored> {
    With {
        fields: parameters.to_stored(),
        extra: Extra::new(),
    }
}
