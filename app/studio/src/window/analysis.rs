//! What people measure in the window: volumes between two scenarios, what is seen from a place, still
//! water, contours.
//!
//! ```text
//! pane, tool --> question --Measured--> thread --> answer with its mark --> pane, legend
//!                                                            |
//!                                                            +--> engine.set_marks --> terrain
//! ```
//!
//! Invariant: an answer says which state of the project it is of. What took less than half a second is
//! measured again by itself when that changes; all else is said to be out of date.

mod contours;
mod exports;
mod fields;
mod legend;
mod measured;
mod sight;
mod volumes;
mod water;

use std::io;

use eframe::egui::{Key, Modifiers, PointerButton, Rect, Response, Ui};
use relievo_engine::Mark;

use self::contours::ContoursPane;
pub(crate) use self::exports::Export;
use self::exports::Exports;
use self::sight::SightPane;
use self::volumes::VolumesPane;
use self::water::WaterPane;
use super::inbox::Waker;
use super::panes::Pane;
use super::studio::Studio;
use super::tools::{Tool, released_at};

/// Everything that is being measured.
pub(crate) struct Analyses {
    volumes: VolumesPane,
    sight: SightPane,
    water: WaterPane,
    contours: ContoursPane,
    exports: Exports,
}

impl Analyses {
    /// Nothing yet.
    ///
    /// # Errors
    /// When the system refuses threads.
    pub(crate) fn new(waker: &Waker) -> io::Result<Self> {
        Ok(Self {
            volumes: VolumesPane::new(waker.clone())?,
            sight: SightPane::new(waker.clone())?,
            water: WaterPane::new(waker.clone())?,
            contours: ContoursPane::new(waker.clone())?,
            exports: Exports::new(waker.clone())?,
        })
    }

    /// Forgets all answers and where they were asked for.
    pub(crate) fn clear(&mut self) {
        self.volumes.clear();
        self.sight.clear();
        self.water.clear();
        self.contours.clear();
    }

    /// Whether there is anything to forget.
    pub(crate) fn has_results(&self) -> bool {
        self.volumes.has_result()
            || self.sight.observer().is_some()
            || self.water.seed().is_some()
            || self.contours.has_area()
    }
}

impl Studio {
    /// A state of the project and its files: answers about the same state are the same.
    pub(in crate::window) fn state(&self) -> u64 {
        self.document.revision() ^ (self.document.engine().file_news() << 32)
    }

    /// Whether questions can be asked that take long: files are open and nothing is being dragged.
    fn rests(&self, ui: &Ui) -> bool {
        self.status.opening == 0 && !ui.input(|i| i.pointer.any_down())
    }

    /// Threads that a measurement may take.
    fn measuring_threads(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        self.engine_options().threads.unwrap_or(cores.max(2) - 1)
    }

    /// Asks what is to be measured anew, takes what was exported, and shows results on the terrain.
    pub(super) fn mind_analyses(&mut self, ui: &Ui) {
        self.follow_volumes(ui);
        self.follow_sight(ui);
        self.follow_water(ui);
        self.follow_contours(ui);
        self.take_exported();
        let analyses = &self.analyses;
        let marks: Vec<Mark> = [
            analyses.water.mark(),
            analyses.sight.mark(),
            analyses.contours.mark(),
        ]
        .into_iter()
        .flatten()
        .collect();
        self.document.engine_mut().set_marks(marks);
    }

    /// The main button and the keys of the tools that choose a place to measure from.
    pub(in crate::window) fn place_question(&mut self, ui: &Ui, rect: Rect, response: &Response) {
        if response.clicked_by(PointerButton::Primary)
            && let Some(at) = released_at(ui)
            && let Some(point) = self.ground_point(rect, at)
        {
            if self.tools.tool == Tool::Observer {
                self.analyses.sight.place(point);
                self.layout.open(Pane::Viewshed);
            } else {
                let ground_m = self.document.engine().ground_m(point);
                self.analyses.water.place(point, ground_m);
                self.layout.open(Pane::Flood);
            }
        }
        if ui.ctx().text_edit_focused() || self.dialog.is_some() || self.palette_is_open() {
            return;
        }
        if ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            self.tools.choose(Tool::Select);
        }
    }
}
