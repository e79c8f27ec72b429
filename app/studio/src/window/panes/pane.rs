//! The parts of the window, their names and where each lies at first.

use serde::{Deserialize, Serialize};

/// A part of the window that can be moved and hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pane {
    /// The view of the planet, which cannot be hidden.
    View,
    /// The list of layers.
    Layers,
    /// The list of planning elements.
    Elements,
    /// The tree of scenarios.
    Scenarios,
    /// Settings of what is selected.
    Inspector,
    /// Light, planet and quality.
    Scene,
    /// What can be undone and redone.
    History,
    /// Places to go back to.
    Bookmarks,
    /// Problems and news.
    Messages,
    /// What made the ground under the pointer.
    Place,
    /// How often each value is seen in the selected layer.
    Histogram,
    /// Colours of layers brought to one look.
    Match,
    /// Heights along a line.
    Profile,
    /// Volumes and areas between two scenarios.
    Volumes,
    /// What is seen from a place.
    Viewshed,
    /// Still water at a level.
    Flood,
    /// Contours to be written to a file.
    Contours,
    /// The nodes that make the picture.
    Graph,
    /// What the program is doing.
    Statistics,
}

impl Pane {
    /// All of them.
    pub const ALL: [Self; 19] = [
        Self::View,
        Self::Layers,
        Self::Elements,
        Self::Scenarios,
        Self::Inspector,
        Self::Scene,
        Self::History,
        Self::Bookmarks,
        Self::Messages,
        Self::Place,
        Self::Histogram,
        Self::Match,
        Self::Profile,
        Self::Volumes,
        Self::Viewshed,
        Self::Flood,
        Self::Contours,
        Self::Graph,
        Self::Statistics,
    ];

    /// What its tab says.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Layers => "Layers",
            Self::Elements => "Elements",
            Self::Scenarios => "Scenarios",
            Self::Inspector => "Inspector",
            Self::Scene => "Scene",
            Self::History => "History",
            Self::Bookmarks => "Bookmarks",
            Self::Messages => "Messages",
            Self::Place => "Place",
            Self::Histogram => "Histogram",
            Self::Match => "Match",
            Self::Profile => "Profile",
            Self::Volumes => "Volumes",
            Self::Viewshed => "Viewshed",
            Self::Flood => "Flood",
            Self::Contours => "Contours",
            Self::Graph => "Graph",
            Self::Statistics => "Statistics",
        }
    }

    /// Where it lies at first.
    pub(super) fn home(self) -> Home {
        match self {
            Self::View => Home::Middle,
            Self::Layers => Home::Left,
            Self::Elements | Self::Scenarios | Self::Bookmarks => Home::LowerLeft,
            Self::Inspector
            | Self::Scene
            | Self::History
            | Self::Match
            | Self::Viewshed
            | Self::Flood
            | Self::Contours => Home::Right,
            Self::Messages
            | Self::Place
            | Self::Histogram
            | Self::Profile
            | Self::Volumes
            | Self::Graph
            | Self::Statistics => Home::Below,
        }
    }

    /// Whether it is shown at first.
    pub(super) fn is_open_at_first(self) -> bool {
        let asked_for = matches!(
            self,
            Self::Match | Self::Viewshed | Self::Flood | Self::Contours
        );
        !asked_for && self.home() != Home::Below
    }
}

/// Groups of tabs of the first layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Home {
    Left,
    LowerLeft,
    Middle,
    Right,
    Below,
}
