//! The studio and its window's device: a stage that fits the project, less of it, another window.

use eframe::egui::{self, ViewportCommand};
use relievo_gpu::OutOfMemory;

use super::Studio;
use crate::window::messages::Weight;
use crate::window::stage::Stage;
use crate::window::theme;

impl Studio {
    /// Moves into a window: takes its device and wakes it from now on.
    pub fn attach(&mut self, cc: &eframe::CreationContext<'_>) {
        theme::apply(&cc.egui_ctx);
        self.settings.apply(&cc.egui_ctx);
        self.waker.attach(&cc.egui_ctx);
        self.title.clear();
        self.closing = false;
        self.render_state.clone_from(&cc.wgpu_render_state);
        self.compare = None;
        self.set_stage(cc.wgpu_render_state.as_ref());
        self.look_for_recent();
        self.look_for_abandoned();
    }

    pub(super) fn set_stage(&mut self, state: Option<&eframe::egui_wgpu::RenderState>) {
        let settings = &self.document.project().quality;
        let chosen = self.governor.setting();
        let stage = state.ok_or_else(|| "the window has no graphics adapter".to_owned());
        match stage.and_then(|state| Stage::new(state, settings, chosen, self.most_window)) {
            Ok(stage) => {
                stage.adapter().clone_into(&mut self.status.adapter);
                (self.stage, self.stage_error) = (Some(stage), None);
            }
            Err(reason) => (self.stage, self.stage_error) = (None, Some(reason)),
        }
        self.document.engine_mut().forget_uploads();
    }

    /// Makes the stage's windows fit the project's quality; what else is spent follows with each frame.
    pub(super) fn fit_stage(&mut self) {
        let settings = &self.document.project().quality;
        self.refit = self
            .stage
            .as_ref()
            .is_some_and(|s| s.has_other_windows(settings));
    }

    pub(super) fn refit_stage(&mut self, frame: &eframe::Frame) {
        if std::mem::take(&mut self.refit) {
            self.set_stage(frame.wgpu_render_state());
        }
    }

    /// The device has no room for what is drawn: it is drawn less finely from now on.
    pub(in crate::window) fn spend_less(&mut self, error: OutOfMemory, ctx: &egui::Context) {
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
    pub(in crate::window) fn device_lost(&mut self, ctx: &egui::Context) {
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
    pub(in crate::window) fn take_restart(&mut self) -> bool {
        std::mem::take(&mut self.restart)
    }
}
