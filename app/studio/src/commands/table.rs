//! The table: every command once, in the order of its menu.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Entry, Menu};
use crate::window::{Mode, Pane, Tool};

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

const fn tool(
    tool: Tool,
    title: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Entry {
    entry(Command::Use(tool), Menu::Draw, title, help, shortcuts)
}

const fn analyse(
    command: Command,
    title: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Entry {
    entry(command, Menu::Analyse, title, help, shortcuts)
}

const fn pane(
    pane: Pane,
    title: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Entry {
    entry(Command::Toggle(pane), Menu::Panes, title, help, shortcuts)
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
        Command::AddDetail,
        Menu::Layer,
        "Add detail",
        "Continue the heights below beyond their resolution, as rough as their own data say",
        &[],
    ),
    entry(
        Command::AddTint,
        Menu::Layer,
        "Add height colours",
        "Add colours by height",
        &[],
    ),
    entry(
        Command::AddSlope,
        Menu::Layer,
        "Add slope colours",
        "Add colours by the steepness of the ground, planning elements included",
        &[],
    ),
    entry(
        Command::AddContours,
        Menu::Layer,
        "Add contour lines",
        "Add lines of equal height of the ground, planning elements included",
        &[],
    ),
    group(entry(
        Command::ToggleVisible,
        Menu::Layer,
        "Show or hide",
        "Show or hide the selected element or layer",
        &[keys(CTRL, Key::H)],
    )),
    entry(
        Command::ZoomToLayer,
        Menu::Layer,
        "Fly to selected",
        "Fly to where the selected element or layer is seen whole",
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
        "Move the selected element or layer up, over its neighbour",
        &[keys(ALT, Key::ArrowUp)],
    ),
    entry(
        Command::MoveDown,
        Menu::Layer,
        "Move down",
        "Move the selected element or layer down, under its neighbour",
        &[keys(ALT, Key::ArrowDown)],
    ),
    entry(
        Command::RemoveLayer,
        Menu::Layer,
        "Remove",
        "Remove the selected element or layer; files stay",
        &[keys(PLAIN, Key::Delete)],
    ),
    tool(
        Tool::Select,
        "Select and edit",
        "Select elements, drag their vertices, move the ground",
        &[keys(PLAIN, Key::V)],
    ),
    tool(
        Tool::Polygon,
        "Draw polygon",
        "Draw an area with a surface of its own",
        &[keys(PLAIN, Key::P)],
    ),
    tool(
        Tool::Hole,
        "Draw hole",
        "Draw a hole into the selected polygon",
        &[keys(PLAIN, Key::H)],
    ),
    tool(
        Tool::Breakline,
        "Draw breakline",
        "Draw a line that the selected polygon's surface through vertices follows",
        &[keys(PLAIN, Key::K)],
    ),
    tool(
        Tool::Corridor,
        "Draw corridor",
        "Draw a road, dam, trench or channel along a line",
        &[keys(PLAIN, Key::C)],
    ),
    tool(
        Tool::Brush,
        "Brush",
        "Raise, lower, smooth or flatten the ground by hand",
        &[keys(PLAIN, Key::B)],
    ),
    tool(
        Tool::Lens,
        "Lens",
        "Show the selected layer only in a circle or polygon that is dragged over the terrain",
        &[keys(PLAIN, Key::X)],
    ),
    tool(
        Tool::LensOutline,
        "Draw lens",
        "Draw the outline of a polygon in which alone the selected layer shows",
        &[],
    ),
    analyse(
        Command::Use(Tool::Measure),
        "Measure",
        "Measure lengths and areas on the terrain",
        &[keys(PLAIN, Key::M)],
    ),
    analyse(
        Command::Volumes,
        "Measure volumes",
        "Measure cut, fill and areas between two scenarios",
        &[],
    ),
    analyse(
        Command::Use(Tool::Observer),
        "See from a place",
        "Place an observer on the terrain to see what is in sight",
        &[keys(PLAIN, Key::O)],
    ),
    analyse(
        Command::Use(Tool::Water),
        "Flood from a place",
        "Choose a place on the terrain where still water stands",
        &[keys(PLAIN, Key::U)],
    ),
    analyse(
        Command::Contours,
        "Contours of this view",
        "Make contour lines of what the view shows, to write them to a file",
        &[],
    ),
    group(analyse(
        Command::ClearResults,
        "Clear results",
        "Forget what was measured and take it off the terrain",
        &[],
    )),
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
        "Fly to a place by its name, or to coordinates",
        &[keys(CTRL, Key::G)],
    ),
    entry(
        Command::AddBookmark,
        Menu::View,
        "Add bookmark",
        "Keep the present view under a name",
        &[keys(CTRL, Key::D)],
    ),
    entry(
        Command::Synthesised,
        Menu::View,
        "Show synthesised detail",
        "Colour the ground where its heights are continued beyond what was measured, or no longer",
        &[],
    ),
    group(entry(
        Command::Compare(Mode::Swipe),
        Menu::View,
        "Compare: swipe",
        "Show two scenarios left and right of a line that can be dragged",
        &[],
    )),
    entry(
        Command::Compare(Mode::SideBySide),
        Menu::View,
        "Compare: side by side",
        "Show two scenarios beside each other through the same camera",
        &[],
    ),
    entry(
        Command::Compare(Mode::Blink),
        Menu::View,
        "Compare: hold X",
        "Show the other scenario while the key X is held",
        &[],
    ),
    entry(
        Command::Compare(Mode::Difference),
        Menu::View,
        "Compare: difference of heights",
        "Show where the ground is higher or lower as colours",
        &[],
    ),
    entry(
        Command::StopComparing,
        Menu::View,
        "Stop comparing",
        "Show one scenario again",
        &[],
    ),
    group(entry(
        Command::Retry,
        Menu::View,
        "Try again",
        "Try files and tiles again that failed",
        &[keys(PLAIN, Key::F5)],
    )),
    group(entry(
        Command::FollowSystem,
        Menu::View,
        "Colours of the system",
        "Dark or light as the system asks for",
        &[],
    )),
    entry(
        Command::Dark,
        Menu::View,
        "Dark",
        "Light text on dark ground",
        &[],
    ),
    entry(
        Command::Light,
        Menu::View,
        "Light",
        "Dark text on light ground",
        &[],
    ),
    group(entry(
        Command::Larger,
        Menu::View,
        "Larger",
        "Make text and controls larger",
        &[keys(CTRL, Key::Plus), keys(CTRL, Key::Equals)],
    )),
    entry(
        Command::Smaller,
        Menu::View,
        "Smaller",
        "Make text and controls smaller",
        &[keys(CTRL, Key::Minus)],
    ),
    entry(
        Command::UsualSize,
        Menu::View,
        "Usual size",
        "Make text and controls as large as the system says",
        &[keys(CTRL, Key::Num0)],
    ),
    pane(
        Pane::Layers,
        "Layers",
        "Show or hide the list of layers",
        &[keys(CTRL_SHIFT, Key::L)],
    ),
    pane(
        Pane::Elements,
        "Elements",
        "Show or hide the list of planning elements",
        &[keys(CTRL_SHIFT, Key::D)],
    ),
    pane(
        Pane::Scenarios,
        "Scenarios",
        "Show or hide the tree of scenarios",
        &[keys(CTRL_SHIFT, Key::A)],
    ),
    pane(
        Pane::Bookmarks,
        "Bookmarks",
        "Show or hide places to go back to",
        &[keys(CTRL_SHIFT, Key::B)],
    ),
    pane(
        Pane::Inspector,
        "Inspector",
        "Show or hide the settings of what is selected",
        &[keys(CTRL_SHIFT, Key::I)],
    ),
    pane(
        Pane::Scene,
        "Scene",
        "Show or hide light, planet and quality",
        &[keys(CTRL_SHIFT, Key::E)],
    ),
    pane(
        Pane::History,
        "History",
        "Show or hide what can be undone and redone",
        &[keys(CTRL_SHIFT, Key::H)],
    ),
    pane(
        Pane::Messages,
        "Messages",
        "Show or hide problems and news",
        &[keys(CTRL_SHIFT, Key::M)],
    ),
    pane(
        Pane::Place,
        "Place",
        "Show or hide what made the ground under the pointer",
        &[keys(CTRL_SHIFT, Key::W)],
    ),
    pane(
        Pane::Histogram,
        "Histogram",
        "Show or hide how often each value is seen in the selected layer",
        &[keys(CTRL_SHIFT, Key::G)],
    ),
    pane(
        Pane::Match,
        "Match",
        "Show or hide what makes layers look like each other",
        &[keys(CTRL_SHIFT, Key::X)],
    ),
    pane(
        Pane::Profile,
        "Profile",
        "Show or hide heights along what is measured or selected",
        &[keys(CTRL_SHIFT, Key::F)],
    ),
    pane(
        Pane::Volumes,
        "Volumes",
        "Show or hide volumes and areas between two scenarios",
        &[keys(CTRL_SHIFT, Key::U)],
    ),
    pane(
        Pane::Viewshed,
        "Viewshed",
        "Show or hide what is seen from a place",
        &[keys(CTRL_SHIFT, Key::J)],
    ),
    pane(
        Pane::Flood,
        "Flood",
        "Show or hide still water at a level",
        &[keys(CTRL_SHIFT, Key::R)],
    ),
    pane(
        Pane::Contours,
        "Contours",
        "Show or hide contours to be written to a file",
        &[keys(CTRL_SHIFT, Key::K)],
    ),
    pane(
        Pane::Graph,
        "Graph",
        "Show or hide the nodes that make the picture",
        &[keys(CTRL_SHIFT, Key::N)],
    ),
    pane(
        Pane::Statistics,
        "Statistics",
        "Show or hide what the program is doing",
        &[keys(CTRL_SHIFT, Key::T)],
    ),
    group(entry(
        Command::ResetPanes,
        Menu::Panes,
        "Reset panes",
        "Put all panes where they were at first",
        &[],
    )),
    entry(
        Command::Palette,
        Menu::Help,
        "Find a command…",
        "Look for a command by its name",
        &[keys(CTRL, Key::P), keys(CTRL, Key::K)],
    ),
    entry(
        Command::Help,
        Menu::Help,
        "Commands and keys",
        "Show all commands and how to move",
        &[keys(PLAIN, Key::F1)],
    ),
];
