//! Still water that stands at a level and reaches a place on the terrain.

use std::io;
use std::sync::Arc;

use eframe::egui::{Button, ScrollArea, Ui};
use relievo_engine::Mark;
use relievo_engine::analysis::{FloodSettings, Task};
use relievo_engine::planet::MapPoint;
use relievo_engine::vector::style::Colour;

use super::fields::{Field, rows};
use super::legend::Line;
use super::measured::Measured;
use super::sight::colour32;
use crate::commands::Command;
use crate::report::grouped;
use crate::window::action::Action;
use crate::window::inbox::Waker;
use crate::window::status::{self, Notation, area, length};
use crate::window::studio::Studio;
use crate::window::tools::Tool;

const WATER: Colour = [0.16, 0.47, 0.82, 0.55];
const SHORE: Colour = [0.85, 0.94, 1.0, 0.9];

/// How high water stands at first above the ground where it is placed, metres.
const AT_FIRST_M: f64 = 5.0;

/// How far the slider reaches above that ground, metres.
const SLIDER_M: f64 = 100.0;

const LEVEL: Field = Field {
    name: "Level",
    hint: "Height of the water above the datum; the slider reaches 100 m over the ground at the place, any other height can be typed",
    range: -20_000.0..=20_000.0,
    unit: " m",
    decimals: 2,
};

#[derive(Clone, Copy, Debug, PartialEq)]
struct Wanted {
    seed: MapPoint,
    level_m: f64,
}

struct Water {
    level_m: f64,
    area_m2: f64,
    volume_m3: f64,
    deepest_m: f64,
    shore_m: f64,
    spacing_m: f64,
    mark: Mark,
}

/// The pane.
pub(super) struct WaterPane {
    /// Where, and the height of the ground there.
    seed: Option<(MapPoint, f64)>,
    level_m: f64,
    is_shown: bool,
    measured: Measured<Wanted, Water>,
}

impl WaterPane {
    pub(super) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            seed: None,
            level_m: 0.0,
            is_shown: true,
            measured: Measured::new("relievo-flood", waker)?,
        })
    }

    pub(super) fn place(&mut self, seed: MapPoint, ground_m: f64) {
        // A place under the water that is there means that water; a dry one, or the first, new water.
        if self.seed.is_none() || ground_m >= self.level_m {
            self.level_m = ((ground_m + AT_FIRST_M) * 10.0).round() / 10.0;
        }
        (self.seed, self.is_shown) = (Some((seed, ground_m)), true);
        self.measured.request();
    }

    pub(super) fn clear(&mut self) {
        self.seed = None;
        self.measured.clear();
    }

    pub(super) fn seed(&self) -> Option<MapPoint> {
        self.seed.map(|(place, _)| place)
    }

    fn water(&self) -> Option<(Arc<Water>, bool)> {
        self.seed?;
        let found = self.measured.found()?;
        Some((found.answer.ok()?, found.is_current))
    }

    /// What lies on the terrain.
    pub(super) fn mark(&self) -> Option<Mark> {
        let (water, _) = self.water()?;
        self.is_shown.then(|| water.mark.clone())
    }

    /// What its colour means.
    pub(super) fn legend(&self) -> Vec<Line> {
        let Some((water, is_current)) = self.water().filter(|_| self.is_shown) else {
            return Vec::new();
        };
        let text = format!(
            "Water at {:.2} m: {}, {} m³, {:.2} m deep",
            water.level_m,
            area(water.area_m2),
            grouped(water.volume_m3, 0),
            water.deepest_m
        );
        vec![Line::new(colour32(WATER), text, is_current)]
    }

    fn show(&mut self, ui: &mut Ui, notation: Notation, actions: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            let place = Button::new(if self.seed.is_some() {
                "Flood elsewhere"
            } else {
                "Choose a place"
            });
            let hint = "Then click on the terrain where water shall stand (U)";
            if ui.add(place).on_hover_text(hint).clicked() {
                actions.push(Action::Run(Command::Use(Tool::Water)));
            }
            if self.seed.is_some() {
                ui.checkbox(&mut self.is_shown, "Show")
                    .on_hover_text("Show the water on the terrain");
                if ui
                    .button("Clear")
                    .on_hover_text("Take the water away")
                    .clicked()
                {
                    self.clear();
                }
            }
        });
        ui.add_space(4.0);
        let Some((seed, ground_m)) = self.seed else {
            ui.weak("Choose a place on the terrain: all ground below the level that is joined to it is flooded.");
            return;
        };
        LEVEL.slide(ui, &mut self.level_m, ground_m..=ground_m + SLIDER_M);
        ui.add_space(4.0);
        self.measured.status(ui, "Flood");
        let (lon_deg, lat_deg) = seed.to_degrees();
        let mut lines = vec![("From", status::coordinates(lon_deg, lat_deg, notation))];
        if let Some((water, _)) = self.water() {
            lines.push(("Level", format!("{:.2} m", water.level_m)));
            lines.push(("Area", area(water.area_m2)));
            lines.push(("Volume", format!("{} m³", grouped(water.volume_m3, 1))));
            lines.push(("Deepest", format!("{:.2} m", water.deepest_m)));
            lines.push(("Shore", length(water.shore_m)));
            lines.push(("Spacing", length(water.spacing_m)));
        }
        rows(ui, "flood", &lines);
    }
}

impl Studio {
    pub(in crate::window) fn flood_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let notation = self.notation();
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| self.analyses.water.show(ui, notation, actions));
    }

    pub(super) fn follow_water(&mut self, ui: &Ui) {
        let (state, rests) = (self.state(), self.rests(ui));
        let water = &mut self.analyses.water;
        let Some((seed, _)) = water.seed else { return };
        let level_m = water.level_m;
        let engine = self.document.engine();
        let planet = engine.project().planet.body.figure();
        let wanted = Wanted { seed, level_m };
        water.measured.follow(wanted, state, rests, || {
            let questions = engine.questions();
            move |task: &Task| {
                let found = questions.flood(seed, &FloodSettings::to(level_m), task);
                let found = found.map_err(|e| e.to_string())?;
                Ok(Water {
                    level_m: found.level_m,
                    area_m2: found.area_m2,
                    volume_m3: found.volume_m3,
                    deepest_m: found.deepest_m,
                    shore_m: found.shore_m,
                    spacing_m: found.spacing_m,
                    mark: Mark::of_flood(&found.shore, planet, WATER, SHORE)?,
                })
            }
        });
    }
}
