//! The list of planning elements: the top row wins. Rows are selected by a click, moved by a drag.

use std::sync::Arc;

use eframe::egui::{
    self, Align, Label, Layout, Pos2, Rect, Response, RichText, Role, ScrollArea, Sense, Stroke,
    Ui, UiBuilder, WidgetInfo, vec2,
};
use relievo_engine::project::{
    Edit, Element, ElementId, ElementKind, ScenarioId, SectionKind, SurfaceKind,
};

use super::action::Action;
use super::layers::eye;
use super::theme;
use crate::commands::{Command, entry_of};
use crate::window::tools::Tool;

/// Height of a row in points.
const ROW: f32 = 38.0;

/// Draws the elements of a scenario, the bottom one first in `elements`.
pub(crate) fn show(
    ui: &mut Ui,
    scenario: Option<&ScenarioId>,
    elements: &[Arc<Element>],
    selected: Option<&ElementId>,
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        let count = elements.len();
        ui.weak(if count == 1 {
            "1 element".to_owned()
        } else {
            format!("{count} elements")
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let menu = ui.menu_button("Draw", |ui| {
                for tool in [Tool::Polygon, Tool::Corridor, Tool::Brush] {
                    let entry = entry_of(Command::Use(tool));
                    let button =
                        egui::Button::new(entry.title).shortcut_text(entry.shortcut_text(ui.ctx()));
                    if ui.add(button).on_hover_text(entry.help).clicked() {
                        actions.push(Action::Run(Command::Use(tool)));
                        ui.close();
                    }
                }
            });
            menu.response
                .on_hover_text("Draw a new element on the terrain");
        });
    });
    ui.add_space(2.0);
    if elements.is_empty() {
        ui.add_space(12.0);
        ui.vertical_centered(|ui| ui.weak("No planning elements yet. Draw one on the terrain."));
        return;
    }
    let count = elements.len();
    let mut gap_line = None;
    ui.spacing_mut().item_spacing.y = 1.0;
    ScrollArea::vertical()
        .auto_shrink([false, true])
        .show_rows(ui, ROW, count, |ui, rows| {
            for position in rows {
                let element = &elements[count - 1 - position];
                let is_selected = selected == Some(&element.id);
                let response = row(ui, scenario, element, is_selected, actions);
                let Some(dragged) = response.dnd_hover_payload::<ElementId>() else {
                    continue;
                };
                let pointer = ui.input(|i| i.pointer.interact_pos());
                let below = pointer.is_some_and(|p| p.y > response.rect.center().y);
                let y = if below {
                    response.rect.bottom()
                } else {
                    response.rect.top()
                };
                gap_line = Some((response.rect.x_range(), y));
                if response.dnd_release_payload::<ElementId>().is_some()
                    && let Some(index) = target(elements, &dragged, position + usize::from(below))
                {
                    actions.push(Action::Edit(Edit::MoveElement {
                        scenario: scenario.cloned(),
                        id: (*dragged).clone(),
                        index,
                    }));
                }
            }
            if let Some((x, y)) = gap_line {
                let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
                ui.painter().hline(x, y, stroke);
            }
        });
}

/// Position from the bottom of an element that is dropped into the gap above row `gap`; `None` when
/// it stays where it is.
fn target(elements: &[Arc<Element>], dragged: &ElementId, gap: usize) -> Option<usize> {
    let (count, from) = (
        elements.len(),
        elements.iter().position(|e| e.id == *dragged)?,
    );
    let row = count - 1 - from;
    let new_row = if gap > row { gap - 1 } else { gap };
    let index = (count - 1).checked_sub(new_row)?;
    (index != from).then_some(index)
}

/// What people call an element; the id stands in for an empty name.
pub(crate) fn name_of(element: &Element) -> String {
    if element.name.is_empty() {
        element.id.0.clone()
    } else {
        element.name.clone()
    }
}

fn row(
    ui: &mut Ui,
    scenario: Option<&ScenarioId>,
    element: &Element,
    selected: bool,
    actions: &mut Vec<Action>,
) -> Response {
    let size = vec2(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let name = name_of(element);
    response.widget_info(|| WidgetInfo::selected(Role::ListBoxOption, true, selected, &name));
    if !element.locked {
        response.dnd_set_drag_payload(element.id.clone());
    }
    theme::row(ui, rect, &response, selected);
    let inner = rect.shrink2(vec2(6.0, 3.0));
    let layout = Layout::left_to_right(Align::Center);
    let mut content = ui.new_child(UiBuilder::new().max_rect(inner).layout(layout));
    content.add_enabled_ui(!element.locked, |ui| {
        if eye(ui, element.visible, &name, "element") {
            actions.push(Action::Edit(Edit::SetElementVisible {
                scenario: scenario.cloned(),
                id: element.id.clone(),
                visible: !element.visible,
            }));
        }
    });
    let from = Pos2::new(content.cursor().left() + 2.0, inner.top());
    let text = Rect::from_min_max(from, inner.max);
    let layout = Layout::top_down(Align::Min);
    let mut lines = ui.new_child(UiBuilder::new().max_rect(text).layout(layout));
    lines.spacing_mut().item_spacing.y = 1.0;
    let title = RichText::new(&name);
    let title = if element.visible { title } else { title.weak() };
    let title = if selected { title.strong() } else { title };
    lines.add(Label::new(title).truncate().selectable(false));
    let note = RichText::new(describe(element)).small().weak();
    lines.add(Label::new(note).truncate().selectable(false));
    if response.clicked() || response.secondary_clicked() || response.drag_started() {
        actions.push(Action::SelectElement(Some(element.id.clone())));
    }
    if response.double_clicked() {
        actions.push(Action::Run(Command::ZoomToLayer));
    }
    response.context_menu(|ui| context_menu(ui, scenario, element, actions));
    response
}

fn describe(element: &Element) -> String {
    let kind = match &element.kind {
        ElementKind::Polygon(polygon) => match &polygon.surface.kind {
            SurfaceKind::Platform { height_m } => format!("platform at {height_m:.1} m"),
            SurfaceKind::Plane { slope_percent, .. } => format!("plane, {slope_percent:.1} %"),
            SurfaceKind::Tin => "surface through its vertices".to_owned(),
            SurfaceKind::Offset { offset_m } => format!("ground {offset_m:+.1} m"),
            SurfaceKind::Smooth => "smooth infill".to_owned(),
            SurfaceKind::Unknown { name } => format!("{name}: of a newer Relievo"),
        },
        ElementKind::Corridor(corridor) => match &corridor.section.kind {
            SectionKind::Road { width_m, .. } => format!("road, {width_m:.1} m wide"),
            SectionKind::Dam { crest_width_m } => format!("dam, crest {crest_width_m:.1} m"),
            SectionKind::Trench { depth_m, .. } => format!("trench, {depth_m:.1} m deep"),
            SectionKind::Channel { depth_m, .. } => format!("channel, {depth_m:.1} m deep"),
            SectionKind::Unknown { name } => format!("{name}: of a newer Relievo"),
        },
        ElementKind::Brush(brush) => match brush.strokes.len() {
            1 => "1 stroke".to_owned(),
            count => format!("{count} strokes"),
        },
        ElementKind::Unknown { kind } => format!("{kind}: of a newer Relievo, without effect"),
    };
    if element.locked {
        format!("{kind}, locked")
    } else {
        kind
    }
}

fn context_menu(
    ui: &mut Ui,
    scenario: Option<&ScenarioId>,
    element: &Element,
    actions: &mut Vec<Action>,
) {
    let commands = [
        Command::ToggleVisible,
        Command::ZoomToLayer,
        Command::MoveUp,
        Command::MoveDown,
        Command::RemoveLayer,
    ];
    for command in commands {
        let entry = entry_of(command);
        let button = egui::Button::new(entry.title).shortcut_text(entry.shortcut_text(ui.ctx()));
        let enabled = !element.locked || command == Command::ZoomToLayer;
        if ui
            .add_enabled(enabled, button)
            .on_hover_text(entry.help)
            .clicked()
        {
            actions.push(Action::Run(command));
            ui.close();
        }
    }
    ui.separator();
    let title = if element.locked { "Unlock" } else { "Lock" };
    let hint = "A locked element cannot be changed in the window";
    if ui.button(title).on_hover_text(hint).clicked() {
        actions.push(Action::Edit(Edit::SetElementLocked {
            scenario: scenario.cloned(),
            id: element.id.clone(),
            locked: !element.locked,
        }));
        ui.close();
    }
}
