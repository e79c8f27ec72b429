//! Sliders of layers that give heights.

use eframe::egui::Ui;
use relievo_engine::project::{Detail, DetailMethod, Edit, HeightLayer, LayerId, Noise, NoiseMode};

use crate::window::action::Action;
use crate::window::controls::{self, Number};

const SCALE: Number = Number::new(
    "Scale",
    "Metres per unit of the file; 0.3048 for feet",
    -10.0..=10.0,
    1.0,
)
.unit("", 4);
const OFFSET: Number = Number::new(
    "Offset",
    "Metres added to all heights",
    -10_000.0..=10_000.0,
    0.0,
)
.unit(" m", 1);

const SEED: Number = Number::new("Seed", "Chooses the pattern", 0.0..=9999.0, 0.0).whole();
const AMPLITUDE: Number = Number::new(
    "Amplitude",
    "Largest height of the widest waves",
    0.0..=100_000.0,
    1000.0,
)
.unit(" m", 1)
.logarithmic();
const WAVELENGTH: Number = Number::new(
    "Wavelength",
    "Length of the widest waves",
    1.0..=10_000_000.0,
    1_000_000.0,
)
.unit(" m", 0)
.logarithmic();
const OCTAVES: Number =
    Number::new("Octaves", "How many finer waves are added", 1.0..=32.0, 8.0).whole();
const LACUNARITY: Number = Number::new(
    "Lacunarity",
    "Factor on the frequency from octave to octave",
    1.0..=8.0,
    2.0,
);
const GAIN: Number = Number::new(
    "Persistence",
    "Factor on the height from octave to octave",
    0.0..=1.0,
    0.5,
);

const MODES: [(NoiseMode, &str); 2] = [
    (NoiseMode::Add, "Add to heights below"),
    (NoiseMode::Replace, "Replace heights below"),
];

const STRENGTH: Number = Number::new(
    "Strength",
    "Factor on the heights that are added; 1 goes on as the data do",
    0.0..=4.0,
    1.0,
);
const STEEPER: Number = Number::new(
    "Rougher slopes",
    "How much steeper ground is rougher: from all of a region alike to in proportion",
    0.0..=1.0,
    0.5,
);
const SHORTEST: Number = Number::new(
    "Shortest",
    "Length of the shortest waves that are added",
    0.1..=1000.0,
    1.0,
)
.unit(" m", 1)
.logarithmic();

const LOWEST: Number = Number::new(
    "Lowest",
    "Lowest ground that gets detail",
    -12_000.0..=25_000.0,
    0.0,
)
.unit(" m", 0);
const HIGHEST: Number = Number::new(
    "Highest",
    "Highest ground that gets detail",
    -12_000.0..=25_000.0,
    9000.0,
)
.unit(" m", 0);
const FADE: Number = Number::new(
    "Fade",
    "Metres of height within these bounds over which detail fades in",
    0.0..=10_000.0,
    50.0,
)
.unit(" m", 0)
.logarithmic();

/// Bounds are at least so many metres apart.
const APART_M: f64 = 1.0;

const METHODS: [(DetailMethod, &str); 2] = [
    (DetailMethod::Simplex, "Simplex noise"),
    (DetailMethod::Spectral, "Spectral waves"),
];

/// How a file's values become metres.
pub(crate) fn scale(ui: &mut Ui, id: &LayerId, layer: &HeightLayer, actions: &mut Vec<Action>) {
    let edit = |vertical_scale, offset_m| Edit::SetHeightScale {
        id: id.clone(),
        vertical_scale,
        offset_m,
    };
    controls::number(ui, &SCALE, layer.vertical_scale, actions, |v| {
        edit(v, layer.offset_m)
    });
    controls::number(ui, &OFFSET, layer.offset_m, actions, |v| {
        edit(layer.vertical_scale, v)
    });
}

/// The parameters of noise.
pub(crate) fn noise(ui: &mut Ui, id: &LayerId, noise: &Noise, actions: &mut Vec<Action>) {
    let edit = |noise| Edit::SetNoise {
        id: id.clone(),
        noise,
    };
    let hint = "How the noise meets the heights of the layers below";
    controls::choice(ui, "Mode", hint, &MODES, noise.mode, actions, |mode| {
        edit(Noise {
            mode,
            ..noise.clone()
        })
    });
    let mut row = |ui: &mut Ui, number: &Number, value: f64, set: &dyn Fn(&mut Noise, f64)| {
        controls::number(ui, number, value, actions, |new| {
            let mut noise = noise.clone();
            set(&mut noise, new);
            edit(noise)
        });
    };
    row(ui, &AMPLITUDE, noise.amplitude_m, &|n, v| n.amplitude_m = v);
    row(ui, &WAVELENGTH, noise.wavelength_m, &|n, v| {
        n.wavelength_m = v;
    });
    row(ui, &OCTAVES, f64::from(noise.octaves), &|n, v| {
        n.octaves = v as u32;
    });
    row(ui, &GAIN, noise.gain, &|n, v| n.gain = v);
    row(ui, &LACUNARITY, noise.lacunarity, &|n, v| n.lacunarity = v);
    row(ui, &OFFSET, noise.offset_m, &|n, v| n.offset_m = v);
    row(ui, &SEED, f64::from(noise.seed), &|n, v| n.seed = v as u32);
    let mut ridged = noise.ridged;
    if ui
        .checkbox(&mut ridged, "Ridged")
        .on_hover_text("Folds waves to sharp ridges")
        .changed()
    {
        actions.push(Action::Edit(edit(Noise {
            ridged,
            ..noise.clone()
        })));
    }
}

/// How heights below are continued beyond their own resolution.
pub(crate) fn detail(ui: &mut Ui, id: &LayerId, detail: &Detail, actions: &mut Vec<Action>) {
    let edit = |detail| Edit::SetDetail {
        id: id.clone(),
        detail,
    };
    let hint = "Spectral waves are nearer to the law of the data and several times dearer";
    controls::choice(
        ui,
        "Method",
        hint,
        &METHODS,
        detail.method,
        actions,
        |method| {
            edit(Detail {
                method,
                ..detail.clone()
            })
        },
    );
    let mut row = |ui: &mut Ui, number: &Number, value: f64, set: &dyn Fn(&mut Detail, f64)| {
        controls::number(ui, number, value, actions, |new| {
            let mut detail = detail.clone();
            set(&mut detail, new);
            edit(detail)
        });
    };
    row(ui, &STRENGTH, detail.strength, &|d, v| d.strength = v);
    row(ui, &STEEPER, detail.slope, &|d, v| d.slope = v);
    row(ui, &SHORTEST, detail.shortest_m, &|d, v| d.shortest_m = v);
    row(ui, &SEED, f64::from(detail.seed), &|d, v| d.seed = v as u32);
    within_heights(ui, id, detail, actions);
    ui.weak("Synthesised: measurements leave it out.");
}

/// The range of heights that detail is kept to.
fn within_heights(ui: &mut Ui, id: &LayerId, detail: &Detail, actions: &mut Vec<Action>) {
    let set = |change: &dyn Fn(&mut Detail)| {
        let mut detail = detail.clone();
        change(&mut detail);
        Edit::SetDetail {
            id: id.clone(),
            detail,
        }
    };
    let mut on = detail.lowest_m.is_some() || detail.highest_m.is_some();
    let hint = "Add detail only where the ground lies in a range of heights";
    if ui
        .checkbox(&mut on, "By height")
        .on_hover_text(hint)
        .changed()
    {
        let bounds = if on {
            (Some(0.0), Some(9000.0))
        } else {
            (None, None)
        };
        actions.push(Action::Edit(set(&|d| {
            (d.lowest_m, d.highest_m) = bounds;
        })));
    }
    if !on {
        return;
    }
    // Either bound gives way to the other.
    let lowest_m = detail.lowest_m.unwrap_or(-12_000.0);
    let highest_m = detail.highest_m.unwrap_or(25_000.0);
    controls::number(ui, &LOWEST, lowest_m, actions, |v| {
        set(&|d| {
            d.lowest_m = Some(v);
            d.highest_m = d.highest_m.map(|high| high.max(v + APART_M));
        })
    });
    controls::number(ui, &HIGHEST, highest_m, actions, |v| {
        set(&|d| {
            d.highest_m = Some(v);
            d.lowest_m = d.lowest_m.map(|low| low.min(v - APART_M));
        })
    });
    controls::number(ui, &FADE, detail.fade_m, actions, |v| {
        set(&|d| d.fade_m = v)
    });
}
