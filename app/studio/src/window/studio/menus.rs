//! The menu bar, made from the table of commands.

use eframe::egui::{self, MenuBar, ThemePreference, Ui};

use super::Studio;
use crate::commands::{Command, Entry, Menu, TABLE};
use crate::window::action::Action;
use crate::window::start;

impl Studio {
    pub(super) fn menus(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let mut recent_open = false;
        MenuBar::new().ui(ui, |ui| {
            for menu in Menu::ALL {
                ui.menu_button(menu.title(), |ui| {
                    ui.set_min_width(200.0);
                    for entry in TABLE.iter().filter(|e| e.menu == menu) {
                        if entry.starts_group {
                            ui.separator();
                        }
                        let title = self.title_of(entry);
                        let button = egui::Button::new(title)
                            .shortcut_text(entry.shortcut_text(ui.ctx()))
                            .selected(self.is_on(entry.command));
                        let response = ui.add_enabled(self.is_possible(entry.command), button);
                        if response.on_hover_text(entry.help).clicked() {
                            actions.push(Action::Run(entry.command));
                            ui.close();
                        }
                        if entry.command == Command::Open {
                            recent_open |= self.recent_menu(ui, actions);
                        }
                    }
                });
            }
        });
        if self.recent.opens(recent_open) {
            self.look_for_recent();
        }
    }

    /// The projects that were open lately; whether they are shown.
    pub(super) fn recent_menu(&self, ui: &mut Ui, actions: &mut Vec<Action>) -> bool {
        if self.recent.is_empty() {
            ui.add_enabled(false, egui::Button::new("Open recent"))
                .on_disabled_hover_text("No project has been open yet");
            return false;
        }
        let list = ui.menu_button("Open recent", |ui| {
            ui.set_max_width(460.0);
            if start::projects(ui, &self.recent, actions) {
                ui.close();
            }
            ui.separator();
            let clear = ui.button("Clear this list");
            if clear.on_hover_text("The projects stay").clicked() {
                actions.push(Action::ClearRecent);
                ui.close();
            }
        });
        list.inner.is_some()
    }

    /// A command's title with what it would do now.
    pub(super) fn title_of(&self, entry: &Entry) -> String {
        let history = self.document.engine().history();
        let undo = history
            .undo_label()
            .filter(|_| entry.command == Command::Undo);
        let redo = history
            .redo_label()
            .filter(|_| entry.command == Command::Redo);
        match undo.or(redo) {
            Some(label) => format!("{}: {label}", entry.title),
            None => entry.title.to_owned(),
        }
    }

    /// Whether a command that switches something is on.
    fn is_on(&self, command: Command) -> bool {
        if let Command::Toggle(pane) = command {
            return self.layout.is_open(pane);
        }
        if let Command::Use(tool) = command {
            return self.tools.tool == tool;
        }
        if command == Command::Synthesised {
            return self.document.engine().shows_synthesised();
        }
        let themes = [
            (Command::FollowSystem, ThemePreference::System),
            (Command::Dark, ThemePreference::Dark),
            (Command::Light, ThemePreference::Light),
        ];
        themes.contains(&(command, self.settings.theme()))
    }
}
