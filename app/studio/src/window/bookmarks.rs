//! Places to go back to.

use eframe::egui::{self, ScrollArea, TextEdit, Ui, WidgetInfo};
use relievo_engine::planet::Camera;
use relievo_engine::project::{Bookmark, CameraSettings, Edit, Extra, Project};

use super::action::Action;
use super::status::length;
use crate::commands::{Command, entry_of};

/// The name that is being typed.
#[derive(Debug, Default)]
pub(crate) struct Bookmarks {
    typed: Option<(usize, String)>,
}

impl Bookmarks {
    /// Draws the list.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        camera: &Camera,
        actions: &mut Vec<Action>,
    ) {
        let entry = entry_of(Command::AddBookmark);
        if ui.button(entry.title).on_hover_text(entry.help).clicked() {
            actions.push(Action::Run(Command::AddBookmark));
        }
        if project.bookmarks.is_empty() {
            ui.add_space(8.0);
            ui.weak("No bookmarks yet. One keeps where you are and how you look.");
            return;
        }
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                for (index, bookmark) in project.bookmarks.iter().enumerate() {
                    ui.push_id(index, |ui| {
                        ui.horizontal(|ui| self.row(ui, index, bookmark, camera, actions));
                    });
                }
            });
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        index: usize,
        bookmark: &Bookmark,
        camera: &Camera,
        actions: &mut Vec<Action>,
    ) {
        let name = &bookmark.name;
        let named = |ui: &mut Ui, text: &str, spoken: String, hint: &str| {
            let button = ui.small_button(text);
            button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &spoken));
            button.on_hover_text(hint).clicked()
        };
        let to = &bookmark.camera;
        let hint = format!(
            "Fly there: {:.4}, {:.4} at {}",
            to.lat_deg,
            to.lon_deg,
            length(to.altitude_m)
        );
        if named(ui, "Go", format!("Go to {name}"), &hint) {
            actions.push(Action::Fly(to.to_camera()));
        }
        let mut own = name.clone();
        let text = match &mut self.typed {
            Some((typed, text)) if *typed == index => text,
            _ => &mut own,
        };
        let width = (ui.available_width() - 92.0).max(60.0);
        let field = ui.add(
            TextEdit::singleline(text)
                .desired_width(width)
                .char_limit(250),
        );
        field.widget_info(|| {
            WidgetInfo::labeled(egui::Role::TextInput, true, format!("Name of {name}"))
        });
        let text = text.clone();
        let is_typed = self
            .typed
            .as_ref()
            .is_some_and(|(typed, _)| *typed == index);
        if field.has_focus() && !is_typed {
            self.typed = Some((index, text));
        } else if field.lost_focus()
            && self.typed.take().is_some()
            && !ui.input(|i| i.key_pressed(egui::Key::Escape))
            && text.trim() != name
        {
            actions.push(replace(
                index,
                Bookmark {
                    name: text.trim().to_owned(),
                    ..bookmark.clone()
                },
            ));
        }
        if named(
            ui,
            "Here",
            format!("Move {name} here"),
            "Keep the present view under this name",
        ) {
            actions.push(replace(
                index,
                Bookmark {
                    camera: bookmark.camera.with_camera(camera),
                    ..bookmark.clone()
                },
            ));
        }
        if named(ui, "×", format!("Remove {name}"), "Remove this bookmark") {
            actions.push(Action::Edit(Edit::RemoveBookmark { index }));
        }
    }
}

fn replace(index: usize, bookmark: Bookmark) -> Action {
    Action::Edit(Edit::ReplaceBookmark { index, bookmark })
}

/// A bookmark of a camera.
pub(crate) fn of(camera: &Camera, name: String) -> Bookmark {
    Bookmark {
        name,
        camera: CameraSettings::default().with_camera(camera),
        extra: Extra::new(),
    }
}
