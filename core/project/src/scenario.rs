//! Scenarios: named deltas on the base or on each other, and what they make of it.
//!
//! A scenario changes each element at most once: it adds it, puts another in its place, or takes it
//! away. What an element is in a scenario follows from the scenario's ancestors, the base first.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use crate::{Element, ElementId, Extra, Layer, LayerId, Project, ScenarioId};

/// A named delta.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Stable id, unique in the project.
    pub id: ScenarioId,
    /// What people call it; up to 1000 bytes.
    pub name: String,
    /// The scenario on which it is based. `None`: the base. Parents form a tree.
    pub parent: Option<ScenarioId>,
    /// What it changes, in this order, each element at most once.
    pub changes: Vec<Change>,
    /// Layers that it shows otherwise, each at most once.
    pub layers: Vec<LayerOverride>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Scenario {
    /// A scenario that changes nothing yet.
    pub fn new(id: ScenarioId, name: impl Into<String>, parent: Option<ScenarioId>) -> Self {
        Self {
            id,
            name: name.into(),
            parent,
            changes: Vec::new(),
            layers: Vec::new(),
            extra: Extra::new(),
        }
    }

    /// What it changes about an element, and where that stands in [`Scenario::changes`].
    pub fn change(&self, id: &ElementId) -> Option<(usize, &Change)> {
        let mut changes = self.changes.iter().enumerate();
        changes.find(|(_, change)| change.element_id() == Some(id))
    }
}

/// What a scenario changes about one element.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// What.
    pub kind: ChangeKind,
    /// Unknown fields of the file; for [`ChangeKind::Unknown`] all of the change's own fields.
    pub extra: Extra,
}

/// A kind of change.
#[derive(Clone, Debug, PartialEq)]
pub enum ChangeKind {
    /// Adds an element. One with the id of an element that is already there takes its place.
    Add {
        /// The element.
        element: Arc<Element>,
        /// Position from the bottom among the elements so far. `None`: on top.
        index: Option<usize>,
    },
    /// Puts an element in the place of the one with its id. Where there is none (it was removed from
    /// the base since), it is added: work in a scenario is not lost by an edit elsewhere.
    Replace {
        /// The element.
        element: Arc<Element>,
        /// New position from the bottom, the old one taken out first. `None`: where the old one was.
        index: Option<usize>,
    },
    /// Takes an element away.
    Remove {
        /// Which; one that is not there is not missed.
        id: ElementId,
    },
    /// A kind that a newer program made: kept, without effect.
    Unknown {
        /// Its name in the file.
        name: String,
    },
}

impl From<ChangeKind> for Change {
    fn from(kind: ChangeKind) -> Self {
        Self {
            kind,
            extra: Extra::new(),
        }
    }
}

impl Change {
    /// Which element it changes; `None` for unknown kinds.
    pub fn element_id(&self) -> Option<&ElementId> {
        match &self.kind {
            ChangeKind::Add { element, .. } | ChangeKind::Replace { element, .. } => {
                Some(&element.id)
            }
            ChangeKind::Remove { id } => Some(id),
            ChangeKind::Unknown { .. } => None,
        }
    }

    /// The element as the change makes it; `None` where it takes it away.
    pub fn element(&self) -> Option<&Arc<Element>> {
        match &self.kind {
            ChangeKind::Add { element, .. } | ChangeKind::Replace { element, .. } => Some(element),
            ChangeKind::Remove { .. } | ChangeKind::Unknown { .. } => None,
        }
    }
}

/// How a scenario shows a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerOverride {
    /// Which layer; one that is not there is not missed.
    pub id: LayerId,
    /// Whether it takes part. `None`: as in the parent.
    pub visible: Option<bool>,
    /// Its opacity, 0 to 1. `None`: as in the parent.
    pub opacity: Option<f64>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Project {
    /// The scenario with this id.
    pub fn scenario(&self, id: &ScenarioId) -> Option<&Scenario> {
        self.scenarios.iter().find(|scenario| scenario.id == *id)
    }

    /// Position of the scenario with this id in the list.
    pub fn scenario_index(&self, id: &ScenarioId) -> Option<usize> {
        self.scenarios
            .iter()
            .position(|scenario| scenario.id == *id)
    }

    /// The scenario that people call by this name, or else the one with this id, for command lines.
    pub fn scenario_called(&self, text: &str) -> Option<&Scenario> {
        let named = self.scenarios.iter().find(|s| s.name == text);
        named.or_else(|| self.scenarios.iter().find(|s| s.id.0 == text))
    }

    /// A scenario and its ancestors, the root of the tree first; empty for the base and for an id
    /// that no scenario has.
    pub fn lineage(&self, scenario: Option<&ScenarioId>) -> Vec<&Scenario> {
        let mut line = Vec::new();
        let mut next = scenario.and_then(|id| self.scenario(id));
        while let Some(scenario) = next {
            line.push(scenario);
            // A tree is never deeper than it has nodes; files and edits are checked, but a loop here
            // would be for ever.
            if line.len() > self.scenarios.len() {
                break;
            }
            next = scenario.parent.as_ref().and_then(|id| self.scenario(id));
        }
        line.reverse();
        line
    }

    /// Scenarios whose parent this is, in the order of the list; `None` gives the roots.
    pub fn children<'a>(
        &'a self,
        parent: Option<&'a ScenarioId>,
    ) -> impl Iterator<Item = &'a Scenario> {
        self.scenarios
            .iter()
            .filter(move |scenario| scenario.parent.as_ref() == parent)
    }

    /// All elements of a scenario (`None`: the base), the bottom one first; later ones win. Elements
    /// that the scenario does not change are shared with the base. Invisible and unknown ones are
    /// among them. An id that no scenario has gives the base.
    pub fn elements_in(&self, scenario: Option<&ScenarioId>) -> Vec<Arc<Element>> {
        let lineage = self.lineage(scenario);
        let mut elements = self.elements.clone();
        for scenario in lineage {
            elements = resolve(elements, &scenario.changes);
        }
        elements
    }

    /// One element as a scenario (`None`: the base) has it.
    pub fn element_in(
        &self,
        scenario: Option<&ScenarioId>,
        id: &ElementId,
    ) -> Option<&Arc<Element>> {
        for scenario in self.lineage(scenario).into_iter().rev() {
            if let Some((_, change)) = scenario.change(id) {
                return change.element();
            }
        }
        self.elements.iter().find(|element| element.id == *id)
    }

    /// All layers as a scenario (`None`: the base) shows them.
    pub fn layers_in(&self, scenario: Option<&ScenarioId>) -> Cow<'_, [Layer]> {
        let mut layers = Cow::Borrowed(self.layers.as_slice());
        for scenario in self.lineage(scenario) {
            for change in &scenario.layers {
                let Some(index) = self.layer_index(&change.id) else {
                    continue;
                };
                let layer = &mut layers.to_mut()[index];
                layer.visible = change.visible.unwrap_or(layer.visible);
                layer.opacity = change.opacity.unwrap_or(layer.opacity);
            }
        }
        layers
    }
}

/// Elements while a scenario's changes are carried out.
struct Resolving {
    /// `None` where one was taken away, so that places stay valid.
    elements: Vec<Option<Arc<Element>>>,
    /// Where elements are, while that is known; a few changes are found faster by looking.
    places: Option<HashMap<ElementId, usize>>,
}

impl Resolving {
    fn place(&self, id: &ElementId) -> Option<usize> {
        match &self.places {
            Some(places) => places.get(id).copied(),
            None => self
                .elements
                .iter()
                .position(|element| element.as_ref().is_some_and(|e| e.id == *id)),
        }
    }

    fn insert(&mut self, element: &Arc<Element>, index: Option<usize>) {
        if let Some(index) = index {
            self.elements.retain(Option::is_some);
            self.places = None;
            let index = index.min(self.elements.len());
            self.elements.insert(index, Some(Arc::clone(element)));
        } else {
            if let Some(places) = &mut self.places {
                places.insert(element.id.clone(), self.elements.len());
            }
            self.elements.push(Some(Arc::clone(element)));
        }
    }

    fn remove(&mut self, place: usize) {
        let element = self.elements[place].take();
        if let (Some(places), Some(element)) = (&mut self.places, element) {
            places.remove(&element.id);
        }
    }
}

/// Carries changes out that keep the order, in one pass over the elements.
fn resolve_in_place(elements: Vec<Arc<Element>>, changes: &[Change]) -> Vec<Arc<Element>> {
    let mut left: HashMap<&ElementId, &Change> = changes
        .iter()
        .filter_map(|change| Some((change.element_id()?, change)))
        .collect();
    let mut resolved = Vec::with_capacity(elements.len() + changes.len());
    for element in elements {
        match left.remove(&element.id) {
            None => resolved.push(element),
            Some(change) => resolved.extend(change.element().cloned()),
        }
    }
    let added = changes.iter().filter_map(Change::element);
    resolved.extend(added.filter(|e| left.contains_key(&e.id)).cloned());
    resolved
}

/// Carries the changes of one scenario out, each element at most once.
pub(crate) fn resolve(elements: Vec<Arc<Element>>, changes: &[Change]) -> Vec<Arc<Element>> {
    const FEW: usize = 4;
    let has_place = |change: &Change| {
        matches!(
            change.kind,
            ChangeKind::Add { index: Some(_), .. } | ChangeKind::Replace { index: Some(_), .. }
        )
    };
    if !changes.iter().any(has_place) {
        return resolve_in_place(elements, changes);
    }
    let places = (changes.len() > FEW).then(|| {
        let all = elements.iter().enumerate();
        all.map(|(place, e)| (e.id.clone(), place)).collect()
    });
    let mut state = Resolving {
        elements: elements.into_iter().map(Some).collect(),
        places,
    };
    for change in changes {
        let place = change.element_id().and_then(|id| state.place(id));
        match (&change.kind, place) {
            (
                ChangeKind::Add { element, .. }
                | ChangeKind::Replace {
                    element,
                    index: None,
                },
                Some(place),
            ) => state.elements[place] = Some(Arc::clone(element)),
            (ChangeKind::Replace { element, index }, Some(place)) => {
                state.remove(place);
                state.insert(element, *index);
            }
            (ChangeKind::Add { element, index } | ChangeKind::Replace { element, index }, None) => {
                state.insert(element, *index);
            }
            (ChangeKind::Remove { .. }, Some(place)) => state.remove(place),
            (ChangeKind::Remove { .. }, None) | (ChangeKind::Unknown { .. }, _) => {}
        }
    }
    state.elements.into_iter().flatten().collect()
}

/// The changes of a scenario and those of another that is based on it, as changes of one: each
/// element at most once. `is_above` says which elements the first scenario's parent has. The order of
/// elements may differ from that of one after the other: see [`keep_order`].
pub(crate) fn combined(
    first: &[Change],
    second: &[Change],
    is_above: impl Fn(&ElementId) -> bool,
) -> Vec<Change> {
    let mut all = first.to_vec();
    let mut places: HashMap<ElementId, usize> = all
        .iter()
        .enumerate()
        .filter_map(|(place, change)| Some((change.element_id()?.clone(), place)))
        .collect();
    for change in second {
        let place = change.element_id().and_then(|id| places.get(id).copied());
        let Some(place) = place else {
            if let Some(id) = change.element_id() {
                places.insert(id.clone(), all.len());
            }
            all.push(change.clone());
            continue;
        };
        let slot = &mut all[place];
        match &change.kind {
            ChangeKind::Add { element, index } | ChangeKind::Replace { element, index } => {
                match &mut slot.kind {
                    ChangeKind::Add {
                        element: before,
                        index: slot,
                    }
                    | ChangeKind::Replace {
                        element: before,
                        index: slot,
                    } => {
                        *before = Arc::clone(element);
                        if matches!(change.kind, ChangeKind::Replace { .. }) {
                            *slot = index.or(*slot);
                        }
                    }
                    // It came back: where it was before does not count any more.
                    kind @ (ChangeKind::Remove { .. } | ChangeKind::Unknown { .. }) => {
                        *kind = ChangeKind::Replace {
                            element: Arc::clone(element),
                            index: Some(index.unwrap_or(usize::MAX)),
                        };
                    }
                }
                slot.extra.extend(change.extra.clone());
            }
            ChangeKind::Remove { id } => slot.kind = ChangeKind::Remove { id: id.clone() },
            ChangeKind::Unknown { .. } => {}
        }
    }
    // What the parent does not have need not be taken away.
    all.retain(|change| match &change.kind {
        ChangeKind::Remove { id } => is_above(id),
        ChangeKind::Add { .. } | ChangeKind::Replace { .. } | ChangeKind::Unknown { .. } => true,
    });
    all
}

/// Changes with the same elements whose result has the elements in this order. `changes` must give
/// the elements of `order`, and leave those that it does not touch in their order.
pub(crate) fn keep_order(
    parents: &[Arc<Element>],
    changes: Vec<Change>,
    order: &[ElementId],
) -> Vec<Change> {
    let gives = |changes: &[Change]| {
        let elements = resolve(parents.to_vec(), changes);
        elements.iter().map(|e| &e.id).eq(order)
    };
    if gives(&changes) {
        return changes;
    }
    // Those with a place of their own, where that does: additions on top keep having none.
    let placed = in_order(parents, &changes, order, |index| index.is_some());
    if gives(&placed) {
        return placed;
    }
    in_order(parents, &changes, order, |_| true)
}

/// The changes with new places for those that `moves` names, each behind the one that it should
/// follow. Going up the order, what a change follows is always in its place already.
fn in_order(
    parents: &[Arc<Element>],
    changes: &[Change],
    order: &[ElementId],
    moves: impl Fn(Option<usize>) -> bool,
) -> Vec<Change> {
    let index_of = |change: &Change| match &change.kind {
        ChangeKind::Add { index, .. } | ChangeKind::Replace { index, .. } => Some(*index),
        ChangeKind::Remove { .. } | ChangeKind::Unknown { .. } => None,
    };
    let (mut moved, mut all): (Vec<Change>, Vec<Change>) = changes
        .iter()
        .cloned()
        .partition(|change| index_of(change).is_some_and(&moves));
    let places: HashMap<&ElementId, usize> =
        order.iter().enumerate().map(|(i, id)| (id, i)).collect();
    let place = |change: &Change| {
        let id = change.element_id();
        id.and_then(|id| places.get(id))
            .copied()
            .unwrap_or(usize::MAX)
    };
    moved.sort_by_key(place);
    let kept = resolve(parents.to_vec(), &all);
    let mut ids: Vec<ElementId> = kept.iter().map(|element| element.id.clone()).collect();
    for mut change in moved {
        let Some(id) = change.element_id().cloned() else {
            continue;
        };
        ids.retain(|other| *other != id);
        let wanted = place(&change);
        let before = wanted.checked_sub(1).and_then(|before| order.get(before));
        let behind = before.and_then(|before| ids.iter().position(|other| other == before));
        let index = behind.map_or(0, |behind| behind + 1);
        ids.insert(index, id);
        if let ChangeKind::Add { index: slot, .. } | ChangeKind::Replace { index: slot, .. } =
            &mut change.kind
        {
            *slot = Some(index);
        }
        all.push(change);
    }
    all
}
