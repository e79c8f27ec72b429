//! What a scenario shows, for whatever looks at one project at a time.

use std::borrow::Cow;

use relievo_project::{Project, ScenarioId};

/// The project with a scenario's elements and layers in the place of the base's (`None`: the base
/// itself), showing no scenario. Elements are shared, so this costs little more than the list.
pub fn as_shown<'a>(project: &'a Project, scenario: Option<&ScenarioId>) -> Cow<'a, Project> {
    if scenario.is_none() && project.scenario.is_none() {
        return Cow::Borrowed(project);
    }
    Cow::Owned(Project {
        planet: project.planet.clone(),
        camera: project.camera.clone(),
        quality: project.quality.clone(),
        sun: project.sun.clone(),
        layers: project.layers_in(scenario).into_owned(),
        elements: project.elements_in(scenario),
        ..Project::default()
    })
}
