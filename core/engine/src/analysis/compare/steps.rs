//! From one version's elements to the other's, one after the other.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use relievo_project::{Element, ElementId};

use super::notes::same_ground;

/// What becomes of an element from one version to the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Only the second version has it.
    Added,
    /// Only the first version has it.
    Removed,
    /// Both have it, differently.
    Changed,
}

impl Step {
    /// `added`, `removed` or `changed`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Added => "added",
            Self::Removed => "removed",
            Self::Changed => "changed",
        }
    }
}

/// An element of either version.
pub(super) struct Entry {
    pub(super) before: Option<Arc<Element>>,
    pub(super) after: Option<Arc<Element>>,
    /// `None` where both are equally shaped.
    pub(super) step: Option<Step>,
}

/// All elements of both versions in the order of the second one; those that only the first one has
/// follow what they followed there.
pub(super) fn steps(from: &[Arc<Element>], to: &[Arc<Element>]) -> Vec<Entry> {
    let before: HashMap<&ElementId, &Arc<Element>> = from.iter().map(|e| (&e.id, e)).collect();
    let kept: HashSet<&ElementId> = to.iter().map(|e| &e.id).collect();
    // What goes, by what it follows.
    let mut behind: HashMap<Option<&ElementId>, Vec<&Arc<Element>>> = HashMap::new();
    let mut last = None;
    for element in from {
        if kept.contains(&element.id) {
            last = Some(&element.id);
        } else {
            behind.entry(last).or_default().push(element);
        }
    }
    let gone = |id: Option<&ElementId>| -> Vec<Entry> {
        let gone = behind.get(&id).into_iter().flatten();
        gone.map(|element| Entry {
            before: Some(Arc::clone(element)),
            after: None,
            step: Some(Step::Removed),
        })
        .collect()
    };
    let mut order: Vec<Entry> = gone(None);
    for element in to {
        let before = before.get(&element.id).map(|e| Arc::clone(e));
        let step = match &before {
            None => Some(Step::Added),
            Some(before) if same_ground(before, element) => None,
            Some(_) => Some(Step::Changed),
        };
        order.push(Entry {
            before,
            after: Some(Arc::clone(element)),
            step,
        });
        order.extend(gone(Some(&element.id)));
    }
    order
}

/// The elements after the first `done` entries have become what they become, with their indices.
pub(super) fn state(order: &[Entry], done: usize) -> impl Iterator<Item = (usize, &Arc<Element>)> {
    let state = order.iter().enumerate().map(move |(index, entry)| {
        let element = if index < done {
            &entry.after
        } else {
            &entry.before
        };
        Some((index, element.as_ref()?))
    });
    state.flatten()
}
