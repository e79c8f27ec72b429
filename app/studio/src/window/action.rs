//! What panels ask for.

use std::path::PathBuf;

use relievo_engine::planet::Camera;
use relievo_engine::project::{Edit, ElementId, LayerId, ScenarioId};

use super::analysis::Export;
use super::classes::Recipe;
use super::compare::Mode;
use super::panes::Pane;
use super::tools::Spot;
use crate::commands::Command;

/// Something that a panel asks the studio to do once the panel is drawn.
#[expect(
    clippy::large_enum_variant,
    reason = "a frame has a handful of actions"
)]
#[derive(Clone, Debug)]
pub(crate) enum Action {
    /// Changes the project.
    Edit(Edit),
    /// All edits from here on are one undo step.
    BeginDrag,
    /// The step is complete.
    EndDrag,
    /// Selects a layer, or none.
    Select(Option<LayerId>),
    /// Hides a pane.
    Hide(Pane),
    /// Shows a pane and brings it to the front.
    Show(Pane),
    /// Carries out a command.
    Run(Command),
    /// Takes so many steps of the history back (negative) or makes them again.
    Jump(isize),
    /// Selects a planning element, or none.
    SelectElement(Option<ElementId>),
    /// Chooses a vertex of an element, for keys.
    ChooseVertex(ElementId, Spot),
    /// Compares the shown scenario with another (`None`: the base).
    Compare(Option<ScenarioId>, Mode),
    /// Flies to a camera.
    Fly(Camera),
    /// Selects a layer and flies to it.
    FlyTo(LayerId),
    /// Selects a layer and asks for its file.
    Locate(LayerId),
    /// Gives a layer a lens in the middle of the view.
    PutLens(LayerId),
    /// Asks where to write what was measured.
    Export(Export),
    /// Makes classes of a vector layer's features.
    Classify(LayerId, Recipe),
    /// Opens a project.
    Open(PathBuf),
    /// Forgets the projects that were open lately.
    ClearRecent,
}
