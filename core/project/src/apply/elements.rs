//! Edits of planning elements, in the base and in scenarios.
//!
//! In a scenario every such edit comes down to what the scenario changes about the element, so that
//! the base stays as it is and one inverse serves all.

use core::mem;
use std::sync::Arc;

use super::EditError;
use crate::scenario::{keep_order, resolve};
use crate::stored::range::MOST_ELEMENTS;
use crate::{Change, ChangeKind, Edit, Element, ElementId, Project, Scenario, ScenarioId};

impl Project {
    pub(super) fn add_element(
        &mut self,
        scenario: Option<ScenarioId>,
        index: Option<usize>,
        element: Arc<Element>,
    ) -> Result<Edit, EditError> {
        if let Some(scenario) = &scenario {
            self.expect_scenario(scenario)?;
        }
        if self.element_in(scenario.as_ref(), &element.id).is_some() {
            return Err(EditError::IdInUse {
                id: element.id.0.clone(),
            });
        }
        let Some(scenario) = scenario else {
            at_most("elements", self.elements.len(), MOST_ELEMENTS)?;
            let index = position(index, self.elements.len())?;
            let id = element.id.clone();
            self.elements.insert(index, element);
            return Ok(Edit::RemoveElement { scenario: None, id });
        };
        let last = self.elements_in(Some(&scenario)).len();
        let on_top = index.is_none();
        let index = position(index, last)?;
        let id = element.id.clone();
        // One that the parent has was taken away here: it comes back as a replacement.
        let kind = if self.element_in(self.parent_of(&scenario), &id).is_some() {
            let index = Some(index);
            ChangeKind::Replace { element, index }
        } else {
            let index = (!on_top).then_some(index);
            ChangeKind::Add { element, index }
        };
        let end = self.changes_besides(&scenario, &id);
        self.set_change(scenario, id, Some(end), Some(kind.into()))
    }

    pub(super) fn remove_element(
        &mut self,
        scenario: Option<ScenarioId>,
        id: ElementId,
    ) -> Result<Edit, EditError> {
        let Some(scenario) = scenario else {
            let index = self.base_element(&id)?;
            let element = self.elements.remove(index);
            return Ok(Edit::AddElement {
                scenario: None,
                index: Some(index),
                element,
            });
        };
        self.expect_element(&scenario, &id)?;
        let mut order = self.ids_in(&scenario);
        order.retain(|other| *other != id);
        let mut changes = self.scenario_mut(&scenario)?.changes.clone();
        let is_parents = self.element_in(self.parent_of(&scenario), &id).is_some();
        let place = changes.iter().position(|c| c.element_id() == Some(&id));
        match (place, is_parents) {
            (Some(place), true) => {
                changes[place].kind = ChangeKind::Remove { id: id.clone() };
            }
            (Some(place), false) => drop(changes.remove(place)),
            (None, _) => changes.push(ChangeKind::Remove { id: id.clone() }.into()),
        }
        self.put_changes(scenario, id, changes, &order)
    }

    /// Puts an element in the place of the one with its id.
    pub(super) fn replace_element(
        &mut self,
        scenario: Option<ScenarioId>,
        element: Arc<Element>,
    ) -> Result<Edit, EditError> {
        let Some(scenario) = scenario else {
            let index = self.base_element(&element.id)?;
            let element = mem::replace(&mut self.elements[index], element);
            return Ok(Edit::ReplaceElement {
                scenario: None,
                element,
            });
        };
        self.expect_element(&scenario, &element.id)?;
        let id = element.id.clone();
        let existing = self
            .scenario(&scenario)
            .and_then(|scenario| scenario.change(&id));
        let change = match existing {
            None => ChangeKind::Replace {
                element,
                index: None,
            }
            .into(),
            Some((_, change)) => {
                let kind = match &change.kind {
                    ChangeKind::Add { index, .. } => ChangeKind::Add {
                        element,
                        index: *index,
                    },
                    ChangeKind::Replace { index, .. } => ChangeKind::Replace {
                        element,
                        index: *index,
                    },
                    ChangeKind::Remove { .. } | ChangeKind::Unknown { .. } => ChangeKind::Replace {
                        element,
                        index: None,
                    },
                };
                let extra = change.extra.clone();
                Change { kind, extra }
            }
        };
        self.set_change(scenario, id, None, Some(change))
    }

    pub(super) fn move_element(
        &mut self,
        scenario: Option<ScenarioId>,
        id: ElementId,
        index: usize,
    ) -> Result<Edit, EditError> {
        let Some(scenario) = scenario else {
            let before = self.base_element(&id)?;
            position(Some(index), self.elements.len() - 1)?;
            let element = self.elements.remove(before);
            self.elements.insert(index, element);
            return Ok(Edit::MoveElement {
                scenario: None,
                id,
                index: before,
            });
        };
        let element = self.expect_element(&scenario, &id)?;
        let mut order = self.ids_in(&scenario);
        position(Some(index), order.len() - 1)?;
        order.retain(|other| *other != id);
        order.insert(index, id.clone());
        let mut changes = self.scenario_mut(&scenario)?.changes.clone();
        let place = changes.iter().position(|c| c.element_id() == Some(&id));
        let mut change: Change = match place {
            Some(place) => changes.remove(place),
            None => ChangeKind::Replace {
                element,
                index: None,
            }
            .into(),
        };
        if let ChangeKind::Add { index: slot, .. } | ChangeKind::Replace { index: slot, .. } =
            &mut change.kind
        {
            *slot = Some(index);
        }
        changes.push(change);
        self.put_changes(scenario, id, changes, &order)
    }

    /// Changes one element in place, or by a replacement in a scenario. `swap` puts a value into the
    /// element and gives the edit that puts the old one back.
    pub(super) fn edit_element(
        &mut self,
        scenario: Option<ScenarioId>,
        id: ElementId,
        swap: impl FnOnce(&mut Element, ElementId) -> Edit,
    ) -> Result<Edit, EditError> {
        if let Some(scenario) = scenario {
            let mut element = self.expect_element(&scenario, &id)?;
            swap(Arc::make_mut(&mut element), id);
            return self.replace_element(Some(scenario), element);
        }
        let index = self.base_element(&id)?;
        Ok(swap(Arc::make_mut(&mut self.elements[index]), id))
    }

    pub(super) fn set_change(
        &mut self,
        scenario: ScenarioId,
        id: ElementId,
        index: Option<usize>,
        change: Option<Change>,
    ) -> Result<Edit, EditError> {
        let changes = &mut self.scenario_mut(&scenario)?.changes;
        let before = changes.iter().position(|c| c.element_id() == Some(&id));
        let last = changes.len() - usize::from(before.is_some());
        let index = position(index.or(before), last)?;
        if change.is_some() && before.is_none() {
            at_most("changes", changes.len(), MOST_ELEMENTS)?;
        }
        let old = before.map(|before| changes.remove(before));
        if let Some(change) = change {
            changes.insert(index, change);
        }
        Ok(Edit::SetChange {
            scenario,
            id,
            index: before,
            change: old,
        })
    }

    pub(super) fn set_changes(
        &mut self,
        scenario: ScenarioId,
        changes: Vec<Change>,
    ) -> Result<Edit, EditError> {
        let slot = &mut self.scenario_mut(&scenario)?.changes;
        let changes = mem::replace(slot, changes);
        Ok(Edit::SetChanges { scenario, changes })
    }

    /// Sets what a scenario changes, of which only that of `id` is other than before unless the order
    /// demands more.
    fn put_changes(
        &mut self,
        scenario: ScenarioId,
        id: ElementId,
        changes: Vec<Change>,
        order: &[ElementId],
    ) -> Result<Edit, EditError> {
        at_most("changes", changes.len(), MOST_ELEMENTS + 1)?;
        let parents = self.elements_in(self.parent_of(&scenario));
        let is_kept = {
            let elements = resolve(parents.clone(), &changes);
            elements.iter().map(|e| &e.id).eq(order)
        };
        if is_kept {
            let place = changes.iter().position(|c| c.element_id() == Some(&id));
            let change = place.map(|place| changes[place].clone());
            return self.set_change(scenario, id, place, change);
        }
        let changes = keep_order(&parents, changes, order);
        self.set_changes(scenario, changes)
    }

    /// The parent of a scenario; `None` for the base.
    pub(super) fn parent_of(&self, scenario: &ScenarioId) -> Option<&ScenarioId> {
        self.scenario(scenario)?.parent.as_ref()
    }

    fn ids_in(&self, scenario: &ScenarioId) -> Vec<ElementId> {
        let elements = self.elements_in(Some(scenario));
        elements.iter().map(|element| element.id.clone()).collect()
    }

    /// How many changes a scenario has without that of one element.
    fn changes_besides(&self, scenario: &ScenarioId, id: &ElementId) -> usize {
        let others = |scenario: &Scenario| {
            let changes = scenario.changes.iter();
            changes.filter(|c| c.element_id() != Some(id)).count()
        };
        self.scenario(scenario).map_or(0, others)
    }

    fn base_element(&self, id: &ElementId) -> Result<usize, EditError> {
        self.element_index(id)
            .ok_or_else(|| EditError::NoSuchElement {
                id: id.0.clone(),
                place: "the base".to_owned(),
            })
    }

    fn expect_element(
        &self,
        scenario: &ScenarioId,
        id: &ElementId,
    ) -> Result<Arc<Element>, EditError> {
        self.expect_scenario(scenario)?;
        let element = self.element_in(Some(scenario), id);
        element.cloned().ok_or_else(|| EditError::NoSuchElement {
            id: id.0.clone(),
            place: format!("scenario {:?}", scenario.0),
        })
    }
}

/// A position that fits, `last` where none is given.
pub(super) fn position(index: Option<usize>, last: usize) -> Result<usize, EditError> {
    match index {
        Some(index) if index > last => Err(EditError::Position { last, index }),
        Some(index) => Ok(index),
        None => Ok(last),
    }
}

/// An error where one more would be too many.
pub(super) fn at_most(what: &'static str, count: usize, most: usize) -> Result<(), EditError> {
    if count >= most {
        return Err(EditError::TooMany { what, most });
    }
    Ok(())
}
