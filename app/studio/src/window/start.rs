//! What an empty window offers: projects, files, samples.

use std::path::{Path, PathBuf};

use eframe::egui::{
    Align2, Button, Color32, Frame, Label, Margin, Rect, RichText, ScrollArea, Ui, UiBuilder, vec2,
};

use super::action::Action;
use super::recent::Recent;
use super::theme;
use crate::commands::{Command, entry_of};

/// Width of the offers in points.
const WIDTH: f32 = 360.0;

/// Folders above the program that may hold the samples: it lies in `target/debug` when it is built.
const FOLDERS_ABOVE: usize = 4;

/// Projects in the folder `projects` here or above the program: those that come with it.
pub(crate) fn samples() -> Vec<PathBuf> {
    let here = std::env::current_dir().ok();
    let program = std::env::current_exe().ok();
    let above = program
        .iter()
        .flat_map(|p| p.ancestors().skip(1).take(FOLDERS_ABOVE));
    let mut folders = here.iter().map(PathBuf::as_path).chain(above);
    folders
        .find_map(|folder| {
            let found = projects_in(&folder.join("projects"));
            (!found.is_empty()).then_some(found)
        })
        .unwrap_or_default()
}

fn projects_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let paths = entries.filter_map(|e| Some(e.ok()?.path()));
    let mut found: Vec<PathBuf> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "relievo"))
        .collect();
    found.sort();
    found
}

/// What is offered.
pub(crate) struct Offers<'a> {
    /// Projects that come with the program.
    pub(crate) samples: &'a [PathBuf],
    /// Projects that were open lately.
    pub(crate) recent: &'a Recent,
    /// Why nothing can be drawn, if nothing can.
    pub(crate) trouble: Option<&'a str>,
}

/// Draws the offers in the middle of a rectangle, as many as fit.
pub(crate) fn show(ui: &mut Ui, rect: Rect, offers: &Offers, actions: &mut Vec<Action>) {
    let most = (rect.size() - vec2(32.0, 48.0)).max(vec2(120.0, 80.0));
    let rows = 2 + offers.samples.len().div_ceil(3) + offers.recent.paths().len();
    let wanted = vec2(WIDTH, 190.0 + 30.0 * rows as f32);
    let area = Align2::CENTER_CENTER.align_size_within_rect(wanted.min(most), rect);
    let mut ui = ui.new_child(UiBuilder::new().max_rect(area));
    // Over a picture that is dark whatever the theme.
    ui.style_mut().visuals = eframe::egui::Visuals::dark();
    let frame = Frame::new()
        .fill(theme::OVERLAY)
        .corner_radius(eframe::egui::CornerRadius::same(10))
        .inner_margin(Margin::same(18));
    frame.show(&mut ui, |ui| {
        ui.set_width(area.width() - 36.0);
        ui.set_max_height(area.height() - 36.0);
        ScrollArea::vertical()
            .auto_shrink([false, true])
            .show(ui, |ui| content(ui, offers, actions));
    });
}

fn content(ui: &mut Ui, offers: &Offers, actions: &mut Vec<Action>) {
    ui.label(RichText::new("Relievo").size(26.0).color(Color32::WHITE));
    ui.label("Terrain on a whole planet");
    if let Some(reason) = offers.trouble {
        let text = format!(
            "Nothing can be drawn here: {reason}. Everything else works; `relievo render` may, too."
        );
        let text = RichText::new(text).color(ui.visuals().warn_fg_color);
        ui.add(Label::new(text).wrap());
    }
    ui.add_space(8.0);
    for (command, title) in [
        (Command::Open, "Open project…"),
        (Command::AddFiles, "New from files…"),
    ] {
        let entry = entry_of(command);
        let button = Button::new(title)
            .shortcut_text(entry.shortcut_text(ui.ctx()))
            .min_size(vec2(ui.available_width(), 28.0));
        if ui.add(button).on_hover_text(entry.help).clicked() {
            actions.push(Action::Run(command));
        }
    }
    if !offers.samples.is_empty() {
        ui.add_space(8.0);
        ui.strong("Samples");
        ui.horizontal_wrapped(|ui| {
            for path in offers.samples {
                open_button(ui, path, title_of(path), true, actions);
            }
        });
    }
    if !offers.recent.is_empty() {
        ui.add_space(8.0);
        ui.strong("Recent");
        projects(ui, offers.recent, actions);
    }
    ui.add_space(8.0);
    ui.add(Label::new(RichText::new("Or drop a project or raster files here").weak()).wrap());
}

/// A button for each project of the list; whether one was clicked.
pub(crate) fn projects(ui: &mut Ui, recent: &Recent, actions: &mut Vec<Action>) -> bool {
    let mut clicked = false;
    for (path, there) in recent.projects() {
        clicked |= open_button(ui, path, label_of(path), there, actions);
    }
    clicked
}

/// A button that opens a project; whether it was clicked.
fn open_button(
    ui: &mut Ui,
    path: &Path,
    title: String,
    there: bool,
    actions: &mut Vec<Action>,
) -> bool {
    let response = ui.add_enabled(there, Button::new(title).truncate());
    let missing = format!("{}\nis not there any more", path.display());
    let response = response
        .on_hover_text(path.display().to_string())
        .on_disabled_hover_text(missing);
    if response.clicked() {
        actions.push(Action::Open(path.to_owned()));
        return true;
    }
    false
}

/// A project's name as a title.
fn title_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut letters = stem.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// A project's name and where it is.
fn label_of(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => {
            format!("{name}  –  {}", folder.display())
        }
        _ => name.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projects_are_told_by_name_and_folder() {
        assert_eq!(title_of(Path::new("/a/earth.relievo")), "Earth");
        assert_eq!(label_of(Path::new("/a/b/earth.relievo")), "earth  –  /a/b");
        assert_eq!(label_of(Path::new("earth.relievo")), "earth");
    }
}
