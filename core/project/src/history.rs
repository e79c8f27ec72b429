//! Undo and redo.

use std::collections::VecDeque;
use std::path::Path;

use crate::{Edit, EditError, ElementId, LayerId, Project, paths};

/// What can be undone and redone, bounded by memory.
///
/// Each step holds the edit that takes it back. Camera moves are applied but not recorded.
#[derive(Clone, Debug)]
pub struct History {
    undo: VecDeque<Step>,
    redo: Vec<Step>,
    drag: Option<Drag>,
    most_bytes: usize,
    /// Memory of all steps.
    bytes: usize,
}

/// The edits since a drag began.
#[derive(Clone, Debug, Default)]
struct Drag {
    /// What the first edit was called.
    label: String,
    /// What takes them back, in the order of the edits.
    inverses: Vec<Edit>,
}

/// One entry of the undo or redo menu.
#[derive(Clone, Debug)]
struct Step {
    label: String,
    edit: Edit,
    bytes: usize,
}

impl Step {
    /// `project` as it is after the step: geometry that it shares costs the step nothing.
    fn new(label: String, edit: Edit, project: &Project) -> Self {
        let bytes = size_of::<Self>() + label.len() + edit.heap_bytes(project);
        Self { label, edit, bytes }
    }
}

impl Default for History {
    /// Up to 64 MiB.
    fn default() -> Self {
        Self::new(64 << 20)
    }
}

impl History {
    /// A history that drops its oldest steps beyond about `most_bytes`; the newest always stays.
    pub fn new(most_bytes: usize) -> Self {
        Self {
            undo: VecDeque::new(),
            redo: Vec::new(),
            drag: None,
            most_bytes,
            bytes: 0,
        }
    }

    /// Applies an edit and records how to take it back; what could be redone is forgotten.
    ///
    /// # Errors
    /// As [`Project::apply`]; project and history are then unchanged.
    pub fn apply(&mut self, project: &mut Project, edit: Edit) -> Result<(), EditError> {
        if matches!(edit, Edit::SetCamera { .. }) {
            return project.apply(edit).map(drop);
        }
        let label = edit.label(project);
        let inverse = project.apply(edit)?;
        // In a scenario the inverse of any edit of an element sets what the scenario changes about it.
        let key = inverse.merge_key();
        self.clear_redo();
        let Some(drag) = &mut self.drag else {
            self.push_undo(Step::new(label, inverse, project));
            return Ok(());
        };
        // Of a run of edits of one value only the first inverse matters: it holds the value before.
        if key.is_none()
            || drag
                .inverses
                .last()
                .is_none_or(|last| last.merge_key() != key)
        {
            if drag.inverses.is_empty() {
                drag.label = label;
            }
            drag.inverses.push(inverse);
        }
        Ok(())
    }

    /// Begins a drag: all edits up to [`History::end_drag`] become one step. A drag that is still
    /// open ends first.
    pub fn begin_drag(&mut self, project: &Project) {
        self.end_drag(project);
        self.drag = Some(Drag::default());
    }

    /// Whether a drag is open.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// Ends a drag. One without edits leaves no step.
    pub fn end_drag(&mut self, project: &Project) {
        let Some(drag) = self.drag.take() else { return };
        let Some(edit) = into_one(drag.inverses) else {
            return;
        };
        // The whole drag tells better than its first edit which slider moved.
        let label = if matches!(edit, Edit::SetAdjust { .. }) {
            edit.label(project)
        } else {
            drag.label
        };
        self.push_undo(Step::new(label, edit, project));
    }

    /// Ends a drag and takes it back (the Escape key). Gives the edit that did so, if any.
    pub fn cancel_drag(&mut self, project: &mut Project) -> Option<Edit> {
        let edit = into_one(self.drag.take()?.inverses)?;
        project.apply(edit.clone()).ok()?;
        Some(edit)
    }

    /// What [`History::undo`] would take back, for the menu: `Opacity of Blue Marble`.
    pub fn undo_label(&self) -> Option<&str> {
        self.undo.back().map(|step| step.label.as_str())
    }

    /// What [`History::redo`] would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|step| step.label.as_str())
    }

    /// Number of steps that can be undone.
    pub fn undo_count(&self) -> usize {
        self.undo.len()
    }

    /// Number of steps that can be redone.
    pub fn redo_count(&self) -> usize {
        self.redo.len()
    }

    /// What the step at `index` from the oldest that can be undone did.
    pub fn undo_label_at(&self, index: usize) -> Option<&str> {
        self.undo.get(index).map(|step| step.label.as_str())
    }

    /// What the step at `index` from the next that can be redone did.
    pub fn redo_label_at(&self, index: usize) -> Option<&str> {
        let from_end = index.checked_add(1)?;
        let at = self.redo.len().checked_sub(from_end)?;
        Some(self.redo[at].label.as_str())
    }

    /// Takes back the last step. Gives the edit that was applied; `None` where there is no step.
    /// A drag that is open ends first.
    ///
    /// # Errors
    /// Where the project was changed by other ways than this history; the step is then gone.
    pub fn undo(&mut self, project: &mut Project) -> Result<Option<Edit>, EditError> {
        self.end_drag(project);
        let Some(step) = self.undo.pop_back() else {
            return Ok(None);
        };
        self.bytes -= step.bytes;
        let applied = step.edit.clone();
        let back = project.apply(step.edit)?;
        let step = Step::new(step.label, back, project);
        self.bytes += step.bytes;
        self.redo.push(step);
        Ok(Some(applied))
    }

    /// Does the last step that was taken back again. Gives the edit that was applied; `None` where
    /// there is no step.
    ///
    /// # Errors
    /// Where the project was changed by other ways than this history; the step is then gone.
    pub fn redo(&mut self, project: &mut Project) -> Result<Option<Edit>, EditError> {
        self.end_drag(project);
        let Some(step) = self.redo.pop() else {
            return Ok(None);
        };
        self.bytes -= step.bytes;
        let applied = step.edit.clone();
        let back = project.apply(step.edit)?;
        self.push_undo(Step::new(step.label, back, project));
        Ok(Some(applied))
    }

    /// Memory of all steps in bytes, about.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// What every step is called, the oldest first: those that can be undone, then those that can be
    /// redone. [`History::position`] says where the one ends and the other begins.
    pub fn labels(&self) -> impl ExactSizeIterator<Item = &str> {
        let redone = self.redo.len();
        let all = (0..self.undo.len() + redone).map(move |place| {
            let undone = place.checked_sub(self.undo.len());
            undone.map_or_else(|| &self.undo[place], |back| &self.redo[redone - 1 - back])
        });
        all.map(|step| step.label.as_str())
    }

    /// How many steps can be undone: the project is where it was after that many of
    /// [`History::labels`].
    pub fn position(&self) -> usize {
        self.undo.len()
    }

    /// Undoes or redoes until so many steps can be undone; the last step that there is where there are
    /// not so many. Gives the edits that were applied, in order.
    ///
    /// # Errors
    /// As [`History::undo`] and [`History::redo`]; what was applied before stays so.
    pub fn go_to(
        &mut self,
        project: &mut Project,
        position: usize,
    ) -> Result<Vec<Edit>, EditError> {
        self.end_drag(project);
        let mut applied = Vec::new();
        while self.undo.len() > position {
            applied.extend(self.undo(project)?);
        }
        while self.undo.len() < position {
            let Some(edit) = self.redo(project)? else {
                break;
            };
            applied.push(edit);
        }
        Ok(applied)
    }

    /// Rewrites the paths in all steps after the project moved from one folder to another with
    /// [`Project::rebased`], so that undoing still means the same files. Both absolute.
    pub fn rebase(&mut self, from: &Path, to: &Path) {
        let dragged = self.drag.iter_mut().flat_map(|drag| &mut drag.inverses);
        let steps = self
            .undo
            .iter_mut()
            .chain(&mut self.redo)
            .map(|step| &mut step.edit);
        steps
            .chain(dragged)
            .for_each(|edit| paths::rebase_edit(edit, from, to));
    }

    /// An id for a new planning element made from `stem`: used neither in the project nor by an element
    /// that an undo or redo would bring back.
    pub fn fresh_element_id(&self, project: &Project, stem: &str) -> ElementId {
        let steps = self.undo.iter().chain(&self.redo).map(|step| &step.edit);
        let edits: Vec<&Edit> = steps
            .chain(self.drag.iter().flat_map(|drag| &drag.inverses))
            .collect();
        project.fresh_element_id(stem, |id| edits.iter().any(|edit| names(edit, id)))
    }

    /// An id for a new layer made from `stem`: used neither in the project nor by a layer that an
    /// undo or redo would bring back.
    pub fn fresh_layer_id(&self, project: &Project, stem: &str) -> LayerId {
        let steps = self.undo.iter().chain(&self.redo).map(|step| &step.edit);
        let edits: Vec<&Edit> = steps
            .chain(self.drag.iter().flat_map(|drag| &drag.inverses))
            .collect();
        project.fresh_layer_id(stem, |id| edits.iter().any(|edit| adds(edit, id)))
    }

    fn push_undo(&mut self, step: Step) {
        self.bytes += step.bytes;
        self.undo.push_back(step);
        while self.bytes > self.most_bytes && self.undo.len() > 1 {
            let dropped = self.undo.pop_front();
            self.bytes -= dropped.map_or(0, |step| step.bytes);
        }
    }

    fn clear_redo(&mut self) {
        self.bytes -= self.redo.iter().map(|step| step.bytes).sum::<usize>();
        self.redo.clear();
    }
}

/// The inverses of a drag as one edit, last first.
fn into_one(mut inverses: Vec<Edit>) -> Option<Edit> {
    match inverses.len() {
        0 | 1 => inverses.pop(),
        _ => {
            inverses.reverse();
            Some(Edit::Batch {
                label: String::new(),
                edits: inverses,
            })
        }
    }
}

/// Whether an edit brings a layer with this id.
fn adds(edit: &Edit, id: &LayerId) -> bool {
    if let Edit::Batch { edits, .. } = edit {
        return edits.iter().any(|edit| adds(edit, id));
    }
    matches!(edit, Edit::AddLayer { layer, .. } if layer.id == *id)
}

/// Whether an edit names an element.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "most edits name one element or none"
)]
fn names(edit: &Edit, id: &ElementId) -> bool {
    match edit {
        Edit::Batch { edits, .. } => edits.iter().any(|edit| names(edit, id)),
        Edit::SetChanges { changes, .. } => changes.iter().any(|c| c.element_id() == Some(id)),
        Edit::AddScenario { scenario, .. } => scenario.change(id).is_some(),
        _others => edit.element().is_some_and(|(_, other)| other == id),
    }
}
