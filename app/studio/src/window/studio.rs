//! The studio: what the window holds from frame to frame, and one frame of it.

mod carry_out;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, CentralPanel, Frame, Key, Margin, MenuBar, Panel, Ui, ViewportCommand};
use relievo_engine::planet::Camera;
use relievo_engine::project::LayerId;
use relievo_engine::raster::Cancel;
use relievo_engine::{
    DEFAULT_DISK_CACHE_BYTES, EngineOptions, OpenError, Severity, default_cache_folder,
};
use relievo_gpu::OutOfMemory;

use super::action::Action;
use super::dialogs::{self, Dialog, Then};
use super::document::Document;
use super::inbox::{Inbox, Waker};
use super::inspector::Inspector;
use super::messages::{self, Log, Weight};
use super::navigation::Navigation;
use super::pace::Pace;
use super::probe::Probe;
use super::recent::{self, Recent};
use super::stage::Stage;
use super::status::{self, Notation, Status};
use super::{layers, start, theme};
use crate::commands::{self, Command, Menu, TABLE};

/// How often files of the project are looked at.
const WATCH: Duration = Duration::from_secs(1);

/// How a studio works.
#[derive(Clone, Debug)]
pub struct StudioOptions {
    /// Threads that make tiles; `None`: all cores but one.
    pub threads: Option<usize>,
    /// Where pyramids of big images and finished tiles are kept; `None`: nowhere.
    pub cache_folder: Option<PathBuf>,
    /// Most that finished tiles take there, in bytes.
    pub disk_cache: u64,
    /// Where the list of recent projects is kept; `None`: nowhere.
    pub state_folder: Option<PathBuf>,
}

impl Default for StudioOptions {
    /// All cores but one, the user's folders.
    fn default() -> Self {
        Self {
            threads: None,
            cache_folder: default_cache_folder(),
            disk_cache: DEFAULT_DISK_CACHE_BYTES,
            state_folder: recent::default_state_folder(),
        }
    }
}

/// Which panels are open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panels {
    pub(super) layers: bool,
    pub(super) inspector: bool,
    pub(super) messages: bool,
}

/// A drag of a control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dragging {
    #[default]
    No,
    /// Its edits become one undo step.
    Yes,
    /// It was taken back; what it still says is ignored until the button is up.
    TakenBack,
}

/// The window's content.
pub struct Studio {
    options: StudioOptions,
    waker: Waker,
    pub(super) document: Document,
    pub(super) navigation: Navigation,
    pub(super) stage: Option<Stage>,
    pub(super) stage_error: Option<String>,
    pub(super) selected: Option<LayerId>,
    inspector: Inspector,
    pub(super) panels: Panels,
    pub(super) dialog: Option<Dialog>,
    pub(super) inbox: Inbox,
    pub(super) probe: Probe,
    pub(super) status: Status,
    notation: Notation,
    pub(super) log: Log,
    pub(super) dragging: Dragging,
    pub(super) pace: Pace,
    /// The camera of the picture that is shown.
    pub(super) drawn_camera: Option<Camera>,
    pub(super) frame_revision: u64,
    /// The layer whose file is being located.
    pub(super) locating: Option<LayerId>,
    pub(super) recent: Recent,
    /// Projects that come with the program.
    pub(super) samples: Vec<PathBuf>,
    /// What happens once a save under a new name has succeeded.
    pub(super) after_save: Option<Then>,
    /// The window may close without a question.
    pub(super) closing: bool,
    restart: bool,
    /// The stage does not fit the project's quality any more.
    refit: bool,
    /// Largest colour windows that the device has room for, as far as is known.
    most_window: u32,
    /// Asks the window to close, once.
    interrupted: Option<Cancel>,
    title: String,
}

impl Studio {
    /// A studio with an empty Earth, without a window yet.
    ///
    /// # Errors
    /// When the system refuses threads.
    pub fn new(options: StudioOptions) -> std::io::Result<Self> {
        let waker = Waker::default();
        let document = Document::empty(engine_options(&options, &waker))?;
        Ok(Self {
            navigation: Navigation::new(document.project().camera.to_camera()),
            document,
            stage: None,
            stage_error: None,
            selected: None,
            inspector: Inspector::default(),
            panels: Panels {
                layers: true,
                inspector: true,
                messages: false,
            },
            dialog: None,
            inbox: Inbox::new(waker.clone()),
            probe: Probe::new(waker.clone())?,
            status: Status::default(),
            notation: Notation::default(),
            log: Log::default(),
            dragging: Dragging::No,
            pace: Pace::default(),
            drawn_camera: None,
            frame_revision: 0,
            locating: None,
            recent: Recent::load(options.state_folder.as_deref()),
            samples: start::samples(),
            after_save: None,
            closing: false,
            restart: false,
            refit: false,
            most_window: u32::MAX,
            interrupted: None,
            title: String::new(),
            options,
            waker,
        })
    }

    /// Moves into a window: takes its device and wakes it from now on.
    pub fn attach(&mut self, cc: &eframe::CreationContext<'_>) {
        theme::apply(&cc.egui_ctx);
        self.waker.attach(&cc.egui_ctx);
        self.title.clear();
        self.closing = false;
        self.set_stage(cc.wgpu_render_state.as_ref());
        self.look_for_recent();
    }

    fn set_stage(&mut self, state: Option<&eframe::egui_wgpu::RenderState>) {
        let settings = &self.document.project().quality;
        let stage = state.ok_or_else(|| "the window has no graphics adapter".to_owned());
        match stage.and_then(|state| Stage::new(state, settings, self.most_window)) {
            Ok(stage) => {
                stage.adapter().clone_into(&mut self.status.adapter);
                (self.stage, self.stage_error) = (Some(stage), None);
            }
            Err(reason) => (self.stage, self.stage_error) = (None, Some(reason)),
        }
        self.document.engine_mut().forget_uploads();
    }

    /// Closes the window once `cancel` is asked for.
    pub(super) fn close_when(&mut self, cancel: &Cancel) -> std::io::Result<()> {
        let (asked, waker) = (cancel.clone(), self.waker.clone());
        let watch = move || {
            while !asked.is_cancelled() {
                std::thread::sleep(Duration::from_millis(200));
            }
            waker.wake();
        };
        std::thread::Builder::new()
            .name("relievo-watch".to_owned())
            .spawn(watch)?;
        self.interrupted = Some(cancel.clone());
        Ok(())
    }

    /// The open project.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The viewer.
    pub fn camera(&self) -> &Camera {
        self.navigation.camera()
    }

    /// The selected layer.
    pub fn selected(&self) -> Option<&LayerId> {
        self.selected.as_ref()
    }

    /// Opens a project in place of the one that is open, whose changes are lost.
    ///
    /// # Errors
    /// [`OpenError`]; the one that is open stays.
    pub fn open_project(&mut self, path: &Path) -> Result<(), OpenError> {
        let document = Document::open(path, engine_options(&self.options, &self.waker))?;
        self.show(document);
        self.remember();
        Ok(())
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
    pub(super) fn is_blank(&self) -> bool {
        let document = &self.document;
        document.path().is_none() && document.project().layers.is_empty() && !document.is_changed()
    }

    /// Starts an empty project in place of the one that is open.
    pub(super) fn start_new(&mut self) {
        match Document::empty(engine_options(&self.options, &self.waker)) {
            Ok(document) => self.show(document),
            Err(error) => self
                .log
                .add(Weight::Error, format!("cannot start a project: {error}")),
        }
    }

    fn show(&mut self, document: Document) {
        self.navigation
            .jump_to(document.project().camera.to_camera());
        self.selected = document.project().layers.last().map(|l| l.id.clone());
        self.probe.forget();
        self.dragging = Dragging::No;
        let old = std::mem::replace(&mut self.document, document);
        // Its threads finish what they are at; that is nothing to wait for here.
        let close = std::thread::Builder::new()
            .name("relievo-close".to_owned())
            .spawn(move || drop(old));
        if let Err(error) = close {
            tracing::warn!("the old project closed on the window's thread: {error}");
        }
        self.fit_stage();
    }

    /// Makes the stage fit the project's quality.
    pub(super) fn fit_stage(&mut self) {
        let settings = &self.document.project().quality;
        self.refit = self
            .stage
            .as_ref()
            .is_some_and(|s| s.quality_for(settings) != s.quality());
    }

    /// The device has no room for what is drawn: it is drawn less finely from now on.
    pub(super) fn spend_less(&mut self, error: OutOfMemory, ctx: &egui::Context) {
        let smaller = self.stage.as_ref().and_then(Stage::smaller_window);
        // Its textures go first, or there would be no room for smaller ones.
        self.stage = None;
        if let Some(window) = smaller {
            let text =
                format!("{error}: colours are drawn less finely, in windows of {window} samples");
            self.log.add(Weight::Warning, text);
            self.most_window = window;
            self.refit = true;
            ctx.request_repaint();
        } else {
            self.stage_error = Some(error.to_string());
        }
    }

    /// The window's device is gone: another window takes the place of this one.
    pub(super) fn device_lost(&mut self, ctx: &egui::Context) {
        if !self.restart {
            self.log.add(
                Weight::Warning,
                "the graphics device was lost; another is opened",
            );
            self.restart = true;
            self.stage = None;
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Whether another window shall be opened after this one; asked once.
    pub(super) fn take_restart(&mut self) -> bool {
        std::mem::take(&mut self.restart)
    }

    /// Turns north up around the middle of the picture.
    pub(super) fn north_up(&mut self) {
        let planet = self.document.project().planet.body.figure();
        let (here_m, middle) = (self.ground_below_m(), self.middle());
        self.navigation.north_up(&planet, here_m, middle);
    }

    fn menus(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let mut recent_open = false;
        MenuBar::new().ui(ui, |ui| {
            for menu in Menu::ALL {
                ui.menu_button(menu.title(), |ui| {
                    ui.set_min_width(200.0);
                    for entry in TABLE.iter().filter(|e| e.menu == menu) {
                        if entry.starts_group {
                            ui.separator();
                        }
                        let title = self.title_of(entry);
                        let button =
                            egui::Button::new(title).shortcut_text(entry.shortcut_text(ui.ctx()));
                        let response = ui.add_enabled(self.is_possible(entry.command), button);
                        if response.on_hover_text(entry.help).clicked() {
                            actions.push(Action::Run(entry.command));
                            ui.close();
                        }
                        if entry.command == Command::Open {
                            recent_open |= self.recent_menu(ui, actions);
                        }
                    }
                });
            }
        });
        if self.recent.opens(recent_open) {
            self.look_for_recent();
        }
    }

    /// The projects that were open lately; whether they are shown.
    fn recent_menu(&self, ui: &mut Ui, actions: &mut Vec<Action>) -> bool {
        if self.recent.is_empty() {
            ui.add_enabled(false, egui::Button::new("Open recent"))
                .on_disabled_hover_text("No project has been open yet");
            return false;
        }
        let list = ui.menu_button("Open recent", |ui| {
            ui.set_max_width(460.0);
            if start::projects(ui, &self.recent, actions) {
                ui.close();
            }
            ui.separator();
            let clear = ui.button("Clear this list");
            if clear.on_hover_text("The projects stay").clicked() {
                actions.push(Action::ClearRecent);
                ui.close();
            }
        });
        list.inner.is_some()
    }

    /// A command's title with what it would do now.
    fn title_of(&self, entry: &commands::Entry) -> String {
        let history = self.document.engine().history();
        let undo = history
            .undo_label()
            .filter(|_| entry.command == Command::Undo);
        let redo = history
            .redo_label()
            .filter(|_| entry.command == Command::Redo);
        match undo.or(redo) {
            Some(label) => format!("{}: {label}", entry.title),
            None => entry.title.to_owned(),
        }
    }

    /// Whether a command can do something now.
    pub(super) fn is_possible(&self, command: Command) -> bool {
        let history = self.document.engine().history();
        let layer = self
            .selected
            .as_ref()
            .and_then(|id| self.document.project().layer(id));
        let unlocked = layer.is_some_and(|l| !l.locked);
        match command {
            Command::Undo => history.undo_label().is_some(),
            Command::Redo => history.redo_label().is_some(),
            Command::RemoveLayer | Command::MoveUp | Command::MoveDown | Command::ToggleVisible => {
                unlocked
            }
            Command::ZoomToLayer => layer.is_some_and(|l| l.source().is_some()),
            Command::Locate => unlocked && layer.is_some_and(|l| l.source().is_some()),
            Command::Screenshot => self.stage.is_some(),
            Command::New
            | Command::Open
            | Command::Save
            | Command::SaveAs
            | Command::Quit
            | Command::AddFiles
            | Command::AddNoise
            | Command::AddTint
            | Command::NorthUp
            | Command::ResetView
            | Command::GoTo
            | Command::ToggleLayers
            | Command::ToggleInspector
            | Command::ToggleMessages
            | Command::Retry
            | Command::Help => true,
        }
    }

    fn panels(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let mut panels = self.panels;
        Panel::top("menu").show(ui, |ui| self.menus(ui, actions));
        Panel::bottom("status").exact_size(26.0).show(ui, |ui| {
            status::show(ui, &self.status, &mut self.notation, actions);
        });
        let messages = Panel::bottom("messages")
            .resizable(true)
            .default_size(140.0)
            .size_range(70.0..=420.0);
        messages.show_collapsible(ui, &mut panels.messages, |ui| {
            messages::show(ui, self.document.engine(), &mut self.log, actions);
        });
        let list = Panel::left("layers")
            .resizable(true)
            .default_size(270.0)
            .size_range(200.0..=460.0);
        list.show_collapsible(ui, &mut panels.layers, |ui| {
            layers::show(ui, self.document.engine(), self.selected.as_ref(), actions);
        });
        let settings = Panel::right("inspector")
            .resizable(true)
            .default_size(310.0)
            .size_range(260.0..=520.0);
        settings.show_collapsible(ui, &mut panels.inspector, |ui| {
            self.inspector
                .show(ui, self.document.engine(), self.selected.as_ref(), actions);
        });
        self.panels = panels;
        let bare = Frame::new().inner_margin(Margin::ZERO);
        CentralPanel::default()
            .frame(bare)
            .show(ui, |ui| self.viewport(ui, actions));
    }

    /// Files that were dropped on the window: a project is opened, rasters become layers.
    fn take_dropped(&mut self, ctx: &egui::Context) {
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

    /// Asks before changes are lost with the window.
    fn guard_close(&mut self, ctx: &egui::Context) {
        if self.interrupted.take_if(|c| c.is_cancelled()).is_some() {
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
        let asked = ctx.input(|i| i.viewport().close_requested());
        if asked && !self.closing && !self.restart && self.document.is_changed() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.dialog = Some(Dialog::Unsaved(Then::Quit));
        }
    }

    /// A control that vanished in the middle of a drag cannot end it; Escape takes it back.
    fn mind_drag(&mut self, ctx: &egui::Context) {
        if self.dragging == Dragging::No {
            return;
        }
        if self.dragging == Dragging::Yes && ctx.input(|i| i.key_pressed(Key::Escape)) {
            self.document.cancel_drag();
            self.dragging = Dragging::TakenBack;
        }
        if !ctx.input(|i| i.pointer.any_down()) {
            if self.dragging == Dragging::Yes {
                self.document.end_drag();
            }
            self.dragging = Dragging::No;
        }
    }

    fn show_title(&mut self, ctx: &egui::Context) {
        let mark = if self.document.is_changed() {
            " ●"
        } else {
            ""
        };
        let title = format!("{}{mark} – Relievo", self.document.name());
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn refit_stage(&mut self, frame: &eframe::Frame) {
        if std::mem::take(&mut self.refit) {
            self.set_stage(frame.wgpu_render_state());
        }
    }

    /// One frame of the window.
    fn one_frame(&mut self, ui: &mut Ui, frame: &eframe::Frame) {
        let started = Instant::now();
        let ctx = ui.ctx().clone();
        self.take_events(&ctx);
        self.take_dropped(&ctx);
        self.guard_close(&ctx);
        self.refit_stage(frame);
        if self.stage.as_ref().is_some_and(Stage::is_lost) {
            self.device_lost(&ctx);
        }
        let engine = self.document.engine();
        self.status.opening = engine.stats().opening;
        let serious = engine
            .messages()
            .iter()
            .filter(|m| m.severity >= Severity::Warning)
            .count();
        self.status.problems = serious + self.log.problems();
        let mut actions = Vec::new();
        if self.dialog.is_none() {
            actions.extend(
                commands::pressed(&ctx)
                    .into_iter()
                    .filter(|c| self.is_possible(*c))
                    .map(Action::Run),
            );
        }
        self.panels(ui, &mut actions);
        self.answer_dialog(&ctx);
        if !actions.is_empty() {
            ctx.request_repaint();
        }
        for action in actions {
            self.carry_out(action, &ctx);
        }
        self.mind_drag(&ctx);
        self.show_title(&ctx);
        let ms = started.elapsed().as_secs_f64() * 1e3;
        self.status.frame_ms = ms;
    }

    fn answer_dialog(&mut self, ctx: &egui::Context) {
        let name = self.document.name();
        let Some(dialog) = &mut self.dialog else {
            return;
        };
        if let Some(answer) = dialogs::show(ctx, dialog, &name) {
            self.dialog = None;
            ctx.request_repaint();
            self.take_answer(answer, ctx);
        }
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.one_frame(ui, frame);
    }
}

fn engine_options(options: &StudioOptions, waker: &Waker) -> EngineOptions {
    let waker = waker.clone();
    EngineOptions {
        threads: options.threads,
        cache_folder: options.cache_folder.clone(),
        disk_cache: options.disk_cache,
        wake: Some(Arc::new(move || waker.wake())),
        watch: Some(WATCH),
        ..EngineOptions::default()
    }
}
