//! The states of a project that are compared, as projects of their own.

use std::sync::Arc;

use relievo_project::{Element, LayerKind, NoiseMode, Project, ScenarioId};

/// A state of a project's elements and layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Version {
    /// The base without any element.
    Ground,
    /// The base.
    Base,
    /// A scenario.
    Scenario(ScenarioId),
}

impl Version {
    /// The version that people call so: `ground`, `base`, a scenario's name or its id.
    pub fn called(project: &Project, text: &str) -> Option<Self> {
        match text {
            "base" => Some(Self::Base),
            "ground" => Some(Self::Ground),
            _ => project
                .scenario_called(text)
                .map(|scenario| Self::Scenario(scenario.id.clone())),
        }
    }

    /// What people call it.
    pub fn name(&self, project: &Project) -> String {
        match self {
            Self::Ground => "ground".to_owned(),
            Self::Base => "base".to_owned(),
            Self::Scenario(id) => project
                .scenario(id)
                .map_or_else(|| id.0.clone(), |scenario| scenario.name.clone()),
        }
    }

    pub(super) fn scenario(&self) -> Option<&ScenarioId> {
        match self {
            Self::Ground | Self::Base => None,
            Self::Scenario(id) => Some(id),
        }
    }

    /// All its elements, hidden ones too.
    pub(super) fn elements(&self, project: &Project) -> Vec<Arc<Element>> {
        match self {
            Self::Ground => Vec::new(),
            Self::Base | Self::Scenario(_) => project.elements_in(self.scenario()),
        }
    }
}

/// Whether a layer adds noise that is seen.
pub(super) fn is_added_noise(layer: &relievo_project::Layer) -> bool {
    let added =
        matches!(&layer.kind, LayerKind::Noise(noise) if noise.noise.mode == NoiseMode::Add);
    layer.visible && added
}

/// A version's layers; elements are put in later.
pub(super) fn as_shown(project: &Project, version: &Version) -> Project {
    Project {
        layers: project.layers_in(version.scenario()).into_owned(),
        elements: Vec::new(),
        scenarios: Vec::new(),
        scenario: None,
        ..project.clone()
    }
}

/// A version's heights without colours and without noise that is added.
pub(super) fn surveyed(project: &Project, version: &Version) -> Project {
    let mut project = as_shown(project, version);
    project.layers.retain(|layer| {
        let gives_heights = matches!(layer.kind, LayerKind::Height(_) | LayerKind::Noise(_));
        gives_heights && layer.visible && !is_added_noise(layer)
    });
    project
}

pub(super) fn with_elements(project: &Project, elements: Vec<Arc<Element>>) -> Project {
    Project {
        elements,
        ..project.clone()
    }
}
