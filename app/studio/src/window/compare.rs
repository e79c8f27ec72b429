//! Two scenarios at once: swiped, side by side, or one after the other while a key is held.
//!
//! The other scenario has an engine and a stage of its own that follow the document and the camera.
//! Both read the same cache folder, so that tiles the scenarios share are made once. What it costs is
//! the memory of a second picture and of a second cache of tiles, while it is on.

mod difference;

use eframe::egui::{
    self, Align2, Color32, CursorIcon, FontId, Key, Pos2, Rect, Role, Sense, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};
use relievo_engine::project::{Project, ScenarioId};
use relievo_engine::{Engine, EngineOptions, HeightDifference};
use relievo_gpu::AdapterClass;

use self::difference::{Differences, Wanted};
use super::latest::Latest;
use super::messages::Weight;
use super::stage::Stage;
use super::studio::Studio;
use super::theme;
use crate::picture;

/// Bytes of tiles that the second engine keeps in memory.
const MEMORY: usize = 256 << 20;

/// How far a key moves the swipe.
const STEP: f32 = 0.02;

/// How two scenarios are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// One left and one right of a line that can be dragged.
    Swipe,
    /// Each in its own half, seen through the same camera.
    SideBySide,
    /// The other one while a key is held.
    Blink,
    /// How much higher or lower the ground is, as colours.
    Difference,
}

impl Mode {
    /// All of them with their names.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::Swipe, "Swipe"),
        (Self::SideBySide, "Side by side"),
        (Self::Blink, "Hold X"),
        (Self::Difference, "Difference"),
    ];
}

/// A comparison that is on.
pub(crate) struct Compare {
    pub(crate) mode: Mode,
    /// What the shown scenario is compared with; `None`: the base.
    pub(crate) other: Option<ScenarioId>,
    engine: Engine,
    stage: Option<Stage>,
    /// The state of the document that the other engine shows.
    revision: u64,
    /// Where the line of the swipe is, 0 to 1.
    swipe: f32,
    differences: Differences,
}

impl Compare {
    /// The difference that the document's own picture shows.
    pub(crate) fn difference(&self) -> Option<(Option<ScenarioId>, HeightDifference)> {
        let colours = self
            .differences
            .colours()
            .filter(|_| self.mode == Mode::Difference);
        Some((self.other.clone(), colours?))
    }
}

/// The parts of the view: the rectangle of the document's own picture, where it is seen, and the
/// same of the other one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parts {
    pub(crate) own: Rect,
    pub(crate) own_seen: Rect,
    pub(crate) other: Option<(Rect, Rect)>,
}

impl Parts {
    /// The picture that a point of the screen belongs to, for what the pointer does.
    pub(crate) fn under(&self, at: Option<Pos2>) -> Rect {
        match (self.other, at) {
            (Some((other, _)), Some(at)) if other != self.own && other.contains(at) => other,
            _ => self.own,
        }
    }
}

impl Studio {
    /// Compares the shown scenario with another; starts a second engine unless one is there.
    pub(super) fn compare_with(&mut self, other: Option<ScenarioId>, mode: Mode) {
        if let Some(compare) = &mut self.compare {
            compare.mode = mode;
            compare.revision = u64::MAX;
            compare.other = other;
            return;
        }
        let options = EngineOptions {
            memory: MEMORY,
            tally: false,
            watch: None,
            ..self.engine_options()
        };
        let project = showing(self.document.project(), other.as_ref());
        let folder = self.document.engine().folder().to_owned();
        let latest = Latest::new("relievo-difference", self.waker());
        let made = Engine::new(project, &folder, options);
        match made.and_then(|engine| Ok((engine, latest?))) {
            Ok((engine, latest)) => {
                self.compare = Some(Compare {
                    mode,
                    other,
                    engine,
                    stage: None,
                    revision: self.document.revision(),
                    swipe: 0.5,
                    differences: Differences::new(latest),
                });
            }
            Err(error) => self
                .log
                .add(Weight::Error, format!("cannot compare: {error}")),
        }
    }

    /// Ends the comparison.
    pub(super) fn stop_comparing(&mut self) {
        self.compare = None;
    }

    /// Where the pictures are in the view.
    pub(super) fn parts(&self, ui: &Ui, rect: Rect) -> Parts {
        let whole = Parts {
            own: rect,
            own_seen: rect,
            other: None,
        };
        let Some(compare) = &self.compare else {
            return whole;
        };
        let held = !ui.ctx().text_edit_focused() && ui.input(|i| i.key_down(Key::X));
        if held {
            let nothing = Rect::from_min_size(rect.min, vec2(0.0, 0.0));
            return Parts {
                own_seen: nothing,
                other: Some((rect, rect)),
                ..whole
            };
        }
        match compare.mode {
            Mode::Blink | Mode::Difference => whole,
            Mode::Swipe => {
                let x = rect.left() + compare.swipe * rect.width();
                let (left, right) = rect.split_left_right_at_x(x);
                Parts {
                    own_seen: left,
                    other: Some((rect, right)),
                    ..whole
                }
            }
            Mode::SideBySide => {
                let (left, right) = rect.split_left_right_at_fraction(0.5);
                Parts {
                    own: left,
                    own_seen: left,
                    other: Some((right, right)),
                }
            }
        }
    }

    /// Draws the other scenario's picture, with the camera and the document as they are now.
    pub(super) fn draw_other(&mut self, ui: &Ui, parts: &Parts, dt_s: f32) {
        let revision = self.document.revision();
        let camera = *self.navigation.camera();
        let settings = self.document.project().quality.clone();
        let render_state = self.render_state.clone();
        let (chosen, most_window) = (self.governor.setting(), self.most_window);
        let Some(compare) = &mut self.compare else {
            return;
        };
        if compare.revision != revision {
            compare.revision = revision;
            let other = compare.other.as_ref();
            compare
                .engine
                .follow(showing(self.document.project(), other));
        }
        // While it is not seen it is made all the same, so that it is there when it is.
        let (rect, seen) = parts.other.unwrap_or((parts.own, Rect::NOTHING));
        if compare.stage.is_none()
            && let Some(state) = &render_state
        {
            compare.stage = Stage::new(state, &settings, chosen, most_window).ok();
        }
        let scale = ui.ctx().pixels_per_point();
        let size_px = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        let fineness = match &compare.stage {
            Some(stage) => stage.fineness(&settings, chosen),
            None => picture::fineness(&settings, AdapterClass::Software, chosen),
        };
        compare
            .engine
            .set_view(picture::view(camera, size_px, &fineness));
        let Some(frame) = compare.engine.drain(dt_s) else {
            return;
        };
        self.status.pending += frame.pending + usize::from(compare.engine.is_busy());
        if let Some(stage) = &mut compare.stage {
            if let Err(error) = stage.draw(&frame, &fineness, true) {
                self.log
                    .add(Weight::Error, format!("the comparison ends: {error}"));
                self.compare = None;
                return;
            }
            if seen.is_positive() {
                ui.painter().with_clip_rect(seen).add(stage.shape(rect));
            }
        }
        if !frame.uploads.is_empty() || frame.pending > 0 {
            ui.ctx().request_repaint();
        }
    }

    /// The line of the swipe and the names of both sides.
    pub(super) fn compare_overlay(&mut self, ui: &mut Ui, rect: Rect, parts: &Parts) {
        let project = self.document.project();
        let own = name_of(project, project.scenario.as_ref());
        let revision = self.state();
        let Some(compare) = &mut self.compare else {
            return;
        };
        let other = name_of(project, compare.other.as_ref());
        if compare.mode == Mode::Difference && parts.other.is_none() {
            let wanted = Wanted {
                revision,
                camera: *self.navigation.camera(),
                aspect: f64::from(rect.aspect_ratio()),
            };
            let engine = self.document.engine();
            if !self.navigation.is_moving() && !ui.input(|i| i.pointer.any_down()) {
                let other = compare.other.as_ref();
                let both = || (engine.questions(), engine.questions_in(other));
                compare.differences.ask(&wanted, both);
            }
            compare.differences.update(&wanted);
            compare.differences.legend(ui, rect, &own, &other);
            return;
        }
        if let Some((_, seen)) = parts.other {
            side_label(ui, seen, Align2::RIGHT_BOTTOM, &other);
        }
        if parts.own_seen.is_positive() {
            side_label(ui, parts.own_seen, Align2::LEFT_BOTTOM, &own);
        }
        if compare.mode == Mode::SideBySide && parts.other.is_some() {
            let line = Stroke::new(2.0, Color32::from_gray(20));
            ui.painter()
                .vline(parts.own_seen.right(), rect.y_range(), line);
        }
        if compare.mode != Mode::Swipe || !parts.own_seen.is_positive() && compare.swipe > 0.01 {
            return;
        }
        let x = rect.left() + compare.swipe * rect.width();
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(14.0, rect.height()));
        let response = ui.interact(grip, ui.scope_id().with("swipe"), Sense::click_and_drag());
        let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);
        let share = f64::from(compare.swipe);
        response.widget_info(|| WidgetInfo::slider(true, share, "Line between both scenarios"));
        if response.dragged() {
            compare.swipe += response.drag_delta().x / rect.width();
        }
        if response.has_focus() {
            let (left, right) = ui.input(|i| {
                (
                    i.key_pressed(Key::ArrowLeft),
                    i.key_pressed(Key::ArrowRight),
                )
            });
            compare.swipe += STEP * (f32::from(u8::from(right)) - f32::from(u8::from(left)));
        }
        compare.swipe = compare.swipe.clamp(0.0, 1.0);
        let bright = response.hovered() || response.dragged() || response.has_focus();
        let stroke = Stroke::new(if bright { 3.0 } else { 2.0 }, Color32::WHITE);
        ui.painter().vline(x, rect.y_range(), stroke);
        ui.painter()
            .circle(pos2(x, rect.center().y), 9.0, theme::OVERLAY, stroke);
    }
}

/// The project as another scenario shows it.
fn showing(project: &Project, other: Option<&ScenarioId>) -> Project {
    let known = other.filter(|id| project.scenario(id).is_some());
    Project {
        scenario: known.cloned(),
        ..project.clone()
    }
}

/// What people call a scenario.
pub(crate) fn name_of(project: &Project, id: Option<&ScenarioId>) -> String {
    id.and_then(|id| project.scenario(id))
        .map_or_else(|| "Base".to_owned(), |s| s.name.clone())
}

fn side_label(ui: &mut Ui, part: Rect, align: Align2, text: &str) {
    let font = FontId::proportional(14.0);
    let galley = ui
        .painter()
        .layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let area = align.align_size_within_rect(galley.size() + vec2(16.0, 8.0), part.shrink(10.0));
    if !part.contains_rect(area) {
        return;
    }
    let painter = ui.painter_at(part);
    painter.rect_filled(area, egui::CornerRadius::same(4), theme::OVERLAY);
    painter.galley(area.min + vec2(8.0, 4.0), galley, Color32::WHITE);
    let name = format!("Side of {text}");
    let response = ui.interact(area, ui.scope_id().with(&name), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &name));
}
