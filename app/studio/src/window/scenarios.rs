//! The tree of scenarios: which is shown, and what can be done with them.

use eframe::egui::{
    self, Align, ComboBox, Layout, RichText, Role, ScrollArea, TextEdit, Ui, WidgetInfo,
};
use relievo_engine::project::{Edit, Project, Scenario, ScenarioId};

use super::action::Action;
use super::compare::{Mode, name_of};
use crate::commands::{Command, entry_of};

/// Space before each generation, points.
const INDENT: f32 = 16.0;

/// What the pane remembers from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Scenarios {
    /// The name that is being typed.
    typed: Option<(ScenarioId, String)>,
}

impl Scenarios {
    /// Draws the tree.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        compared: Option<&(Option<ScenarioId>, Mode)>,
        actions: &mut Vec<Action>,
    ) {
        let shown = project.scenario.as_ref();
        ui.horizontal_wrapped(|ui| {
            let under = shown
                .and_then(|id| project.scenario(id))
                .map_or_else(|| "the base".to_owned(), |s| s.name.clone());
            let hint = format!("Add a scenario that begins as {under}");
            if ui.button("Add").on_hover_text(hint).clicked() {
                let scenario = Scenario::new(
                    fresh_id(project),
                    fresh_name(project, "Scenario"),
                    shown.cloned(),
                );
                actions.push(Action::Edit(batch("Add a scenario", scenario)));
            }
            let current = shown.and_then(|id| project.scenario(id));
            let button = |ui: &mut Ui, text: &str, hint: &str, possible: bool| {
                let button = ui.add_enabled(possible, egui::Button::new(text));
                button.on_hover_text(hint).clicked()
            };
            let has = current.is_some();
            if button(ui, "Duplicate", "Make a copy of the shown scenario", has)
                && let Some(current) = current
            {
                let new_id = fresh_id(project);
                let duplicate = Edit::DuplicateScenario {
                    id: current.id.clone(),
                    new_id: new_id.clone(),
                    name: fresh_name(project, &current.name),
                };
                let show = Edit::ShowScenario { id: Some(new_id) };
                actions.push(Action::Edit(Edit::Batch {
                    label: format!("Duplicate {}", current.name),
                    edits: vec![duplicate, show],
                }));
            }
            let hint = "Make the shown scenario's changes in what it is based on, and remove it";
            if button(ui, "Merge", hint, has)
                && let Some(current) = current
            {
                actions.push(Action::Edit(Edit::MergeScenario {
                    id: current.id.clone(),
                }));
            }
            let childless = current.is_some_and(|c| project.children(Some(&c.id)).next().is_none());
            let hint = "Remove the shown scenario; only one that no other is based on";
            if button(ui, "Remove", hint, childless)
                && let Some(current) = current
            {
                actions.push(Action::Edit(Edit::RemoveScenario {
                    id: current.id.clone(),
                }));
            }
        });
        if !project.scenarios.is_empty() {
            compare(ui, project, compared, actions);
        }
        ui.add_space(4.0);
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                let count = project.elements.len();
                let note = if count == 1 {
                    "1 element".to_owned()
                } else {
                    format!("{count} elements")
                };
                if line(ui, "Base", &note, shown.is_none(), 0) {
                    actions.push(Action::Edit(Edit::ShowScenario { id: None }));
                }
                self.children(ui, project, None, 1, actions);
            });
    }

    fn children(
        &mut self,
        ui: &mut Ui,
        project: &Project,
        parent: Option<&ScenarioId>,
        depth: usize,
        actions: &mut Vec<Action>,
    ) {
        // Parents form a tree; a file is checked when it is read.
        for scenario in project.children(parent) {
            let is_shown = project.scenario.as_ref() == Some(&scenario.id);
            let note = match scenario.changes.len() {
                1 => "1 change".to_owned(),
                count => format!("{count} changes"),
            };
            if is_shown {
                self.name(ui, scenario, &note, depth, actions);
            } else if line(ui, &scenario.name, &note, false, depth) {
                actions.push(Action::Edit(Edit::ShowScenario {
                    id: Some(scenario.id.clone()),
                }));
            }
            self.children(ui, project, Some(&scenario.id), depth + 1, actions);
        }
    }

    /// The shown scenario, whose name can be typed.
    fn name(
        &mut self,
        ui: &mut Ui,
        scenario: &Scenario,
        note: &str,
        depth: usize,
        actions: &mut Vec<Action>,
    ) {
        if self.typed.as_ref().is_none_or(|(id, _)| *id != scenario.id) {
            self.typed = Some((scenario.id.clone(), scenario.name.clone()));
        }
        let Some((_, text)) = &mut self.typed else {
            return;
        };
        ui.horizontal(|ui| {
            ui.add_space(depth as f32 * INDENT);
            ui.label(RichText::new("•").color(ui.visuals().selection.bg_fill));
            let width = (ui.available_width() - 90.0).max(80.0);
            let field = ui.add(
                TextEdit::singleline(text)
                    .desired_width(width)
                    .char_limit(250),
            );
            field.widget_info(|| {
                WidgetInfo::labeled(Role::TextInput, true, "Name of the shown scenario")
            });
            let field = field.on_hover_text("The scenario that is shown; type another name");
            ui.weak(note);
            if field.lost_focus()
                && *text != scenario.name
                && !ui.input(|i| i.key_pressed(egui::Key::Escape))
            {
                actions.push(Action::Edit(Edit::RenameScenario {
                    id: scenario.id.clone(),
                    name: text.trim().to_owned(),
                }));
            } else if !field.has_focus() && *text != scenario.name {
                text.clone_from(&scenario.name);
            }
        });
    }
}

/// With what the shown scenario is compared, and how.
fn compare(
    ui: &mut Ui,
    project: &Project,
    compared: Option<&(Option<ScenarioId>, Mode)>,
    actions: &mut Vec<Action>,
) {
    let shown = project.scenario.as_ref();
    let all = core::iter::once(None).chain(project.scenarios.iter().map(|s| Some(&s.id)));
    let others: Vec<Option<&ScenarioId>> = all.filter(|id| *id != shown).collect();
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Compare with");
        let now = compared.map(|(other, _)| other.as_ref());
        let mut other = now.unwrap_or(others.first().copied().flatten());
        let combo = ComboBox::from_id_salt("compare with")
            .selected_text(name_of(project, other))
            .show_ui(ui, |ui| {
                for id in &others {
                    ui.selectable_value(&mut other, *id, name_of(project, *id));
                }
            });
        combo.response.labelled_by(label.id);
        for (mode, title) in Mode::ALL {
            let is_on = compared.is_some_and(|(_, m)| *m == mode);
            let hint = entry_of(Command::Compare(mode)).help;
            let clicked = ui
                .selectable_label(is_on, title)
                .on_hover_text(hint)
                .clicked();
            let changed = is_on && now != Some(other);
            if clicked || changed {
                actions.push(Action::Compare(other.cloned(), mode));
            }
        }
        let stop = entry_of(Command::StopComparing);
        if compared.is_some() && ui.button("Stop").on_hover_text(stop.help).clicked() {
            actions.push(Action::Run(Command::StopComparing));
        }
    });
}

/// A line of the tree; whether it was clicked.
fn line(ui: &mut Ui, name: &str, note: &str, shown: bool, depth: usize) -> bool {
    ui.horizontal(|ui| {
        ui.add_space(depth as f32 * INDENT);
        let button = ui.selectable_label(shown, name);
        button.widget_info(|| {
            WidgetInfo::selected(Role::Button, true, shown, format!("Show scenario {name}"))
        });
        let clicked = button.on_hover_text("Show this scenario").clicked();
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.weak(note));
        clicked && !shown
    })
    .inner
}

/// Adds a scenario and shows it, as one step.
fn batch(label: &str, scenario: Scenario) -> Edit {
    let show = Edit::ShowScenario {
        id: Some(scenario.id.clone()),
    };
    let add = Edit::AddScenario {
        index: None,
        scenario: Box::new(scenario),
    };
    Edit::Batch {
        label: label.to_owned(),
        edits: vec![add, show],
    }
}

fn fresh_id(project: &Project) -> ScenarioId {
    let ids = (1_u32..).map(|n| ScenarioId(format!("scenario-{n}")));
    let mut free = ids.filter(|id| project.scenario(id).is_none());
    free.next().unwrap_or_else(|| "scenario".into())
}

/// `stem` with the next number that no scenario has.
fn fresh_name(project: &Project, stem: &str) -> String {
    let stem = stem
        .trim_end_matches(|c: char| c.is_ascii_digit())
        .trim_end();
    let mut names = (1_u32..).map(|n| format!("{stem} {n}"));
    let is_free = |name: &String| project.scenarios.iter().all(|s| s.name != *name);
    names.find(is_free).unwrap_or_else(|| stem.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_names_and_ids_are_not_in_use() {
        let mut project = Project::default();
        assert_eq!(fresh_name(&project, "Scenario"), "Scenario 1");
        project
            .scenarios
            .push(Scenario::new(fresh_id(&project), "Scenario 1", None));
        assert_eq!(fresh_name(&project, "Scenario 1"), "Scenario 2");
        assert_eq!(fresh_id(&project).0, "scenario-2");
    }
}
