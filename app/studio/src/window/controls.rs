//! Controls that edit one value of the project: numbers, choices.
//!
//! A whole drag is one undo step; a double click on the name resets; every control has a name, a
//! unit and its range for who cannot see it.

use core::ops::RangeInclusive;

use eframe::egui::{
    self, Align, Color32, ComboBox, Layout, Sense, Slider, SliderClamping, TextStyle, Ui, vec2,
};
use relievo_engine::project::Edit;

use super::action::Action;

/// Width of names in points.
const NAME_WIDTH: f32 = 92.0;

/// Width of number fields in points, at least.
const NUMBER_WIDTH: f32 = 62.0;

/// What is known of a number.
#[derive(Clone, Debug)]
pub(crate) struct Number {
    name: &'static str,
    hint: &'static str,
    unit: &'static str,
    range: RangeInclusive<f64>,
    default: f64,
    logarithmic: bool,
    decimals: usize,
    whole: bool,
}

impl Number {
    /// A number with its name, meaning, range and default.
    pub(crate) const fn new(
        name: &'static str,
        hint: &'static str,
        range: RangeInclusive<f64>,
        default: f64,
    ) -> Self {
        Self {
            name,
            hint,
            unit: "",
            range,
            default,
            logarithmic: false,
            decimals: 2,
            whole: false,
        }
    }

    /// With a unit, written after the value.
    pub(crate) const fn unit(mut self, unit: &'static str, decimals: usize) -> Self {
        self.unit = unit;
        self.decimals = decimals;
        self
    }

    /// Spread by magnitude.
    pub(crate) const fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Without fractions.
    pub(crate) const fn whole(mut self) -> Self {
        self.whole = true;
        self.decimals = 0;
        self
    }

    /// Everything that a tooltip says.
    fn tooltip(&self) -> String {
        let (low, high, default, unit) = (
            self.range.start(),
            self.range.end(),
            self.default,
            self.unit,
        );
        format!(
            "{}\n{low} to {high}{unit}, usually {default}{unit}. Double-click the name to reset.",
            self.hint
        )
    }
}

/// A row with a slider and a number field. Changes become edits by `edit`.
pub(crate) fn number(
    ui: &mut Ui,
    number: &Number,
    value: f64,
    actions: &mut Vec<Action>,
    edit: impl FnOnce(f64) -> Edit,
) {
    ui.horizontal(|ui| {
        let name = name(ui, number.name, value != number.default).on_hover_text(number.tooltip());
        let field = field_width(ui, number, value);
        ui.spacing_mut().interact_size.x = field;
        ui.spacing_mut().slider_width = (ui.available_width() - field - 12.0).max(40.0);
        let mut new = value;
        let mut slider = Slider::new(&mut new, number.range.clone())
            .clamping(SliderClamping::Edits)
            .logarithmic(number.logarithmic)
            .suffix(number.unit)
            .max_decimals(number.decimals)
            .update_while_editing(false);
        if number.whole {
            slider = slider.integer();
        }
        if number.logarithmic {
            slider = slider.smallest_positive((number.range.end() * 1e-6).max(1e-3));
        }
        let response = ui
            .add(slider)
            .labelled_by(name.id)
            .on_hover_text(number.tooltip());
        if response.drag_started() {
            actions.push(Action::BeginDrag);
        }
        if name.double_clicked() {
            actions.push(Action::Edit(edit(number.default)));
        } else if response.changed() && new != value {
            actions.push(Action::Edit(edit(new)));
        }
        if response.drag_stopped() {
            actions.push(Action::EndDrag);
        }
    });
}

/// Width of the field of a number: a value that needs more than usual takes it from the slider, not from
/// the pane.
fn field_width(ui: &Ui, number: &Number, value: f64) -> f32 {
    let text = format!("{value:.*}{}", number.decimals, number.unit);
    let font = TextStyle::Button.resolve(ui.style());
    let size = ui
        .painter()
        .layout_no_wrap(text, font, Color32::WHITE)
        .size();
    NUMBER_WIDTH.max(size.x + 2.0 * ui.spacing().button_padding.x)
}

/// A row with a choice between few things.
pub(crate) fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    title: &'static str,
    hint: &str,
    options: &[(T, &'static str)],
    value: T,
    actions: &mut Vec<Action>,
    edit: impl FnOnce(T) -> Edit,
) {
    ui.horizontal(|ui| {
        let label = name(ui, title, false).on_hover_text(hint);
        let shown = options
            .iter()
            .find(|(v, _)| *v == value)
            .map_or("other", |(_, text)| text);
        let mut new = value;
        let combo = ComboBox::from_id_salt(title)
            .selected_text(shown)
            .width(ui.available_width() - 8.0);
        let shown = combo.show_ui(ui, |ui| {
            for (option, text) in options {
                ui.selectable_value(&mut new, *option, *text);
            }
        });
        shown.response.labelled_by(label.id).on_hover_text(hint);
        if new != value {
            actions.push(Action::Edit(edit(new)));
        }
    });
}

/// A name of fixed width that can be double-clicked; `emphasis` marks values that are not usual.
pub(crate) fn name(ui: &mut Ui, text: &str, emphasis: bool) -> egui::Response {
    let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
    let text = if emphasis {
        egui::RichText::new(text).strong()
    } else {
        egui::RichText::new(text)
    };
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(NAME_WIDTH);
        ui.add(
            egui::Label::new(text)
                .truncate()
                .selectable(false)
                .sense(Sense::click()),
        )
    })
    .inner
}
