//! Which commands can do something now.

use super::Studio;
use crate::commands::Command;
use crate::window::tools::Tool;

impl Studio {
    /// Whether a command can do something now.
    pub(in crate::window) fn is_possible(&self, command: Command) -> bool {
        let history = self.document.engine().history();
        let layer = self
            .selected
            .as_ref()
            .and_then(|id| self.document.project().layer(id));
        let unlocked = layer.is_some_and(|l| !l.locked);
        let element = self.selected_element();
        match command {
            Command::Undo => history.undo_label().is_some(),
            Command::Redo => history.redo_label().is_some(),
            Command::RemoveLayer | Command::MoveUp | Command::MoveDown | Command::ToggleVisible
                if element.is_some() =>
            {
                element.is_some_and(|e| !e.locked)
            }
            Command::RemoveLayer | Command::MoveUp | Command::MoveDown | Command::ToggleVisible => {
                unlocked
            }
            Command::ZoomToLayer if element.is_some() => true,
            Command::ZoomToLayer => layer.is_some_and(|l| l.source().is_some()),
            Command::Locate => unlocked && layer.is_some_and(|l| l.source().is_some()),
            Command::Compare(_) => !self.document.project().scenarios.is_empty(),
            Command::StopComparing => self.compare.is_some(),
            Command::Use(tool @ (Tool::Hole | Tool::Breakline)) => self.host_of(tool).is_some(),
            Command::Use(Tool::Lens | Tool::LensOutline) => {
                unlocked && layer.is_some_and(|l| l.kind.may_be_masked())
            }
            Command::ClearResults => self.analyses.has_results(),
            Command::Screenshot => self.stage.is_some(),
            Command::New
            | Command::Open
            | Command::Save
            | Command::SaveAs
            | Command::Quit
            | Command::AddFiles
            | Command::AddNoise
            | Command::AddDetail
            | Command::Synthesised
            | Command::AddTint
            | Command::AddSlope
            | Command::AddContours
            | Command::NorthUp
            | Command::ResetView
            | Command::GoTo
            | Command::Toggle(_)
            | Command::ResetPanes
            | Command::Palette
            | Command::Use(_)
            | Command::AddBookmark
            | Command::Volumes
            | Command::Contours
            | Command::FollowSystem
            | Command::Dark
            | Command::Light
            | Command::Larger
            | Command::Smaller
            | Command::UsualSize
            | Command::Retry
            | Command::Help => true,
        }
    }
}
