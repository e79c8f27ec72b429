//! Between stored and runtime types, and the checks that a single number's range cannot make.

mod adjust;
mod colour_detail;
mod elements;
mod layer;
mod mask;
mod relief;
mod scenarios;
mod series;
mod settings;
mod vector;

use std::collections::BTreeMap;

pub(crate) use colour_detail::details;
pub(crate) use elements::{check_element, element_id};
pub(crate) use scenarios::{changes, check_change, scenario_id};

pub(crate) use layer::{bands, layer_id, layer_name, source_path, unknown_is_unknown};
pub(crate) use relief::{stored_tint, tint};

use super::fault::{At, Fault};
use super::series::StoredDate;
use super::value::With;
use super::{range, v1};
use crate::{Layer, Project};

/// A type with a twin on the other side.
pub(crate) trait Twin: Sized {
    /// The stored type.
    type Stored;
    /// From the stored type.
    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault>;
    /// To the stored type, leaving out what has its default.
    fn to_stored(&self) -> Self::Stored;
}

/// `Some` where a value differs from its default.
fn unless_default<T: PartialEq>(value: T, default: &T) -> Option<T> {
    (value != *default).then_some(value)
}

/// `Some` where a list holds anything.
fn unless_empty<T>(list: Vec<T>) -> Option<Vec<T>> {
    (!list.is_empty()).then_some(list)
}

impl Twin for Project {
    type Stored = With<v1::Project>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let layers_at = At::Member(at, "layers");
        let stored_layers = fields.layers.unwrap_or_default();
        if stored_layers.len() > range::MOST_LAYERS {
            let most = format!("at most {} layers", range::MOST_LAYERS);
            return Err(layers_at.fault(most, stored_layers.len().to_string()));
        }
        let mut layers: Vec<Layer> = Vec::with_capacity(stored_layers.len());
        let mut places = BTreeMap::new();
        for (i, stored_layer) in stored_layers.into_iter().enumerate() {
            let layer_at = At::Element(&layers_at, i);
            let layer = Layer::from_stored(stored_layer, &layer_at)?;
            if let Some(first) = places.insert(layer.id.clone(), i) {
                let found = format!("{:?} again, as in layer {first}", layer.id.0);
                return Err(At::Member(&layer_at, "id").fault("an id of its own", found));
            }
            layers.push(layer);
        }
        let mut project = Self {
            planet: optional(fields.planet, &At::Member(at, "planet"))?,
            camera: optional(fields.camera, &At::Member(at, "camera"))?,
            quality: optional(fields.quality, &At::Member(at, "quality"))?,
            sun: optional(fields.sun, &At::Member(at, "sun"))?,
            layers,
            elements: elements::all(fields.elements, &At::Member(at, "elements"))?,
            scenarios: scenarios::all(fields.scenarios, &At::Member(at, "scenarios"))?,
            scenario: None,
            date: fields.date.map(|date| date.0),
            bookmarks: scenarios::bookmarks(fields.bookmarks, &At::Member(at, "bookmarks"))?,
            extra,
        };
        project.scenario =
            scenarios::shown(fields.scenario, &project, &At::Member(at, "scenario"))?;
        Ok(project)
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: v1::Project {
                version: v1::VERSION,
                planet: Some(self.planet.to_stored()),
                camera: Some(self.camera.to_stored()),
                quality: unless_default(&self.quality, &&crate::Quality::default())
                    .map(Twin::to_stored),
                sun: unless_default(&self.sun, &&crate::Sun::default()).map(Twin::to_stored),
                layers: Some(self.layers.iter().map(Twin::to_stored).collect()),
                elements: unless_empty(self.elements.iter().map(|e| e.to_stored()).collect()),
                scenarios: unless_empty(self.scenarios.iter().map(Twin::to_stored).collect()),
                scenario: self.scenario.as_ref().map(|id| id.0.clone()),
                date: self.date.map(StoredDate),
                bookmarks: unless_empty(self.bookmarks.iter().map(Twin::to_stored).collect()),
            },
            extra: self.extra.clone(),
        }
    }
}

/// A member that may be missing.
fn optional<T: Twin + Default>(stored: Option<T::Stored>, at: &At<'_>) -> Result<T, Fault> {
    stored.map_or_else(|| Ok(T::default()), |stored| T::from_stored(stored, at))
}

/// A text of limited length without control characters.
fn text(value: String, most_bytes: usize, at: &At<'_>) -> Result<String, Fault> {
    if value.len() > most_bytes {
        return Err(at.fault(
            format!("at most {most_bytes} bytes"),
            format!("{} bytes", value.len()),
        ));
    }
    if value.chars().any(char::is_control) {
        return Err(at.fault("no control characters", super::fault::quote(&value)));
    }
    Ok(value)
}

/// A text that is not empty either.
pub(crate) fn filled(value: String, most_bytes: usize, at: &At<'_>) -> Result<String, Fault> {
    if value.is_empty() {
        return Err(at.fault("a text that is not empty", "\"\""));
    }
    text(value, most_bytes, at)
}

/// A position as it is stored; one beyond 32 bits is out of every project anyway.
pub(crate) fn position(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
