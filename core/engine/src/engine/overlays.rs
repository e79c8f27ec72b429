//! What is shown over the project and is no part of it.

use std::sync::Arc;

use relievo_project::ScenarioId;

use super::Engine;
use crate::difference::HeightDifference;
use crate::marks::Mark;

/// How ground that is synthesised is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Synthesised {
    /// As all other ground.
    #[default]
    Plain,
    /// In colours of its own.
    Coloured,
}

impl Engine {
    /// Colours the ground by how much higher or lower it is than in another scenario (`None`: the
    /// base), over everything else; `None` shows it as it is. No part of the project, and only tiles
    /// that the difference touches are made again.
    pub fn show_difference(&mut self, of: Option<(Option<ScenarioId>, HeightDifference)>) {
        if self.difference != of {
            self.difference = of;
            self.stale = true;
        }
    }

    /// Colours the ground where detail beyond the data's own resolution is seen, of heights the stronger the
    /// higher it is. No part of the project.
    pub fn show_synthesised(&mut self, shows: bool) {
        let wanted = if shows {
            Synthesised::Coloured
        } else {
            Synthesised::Plain
        };
        if self.synthesised != wanted {
            self.synthesised = wanted;
            self.stale = true;
        }
    }

    /// Whether it does.
    pub fn shows_synthesised(&self) -> bool {
        self.synthesised == Synthesised::Coloured
    }

    /// Shows marks over the project's colours, the first at the bottom, in place of those before.
    pub fn set_marks(&mut self, marks: Vec<Mark>) {
        let same = |(a, b): (&Mark, &Mark)| Arc::ptr_eq(&a.node, &b.node);
        if marks.len() == self.marks.len() && marks.iter().zip(&self.marks).all(same) {
            return;
        }
        self.marks = marks;
        self.stale = true;
    }
}
