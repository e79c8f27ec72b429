//! The settings of a planning element: surface, section, side slopes, colours, vertices.

mod brush;
mod corridor;
mod sides;
mod surface;
mod vertices;

use std::sync::Arc;

use eframe::egui::{self, CollapsingHeader, RichText, TextEdit, Ui};
use relievo_engine::project::{Edit, Element, ElementId, ElementKind, ScenarioId};

use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::tools::Spot;

const HEIGHT: Number = Number::new(
    "Height",
    "Height above the datum",
    -12_000.0..=12_000.0,
    0.0,
)
.unit(" m", 2);
const OFFSET: Number = Number::new(
    "Offset",
    "Above the ground, negative below it",
    -500.0..=500.0,
    0.0,
)
.unit(" m", 2);

/// What the inspector remembers of elements from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct ElementForm {
    /// The name that is being typed.
    name: Option<(ElementId, String)>,
}

/// What is shown.
pub(crate) struct Shown<'a> {
    pub(crate) scenario: Option<ScenarioId>,
    pub(crate) element: &'a Element,
    /// The vertex that is chosen on the terrain.
    pub(crate) vertex: Option<Spot>,
}

impl ElementForm {
    /// Draws it; the vertex that was chosen in it, if one was.
    pub(crate) fn show(&mut self, ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
        let element = shown.element;
        ui.push_id(&element.id.0, |ui| {
            ui.add_enabled_ui(!element.locked, |ui| {
                self.name(ui, shown, actions);
                match &element.kind {
                    ElementKind::Polygon(polygon) => surface::show(ui, shown, polygon, actions),
                    ElementKind::Corridor(corridor) => corridor::show(ui, shown, corridor, actions),
                    ElementKind::Brush(_) => brush::show(ui, shown, actions),
                    ElementKind::Unknown { kind } => {
                        ui.weak(format!(
                            "An element of kind {kind}, made by a newer Relievo. It is kept as it is."
                        ));
                    }
                }
                if matches!(element.kind, ElementKind::Polygon(_) | ElementKind::Corridor(_)) {
                    section(ui, "Side slopes", |ui| sides::side(ui, shown, actions));
                }
                section(ui, "Colours", |ui| sides::style(ui, shown, actions));
                if !matches!(element.kind, ElementKind::Brush(_)) {
                    section(ui, "Vertices", |ui| vertices::show(ui, shown, actions));
                }
            });
            ui.add_space(6.0);
            let mut locked = element.locked;
            let hint = "A locked element cannot be changed in the window";
            if ui.checkbox(&mut locked, "Locked").on_hover_text(hint).changed() {
                actions.push(Action::Edit(Edit::SetElementLocked {
                    scenario: shown.scenario.clone(),
                    id: element.id.clone(),
                    locked,
                }));
            }
        });
    }

    fn name(&mut self, ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
        let element = shown.element;
        if self.name.as_ref().is_none_or(|(id, _)| *id != element.id) {
            self.name = Some((element.id.clone(), element.name.clone()));
        }
        let Some((_, text)) = &mut self.name else {
            return;
        };
        ui.horizontal(|ui| {
            let label = controls::name(ui, "Name", false);
            let field = TextEdit::singleline(text)
                .desired_width(f32::INFINITY)
                .char_limit(250)
                .hint_text(element.id.0.as_str());
            let response = ui.add(field).labelled_by(label.id);
            let response = response.on_hover_text("What the list calls the element");
            if response.lost_focus() && *text != element.name {
                if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                    text.clone_from(&element.name);
                } else {
                    actions.push(Action::Edit(Edit::SetElementName {
                        scenario: shown.scenario.clone(),
                        id: element.id.clone(),
                        name: text.trim().to_owned(),
                    }));
                }
            } else if !response.has_focus() && *text != element.name {
                text.clone_from(&element.name);
            }
        });
    }
}

/// The edit that puts the element, changed, in its own place.
fn replace(shown: &Shown<'_>, change: impl FnOnce(&mut Element)) -> Edit {
    let mut element = shown.element.clone();
    change(&mut element);
    Edit::ReplaceElement {
        scenario: shown.scenario.clone(),
        element: Arc::new(element),
    }
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new(title).strong())
        .default_open(true)
        .show_unindented(ui, content);
}
