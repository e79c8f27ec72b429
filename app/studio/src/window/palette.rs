//! The palette: a command by a few letters of its name, without the mouse.

mod fuzzy;

use eframe::egui::{
    self, Event, Id, Key, Label, Modal, Modifiers, Response, RichText, Role, ScrollArea, Sense,
    TextEdit, Ui, WidgetInfo, vec2,
};

use super::theme;
use crate::commands::{Command, Entry, TABLE};

/// Width of the palette in points.
const WIDTH: f32 = 460.0;

/// Height of a line in points.
const LINE: f32 = 26.0;

/// Lines that are seen at once.
const LINES: f32 = 12.0;

/// What was typed and which line is chosen.
#[derive(Debug, Default)]
pub(crate) struct Palette {
    typed: String,
    chosen: usize,
}

/// What came of a frame of the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It stays.
    Open,
    /// It goes.
    Closed,
    /// It goes, and a command is asked for.
    Run(Command),
}

/// A command as it stands now.
#[derive(Clone, Debug)]
pub(crate) struct Offer {
    /// Its line of the table.
    pub(crate) entry: &'static Entry,
    /// What it would do now.
    pub(crate) title: String,
    /// Whether it can do something now.
    pub(crate) possible: bool,
}

impl Palette {
    /// An empty one, or with what was typed since its keys in the same slow frame.
    pub(crate) fn opened(ctx: &egui::Context) -> Self {
        let mut typed = String::new();
        if !ctx.text_edit_focused() {
            ctx.input(|i| {
                for event in &i.events {
                    if let Event::Text(text) = event {
                        typed.push_str(text);
                    }
                }
            });
        }
        Self { typed, chosen: 0 }
    }

    /// Draws it.
    pub(crate) fn show(&mut self, ctx: &egui::Context, offers: &[Offer]) -> Outcome {
        let modal = Modal::new(Id::unique("palette")).show(ctx, |ui| self.content(ui, offers));
        if modal.inner == Outcome::Open && modal.should_close() {
            return Outcome::Closed;
        }
        modal.inner
    }

    fn content(&mut self, ui: &mut Ui, offers: &[Offer]) -> Outcome {
        ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 40.0));
        let (up, down, enter) = ui.input_mut(|i| {
            (
                i.consume_key(Modifiers::NONE, Key::ArrowUp),
                i.consume_key(Modifiers::NONE, Key::ArrowDown),
                i.consume_key(Modifiers::NONE, Key::Enter),
            )
        });
        let field = TextEdit::singleline(&mut self.typed)
            .desired_width(f32::INFINITY)
            .hint_text("Find a command");
        let field = ui.add(field);
        field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Find a command"));
        field.request_focus();
        if field.changed() {
            self.chosen = 0;
        }
        let found = found(&self.typed, offers);
        let last = found.len().saturating_sub(1);
        self.chosen = self.chosen.min(last);
        if down {
            self.chosen = if self.chosen == last {
                0
            } else {
                self.chosen + 1
            };
        }
        if up {
            self.chosen = self.chosen.checked_sub(1).unwrap_or(last);
        }
        ui.add_space(4.0);
        if found.is_empty() {
            ui.weak("No command has these letters.");
            return Outcome::Open;
        }
        let mut outcome = Outcome::Open;
        let most = (ui.ctx().content_rect().height() - 160.0).clamp(LINE, LINE * LINES);
        ScrollArea::vertical().max_height(most).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            for (at, offer) in found.iter().enumerate() {
                let is_chosen = at == self.chosen;
                let line = line(ui, offer, is_chosen);
                if is_chosen && (up || down) {
                    line.scroll_to_me(None);
                }
                if offer.possible && (line.clicked() || (enter && is_chosen)) {
                    outcome = Outcome::Run(offer.entry.command);
                }
            }
        });
        outcome
    }
}

/// The offers that fit, best first; those that can do nothing now come last.
fn found<'a>(typed: &str, offers: &'a [Offer]) -> Vec<&'a Offer> {
    let mut scored: Vec<(i32, &Offer)> = offers
        .iter()
        .filter(|o| o.entry.command != Command::Palette)
        .filter_map(|offer| {
            let own = fuzzy::score(typed, &offer.title);
            let with_menu = fuzzy::score(
                typed,
                &format!("{} {}", offer.entry.menu.title(), offer.title),
            );
            Some((own.max(with_menu)?, offer))
        })
        .collect();
    if !typed.trim().is_empty() {
        scored.sort_by_key(|(score, offer)| (!offer.possible, core::cmp::Reverse(*score)));
    }
    scored.into_iter().map(|(_, offer)| offer).collect()
}

/// A line.
fn line(ui: &mut Ui, offer: &Offer, chosen: bool) -> Response {
    let size = vec2(ui.available_width(), LINE);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let keys = offer.entry.shortcut_text(ui.ctx());
    response.widget_info(|| {
        WidgetInfo::selected(Role::ListBoxOption, offer.possible, chosen, &offer.title)
    });
    let fill = if chosen {
        Some(theme::selection_fill(ui.visuals()))
    } else {
        let hovered = ui
            .visuals()
            .widgets
            .hovered
            .weak_bg_fill
            .gamma_multiply(0.5);
        response.hovered().then_some(hovered)
    };
    if let Some(fill) = fill {
        ui.painter().rect_filled(rect, 4, fill);
    }
    let mut inside = ui.new_child(
        egui::UiBuilder::new()
            .max_rect(rect.shrink2(vec2(8.0, 0.0)))
            .layout(egui::Layout::right_to_left(egui::Align::Center)),
    );
    let text = |text: &str| {
        let text = RichText::new(text);
        if offer.possible { text } else { text.weak() }
    };
    inside.add(Label::new(text(&keys).monospace().weak()).selectable(false));
    inside
        .add(Label::new(RichText::new(offer.entry.menu.title()).small().weak()).selectable(false));
    inside.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.add(Label::new(text(&offer.title)).truncate().selectable(false));
    });
    let hint = if offer.possible {
        offer.entry.help.to_owned()
    } else {
        format!("{}\nNot possible now", offer.entry.help)
    };
    response.on_hover_text(hint)
}

/// All commands, as `title` and `possible` say of each.
pub(crate) fn offers(
    title: impl Fn(&Entry) -> String,
    possible: impl Fn(Command) -> bool,
) -> Vec<Offer> {
    let offer = |entry: &'static Entry| Offer {
        title: title(entry),
        possible: possible(entry.command),
        entry,
    };
    TABLE.iter().map(offer).collect()
}
