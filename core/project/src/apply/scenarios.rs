//! Edits of scenarios and bookmarks.

use core::mem;

use super::EditError;
use super::elements::{at_most, position};
use crate::scenario::{combined, keep_order};
use crate::stored::range::{MOST_BOOKMARKS, MOST_SCENARIOS};
use crate::{
    Bookmark, ChangeKind, Edit, ElementId, LayerId, LayerOverride, Project, Scenario, ScenarioId,
};

impl Project {
    pub(super) fn add_scenario(
        &mut self,
        index: Option<usize>,
        scenario: Scenario,
    ) -> Result<Edit, EditError> {
        at_most("scenarios", self.scenarios.len(), MOST_SCENARIOS)?;
        self.expect_free(&scenario.id)?;
        if let Some(parent) = &scenario.parent {
            self.expect_scenario(parent)?;
        }
        let index = position(index, self.scenarios.len())?;
        let id = scenario.id.clone();
        self.scenarios.insert(index, scenario);
        Ok(Edit::RemoveScenario { id })
    }

    pub(super) fn remove_scenario(&mut self, id: &ScenarioId) -> Result<Edit, EditError> {
        let index = self.expect_scenario(id)?;
        if let Some(child) = self.children(Some(id)).next() {
            return Err(EditError::HasChildren {
                id: id.0.clone(),
                child: child.id.0.clone(),
            });
        }
        let scenario = self.scenarios.remove(index);
        let was_shown = self.scenario.as_ref() == Some(id);
        if was_shown {
            self.scenario.clone_from(&scenario.parent);
        }
        let add = Edit::AddScenario {
            index: Some(index),
            scenario: Box::new(scenario),
        };
        Ok(if was_shown {
            let show = Edit::ShowScenario {
                id: Some(id.clone()),
            };
            Edit::Batch {
                label: String::new(),
                edits: vec![add, show],
            }
        } else {
            add
        })
    }

    pub(super) fn duplicate_scenario(
        &mut self,
        id: &ScenarioId,
        new_id: ScenarioId,
        name: String,
    ) -> Result<Edit, EditError> {
        at_most("scenarios", self.scenarios.len(), MOST_SCENARIOS)?;
        let index = self.expect_scenario(id)?;
        self.expect_free(&new_id)?;
        let copy = Scenario {
            id: new_id.clone(),
            name,
            ..self.scenarios[index].clone()
        };
        self.scenarios.insert(index + 1, copy);
        Ok(Edit::RemoveScenario { id: new_id })
    }

    /// Carries a merge out as a batch of smaller edits, which together have the inverse.
    pub(super) fn merge_scenario(&mut self, id: &ScenarioId) -> Result<Edit, EditError> {
        let index = self.expect_scenario(id)?;
        let merged = self.scenarios[index].clone();
        let mut edits = match &merged.parent {
            None => self.merged_into_base(&merged),
            Some(parent) => self.merged_into(&merged, parent),
        };
        let children = self.children(Some(id));
        edits.extend(children.map(|child| Edit::SetScenarioParent {
            id: child.id.clone(),
            parent: merged.parent.clone(),
        }));
        edits.push(Edit::RemoveScenario { id: id.clone() });
        self.apply_batch(String::new(), edits)
    }

    fn merged_into_base(&self, merged: &Scenario) -> Vec<Edit> {
        let mut edits = Vec::new();
        let scenario = None;
        let mut ids: Vec<&ElementId> = self.elements.iter().map(|e| &e.id).collect();
        for change in &merged.changes {
            let Some(id) = change.element_id() else {
                continue;
            };
            let place = ids.iter().position(|other| *other == id);
            match (&change.kind, place) {
                (
                    ChangeKind::Add { element, index } | ChangeKind::Replace { element, index },
                    None,
                ) => {
                    let index = index.map_or(ids.len(), |index| index.min(ids.len()));
                    ids.insert(index, id);
                    edits.push(Edit::AddElement {
                        scenario: scenario.clone(),
                        index: Some(index),
                        element: element.clone(),
                    });
                }
                (
                    kind @ (ChangeKind::Add { element, .. } | ChangeKind::Replace { element, .. }),
                    Some(place),
                ) => {
                    edits.push(Edit::ReplaceElement {
                        scenario: scenario.clone(),
                        element: element.clone(),
                    });
                    if let ChangeKind::Replace {
                        index: Some(index), ..
                    } = kind
                    {
                        ids.remove(place);
                        let index = (*index).min(ids.len());
                        ids.insert(index, id);
                        edits.push(Edit::MoveElement {
                            scenario: scenario.clone(),
                            id: id.clone(),
                            index,
                        });
                    }
                }
                (ChangeKind::Remove { .. }, Some(place)) => {
                    ids.remove(place);
                    edits.push(Edit::RemoveElement {
                        scenario: scenario.clone(),
                        id: id.clone(),
                    });
                }
                (ChangeKind::Remove { .. }, None) | (ChangeKind::Unknown { .. }, _) => {}
            }
        }
        for layer in &merged.layers {
            if self.layer(&layer.id).is_none() {
                continue;
            }
            let id = || layer.id.clone();
            edits.extend(
                layer
                    .visible
                    .map(|visible| Edit::SetVisible { id: id(), visible }),
            );
            edits.extend(
                layer
                    .opacity
                    .map(|opacity| Edit::SetOpacity { id: id(), opacity }),
            );
        }
        edits
    }

    fn merged_into(&self, merged: &Scenario, parent: &ScenarioId) -> Vec<Edit> {
        let above = self.elements_in(self.parent_of(parent));
        let order: Vec<ElementId> = self
            .elements_in(Some(&merged.id))
            .iter()
            .map(|element| element.id.clone())
            .collect();
        let Some(target) = self.scenario(parent) else {
            return Vec::new();
        };
        let is_above = |id: &ElementId| above.iter().any(|element| element.id == *id);
        let changes = combined(&target.changes, &merged.changes, is_above);
        let mut edits = vec![Edit::SetChanges {
            scenario: parent.clone(),
            changes: keep_order(&above, changes, &order),
        }];
        for layer in &merged.layers {
            let before = target.layers.iter().find(|other| other.id == layer.id);
            edits.push(Edit::SetScenarioLayer {
                scenario: parent.clone(),
                id: layer.id.clone(),
                index: None,
                layer: Some(LayerOverride {
                    visible: layer.visible.or(before.and_then(|b| b.visible)),
                    opacity: layer.opacity.or(before.and_then(|b| b.opacity)),
                    ..layer.clone()
                }),
            });
        }
        edits
    }

    pub(super) fn set_scenario_parent(
        &mut self,
        id: ScenarioId,
        parent: Option<ScenarioId>,
    ) -> Result<Edit, EditError> {
        let index = self.expect_scenario(&id)?;
        if let Some(parent) = &parent {
            self.expect_scenario(parent)?;
            if self.lineage(Some(parent)).iter().any(|s| s.id == id) {
                return Err(EditError::Cycle {
                    id: id.0,
                    parent: parent.0.clone(),
                });
            }
        }
        let parent = mem::replace(&mut self.scenarios[index].parent, parent);
        Ok(Edit::SetScenarioParent { id, parent })
    }

    pub(super) fn set_scenario_layer(
        &mut self,
        scenario: ScenarioId,
        id: LayerId,
        index: Option<usize>,
        layer: Option<LayerOverride>,
    ) -> Result<Edit, EditError> {
        let layers = &mut self.scenario_mut(&scenario)?.layers;
        let before = layers.iter().position(|layer| layer.id == id);
        let last = layers.len() - usize::from(before.is_some());
        let index = position(index.or(before), last)?;
        if layer.is_some() && before.is_none() {
            at_most("layers", layers.len(), crate::stored::range::MOST_LAYERS)?;
        }
        let old = before.map(|before| layers.remove(before));
        if let Some(layer) = layer {
            layers.insert(index, layer);
        }
        Ok(Edit::SetScenarioLayer {
            scenario,
            id,
            index: before,
            layer: old,
        })
    }

    pub(super) fn show_scenario(&mut self, id: Option<ScenarioId>) -> Result<Edit, EditError> {
        if let Some(id) = &id {
            self.expect_scenario(id)?;
        }
        let id = mem::replace(&mut self.scenario, id);
        Ok(Edit::ShowScenario { id })
    }

    pub(super) fn add_bookmark(
        &mut self,
        index: Option<usize>,
        bookmark: Bookmark,
    ) -> Result<Edit, EditError> {
        at_most("bookmarks", self.bookmarks.len(), MOST_BOOKMARKS)?;
        let index = position(index, self.bookmarks.len())?;
        self.bookmarks.insert(index, bookmark);
        Ok(Edit::RemoveBookmark { index })
    }

    pub(super) fn expect_bookmark(&mut self, index: usize) -> Result<&mut Bookmark, EditError> {
        let count = self.bookmarks.len();
        self.bookmarks
            .get_mut(index)
            .ok_or(EditError::NoSuchBookmark { count, index })
    }

    /// Where a scenario is in the list.
    pub(super) fn expect_scenario(&self, id: &ScenarioId) -> Result<usize, EditError> {
        self.scenario_index(id)
            .ok_or_else(|| EditError::NoSuchScenario { id: id.0.clone() })
    }

    pub(super) fn scenario_mut(&mut self, id: &ScenarioId) -> Result<&mut Scenario, EditError> {
        let index = self.expect_scenario(id)?;
        Ok(&mut self.scenarios[index])
    }

    fn expect_free(&self, id: &ScenarioId) -> Result<(), EditError> {
        if self.scenario(id).is_some() {
            return Err(EditError::IdInUse { id: id.0.clone() });
        }
        Ok(())
    }
}
