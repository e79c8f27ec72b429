//! A layer's place in a series of pictures of one ground at different times.

use eframe::egui::{self, CollapsingHeader, RichText, TextEdit, Ui};
use relievo_engine::project::{Dated, Edit, Extra, Layer, LayerId, Project, parse_date};

use crate::window::action::Action;
use crate::window::controls;

/// What is being typed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Typed {
    layer: Option<LayerId>,
    series: String,
    date: String,
    /// As the project had it when the typing began.
    before: Option<Dated>,
}

impl Typed {
    /// Takes over what the project says, unless somebody is typing.
    fn follow(&mut self, layer: &Layer) {
        if self.layer.as_ref() == Some(&layer.id) && self.before == layer.dated {
            return;
        }
        let dated = layer.dated.as_ref();
        *self = Self {
            layer: Some(layer.id.clone()),
            series: dated.map(|d| d.series.clone()).unwrap_or_default(),
            date: dated.map(|d| d.date.to_string()).unwrap_or_default(),
            before: layer.dated.clone(),
        };
    }

    /// What is typed as a place in a series; an `Err` says what is missing.
    fn dated(&self) -> Result<Option<Dated>, &'static str> {
        let (series, date) = (self.series.trim(), self.date.trim());
        if series.is_empty() && date.is_empty() {
            return Ok(None);
        }
        let date = parse_date(date).ok_or("A day as 2015-09-26")?;
        if series.is_empty() {
            return Err("A name of the series");
        }
        Ok(Some(Dated {
            series: series.to_owned(),
            date,
            extra: self
                .before
                .as_ref()
                .map_or_else(Extra::new, |d| d.extra.clone()),
        }))
    }
}

/// Draws it.
pub(super) fn show(
    ui: &mut Ui,
    typed: &mut Typed,
    project: &Project,
    layer: &Layer,
    actions: &mut Vec<Action>,
) {
    ui.add_space(4.0);
    typed.follow(layer);
    CollapsingHeader::new(RichText::new("Time").strong())
        .default_open(layer.dated.is_some())
        .show_unindented(ui, |ui| {
            let rows = [
                ("Series", "Layers of one series show the same ground at different times; one of them is shown", &mut typed.series),
                ("Date", "The day that the layer shows, as 2015-09-26", &mut typed.date),
            ];
            let mut done = false;
            for (name, hint, text) in rows {
                ui.horizontal(|ui| {
                    let label = controls::name(ui, name, false).on_hover_text(hint);
                    let field = TextEdit::singleline(text)
                        .desired_width(f32::INFINITY)
                        .char_limit(250);
                    let response = ui.add(field).labelled_by(label.id).on_hover_text(hint);
                    done |= response.lost_focus();
                });
            }
            if done && ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                typed.layer = None;
                return;
            }
            match typed.dated() {
                Ok(dated) if done && dated != layer.dated => {
                    let id = layer.id.clone();
                    actions.push(Action::Edit(Edit::SetDated { id, dated }));
                }
                Ok(_) => {}
                Err(missing) => {
                    ui.weak(format!("{missing} is missing."));
                }
            }
            if layer.is_superseded(&project.layers, project.date) {
                ui.weak("Another picture of the series is shown at the date above the list of layers.");
            }
        });
}
