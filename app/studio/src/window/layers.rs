//! The list of layers: the top row is drawn last. Rows are selected by a click, moved by a drag.

mod dates;
mod row;

pub(crate) use row::eye;

use eframe::egui::{self, Align, Layout, ScrollArea, Stroke, Ui};
use relievo_engine::Engine;
use relievo_engine::project::{Edit, Layer, LayerId};

use super::action::Action;
use crate::commands::{Command, entry_of};

/// Draws the list.
pub(crate) fn show(
    ui: &mut Ui,
    engine: &Engine,
    selected: Option<&LayerId>,
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        let count = engine.project().layers.len();
        let text = match count {
            1 => "1 layer".to_owned(),
            _ => format!("{count} layers"),
        };
        ui.weak(text);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.menu_button("Add", |ui| {
                for command in [
                    Command::AddFiles,
                    Command::AddNoise,
                    Command::AddDetail,
                    Command::AddTint,
                    Command::AddSlope,
                    Command::AddContours,
                ] {
                    let entry = entry_of(command);
                    if ui.button(entry.title).on_hover_text(entry.help).clicked() {
                        actions.push(Action::Run(command));
                        ui.close();
                    }
                }
            })
            .response
            .on_hover_text("Add a layer on top of the list");
        });
    });
    dates::show(ui, engine.project(), actions);
    ui.add_space(2.0);
    let layers = &engine.project().layers;
    if layers.is_empty() {
        ui.add_space(12.0);
        ui.vertical_centered(|ui| ui.weak("No layers yet. Add files, or drop them here."));
        return;
    }
    let count = layers.len();
    let mut gap_line = None;
    ui.spacing_mut().item_spacing.y = 1.0;
    ScrollArea::vertical().auto_shrink([false, true]).show_rows(
        ui,
        row::HEIGHT,
        count,
        |ui, rows| {
            for position in rows {
                let layer = &layers[count - 1 - position];
                let is_selected = selected == Some(&layer.id);
                let response = row::show(ui, engine, layer, is_selected, actions);
                let Some(dragged) = response.dnd_hover_payload::<LayerId>() else {
                    continue;
                };
                let pointer_y = ui
                    .input(|i| i.pointer.interact_pos())
                    .map_or(response.rect.center().y, |p| p.y);
                let below = pointer_y > response.rect.center().y;
                let gap = position + usize::from(below);
                let y = if below {
                    response.rect.bottom()
                } else {
                    response.rect.top()
                };
                gap_line = Some((response.rect.x_range(), y));
                if response.dnd_release_payload::<LayerId>().is_some()
                    && let Some(index) = target_index(engine, &dragged, gap)
                {
                    actions.push(Action::Edit(Edit::MoveLayer {
                        id: (*dragged).clone(),
                        index,
                    }));
                }
            }
            if let Some((x, y)) = gap_line {
                let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
                ui.painter().hline(x, y, stroke);
            }
        },
    );
    if egui::DragAndDrop::has_payload_of_type::<LayerId>(ui.ctx()) {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
    }
}

/// Position from the bottom of a layer that is dropped into the gap above row `gap` (counted from
/// the top; the number of rows: below all). `None` when it stays where it is.
fn target_index(engine: &Engine, dragged: &LayerId, gap: usize) -> Option<usize> {
    let project = engine.project();
    let (count, from) = (project.layers.len(), project.layer_index(dragged)?);
    let row = count - 1 - from;
    let new_row = if gap > row { gap - 1 } else { gap };
    let index = (count - 1).checked_sub(new_row)?;
    (index != from).then_some(index)
}

/// What people call a layer.
pub(crate) fn name_of(layer: &Layer) -> String {
    row::display_name(layer)
}

/// The edit that moves a layer by one row, up the list or down.
pub(crate) fn step(engine: &Engine, id: &LayerId, up: bool) -> Option<Edit> {
    let from = engine.project().layer_index(id)?;
    let index = if up { from + 1 } else { from.checked_sub(1)? };
    (index < engine.project().layers.len()).then(|| Edit::MoveLayer {
        id: id.clone(),
        index,
    })
}
