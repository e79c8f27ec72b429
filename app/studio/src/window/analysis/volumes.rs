//! What differs between two scenarios: cut, fill, areas, slopes, element by element and in total.

use std::cell::Cell;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{Align, ComboBox, DragValue, Grid, Layout, Response, RichText, ScrollArea, Ui};
use relievo_engine::analysis::{
    Amount, Comparison, ComparisonReport, Task, Version, VolumeSettings, Volumes,
};
use relievo_engine::project::{ElementId, Project};

use super::exports::Export;
use super::measured::Measured;
use crate::report::{Format, QUANTITIES, grouped};
use crate::window::action::Action;
use crate::window::inbox::Waker;
use crate::window::studio::Studio;

/// Coarsest spacing to begin with, metres: the data decides.
const ANY_M: f64 = 1e9;

/// Samples that a step takes at most, unless somebody says how many.
const MOST_SAMPLES: u64 = 1 << 21;

/// Compiling both versions may hold the window up for so long before they are measured on request only.
const NOTICED: Duration = Duration::from_millis(30);

/// Heads of columns, in the order of [`QUANTITIES`].
const HEADS: [&str; 8] = [
    "Cut m³",
    "Fill m³",
    "Net m³",
    "Plan m²",
    "Surface m²",
    "Highest cut m",
    "Highest fill m",
    "Mean slope °",
];

/// What columns mean.
const HINTS: [&str; 8] = [
    "Ground that is taken away",
    "Ground that is put on",
    "Fill less cut",
    "Area that changes, seen from above",
    "Area of the new surface where it changes",
    "Deepest cut",
    "Highest fill",
    "Mean slope of the new surface where it changes",
];

#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    a: Version,
    b: Version,
    samples: u64,
}

/// A comparison that has been measured.
pub(super) struct Compared {
    pub(super) comparison: Comparison,
    pub(super) report: ComparisonReport,
}

/// The pane.
pub(super) struct VolumesPane {
    /// What was chosen; `None`: what the shown scenario suggests.
    chosen: [Option<Version>; 2],
    /// Samples that a step takes at most.
    samples: u64,
    /// The question that was asked.
    asked: Option<Wanted>,
    /// Compiling it was noticed.
    is_dear: bool,
    measured: Measured<Wanted, Compared>,
}

impl VolumesPane {
    pub(super) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            chosen: [None, None],
            samples: MOST_SAMPLES,
            asked: None,
            is_dear: false,
            measured: Measured::new("relievo-volumes", waker)?,
        })
    }

    pub(super) fn clear(&mut self) {
        (self.chosen, self.asked) = ([None, None], None);
        self.measured.clear();
    }

    pub(super) fn has_result(&self) -> bool {
        self.asked.is_some()
    }

    /// What would be compared.
    fn versions(&self, project: &Project) -> Wanted {
        let is_known = |version: &&Version| match version {
            Version::Ground | Version::Base => true,
            Version::Scenario(id) => project.scenario(id).is_some(),
        };
        let shown = project
            .scenario
            .clone()
            .map_or(Version::Base, Version::Scenario);
        let before = match &shown {
            Version::Scenario(_) => Version::Base,
            Version::Ground | Version::Base => Version::Ground,
        };
        let [a, b] = &self.chosen;
        Wanted {
            a: a.as_ref().filter(is_known).unwrap_or(&before).clone(),
            b: b.as_ref().filter(is_known).unwrap_or(&shown).clone(),
            samples: self.samples,
        }
    }

    fn show(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        is_there: &dyn Fn(&ElementId) -> bool,
        actions: &mut Vec<Action>,
    ) {
        let wanted = self.versions(project);
        ui.horizontal_wrapped(|ui| {
            let [first, second] = &mut self.chosen;
            ui.label("From");
            version(ui, "Version before", project, &wanted.a, first);
            ui.label("to");
            version(ui, "Version after", project, &wanted.b, second);
            let label = ui.label("Samples");
            let field = DragValue::new(&mut self.samples)
                .range(1024..=1_u64 << 32)
                .speed(1000.0)
                .update_while_editing(false);
            ui.add(field).labelled_by(label.id).on_hover_text(
                "Samples for an element at most, 1024 to 4 294 967 296: more take longer and leave smaller errors",
            );
            let hint =
                "Cut, fill, areas and slopes of every element that differs, with their errors";
            if ui.button("Measure").on_hover_text(hint).clicked() {
                self.asked = Some(self.versions(project));
                self.measured.request();
            }
            let found = self.measured.found().and_then(|found| found.answer.ok());
            if found.is_some() {
                ui.menu_button("Save report", |ui| {
                    for (format, name) in [
                        (Format::Html, "Page with pictures (HTML)…"),
                        (Format::Csv, "Table (CSV)…"),
                        (Format::Json, "Data (JSON)…"),
                    ] {
                        if ui.button(name).clicked() {
                            actions.push(Action::Export(Export::Volumes(format)));
                            ui.close();
                        }
                    }
                })
                .response
                .on_hover_text("Write what was measured to a file");
                if ui
                    .button("Clear")
                    .on_hover_text("Forget what was measured")
                    .clicked()
                {
                    self.clear();
                }
            }
        });
        if self.asked.as_ref().is_some_and(|asked| *asked != wanted) {
            // Chosen anew: that is a question of its own.
            self.asked = Some(wanted);
        }
        if self.asked.is_none() {
            ui.weak("Choose two versions of the plan and measure what differs.");
            return;
        }
        self.measured.status(ui, "Volumes");
        let Some(Ok(found)) = self.measured.found().map(|found| found.answer) else {
            return;
        };
        let [a, b] = &found.report.names;
        ui.label(RichText::new(format!("From {a} to {b}")).strong());
        ScrollArea::both()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                table(ui, &found.report, is_there, actions);
                for note in &found.report.notes {
                    ui.weak(note);
                }
            });
    }
}

/// A choice between the versions of a project.
fn version(
    ui: &mut Ui,
    name: &str,
    project: &Project,
    value: &Version,
    chosen: &mut Option<Version>,
) {
    let title = |version: &Version| match version {
        Version::Ground => "Ground without elements".to_owned(),
        Version::Base => "Base".to_owned(),
        Version::Scenario(_) => version.name(project),
    };
    let scenarios = project.scenarios.iter();
    let all = [Version::Ground, Version::Base]
        .into_iter()
        .chain(scenarios.map(|s| Version::Scenario(s.id.clone())));
    let combo = ComboBox::from_id_salt(name).selected_text(title(value));
    let combo = combo.show_ui(ui, |ui| {
        for option in all {
            let text = title(&option);
            if ui.selectable_label(option == *value, text).clicked() {
                *chosen = Some(option);
            }
        }
    });
    combo.response.widget_info(|| {
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::ComboBox, true, name)
    });
}

fn table(
    ui: &mut Ui,
    report: &ComparisonReport,
    is_there: &dyn Fn(&ElementId) -> bool,
    actions: &mut Vec<Action>,
) {
    Grid::new("volumes")
        .num_columns(1 + HEADS.len())
        .striped(true)
        .spacing([18.0, 4.0])
        .show(ui, |ui| {
            ui.strong("Element");
            for (head, hint) in HEADS.iter().zip(HINTS) {
                right(ui, |ui| ui.strong(*head)).on_hover_text(hint);
            }
            ui.end_row();
            for element in &report.elements {
                let name = if element.name.is_empty() {
                    &element.id.0
                } else {
                    &element.name
                };
                let hint = format!(
                    "{}, {}. Click to select it",
                    element.kind,
                    element.step.name()
                );
                let title = eframe::egui::Button::new(format!("{name}, {}", element.step.name()));
                let row = ui.add_enabled(is_there(&element.id), title.frame(false));
                if row.on_hover_text(hint).clicked() {
                    actions.push(Action::SelectElement(Some(element.id.clone())));
                }
                quantities(ui, &element.volumes, false);
            }
            ui.strong("Total");
            quantities(ui, &report.total, true);
        });
}

fn quantities(ui: &mut Ui, volumes: &Volumes, strong: bool) {
    for (_, of, digits) in QUANTITIES {
        let Amount { value, error } = of(volumes);
        let value = RichText::new(grouped(value, digits));
        let value = if strong { value.strong() } else { value };
        let error = format!("±{}", grouped(error, digits));
        right(ui, |ui| {
            ui.label(RichText::new(&error).small().weak());
            ui.label(value)
        })
        .on_hover_text(format!("{error} from discretisation"));
    }
    ui.end_row();
}

/// A cell that ends at the right.
fn right(ui: &mut Ui, content: impl FnOnce(&mut Ui) -> Response) -> Response {
    ui.with_layout(Layout::right_to_left(Align::Center), content)
        .inner
}

impl Studio {
    pub(in crate::window) fn volumes_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let project = self.document.project();
        let is_there = |id: &ElementId| project.element_in(project.scenario.as_ref(), id).is_some();
        self.analyses.volumes.show(ui, project, &is_there, actions);
        self.analyses.exports.status(ui);
    }

    /// Measures what is chosen in the pane.
    pub(in crate::window) fn measure_volumes(&mut self) {
        let volumes = &mut self.analyses.volumes;
        volumes.asked = Some(volumes.versions(self.document.project()));
        volumes.measured.request();
    }

    /// What was measured last.
    pub(super) fn measured_volumes(&self) -> Option<Arc<Compared>> {
        self.analyses.volumes.measured.found()?.answer.ok()
    }

    pub(super) fn follow_volumes(&mut self, ui: &Ui) {
        let (state, rests) = (self.state(), self.rests(ui));
        let threads = self.measuring_threads();
        let volumes = &mut self.analyses.volumes;
        let Some(wanted) = volumes.asked.clone() else {
            return;
        };
        let engine = self.document.engine();
        let is_free = !volumes.is_dear || volumes.measured.is_requested();
        let compiled = Cell::new(Duration::ZERO);
        let key = wanted.clone();
        volumes.measured.follow(key, state, rests && is_free, || {
            let began = Instant::now();
            let comparison = engine.comparison(&wanted.a, &wanted.b, None);
            compiled.set(began.elapsed());
            move |task: &Task| {
                let comparison = comparison?;
                let settings = VolumeSettings {
                    max_samples: wanted.samples,
                    threads,
                    ..VolumeSettings::from_spacing(ANY_M)
                };
                let report = comparison.measure(&settings, task);
                let report = report.map_err(|e| e.to_string())?;
                Ok(Compared { comparison, report })
            }
        });
        volumes.is_dear |= compiled.get() > NOTICED;
    }
}
