//! What is seen from a place on the terrain.

use std::io;

use eframe::egui::{Button, Color32, ScrollArea, Ui};
use relievo_engine::Mark;
use relievo_engine::analysis::{Task, ViewshedSettings};
use relievo_engine::planet::MapPoint;
use relievo_engine::vector::style::Colour;

use super::fields::{Field, rows};
use super::legend::Line;
use super::measured::Measured;
use crate::commands::Command;
use crate::window::action::Action;
use crate::window::inbox::Waker;
use crate::window::status::{self, Notation, area, length};
use crate::window::studio::Studio;
use crate::window::tools::Tool;

const SEEN: Colour = [1.0, 0.82, 0.25, 0.45];
const HIDDEN: Colour = [0.08, 0.09, 0.18, 0.55];

/// Samples to each side where the data is too fine for so large a circle.
const COARSE: f64 = 700.0;

const EYE: Field = Field {
    name: "Eye",
    hint: "Height of the observer's eye above the ground",
    range: -100.0..=100_000.0,
    unit: " m",
    decimals: 2,
};
const TARGET: Field = Field {
    name: "Target",
    hint: "Height above the ground of what should be seen",
    range: -100.0..=100_000.0,
    unit: " m",
    decimals: 2,
};
const RADIUS: Field = Field {
    name: "Radius",
    hint: "How far to look",
    range: 1.0..=500_000.0,
    unit: " m",
    decimals: 0,
};
const REFRACTION: Field = Field {
    name: "Refraction",
    hint: "Share of the planet's curvature that the air's refraction takes away; for light over land about 0.13",
    range: -1.0..=1.0,
    unit: "",
    decimals: 3,
};
const SPACING: Field = Field {
    name: "Spacing",
    hint: "Metres between samples; 0 takes the spacing of the data where that is possible",
    range: 0.0..=10_000.0,
    unit: " m",
    decimals: 2,
};

/// A question.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wanted {
    observer: MapPoint,
    settings: ViewshedSettings,
}

/// Its answer, short.
struct Seen {
    visible_m2: f64,
    area_m2: f64,
    ground_m: f64,
    spacing_m: f64,
    mark: Mark,
}

/// The pane.
pub(super) struct SightPane {
    observer: Option<MapPoint>,
    settings: ViewshedSettings,
    is_shown: bool,
    measured: Measured<Wanted, Seen>,
}

impl SightPane {
    pub(super) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            observer: None,
            settings: ViewshedSettings::within(2000.0),
            is_shown: true,
            measured: Measured::new("relievo-viewshed", waker)?,
        })
    }

    pub(super) fn place(&mut self, observer: MapPoint) {
        (self.observer, self.is_shown) = (Some(observer), true);
        self.measured.request();
    }

    pub(super) fn clear(&mut self) {
        self.observer = None;
        self.measured.clear();
    }

    pub(super) fn observer(&self) -> Option<(MapPoint, f64)> {
        self.observer.map(|place| (place, self.settings.radius_m))
    }

    fn seen(&self) -> Option<(std::sync::Arc<Seen>, bool)> {
        self.observer?;
        let found = self.measured.found()?;
        Some((found.answer.ok()?, found.is_current))
    }

    /// What lies on the terrain.
    pub(super) fn mark(&self) -> Option<Mark> {
        let (seen, _) = self.seen()?;
        self.is_shown.then(|| seen.mark.clone())
    }

    /// What its colours mean.
    pub(super) fn legend(&self) -> Vec<Line> {
        let Some((seen, is_current)) = self.seen().filter(|_| self.is_shown) else {
            return Vec::new();
        };
        let share = 100.0 * seen.visible_m2 / seen.area_m2.max(1e-9);
        let hidden_m2 = seen.area_m2 - seen.visible_m2;
        vec![
            Line::new(
                colour32(SEEN),
                format!("Seen: {} ({share:.0} %)", area(seen.visible_m2)),
                is_current,
            ),
            Line::new(
                colour32(HIDDEN),
                format!("Hidden: {}", area(hidden_m2)),
                is_current,
            ),
        ]
    }

    fn show(&mut self, ui: &mut Ui, notation: Notation, actions: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            let place = Button::new(if self.observer.is_some() {
                "Place elsewhere"
            } else {
                "Place the observer"
            });
            let hint = "Then click where somebody stands on the terrain (O)";
            if ui.add(place).on_hover_text(hint).clicked() {
                actions.push(Action::Run(Command::Use(Tool::Observer)));
            }
            if self.observer.is_some() {
                ui.checkbox(&mut self.is_shown, "Show")
                    .on_hover_text("Show on the terrain what is seen");
                let clear = ui.button("Clear");
                if clear.on_hover_text("Take the observer away").clicked() {
                    self.clear();
                }
            }
        });
        ui.add_space(4.0);
        EYE.show(ui, &mut self.settings.observer_height_m);
        TARGET.show(ui, &mut self.settings.target_height_m);
        RADIUS.show(ui, &mut self.settings.radius_m);
        REFRACTION.show(ui, &mut self.settings.refraction);
        let mut spacing_m = self.settings.spacing_m.unwrap_or(0.0);
        SPACING.show(ui, &mut spacing_m);
        self.settings.spacing_m = Some(spacing_m).filter(|m| *m > 0.0);
        ui.add_space(4.0);
        let Some(observer) = self.observer else {
            ui.weak("Place an observer on the terrain to see what is in sight.");
            return;
        };
        self.measured.status(ui, "Viewshed");
        let (lon_deg, lat_deg) = observer.to_degrees();
        let mut lines = vec![("Observer", status::coordinates(lon_deg, lat_deg, notation))];
        if let Some((seen, _)) = self.seen() {
            let share = 100.0 * seen.visible_m2 / seen.area_m2.max(1e-9);
            lines.push(("Ground there", format!("{:.2} m", seen.ground_m)));
            lines.push(("Seen", format!("{} ({share:.1} %)", area(seen.visible_m2))));
            lines.push(("Looked at", area(seen.area_m2)));
            lines.push(("Spacing", length(seen.spacing_m)));
        }
        rows(ui, "viewshed", &lines);
    }
}

/// A mark's colour for the window.
pub(super) fn colour32([r, g, b, a]: Colour) -> Color32 {
    let byte = |v: f32| (v * 255.0).round() as u8;
    Color32::from_rgba_unmultiplied(byte(r), byte(g), byte(b), byte(a))
}

impl Studio {
    pub(in crate::window) fn viewshed_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let notation = self.notation();
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| self.analyses.sight.show(ui, notation, actions));
    }

    pub(super) fn follow_sight(&mut self, ui: &Ui) {
        let (state, rests) = (self.state(), self.rests(ui));
        let threads = self.measuring_threads();
        let sight = &mut self.analyses.sight;
        let Some(observer) = sight.observer else {
            return;
        };
        let wanted = Wanted {
            observer,
            settings: ViewshedSettings {
                threads,
                ..sight.settings
            },
        };
        let engine = self.document.engine();
        sight.measured.follow(wanted, state, rests, || {
            let questions = engine.questions();
            move |task: &Task| {
                let settings = wanted.settings;
                let found = questions
                    .viewshed(observer, &settings, task)
                    .or_else(|error| {
                        if settings.spacing_m.is_some() || task.cancel.is_cancelled() {
                            return Err(error);
                        }
                        // Finer data than can be looked at so far: as fine as is quick.
                        let settings = ViewshedSettings {
                            spacing_m: Some(settings.radius_m / COARSE),
                            ..settings
                        };
                        questions.viewshed(observer, &settings, task)
                    });
                let found = found.map_err(|e| e.to_string())?;
                Ok(Seen {
                    visible_m2: found.visible_m2,
                    area_m2: found.area_m2,
                    ground_m: found.ground_m,
                    spacing_m: found.spacing_m,
                    mark: Mark::of_viewshed(&found, SEEN, HIDDEN),
                })
            }
        });
    }
}
