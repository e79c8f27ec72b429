//! What differs between two versions without moving any ground.

use std::collections::HashMap;
use std::sync::Arc;

use relievo_project::{Element, ElementId, Layer, LayerKind, Project};

use super::version::{Version, is_added_noise};
use crate::query::WITHOUT_DETAIL;

/// Most names that a note lists.
const MOST_NAMES: usize = 5;

/// Notes on elements and layers that are hidden or look different in one of the versions.
pub(super) fn notes(project: &Project, versions: [&Version; 2]) -> Vec<String> {
    let [a, b] = versions.map(|version| version.name(project));
    let mut notes = Vec::new();
    let mut note = |before: &str, names: Vec<&str>| {
        if !names.is_empty() {
            notes.push(format!("{before}: {}.", listed(&names)));
        }
    };
    let [from, to] = versions.map(|version| version.elements(project));
    let pairs = pairs(&from, &to);
    let named = |wanted: &dyn Fn(&Element, &Element) -> bool| -> Vec<&str> {
        let found = pairs.iter().filter(|(before, after)| wanted(before, after));
        found.map(|(_, after)| after.name.as_str()).collect()
    };
    note(
        &format!("Only hidden in {b}, not removed"),
        named(&|before, after| before.visible && !after.visible),
    );
    note(
        &format!("Only hidden in {a}, not new in {b}"),
        named(&|before, after| !before.visible && after.visible),
    );
    note(
        "Hidden in both, though they differ",
        named(&|before, after| !before.visible && !after.visible && before != after),
    );
    note(
        "Only name or looks differ, which moves no ground",
        named(&|before, after| before.visible && after.visible && same_ground(before, after)),
    );
    let [before, after] = versions.map(|version| project.layers_in(version.scenario()));
    let looks = before.iter().zip(after.iter());
    let looks = looks.filter(|(before, after)| !gives_heights(after) && before != after);
    note(
        "Layers that only look different, which moves no ground",
        looks.map(|(_, layer)| layer.name.as_str()).collect(),
    );
    notes
}

/// Notes on what the ground of two versions, as it is surveyed, leaves out or counts.
pub(super) fn of_grounds(
    project: &Project,
    first: &Project,
    last: &Project,
    has_bounds: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    if first.layers != last.layers {
        notes.push(if has_bounds {
            "The versions show different height layers: the total counts them within the bounds, the rows of elements stand on the second version's ground."
        } else {
            "The versions show different height layers: the total counts them where elements change; give bounds to count them elsewhere. Rows of elements stand on the second version's ground."
        }.to_owned());
    }
    if project.layers.iter().any(is_added_noise) {
        notes.push("Noise that is added to other heights is left out of all measures.".to_owned());
    }
    if project.layers.iter().any(is_detail) {
        notes.push(WITHOUT_DETAIL.to_owned());
    }
    notes
}

/// Elements of both versions that differ in anything, in the order of the second one.
fn pairs<'a>(
    from: &'a [Arc<Element>],
    to: &'a [Arc<Element>],
) -> Vec<(&'a Arc<Element>, &'a Arc<Element>)> {
    let before: HashMap<&ElementId, &Arc<Element>> = from.iter().map(|e| (&e.id, e)).collect();
    let both = to.iter().filter_map(|e| Some((*before.get(&e.id)?, e)));
    both.filter(|(before, after)| !Arc::ptr_eq(before, after) && before != after)
        .collect()
}

/// Whether two states of an element shape the ground alike; names and colours move none.
pub(super) fn same_ground(before: &Element, after: &Element) -> bool {
    before.kind == after.kind && before.side == after.side
}

fn gives_heights(layer: &Layer) -> bool {
    matches!(
        layer.kind,
        LayerKind::Height(_) | LayerKind::Noise(_) | LayerKind::Detail(_)
    )
}

/// Whether a layer adds detail that is seen.
fn is_detail(layer: &Layer) -> bool {
    layer.visible && matches!(layer.kind, LayerKind::Detail(_))
}

/// Names in one line.
pub(super) fn listed(names: &[&str]) -> String {
    match names.get(MOST_NAMES..) {
        None | Some([]) => names.join(", "),
        Some(more) => format!("{} and {} more", names[..MOST_NAMES].join(", "), more.len()),
    }
}
