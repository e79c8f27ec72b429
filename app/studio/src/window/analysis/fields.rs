//! Numbers of a question: a name, a field with its unit, a tooltip with its range.

use core::ops::RangeInclusive;

use eframe::egui::{DragValue, Slider, SliderClamping, Ui};

use crate::window::controls;

/// What is known of a number.
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) hint: &'static str,
    pub(super) range: RangeInclusive<f64>,
    pub(super) unit: &'static str,
    pub(super) decimals: usize,
}

impl Field {
    fn tooltip(&self) -> String {
        let (low, high, unit) = (self.range.start(), self.range.end(), self.unit);
        format!("{}\n{low} to {high}{unit}", self.hint)
    }

    /// A row with a field that is typed into or dragged.
    pub(super) fn show(&self, ui: &mut Ui, value: &mut f64) {
        ui.horizontal(|ui| {
            let name = controls::name(ui, self.name, false).on_hover_text(self.tooltip());
            let speed = (value.abs() * 0.01).max(0.1_f64.powi(self.decimals as i32));
            let field = DragValue::new(value)
                .range(self.range.clone())
                .speed(speed)
                .max_decimals(self.decimals)
                .suffix(self.unit)
                .update_while_editing(false);
            ui.add(field)
                .labelled_by(name.id)
                .on_hover_text(self.tooltip());
        });
    }

    /// A row with a slider over a part of the range and a field for all of it.
    pub(super) fn slide(&self, ui: &mut Ui, value: &mut f64, part: RangeInclusive<f64>) {
        ui.horizontal(|ui| {
            let name = controls::name(ui, self.name, false).on_hover_text(self.tooltip());
            ui.spacing_mut().slider_width = (ui.available_width() - 90.0).max(40.0);
            let slider = Slider::new(value, part)
                .clamping(SliderClamping::Never)
                .max_decimals(self.decimals)
                .suffix(self.unit)
                .update_while_editing(false);
            ui.add(slider)
                .labelled_by(name.id)
                .on_hover_text(self.tooltip());
        });
        *value = value.clamp(*self.range.start(), *self.range.end());
    }
}

/// Results with their names.
pub(super) fn rows(ui: &mut Ui, name: &str, rows: &[(&str, String)]) {
    eframe::egui::Grid::new(name)
        .num_columns(2)
        .spacing([12.0, 3.0])
        .show(ui, |ui| {
            for (name, text) in rows {
                ui.weak(*name);
                ui.label(text);
                ui.end_row();
            }
        });
}
