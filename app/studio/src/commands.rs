//! The one table of commands: menus, shortcuts and help are made from it.

use eframe::egui::{Context, Key, KeyboardShortcut, Modifiers};

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
    /// Adds a layer that colours heights.
    AddTint,
    /// Removes the selected layer.
    RemoveLayer,
    /// Moves the selected layer up in the list.
    MoveUp,
    /// Moves the selected layer down in the list.
    MoveDown,
    /// Shows or hides the selected layer.
    ToggleVisible,
    /// Flies to where the selected layer is seen whole.
    ZoomToLayer,
    /// Links the selected layer to another file.
    Locate,
    /// Turns north up.
    NorthUp,
    /// Returns to the camera of the project file.
    ResetView,
    /// Asks for coordinates and flies there.
    GoTo,
    /// Shows or hides the layers.
    ToggleLayers,
    /// Shows or hides the inspector.
    ToggleInspector,
    /// Shows or hides the messages.
    ToggleMessages,
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
    /// The camera and the panels.
    View,
    /// Help.
    Help,
}

impl Menu {
    /// All of them, from left to right.
    pub const ALL: [Self; 5] = [Self::File, Self::Edit, Self::Layer, Self::View, Self::Help];

    /// What the menu bar calls it.
    pub fn title(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Layer => "Layer",
            Self::View => "View",
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

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);
const ALT: Modifiers = Modifiers::ALT;
const PLAIN: Modifiers = Modifiers::NONE;

const fn keys(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

const fn entry(
    command: Command,
    menu: Menu,
    title: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Entry {
    Entry {
        command,
        menu,
        title,
        help,
        shortcuts,
        starts_group: false,
    }
}

const fn group(entry: Entry) -> Entry {
    Entry {
        starts_group: true,
        ..entry
    }
}

/// All commands, in the order of their menus.
pub const TABLE: &[Entry] = &[
    entry(
        Command::New,
        Menu::File,
        "New project",
        "Start with an empty Earth",
        &[keys(CTRL, Key::N)],
    ),
    entry(
        Command::Open,
        Menu::File,
        "Open project…",
        "Open a .relievo file",
        &[keys(CTRL, Key::O)],
    ),
    group(entry(
        Command::Save,
        Menu::File,
        "Save",
        "Save the project",
        &[keys(CTRL, Key::S)],
    )),
    entry(
        Command::SaveAs,
        Menu::File,
        "Save as…",
        "Save the project under another name",
        &[keys(CTRL_SHIFT, Key::S)],
    ),
    entry(
        Command::Screenshot,
        Menu::File,
        "Save picture…",
        "Save what the viewport shows as PNG",
        &[keys(CTRL_SHIFT, Key::P)],
    ),
    group(entry(
        Command::Quit,
        Menu::File,
        "Quit",
        "Close the studio",
        &[keys(CTRL, Key::Q)],
    )),
    entry(
        Command::Undo,
        Menu::Edit,
        "Undo",
        "Take the last edit back",
        &[keys(CTRL, Key::Z)],
    ),
    entry(
        Command::Redo,
        Menu::Edit,
        "Redo",
        "Make the last undone edit again",
        &[keys(CTRL_SHIFT, Key::Z), keys(CTRL, Key::Y)],
    ),
    entry(
        Command::AddFiles,
        Menu::Layer,
        "Add files…",
        "Add imagery or heights from raster files and sets of tiles",
        &[keys(CTRL_SHIFT, Key::O)],
    ),
    entry(
        Command::AddNoise,
        Menu::Layer,
        "Add noise heights",
        "Add heights from fractal noise",
        &[],
    ),
    entry(
        Command::AddTint,
        Menu::Layer,
        "Add height colours",
        "Add colours by height",
        &[],
    ),
    group(entry(
        Command::ToggleVisible,
        Menu::Layer,
        "Show or hide",
        "Show or hide the selected layer",
        &[keys(CTRL, Key::H)],
    )),
    entry(
        Command::ZoomToLayer,
        Menu::Layer,
        "Fly to layer",
        "Fly to where the selected layer is seen whole",
        &[keys(PLAIN, Key::F)],
    ),
    entry(
        Command::Locate,
        Menu::Layer,
        "Locate file…",
        "Link the selected layer to a file that was moved, or to another one",
        &[keys(CTRL, Key::L)],
    ),
    entry(
        Command::MoveUp,
        Menu::Layer,
        "Move up",
        "Draw the selected layer later, over its neighbour",
        &[keys(ALT, Key::ArrowUp)],
    ),
    entry(
        Command::MoveDown,
        Menu::Layer,
        "Move down",
        "Draw the selected layer earlier, under its neighbour",
        &[keys(ALT, Key::ArrowDown)],
    ),
    entry(
        Command::RemoveLayer,
        Menu::Layer,
        "Remove",
        "Remove the selected layer; its file stays",
        &[keys(PLAIN, Key::Delete)],
    ),
    entry(
        Command::NorthUp,
        Menu::View,
        "North up",
        "Turn until north is up",
        &[keys(PLAIN, Key::N)],
    ),
    entry(
        Command::ResetView,
        Menu::View,
        "Reset view",
        "Return to the camera that the project was saved with",
        &[keys(PLAIN, Key::Home)],
    ),
    entry(
        Command::GoTo,
        Menu::View,
        "Go to…",
        "Fly to coordinates",
        &[keys(CTRL, Key::G)],
    ),
    group(entry(
        Command::ToggleLayers,
        Menu::View,
        "Layers",
        "Show or hide the list of layers",
        &[keys(CTRL_SHIFT, Key::L)],
    )),
    entry(
        Command::ToggleInspector,
        Menu::View,
        "Inspector",
        "Show or hide the settings of the selected layer and the scene",
        &[keys(CTRL_SHIFT, Key::I)],
    ),
    entry(
        Command::ToggleMessages,
        Menu::View,
        "Messages",
        "Show or hide problems and news",
        &[keys(CTRL_SHIFT, Key::M)],
    ),
    group(entry(
        Command::Retry,
        Menu::View,
        "Try again",
        "Try files and tiles again that failed",
        &[keys(PLAIN, Key::F5)],
    )),
    entry(
        Command::Help,
        Menu::Help,
        "Commands and keys",
        "Show all commands and how to move",
        &[keys(PLAIN, Key::F1)],
    ),
];

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

/// The commands whose keys are pressed, which are then used up. While a text is being edited only
/// keys with Ctrl count.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    let typing = ctx.text_edit_focused();
    let mut all: Vec<(&KeyboardShortcut, Command)> = TABLE
        .iter()
        .flat_map(|e| e.shortcuts.iter().map(|s| (s, e.command)))
        .collect();
    // Ctrl+Shift+S is also Ctrl+S to who looks at Ctrl only.
    all.sort_by_key(|(s, _)| core::cmp::Reverse(modifiers(**s)));
    let allowed = |s: &KeyboardShortcut| {
        !typing || (s.modifiers.command && s.logical_key != Key::Z && s.logical_key != Key::Y)
    };
    ctx.input_mut(|input| {
        all.into_iter()
            .filter(|(s, _)| allowed(s))
            .filter(|(s, _)| input.consume_shortcut(s))
            .map(|(_, c)| c)
            .collect()
    })
}

fn modifiers(shortcut: KeyboardShortcut) -> u8 {
    let m = shortcut.modifiers;
    u8::from(m.command) + u8::from(m.shift) + u8::from(m.alt)
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
