//! The project behind an engine: edited, undone, opened, saved.
//!
//! Invariant: nothing else changes a project. What an edit touches decides what is made again.

use std::path::Path;
use std::sync::Arc;

use relievo_project::{
    Affects, Aspect, Edit, EditError, FileStamp, Replace, SaveProjectError, ScenarioId,
};

use super::Engine;
use super::edited::Edited;
use super::options::{EngineOptions, OpenError, folder_of};

impl Engine {
    /// Applies an edit: the only way to change a project. The picture follows as tiles get ready.
    ///
    /// # Errors
    /// When the edit does not fit the project; nothing has changed then.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        self.check_exaggeration(&edit)?;
        let affects = edit.affects();
        // Where the viewer is goes into the file with a save; it is no work to be lost.
        let is_kept = self.keeps() && !matches!(edit, Edit::SetCamera { .. });
        let kept = is_kept.then(|| edit.clone());
        self.history.apply(&mut self.project, edit)?;
        if let Some(edit) = kept {
            self.keep(&edit);
        }
        self.changed(&affects);
        Ok(())
    }

    /// Starts a drag: all edits until [`Self::end_drag`] are one undo step.
    pub fn begin_drag(&mut self) {
        self.history.begin_drag(&self.project);
        self.drags += 1;
        self.edited = Edited::default();
        self.before_drag = Some(Arc::clone(self.target()));
    }

    /// Ends a drag.
    pub fn end_drag(&mut self) {
        self.history.end_drag(&self.project);
        // To the last bit as if nobody had dragged.
        self.stale |= self.target().mixed_apart;
        if !self.stale {
            self.before_drag = None;
        }
    }

    /// Ends a drag and takes it back.
    pub fn cancel_drag(&mut self) {
        if let Some(edit) = self.history.cancel_drag(&mut self.project) {
            self.keep(&edit);
            self.changed(&edit.affects());
        }
    }

    /// Takes the last edit back; `false` if there is none.
    ///
    /// # Errors
    /// When the step does not fit the project any more; it is gone then.
    pub fn undo(&mut self) -> Result<bool, EditError> {
        let edit = self.history.undo(&mut self.project)?;
        Ok(edit.inspect(|e| self.went(e)).is_some())
    }

    /// Makes the last undone edit again; `false` if there is none.
    ///
    /// # Errors
    /// When the step does not fit the project any more; it is gone then.
    pub fn redo(&mut self) -> Result<bool, EditError> {
        let edit = self.history.redo(&mut self.project)?;
        Ok(edit.inspect(|e| self.went(e)).is_some())
    }

    /// Undoes or redoes until so many steps of [`Self::history`] can be undone; `false` if nothing
    /// changed.
    ///
    /// # Errors
    /// When a step does not fit the project any more; it is gone then.
    pub fn go_to(&mut self, position: usize) -> Result<bool, EditError> {
        let mut changed = false;
        while self.history.position() > position {
            if !self.undo()? {
                break;
            }
            changed = true;
        }
        while self.history.position() < position {
            if !self.redo()? {
                break;
            }
            changed = true;
        }
        Ok(changed)
    }

    /// Notes an edit that the history applied.
    fn went(&mut self, edit: &Edit) {
        self.keep(edit);
        self.changed(&edit.affects());
    }

    /// Opens a project file.
    ///
    /// # Errors
    /// [`OpenError`] when the file cannot be read or is no project, or the system refuses a thread.
    pub fn open(path: &Path, options: EngineOptions) -> Result<(Self, FileStamp), OpenError> {
        let (project, stamp) = relievo_project::open(path)?;
        let engine = Self::new(project, folder_of(path), options).map_err(OpenError::Threads)?;
        Ok((engine, stamp))
    }

    /// Saves the project, whole or not at all. In another folder than before, relative paths are
    /// rewritten so that they still lead to the same files.
    ///
    /// # Errors
    /// [`SaveProjectError`]; the file on disk is then untouched.
    pub fn save(&mut self, path: &Path, replace: Replace) -> Result<FileStamp, SaveProjectError> {
        let folder = folder_of(path);
        let moved = (folder != self.folder).then(|| self.project.rebased(&self.folder, folder));
        let keeper = self.keeper.as_ref();
        let stamp = relievo_project::save_with(
            path,
            moved.as_ref().unwrap_or(&self.project),
            replace,
            |stamp| keeper.into_iter().for_each(|k| k.saving(path, stamp)),
        )?;
        if let Some(moved) = moved {
            self.history.rebase(&self.folder, folder);
            self.project = moved;
            folder.clone_into(&mut self.folder);
            self.sources.require(&self.project, &self.folder);
        }
        self.kept_saved(path, stamp);
        Ok(stamp)
    }

    /// Whether what a scenario changes is part of what is shown.
    fn is_shown(&self, scenario: &ScenarioId) -> bool {
        let shown = self.project.lineage(self.project.scenario.as_ref());
        shown.iter().any(|s| s.id == *scenario)
    }

    fn changed(&mut self, affects: &[Affects]) {
        // Layers of which a value changed, and whether anything else did that is seen.
        let (mut layers, mut others) = (Vec::new(), false);
        for affect in affects {
            match affect {
                Affects::Layer { aspect, .. } | Affects::Element { aspect, .. }
                    if !aspect.is_visible() => {}
                Affects::ScenarioName | Affects::Bookmarks => {}
                Affects::Element {
                    scenario: Some(scenario),
                    ..
                } if !self.is_shown(scenario) => {}
                Affects::Element { .. }
                | Affects::Scenario { .. }
                | Affects::Base
                | Affects::Shown => (self.stale, others) = (true, true),
                Affects::Layer { id, aspect } => {
                    self.stale = true;
                    let edits_value = matches!(
                        aspect,
                        Aspect::Adjust
                            | Aspect::Opacity
                            | Aspect::Blend
                            | Aspect::Mask
                            | Aspect::Resampling
                            | Aspect::EdgeFade
                            | Aspect::Noise
                            | Aspect::Tint
                            | Aspect::Style
                    );
                    if edits_value {
                        layers.push(id);
                    } else {
                        others = true;
                    }
                }
                Affects::Planet | Affects::Exaggeration => {
                    self.stale = true;
                    self.dirty = true;
                }
                Affects::Camera | Affects::Sun | Affects::Quality => self.dirty = true,
            }
        }
        if others || !layers.is_empty() {
            if !self.history.is_dragging() {
                self.edited = Edited::default();
            }
            self.edited.take(layers, others);
        }
        self.sources.require(&self.project, &self.folder);
    }
}
