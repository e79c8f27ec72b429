//! One frame of the window.

use std::time::{Duration, Instant};

use eframe::egui::{self, Key, Ui, ViewportCommand};
use relievo_engine::Severity;
use relievo_engine::raster::Cancel;

use super::{Dragging, Studio};
use crate::commands::{self, Command};
use crate::window::action::Action;
use crate::window::dialogs::{self, Dialog, Then};
use crate::window::palette::{self, Outcome};
use crate::window::stage::Stage;

impl Studio {
    /// One frame of the window.
    pub(super) fn one_frame(&mut self, ui: &mut Ui, frame: &eframe::Frame) {
        let started = Instant::now();
        let ctx = ui.ctx().clone();
        self.take_events(&ctx);
        self.take_dropped(&ctx);
        self.mind_file(&ctx);
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
        if self.dialog.is_none() && self.palette.is_none() {
            let mut pressed = commands::pressed(&ctx);
            if pressed.contains(&Command::Palette) {
                // What was typed after its keys in one slow frame is for it.
                pressed.retain(|c| *c == Command::Palette);
            }
            if self.has_chosen_corner() && pressed.contains(&Command::RemoveLayer) {
                // The key means the corner that is chosen on the terrain.
                pressed.retain(|c| *c != Command::RemoveLayer);
                actions.extend(self.without_corner());
            }
            pressed.retain(|c| self.is_possible(*c));
            actions.extend(pressed.into_iter().map(Action::Run));
        }
        self.mind_analyses(ui);
        self.panels(ui, &mut actions);
        self.show_palette(&ctx, &mut actions);
        self.answer_dialog(&ctx);
        if !actions.is_empty() {
            ctx.request_repaint();
        }
        for action in actions {
            self.carry_out(action, &ctx);
        }
        self.mind_drag(&ctx);
        self.mind_trouble();
        self.show_title(&ctx);
        // While something is being dragged it changes with every frame.
        if !ctx.input(|i| i.pointer.any_down()) && self.layout.take_changed() {
            self.settings.save(&self.layout);
        }
        let ms = started.elapsed().as_secs_f64() * 1e3;
        self.status.frame_ms = ms;
    }

    /// Closes the window once `cancel` is asked for.
    pub(in crate::window) fn close_when(&mut self, cancel: &Cancel) -> std::io::Result<()> {
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

    /// Asks before changes are lost with the window.
    pub(super) fn guard_close(&mut self, ctx: &egui::Context) {
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
    pub(super) fn mind_drag(&mut self, ctx: &egui::Context) {
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

    pub(super) fn show_title(&mut self, ctx: &egui::Context) {
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

    pub(super) fn answer_dialog(&mut self, ctx: &egui::Context) {
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

    fn show_palette(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        let Some(mut palette) = self.palette.take() else {
            return;
        };
        let offers = palette::offers(|e| self.title_of(e), |c| self.is_possible(c));
        match palette.show(ctx, &offers) {
            Outcome::Open => self.palette = Some(palette),
            Outcome::Closed => ctx.request_repaint(),
            Outcome::Run(command) => actions.push(Action::Run(command)),
        }
    }
}
