//! Which layers are being edited: what lies around them is kept.

use relievo_project::{LayerId, Project};

use crate::compile::Pinned;

/// The layers of which the latest edit changed a value; during a drag, all edits since it began.
#[derive(Debug, Default)]
pub(super) struct Edited {
    layers: Vec<LayerId>,
    /// Whether the drag has changed something else, too.
    more: bool,
}

impl Edited {
    /// Notes an edit: the layers of which it changed a value, and whether it changed anything else that is
    /// seen.
    pub(super) fn take(&mut self, layers: Vec<&LayerId>, others: bool) {
        self.more |= others;
        for id in layers {
            if !self.layers.contains(id) {
                self.layers.push(id.clone());
            }
        }
        if self.more {
            self.layers.clear();
        }
    }

    /// What the next graph keeps of what lies around them; `drags` says that a drag goes on.
    pub(super) fn pinned<'a>(&self, project: &'a Project, drags: bool) -> Option<Pinned<'a>> {
        let edited = |id: &LayerId| self.layers.contains(id);
        let mut layers = project.layers.iter().map(|layer| &layer.id);
        let lowest = layers.clone().find(|id| edited(id))?;
        Some(Pinned {
            lowest,
            topmost: layers.rfind(|id| edited(id)).unwrap_or(lowest),
            dragged: drags,
        })
    }
}
