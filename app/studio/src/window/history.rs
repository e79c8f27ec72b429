//! What can be undone and redone: a click goes there.

use eframe::egui::{
    Align, Label, Layout, RichText, Role, ScrollArea, Sense, Ui, UiBuilder, WidgetInfo, vec2,
};
use relievo_engine::Engine;

use super::action::Action;
use super::theme;

/// Height of a line in points.
const LINE: f32 = 22.0;

/// Draws the steps, the oldest first; the one that the project is at is marked.
pub(crate) fn show(ui: &mut Ui, engine: &Engine, actions: &mut Vec<Action>) {
    let history = engine.history();
    let (done, undone) = (history.undo_count(), history.redo_count());
    if done + undone == 0 {
        ui.add_space(8.0);
        ui.weak("Nothing has been changed yet.");
        return;
    }
    ui.spacing_mut().item_spacing.y = 0.0;
    let rows = ScrollArea::vertical().auto_shrink([false, false]);
    // The line above the first step is the project as it was opened.
    rows.stick_to_bottom(true)
        .show_rows(ui, LINE, 1 + done + undone, |ui, rows| {
            for row in rows {
                let steps = row as isize - done as isize;
                let label = match row.checked_sub(1) {
                    None => "As it was opened",
                    Some(at) if at < done => history.undo_label_at(at).unwrap_or_default(),
                    Some(at) => history.redo_label_at(at - done).unwrap_or_default(),
                };
                if line(ui, label, steps) {
                    actions.push(Action::Jump(steps));
                }
            }
        });
}

/// A line that is `steps` steps after the present; whether it was clicked.
fn line(ui: &mut Ui, label: &str, steps: isize) -> bool {
    let size = vec2(ui.available_width(), LINE);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| {
        WidgetInfo::selected(
            Role::ListBoxOption,
            true,
            steps == 0,
            format!("Step: {label}"),
        )
    });
    let fill = if steps == 0 {
        Some(theme::selection_fill(ui.visuals()))
    } else {
        let hovered = ui
            .visuals()
            .widgets
            .hovered
            .weak_bg_fill
            .gamma_multiply(0.5);
        response.hovered().then_some(hovered)
    };
    if let Some(fill) = fill {
        ui.painter().rect_filled(rect, 4, fill);
    }
    if response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        ui.painter()
            .rect_stroke(rect, 4, stroke, eframe::egui::StrokeKind::Inside);
    }
    let mut inside = ui.new_child(
        UiBuilder::new()
            .max_rect(rect.shrink2(vec2(8.0, 0.0)))
            .layout(Layout::left_to_right(Align::Center)),
    );
    let text = RichText::new(label);
    let text = if steps > 0 { text.weak() } else { text };
    inside.add(Label::new(text).truncate().selectable(false));
    let hint = match steps {
        0 => "The project is here".to_owned(),
        -1 => "Click to take one step back".to_owned(),
        1 => "Click to make one step again".to_owned(),
        n if n < 0 => format!("Click to take {} steps back", -n),
        n => format!("Click to make {n} steps again"),
    };
    response.on_hover_text(hint).clicked() && steps != 0
}
