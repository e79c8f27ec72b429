//! A measurement that follows the project: at once while it is quick, else when somebody asks.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::Ui;
use relievo_engine::analysis::Task;

use crate::window::inbox::Waker;
use crate::window::latest::{Latest, Waiting};
use crate::window::waiting;

/// What took less is measured again by itself.
const QUICK: Duration = Duration::from_millis(500);

/// A question and the state of the project that it is about.
type Asked<K> = (K, u64);

/// The latest answer to a question of kind `K`.
pub(crate) struct Measured<K, A> {
    latest: Latest<Asked<K>, Result<Arc<A>, String>>,
    /// Somebody asked for it, however long it takes.
    requested: bool,
    /// What it would be asked now.
    wanted: Option<Asked<K>>,
    /// The settings that it was asked with last.
    asked: Option<K>,
}

/// An answer, or one line that says why there is none.
pub(crate) struct Found<A> {
    pub(crate) answer: Result<Arc<A>, String>,
    /// Whether it is of the project and the settings as they are.
    pub(crate) is_current: bool,
}

impl<K, A> Measured<K, A>
where
    K: Clone + PartialEq + Send + 'static,
    A: Send + Sync + 'static,
{
    /// # Errors
    /// When the system refuses a thread.
    pub(crate) fn new(name: &str, waker: Waker) -> io::Result<Self> {
        Ok(Self {
            latest: Latest::new(name, waker)?,
            requested: false,
            wanted: None,
            asked: None,
        })
    }

    /// Measures as soon as nothing is in the way.
    pub(crate) fn request(&mut self) {
        self.requested = true;
    }

    /// Whether somebody waits for it to be asked.
    pub(crate) fn is_requested(&self) -> bool {
        self.requested
    }

    /// Once a frame: asks what is wanted now if it is requested, or if the last time was quick. `rests`
    /// says whether nothing is in the way.
    pub(crate) fn follow<W>(&mut self, key: K, state: u64, rests: bool, work: impl FnOnce() -> W)
    where
        W: FnOnce(&Task) -> Result<A, String> + Send + 'static,
    {
        let is_busy = matches!(self.latest.waiting(), Waiting::Busy { .. });
        // Whoever changes a setting while it works wants the new answer and not the old one.
        self.requested |= is_busy && self.asked.as_ref().is_some_and(|asked| *asked != key);
        let wanted = (key, state);
        self.wanted = Some(wanted.clone());
        if !rests {
            return;
        }
        let was_quick = !is_busy && self.latest.last().is_some_and(|last| last.took < QUICK);
        if std::mem::take(&mut self.requested) {
            if self.latest.waiting() == Waiting::Stopped {
                self.latest.forget();
            }
        } else if !was_quick {
            return;
        }
        self.asked = Some(wanted.0.clone());
        self.latest.ask(wanted, || {
            let work = work();
            move |task: &Task| work(task).map(Arc::new)
        });
    }

    /// The last answer.
    pub(crate) fn found(&self) -> Option<Found<A>> {
        let last = self.latest.last()?;
        Some(Found {
            is_current: self.wanted.as_ref() == Some(&last.key),
            answer: last.answer,
        })
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.latest.clear();
        (self.requested, self.wanted, self.asked) = (false, None, None);
    }

    /// What is being waited for, whether the last answer is out of date, why there is none.
    pub(crate) fn status(&mut self, ui: &mut Ui, what: &str) {
        let stopped = self.latest.waiting() == Waiting::Stopped;
        waiting::show(ui, &mut self.latest, what);
        if stopped && self.latest.waiting() == Waiting::No {
            self.requested = true;
        }
        let is_free = self.latest.waiting() == Waiting::No;
        let Some(found) = self.found() else { return };
        if is_free && !found.is_current && !self.requested {
            ui.horizontal(|ui| {
                let text = "Out of date";
                let hint = "The project or the settings changed since";
                ui.colored_label(ui.visuals().warn_fg_color, text)
                    .on_hover_text(hint);
                let again = ui.button("Measure again");
                if again.on_hover_text(hint).clicked() {
                    self.requested = true;
                }
            });
        }
        if let Err(reason) = found.answer
            && (is_free || found.is_current)
        {
            ui.colored_label(ui.visuals().error_fg_color, reason);
        }
    }
}
