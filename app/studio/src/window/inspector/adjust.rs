//! Controls of a colour adjustment.

mod clear;
mod curves;

use eframe::egui::{Button, CollapsingHeader, Ui};
use relievo_engine::project::{Adjust, AdjustSpace, Edit, LayerId, NEUTRAL_TEMPERATURE_K};

use crate::commands::{Command, entry_of};
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::panes::Pane;

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

const fn share_of(name: &'static str, hint: &'static str, default: f64) -> Number {
    Number::new(name, hint, -2.0..=2.0, default)
}

const MIXES: [[Number; 3]; 3] = [
    [
        share_of("Red of red", "How much of red makes red", 1.0),
        share_of("Red of green", "How much of green makes red", 0.0),
        share_of("Red of blue", "How much of blue makes red", 0.0),
    ],
    [
        share_of("Green of red", "How much of red makes green", 0.0),
        share_of("Green of green", "How much of green makes green", 1.0),
        share_of("Green of blue", "How much of blue makes green", 0.0),
    ],
    [
        share_of("Blue of red", "How much of red makes blue", 0.0),
        share_of("Blue of green", "How much of green makes blue", 0.0),
        share_of("Blue of blue", "How much of blue makes blue", 1.0),
    ],
];

/// An edit that changes an adjustment.
fn changed(id: &LayerId, adjust: &Adjust, change: impl FnOnce(&mut Adjust)) -> Action {
    let mut adjust = adjust.clone();
    change(&mut adjust);
    Action::Edit(Edit::SetAdjust {
        id: id.clone(),
        adjust,
    })
}

/// Draws them.
pub(crate) fn show(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    strokes(ui, id, adjust, actions);
    CollapsingHeader::new("Curves")
        .default_open(false)
        .show_unindented(ui, |ui| curves::show(ui, id, adjust, actions));
    CollapsingHeader::new("Channels")
        .default_open(false)
        .show_unindented(ui, |ui| channels(ui, id, adjust, actions));
    CollapsingHeader::new("Colour to alpha")
        .default_open(false)
        .show_unindented(ui, |ui| clear::show(ui, id, adjust, actions));
    let mut invert = adjust.invert;
    let tick = ui.checkbox(&mut invert, "Invert");
    if tick
        .on_hover_text("Turn display values over: white becomes black")
        .changed()
    {
        actions.push(changed(id, adjust, |a| a.invert = invert));
    }
    ui.horizontal_wrapped(|ui| {
        for (pane, title) in [
            (Pane::Match, "Match colours…"),
            (Pane::Histogram, "Levels…"),
        ] {
            let command = Command::Toggle(pane);
            if ui
                .button(title)
                .on_hover_text(entry_of(command).help)
                .clicked()
            {
                actions.push(Action::Show(pane));
            }
        }
        let unadjusted = Adjust {
            extra: adjust.extra.clone(),
            ..Adjust::default()
        };
        let reset = ui.add_enabled(*adjust != unadjusted, Button::new("Reset adjustments"));
        if reset
            .on_hover_text("Show the layer as its file has it")
            .clicked()
        {
            actions.push(changed(id, adjust, |a| *a = unadjusted));
        }
    });
}

/// Sets one number of an adjustment.
type Setter = fn(&mut Adjust, f64);

/// What most people look for.
fn strokes(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    let rows: [(&Number, f64, Setter); 8] = [
        (&BRIGHTNESS, adjust.brightness, |a, v| a.brightness = v),
        (&CONTRAST, adjust.contrast, |a, v| a.contrast = v),
        (&HUE, adjust.hue_deg, |a, v| a.hue_deg = v),
        (&SATURATION, adjust.saturation, |a, v| a.saturation = v),
        (&GAMMA, adjust.gamma, |a, v| a.gamma = v),
        (&TEMPERATURE, adjust.temperature_k, |a, v| {
            a.temperature_k = v;
        }),
        (&TINT, adjust.tint, |a, v| a.tint = v),
        (&STRENGTH, adjust.strength, |a, v| a.strength = v),
    ];
    for (number, value, set) in rows {
        row(ui, (id, adjust), number, value, actions, set);
    }
    let space = |space| {
        let mut adjust = adjust.clone();
        adjust.space = space;
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
        space,
    );
}

fn channels(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    let whose = (id, adjust);
    for (i, number) in GAINS.iter().enumerate() {
        row(ui, whose, number, adjust.gain[i], actions, |a, v| {
            a.gain[i] = v;
        });
    }
    for (i, number) in OFFSETS.iter().enumerate() {
        row(ui, whose, number, adjust.offset[i], actions, |a, v| {
            a.offset[i] = v;
        });
    }
    for (r, numbers) in MIXES.iter().enumerate() {
        for (c, number) in numbers.iter().enumerate() {
            row(ui, whose, number, adjust.mix[r][c], actions, |a, v| {
                a.mix[r][c] = v;
            });
        }
    }
}

fn row(
    ui: &mut Ui,
    (id, adjust): (&LayerId, &Adjust),
    number: &Number,
    value: f64,
    actions: &mut Vec<Action>,
    set: impl FnOnce(&mut Adjust, f64),
) {
    controls::number(ui, number, value, actions, |new| {
        let mut adjust = adjust.clone();
        set(&mut adjust, new);
        Edit::SetAdjust {
            id: id.clone(),
            adjust,
        }
    });
}
