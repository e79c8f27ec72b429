//! What users should know: each problem once.

use std::sync::Arc;

use relievo_graph::RenderError;
use relievo_project::{ElementId, LayerId};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// The picture is right, but something deserves attention.
    Warning,
    /// Part of the picture is missing.
    Error,
}

/// One thing that users should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How bad it is.
    pub severity: Severity,
    /// The layer it is about, where there is one.
    pub layer: Option<LayerId>,
    /// The planning element it is about, where there is one.
    pub element: Option<ElementId>,
    /// One line: what, expected, found.
    pub text: String,
}

/// Most messages kept; a damaged file may fail in thousands of tiles with as many texts.
const KEPT: usize = 200;

/// All messages, without duplicates.
#[derive(Default)]
pub(crate) struct Messages {
    all: Vec<Message>,
    /// How many at the front are about sources, replaced as a whole by each revision.
    sources: usize,
    /// How many behind those are about planning elements on their ground, replaced as a whole too.
    ground: usize,
    /// And behind those about how the picture departs from the project.
    drawn: usize,
}

impl Messages {
    pub(crate) fn all(&self) -> &[Message] {
        &self.all
    }

    pub(crate) fn clear(&mut self) {
        self.all.clear();
        (self.sources, self.ground, self.drawn) = (0, 0, 0);
    }

    pub(crate) fn tile_failed(&mut self, error: &Arc<RenderError>) {
        let message = Message {
            severity: Severity::Error,
            layer: None,
            element: None,
            text: error.to_string(),
        };
        if self.all.len() < KEPT && !self.all.contains(&message) {
            self.all.push(message);
        }
    }

    /// Forgets what tiles said: their causes may be gone.
    pub(crate) fn forget_tiles(&mut self) {
        self.all.truncate(self.sources + self.ground + self.drawn);
    }

    pub(crate) fn replace_sources(&mut self, problems: &[Message]) {
        self.all.splice(..self.sources, problems.iter().cloned());
        self.sources = problems.len();
    }

    pub(crate) fn replace_ground(&mut self, mut problems: Vec<Message>) {
        let (known, _) = self.all.split_at(self.sources);
        problems.retain(|p| !known.contains(p));
        problems.truncate(KEPT);
        let count = problems.len();
        let range = self.sources..self.sources + self.ground;
        self.all.splice(range, problems);
        self.ground = count;
    }

    pub(crate) fn replace_drawn(&mut self, problem: Option<Message>) {
        let count = usize::from(problem.is_some());
        let first = self.sources + self.ground;
        self.all.splice(first..first + self.drawn, problem);
        self.drawn = count;
    }
}
