//! Work that was not saved: offered again after a crash, and what other programs do to the file.

use eframe::egui;
use relievo_engine::Guarded;
use relievo_engine::project::{Abandoned, forget_untitled};

use super::Studio;
use crate::window::dialogs::Dialog;
use crate::window::document::Document;
use crate::window::messages::Weight;
use crate::window::panes::Pane;

impl Studio {
    /// Guards the project that was opened; asks about edits of a run that did not end well.
    pub(super) fn guard(&mut self) {
        let state_folder = self.options.state_folder.clone();
        let Guarded {
            offer,
            held,
            unreadable,
        } = self.document.guard(state_folder.as_deref());
        if let Some(held) = held {
            let text = format!("{held}. What you change here is kept safe only by saving");
            self.log.add(Weight::Warning, text);
            self.layout.open(Pane::Messages);
        }
        if let Some(error) = unreadable {
            self.log.add(Weight::Warning, error.to_string());
        }
        if let Some(offer) = &offer {
            self.dialog = Some(Dialog::Recover {
                edits: offer.edits().len(),
                fits: offer.fits(),
            });
        }
        self.offer = offer;
    }

    /// Looks for untitled projects of runs that did not end well.
    pub(in crate::window) fn look_for_abandoned(&self) {
        if let Some(folder) = &self.options.state_folder {
            self.inbox.look_for_abandoned(folder.clone());
        }
    }

    /// Offers untitled projects again, one after the other, while nothing else is open.
    pub(super) fn offer_abandoned(&mut self, found: Vec<(Abandoned, usize)>) {
        self.abandoned = found;
        let Some((_, edits)) = self.abandoned.first() else {
            return;
        };
        if self.is_blank() && self.dialog.is_none() {
            self.dialog = Some(Dialog::Recover {
                edits: *edits,
                fits: true,
            });
        } else {
            let text = "Unsaved work on an untitled project is kept; start with an empty project to get it back";
            self.log.add(Weight::News, text);
            self.abandoned.clear();
        }
    }

    /// Opens the untitled project that was offered, or throws it away and offers the next.
    fn answer_abandoned(&mut self, wanted: bool) {
        if self.abandoned.is_empty() {
            return;
        }
        let (found, _) = self.abandoned.remove(0);
        if !wanted {
            forget_untitled(&found.path);
            let rest = std::mem::take(&mut self.abandoned);
            self.offer_abandoned(rest);
            return;
        }
        let folder = self.options.state_folder.clone().unwrap_or_default();
        match Document::abandoned(&found, &folder, self.engine_options()) {
            Ok((document, guarded)) => {
                self.show(document);
                self.offer = guarded.offer;
                self.answer_offer(true);
            }
            Err(error) => self.log.add(Weight::Error, error.to_string()),
        }
    }

    /// Tells why edits are not kept safe.
    pub(super) fn mind_trouble(&mut self) {
        if let Some(text) = self.document.take_trouble() {
            self.log.add(Weight::Warning, text);
        }
    }

    /// Makes the offered edits again, or throws them away.
    pub(super) fn answer_offer(&mut self, wanted: bool) {
        let Some(offer) = self.offer.take() else {
            self.answer_abandoned(wanted);
            return;
        };
        if wanted {
            let all = offer.edits().len();
            let (count, problem) = self.document.recover(&offer);
            let text = format!("{count} of {all} unsaved edits are back");
            match problem {
                None => self.log.add(Weight::News, text),
                Some(error) => self.log.add(Weight::Warning, format!("{text}: {error}")),
            }
            self.keep_selection();
            self.fit_stage();
        } else if let Err(error) = self.document.engine_mut().decline(offer) {
            self.log
                .add(Weight::Warning, format!("the journal stays: {error}"));
        }
    }

    /// The window ends in order: what was not saved is not wanted.
    pub fn finish(&mut self) {
        self.document.engine_mut().forget_unsaved();
    }

    /// Looks whether another program changed the project's file, whenever the window comes to the
    /// front.
    pub(super) fn mind_file(&mut self, ctx: &egui::Context) {
        let came = ctx.input(|i| i.events.contains(&egui::Event::WindowFocused(true)));
        if came && let (Some(path), Some(stamp)) = (self.document.path(), self.document.stamp()) {
            self.inbox.look_at_project(path.to_owned(), stamp);
        }
    }

    /// Another program changed a project's file: asks once.
    pub(super) fn file_changed(&mut self, path: &std::path::Path) {
        let is_open = self.document.path() == Some(path);
        let told = self.told_changed == self.document.stamp();
        if is_open && !told && self.dialog.is_none() {
            self.told_changed = self.document.stamp();
            self.dialog = Some(Dialog::ChangedOnDisk);
        }
    }
}
