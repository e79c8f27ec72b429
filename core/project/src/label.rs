//! What an edit touches and what people call it.

mod planning;

use crate::{Affects, Aspect, Edit, Element, LayerId, Project, Vertices};

impl Edit {
    /// The layer it touches, where it touches one.
    #[expect(clippy::wildcard_enum_match_arm, reason = "the others touch no layer")]
    pub fn layer_id(&self) -> Option<&LayerId> {
        match self {
            Self::AddLayer { layer, .. } => Some(&layer.id),
            Self::RemoveLayer { id }
            | Self::MoveLayer { id, .. }
            | Self::SetName { id, .. }
            | Self::SetVisible { id, .. }
            | Self::SetOpacity { id, .. }
            | Self::SetLocked { id, .. }
            | Self::SetBlend { id, .. }
            | Self::SetMask { id, .. }
            | Self::SetDated { id, .. }
            | Self::SetAdjust { id, .. }
            | Self::SetResampling { id, .. }
            | Self::SetEdgeFade { id, .. }
            | Self::SetSeamBlend { id, .. }
            | Self::SetMissing { id, .. }
            | Self::SetColourDetail { id, .. }
            | Self::SetPath { id, .. }
            | Self::SetGeoreference { id, .. }
            | Self::SetNodata { id, .. }
            | Self::SetTiles { id, .. }
            | Self::SetStretch { id, .. }
            | Self::SetBands { id, .. }
            | Self::SetHeightScale { id, .. }
            | Self::SetNoise { id, .. }
            | Self::SetDetail { id, .. }
            | Self::SetTint { id, .. }
            | Self::SetSlope { id, .. }
            | Self::SetContours { id, .. }
            | Self::SetVectorStyle { id, .. }
            | Self::SetVectorSource { id, .. }
            | Self::SetScenarioLayer { id, .. } => Some(id),
            _ => None,
        }
    }

    /// What it touches, sorted, each once.
    pub fn affects(&self) -> Vec<Affects> {
        let mut all = Vec::new();
        self.collect_affects(&mut all);
        all.sort();
        all.dedup();
        all
    }

    fn collect_affects(&self, all: &mut Vec<Affects>) {
        let aspect = match self {
            Self::AddLayer { .. } | Self::RemoveLayer { .. } => Aspect::Presence,
            Self::MoveLayer { .. } => Aspect::Order,
            Self::SetName { .. } => Aspect::Name,
            Self::SetVisible { .. } | Self::SetDated { .. } => Aspect::Visibility,
            Self::SetOpacity { .. } => Aspect::Opacity,
            Self::SetLocked { .. } => Aspect::Lock,
            Self::SetBlend { .. } => Aspect::Blend,
            Self::SetMask { .. } => Aspect::Mask,
            Self::SetAdjust { .. } => Aspect::Adjust,
            Self::SetResampling { .. } => Aspect::Resampling,
            Self::SetEdgeFade { .. } | Self::SetSeamBlend { .. } => Aspect::EdgeFade,
            Self::SetPath { .. }
            | Self::SetGeoreference { .. }
            | Self::SetNodata { .. }
            | Self::SetMissing { .. }
            | Self::SetTiles { .. }
            | Self::SetStretch { .. }
            | Self::SetBands { .. }
            | Self::SetVectorSource { .. } => Aspect::Source,
            Self::SetHeightScale { .. } => Aspect::HeightScale,
            Self::SetNoise { .. } | Self::SetDetail { .. } | Self::SetColourDetail { .. } => {
                Aspect::Noise
            }
            Self::SetTint { .. } => Aspect::Tint,
            Self::SetVectorStyle { .. } | Self::SetSlope { .. } | Self::SetContours { .. } => {
                Aspect::Style
            }
            Self::AddElement { .. }
            | Self::RemoveElement { .. }
            | Self::ReplaceElement { .. }
            | Self::MoveElement { .. }
            | Self::SetElementName { .. }
            | Self::SetElementVisible { .. }
            | Self::SetElementLocked { .. }
            | Self::SetElementStyle { .. }
            | Self::SetChange { .. } => return all.extend(self.affected_element()),
            Self::SetChanges { scenario: id, .. }
            | Self::SetScenarioLayer { scenario: id, .. }
            | Self::SetScenarioParent { id, .. }
            | Self::DuplicateScenario { new_id: id, .. }
            | Self::RemoveScenario { id } => {
                return all.push(Affects::Scenario { id: id.clone() });
            }
            Self::AddScenario { scenario, .. } => {
                return all.push(Affects::Scenario {
                    id: scenario.id.clone(),
                });
            }
            Self::RenameScenario { .. } => return all.push(Affects::ScenarioName),
            Self::MergeScenario { id } => {
                return all.extend([Affects::Scenario { id: id.clone() }, Affects::Base]);
            }
            Self::ShowScenario { .. } | Self::ShowDate { .. } => return all.push(Affects::Shown),
            Self::AddBookmark { .. }
            | Self::RemoveBookmark { .. }
            | Self::ReplaceBookmark { .. } => return all.push(Affects::Bookmarks),
            Self::SetPlanet { .. } => return all.extend([Affects::Planet, Affects::Exaggeration]),
            Self::SetExaggeration { .. } => return all.push(Affects::Exaggeration),
            Self::SetCamera { .. } => return all.push(Affects::Camera),
            Self::SetSun { .. } => return all.push(Affects::Sun),
            Self::SetQuality { .. } => return all.push(Affects::Quality),
            Self::Batch { edits, .. } => {
                return edits.iter().for_each(|edit| edit.collect_affects(all));
            }
        };
        all.extend(self.layer_id().map(|id| Affects::Layer {
            id: id.clone(),
            aspect,
        }));
    }

    /// What people call it, for the undo menu: `Opacity of Blue Marble`. `project` knows the names,
    /// before or after the edit.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the others are labelled with what they plan"
    )]
    pub fn label(&self, project: &Project) -> String {
        let what = match self {
            Self::AddLayer { .. } => "Add",
            Self::RemoveLayer { .. } => "Remove",
            Self::MoveLayer { .. } => "Move",
            Self::SetName { .. } => "Rename",
            Self::SetVisible { visible: true, .. } => "Show",
            Self::SetVisible { visible: false, .. } => "Hide",
            Self::SetLocked { locked: true, .. } => "Lock",
            Self::SetLocked { locked: false, .. } => "Unlock",
            Self::SetOpacity { .. } => "Opacity of",
            Self::SetBlend { .. } => "Blend mode of",
            Self::SetMask { .. } => "Mask of",
            Self::SetDated { .. } => "Date of",
            Self::ShowDate { .. } => return "Shown date".to_owned(),
            Self::SetAdjust { id, adjust } => adjusted(project, id, adjust),
            Self::SetResampling { .. } => "Resampling of",
            Self::SetEdgeFade { .. } => "Edge fade of",
            Self::SetSeamBlend { .. } => "Seams of",
            Self::SetMissing { .. } => "Holes of",
            Self::SetPath { .. } => "File of",
            Self::SetGeoreference { .. } => "Place of",
            Self::SetNodata { .. } => "No-data value of",
            Self::SetTiles { .. } => "Tiles of",
            Self::SetStretch { .. } => "Stretch of",
            Self::SetBands { .. } => "Bands of",
            Self::SetHeightScale { .. } => "Height scale of",
            Self::SetNoise { .. } => "Noise of",
            Self::SetDetail { .. } | Self::SetColourDetail { .. } => "Detail of",
            Self::SetTint { .. } | Self::SetSlope { .. } => "Colours of",
            Self::SetVectorStyle { .. } | Self::SetContours { .. } => "Style of",
            Self::SetVectorSource { .. } => "Source of",
            Self::SetPlanet { .. } => return "Planet".to_owned(),
            Self::SetExaggeration { .. } => return "Vertical exaggeration".to_owned(),
            Self::SetCamera { .. } => return "Camera".to_owned(),
            Self::SetSun { .. } => return "Sun".to_owned(),
            Self::SetQuality { .. } => return "Quality".to_owned(),
            Self::Batch { label, edits } => {
                let first = || {
                    edits
                        .first()
                        .map_or_else(|| "Nothing".to_owned(), |edit| edit.label(project))
                };
                return if label.is_empty() {
                    first()
                } else {
                    label.clone()
                };
            }
            _ => return self.planning_label(project),
        };
        let name = if let Self::AddLayer { layer, .. } = self {
            &layer.name
        } else {
            self.layer_id()
                .and_then(|id| project.layer(id))
                .map_or("a layer", |layer| layer.name.as_str())
        };
        format!("{what} {name}")
    }

    /// Edits with equal keys set the same value of the same thing; batches, those of their edits.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "most edits set a value of one layer, one element, or the project"
    )]
    pub(crate) fn merge_key(&self) -> Option<(core::mem::Discriminant<Self>, String)> {
        let thing = match self {
            Self::AddLayer { .. }
            | Self::RemoveLayer { .. }
            | Self::AddElement { .. }
            | Self::RemoveElement { .. }
            | Self::AddScenario { .. }
            | Self::RemoveScenario { .. }
            | Self::DuplicateScenario { .. }
            | Self::MergeScenario { .. }
            | Self::SetScenarioLayer { .. }
            | Self::AddBookmark { .. }
            | Self::RemoveBookmark { .. } => return None,
            Self::Batch { edits, .. } => {
                let keys: Option<Vec<_>> = edits.iter().map(Self::merge_key).collect();
                format!("{:?}", keys?)
            }
            Self::ReplaceBookmark { index, .. } => index.to_string(),
            Self::SetChanges { scenario: id, .. }
            | Self::RenameScenario { id, .. }
            | Self::SetScenarioParent { id, .. } => id.0.clone(),
            _ => match (self.layer_id(), self.element()) {
                (Some(id), _) => id.0.clone(),
                (None, Some((scenario, id))) => {
                    format!("{}/{id}", scenario.map_or("", |s| s.0.as_str()))
                }
                (None, None) => String::new(),
            },
        };
        Some((core::mem::discriminant(self), thing))
    }

    /// Memory behind it in bytes, about. Lists of vertices that `project` shares cost nothing.
    pub(crate) fn heap_bytes(&self, project: &Project) -> usize {
        let (bare, elements) = crate::stored::edits::apart(self);
        let text = serde_json::to_vec(bare.as_ref()).map_or(0, |text| text.len());
        let own: usize = elements
            .iter()
            .map(|element| own_vertices(element, project))
            .sum();
        text + own * size_of::<crate::Vertex>()
    }
}

/// Vertices of an element that no element of this id in the project shares.
fn own_vertices(element: &Element, project: &Project) -> usize {
    // Short lists are not worth the look.
    const SHORT: usize = 100;
    let lists = element.vertex_lists();
    let all: usize = lists.iter().map(|list| list.len()).sum();
    if all < SHORT {
        return all;
    }
    let changes = project
        .scenarios
        .iter()
        .filter_map(|s| s.change(&element.id));
    let others: Vec<&Vertices> = changes
        .filter_map(|(_, change)| change.element())
        .chain(project.element_in(None, &element.id))
        .flat_map(|other| other.vertex_lists())
        .collect();
    let is_own = |list: &&&Vertices| !others.iter().any(|other| other.is_same(list));
    let own = lists.iter().filter(is_own);
    own.map(|list| list.len()).sum()
}

/// Which adjustment differs from the project's, where it is one.
fn adjusted(project: &Project, id: &LayerId, new: &crate::Adjust) -> &'static str {
    use crate::LayerKind::{
        Contours, Detail, Height, Imagery, Noise, Slope, Tint, Unknown, Vector,
    };
    let old = match project.layer(id).map(|layer| &layer.kind) {
        Some(Imagery(imagery)) => &imagery.adjust,
        Some(Tint(tint)) => &tint.adjust,
        Some(
            Height(_) | Noise(_) | Detail(_) | Slope(_) | Contours(_) | Vector(_) | Unknown { .. },
        )
        | None => {
            return "Adjustment of";
        }
    };
    let changes = [
        (old.space != new.space, "Colour space of"),
        (
            (old.temperature_k, old.tint) != (new.temperature_k, new.tint),
            "White balance of",
        ),
        (old.mix != new.mix, "Channel mix of"),
        (old.curves != new.curves, "Tone curve of"),
        (old.invert != new.invert, "Inversion of"),
        (old.clear != new.clear, "Clear colour of"),
        (old.strength != new.strength, "Strength of adjustment of"),
        (old.brightness != new.brightness, "Brightness of"),
        (old.contrast != new.contrast, "Contrast of"),
        (old.hue_deg != new.hue_deg, "Hue of"),
        (old.saturation != new.saturation, "Saturation of"),
        (old.gamma != new.gamma, "Gamma of"),
        (old.gain != new.gain, "Gain of"),
        (old.offset != new.offset, "Offset of"),
    ];
    let mut changed = changes.iter().filter(|(differs, _)| *differs);
    match (changed.next(), changed.next()) {
        (Some((_, what)), None) => what,
        _ => "Adjustment of",
    }
}
