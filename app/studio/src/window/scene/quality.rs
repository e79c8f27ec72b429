//! How fine the picture is drawn: what decides, its value, and what that costs here.

use eframe::egui::Ui;
use relievo_engine::project::{Aim, Auto, Edit, Quality};

use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::governor::Governor;
use crate::window::trade;

const ERROR: Number = Number::new(
    "Error",
    "How far what is shown may be off on the screen; the cheapest setting that was measured to stay below \
     is drawn, the finest where none does",
    0.05..=20.0,
    0.5,
)
.unit(" px", 2)
.logarithmic();
const FRAME_TIME: Number = Number::new(
    "Frame time",
    "What the graphics device may spend on a frame; the finest setting that this adapter draws in it is \
     drawn, the coarsest where it draws none",
    1.0..=200.0,
    16.0,
)
.unit(" ms", 1)
.logarithmic();
const TEXEL: Number = Number::new(
    "Texel size",
    "Screen pixels that the finest sample covers; larger is faster",
    0.25..=16.0,
    1.0,
)
.unit(" px", 2)
.logarithmic();
const DENSITY: Number =
    Number::new("Mesh", "Factor on the number of triangles", 0.1..=10.0, 1.0).logarithmic();

const AIMS: [(Aim, &str); 3] = [
    (Aim::Adapter, "Graphics adapter"),
    (Aim::Error, "Pixels of error"),
    (Aim::FrameTime, "Milliseconds a frame"),
];

const WINDOWS: [(Auto<u32>, &str); 6] = [
    (Auto::Auto, "Automatic"),
    (Auto::Value(256), "256"),
    (Auto::Value(512), "512"),
    (Auto::Value(1024), "1024"),
    (Auto::Value(2048), "2048"),
    (Auto::Value(4096), "4096"),
];

/// Draws the controls and the plot.
pub(super) fn show(ui: &mut Ui, quality: &Quality, governor: &Governor, actions: &mut Vec<Action>) {
    let changed = |change: &dyn Fn(&mut Quality)| {
        let mut quality = quality.clone();
        change(&mut quality);
        Edit::SetQuality { quality }
    };
    let hint = "What decides how fine the picture is: the graphics adapter and your own changes, an error on \
        the screen, or the time of a frame";
    controls::choice(ui, "Decided by", hint, &AIMS, quality.aim, actions, |aim| {
        changed(&|q| q.aim = aim)
    });
    match quality.aim {
        Aim::Adapter => {
            controls::number(ui, &TEXEL, quality.texel_px, actions, |texel_px| {
                changed(&|q| q.texel_px = texel_px)
            });
            let density = quality.mesh_density.unwrap_or(1.0);
            controls::number(ui, &DENSITY, density, actions, |v| {
                let density = if v == 1.0 { Auto::Auto } else { Auto::Value(v) };
                changed(&|q| q.mesh_density = density)
            });
        }
        Aim::Error => {
            controls::number(ui, &ERROR, quality.error_px, actions, |error_px| {
                changed(&|q| q.error_px = error_px)
            });
        }
        Aim::FrameTime => {
            controls::number(ui, &FRAME_TIME, quality.frame_budget_ms, actions, |ms| {
                changed(&|q| q.frame_budget_ms = ms)
            });
        }
    }
    let hint = "Samples along a side of a colour level; more are finer and take more memory";
    let windows = quality.colour_window_samples;
    controls::choice(ui, "Windows", hint, &WINDOWS, windows, actions, |samples| {
        changed(&|q| q.colour_window_samples = samples)
    });
    ui.add_space(4.0);
    trade::show(ui, governor);
}
