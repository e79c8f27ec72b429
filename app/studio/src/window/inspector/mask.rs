//! Where a layer shows.

mod lens;

use eframe::egui::{CollapsingHeader, ComboBox, RichText, Ui};
use relievo_engine::project::{Edit, Extra, Layer, LayerId, LayerKind, Mask, MaskRange, Project};

use crate::window::action::Action;
use crate::window::controls::{self, Number};

const FROM_M: Number = Number::new(
    "From",
    "Lowest height that shows fully",
    -12_000.0..=25_000.0,
    0.0,
)
.unit(" m", 0);
const TO_M: Number = Number::new(
    "To",
    "Highest height that shows fully",
    -12_000.0..=25_000.0,
    3000.0,
)
.unit(" m", 0);
const FADE_M: Number = Number::new(
    "Fade",
    "Metres of height beyond either end over which the layer fades out",
    0.0..=10_000.0,
    0.0,
)
.unit(" m", 0)
.logarithmic();
const FROM_DEG: Number = Number::new(
    "From",
    "Least slope that shows fully, against the horizontal",
    0.0..=90.0,
    30.0,
)
.unit("°", 1);
const TO_DEG: Number = Number::new(
    "To",
    "Greatest slope that shows fully, against the horizontal",
    0.0..=90.0,
    90.0,
)
.unit("°", 1);
const FADE_DEG: Number = Number::new(
    "Fade",
    "Degrees beyond either end over which the layer fades out",
    0.0..=90.0,
    0.0,
)
.unit("°", 1);
/// Draws it.
pub(super) fn show(ui: &mut Ui, project: &Project, layer: &Layer, actions: &mut Vec<Action>) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new("Mask").strong())
        .default_open(layer.mask.is_some())
        .show_unindented(ui, |ui| {
            let mask = layer.mask.clone().unwrap_or_default();
            heights(ui, &layer.id, &mask, actions);
            slopes(ui, &layer.id, &mask, actions);
            lens::show(ui, project, layer, &mask, actions);
            areas(ui, project, layer, &mask, actions);
            let mut invert = mask.invert;
            let hint = "Show the layer everywhere else instead";
            let tick = ui.checkbox(&mut invert, "Outside instead of inside");
            if tick.on_hover_text(hint).changed() {
                actions.push(Action::Edit(set(&layer.id, &mask, |m| m.invert = invert)));
            }
        });
}

/// An edit that changes a mask; one that is left without anything goes.
fn set(id: &LayerId, mask: &Mask, change: impl FnOnce(&mut Mask)) -> Edit {
    let mut mask = mask.clone();
    change(&mut mask);
    let says_nothing = mask == Mask::default();
    Edit::SetMask {
        id: id.clone(),
        mask: (!says_nothing).then(|| Box::new(mask)),
    }
}

fn usual(from: f64, to: f64, fade: f64) -> MaskRange {
    MaskRange {
        from,
        to,
        fade,
        extra: Extra::new(),
    }
}

fn heights(ui: &mut Ui, id: &LayerId, mask: &Mask, actions: &mut Vec<Action>) {
    let mut on = mask.heights.is_some();
    let tick = ui.checkbox(&mut on, "By height");
    let hint = "Show the layer only where the ground lies in a range of heights";
    if tick.on_hover_text(hint).changed() {
        let range = on.then(|| usual(0.0, 3000.0, 100.0));
        actions.push(Action::Edit(set(id, mask, |m| m.heights = range)));
    }
    if let Some(range) = &mask.heights {
        let numbers = [&FROM_M, &TO_M, &FADE_M];
        rows(ui, ("heights", numbers), range, actions, |range| {
            set(id, mask, |m| m.heights = Some(range))
        });
    }
}

fn slopes(ui: &mut Ui, id: &LayerId, mask: &Mask, actions: &mut Vec<Action>) {
    let mut on = mask.slopes.is_some();
    let tick = ui.checkbox(&mut on, "By slope");
    let hint = "Show the layer only where the ground is so steep";
    if tick.on_hover_text(hint).changed() {
        let range = on.then(|| usual(30.0, 90.0, 5.0));
        actions.push(Action::Edit(set(id, mask, |m| m.slopes = range)));
    }
    if let Some(range) = &mask.slopes {
        let numbers = [&FROM_DEG, &TO_DEG, &FADE_DEG];
        rows(ui, ("slopes", numbers), range, actions, |range| {
            set(id, mask, |m| m.slopes = Some(range))
        });
    }
}

/// The numbers of a range; either end gives way to the other.
fn rows(
    ui: &mut Ui,
    (name, [low, high, fade]): (&str, [&Number; 3]),
    range: &MaskRange,
    actions: &mut Vec<Action>,
    edit: impl Fn(MaskRange) -> Edit,
) {
    let with = |change: &dyn Fn(&mut MaskRange)| {
        let mut range = range.clone();
        change(&mut range);
        edit(range)
    };
    ui.push_id(name, |ui| {
        controls::number(ui, low, range.from, actions, |v| {
            with(&|r| (r.from, r.to) = (v, r.to.max(v)))
        });
        controls::number(ui, high, range.to, actions, |v| {
            with(&|r| (r.from, r.to) = (r.from.min(v), v))
        });
        controls::number(ui, fade, range.fade, actions, |v| with(&|r| r.fade = v));
    });
}

fn shown_name<'a>(name: Option<&'a str>, none: &'a str) -> &'a str {
    name.unwrap_or(none)
}

fn areas(ui: &mut Ui, project: &Project, layer: &Layer, mask: &Mask, actions: &mut Vec<Action>) {
    let words = Words {
        title: "In areas of",
        hint: "Show the layer only inside the areas of a vector layer, which may be hidden",
        none: "None",
    };
    let edit = |new| set(&layer.id, mask, |m| m.vector = new);
    vector_layer(
        ui,
        project,
        layer,
        (&words, mask.vector.as_ref()),
        actions,
        edit,
    );
}

/// What a choice of a vector layer is called.
pub(super) struct Words {
    pub(super) title: &'static str,
    pub(super) hint: &'static str,
    /// The choice of no layer.
    pub(super) none: &'static str,
}

/// A choice of a vector layer whose areas count; nothing where there is none to choose.
pub(super) fn vector_layer(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    (words, chosen): (&Words, Option<&LayerId>),
    actions: &mut Vec<Action>,
    edit: impl FnOnce(Option<LayerId>) -> Edit,
) {
    let others: Vec<&Layer> = project
        .layers
        .iter()
        .filter(|other| other.id != layer.id && matches!(other.kind, LayerKind::Vector(_)))
        .collect();
    if others.is_empty() && chosen.is_none() {
        return;
    }
    ui.horizontal(|ui| {
        let label = controls::name(ui, words.title, false).on_hover_text(words.hint);
        let found = others.iter().find(|other| Some(&other.id) == chosen);
        let missing = if chosen.is_some() {
            "a layer that is gone"
        } else {
            words.none
        };
        let combo = ComboBox::from_id_salt(words.title)
            .selected_text(shown_name(found.map(|other| other.name.as_str()), missing))
            .width(ui.available_width() - 8.0);
        let combo = combo.show_ui(ui, |ui| {
            let mut new = chosen.cloned();
            ui.selectable_value(&mut new, None, words.none);
            for other in &others {
                ui.selectable_value(&mut new, Some(other.id.clone()), &other.name);
            }
            if new.as_ref() != chosen {
                actions.push(Action::Edit(edit(new)));
            }
        });
        combo
            .response
            .labelled_by(label.id)
            .on_hover_text(words.hint);
    });
}
