//! What tools show over the picture: outlines, handles, the rubber band.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Shape, Stroke, Ui, vec2,
};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{Element, ElementKind, Vertex};

use super::view::{self, Projector};
use super::{Tool, handles};
use crate::window::studio::Studio;
use crate::window::theme;

pub(super) const BAND: Color32 = Color32::from_rgb(255, 214, 102);
pub(super) const SELECTED: Color32 = Color32::from_rgb(255, 255, 255);
const OTHER: Color32 = Color32::from_rgba_premultiplied(70, 70, 70, 90);

/// Vertices of elements that are not selected whose outlines are drawn, at most.
const MOST_OTHERS: usize = 1500;

impl Studio {
    /// Draws everything over the picture.
    pub(in crate::window) fn paint_tools(&mut self, ui: &Ui, rect: Rect) {
        self.tools.pointer = ui
            .input(|i| i.pointer.latest_pos())
            .filter(|p| rect.contains(*p));
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        if self.is_blank() {
            return;
        }
        let painter = ui.painter_at(rect);
        let selected = self.selected_element();
        let mut left = MOST_OTHERS;
        for element in self.elements() {
            let is_selected = selected.as_ref().is_some_and(|s| s.id == element.id);
            let count: usize = element
                .vertex_lists()
                .iter()
                .map(|l| l.as_slice().len())
                .sum();
            if is_selected || !element.visible || count > left {
                continue;
            }
            left -= count;
            outline(&painter, &projector, &element, Stroke::new(1.0, OTHER));
        }
        if let Some(element) = selected.filter(|e| e.visible) {
            outline(&painter, &projector, &element, Stroke::new(1.5, SELECTED));
            if !element.locked && self.tools.tool == Tool::Select {
                self.paint_handles(&painter, &projector, &element);
            }
        }
        if let Some(at) = self.marked.and_then(|place| projector.screen(place)) {
            painter.circle(at, 5.0, BAND, Stroke::new(1.5, Color32::from_gray(20)));
        }
        match self.tools.tool {
            Tool::Select | Tool::Observer | Tool::Water => {
                if self.selected_element.is_none() {
                    self.paint_lens(&painter, &projector, Stroke::new(1.0, OTHER));
                }
            }
            Tool::Lens => {
                self.paint_lens(&painter, &projector, Stroke::new(2.0, BAND));
                self.paint_lens_handles(&painter, &projector);
            }
            Tool::LensOutline => {
                self.paint_lens(&painter, &projector, Stroke::new(1.0, OTHER));
                self.paint_draft(&painter, &projector);
            }
            Tool::Polygon | Tool::Hole | Tool::Breakline | Tool::Corridor | Tool::Measure => {
                self.paint_draft(&painter, &projector);
            }
            Tool::Brush => {
                if let Some(at) = self.tools.pointer {
                    let stroke = Stroke::new(1.5, BAND);
                    painter.circle_stroke(at, self.tools.brush.radius, stroke);
                    let inner = self.tools.brush.radius * self.tools.brush.hardness as f32;
                    painter.circle_stroke(at, inner, Stroke::new(1.0, BAND.gamma_multiply(0.5)));
                }
            }
        }
    }

    fn paint_handles(&self, painter: &Painter, projector: &Projector<'_>, element: &Element) {
        if matches!(element.kind, ElementKind::Brush(_)) {
            return;
        }
        let chosen = self
            .tools
            .vertex
            .as_ref()
            .filter(|(id, _)| *id == element.id);
        for (spot, vertex, middle) in handles::handles(projector, element) {
            let rim = Stroke::new(1.5, Color32::from_gray(20));
            if let Some(at) = middle.and_then(|m| projector.visible(view::place(&m))) {
                painter.circle(
                    at,
                    3.0,
                    SELECTED.gamma_multiply(0.6),
                    Stroke::new(1.0, rim.color),
                );
            }
            if let Some(at) = projector.visible(view::place(&vertex)) {
                let is_chosen = chosen.is_some_and(|(_, s)| *s == spot);
                let fill = if is_chosen { BAND } else { SELECTED };
                let area = Rect::from_center_size(at, vec2(9.0, 9.0));
                painter.rect(
                    area,
                    CornerRadius::same(2),
                    fill,
                    rim,
                    eframe::egui::StrokeKind::Inside,
                );
            }
        }
    }

    fn paint_draft(&self, painter: &Painter, projector: &Projector<'_>) {
        let draft = &self.tools.draft;
        let stroke = Stroke::new(2.0, BAND);
        for pair in draft.windows(2) {
            line(painter, projector, &pair[0], &pair[1], stroke);
        }
        let faint = Stroke::new(1.5, BAND.gamma_multiply(0.6));
        if let (Some(last), Some(next)) = (draft.last(), &self.tools.next) {
            line(painter, projector, last, next, faint);
            if self.tools.tool.is_ring() && draft.len() > 1 {
                line(painter, projector, next, &draft[0], faint);
            }
        }
        for vertex in draft.iter().chain(&self.tools.next) {
            if let Some(at) = projector.screen(view::place(vertex)) {
                painter.circle(at, 4.0, BAND, Stroke::new(1.0, Color32::from_gray(20)));
            }
        }
        if let (Tool::Measure, Some(at)) = (self.tools.tool, self.tools.pointer)
            && let Some(text) = self.measured()
        {
            label(painter, at + vec2(14.0, 14.0), &text);
        }
    }
}

/// A text on a dark ground.
pub(super) fn label(painter: &Painter, at: Pos2, text: &str) {
    let galley =
        painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let area = Align2::LEFT_TOP.anchor_size(at, galley.size() + vec2(12.0, 6.0));
    painter.rect_filled(area, CornerRadius::same(4), theme::OVERLAY);
    painter.galley(area.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}

fn outline(painter: &Painter, projector: &Projector<'_>, element: &Element, stroke: Stroke) {
    for (index, list) in element.vertex_lists().into_iter().enumerate() {
        let vertices = list.as_slice();
        for pair in vertices.windows(2).take(handles::MOST) {
            line(painter, projector, &pair[0], &pair[1], stroke);
        }
        if let (true, [first, .., last]) = (handles::is_ring(element, index), vertices) {
            line(painter, projector, last, first, stroke);
        }
    }
}

fn line(painter: &Painter, projector: &Projector<'_>, from: &Vertex, to: &Vertex, stroke: Stroke) {
    let (from, to): (MapPoint, MapPoint) = (view::place(from), view::place(to));
    for run in projector.draped(from, to) {
        painter.add(Shape::line(run, stroke));
    }
}
