//! What the colours of results mean, at the lower edge of the picture, and where they were asked for.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Role, Sense, Shape, Stroke, Ui,
    WidgetInfo, vec2,
};
use glam::DVec2;
use relievo_engine::analysis::LocalFrame;
use relievo_engine::planet::{MapPoint, Planet};

use crate::window::studio::Studio;
use crate::window::theme;
use crate::window::tools::view::Projector;

/// Height of a line, points.
const LINE: f32 = 18.0;

/// Corners of the circle around an observer.
const CORNERS: u32 = 72;

/// A colour and what it means.
#[derive(Clone, Debug)]
pub(super) struct Line {
    colour: Color32,
    text: String,
}

impl Line {
    pub(super) fn new(colour: Color32, text: String, is_current: bool) -> Self {
        let text = if is_current {
            text
        } else {
            format!("{text} (out of date)")
        };
        Self { colour, text }
    }
}

impl Studio {
    /// Draws the legend and the places over the picture.
    pub(in crate::window) fn analysis_overlay(&self, ui: &mut Ui, rect: Rect) {
        let analyses = &self.analyses;
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        let painter = ui.painter_at(rect);
        if let Some((observer, radius_m)) = analyses.sight.observer() {
            let planet = self.document.project().planet.body.figure();
            circle(&painter, &projector, planet, observer, radius_m);
            if let Some(at) = projector.screen(observer) {
                sign(&painter, at, Color32::from_rgb(255, 209, 64));
            }
        }
        if let Some(at) = analyses.water.seed().and_then(|p| projector.screen(p)) {
            sign(&painter, at, Color32::from_rgb(70, 150, 235));
        }
        let mut lines = analyses.sight.legend();
        lines.extend(analyses.water.legend());
        lines.extend(analyses.contours.legend());
        legend(ui, rect, &lines);
    }
}

fn legend(ui: &mut Ui, rect: Rect, lines: &[Line]) {
    if lines.is_empty() {
        return;
    }
    let painter = ui.painter_at(rect);
    let font = FontId::proportional(12.5);
    let galleys: Vec<_> = lines
        .iter()
        .map(|line| painter.layout_no_wrap(line.text.clone(), font.clone(), Color32::WHITE))
        .collect();
    let widest = galleys.iter().map(|g| g.size().x).fold(0.0, f32::max);
    let size = vec2(widest + 42.0, LINE * lines.len() as f32 + 10.0);
    // Above the labels of compared scenarios.
    let inside = Rect::from_min_max(rect.min, rect.max - vec2(0.0, 36.0)).shrink(10.0);
    let area = Align2::LEFT_BOTTOM.align_size_within_rect(size, inside);
    if !rect.contains_rect(area) {
        return;
    }
    painter.rect_filled(area, CornerRadius::same(6), theme::OVERLAY);
    for (i, (line, galley)) in lines.iter().zip(galleys).enumerate() {
        let left = area.min + vec2(8.0, 5.0 + LINE * i as f32);
        let swatch = Rect::from_min_size(left + vec2(0.0, 3.0), vec2(20.0, LINE - 6.0));
        // On the grey of bare ground, so that what is half transparent looks as it does there.
        painter.rect_filled(swatch, CornerRadius::same(2), Color32::from_gray(190));
        painter.rect_filled(swatch, CornerRadius::same(2), line.colour);
        let middle = 0.5 * (LINE - galley.size().y);
        painter.galley(left + vec2(28.0, middle), galley, Color32::WHITE);
    }
    let spoken: Vec<&str> = lines.iter().map(|line| line.text.as_str()).collect();
    let spoken = format!("Legend. {}", spoken.join(". "));
    let response = ui.interact(area, ui.scope_id().with("results"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
}

/// A pin whose point is the place.
fn sign(painter: &Painter, at: Pos2, colour: Color32) {
    let rim = Stroke::new(1.5, Color32::from_gray(20));
    let head = at - vec2(0.0, 16.0);
    let foot = vec![at, head + vec2(-5.5, 3.0), head + vec2(5.5, 3.0)];
    painter.add(Shape::convex_polygon(foot, colour, rim));
    painter.circle(head, 7.0, colour, rim);
    painter.circle_filled(head, 2.5, Color32::from_gray(20));
}

/// A circle on the ground.
fn circle(
    painter: &Painter,
    projector: &Projector<'_>,
    planet: Planet,
    centre: MapPoint,
    radius_m: f64,
) {
    let frame = LocalFrame::new(planet, centre);
    let at = |corner: u32| {
        let turn = core::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS);
        projector.screen(frame.place(DVec2::from_angle(turn) * radius_m))
    };
    let stroke = Stroke::new(1.5, Color32::from_rgba_unmultiplied(255, 209, 64, 200));
    for corner in 0..CORNERS {
        if let (Some(from), Some(to)) = (at(corner), at(corner + 1)) {
            painter.line_segment([from, to], stroke);
        }
    }
}
