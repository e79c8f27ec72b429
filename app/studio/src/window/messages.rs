//! Problems and news: each once, with who it is about.

use eframe::egui::{Align, Label, Layout, RichText, ScrollArea, Ui};
use relievo_engine::{Engine, Severity};

use super::action::Action;
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
        ui.heading("Messages");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui
                .button("Hide")
                .on_hover_text("Hide the messages")
                .clicked()
            {
                actions.push(Action::Run(Command::ToggleMessages));
            }
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
                let about = layer.map(|l| format!("{}: ", l.name)).unwrap_or_default();
                line(ui, weight, &format!("{about}{}", message.text));
            }
            for (weight, text) in log.0.iter().rev() {
                line(ui, *weight, text);
            }
        });
}

fn line(ui: &mut Ui, weight: Weight, text: &str) {
    let (sign, colour) = match weight {
        Weight::News => ("·", ui.visuals().text_color()),
        Weight::Warning => ("!", ui.visuals().warn_fg_color),
        Weight::Error => ("×", ui.visuals().error_fg_color),
    };
    ui.horizontal_top(|ui| {
        ui.add(Label::new(RichText::new(sign).color(colour)).selectable(false));
        ui.add(Label::new(text).wrap());
    });
}
