//! Settings of the whole scene: light, planet, quality.

mod quality;

use eframe::egui::{CollapsingHeader, RichText, ScrollArea, Ui};
use relievo_engine::project::{Body, Edit, PlanetSettings, Project, Sun};

use super::action::Action;
use super::controls::{self, Number};
use super::governor::Governor;

const EXAGGERATION: Number = Number::new(
    "Heights ×",
    "Factor on heights in the picture; measurements stay as they are",
    0.0..=10.0,
    1.0,
);
const AZIMUTH: Number = Number::new(
    "Azimuth",
    "Where the sun stands, clockwise from north",
    0.0..=360.0,
    315.0,
)
.unit("°", 1);
const ELEVATION: Number = Number::new(
    "Elevation",
    "Height of the sun above the horizontal",
    -90.0..=90.0,
    45.0,
)
.unit("°", 1);
const AMBIENT: Number = Number::new(
    "Sky light",
    "Share of light that comes evenly from the sky",
    0.0..=1.0,
    0.3,
);
/// Which planets the window offers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    Earth,
    Mars,
    Moon,
    Other,
}

/// Draws them.
pub(crate) fn show(ui: &mut Ui, project: &Project, governor: &Governor, actions: &mut Vec<Action>) {
    ScrollArea::vertical()
        .auto_shrink([false, false])
        .show(ui, |ui| {
            section(ui, "Light", |ui| light(ui, &project.sun, actions));
            section(ui, "Planet", |ui| planet(ui, &project.planet, actions));
            section(ui, "Quality", |ui| {
                quality::show(ui, &project.quality, governor, actions);
            });
        });
}

fn light(ui: &mut Ui, sun: &Sun, actions: &mut Vec<Action>) {
    let mut row = |ui: &mut Ui, number: &Number, value: f64, set: &dyn Fn(&mut Sun, f64)| {
        controls::number(ui, number, value, actions, |new| {
            let mut sun = sun.clone();
            set(&mut sun, new);
            Edit::SetSun { sun }
        });
    };
    row(ui, &AZIMUTH, sun.azimuth_deg.rem_euclid(360.0), &|s, v| {
        s.azimuth_deg = v;
    });
    row(ui, &ELEVATION, sun.elevation_deg, &|s, v| {
        s.elevation_deg = v;
    });
    row(ui, &AMBIENT, sun.ambient, &|s, v| s.ambient = v);
}

fn planet(ui: &mut Ui, planet: &PlanetSettings, actions: &mut Vec<Action>) {
    let exaggeration = |vertical_exaggeration| Edit::SetExaggeration {
        vertical_exaggeration,
    };
    controls::number(
        ui,
        &EXAGGERATION,
        planet.vertical_exaggeration,
        actions,
        exaggeration,
    );
    let known = match planet.body {
        Body::Earth => Known::Earth,
        Body::Mars => Known::Mars,
        Body::Moon => Known::Moon,
        Body::Custom(_) => Known::Other,
    };
    let mut options = vec![
        (Known::Earth, "Earth"),
        (Known::Mars, "Mars"),
        (Known::Moon, "Moon"),
    ];
    if known == Known::Other {
        options.push((Known::Other, "Custom"));
    }
    controls::choice(
        ui,
        "Planet",
        "Whose figure places and measures are on",
        &options,
        known,
        actions,
        |chosen| {
            let body = match chosen {
                Known::Earth => Body::Earth,
                Known::Mars => Body::Mars,
                Known::Moon => Body::Moon,
                Known::Other => planet.body,
            };
            Edit::SetPlanet {
                planet: PlanetSettings {
                    body,
                    ..planet.clone()
                },
            }
        },
    );
    let radius_km = planet.body.figure().radius_m / 1000.0;
    ui.label(
        RichText::new(format!("mean radius {radius_km:.1} km"))
            .small()
            .weak(),
    );
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong())
        .default_open(true)
        .show_unindented(ui, content);
    ui.add_space(4.0);
}
