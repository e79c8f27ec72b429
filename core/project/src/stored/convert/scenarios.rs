//! Scenarios and bookmarks.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::elements::{at_most, element_id};
use super::{Twin, layer_id, layer_name, unless_default};
use crate::stored::fault::{At, Fault, quote};
use crate::stored::range;
use crate::stored::scenarios as stored;
use crate::stored::value::With;
use crate::{
    Bookmark, CameraSettings, Change, ChangeKind, Element, LayerOverride, Project, Scenario,
    ScenarioId,
};

/// A valid id.
pub(crate) fn scenario_id(id: String, at: &At<'_>) -> Result<ScenarioId, Fault> {
    if ScenarioId::is_valid(&id) {
        Ok(ScenarioId(id))
    } else {
        Err(at.fault("1 to 64 letters, digits, '-', '_' or '.'", quote(&id)))
    }
}

/// All scenarios; their parents form a tree.
pub(crate) fn all(
    stored: Option<Vec<With<stored::Scenario>>>,
    at: &At<'_>,
) -> Result<Vec<Scenario>, Fault> {
    let stored = stored.unwrap_or_default();
    at_most(stored.len(), range::MOST_SCENARIOS, "scenarios", at)?;
    let scenarios = stored.into_iter().enumerate();
    let scenarios: Vec<Scenario> = scenarios
        .map(|(i, scenario)| Scenario::from_stored(scenario, &At::Element(at, i)))
        .collect::<Result<_, _>>()?;
    let mut places = BTreeMap::new();
    for (i, scenario) in scenarios.iter().enumerate() {
        if let Some(first) = places.insert(&scenario.id, i) {
            let found = format!("{:?} again, as in scenario {first}", scenario.id.0);
            return Err(At::Member(&At::Element(at, i), "id").fault("an id of its own", found));
        }
    }
    check_tree(&scenarios, at)?;
    Ok(scenarios)
}

/// Parents that exist and do not go round in a circle.
fn check_tree(scenarios: &[Scenario], at: &At<'_>) -> Result<(), Fault> {
    let parents: BTreeMap<&ScenarioId, Option<&ScenarioId>> = scenarios
        .iter()
        .map(|scenario| (&scenario.id, scenario.parent.as_ref()))
        .collect();
    for (i, scenario) in scenarios.iter().enumerate() {
        let element = At::Element(at, i);
        let place = At::Member(&element, "parent");
        let mut seen = BTreeSet::from([&scenario.id]);
        let mut next = scenario.parent.as_ref();
        while let Some(parent) = next {
            let Some(above) = parents.get(parent) else {
                return Err(place.fault("the id of a scenario", quote(&parent.0)));
            };
            if !seen.insert(parent) {
                let found = format!("{} among its own ancestors", quote(&parent.0));
                return Err(place.fault("a tree of scenarios", found));
            }
            next = *above;
        }
    }
    Ok(())
}

/// The scenario that is shown.
pub(crate) fn shown(
    id: Option<String>,
    project: &Project,
    at: &At<'_>,
) -> Result<Option<ScenarioId>, Fault> {
    let Some(id) = id else { return Ok(None) };
    let id = scenario_id(id, at)?;
    if project.scenario(&id).is_none() {
        return Err(at.fault("the id of a scenario", quote(&id.0)));
    }
    Ok(Some(id))
}

impl Twin for Scenario {
    type Stored = With<stored::Scenario>;

    fn from_stored(scenario: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = scenario;
        let id = scenario_id(fields.id, &At::Member(at, "id"))?;
        let name = match fields.name {
            Some(name) => layer_name(name, &At::Member(at, "name"))?,
            None => id.0.clone(),
        };
        let parent = fields
            .parent
            .map(|parent| scenario_id(parent, &At::Member(at, "parent")))
            .transpose()?;
        Ok(Self {
            id,
            name,
            parent,
            changes: changes(fields.changes, &At::Member(at, "changes"))?,
            layers: layers(fields.layers, &At::Member(at, "layers"))?,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Scenario {
                id: self.id.0.clone(),
                name: unless_default(self.name.clone(), &self.id.0),
                parent: self.parent.as_ref().map(|id| id.0.clone()),
                changes: super::unless_empty(self.changes.iter().map(Twin::to_stored).collect()),
                layers: super::unless_empty(self.layers.iter().map(Twin::to_stored).collect()),
            },
            extra: self.extra.clone(),
        }
    }
}

/// What a scenario changes, each element at most once.
pub(crate) fn changes(
    stored: Option<Vec<stored::Change>>,
    at: &At<'_>,
) -> Result<Vec<Change>, Fault> {
    let stored = stored.unwrap_or_default();
    at_most(stored.len(), range::MOST_ELEMENTS, "changes", at)?;
    let mut places = BTreeMap::new();
    let mut changes = Vec::with_capacity(stored.len());
    for (i, change) in stored.into_iter().enumerate() {
        let place = At::Element(at, i);
        let change = Change::from_stored(change, &place)?;
        let first = change
            .element_id()
            .and_then(|id| places.insert(id.clone(), i));
        if let (Some(first), Some(id)) = (first, change.element_id()) {
            let found = format!("{:?} again, as in change {first}", id.0);
            return Err(place.fault("one change of an element", found));
        }
        changes.push(change);
    }
    Ok(changes)
}

fn layers(
    stored: Option<Vec<With<stored::LayerOverride>>>,
    at: &At<'_>,
) -> Result<Vec<LayerOverride>, Fault> {
    let stored = stored.unwrap_or_default();
    at_most(stored.len(), range::MOST_LAYERS, "layers", at)?;
    let mut places = BTreeMap::new();
    let mut layers = Vec::with_capacity(stored.len());
    for (i, layer) in stored.into_iter().enumerate() {
        let place = At::Element(at, i);
        let layer = LayerOverride::from_stored(layer, &place)?;
        if let Some(first) = places.insert(layer.id.clone(), i) {
            let found = format!("{:?} again, as in layer {first}", layer.id.0);
            return Err(At::Member(&place, "id").fault("an id of its own", found));
        }
        layers.push(layer);
    }
    Ok(layers)
}

impl Twin for LayerOverride {
    type Stored = With<stored::LayerOverride>;

    fn from_stored(layer: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            id: layer_id(layer.fields.id, &At::Member(at, "id"))?,
            visible: layer.fields.visible,
            opacity: layer.fields.opacity,
            extra: layer.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::LayerOverride {
                id: self.id.0.clone(),
                visible: self.visible,
                opacity: self.opacity,
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Change {
    type Stored = stored::Change;

    fn from_stored(change: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        use stored::Changes;
        let element =
            |element| Element::from_stored(element, &At::Member(at, "element")).map(Arc::new);
        let kind = match change.kind {
            Changes::AddChange(c) => ChangeKind::Add {
                element: element(c.element)?,
                index: c.index.map(|i| i as usize),
            },
            Changes::ReplaceChange(c) => ChangeKind::Replace {
                element: element(c.element)?,
                index: c.index.map(|i| i as usize),
            },
            Changes::RemoveChange(c) => ChangeKind::Remove {
                id: element_id(c.id, &At::Member(at, "id"))?,
            },
            Changes::Unknown(name) => ChangeKind::Unknown { name },
        };
        Ok(Self {
            kind,
            extra: change.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::Changes;
        let position = |index: &Option<usize>| index.map(super::position);
        let kind = match &self.kind {
            ChangeKind::Add { element, index } => Changes::AddChange(stored::AddChange {
                index: position(index),
                element: element.to_stored(),
            }),
            ChangeKind::Replace { element, index } => {
                Changes::ReplaceChange(stored::ReplaceChange {
                    index: position(index),
                    element: element.to_stored(),
                })
            }
            ChangeKind::Remove { id } => {
                Changes::RemoveChange(stored::RemoveChange { id: id.0.clone() })
            }
            ChangeKind::Unknown { name } => Changes::Unknown(name.clone()),
        };
        stored::Change {
            kind,
            extra: self.extra.clone(),
        }
    }
}

/// All bookmarks.
pub(crate) fn bookmarks(
    stored: Option<Vec<With<stored::Bookmark>>>,
    at: &At<'_>,
) -> Result<Vec<Bookmark>, Fault> {
    let stored = stored.unwrap_or_default();
    at_most(stored.len(), range::MOST_BOOKMARKS, "bookmarks", at)?;
    let bookmarks = stored.into_iter().enumerate();
    bookmarks
        .map(|(i, bookmark)| Bookmark::from_stored(bookmark, &At::Element(at, i)))
        .collect()
}

impl Twin for Bookmark {
    type Stored = With<stored::Bookmark>;

    fn from_stored(bookmark: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = bookmark;
        Ok(Self {
            name: layer_name(fields.name, &At::Member(at, "name"))?,
            camera: CameraSettings::from_stored(fields.camera, &At::Member(at, "camera"))?,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::Bookmark {
                name: self.name.clone(),
                camera: self.camera.to_stored(),
            },
            extra: self.extra.clone(),
        }
    }
}

/// Checks what the detour through JSON without vertices does not: vertices, and names that claim to
/// be unknown.
pub(crate) fn check_change(change: &Change, at: &At<'_>) -> Result<(), Fault> {
    if let Some(element) = change.element() {
        super::check_element(element, &At::Member(at, "element"))?;
    }
    match &change.kind {
        ChangeKind::Unknown { name } if stored::Change::KINDS.contains(&name.as_str()) => {
            Err(At::Member(at, "change").fault("a name that is not known", quote(name)))
        }
        ChangeKind::Unknown { .. }
        | ChangeKind::Add { .. }
        | ChangeKind::Replace { .. }
        | ChangeKind::Remove { .. } => Ok(()),
    }
}
