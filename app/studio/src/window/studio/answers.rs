//! Taking what other threads and dialogs have to say.

use std::path::Path;

use eframe::egui;

use super::Studio;
use crate::window::dialogs::{Answer, Then};
use crate::window::inbox::{Event, Purpose};
use crate::window::messages::Weight;
use crate::window::panes::Pane;

impl Studio {
    /// Takes what other threads have to say.
    pub(super) fn take_events(&mut self, ctx: &egui::Context) {
        for event in self.inbox.take() {
            match event {
                Event::Picked {
                    purpose,
                    paths,
                    seen,
                } => {
                    if paths.is_empty() && !seen {
                        self.ask_path(purpose, None);
                    } else if paths.is_empty() {
                        (self.after_save, self.locating) = (None, None);
                    }
                    self.use_paths(purpose, paths, ctx);
                }
                Event::Looked(files) => self.add_sources(files),
                Event::Located { link, beside } => self.located(link, beside),
                Event::ProjectChanged(path) => self.file_changed(&path),
                Event::Missing(projects) => self.recent.set_missing(projects),
                Event::Classified(id, made) => self.classified(id, made),
                Event::Abandoned(found) => self.offer_abandoned(found),
                Event::PictureSaved(Ok(path)) => {
                    self.log.add(
                        Weight::News,
                        format!("saved the picture {}", path.display()),
                    );
                }
                Event::PictureSaved(Err(reason)) => {
                    self.log.add(Weight::Error, reason);
                    self.layout.open(Pane::Messages);
                }
            }
        }
    }

    /// Takes the answer to a dialog.
    pub(super) fn take_answer(&mut self, answer: Answer, ctx: &egui::Context) {
        match answer {
            Answer::Cancel => {
                (self.after_save, self.locating) = (None, None);
                // What was offered stays where it is and is offered again next time.
                self.abandoned.clear();
            }
            Answer::Save(then) => {
                self.after_save = Some(then);
                self.save(None, false, ctx);
            }
            Answer::Discard(then) => self.go_on(then, ctx),
            Answer::Overwrite => self.save(None, true, ctx),
            Answer::SaveAs => self.pick(Purpose::Save),
            Answer::Reload => {
                if let Some(path) = self.document.path().map(Path::to_owned) {
                    self.go_on(Then::Open(path), ctx);
                }
            }
            Answer::GoTo(to) => self.fly_to(to.camera(self.camera())),
            Answer::Path(purpose, path) => self.use_paths(purpose, vec![path], ctx),
            Answer::Recover(wanted) => self.answer_offer(wanted),
            Answer::Relink(links) => self.relink(&links),
        }
    }
}
