//! Detail of imagery beyond its file's resolution.

use eframe::egui::{CollapsingHeader, RichText, Ui};
use relievo_engine::project::{ColourDetail, DetailBy, Edit, Layer, LayerId, LayerKind, Project};

use super::mask::{Words, vector_layer};
use crate::window::action::Action;
use crate::window::controls::{self, Number};

const AMOUNT: Number = Number::new(
    "Amount",
    "Contrast of what is added: 1 is as the examples have it, or as the imagery's own power law goes on",
    0.0..=4.0,
    1.0,
);
const TOLERANCE: Number = Number::new(
    "Tolerance",
    "How far an example's mean colour may be from the imagery's to be used; black to white is 1.73",
    0.0..=2.0,
    DetailBy::TOLERANCE,
);
const SEED: Number = Number::new("Seed", "Chooses the pattern", 0.0..=4_294_967_295.0, 0.0).whole();

const AREAS: Words = Words {
    title: "In areas of",
    hint: "Add detail only inside the areas of a vector layer, which may be hidden: land cover, say",
    none: "Everywhere",
};

/// Draws all of a layer's detail, and what adds more.
pub(super) fn show(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    all: &[ColourDetail],
    actions: &mut Vec<Action>,
) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new("Detail beyond the file").strong())
        .id_salt("colour detail")
        .default_open(!all.is_empty())
        .show_unindented(ui, |ui| {
            for at in 0..all.len() {
                ui.push_id(at, |ui| entry(ui, project, layer, (all, at), actions));
            }
            add(ui, project, layer, all, actions);
        });
}

/// An edit that sets all of a layer's detail.
fn set(layer: &Layer, detail: Vec<ColourDetail>) -> Edit {
    Edit::SetColourDetail {
        id: layer.id.clone(),
        detail,
    }
}

/// An edit that changes one of them.
fn changed(
    layer: &Layer,
    (all, at): (&[ColourDetail], usize),
    change: impl FnOnce(&mut ColourDetail),
) -> Edit {
    let mut all = all.to_vec();
    if let Some(detail) = all.get_mut(at) {
        change(detail);
    }
    set(layer, all)
}

fn entry(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    (all, at): (&[ColourDetail], usize),
    actions: &mut Vec<Action>,
) {
    let Some(detail) = all.get(at) else { return };
    let this = (all, at);
    let title = match detail.by {
        DetailBy::Noise => "Noise",
        DetailBy::Examples { .. } => "After examples",
    };
    ui.horizontal(|ui| {
        ui.label(title);
        let hint = "Take this detail away";
        if ui.small_button("Remove").on_hover_text(hint).clicked() {
            let mut rest = all.to_vec();
            rest.remove(at);
            actions.push(Action::Edit(set(layer, rest)));
        }
    });
    if let DetailBy::Examples { layers, tolerance } = &detail.by {
        examples(ui, project, layer, (this, layers), actions);
        controls::number(ui, &TOLERANCE, *tolerance, actions, |v| {
            changed(layer, this, |d| {
                if let DetailBy::Examples { tolerance, .. } = &mut d.by {
                    *tolerance = v;
                }
            })
        });
    }
    controls::number(ui, &AMOUNT, detail.strength, actions, |v| {
        changed(layer, this, |d| d.strength = v)
    });
    controls::number(ui, &SEED, f64::from(detail.seed), actions, |v| {
        changed(layer, this, |d| d.seed = v as u32)
    });
    let choice = (&AREAS, detail.areas.as_ref());
    vector_layer(ui, project, layer, choice, actions, |new| {
        changed(layer, this, |d| d.areas = new)
    });
    ui.add_space(4.0);
}

/// Which layers are examples; the last one stays.
fn examples(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    (this, chosen): ((&[ColourDetail], usize), &[LayerId]),
    actions: &mut Vec<Action>,
) {
    let others = others(project, layer);
    // Ids of layers that are gone, or are no imagery.
    let gone: Vec<&LayerId> = chosen
        .iter()
        .filter(|id| others.iter().all(|other| other.id != **id))
        .collect();
    let rows = others
        .iter()
        .map(|other| (&other.id, other.name.clone()))
        .chain(
            gone.iter()
                .map(|id| (*id, format!("{} (no imagery)", id.0))),
        );
    for (id, name) in rows {
        let was = chosen.contains(id);
        let mut is = was;
        let hint =
            "Use the middle of this layer's file as an example of fine ground; it may be hidden";
        let only = was && chosen.iter().all(|other| other == id);
        let full = !was && chosen.len() >= DetailBy::MOST_EXAMPLES;
        let row = ui.add_enabled_ui(!only && !full, |ui| ui.checkbox(&mut is, name));
        let why_not = if full {
            "There are 16 examples already"
        } else {
            "At least one layer is an example; remove the detail instead"
        };
        let tick = row
            .inner
            .on_hover_text(hint)
            .on_disabled_hover_text(why_not);
        if tick.changed() {
            actions.push(Action::Edit(changed(layer, this, |d| {
                if let DetailBy::Examples { layers, .. } = &mut d.by {
                    if is {
                        layers.push(id.clone());
                    } else {
                        layers.retain(|other| other != id);
                    }
                }
            })));
        }
    }
}

/// Imagery that can show what fine ground looks like.
fn others<'p>(project: &'p Project, layer: &Layer) -> Vec<&'p Layer> {
    let is_other =
        |other: &&Layer| other.id != layer.id && matches!(other.kind, LayerKind::Imagery(_));
    project.layers.iter().filter(is_other).collect()
}

fn add(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    all: &[ColourDetail],
    actions: &mut Vec<Action>,
) {
    if all.len() >= ColourDetail::MOST {
        ui.weak("There are 16 kinds of detail, which is as many as can be.");
        return;
    }
    let mut push = |by| {
        let mut all = all.to_vec();
        all.push(ColourDetail::new(by));
        actions.push(Action::Edit(set(layer, all)));
    };
    ui.horizontal(|ui| {
        let hint =
            "Continue the imagery below its resolution by noise that follows its own power law";
        if ui.button("Add noise").on_hover_text(hint).clicked() {
            push(DetailBy::Noise);
        }
        let others = others(project, layer);
        let button = ui.add_enabled_ui(!others.is_empty(), |ui| ui.button("Add examples"));
        let hint = "Continue the imagery below its resolution after finer imagery of such ground";
        let button = button
            .inner
            .on_hover_text(hint)
            .on_disabled_hover_text("There is no other imagery layer to follow");
        if button.clicked() {
            let layers = others.last().map(|other| other.id.clone());
            push(DetailBy::Examples {
                layers: layers.into_iter().collect(),
                tolerance: DetailBy::TOLERANCE,
            });
        }
    });
}
