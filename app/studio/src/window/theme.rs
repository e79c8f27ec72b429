//! How the window looks: quiet, so that the terrain is what one sees.

use eframe::egui::{
    Color32, Context, CornerRadius, FontId, Margin, Pos2, Rect, Response, Stroke, StrokeKind,
    TextStyle, Theme, Ui, Visuals, vec2,
};

/// The colour of what is selected and active.
const ACCENT_DARK: Color32 = Color32::from_rgb(46, 120, 150);
/// The same on light ground.
const ACCENT_LIGHT: Color32 = Color32::from_rgb(28, 110, 145);

/// Sets spacing and colours of both themes; which one is used follows the system.
pub(crate) fn apply(ctx: &Context) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            style.spacing.item_spacing = vec2(6.0, 5.0);
            style.spacing.button_padding = vec2(8.0, 3.0);
            style.spacing.window_margin = Margin::same(14);
            style.spacing.menu_margin = Margin::same(6);
            style
                .text_styles
                .insert(TextStyle::Small, FontId::proportional(10.5));
            style.visuals = visuals(theme);
        });
    }
}

fn visuals(theme: Theme) -> Visuals {
    let mut v = match theme {
        Theme::Dark => Visuals::dark(),
        Theme::Light => Visuals::light(),
    };
    let (panel, window, accent) = match theme {
        Theme::Dark => (Color32::from_gray(28), Color32::from_gray(36), ACCENT_DARK),
        Theme::Light => (
            Color32::from_gray(246),
            Color32::from_gray(252),
            ACCENT_LIGHT,
        ),
    };
    v.panel_fill = panel;
    v.window_fill = window;
    v.selection.bg_fill = accent;
    v.selection.stroke = Stroke::new(
        1.0,
        if theme == Theme::Dark {
            Color32::from_gray(235)
        } else {
            Color32::WHITE
        },
    );
    v.slider_trailing_fill = true;
    v.window_corner_radius = CornerRadius::same(8);
    for widget in [
        &mut v.widgets.inactive,
        &mut v.widgets.hovered,
        &mut v.widgets.active,
        &mut v.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
    }
    v
}

/// Ground of the titles of panes that lie behind others.
pub(crate) fn behind_tabs(visuals: &Visuals) -> Color32 {
    Color32::from_gray(if visuals.dark_mode { 14 } else { 226 })
}

/// Ground of a selected row.
pub(crate) fn selection_fill(visuals: &Visuals) -> Color32 {
    visuals
        .selection
        .bg_fill
        .gamma_multiply(if visuals.dark_mode { 0.45 } else { 0.22 })
}

/// The ground of a row of a list: selected, under the pointer, with the keyboard's focus.
pub(crate) fn row(ui: &Ui, rect: Rect, response: &Response, selected: bool) {
    let visuals = ui.visuals();
    let fill = if selected {
        selection_fill(visuals)
    } else if response.hovered() {
        visuals.widgets.hovered.weak_bg_fill.gamma_multiply(0.5)
    } else {
        Color32::TRANSPARENT
    };
    let corner = CornerRadius::same(4);
    ui.painter().rect_filled(rect, corner, fill);
    if response.has_focus() {
        let stroke = visuals.selection.stroke;
        ui.painter()
            .rect_stroke(rect, corner, stroke, StrokeKind::Inside);
    }
    if selected {
        let bar = Rect::from_min_max(rect.min, Pos2::new(rect.left() + 3.0, rect.bottom()));
        ui.painter()
            .rect_filled(bar, CornerRadius::same(2), visuals.selection.bg_fill);
    }
}

/// Ground of texts that lie over the picture.
pub(crate) const OVERLAY: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 170);
