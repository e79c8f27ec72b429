//! The one table of commands: menus, shortcuts, the palette and help are made from it.

mod keys;
mod table;

use eframe::egui::{Context, KeyboardShortcut};

use crate::window::{Mode, Pane, Tool};

pub use keys::{pressed, uses_keys};
pub use table::TABLE;

/// Something that the user can ask the window to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Starts an empty project.
    New,
    /// Opens a project file.
    Open,
    /// Saves the project.
    Save,
    /// Saves the project under another name.
    SaveAs,
    /// Saves the picture of the viewport.
    Screenshot,
    /// Ends the program.
    Quit,
    /// Takes the last edit back.
    Undo,
    /// Makes the last undone edit again.
    Redo,
    /// Adds layers from raster files.
    AddFiles,
    /// Adds a layer of noise.
    AddNoise,
    /// Adds a layer that continues heights beyond their resolution.
    AddDetail,
    /// Adds a layer that colours heights.
    AddTint,
    /// Adds a layer that colours slopes.
    AddSlope,
    /// Adds a layer of contour lines.
    AddContours,
    /// Removes the selected element or layer.
    RemoveLayer,
    /// Moves the selected element or layer up in the list.
    MoveUp,
    /// Moves the selected element or layer down in the list.
    MoveDown,
    /// Shows or hides the selected element or layer.
    ToggleVisible,
    /// Flies to where the selected element or layer is seen whole.
    ZoomToLayer,
    /// Links the selected layer to another file.
    Locate,
    /// Takes a tool for the terrain.
    Use(Tool),
    /// Compares the shown scenario with another.
    Compare(Mode),
    /// Ends the comparison.
    StopComparing,
    /// Measures volumes and areas between two scenarios.
    Volumes,
    /// Makes contours of what the view shows.
    Contours,
    /// Forgets what was measured.
    ClearResults,
    /// Keeps the present view.
    AddBookmark,
    /// Turns north up.
    NorthUp,
    /// Returns to the camera of the project file.
    ResetView,
    /// Asks for coordinates and flies there.
    GoTo,
    /// Colours the ground where detail is synthesised, or no longer.
    Synthesised,
    /// Shows a pane, brings it to the front or hides it.
    Toggle(Pane),
    /// Puts all panes where they were at first.
    ResetPanes,
    /// Looks for a command by its name.
    Palette,
    /// Uses the colours that the system asks for.
    FollowSystem,
    /// Dark colours.
    Dark,
    /// Light colours.
    Light,
    /// Makes everything larger.
    Larger,
    /// Makes everything smaller.
    Smaller,
    /// Everything as large as the system says.
    UsualSize,
    /// Tries again what failed.
    Retry,
    /// Shows all commands and how to move.
    Help,
}

/// Menus of the menu bar, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Files and the program.
    File,
    /// Undo and redo.
    Edit,
    /// Layers.
    Layer,
    /// Planning elements and measuring.
    Draw,
    /// What is measured on the terrain.
    Analyse,
    /// The camera and how the window looks.
    View,
    /// The panes.
    Panes,
    /// Help.
    Help,
}

impl Menu {
    /// All of them, from left to right.
    pub const ALL: [Self; 8] = [
        Self::File,
        Self::Edit,
        Self::Layer,
        Self::Draw,
        Self::Analyse,
        Self::View,
        Self::Panes,
        Self::Help,
    ];

    /// What the menu bar calls it.
    pub fn title(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Layer => "Layer",
            Self::Draw => "Draw",
            Self::Analyse => "Analyse",
            Self::View => "View",
            Self::Panes => "Panes",
            Self::Help => "Help",
        }
    }
}

/// One line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The command.
    pub command: Command,
    /// Its menu.
    pub menu: Menu,
    /// What menus and help call it.
    pub title: &'static str,
    /// What it does, for tooltips and help.
    pub help: &'static str,
    /// The keys that ask for it.
    pub shortcuts: &'static [KeyboardShortcut],
    /// Whether a line is drawn above it in its menu.
    pub starts_group: bool,
}

impl Entry {
    /// Its first shortcut as text, empty without one.
    pub fn shortcut_text(&self, ctx: &Context) -> String {
        self.shortcuts
            .first()
            .map(|s| ctx.format_shortcut(s))
            .unwrap_or_default()
    }
}

/// The table's line of a command.
///
/// # Panics
/// Never: every command is in the table, as a test says.
pub fn entry_of(command: Command) -> &'static Entry {
    TABLE
        .iter()
        .find(|e| e.command == command)
        .expect("every command is in the table")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_keys_or_titles() {
        for (i, a) in TABLE.iter().enumerate() {
            for b in &TABLE[i + 1..] {
                assert_ne!(a.command, b.command);
                assert_ne!(a.title, b.title);
                assert!(
                    !a.shortcuts.iter().any(|s| b.shortcuts.contains(s)),
                    "{} and {}",
                    a.title,
                    b.title
                );
            }
        }
    }

    #[test]
    fn every_command_says_what_it_does() {
        for e in TABLE {
            assert!(!e.title.is_empty() && !e.help.is_empty());
            assert_eq!(entry_of(e.command).title, e.title);
        }
    }
}
