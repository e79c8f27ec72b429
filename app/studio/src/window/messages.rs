//! Problems and news: each once, with who it is about.

use eframe::egui::{Align, Label, Layout, RichText, Role, ScrollArea, Ui, WidgetInfo};
use relievo_engine::project::Layer;
use relievo_engine::{Engine, Severity, SourceState};

use super::action::Action;
use super::layers;
use crate::commands::{Command, entry_of};

/// Most lines of the studio's own that are kept.
const KEPT: usize = 100;

/// How much attention a line deserves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// Something went well.
    News,
    /// Something is odd.
    Warning,
    /// Something failed.
    Error,
}

/// What the studio itself has to say; the engine keeps its own messages.
#[derive(Debug, Default)]
pub(crate) struct Log(Vec<(Weight, String)>);

impl Log {
    /// Adds a line, unless it is the same as the one before.
    pub(crate) fn add(&mut self, weight: Weight, text: impl Into<String>) {
        let line = (weight, text.into());
        if self.0.last() != Some(&line) {
            self.0.push(line);
        }
        if self.0.len() > KEPT {
            self.0.remove(0);
        }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Lines that are more than news.
    pub(crate) fn problems(&self) -> usize {
        self.0.iter().filter(|(w, _)| *w != Weight::News).count()
    }
}

/// Draws all messages.
pub(crate) fn show(ui: &mut Ui, engine: &Engine, log: &mut Log, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let count = engine.messages().len() + log.0.len();
        ui.weak(if count == 1 {
            "1 line".to_owned()
        } else {
            format!("{count} lines")
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let retry = entry_of(Command::Retry);
            if ui.button(retry.title).on_hover_text(retry.help).clicked() {
                actions.push(Action::Run(Command::Retry));
            }
            if ui
                .button("Clear")
                .on_hover_text("Forget the studio's own messages")
                .clicked()
            {
                log.clear();
            }
        });
    });
    ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            if engine.messages().is_empty() && log.0.is_empty() {
                ui.weak("Nothing to report.");
            }
            for message in engine.messages() {
                let weight = if message.severity == Severity::Error {
                    Weight::Error
                } else {
                    Weight::Warning
                };
                let layer = message
                    .layer
                    .as_ref()
                    .and_then(|id| engine.project().layer(id));
                let about = layer.map(|l| format!("{}: ", layers::name_of(l)));
                let text = format!("{}{}", about.unwrap_or_default(), message.text);
                ui.push_id(&text, |ui| {
                    line(ui, weight, &text, |ui| {
                        if let Some(layer) = layer {
                            remedies(ui, engine, layer, actions);
                        }
                    });
                });
            }
            for (weight, text) in log.0.iter().rev() {
                line(ui, *weight, text, |_| {});
            }
        });
}

/// What can be done about a layer's problem.
fn remedies(ui: &mut Ui, engine: &Engine, layer: &Layer, actions: &mut Vec<Action>) {
    let name = layers::name_of(layer);
    let mut button = |ui: &mut Ui, text: &str, spoken: String, hint: &str, action: Action| {
        let button = ui.small_button(text);
        button.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), &spoken));
        if button.on_hover_text(hint).clicked() {
            actions.push(action);
        }
    };
    if layer.source().is_some() && !layer.locked {
        let (spoken, hint) = (
            format!("Find the file of {name}"),
            entry_of(Command::Locate).help,
        );
        button(
            ui,
            "Locate…",
            spoken,
            hint,
            Action::Locate(layer.id.clone()),
        );
    }
    let state = engine.sources().state(&layer.kind, engine.folder());
    if matches!(state, Some(SourceState::Failed(_))) {
        let (spoken, hint) = (format!("Try {name} again"), entry_of(Command::Retry).help);
        button(ui, "Try again", spoken, hint, Action::Run(Command::Retry));
    }
    if matches!(state, Some(SourceState::Open(_) | SourceState::Features(_))) {
        let (spoken, hint) = (
            format!("Fly to {name}"),
            entry_of(Command::ZoomToLayer).help,
        );
        button(
            ui,
            "Fly there",
            spoken,
            hint,
            Action::FlyTo(layer.id.clone()),
        );
    }
    let (spoken, hint) = (
        format!("Select {name}"),
        "Select the layer and show its settings",
    );
    button(
        ui,
        "Select",
        spoken,
        hint,
        Action::Select(Some(layer.id.clone())),
    );
}

fn line(ui: &mut Ui, weight: Weight, text: &str, remedies: impl FnOnce(&mut Ui)) {
    let (sign, colour) = match weight {
        Weight::News => ("·", ui.visuals().text_color()),
        Weight::Warning => ("!", ui.visuals().warn_fg_color),
        Weight::Error => ("×", ui.visuals().error_fg_color),
    };
    ui.horizontal_wrapped(|ui| {
        ui.add(Label::new(RichText::new(sign).color(colour)).selectable(false));
        ui.add(Label::new(text).wrap());
        remedies(ui);
    });
}
