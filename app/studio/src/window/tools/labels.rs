//! Texts of vector layers over the picture.

use eframe::egui::{Align2, Color32, FontId, Ui, vec2};
use relievo_engine::View;

use crate::picture::labels::{AROUND, HALO};
use crate::window::compare::Parts;
use crate::window::studio::Studio;

impl Studio {
    /// Draws the texts that the latest view shows.
    pub(in crate::window) fn paint_labels(&self, ui: &Ui, parts: &Parts, view: &View) {
        let rect = parts.own;
        let painter = ui.painter().with_clip_rect(parts.own_seen);
        let points = rect.width() / view.viewport_px[0] as f32;
        for label in self.document.engine().labels(view) {
            let size = label.size_px as f32 / ui.ctx().pixels_per_point();
            let at = rect.min + vec2(label.centre_px.x as f32, label.centre_px.y as f32) * points;
            let font = FontId::proportional(size);
            let solid = |[r, g, b]: [u8; 3]| Color32::from_rgb(r, g, b);
            let galley = painter.layout_no_wrap(label.text, font, solid(label.colour));
            let corner = Align2::CENTER_CENTER.anchor_size(at, galley.size()).min;
            if let Some(halo) = label.halo {
                for [x, y] in AROUND {
                    let by = vec2(x, y) * size * HALO;
                    painter.galley_with_override_text_color(
                        corner + by,
                        galley.clone(),
                        solid(halo),
                    );
                }
            }
            painter.galley(corner, galley, solid(label.colour));
        }
    }
}
