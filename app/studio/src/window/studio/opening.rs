//! Which project is open.

use std::path::{Path, PathBuf};

use eframe::egui;
use relievo_engine::OpenError;

use super::{Dragging, Studio, engine_options};
use crate::window::dialogs::Then;
use crate::window::document::Document;
use crate::window::messages::Weight;
use crate::window::tools::Tools;

impl Studio {
    /// Opens a project in place of the one that is open, whose changes are lost.
    ///
    /// # Errors
    /// [`OpenError`]; the one that is open stays.
    pub fn open_project(&mut self, path: &Path) -> Result<(), OpenError> {
        let document = Document::open(path, engine_options(&self.options, &self.waker))?;
        self.show(document);
        self.guard();
        self.remember();
        Ok(())
    }

    /// Starts an empty project in place of the one that is open.
    pub(super) fn start_new(&mut self) {
        match Document::empty(engine_options(&self.options, &self.waker)) {
            Ok(mut document) => {
                document.guard_untitled(self.options.state_folder.as_deref());
                self.show(document);
            }
            Err(error) => self
                .log
                .add(Weight::Error, format!("cannot start a project: {error}")),
        }
    }

    pub(super) fn show(&mut self, document: Document) {
        self.navigation
            .jump_to(document.project().camera.to_camera());
        self.selected = document.project().layers.last().map(|l| l.id.clone());
        self.probe.forget();
        self.dragging = Dragging::No;
        self.selected_element = None;
        self.compare = None;
        self.tools = Tools::default();
        self.analyses.clear();
        self.matching.clear();
        self.offer = None;
        let mut old = std::mem::replace(&mut self.document, document);
        old.engine_mut().forget_unsaved();
        // Its threads finish what they are at; that is nothing to wait for here.
        let close = std::thread::Builder::new()
            .name("relievo-close".to_owned())
            .spawn(move || drop(old));
        if let Err(error) = close {
            tracing::warn!("the old project closed on the window's thread: {error}");
        }
        self.fit_stage();
    }

    /// Puts the open project on top of the recent ones.
    pub(super) fn remember(&mut self) {
        if let Some(path) = self.document.path() {
            self.recent.add(path);
            self.look_for_recent();
        }
    }

    /// Looks which of the recent projects are there.
    pub(super) fn look_for_recent(&self) {
        if !self.recent.is_empty() {
            self.inbox.look_for(self.recent.paths());
        }
    }

    /// Whether nothing has been opened or made yet.
    pub(in crate::window) fn is_blank(&self) -> bool {
        let document = &self.document;
        document.path().is_none() && document.project().layers.is_empty() && !document.is_changed()
    }

    /// Files that were dropped on the window: a project is opened, rasters become layers.
    pub(super) fn take_dropped(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|i| i.raw.dropped_files.clone());
        let paths: Vec<PathBuf> = dropped.iter().map(|f| f.path().to_owned()).collect();
        let is_project = |p: &PathBuf| {
            p.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("relievo"))
        };
        if let Some(project) = paths.iter().find(|p| is_project(p)) {
            self.unless_changed(Then::Open(project.clone()), ctx);
        } else if !paths.is_empty() {
            self.inbox.look_at(paths);
        }
    }
}
