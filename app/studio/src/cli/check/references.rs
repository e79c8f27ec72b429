//! What layers say of each other: masks by areas, examples and areas of detail.

use relievo_engine::project::{ColourDetail, DetailBy, Layer, LayerId, LayerKind, Project};

use super::{Problem, Severity, text_of, unknown_fields};

/// Complains of every layer that is named and is not what is wanted there.
pub(super) fn problems(project: &Project, found: &mut Vec<Problem>) {
    for (index, layer) in project.layers.iter().enumerate() {
        let place = format!("/layers/{index}");
        if let Some(mask) = &layer.mask {
            let at = format!("{place}/mask");
            unknown_fields(&at, mask.extra.keys(), Some(&layer.id), found);
            let at = format!("{at}/vector");
            found.extend(
                mask.vector
                    .iter()
                    .filter_map(|id| areas(project, layer, id, &at)),
            );
        }
        let LayerKind::Imagery(imagery) = &layer.kind else {
            continue;
        };
        for (i, detail) in imagery.detail.iter().enumerate() {
            let at = format!("{place}/detail/{i}");
            unknown_fields(&at, detail.extra.keys(), Some(&layer.id), found);
            of_detail(project, layer, detail, &at, found);
        }
    }
}

fn of_detail(
    project: &Project,
    layer: &Layer,
    detail: &ColourDetail,
    at: &str,
    found: &mut Vec<Problem>,
) {
    let place = format!("{at}/areas");
    found.extend(
        detail
            .areas
            .iter()
            .filter_map(|id| areas(project, layer, id, &place)),
    );
    let DetailBy::Examples { layers, .. } = &detail.by else {
        return;
    };
    for (k, id) in layers.iter().enumerate() {
        let is_imagery =
            |other: &Layer| other.id != layer.id && matches!(other.kind, LayerKind::Imagery(_));
        if !project.layer(id).is_some_and(is_imagery) {
            found.push(wrong(
                layer,
                format!("{at}/layers/{k}"),
                &format!("another imagery layer {:?} as an example", id.0),
                &found_as(project, layer, id),
            ));
        }
    }
}

/// The complaint about a layer whose areas count, if it has none.
fn areas(project: &Project, layer: &Layer, id: &LayerId, at: &str) -> Option<Problem> {
    let is_vector = |other: &Layer| matches!(other.kind, LayerKind::Vector(_));
    if project.layer(id).is_some_and(is_vector) {
        return None;
    }
    let expected = format!("a vector layer {:?}", id.0);
    Some(wrong(
        layer,
        at.to_owned(),
        &expected,
        &found_as(project, layer, id),
    ))
}

fn found_as(project: &Project, layer: &Layer, id: &LayerId) -> String {
    match project.layer(id) {
        None => "none".to_owned(),
        Some(other) if other.id == layer.id => "the layer itself".to_owned(),
        Some(other) => format!("one of kind {}", other.kind.name()),
    }
}

fn wrong(layer: &Layer, place: String, expected: &str, found: &str) -> Problem {
    Problem {
        severity: Severity::Error,
        place,
        layer: Some(text_of(&layer.id)),
        what: format!("expected {expected}, found {found}"),
        mend: "name a layer of that kind, add one with that id, or take the name away".to_owned(),
        edits: Vec::new(),
    }
}
