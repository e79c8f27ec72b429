//! Choosing, saving and linking files.

use std::path::{Path, PathBuf};

use eframe::egui::{self, ViewportCommand};
use relievo_engine::project::{LayerId, SaveProjectError, resolve_path};
use relievo_engine::relink::{self, Link};

use super::Studio;
use crate::window::dialogs::{Dialog, Then};
use crate::window::inbox::Purpose;
use crate::window::layers;
use crate::window::messages::Weight;
use crate::window::panes::Pane;

impl Studio {
    pub(in crate::window) fn pick(&mut self, purpose: Purpose) {
        let own = self.document.path().map(Path::to_owned);
        let folder = self.document.engine().folder().to_owned();
        let named =
            |extension: &str| Some(folder.join(self.document.name()).with_extension(extension));
        let start = match purpose {
            Purpose::Save => own.or_else(|| named("relievo")),
            Purpose::Picture => named("png"),
            Purpose::Export(export) => named(export.extension()),
            Purpose::Open | Purpose::Add => own.or_else(|| Some(folder.join("file"))),
            Purpose::Locate => self.located_beside().or(own),
        };
        if self.options.file_dialogs {
            self.inbox.pick(purpose, start);
        } else {
            self.ask_path(purpose, start);
        }
    }

    /// Asks for a path to be typed.
    pub(super) fn ask_path(&mut self, purpose: Purpose, start: Option<PathBuf>) {
        let folder = || self.document.engine().folder().join("");
        let start = start.unwrap_or_else(folder);
        self.dialog = Some(Dialog::Path(purpose, start.display().to_string()));
    }

    /// Where the file of the layer that is being located was, if its folder is still there.
    pub(super) fn located_beside(&self) -> Option<PathBuf> {
        let engine = self.document.engine();
        let layer = engine.project().layer(self.locating.as_ref()?)?;
        let file = resolve_path(engine.folder(), &layer.source()?.path);
        file.parent().is_some_and(Path::is_dir).then_some(file)
    }

    /// Links a layer to a file that was chosen for it. Where files that other layers miss lie beside
    /// it the user is asked about them first.
    pub fn locate(&self, layer: LayerId, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_odd| file.to_owned());
        let engine = self.document.engine();
        let (project, folder) = (engine.project().clone(), engine.folder().to_owned());
        self.inbox
            .look_beside(Link { layer, file }, project, folder);
    }

    /// Links layers to files as one undo step.
    pub(super) fn relink(&mut self, links: &[Link]) {
        match relink::relink(self.document.engine().folder(), links) {
            Ok(Some(edit)) => {
                self.edit(edit);
                let files = if links.len() == 1 { "file" } else { "files" };
                self.log
                    .add(Weight::News, format!("linked {} {files}", links.len()));
            }
            Ok(None) => {}
            Err(file) => {
                let text = format!("expected a path in Unicode, found {file:?}");
                self.log.add(Weight::Error, text);
                self.layout.open(Pane::Messages);
            }
        }
    }

    /// A file was located: asks about others that lie beside it, or links it.
    pub(super) fn located(&mut self, link: Link, beside: Vec<Link>) {
        let project = self.document.project();
        if project.layer(&link.layer).is_none() {
            return;
        }
        let named = |other: Link| {
            let layer = project.layer(&other.layer).filter(|l| !l.locked)?;
            Some((other, layers::name_of(layer)))
        };
        let beside: Vec<_> = beside.into_iter().filter_map(named).collect();
        if beside.is_empty() {
            self.relink(&[link]);
        } else {
            self.dialog = Some(Dialog::Relink { link, beside });
        }
    }

    /// Does something that loses the project, after asking about unsaved changes.
    pub(super) fn unless_changed(&mut self, then: Then, ctx: &egui::Context) {
        if self.document.is_changed() {
            self.dialog = Some(Dialog::Unsaved(then));
        } else {
            self.go_on(then, ctx);
        }
    }

    pub(super) fn go_on(&mut self, then: Then, ctx: &egui::Context) {
        match then {
            Then::Quit => {
                self.closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Then::PickProject => self.pick(Purpose::Open),
            Then::Open(path) => {
                if let Err(error) = self.open_project(&path) {
                    self.log.add(Weight::Error, error.to_string());
                    self.layout.open(Pane::Messages);
                    self.look_for_recent();
                }
            }
            Then::New => self.start_new(),
        }
    }

    /// Saves to a path or to the project's own file; asks for a name where there is none.
    pub(super) fn save(&mut self, path: Option<&Path>, overwrite: bool, ctx: &egui::Context) {
        if path.is_none() && self.document.path().is_none() {
            self.pick(Purpose::Save);
            return;
        }
        let camera = *self.camera();
        match self.document.save(path, &camera, overwrite) {
            Ok(()) => {
                self.log
                    .add(Weight::News, format!("saved {}", self.document.name()));
                self.remember();
                if let Some(then) = self.after_save.take() {
                    self.go_on(then, ctx);
                }
            }
            Err(SaveProjectError::ChangedOnDisk { .. }) => {
                self.dialog = Some(Dialog::ChangedOnDisk);
            }
            Err(
                error @ (SaveProjectError::Write { .. }
                | SaveProjectError::TooLarge { .. }
                | SaveProjectError::Exists { .. }),
            ) => {
                self.after_save = None;
                self.log.add(Weight::Error, error.to_string());
                self.layout.open(Pane::Messages);
            }
        }
    }

    pub(super) fn use_paths(&mut self, purpose: Purpose, paths: Vec<PathBuf>, ctx: &egui::Context) {
        let Some(first) = paths.first().cloned() else {
            return;
        };
        match purpose {
            Purpose::Open => self.go_on(Then::Open(first), ctx),
            Purpose::Save => self.save(Some(&with_extension(first, "relievo")), true, ctx),
            Purpose::Add => self.inbox.look_at(paths),
            Purpose::Locate => {
                if let Some(layer) = self.locating.take() {
                    self.locate(layer, &first);
                }
            }
            Purpose::Export(export) => {
                self.export(export, with_extension(first, export.extension()));
            }
            Purpose::Picture => match self
                .stage
                .as_ref()
                .map(crate::window::stage::Stage::picture)
            {
                Some(Ok(picture)) => self
                    .inbox
                    .save_picture(with_extension(first, "png"), picture),
                Some(Err(error)) => self.log.add(Weight::Error, error.to_string()),
                None => {}
            },
        }
    }
}

fn with_extension(path: PathBuf, extension: &str) -> PathBuf {
    if path.extension().is_some() {
        path
    } else {
        path.with_extension(extension)
    }
}
