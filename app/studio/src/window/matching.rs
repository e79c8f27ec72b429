//! Layers brought to one look: a layer matched to another or to what lies below it, or several balanced at
//! once.
//!
//! What is found becomes an ordinary adjustment, by one edit that can be undone.

mod curves;

use std::io;
use std::sync::Arc;

use eframe::egui::{Button, ComboBox, Grid, ScrollArea, Ui};
use relievo_engine::analysis::Task;
use relievo_engine::analysis::colour::{Difference, MatchMethod};
use relievo_engine::project::{Edit, LayerId, Project};
use relievo_engine::{ColourBalance, ColourMatch, MatchTarget, OverlapDifference};

use super::action::Action;
use super::controls;
use super::histogram::adjust_of;
use super::inbox::Waker;
use super::latest::{Latest, Waiting};
use super::studio::Studio;
use super::waiting;

const METHODS: [(MatchMethod, &str); 3] = [
    (MatchMethod::MeanAndSpread, "Mean and spread"),
    (MatchMethod::Histogram, "Histogram"),
    (MatchMethod::Regression, "Regression"),
];
const METHOD_HINT: &str = "Mean and spread: gain and offset of each channel. Histogram: a tone curve of each \
                           channel. Regression: a mix of channels, from the colours of the same places; mostly the \
                           nearest";

/// What is being asked. A number tells presses of the button apart.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    press: u64,
    what: What,
}

#[derive(Clone, Debug, PartialEq)]
enum What {
    Match {
        layer: LayerId,
        target: MatchTarget,
        method: MatchMethod,
    },
    Balance {
        layers: Vec<LayerId>,
        held: Option<LayerId>,
    },
}

/// What was found.
#[derive(Clone)]
enum Found {
    Matched(Arc<ColourMatch>),
    Balanced(Arc<ColourBalance>),
}

/// What is chosen in the pane, and what was found last.
pub(crate) struct Matching {
    /// The layer that the selected one is to look like; `None`: what lies below it.
    target: Option<LayerId>,
    method: MatchMethod,
    /// Compare only what is seen now.
    seen_only: bool,
    /// Layers that are left out of a balance.
    left_out: Vec<LayerId>,
    held: Option<LayerId>,
    presses: u64,
    /// The press whose answer has become an edit.
    carried_out: u64,
    latest: Latest<Wanted, Result<Found, String>>,
}

impl Matching {
    /// # Errors
    /// When the system refuses a thread.
    pub(crate) fn new(waker: Waker) -> io::Result<Self> {
        Ok(Self {
            target: None,
            method: MatchMethod::Regression,
            seen_only: false,
            left_out: Vec::new(),
            held: None,
            presses: 0,
            carried_out: 0,
            latest: Latest::new("relievo-match", waker)?,
        })
    }

    /// Forgets everything: another project is shown.
    pub(crate) fn clear(&mut self) {
        self.latest.clear();
        self.target = None;
        self.held = None;
        self.left_out.clear();
    }

    fn is_busy(&self) -> bool {
        matches!(self.latest.waiting(), Waiting::Busy { .. })
    }
}

/// Layers that have an adjustment and are shown, the topmost first: names and ids.
fn adjustable(project: &Project) -> Vec<(LayerId, String)> {
    let shown = project.layers.iter().rev();
    shown
        .filter(|l| l.visible && adjust_of(&l.kind).is_some())
        .map(|l| (l.id.clone(), l.name.clone()))
        .collect()
}

impl Studio {
    /// Draws the pane.
    pub(super) fn match_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                self.match_one(ui);
                ui.separator();
                self.balance_all(ui);
                ui.separator();
                waiting::show(ui, &mut self.matching.latest, "Comparing");
                self.carry_out_match(actions);
                self.found(ui);
            });
    }

    fn match_one(&mut self, ui: &mut Ui) {
        let project = self.document.project();
        let selected = self.selected.as_ref().and_then(|id| project.layer(id));
        let layer = selected.filter(|l| adjust_of(&l.kind).is_some());
        let Some(layer) = layer.map(|l| (l.id.clone(), l.name.clone(), l.locked)) else {
            ui.weak("Select a layer of imagery to match it to another.");
            return;
        };
        let (id, name, locked) = layer;
        let others: Vec<_> = adjustable(project)
            .into_iter()
            .filter(|(other, _)| *other != id)
            .collect();
        let pane = &mut self.matching;
        if let Some(target) = &pane.target
            && !others.iter().any(|(other, _)| other == target)
        {
            pane.target = None;
        }
        ui.horizontal(|ui| {
            let label = controls::name(ui, "Layer", false);
            ui.strong(name).labelled_by(label.id);
        });
        let hint = "What the layer is to look like";
        chooser(
            ui,
            ("Should look like", hint),
            "What lies below",
            &others,
            &mut pane.target,
        );
        ui.horizontal(|ui| {
            let label = controls::name(ui, "Method", false).on_hover_text(METHOD_HINT);
            let shown = METHODS.iter().find(|(m, _)| *m == pane.method);
            let combo = ComboBox::from_id_salt("method of matching")
                .selected_text(shown.map_or("", |(_, name)| name))
                .width(ui.available_width() - 8.0);
            let combo = combo.show_ui(ui, |ui| {
                for (method, name) in METHODS {
                    ui.selectable_value(&mut pane.method, method, name);
                }
            });
            combo
                .response
                .labelled_by(label.id)
                .on_hover_text(METHOD_HINT);
        });
        ui.checkbox(&mut pane.seen_only, "Only what is seen now")
            .on_hover_text(
                "Compare only the part of the map in the view, not all that both layers cover",
            );
        let ready = !locked && self.status.opening == 0 && !pane.is_busy();
        let hint = if locked {
            "The layer is locked"
        } else {
            "Compare about 65,000 places that both cover, and adjust the layer; clouds and what was built \
             between the two are left out"
        };
        let button = ui.add_enabled(ready, Button::new("Match colours"));
        let button = button.on_hover_text(hint).on_disabled_hover_text(hint);
        if button.clicked() {
            let target = pane.target.clone();
            let what = What::Match {
                layer: id,
                target: target.map_or(MatchTarget::Below, MatchTarget::Layer),
                method: pane.method,
            };
            self.compare_colours(what);
        }
    }

    fn balance_all(&mut self, ui: &mut Ui) {
        let project = self.document.project();
        let unlocked = |id: &LayerId| project.layer(id).is_some_and(|l| !l.locked);
        let all: Vec<_> = adjustable(project)
            .into_iter()
            .filter(|(id, _)| unlocked(id))
            .collect();
        if all.len() < 2 {
            ui.weak("Show two or more unlocked layers of imagery to balance them with each other.");
            return;
        }
        let pane = &mut self.matching;
        ui.strong("Balance");
        for (id, name) in &all {
            let mut takes_part = !pane.left_out.contains(id);
            let tick = ui.checkbox(&mut takes_part, name);
            if tick
                .on_hover_text("Whether the layer is balanced with the others")
                .changed()
            {
                pane.left_out.retain(|other| other != id);
                if !takes_part {
                    pane.left_out.push(id.clone());
                }
            }
        }
        let taking_part: Vec<_> = all
            .into_iter()
            .filter(|(id, _)| !pane.left_out.contains(id))
            .collect();
        if let Some(held) = &pane.held
            && !taking_part.iter().any(|(id, _)| id == held)
        {
            pane.held = None;
        }
        let hint = "The layer that keeps its look; without one all meet in the middle";
        chooser(ui, ("Keep", hint), "None", &taking_part, &mut pane.held);
        let ready = taking_part.len() > 1 && self.status.opening == 0 && !pane.is_busy();
        let button = ui.add_enabled(ready, Button::new("Balance layers"));
        let hint = "Gain and offset of each channel of each layer, so that all overlaps agree as well as they can \
                    together";
        if button.on_hover_text(hint).clicked() {
            let what = What::Balance {
                layers: taking_part.into_iter().map(|(id, _)| id).collect(),
                held: pane.held.clone(),
            };
            self.compare_colours(what);
        }
    }

    /// Asks for an answer, on another thread.
    fn compare_colours(&mut self, what: What) {
        let seen_only = self.matching.seen_only;
        let (camera, aspect) = (*self.camera(), self.aspect);
        let engine = self.document.engine();
        let questions = engine.questions();
        let area = seen_only.then(|| questions.seen_area(&camera, aspect));
        let pane = &mut self.matching;
        pane.presses += 1;
        let wanted = Wanted {
            press: pane.presses,
            what: what.clone(),
        };
        pane.latest.ask(wanted, || {
            move |task: &Task| {
                let area = match &area {
                    Some(None) => return Err("Nothing of the planet is seen.".to_owned()),
                    Some(Some(area)) => Some(area),
                    None => None,
                };
                let found = match &what {
                    What::Match {
                        layer,
                        target,
                        method,
                    } => {
                        let how = (*method, 1.0);
                        let found = questions.match_colours(layer, target, area, how, task);
                        found.map(|found| Found::Matched(Arc::new(found)))
                    }
                    What::Balance { layers, held } => {
                        let found = questions.balance_colours(layers, held.as_ref(), area, task);
                        found.map(|found| Found::Balanced(Arc::new(found)))
                    }
                };
                found.map_err(|e| e.to_string())
            }
        });
    }

    /// Makes an edit of an answer, once.
    fn carry_out_match(&mut self, actions: &mut Vec<Action>) {
        let Some(last) = self.matching.latest.last() else {
            return;
        };
        if last.key.press <= self.matching.carried_out {
            return;
        }
        self.matching.carried_out = last.key.press;
        let project = self.document.project();
        let unlocked = |id: &LayerId| project.layer(id).is_some_and(|l| !l.locked);
        match (last.answer, last.key.what) {
            (Ok(Found::Matched(found)), What::Match { layer, .. }) if unlocked(&layer) => {
                actions.push(Action::Edit(Edit::Batch {
                    label: "Match colours".to_owned(),
                    edits: vec![Edit::SetAdjust {
                        id: layer,
                        adjust: found.adjust.clone(),
                    }],
                }));
            }
            (Ok(Found::Balanced(found)), _) => {
                let layers = found.layers.iter().filter(|b| unlocked(&b.layer));
                let edits = layers.map(|balanced| Edit::SetAdjust {
                    id: balanced.layer.clone(),
                    adjust: balanced.adjust.clone(),
                });
                actions.push(Action::Edit(Edit::Batch {
                    label: "Balance layers".to_owned(),
                    edits: edits.collect(),
                }));
            }
            (Ok(Found::Matched(_)) | Err(_), _) => {}
        }
    }

    /// What was found last, and how good it is.
    fn found(&self, ui: &mut Ui) {
        let Some(last) = self.matching.latest.last() else {
            return;
        };
        let name = |id: &LayerId| {
            let layer = self.document.project().layer(id);
            layer.map_or_else(|| id.0.as_str().to_owned(), |l| l.name.clone())
        };
        match &last.answer {
            Err(reason) => {
                ui.colored_label(ui.visuals().error_fg_color, reason);
            }
            Ok(Found::Matched(found)) => {
                let fit = &found.fit;
                let share = 100.0 * fit.same as f64 / fit.pairs.max(1) as f64;
                ui.label(format!(
                    "{} places compared, {share:.0} % of them show the same ground.",
                    fit.pairs
                ));
                differences(ui, &[(String::new(), fit.before, fit.after)]);
                curves::show(ui, &fit.histograms);
                ui.weak(
                    "Change the result, or its strength, in the inspector; Ctrl+Z takes it back.",
                );
            }
            Ok(Found::Balanced(found)) => {
                let rows: Vec<_> = found
                    .overlaps
                    .iter()
                    .map(
                        |OverlapDifference {
                             layers,
                             before,
                             after,
                             ..
                         }| {
                            let names = layers.each_ref().map(name);
                            (names.join(" and "), *before, *after)
                        },
                    )
                    .collect();
                differences(ui, &rows);
            }
        }
    }
}

/// A choice of a layer, or of none.
fn chooser(
    ui: &mut Ui,
    (title, hint): (&str, &str),
    none: &str,
    layers: &[(LayerId, String)],
    chosen: &mut Option<LayerId>,
) {
    ui.horizontal(|ui| {
        let label = controls::name(ui, title, false).on_hover_text(hint);
        let name = layers.iter().find(|(id, _)| Some(id) == chosen.as_ref());
        let combo = ComboBox::from_id_salt(title)
            .selected_text(name.map_or(none, |(_, name)| name))
            .width(ui.available_width() - 8.0);
        let combo = combo.show_ui(ui, |ui| {
            ui.selectable_value(chosen, None, none);
            for (id, name) in layers {
                ui.selectable_value(chosen, Some(id.clone()), name);
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(hint);
    });
}

/// Differences before and after, with what they are of.
fn differences(ui: &mut Ui, rows: &[(String, Difference, Difference)]) {
    let hint = "CIEDE2000: 1 is just seen, 2 to 3 side by side, 10 at a glance";
    Grid::new("colour differences")
        .num_columns(4)
        .spacing([12.0, 3.0])
        .show(ui, |ui| {
            for title in ["Colour difference", "mean", "same ground", "95 %"] {
                ui.weak(title).on_hover_text(hint);
            }
            ui.end_row();
            for (what, before, after) in rows {
                for (when, difference) in [("before", before), ("after", after)] {
                    let title = if what.is_empty() {
                        when.to_owned()
                    } else {
                        format!("{what}, {when}")
                    };
                    ui.label(title);
                    for value in [difference.mean, difference.mean_of_same, difference.p95] {
                        ui.label(format!("{value:.1}"));
                    }
                    ui.end_row();
                }
            }
        });
}
