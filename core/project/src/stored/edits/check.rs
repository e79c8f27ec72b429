//! Checks of edits by the reader's rules, and edits without their geometry.

use std::borrow::Cow;
use std::sync::Arc;

use super::StoredEdit;
use crate::stored::convert::{Twin as _, check_change, check_element, unknown_is_unknown};
use crate::stored::fault::{At, Fault};
use crate::stored::range;
use crate::{Change, ChangeKind, Edit, Element, Vertices};

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
