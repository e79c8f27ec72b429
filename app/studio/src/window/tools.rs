//! Drawing on the terrain: which tool is chosen and what it is at.
//!
//! ```text
//! pointer --cast--> place --snap--> draft --Enter--> Edit::AddElement
//!                     |                     (an outline of a lens: Edit::SetMask)
//!                     +--> handle of the selected element --each frame--> Edit::ReplaceElement
//! ```
//!
//! Invariant: what is drawn and not yet closed is no part of the project; what is dragged is, as one
//! undo step.

mod bar;
mod brush;
mod draft;
mod handles;
mod labels;
pub(in crate::window) mod lens;
mod measure;
mod paint;
mod pick;
mod snap;
pub(crate) mod view;

use eframe::egui::{Event, PointerButton, Pos2, Ui};
use relievo_engine::project::{ElementId, Vertex};

pub(crate) use brush::BrushSettings;
pub(crate) use handles::{Held, Spot};
pub(in crate::window) use handles::{changed, inserted, removed};
pub(crate) use lens::LensTool;

/// What the main button of the pointer does on the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tool {
    /// Moves the ground, selects elements, drags their vertices.
    #[default]
    Select,
    /// Draws an area.
    Polygon,
    /// Draws a hole into the selected polygon.
    Hole,
    /// Draws a line that the selected polygon's surface follows.
    Breakline,
    /// Draws a line with a width.
    Corridor,
    /// Changes heights by hand.
    Brush,
    /// Measures lengths and areas.
    Measure,
    /// Places somebody who looks around.
    Observer,
    /// Chooses where still water stands.
    Water,
    /// Moves and shapes the circle or polygon in which the selected layer shows.
    Lens,
    /// Draws the polygon in which the selected layer shows.
    LensOutline,
}

impl Tool {
    /// Those that are always in the bar, in its order.
    pub const BAR: [Self; 5] = [
        Self::Select,
        Self::Polygon,
        Self::Corridor,
        Self::Brush,
        Self::Measure,
    ];

    /// What the bar calls it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Select => "Select",
            Self::Polygon => "Polygon",
            Self::Hole => "Hole",
            Self::Breakline => "Breakline",
            Self::Corridor => "Corridor",
            Self::Brush => "Brush",
            Self::Measure => "Measure",
            Self::Observer => "Observer",
            Self::Water => "Flood",
            Self::Lens => "Lens",
            Self::LensOutline => "Draw lens",
        }
    }

    /// Whether it draws something that closes upon itself.
    pub(crate) fn is_ring(self) -> bool {
        matches!(self, Self::Polygon | Self::Hole | Self::LensOutline)
    }

    /// What to do with it.
    pub fn hint(self) -> &'static str {
        match self {
            Self::Select => {
                "Click an element to select it, drag its vertices, click a small handle to add one"
            }
            Self::Polygon => {
                "Click vertices. Enter or a double click closes, Backspace removes the last, Esc cancels"
            }
            Self::Hole => {
                "Click the hole's vertices inside the selected polygon. Enter or a double click closes, Backspace removes the last, Esc cancels"
            }
            Self::Breakline => {
                "Click along the line that the surface follows; type its heights in the inspector. Enter or a double click ends, Backspace removes the last, Esc cancels"
            }
            Self::Corridor => {
                "Click along the axis. Enter or a double click ends, Backspace removes the last, Esc cancels"
            }
            Self::Brush => "Drag over the ground. The right button turns the view, Esc ends",
            Self::Measure => {
                "Click along the way. Backspace removes the last, Enter begins anew, Esc ends"
            }
            Self::Observer => "Click where somebody stands to see what is in sight. Esc ends",
            Self::Water => "Click where still water shall stand. Esc ends",
            Self::Lens => {
                "Drag the circle or polygon in which the selected layer shows, or its corners; small handles add corners, Delete takes the chosen one away. Ctrl moves the ground, Esc ends"
            }
            Self::LensOutline => {
                "Click the corners of the polygon in which the selected layer shows. Enter or a double click closes, Backspace removes the last, Esc cancels"
            }
        }
    }
}

/// Everything that tools remember from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Tools {
    pub(crate) tool: Tool,
    /// Vertices of what is being drawn.
    pub(crate) draft: Vec<Vertex>,
    /// Where the next vertex would be.
    pub(crate) next: Option<Vertex>,
    /// The vertex that is dragged.
    pub(crate) held: Option<Held>,
    /// The vertex that keys act on.
    pub(crate) vertex: Option<(ElementId, Spot)>,
    pub(crate) brush: BrushSettings,
    /// The brush is down on this element.
    pub(crate) stroke: Option<ElementId>,
    pub(crate) lens: LensTool,
    /// Where the pointer is on the screen.
    pointer: Option<Pos2>,
}

impl Tools {
    /// Takes another tool; what was begun is given up.
    pub(crate) fn choose(&mut self, tool: Tool) {
        self.tool = tool;
        self.forget();
    }

    /// Gives up what was begun.
    pub(crate) fn forget(&mut self) {
        self.draft.clear();
        (self.next, self.held, self.vertex, self.stroke) = (None, None, None, None);
        self.lens = LensTool::default();
    }
}

/// Vertices that a ring or a line needs.
pub(crate) fn least_vertices(is_ring: bool) -> usize {
    if is_ring { 3 } else { 2 }
}

/// Where the main button was let go in this frame. In a slow frame the pointer may have gone on since.
pub(in crate::window) fn released_at(ui: &Ui) -> Option<Pos2> {
    let released = |event: &Event| {
        if let Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed: false,
            ..
        } = event
        {
            Some(*pos)
        } else {
            None
        }
    };
    ui.input(|i| i.events.iter().rev().find_map(released))
}
