//! The view of the planet: pointer and keys move the camera, the engine's frame is drawn.

mod signs;

use std::time::Duration;

use eframe::egui::{
    Color32, CornerRadius, Key, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo,
    vec2,
};
use glam::{DVec2, DVec3};
use relievo_engine::analysis::Task;
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::camera::FlyInput;
use relievo_engine::project::Aim;
use relievo_engine::{Frame, View};
use relievo_gpu::{AdapterClass, Quality, RenderError};

use super::action::Action;
use super::compare::{Compare, Parts};
use super::governor::{Occasion, Wish};
use super::messages::Weight;
use super::navigation::Hit;
use super::pace::REST_S as PICTURE_REST_S;
use super::probe::Spot;
use super::start;
use super::status::Pointed;
use super::studio::{Dragging, Studio};
use super::tools::Tool;
use crate::picture;

/// Points that the wheel scrolls for one step of zoom.
const POINTS_PER_STEP: f64 = 80.0;

/// Longest time between frames that motion follows, seconds: after a pause nothing jumps.
const LONGEST_FRAME_S: f32 = 0.1;

/// The pointer rests when it has not moved for so long, seconds.
const REST_S: f32 = 0.12;

/// Factor on the speed of flight while Shift is held.
const FASTER: f64 = 5.0;

impl Studio {
    /// Draws the viewport into all that is left.
    pub(super) fn viewport(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "View of the planet"));
        if rect.width() < 1.0 || rect.height() < 1.0 {
            return;
        }
        let parts = self.parts(ui, rect);
        self.aspect = f64::from(parts.own.aspect_ratio());
        // What was grabbed in one picture stays in it.
        let at = ui.input(|i| i.pointer.press_origin().or(i.pointer.latest_pos()));
        let active = parts.under(at);
        let dt_s = ui.input(|i| i.stable_dt).min(LONGEST_FRAME_S);
        let taken = self.use_tool(ui, active, &response, actions);
        self.steer(ui, active, &response, dt_s, taken);
        self.draw(ui, &parts, dt_s);
        self.draw_other(ui, &parts, dt_s);
        self.paint_tools(ui, parts.own);
        self.analysis_overlay(ui, parts.own);
        self.compare_overlay(ui, rect, &parts);
        self.point(ui, active, &response);
        self.compass(ui, rect);
        if self.is_blank() {
            let offers = start::Offers {
                samples: &self.samples,
                recent: &self.recent,
                trouble: self.stage_error.as_deref(),
            };
            start::show(ui, rect, &offers, actions);
        } else {
            self.notes(ui, rect);
            self.tool_bar(ui, rect, actions);
        }
    }

    /// What the chosen tool does with pointer and keys; `true` while it has the pointer.
    fn use_tool(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) -> bool {
        if self.is_blank() {
            return false;
        }
        match self.tools.tool {
            Tool::Select => {
                let taken = self.drag_handles(ui, rect, response, actions);
                if !taken && response.clicked() {
                    self.pick_element(ui, rect, actions);
                }
                taken
            }
            Tool::Polygon
            | Tool::Hole
            | Tool::Breakline
            | Tool::Corridor
            | Tool::Measure
            | Tool::LensOutline => {
                self.draw_draft(ui, rect, response, actions);
                false
            }
            Tool::Observer | Tool::Water => {
                self.place_question(ui, rect, response);
                false
            }
            Tool::Brush => self.paint_stroke(ui, rect, response, actions),
            Tool::Lens => self.drag_lens(ui, rect, response, actions),
        }
    }

    /// Moves the camera, as far as a tool has not `taken` the pointer.
    fn steer(&mut self, ui: &Ui, rect: Rect, response: &Response, dt_s: f32, taken: bool) {
        let planet = self.document.project().planet.body.figure();
        let aspect = f64::from(rect.aspect_ratio());
        let here_m = self.ground_below_m();
        let pointer = ui.input(|i| i.pointer.latest_pos());
        if response.drag_started() && taken {
            response.request_focus();
        } else if response.drag_started() {
            let origin = ui.input(|i| i.pointer.press_origin()).or(pointer);
            let orbit = !response.drag_started_by(PointerButton::Primary)
                || ui.input(|i| i.modifiers.command);
            let hit = origin.and_then(|p| self.hit(rect, p));
            self.navigation.grab(hit, orbit);
            response.request_focus();
        }
        if response.dragged()
            && !taken
            && let Some(at) = pointer
        {
            let moved = response.drag_delta() / rect.height();
            let moved = DVec2::new(f64::from(moved.x), f64::from(moved.y));
            self.navigation.drag(&planet, ndc(rect, at), aspect, moved);
        }
        if response.drag_stopped() {
            self.navigation.release();
        }
        if response.hovered()
            && let Some(at) = pointer
        {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            let steps = f64::from(scroll) / POINTS_PER_STEP + f64::from(pinch).ln() / 1.25_f64.ln();
            if steps != 0.0 {
                let ground_m = self.hit(rect, at).map_or(here_m, |h| h.ground_m);
                self.navigation
                    .zoom(&planet, ground_m, ndc(rect, at), aspect, steps);
            }
        }
        if response.double_clicked()
            && self.tools.tool == Tool::Select
            && let Some(at) = pointer
            && let Some(hit) = self.hit(rect, at)
        {
            self.navigation
                .approach(&planet, here_m, hit, ndc(rect, at), aspect);
        }
        let input = if self.dialog.is_none() && !ui.ctx().text_edit_focused() {
            keys(ui)
        } else {
            FlyInput::default()
        };
        let held = input.right != 0.0 || input.forward != 0.0 || input.up != 0.0;
        if let Some(there) = self.navigation.destination() {
            let there_m = self.ground_m(there);
            self.navigation.aim(&planet, there_m);
        }
        self.navigation
            .advance(&planet, here_m, &input, f64::from(dt_s));
        let moves = held || self.navigation.is_moving();
        // Ground that is coarse yet may lie above the place where the viewer stands: whoever does not
        // move waits for what is finer.
        if moves || (self.status.pending == 0 && self.status.opening == 0) {
            self.navigation.stay_above(self.ground_below_m());
        }
        if moves {
            ui.ctx().request_repaint();
        }
    }

    fn draw(&mut self, ui: &Ui, parts: &Parts, dt_s: f32) {
        let rect = parts.own;
        let scale = ui.ctx().pixels_per_point();
        let full_px = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        let viewport_px = self.picture_size_px(ui, full_px);
        self.govern(ui);
        let (settings, chosen) = (&self.document.project().quality, self.governor.setting());
        let fineness = match &self.stage {
            Some(stage) => stage.fineness(settings, chosen),
            None => picture::fineness(settings, AdapterClass::Software, chosen),
        };
        let view = picture::view(*self.navigation.camera(), viewport_px, &fineness);
        let label_view = View {
            viewport_px: full_px,
            ..view
        };
        let difference = self.compare.as_ref().and_then(Compare::difference);
        let engine = self.document.engine_mut();
        engine.show_difference(difference);
        engine.set_view(view);
        let Some(frame) = engine.drain(dt_s) else {
            return;
        };
        self.status.pending = frame.pending;
        if let Some(stage) = &mut self.stage {
            match stage.draw(&frame, &fineness, self.pace.rests()) {
                Ok(()) => {}
                Err(RenderError::DeviceLost) => self.device_lost(ui.ctx()),
                Err(RenderError::OutOfMemory(error)) => self.spend_less(error, ui.ctx()),
                Err(error @ RenderError::Upload(_)) => {
                    self.log.add(Weight::Error, error.to_string());
                }
            }
        }
        match &self.stage {
            Some(stage) => {
                let painter = ui.painter().with_clip_rect(parts.own_seen);
                if parts.own_seen.is_positive() {
                    painter.add(stage.shape(rect));
                }
                let measured = stage.stats().and_then(|s| s.measured);
                self.status.gpu_ms = measured.map(|m| m.gpu_ms);
                if let Some(measured) = measured {
                    self.pace.measured(measured.gpu_ms, measured.pixels as f64);
                    let whole_px = full_px.map(f64::from).iter().product();
                    self.governor.measured(measured, whole_px);
                }
                self.status.triangles = stage.stats().map_or(0, |s| s.triangles);
            }
            None => {
                ui.painter()
                    .rect_filled(rect, CornerRadius::ZERO, Color32::from_gray(12));
            }
        }
        if parts.own_seen.is_positive() {
            self.paint_labels(ui, parts, &label_view);
        }
        if is_changing(&frame) {
            ui.ctx().request_repaint();
        } else if frame.pending > 0 {
            // Tiles wake the window when they are there; this is for what does not.
            ui.ctx().request_repaint_after(Duration::from_millis(100));
        }
    }

    /// Chooses how finely is drawn, where the project leaves that to what is measured.
    fn govern(&mut self, ui: &Ui) {
        let settings = &self.document.project().quality;
        let wish = match settings.aim {
            Aim::Adapter => Wish::Adapter,
            Aim::Error => Wish::ErrorPx(settings.error_px),
            Aim::FrameTime => Wish::FrameMs(settings.frame_budget_ms),
        };
        let occasion = if self.dragging != Dragging::No || ui.input(|i| i.pointer.any_down()) {
            Occasion::Dragged
        } else if self.pace.rests() {
            Occasion::Still
        } else {
            Occasion::Moving
        };
        let standard = match &self.stage {
            Some(stage) => stage.standard(),
            None => Quality::for_adapter(AdapterClass::Software),
        };
        let like = self.governor.front().like(&standard);
        self.governor.follow(wish, like, occasion);
        self.pace.allow(self.governor.budget_ms());
    }

    /// Size of the picture, which may be coarser than the view while something moves.
    fn picture_size_px(&mut self, ui: &Ui, full_px: [u32; 2]) -> [u32; 2] {
        let camera = *self.navigation.camera();
        let moving = self.dragging == Dragging::Yes
            || self.navigation.is_moving()
            || self.drawn_camera.replace(camera) != Some(camera);
        let size_px = self.pace.size_px(full_px, ui.input(|i| i.time), moving);
        if !self.pace.rests() {
            let rest = Duration::from_secs_f64(PICTURE_REST_S);
            ui.ctx().request_repaint_after(rest);
        }
        size_px
    }

    /// What the status bar says of the place under the pointer.
    fn point(&mut self, ui: &Ui, rect: Rect, response: &Response) {
        self.status.above_ground_m = self.navigation.camera().altitude_m - self.ground_below_m();
        let at = response
            .hover_pos()
            .filter(|_| response.hovered() || response.dragged());
        let found = at.and_then(|at| {
            let camera = *self.navigation.camera();
            let (eye, ray) = self.ray(rect, at, &camera);
            self.document.engine().cast(eye, ray)
        });
        let Some((point, drawn_m)) = found else {
            self.status.pointed = None;
            return;
        };
        // A rounded place: what is asked for stays the same while nothing moves.
        let spot = Spot {
            point,
            revision: self.state(),
        };
        let rests = ui.input(|i| i.pointer.time_since_last_movement()) >= REST_S
            && !self.navigation.is_moving();
        if rests && self.status.pending == 0 && self.status.opening == 0 {
            let engine = self.document.engine();
            self.probe.ask(spot, || {
                let questions = engine.questions();
                move |task: &Task| questions.place(point, task.cancel).ok()
            });
        } else if !rests {
            ui.ctx()
                .request_repaint_after(Duration::from_secs_f32(REST_S));
        }
        let measured = self
            .probe
            .answer(&spot)
            .flatten()
            .map(|a| (a.height_m, a.slope_deg, a.spacing_m));
        self.status.pointed = Some(Pointed {
            point,
            drawn_m,
            measured,
        });
    }

    /// The ground that a point of the screen shows.
    pub(super) fn hit(&self, rect: Rect, at: Pos2) -> Option<Hit> {
        let (eye, ray) = self.ray(rect, at, self.navigation.camera());
        let (point, height_m) = self.document.engine().cast(eye, ray)?;
        let ground_m = height_m * self.document.engine().exaggeration();
        Some(Hit {
            direction: point.to_unit(),
            ground_m,
        })
    }

    /// The ground in the middle of the picture.
    pub(super) fn middle(&self) -> Option<Hit> {
        let square = Rect::from_min_size(Pos2::ZERO, vec2(2.0, 2.0));
        self.hit(square, square.center())
    }

    fn ray(&self, rect: Rect, at: Pos2, camera: &relievo_engine::planet::Camera) -> (DVec3, DVec3) {
        let planet = self.document.project().planet.body.figure();
        let ndc = ndc(rect, at);
        (
            camera.eye(&planet),
            camera.ray(ndc.x, ndc.y, f64::from(rect.aspect_ratio())),
        )
    }

    /// Height of the drawn ground below the eye, metres.
    pub(super) fn ground_below_m(&self) -> f64 {
        self.ground_m(self.navigation.camera().map_point())
    }

    /// Height of the drawn ground at a place, exaggerated, metres.
    pub(super) fn ground_m(&self, point: MapPoint) -> f64 {
        let engine = self.document.engine();
        engine.ground_m(point) * engine.exaggeration()
    }
}

/// A point of the screen as −1 to 1, right and up.
fn ndc(rect: Rect, at: Pos2) -> DVec2 {
    let from_centre = (at - rect.center()) / (rect.size() * 0.5);
    DVec2::new(f64::from(from_centre.x), -f64::from(from_centre.y))
}

/// Whether the next frame differs from this one without anything new.
fn is_changing(frame: &Frame) -> bool {
    let levels = [&frame.heights, &frame.colours, &frame.normals];
    !frame.uploads.is_empty() || levels.into_iter().flatten().any(|l| l.view.fade < 1.0)
}

/// What the keys ask of the flying camera. With Ctrl or Alt they mean commands.
fn keys(ui: &Ui) -> FlyInput {
    ui.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return FlyInput::default();
        }
        let axis = |plus: Key, minus: Key| {
            f64::from(u8::from(i.key_down(plus))) - f64::from(u8::from(i.key_down(minus)))
        };
        FlyInput {
            right: axis(Key::D, Key::A),
            forward: axis(Key::W, Key::S),
            up: axis(Key::E, Key::Q),
            boost: if i.modifiers.shift { FASTER } else { 1.0 },
        }
    })
}
