//! Sliders of a colour adjustment.

use eframe::egui::{CollapsingHeader, Ui};
use relievo_engine::project::{Adjust, AdjustSpace, Edit, LayerId, NEUTRAL_TEMPERATURE_K};

use crate::window::action::Action;
use crate::window::controls::{self, Number};

const BRIGHTNESS: Number = Number::new("Brightness", "Added to all channels", -1.0..=1.0, 0.0);
const CONTRAST: Number = Number::new(
    "Contrast",
    "Factor on the distance from mid grey",
    0.0..=4.0,
    1.0,
);
const HUE: Number = Number::new("Hue", "Turn of the hue", -180.0..=180.0, 0.0).unit("°", 1);
const SATURATION: Number = Number::new(
    "Saturation",
    "Factor on saturation; 0 is grey",
    0.0..=4.0,
    1.0,
);
const GAMMA: Number = Number::new(
    "Gamma",
    "Above 1 lightens the middle, below 1 darkens it",
    0.1..=10.0,
    1.0,
)
.logarithmic();

const TEMPERATURE: Number = Number::new(
    "Temperature",
    "Colour temperature of the light in the picture; higher warms it",
    1667.0..=25_000.0,
    NEUTRAL_TEMPERATURE_K,
)
.unit(" K", 0)
.logarithmic();
const TINT: Number = Number::new(
    "Tint",
    "Green of the light in the picture; higher turns it magenta",
    -100.0..=100.0,
    0.0,
)
.unit("", 0);
const STRENGTH: Number = Number::new(
    "Strength",
    "How much of all adjustments is shown",
    0.0..=1.0,
    1.0,
);

const SPACES: [(AdjustSpace, &str); 3] = [
    (AdjustSpace::Display, "Display values"),
    (AdjustSpace::Linear, "Linear light"),
    (AdjustSpace::Perceptual, "Perceptual"),
];
const SPACE_HINT: &str = "What gain to saturation work on: display values as in image editors, linear light \
                          as in a camera, or lightness, chroma and hue as the eye has them";

const GAINS: [Number; 3] = [
    Number::new("Gain red", "Factor on red", 0.0..=16.0, 1.0).logarithmic(),
    Number::new("Gain green", "Factor on green", 0.0..=16.0, 1.0).logarithmic(),
    Number::new("Gain blue", "Factor on blue", 0.0..=16.0, 1.0).logarithmic(),
];
const OFFSETS: [Number; 3] = [
    Number::new(
        "Offset red",
        "Added to red after the gain",
        -16.0..=16.0,
        0.0,
    )
    .logarithmic(),
    Number::new(
        "Offset green",
        "Added to green after the gain",
        -16.0..=16.0,
        0.0,
    )
    .logarithmic(),
    Number::new(
        "Offset blue",
        "Added to blue after the gain",
        -16.0..=16.0,
        0.0,
    )
    .logarithmic(),
];

/// Draws them.
pub(crate) fn show(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    let mut row = |ui: &mut Ui, number: &Number, value: f64, set: &dyn Fn(&mut Adjust, f64)| {
        controls::number(ui, number, value, actions, |new| {
            let mut adjust = adjust.clone();
            set(&mut adjust, new);
            Edit::SetAdjust {
                id: id.clone(),
                adjust,
            }
        });
    };
    row(ui, &BRIGHTNESS, adjust.brightness, &|a, v| a.brightness = v);
    row(ui, &CONTRAST, adjust.contrast, &|a, v| a.contrast = v);
    row(ui, &HUE, adjust.hue_deg, &|a, v| a.hue_deg = v);
    row(ui, &SATURATION, adjust.saturation, &|a, v| a.saturation = v);
    row(ui, &GAMMA, adjust.gamma, &|a, v| a.gamma = v);
    row(ui, &TEMPERATURE, adjust.temperature_k, &|a, v| {
        a.temperature_k = v;
    });
    row(ui, &TINT, adjust.tint, &|a, v| a.tint = v);
    row(ui, &STRENGTH, adjust.strength, &|a, v| a.strength = v);
    CollapsingHeader::new("Channels")
        .default_open(false)
        .show_unindented(ui, |ui| {
            for (i, number) in GAINS.iter().enumerate() {
                row(ui, number, adjust.gain[i], &|a, v| a.gain[i] = v);
            }
            for (i, number) in OFFSETS.iter().enumerate() {
                row(ui, number, adjust.offset[i], &|a, v| a.offset[i] = v);
            }
        });
    let set = |change: &dyn Fn(&mut Adjust)| {
        let mut adjust = adjust.clone();
        change(&mut adjust);
        Edit::SetAdjust {
            id: id.clone(),
            adjust,
        }
    };
    controls::choice(
        ui,
        "Works on",
        SPACE_HINT,
        &SPACES,
        adjust.space,
        actions,
        |space| set(&|a| a.space = space),
    );
    let mut invert = adjust.invert;
    let tick = ui.checkbox(&mut invert, "Invert");
    if tick
        .on_hover_text("Turn display values over: white becomes black")
        .changed()
    {
        actions.push(Action::Edit(set(&|a| a.invert = invert)));
    }
    let unadjusted = Adjust {
        extra: adjust.extra.clone(),
        ..Adjust::default()
    };
    let reset = ui.add_enabled(
        *adjust != unadjusted,
        eframe::egui::Button::new("Reset adjustments"),
    );
    if reset
        .on_hover_text("Show the layer as its file has it")
        .clicked()
    {
        actions.push(Action::Edit(set(&|a| *a = unadjusted.clone())));
    }
}
