//! What lies over the picture besides tools: the compass, and what to do with an empty project.

use eframe::egui::{
    self, Align2, Color32, CornerRadius, FontId, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};

use crate::window::studio::Studio;
use crate::window::theme;

impl Studio {
    /// A needle that points north; a click turns north up.
    pub(super) fn compass(&mut self, ui: &mut Ui, rect: Rect) {
        let centre = pos2(rect.right() - 32.0, rect.top() + 32.0);
        let area = Rect::from_center_size(centre, vec2(40.0, 40.0));
        if !rect.contains_rect(area) {
            return;
        }
        let response = ui.interact(area, ui.scope_id().with("compass"), Sense::click());
        let heading_deg = self
            .navigation
            .camera()
            .heading_rad
            .to_degrees()
            .rem_euclid(360.0);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Turn north up"));
        let painter = ui.painter();
        let rim = if response.hovered() || response.has_focus() {
            Color32::WHITE
        } else {
            Color32::from_white_alpha(90)
        };
        painter.circle(centre, 18.0, theme::OVERLAY, Stroke::new(1.0, rim));
        let (sin, cos) = (-self.navigation.camera().heading_rad as f32).sin_cos();
        let turned = |x: f32, y: f32| centre + vec2(x * cos - y * sin, x * sin + y * cos);
        let (north, south) = (Color32::from_rgb(235, 92, 76), Color32::from_gray(210));
        let half = |tip: f32, fill| {
            let points = vec![turned(0.0, tip), turned(4.5, 0.0), turned(-4.5, 0.0)];
            egui::Shape::convex_polygon(points, fill, Stroke::NONE)
        };
        painter.add(half(-14.0, north));
        painter.add(half(14.0, south));
        let hint = format!("Heading {heading_deg:.0}°. Click for north up (N)");
        if response.on_hover_text(hint).clicked() {
            self.north_up();
        }
    }

    /// Texts over the picture: what to do with an empty project, why there is none.
    pub(super) fn notes(&self, ui: &Ui, rect: Rect) {
        let text = if let Some(reason) = &self.stage_error {
            format!(
                "Nothing can be drawn here:\n{reason}\n\nEverything else works; `relievo render` may, too."
            )
        } else if self.document.project().layers.is_empty() {
            "Add files (Ctrl+Shift+O), or drop them here".to_owned()
        } else {
            return;
        };
        let painter = ui.painter_at(rect);
        let font = FontId::proportional(16.0);
        let galley = painter.layout(
            text,
            font,
            Color32::from_gray(235),
            (rect.width() - 80.0).max(100.0),
        );
        let area =
            Align2::CENTER_CENTER.align_size_within_rect(galley.size() + vec2(32.0, 20.0), rect);
        painter.rect_filled(area, CornerRadius::same(8), theme::OVERLAY);
        painter.galley(area.min + vec2(16.0, 10.0), galley, Color32::WHITE);
    }
}
