//! Labels of edits of elements, scenarios and bookmarks: what moved, in words.

use crate::{
    Affects, Aspect, Change, ChangeKind, Edit, Element, ElementId, ElementKind, Project,
    ScenarioId, Vertices,
};

impl Edit {
    /// The planning element it touches and in which scenario (`None`: the base), where it touches one.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the others touch no element"
    )]
    pub fn element(&self) -> Option<(Option<&ScenarioId>, &ElementId)> {
        match self {
            Self::AddElement {
                scenario, element, ..
            }
            | Self::ReplaceElement { scenario, element } => Some((scenario.as_ref(), &element.id)),
            Self::RemoveElement { scenario, id }
            | Self::MoveElement { scenario, id, .. }
            | Self::SetElementName { scenario, id, .. }
            | Self::SetElementVisible { scenario, id, .. }
            | Self::SetElementLocked { scenario, id, .. }
            | Self::SetElementStyle { scenario, id, .. } => Some((scenario.as_ref(), id)),
            Self::SetChange { scenario, id, .. } => Some((Some(scenario), id)),
            _ => None,
        }
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the others bring one or take it away"
    )]
    pub(super) fn affected_element(&self) -> Option<Affects> {
        let (scenario, id) = self.element()?;
        let aspect = match self {
            Self::MoveElement { .. } => Aspect::Order,
            Self::SetElementName { .. } => Aspect::Name,
            Self::SetElementVisible { .. } => Aspect::Visibility,
            Self::SetElementLocked { .. } => Aspect::Lock,
            Self::SetElementStyle { .. } => Aspect::Style,
            Self::ReplaceElement { .. } => Aspect::Shape,
            _ => Aspect::Presence,
        };
        Some(Affects::Element {
            scenario: scenario.cloned(),
            id: id.clone(),
            aspect,
        })
    }

    /// As [`Edit::label`].
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the others have their labels already"
    )]
    pub(super) fn planning_label(&self, project: &Project) -> String {
        let name = |what: &str| format!("{what} {}", self.element_name(project));
        let scenario = |what: &str, id: &ScenarioId| {
            let name = project.scenario(id).map(|s| s.name.as_str());
            format!("{what} scenario {}", name.unwrap_or(&id.0))
        };
        match self {
            Self::AddElement { .. } => name("Add"),
            Self::RemoveElement { .. } => name("Remove"),
            Self::ReplaceElement { scenario, element } => {
                let before = project.element_in(scenario.as_ref(), &element.id);
                name(before.map_or("Change", |before| difference(before, element)))
            }
            Self::MoveElement { .. } => name("Order of"),
            Self::SetElementName { .. } => name("Rename"),
            Self::SetElementVisible { visible: true, .. } => name("Show"),
            Self::SetElementVisible { visible: false, .. } => name("Hide"),
            Self::SetElementLocked { locked: true, .. } => name("Lock"),
            Self::SetElementLocked { locked: false, .. } => name("Unlock"),
            Self::SetElementStyle { .. } => name("Style of"),
            Self::SetChange { change: None, .. } => name("Back to parent:"),
            Self::SetChange {
                change: Some(Change { kind, .. }),
                ..
            } => match kind {
                ChangeKind::Remove { .. } => name("Remove"),
                ChangeKind::Add { .. }
                | ChangeKind::Replace { .. }
                | ChangeKind::Unknown { .. } => name("Change"),
            },
            Self::SetChanges { scenario: id, .. } => scenario("Changes of", id),
            Self::AddScenario { scenario, .. } => format!("Add scenario {}", scenario.name),
            Self::RemoveScenario { id } => scenario("Remove", id),
            Self::RenameScenario { id, .. } => scenario("Rename", id),
            Self::DuplicateScenario { id, .. } => scenario("Duplicate", id),
            Self::MergeScenario { id } => scenario("Merge", id),
            Self::SetScenarioParent { id, .. } => scenario("Parent of", id),
            Self::SetScenarioLayer {
                scenario: of, id, ..
            } => {
                let layer = project.layer(id).map_or(id.0.as_str(), |l| l.name.as_str());
                scenario(&format!("{layer} in"), of)
            }
            Self::ShowScenario { id: Some(id) } => scenario("Show", id),
            Self::ShowScenario { id: None } => "Show base".to_owned(),
            Self::AddBookmark { bookmark, .. } => format!("Add bookmark {}", bookmark.name),
            Self::RemoveBookmark { index } | Self::ReplaceBookmark { index, .. } => {
                let name = project.bookmarks.get(*index).map(|b| b.name.as_str());
                let what = if matches!(self, Self::RemoveBookmark { .. }) {
                    "Remove"
                } else {
                    "Change"
                };
                format!("{what} bookmark {}", name.unwrap_or_default())
            }
            _ => String::new(),
        }
    }

    fn element_name<'a>(&'a self, project: &'a Project) -> &'a str {
        if let Self::AddElement { element, .. } = self {
            return &element.name;
        }
        let Some((scenario, id)) = self.element() else {
            return "an element";
        };
        let there = project.element_in(scenario, id);
        there
            .or_else(|| project.element_in(None, id))
            .map_or(id.0.as_str(), |element| element.name.as_str())
    }
}

/// What a replacement does to an element, in words that go before its name.
fn difference(before: &Element, after: &Element) -> &'static str {
    use ElementKind::{Brush, Corridor, Polygon};
    if before.side != after.side {
        return "Side slopes of";
    }
    if before.style != after.style {
        return "Style of";
    }
    match (&before.kind, &after.kind) {
        (Polygon(a), Polygon(b)) if a.surface != b.surface => "Surface of",
        (Polygon(a), Polygon(b)) if a.holes.len() != b.holes.len() => "Holes of",
        (Polygon(a), Polygon(b)) if a.breaklines.len() != b.breaklines.len() => "Breaklines of",
        (Corridor(a), Corridor(b)) if a.profile != b.profile => "Profile of",
        (Corridor(a), Corridor(b)) if a.section != b.section => "Section of",
        (Brush(a), Brush(b)) if a.strokes.len() < b.strokes.len() => "Brush stroke on",
        (Polygon(_), Polygon(_)) | (Corridor(_), Corridor(_)) => {
            moved(&before.vertex_lists(), &after.vertex_lists())
        }
        _ => "Change",
    }
}

/// What happened to the vertices of lists.
fn moved(before: &[&Vertices], after: &[&Vertices]) -> &'static str {
    let mut pairs = before.iter().zip(after).filter(|(a, b)| !a.is_same(b));
    let mut moved = 0_usize;
    let mut all = 0_usize;
    for (a, b) in &mut pairs {
        match b.len().checked_signed_diff(a.len()) {
            Some(0) => {}
            Some(1..) => return "Insert vertex in",
            _ => return "Delete vertex of",
        }
        all += a.len();
        moved += a.iter().zip(b.iter()).filter(|(a, b)| a != b).count();
    }
    match moved {
        0 => "Change",
        1 => "Move vertex of",
        _ if moved == all => "Move",
        _ => "Move vertices of",
    }
}
