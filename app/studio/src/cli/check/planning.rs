//! What is odd about planning elements and scenarios.

use std::path::Path;

use relievo_engine::project::{
    BrushTool, Change, ChangeKind, Element, ElementKind, ProfileKind, Project, Scenario,
    SectionKind, SurfaceKind,
};

use super::{Problem, Severity, text_of, unknown_fields};

/// Adds the problems of all elements and scenarios; `path` is the project's file.
pub(super) fn problems(project: &Project, path: &Path, found: &mut Vec<Problem>) {
    for (index, element) in project.elements.iter().enumerate() {
        of_element(&format!("/elements/{index}"), element, found);
    }
    for (index, scenario) in project.scenarios.iter().enumerate() {
        of_scenario(project, &format!("/scenarios/{index}"), scenario, found);
    }
    for missing in project.missing_geometry(path) {
        let place = match &missing.scenario {
            Some(scenario) => format!("element {} of scenario {scenario}", missing.element),
            None => format!("element {}", missing.element),
        };
        found.push(Problem {
            severity: Severity::Error,
            place,
            layer: None,
            what: format!(
                "the vertices of {:?} cannot be read: {}: {:?}",
                missing.name, missing.reason, missing.file
            ),
            mend: "bring the file back from where the project came from, or draw the element anew"
                .to_owned(),
            edits: Vec::new(),
        });
    }
}

fn warn(place: String, what: String, mend: &str, found: &mut Vec<Problem>) {
    found.push(Problem {
        severity: Severity::Warning,
        place,
        layer: None,
        what,
        mend: mend.to_owned(),
        edits: Vec::new(),
    });
}

fn of_element(place: &str, element: &Element, found: &mut Vec<Problem>) {
    if let Some((member, name)) = unknown_name(element) {
        warn(
            format!("{place}/{member}"),
            format!("expected a {member} of this version, found {name:?}: it has no effect"),
            "open the project with a newer Relievo, or remove the element",
            found,
        );
        return;
    }
    if let Some((member, needed, list)) = least(element)
        && list.missing().is_none()
        && list.len() < needed
    {
        warn(
            format!("{place}/{member}"),
            format!(
                "expected at least {needed} vertices, found {}: {:?} has no effect",
                list.len(),
                element.name
            ),
            "draw it further, or remove the element",
            found,
        );
    }
    for (member, extra) in [
        ("", &element.extra),
        ("/style", &element.style.extra),
        ("/side", &element.side.extra),
    ] {
        unknown_fields(&format!("{place}{member}"), extra.keys(), None, found);
    }
}

/// The list of vertices that makes an element's shape, and how many it takes.
fn least(element: &Element) -> Option<(&'static str, usize, &relievo_engine::project::Vertices)> {
    match &element.kind {
        ElementKind::Polygon(polygon) => Some(("outline", 3, &polygon.outline)),
        ElementKind::Corridor(corridor) => Some(("line", 2, &corridor.line)),
        ElementKind::Brush(_) | ElementKind::Unknown { .. } => None,
    }
}

/// The first kind, type or tool that this version does not know.
fn unknown_name(element: &Element) -> Option<(&'static str, &str)> {
    match &element.kind {
        ElementKind::Unknown { kind } => Some(("kind", kind)),
        ElementKind::Polygon(polygon) => match &polygon.surface.kind {
            SurfaceKind::Unknown { name } => Some(("surface", name)),
            SurfaceKind::Platform { .. }
            | SurfaceKind::Plane { .. }
            | SurfaceKind::Tin
            | SurfaceKind::Offset { .. }
            | SurfaceKind::Smooth => None,
        },
        ElementKind::Corridor(corridor) => {
            if let ProfileKind::Unknown { name } = &corridor.profile.kind {
                return Some(("profile", name));
            }
            match &corridor.section.kind {
                SectionKind::Unknown { name } => Some(("section", name)),
                SectionKind::Road { .. }
                | SectionKind::Dam { .. }
                | SectionKind::Trench { .. }
                | SectionKind::Channel { .. } => None,
            }
        }
        ElementKind::Brush(brush) => brush.strokes.iter().find_map(|stroke| match &stroke.tool {
            BrushTool::Unknown { name } => Some(("strokes", name.as_str())),
            BrushTool::Raise { .. }
            | BrushTool::Lower { .. }
            | BrushTool::Smooth { .. }
            | BrushTool::Flatten { .. } => None,
        }),
    }
}

fn of_scenario(project: &Project, place: &str, scenario: &Scenario, found: &mut Vec<Problem>) {
    unknown_fields(place, scenario.extra.keys(), None, found);
    for (index, change) in scenario.changes.iter().enumerate() {
        let place = format!("{place}/changes/{index}");
        if let Some((what, mend)) = lost(project, scenario, change) {
            warn(place.clone(), what, mend, found);
        }
        if let Some(element) = change.element() {
            of_element(&format!("{place}/element"), element, found);
        }
    }
    for (index, layer) in scenario.layers.iter().enumerate() {
        if project.layer(&layer.id).is_none() {
            found.push(Problem {
                severity: Severity::Warning,
                place: format!("{place}/layers/{index}/id"),
                layer: Some(text_of(&layer.id)),
                what: format!("expected the id of a layer, found {:?}", layer.id.0),
                mend: "leave it out: the layer is gone".to_owned(),
                edits: Vec::new(),
            });
        }
    }
}

/// What is odd about a change whose element the parent does not have (or has already).
fn lost(project: &Project, scenario: &Scenario, change: &Change) -> Option<(String, &'static str)> {
    let parents = |id| project.element_in(scenario.parent.as_ref(), id).is_some();
    match &change.kind {
        ChangeKind::Remove { id } if !parents(id) => Some((
            format!("expected an element to remove, found that {id:?} is not there"),
            "leave the change out: the element is gone",
        )),
        ChangeKind::Replace { element, .. } if !parents(&element.id) => Some((
            format!(
                "expected an element to replace, found that {:?} is not there: it is added",
                element.id.0
            ),
            "nothing, if that is meant; else remove the element in this scenario",
        )),
        ChangeKind::Add { element, .. } if parents(&element.id) => Some((
            format!(
                "expected an id that is not in use, found {:?} in the parent: it is replaced",
                element.id.0
            ),
            "nothing, if that is meant; else give the element an id of its own",
        )),
        ChangeKind::Unknown { name } => Some((
            format!("expected add, replace or remove, found {name:?}: it has no effect"),
            "open the project with a newer Relievo",
        )),
        ChangeKind::Add { .. } | ChangeKind::Replace { .. } | ChangeKind::Remove { .. } => None,
    }
}
