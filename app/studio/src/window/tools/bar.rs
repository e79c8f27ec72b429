//! The bar of tools at the edge of the picture.

use eframe::egui::{
    self, Color32, ComboBox, DragValue, Frame, Margin, Rect, RichText, Ui, UiBuilder, Visuals, vec2,
};

use super::Tool;
use super::brush::Effect;
use crate::commands::{Command, entry_of};
use crate::window::action::Action;
use crate::window::studio::Studio;
use crate::window::theme;

impl Studio {
    /// Draws it in the upper left corner of the picture.
    pub(in crate::window) fn tool_bar(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        actions: &mut Vec<Action>,
    ) {
        let area = Rect::from_min_max(rect.min + vec2(10.0, 10.0), rect.max - vec2(64.0, 10.0));
        if area.width() < 160.0 || area.height() < 60.0 {
            return;
        }
        let mut ui = ui.new_child(UiBuilder::new().max_rect(area));
        // Over a picture that is dark whatever the theme.
        ui.style_mut().visuals = Visuals {
            selection: ui.visuals().selection,
            ..Visuals::dark()
        };
        let frame = Frame::new()
            .fill(theme::OVERLAY)
            .corner_radius(egui::CornerRadius::same(8))
            .inner_margin(Margin::symmetric(6, 4));
        ui.horizontal(|ui| {
            frame.show(ui, |ui| {
                let extra = Some(self.tools.tool).filter(|tool| !Tool::BAR.contains(tool));
                let parts = [Tool::Hole, Tool::Breakline].into_iter();
                let parts = parts
                    .filter(|tool| self.is_possible(Command::Use(*tool)) || extra == Some(*tool));
                let extra = extra.filter(|tool| !matches!(tool, Tool::Hole | Tool::Breakline));
                for tool in Tool::BAR.into_iter().chain(parts).chain(extra) {
                    let entry = entry_of(Command::Use(tool));
                    let button = ui.selectable_label(self.tools.tool == tool, tool.title());
                    let hint = format!("{}\n{}", entry.help, entry.shortcut_text(ui.ctx()));
                    if button.on_hover_text(hint.trim_end()).clicked() {
                        actions.push(Action::Run(Command::Use(tool)));
                    }
                }
            });
        });
        if self.tools.tool == Tool::Brush {
            frame.show(&mut ui, |ui| {
                ui.horizontal_wrapped(|ui| self.brush_settings(ui))
            });
        }
        if self.tools.tool != Tool::Select {
            frame.show(&mut ui, |ui| {
                ui.label(
                    RichText::new(self.tools.tool.hint())
                        .small()
                        .color(Color32::from_gray(225)),
                );
            });
        }
    }

    fn brush_settings(&mut self, ui: &mut Ui) {
        let brush = &mut self.tools.brush;
        let shown = Effect::ALL.iter().find(|(e, _)| *e == brush.effect);
        let combo = ComboBox::from_id_salt("brush effect")
            .width(80.0)
            .selected_text(shown.map_or("", |(_, name)| name));
        let combo = combo.show_ui(ui, |ui| {
            for (effect, name) in Effect::ALL {
                ui.selectable_value(&mut brush.effect, effect, name);
            }
        });
        combo.response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "What the brush does")
        });
        let label = ui.label("Radius");
        ui.add(
            DragValue::new(&mut brush.radius)
                .range(4.0..=400.0)
                .speed(1.0)
                .suffix(" px"),
        )
        .labelled_by(label.id)
        .on_hover_text("On the screen, 4 to 400 px: what is seen is what is changed");
        if matches!(brush.effect, Effect::Raise | Effect::Lower) {
            let label = ui.label("Strength");
            ui.add(
                DragValue::new(&mut brush.strength_m)
                    .range(0.0..=10_000.0)
                    .speed(0.5)
                    .suffix(" m"),
            )
            .labelled_by(label.id)
            .on_hover_text("Metres at the centre, 0 to 10 000 m");
        }
        let label = ui.label("Hardness");
        ui.add(
            DragValue::new(&mut brush.hardness)
                .range(0.0..=1.0)
                .speed(0.01)
                .max_decimals(2),
        )
        .labelled_by(label.id)
        .on_hover_text("Share of the radius with full effect, 0 to 1");
    }
}
