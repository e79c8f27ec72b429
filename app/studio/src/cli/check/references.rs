//! What layers say of each other: masks by areas, examples and areas of detail.

use relievo_engine::project::{
    ColourDetail, DetailBy, Layer, LayerKind, LensShape, Project, WrongReference,
};

use super::{Problem, Severity, text_of, unknown_fields};

/// Complains of every layer that is named and is not what is wanted there.
pub(super) fn problems(project: &Project, found: &mut Vec<Problem>) {
    for (index, layer) in project.layers.iter().enumerate() {
        let place = format!("/layers/{index}");
        if let Some(mask) = &layer.mask {
            let at = format!("{place}/mask");
            unknown_fields(&at, mask.extra.keys(), Some(&layer.id), found);
            if let Some(lens) = &mask.lens {
                let member = match lens.shape {
                    LensShape::Circle { .. } => "circle",
                    LensShape::Polygon { .. } => "polygon",
                };
                let at = format!("{at}/{member}");
                unknown_fields(&at, lens.extra.keys(), Some(&layer.id), found);
            }
            let named = mask
                .vector
                .iter()
                .map(|id| project.named_areas(id, "for the mask"));
            let wrong = named.filter_map(Result::err);
            found.extend(wrong.map(|wrong| problem(layer, format!("{at}/vector"), &wrong)));
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
    let named = |id| project.named_areas(id, "for the detail");
    let named = detail.areas.iter().map(named);
    let wrong = named.filter_map(Result::err);
    found.extend(wrong.map(|wrong| problem(layer, format!("{at}/areas"), &wrong)));
    let DetailBy::Examples { layers, .. } = &detail.by else {
        return;
    };
    for (k, id) in layers.iter().enumerate() {
        if let Err(wrong) = project.named_example(&layer.id, id) {
            found.push(problem(layer, format!("{at}/layers/{k}"), &wrong));
        }
    }
}

fn problem(layer: &Layer, place: String, wrong: &WrongReference) -> Problem {
    Problem {
        severity: Severity::Error,
        place,
        layer: Some(text_of(&layer.id)),
        what: wrong.to_string(),
        mend: "name a layer of that kind, add one with that id, or take the name away".to_owned(),
        edits: Vec::new(),
    }
}
