//! How an element meets the ground around it, and how it looks.

use eframe::egui::Ui;
use relievo_engine::project::{Edit, ElementStyle, SideSlopes};

use super::{Shown, replace};
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::inspector::vector::colour;

const CUT: Number = Number::new(
    "Cut slope",
    "Rise over run where ground is taken away",
    0.01..=100.0,
    0.5,
)
.logarithmic();

const FILL: Number = Number::new(
    "Fill slope",
    "Rise over run where ground is filled up",
    0.01..=100.0,
    0.5,
)
.logarithmic();

const REACH: Number = Number::new(
    "Reach",
    "Farthest that a side slope goes; it ends in a wall there",
    0.0..=10_000.0,
    200.0,
)
.unit(" m", 0)
.logarithmic();

const OPACITY: Number = Number::new("Opacity", "How much the fill covers", 0.0..=1.0, 1.0);

const STROKE_WIDTH: Number = Number::new(
    "Line width",
    "Width of the line on the ground",
    0.0..=1000.0,
    1.0,
)
.unit(" m", 2)
.logarithmic();

/// Slopes or walls beside it.
pub(super) fn side(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let side = &shown.element.side;
    let set = |change: &dyn Fn(&mut SideSlopes)| replace(shown, |e| change(&mut e.side));
    let mut wall = side.wall;
    let hint = "Vertical at the boundary, without slopes beside it";
    if ui
        .checkbox(&mut wall, "Walls")
        .on_hover_text(hint)
        .changed()
    {
        actions.push(Action::Edit(set(&|s| s.wall = wall)));
    }
    ui.add_enabled_ui(!side.wall, |ui| {
        controls::number(ui, &CUT, side.cut_slope, actions, |v| {
            set(&|s| s.cut_slope = v)
        });
        controls::number(ui, &FILL, side.fill_slope, actions, |v| {
            set(&|s| s.fill_slope = v)
        });
        controls::number(ui, &REACH, side.max_reach_m, actions, |v| {
            set(&|s| s.max_reach_m = v)
        });
    });
}

/// Its colours.
pub(super) fn style(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let style = &shown.element.style;
    let set = |change: &dyn Fn(&mut ElementStyle)| {
        let mut style = style.clone();
        change(&mut style);
        Edit::SetElementStyle {
            scenario: shown.scenario.clone(),
            id: shown.element.id.clone(),
            style,
        }
    };
    if let Some(fill) = colour(ui, "Fill", style.fill) {
        actions.push(Action::Edit(set(&|s| s.fill = fill)));
    }
    if style.fill.is_some() {
        controls::number(ui, &OPACITY, style.fill_opacity, actions, |v| {
            set(&|s| s.fill_opacity = v)
        });
    }
    if let Some(stroke) = colour(ui, "Line", style.stroke) {
        actions.push(Action::Edit(set(&|s| s.stroke = stroke)));
    }
    if style.stroke.is_some() {
        controls::number(ui, &STROKE_WIDTH, style.stroke_width_m, actions, |v| {
            set(&|s| s.stroke_width_m = v)
        });
    }
}
