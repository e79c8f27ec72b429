//! The last stroke of a brush.

use eframe::egui::Ui;
use relievo_engine::project::{BrushTool, ElementKind};

use super::{HEIGHT, Shown, replace};
use crate::window::action::Action;
use crate::window::controls::{self, Number};

const STRENGTH: Number = Number::new(
    "Strength",
    "Metres at the centre of the stroke",
    0.0..=1000.0,
    20.0,
)
.unit(" m", 2);

const SHARE: Number = Number::new("Strength", "How much of the way", 0.0..=1.0, 1.0);

const RADIUS: Number = Number::new(
    "Radius",
    "Radius of the last stroke on the ground",
    0.01..=100_000.0,
    100.0,
)
.unit(" m", 1)
.logarithmic();

const HARDNESS: Number = Number::new(
    "Hardness",
    "Share of the radius with full effect",
    0.0..=1.0,
    0.5,
);

/// The last stroke's settings.
pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let ElementKind::Brush(brush) = &shown.element.kind else {
        return;
    };
    ui.weak(format!(
        "{} strokes; the settings are those of the last one",
        brush.strokes.len()
    ));
    let Some(stroke) = brush.strokes.last() else {
        return;
    };
    let set = |change: &dyn Fn(&mut relievo_engine::project::Stroke)| {
        replace(shown, |element| {
            if let ElementKind::Brush(brush) = &mut element.kind
                && let Some(stroke) = brush.strokes.last_mut()
            {
                change(stroke);
            }
        })
    };
    controls::number(ui, &RADIUS, stroke.radius_m, actions, |v| {
        set(&|s| s.radius_m = v)
    });
    controls::number(ui, &HARDNESS, stroke.hardness, actions, |v| {
        set(&|s| s.hardness = v)
    });
    match stroke.tool {
        BrushTool::Raise { strength_m } => {
            controls::number(ui, &STRENGTH, strength_m, actions, |strength_m| {
                set(&|s| s.tool = BrushTool::Raise { strength_m })
            });
        }
        BrushTool::Lower { strength_m } => {
            controls::number(ui, &STRENGTH, strength_m, actions, |strength_m| {
                set(&|s| s.tool = BrushTool::Lower { strength_m })
            });
        }
        BrushTool::Smooth { strength } => {
            controls::number(ui, &SHARE, strength, actions, |strength| {
                set(&|s| s.tool = BrushTool::Smooth { strength })
            });
        }
        BrushTool::Flatten { height_m, strength } => {
            controls::number(ui, &HEIGHT, height_m, actions, |height_m| {
                set(&|s| s.tool = BrushTool::Flatten { height_m, strength })
            });
            controls::number(ui, &SHARE, strength, actions, |strength| {
                set(&|s| s.tool = BrushTool::Flatten { height_m, strength })
            });
        }
        BrushTool::Unknown { .. } => {}
    }
}
