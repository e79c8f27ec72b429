//! Coordinates and heights of vertices, typed.

use eframe::egui::{self, DragValue, ScrollArea, Ui, WidgetInfo};
use relievo_engine::project::{Edit, Element, ElementKind, Vertex};
use std::sync::Arc;

use super::Shown;
use crate::window::action::Action;
use crate::window::tools::{Spot, changed, inserted, removed};

/// Height of a row in points.
const ROW: f32 = 22.0;

/// Rows that are seen at once.
const ROWS: f32 = 8.0;

/// A coordinate of a vertex.
struct Field {
    name: &'static str,
    hint: &'static str,
    range: core::ops::RangeInclusive<f64>,
    unit: &'static str,
    decimals: usize,
    speed: f64,
    set: fn(&mut Vertex, f64),
}

const LONGITUDE: Field = Field {
    name: "Longitude",
    hint: "Degrees, east positive, -360 to 360",
    range: -360.0..=360.0,
    unit: "°",
    decimals: 6,
    speed: 1e-5,
    set: |v, x| v.lon_deg = x,
};
const LATITUDE: Field = Field {
    name: "Latitude",
    hint: "Degrees, north positive, -90 to 90",
    range: -90.0..=90.0,
    unit: "°",
    decimals: 6,
    speed: 1e-5,
    set: |v, x| v.lat_deg = x,
};
const HEIGHT: Field = Field {
    name: "Height",
    hint: "Metres above the datum, -10 000 000 to 10 000 000",
    range: -1e7..=1e7,
    unit: " m",
    decimals: 2,
    speed: 0.1,
    set: |v, x| v.height_m = Some(x),
};

/// Draws all vertices as rows; the one chosen on the terrain is marked.
pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let lists = shown.element.vertex_lists();
    let spots: Vec<(Spot, Vertex)> = lists
        .iter()
        .enumerate()
        .flat_map(|(list, vertices)| {
            let vertices = vertices.as_slice().iter().enumerate();
            vertices.map(move |(index, vertex)| (Spot { list, index }, *vertex))
        })
        .collect();
    if lists.iter().any(|l| l.missing().is_some()) {
        ui.weak("Some vertices lie in a file that is missing; they are kept.");
    }
    ScrollArea::both()
        .max_height(ROW * ROWS)
        .show_rows(ui, ROW, spots.len(), |ui, rows| {
            for row in rows {
                let (spot, vertex) = &spots[row];
                ui.push_id(row, |ui| {
                    ui.horizontal(|ui| self::row(ui, shown, row, *spot, vertex, actions));
                });
            }
        });
}

/// What people call a list of vertices.
fn list_name(element: &Element, list: usize) -> String {
    match &element.kind {
        ElementKind::Polygon(_) if list == 0 => "Outline".to_owned(),
        ElementKind::Polygon(polygon) if list <= polygon.holes.len() => format!("Hole {list}"),
        ElementKind::Polygon(polygon) => format!("Breakline {}", list - polygon.holes.len()),
        ElementKind::Corridor(_) => "Axis".to_owned(),
        ElementKind::Brush(_) | ElementKind::Unknown { .. } => format!("List {}", list + 1),
    }
}

fn row(
    ui: &mut Ui,
    shown: &Shown<'_>,
    number: usize,
    spot: Spot,
    vertex: &Vertex,
    actions: &mut Vec<Action>,
) {
    let number = number + 1;
    let chosen = shown.vertex == Some(spot);
    let button = ui.selectable_label(chosen, format!("{number}"));
    button.widget_info(|| {
        WidgetInfo::selected(egui::Role::Button, true, chosen, format!("Vertex {number}"))
    });
    let hint = format!(
        "Mark this vertex on the terrain\n{}",
        list_name(shown.element, spot.list)
    );
    if button.on_hover_text(hint).clicked() {
        let id = shown.element.id.clone();
        actions.push(Action::ChooseVertex(id, spot));
    }
    let edit = |element| {
        Action::Edit(Edit::ReplaceElement {
            scenario: shown.scenario.clone(),
            element: Arc::new(element),
        })
    };
    let set = |field: &Field, value: f64| {
        changed(shown.element, spot.list, |vertices| {
            (field.set)(vertices.get_mut(spot.index)?, value);
            Some(())
        })
    };
    let mut value = |ui: &mut Ui, field: &Field, value: f64| {
        let mut new = value;
        let drag = DragValue::new(&mut new)
            .range(field.range.clone())
            .clamp_existing_to_range(false)
            .speed(field.speed)
            .max_decimals(field.decimals)
            .suffix(field.unit)
            .update_while_editing(false);
        let response = ui.add(drag);
        let label = format!("{} of vertex {number}", field.name);
        response.widget_info(|| WidgetInfo {
            label: Some(label.clone()),
            ..WidgetInfo::drag_value(true, value)
        });
        let response = response.on_hover_text(field.hint);
        if response.drag_started() {
            actions.push(Action::BeginDrag);
        }
        if response.changed()
            && new != value
            && let Some(element) = set(field, new)
        {
            actions.push(edit(element));
        }
        if response.drag_stopped() {
            actions.push(Action::EndDrag);
        }
    };
    value(ui, &LONGITUDE, vertex.lon_deg);
    value(ui, &LATITUDE, vertex.lat_deg);
    if let Some(height_m) = vertex.height_m {
        value(ui, &HEIGHT, height_m);
    }
    let mut has_height = vertex.height_m.is_some();
    let tick = ui.checkbox(&mut has_height, "");
    let label = format!("Vertex {number} has a height of its own");
    tick.widget_info(|| WidgetInfo::selected(egui::Role::CheckBox, true, has_height, &label));
    let hint = "A height of its own; without one it is the ground's or lies between its neighbours";
    if tick.on_hover_text(hint).changed() {
        let element = changed(shown.element, spot.list, |vertices| {
            vertices.get_mut(spot.index)?.height_m = has_height.then_some(0.0);
            Some(())
        });
        actions.extend(element.map(&edit));
    }
    let small = |ui: &mut Ui, text: &str, name: String, hint: &str| {
        let button = ui.small_button(text);
        button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &name));
        button.on_hover_text(hint).clicked()
    };
    if small(
        ui,
        "+",
        format!("Insert after vertex {number}"),
        "Insert a vertex after this one",
    ) {
        actions.extend(inserted(shown.element, spot).map(&edit));
    }
    if small(
        ui,
        "×",
        format!("Remove vertex {number}"),
        "Remove this vertex",
    ) {
        actions.extend(removed(shown.element, spot).map(&edit));
    }
}
