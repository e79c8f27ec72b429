//! Questions that wait for an answer in front of everything else.

mod go_to;

use std::path::PathBuf;

use eframe::egui::{self, Grid, Id, Key, Modal, RichText, ScrollArea, TextEdit, Ui, WidgetInfo};
use relievo_engine::relink::Link;

use super::inbox::Purpose;
use crate::commands::{Menu, TABLE};

pub(crate) use go_to::Destination;

/// What happens once unsaved changes are saved or given up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// The program ends.
    Quit,
    /// Another project is chosen.
    PickProject,
    /// This project is opened.
    Open(PathBuf),
    /// An empty one is started.
    New,
}

/// A question.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Dialog {
    /// The project has changes that are not saved.
    Unsaved(Then),
    /// Another program changed the project's file.
    ChangedOnDisk,
    /// Whether edits of a run that did not end well are made again.
    Recover {
        /// How many.
        edits: usize,
        /// Whether the file is still what they were made on.
        fits: bool,
    },
    /// Where to fly.
    GoTo(Destination),
    /// All commands.
    Help,
    /// A path to type, where the system has no file dialog.
    Path(Purpose, String),
    /// Whether other missing files, found beside the one that was located, are linked, too.
    Relink {
        /// The layer and the file that was located.
        link: Link,
        /// The others, with the names of their layers.
        beside: Vec<(Link, String)>,
    },
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer {
    /// Nothing happens.
    Cancel,
    /// Save first.
    Save(Then),
    /// Give the changes up.
    Discard(Then),
    /// Save over what the other program wrote.
    Overwrite,
    /// Save under another name.
    SaveAs,
    /// Open what the other program wrote.
    Reload,
    /// Make the edits again, or throw them away.
    Recover(bool),
    /// Fly there.
    GoTo(Destination),
    /// Use this path.
    Path(Purpose, PathBuf),
    /// Link these layers to these files.
    Relink(Vec<Link>),
}

/// Draws a question; `None` until it is answered.
pub(crate) fn show(ctx: &egui::Context, dialog: &mut Dialog, name: &str) -> Option<Answer> {
    let modal = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        ui.set_max_width(440.0);
        match dialog {
            Dialog::Unsaved(then) => unsaved(ui, name, then),
            Dialog::ChangedOnDisk => changed_on_disk(ui, name),
            Dialog::Recover { edits, fits } => recover(ui, name, *edits, *fits),
            Dialog::GoTo(destination) => go_to::show(ui, destination),
            Dialog::Help => help(ui),
            Dialog::Path(purpose, text) => path(ui, *purpose, text),
            Dialog::Relink { link, beside } => relink(ui, link, beside),
        }
    });
    if modal.inner.is_none() && modal.should_close() {
        return Some(Answer::Cancel);
    }
    modal.inner
}

fn unsaved(ui: &mut Ui, name: &str, then: &Then) -> Option<Answer> {
    ui.heading(format!("Save changes to {name}?"));
    ui.label("They are lost otherwise.");
    ui.add_space(8.0);
    buttons(ui, |ui| {
        let save = ui.button(RichText::new("Save").strong()).clicked();
        let discard = ui.button("Don't save").clicked();
        let cancel = ui.button("Cancel").clicked();
        match (save, discard, cancel) {
            (true, ..) => Some(Answer::Save(then.clone())),
            (_, true, _) => Some(Answer::Discard(then.clone())),
            (.., true) => Some(Answer::Cancel),
            _ => None,
        }
    })
}

fn changed_on_disk(ui: &mut Ui, name: &str) -> Option<Answer> {
    ui.heading(format!("{name} changed on disk"));
    ui.label("Another program wrote the file since it was opened. Nothing has been overwritten.");
    ui.add_space(8.0);
    buttons(ui, |ui| {
        let choices = [
            ("Save as…", "Keep both", Answer::SaveAs),
            (
                "Overwrite",
                "Keep what is in this window",
                Answer::Overwrite,
            ),
            ("Reload", "Keep what is on disk", Answer::Reload),
            ("Cancel", "Decide later", Answer::Cancel),
        ];
        choices.into_iter().find_map(|(text, hint, answer)| {
            ui.button(text)
                .on_hover_text(hint)
                .clicked()
                .then_some(answer)
        })
    })
}

fn recover(ui: &mut Ui, name: &str, edits: usize, fits: bool) -> Option<Answer> {
    ui.heading(format!("Recover unsaved work on {name}?"));
    let what = if edits == 1 {
        "1 edit was".to_owned()
    } else {
        format!("{edits} edits were")
    };
    ui.label(format!(
        "{what} made and never saved: the program ended before."
    ));
    if !fits {
        ui.label("The file was changed since; some edits may not fit any more.");
    }
    ui.add_space(8.0);
    buttons(ui, |ui| {
        let choices = [
            (
                "Recover",
                "Make them again; each can be undone",
                Answer::Recover(true),
            ),
            (
                "Throw away",
                "They are lost for good",
                Answer::Recover(false),
            ),
            ("Decide later", "They are offered again", Answer::Cancel),
        ];
        choices.into_iter().find_map(|(text, hint, answer)| {
            let button = ui.button(text).on_hover_text(hint);
            button.clicked().then_some(answer)
        })
    })
}

fn relink(ui: &mut Ui, link: &Link, beside: &[(Link, String)]) -> Option<Answer> {
    let folder = link.file.parent().unwrap_or(&link.file);
    let (what, all) = match beside {
        [(_, name)] => (
            format!("Link {name}, too?"),
            "Its file is missing, and one of its name lies in the same folder:",
        ),
        _ => (
            format!("Link {} more layers?", beside.len()),
            "Their files are missing, and files of their names lie in the same folder:",
        ),
    };
    ui.heading(what);
    ui.label(all);
    ui.weak(folder.display().to_string());
    ui.add_space(4.0);
    let most = (ui.ctx().content_rect().height() - 220.0).clamp(60.0, 240.0);
    ScrollArea::vertical().max_height(most).show(ui, |ui| {
        for (other, name) in beside {
            let file = other.file.file_name().unwrap_or_default();
            ui.label(format!("{name}: {}", file.to_string_lossy()));
        }
    });
    ui.add_space(8.0);
    buttons(ui, |ui| {
        let all = ui
            .button(RichText::new("Link all").strong())
            .on_hover_text("One undo step takes all of them back");
        if ui.memory(|m| m.focused().is_none()) {
            all.request_focus();
        }
        let one = ui
            .button("Only the one")
            .on_hover_text("The other layers stay as they are");
        let cancel = ui.button("Cancel").on_hover_text("Nothing is linked");
        if all.clicked() {
            let others = beside.iter().map(|(other, _)| other.clone());
            return Some(Answer::Relink(
                std::iter::once(link.clone()).chain(others).collect(),
            ));
        }
        if one.clicked() {
            return Some(Answer::Relink(vec![link.clone()]));
        }
        cancel.clicked().then_some(Answer::Cancel)
    })
}

fn help(ui: &mut Ui) -> Option<Answer> {
    ui.heading("Commands and keys");
    // The button below must stay on the screen of a small window, too.
    let most = (ui.ctx().content_rect().height() - 180.0).clamp(80.0, 460.0);
    ScrollArea::vertical().max_height(most).show(ui, |ui| {
        ui.add_space(4.0);
        ui.strong("Moving");
        let moving = [
            ("Drag", "Move the ground under the pointer"),
            (
                "Right drag, Ctrl+drag",
                "Turn around the place under the pointer",
            ),
            ("Wheel, pinch", "Zoom towards the pointer"),
            ("Double click", "Fly there"),
            ("W A S D", "Fly ahead, left, back, right"),
            ("E, Q", "Climb, descend"),
            ("Shift", "Fly faster"),
            ("Escape", "Take the drag of a slider back"),
        ];
        Grid::new("moving")
            .num_columns(2)
            .striped(true)
            .spacing([16.0, 3.0])
            .show(ui, |ui| {
                for (keys, what) in moving {
                    ui.monospace(keys);
                    ui.label(what);
                    ui.end_row();
                }
            });
        for menu in Menu::ALL {
            ui.add_space(6.0);
            ui.strong(menu.title());
            Grid::new(menu.title())
                .num_columns(2)
                .striped(true)
                .spacing([16.0, 3.0])
                .show(ui, |ui| {
                    for entry in TABLE.iter().filter(|e| e.menu == menu) {
                        ui.monospace(entry.shortcut_text(ui.ctx()));
                        ui.label(format!(
                            "{}: {}",
                            entry.title.trim_end_matches('…'),
                            entry.help
                        ));
                        ui.end_row();
                    }
                });
        }
    });
    ui.add_space(8.0);
    buttons(ui, |ui| {
        ui.button("Close").clicked().then_some(Answer::Cancel)
    })
}

fn path(ui: &mut Ui, purpose: Purpose, text: &mut String) -> Option<Answer> {
    let (title, go) = match purpose {
        Purpose::Open => ("Open project", "Open"),
        Purpose::Save => ("Save project as", "Save"),
        Purpose::Add => ("Add a raster file", "Add"),
        Purpose::Picture => ("Save picture as", "Save"),
        Purpose::Locate => ("Locate the layer's file", "Link"),
        Purpose::Export(export) => (export.title(), "Save"),
    };
    ui.heading(title);
    ui.weak("This desktop has no file dialog; type the path.");
    let field = ui.add(
        TextEdit::singleline(text)
            .desired_width(f32::INFINITY)
            .hint_text("/folder/file"),
    );
    field.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "Path"));
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    if !entered && ui.memory(|m| m.focused().is_none()) {
        field.request_focus();
    }
    ui.add_space(8.0);
    buttons(ui, |ui| {
        let use_it = ui.add_enabled(
            !text.trim().is_empty(),
            egui::Button::new(RichText::new(go).strong()),
        );
        let cancel = ui.button("Cancel").clicked();
        if use_it.clicked() || (entered && !text.trim().is_empty()) {
            return Some(Answer::Path(purpose, PathBuf::from(text.trim())));
        }
        cancel.then_some(Answer::Cancel)
    })
}

fn buttons(ui: &mut Ui, content: impl FnOnce(&mut Ui) -> Option<Answer>) -> Option<Answer> {
    ui.horizontal(content).inner
}
