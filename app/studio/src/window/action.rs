//! What panels ask for.

use std::path::PathBuf;

use relievo_engine::project::{Edit, LayerId};

use crate::commands::Command;

/// Something that a panel asks the studio to do once the panel is drawn.
#[derive(Clone, Debug)]
pub enum Action {
    /// Changes the project.
    Edit(Edit),
    /// All edits from here on are one undo step.
    BeginDrag,
    /// The step is complete.
    EndDrag,
    /// Selects a layer, or none.
    Select(Option<LayerId>),
    /// Carries out a command.
    Run(Command),
    /// Opens a project.
    Open(PathBuf),
    /// Forgets the projects that were open lately.
    ClearRecent,
}
