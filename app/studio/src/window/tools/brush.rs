//! The brush: heights changed by hand, stroke by stroke.

use std::sync::Arc;

use eframe::egui::{Key, Modifiers, PointerButton, Pos2, Rect, Response, Ui};
use relievo_engine::project::{
    Brush, BrushTool, Edit, Element, ElementId, ElementKind, Extra, Stroke, Vertex, Vertices,
};

use super::Tool;
use super::view;
use crate::window::action::Action;
use crate::window::studio::Studio;

/// What the brush does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Effect {
    #[default]
    Raise,
    Lower,
    Smooth,
    Flatten,
}

impl Effect {
    /// All of them with their names.
    pub(crate) const ALL: [(Self, &'static str); 4] = [
        (Self::Raise, "Raise"),
        (Self::Lower, "Lower"),
        (Self::Smooth, "Smooth"),
        (Self::Flatten, "Flatten"),
    ];
}

/// How the next stroke is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BrushSettings {
    pub(crate) effect: Effect,
    /// Radius on the screen, points: what is seen is what is changed.
    pub(crate) radius: f32,
    /// Metres at the centre, for raising and lowering.
    pub(crate) strength_m: f64,
    /// Share of the radius with full effect.
    pub(crate) hardness: f64,
}

impl Default for BrushSettings {
    fn default() -> Self {
        Self {
            effect: Effect::Raise,
            radius: 40.0,
            strength_m: 20.0,
            hardness: 0.3,
        }
    }
}

impl Studio {
    /// The main button paints; `true` while it does.
    pub(in crate::window) fn paint_stroke(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) -> bool {
        let typing = ui.ctx().text_edit_focused() || self.dialog.is_some();
        if !typing
            && self.tools.stroke.is_none()
            && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape))
        {
            self.tools.choose(Tool::Select);
            return false;
        }
        let at = ui.input(|i| i.pointer.latest_pos());
        if response.drag_started_by(PointerButton::Primary) && !ui.input(|i| i.modifiers.command) {
            let origin = ui.input(|i| i.pointer.press_origin()).or(at);
            if let Some(origin) = origin {
                self.begin_stroke(rect, origin, actions);
                // The stroke is there in the next frame.
                return self.tools.stroke.is_some();
            }
        }
        let Some(id) = self.tools.stroke.clone() else {
            return false;
        };
        if response.dragged()
            && let Some(at) = at
        {
            self.continue_stroke(rect, &id, at, actions);
        }
        if response.drag_stopped() || !ui.input(|i| i.pointer.any_down()) {
            actions.push(Action::EndDrag);
            self.tools.stroke = None;
        }
        true
    }

    /// Metres on the ground under the brush.
    fn brush_radius_m(&self, rect: Rect, at: Pos2) -> Option<f64> {
        let hit = self.hit(rect, at)?;
        let planet = self.document.project().planet.body.figure();
        let place = hit.direction * (planet.radius_m + hit.ground_m);
        let distance_m = place.distance(self.camera().eye(&planet));
        let height_m = 2.0 * (0.5 * self.camera().fov_y_rad).tan() * distance_m;
        let share = f64::from(self.tools.brush.radius / rect.height());
        Some((height_m * share).clamp(0.01, 1e6))
    }

    fn begin_stroke(&mut self, rect: Rect, at: Pos2, actions: &mut Vec<Action>) {
        let (Some(radius_m), Some(point)) =
            (self.brush_radius_m(rect, at), self.ground_point(rect, at))
        else {
            return;
        };
        let settings = self.tools.brush;
        let tool = match settings.effect {
            Effect::Raise => BrushTool::Raise {
                strength_m: settings.strength_m,
            },
            Effect::Lower => BrushTool::Lower {
                strength_m: settings.strength_m,
            },
            Effect::Smooth => BrushTool::Smooth { strength: 1.0 },
            Effect::Flatten => BrushTool::Flatten {
                height_m: self.document.engine().ground_m(point),
                strength: 1.0,
            },
        };
        let stroke = Stroke {
            tool,
            radius_m,
            hardness: settings.hardness,
            points: Vertices::from(vec![view::vertex(point, None)]),
            extra: Extra::new(),
        };
        actions.push(Action::BeginDrag);
        let selected = self.selected_element().filter(|e| !e.locked);
        let brush = selected.filter(|e| matches!(e.kind, ElementKind::Brush(_)));
        let id = if let Some(element) = brush {
            let mut element = Element::clone(&element);
            if let ElementKind::Brush(brush) = &mut element.kind {
                brush.strokes.push(stroke);
            }
            let id = element.id.clone();
            actions.push(self.replace(element));
            id
        } else {
            let kind = ElementKind::Brush(Brush {
                strokes: vec![stroke],
            });
            let element = self.new_element("Brush", kind);
            let id = element.id.clone();
            self.select_element(Some(id.clone()));
            actions.push(Action::Edit(Edit::AddElement {
                scenario: self.document.project().scenario.clone(),
                index: None,
                element: Arc::new(element),
            }));
            id
        };
        self.tools.stroke = Some(id);
    }

    /// Adds a point to the last stroke once the pointer is a third of the radius further.
    fn continue_stroke(&self, rect: Rect, id: &ElementId, at: Pos2, actions: &mut Vec<Action>) {
        let (Some(element), Some(point)) = (self.element(id), self.ground_point(rect, at)) else {
            return;
        };
        let radius_rad = |stroke: &Stroke| {
            let planet = self.document.project().planet.body.figure();
            stroke.radius_m / planet.radius_m
        };
        let mut element = Element::clone(&element);
        let ElementKind::Brush(brush) = &mut element.kind else {
            return;
        };
        let Some(stroke) = brush.strokes.last_mut() else {
            return;
        };
        let last: Option<Vertex> = stroke.points.as_slice().last().copied();
        let far = last.is_none_or(|v| view::place(&v).angle_to(point) > radius_rad(stroke) / 3.0);
        if far {
            let mut points = stroke.points.as_slice().to_vec();
            points.push(view::vertex(point, last.as_ref()));
            stroke.points = Vertices::from(points);
            actions.push(self.replace(element));
        }
    }
}
