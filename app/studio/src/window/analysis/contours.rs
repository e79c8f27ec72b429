//! Contours of what is seen, to look at and to write to a file.

use std::io;
use std::sync::Arc;

use eframe::egui::{Button, ScrollArea, Ui};
use relievo_engine::Mark;
use relievo_engine::analysis::{ContourLine, ContourSettings, MapBox, Task};
use relievo_engine::vector::style::Colour;

use super::exports::Export;
use super::fields::{Field, rows};
use super::legend::Line;
use super::measured::Measured;
use super::sight::colour32;
use crate::commands::Command;
use crate::window::action::Action;
use crate::window::inbox::Waker;
use crate::window::studio::Studio;

const COLOUR: Colour = [0.45, 0.24, 0.1, 0.9];
const WIDTH_PX: f64 = 1.2;

const INTERVAL: Field = Field {
    name: "Interval",
    hint: "Metres between contours",
    range: 0.01..=10_000.0,
    unit: " m",
    decimals: 2,
};
const BASE: Field = Field {
    name: "Base",
    hint: "A height that has a contour",
    range: -20_000.0..=20_000.0,
    unit: " m",
    decimals: 2,
};

#[derive(Clone, Copy, Debug, PartialEq)]
struct Wanted {
    area: MapBox,
    settings: ContourSettings,
}

pub(super) struct Contours {
    pub(super) lines: Arc<Vec<ContourLine>>,
    vertices: usize,
    mark: Mark,
}

/// The pane.
pub(super) struct ContoursPane {
    area: Option<MapBox>,
    settings: ContourSettings,
    is_shown: bool,
    measured: Measured<Wanted, Contours>,
}

impl ContoursPane {
    pub(super) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            area: None,
            settings: ContourSettings::every(10.0),
            is_shown: true,
            measured: Measured::new("relievo-contours", waker)?,
        })
    }

    pub(super) fn clear(&mut self) {
        self.area = None;
        self.measured.clear();
    }

    pub(super) fn has_area(&self) -> bool {
        self.area.is_some()
    }

    fn found(&self) -> Option<(Arc<Contours>, bool)> {
        self.area?;
        let found = self.measured.found()?;
        Some((found.answer.ok()?, found.is_current))
    }

    /// What lies on the terrain.
    pub(super) fn mark(&self) -> Option<Mark> {
        let (found, _) = self.found()?;
        self.is_shown.then(|| found.mark.clone())
    }

    /// What its colour means.
    pub(super) fn legend(&self) -> Vec<Line> {
        let Some((_, is_current)) = self.found().filter(|_| self.is_shown) else {
            return Vec::new();
        };
        let text = format!("Contours every {} m", self.settings.interval_m);
        vec![Line::new(colour32(COLOUR), text, is_current)]
    }

    fn show(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        INTERVAL.show(ui, &mut self.settings.interval_m);
        BASE.show(ui, &mut self.settings.base_m);
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            let hint = "Contours of all that the view shows, at the data's resolution";
            if ui
                .button("Contours of this view")
                .on_hover_text(hint)
                .clicked()
            {
                actions.push(Action::Run(Command::Contours));
            }
            if self.area.is_some() {
                ui.checkbox(&mut self.is_shown, "Show")
                    .on_hover_text("Show the lines on the terrain");
                if ui
                    .button("Clear")
                    .on_hover_text("Take the lines away")
                    .clicked()
                {
                    self.clear();
                }
            }
        });
        self.measured.status(ui, "Contours");
        let Some((found, _)) = self.found() else {
            if self.area.is_none() {
                ui.weak("A layer of contours draws them everywhere; here they become lines to write to a file.");
            }
            return;
        };
        rows(
            ui,
            "contours",
            &[
                ("Lines", found.lines.len().to_string()),
                ("Vertices", found.vertices.to_string()),
            ],
        );
        ui.horizontal_wrapped(|ui| {
            for (export, text) in [
                (Export::ContoursGeoJson, "Save GeoJSON…"),
                (Export::ContoursGeoPackage, "Save GeoPackage…"),
            ] {
                let button = ui.add(Button::new(text));
                let hint = "Lines in longitude and latitude with their heights in metres";
                if button.on_hover_text(hint).clicked() {
                    actions.push(Action::Export(export));
                }
            }
        });
    }
}

impl Studio {
    pub(in crate::window) fn contours_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                self.analyses.contours.show(ui, actions);
                self.analyses.exports.status(ui);
            });
    }

    /// Contours of what the view shows now.
    pub(in crate::window) fn contour_view(&mut self) {
        let questions = self.document.engine().questions();
        let area = questions.seen_area(self.camera(), self.aspect);
        let contours = &mut self.analyses.contours;
        (contours.area, contours.is_shown) = (area, true);
        contours.measured.request();
    }

    /// The lines that were found.
    pub(super) fn contour_lines(&self) -> Option<Arc<Vec<ContourLine>>> {
        let (found, _) = self.analyses.contours.found()?;
        Some(Arc::clone(&found.lines))
    }

    pub(super) fn follow_contours(&mut self, ui: &Ui) {
        let (state, rests) = (self.state(), self.rests(ui));
        let contours = &mut self.analyses.contours;
        let Some(area) = contours.area else { return };
        let settings = contours.settings;
        let engine = self.document.engine();
        let planet = engine.project().planet.body.figure();
        let wanted = Wanted { area, settings };
        contours.measured.follow(wanted, state, rests, || {
            let questions = engine.questions();
            move |task: &Task| {
                let lines = questions.contours(&area, &settings, task);
                let lines = lines.map_err(|e| e.to_string())?;
                Ok(Contours {
                    vertices: lines.iter().map(|line| line.points.len()).sum(),
                    mark: Mark::of_lines(&lines, planet, COLOUR, WIDTH_PX)?,
                    lines: Arc::new(lines),
                })
            }
        });
    }
}
