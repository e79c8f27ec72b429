//! One row of the list of layers: eye, name, opacity, state.

use eframe::egui::{
    self, Align, CornerRadius, Label, Layout, Pos2, Rect, Response, RichText, Role, Sense, Slider,
    Stroke, Ui, UiBuilder, WidgetInfo, vec2,
};
use relievo_engine::project::{Edit, Layer, LayerKind};
use relievo_engine::{Engine, SourceState};

use crate::commands::{Command, entry_of};
use crate::window::action::Action;
use crate::window::theme;

/// Height of a row in points.
pub(crate) const HEIGHT: f32 = 44.0;

/// Width of the opacity slider in points.
const OPACITY_WIDTH: f32 = 64.0;

/// What the second line of a row says.
enum State {
    /// Nothing to worry about.
    Fine(String),
    /// Being opened, 0 to 1.
    Opening(f32),
    /// Left out of the picture, and why.
    LeftOut(String),
    /// Cannot be shown.
    Broken(String),
}

/// Draws a row; the response is that of the row outside its controls.
pub(crate) fn show(
    ui: &mut Ui,
    engine: &Engine,
    layer: &Layer,
    selected: bool,
    actions: &mut Vec<Action>,
) -> Response {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let name = display_name(layer);
    response.widget_info(|| WidgetInfo::selected(Role::ListBoxOption, true, selected, &name));
    if !layer.locked {
        response.dnd_set_drag_payload(layer.id.clone());
    }
    theme::row(ui, rect, &response, selected);
    let inner = rect.shrink2(vec2(6.0, 4.0));
    let mut content = ui.new_child(
        UiBuilder::new()
            .max_rect(inner)
            .layout(Layout::left_to_right(Align::Center)),
    );
    content.add_enabled_ui(!layer.locked, |ui| {
        if eye(ui, layer.visible, &name, "layer") {
            actions.push(Action::Edit(Edit::SetVisible {
                id: layer.id.clone(),
                visible: !layer.visible,
            }));
        }
    });
    content.add_space(2.0);
    let opacity_left = inner.right() - OPACITY_WIDTH;
    let text = Rect::from_min_max(
        Pos2::new(content.cursor().left(), inner.top()),
        Pos2::new(opacity_left - 6.0, inner.bottom()),
    );
    let mut lines = content.new_child(
        UiBuilder::new()
            .max_rect(text)
            .layout(Layout::top_down(Align::Min)),
    );
    lines.spacing_mut().item_spacing.y = 1.0;
    let title = if layer.visible {
        RichText::new(&name)
    } else {
        RichText::new(&name).weak()
    };
    let title = if selected { title.strong() } else { title };
    lines.add(Label::new(title).truncate().selectable(false));
    let state = state(engine, layer);
    state_line(&mut lines, &state);
    let slot = Rect::from_min_max(Pos2::new(opacity_left, inner.top()), inner.max);
    let mut end = ui.new_child(
        UiBuilder::new()
            .max_rect(slot)
            .layout(Layout::top_down(Align::Max)),
    );
    end.add_enabled_ui(!layer.locked, |ui| {
        if matches!(state, State::Broken(_)) {
            locate(ui, layer, &name, actions);
        } else {
            opacity(ui, layer, &name, actions);
        }
    });
    if response.clicked() || response.secondary_clicked() || response.drag_started() {
        actions.push(Action::Select(Some(layer.id.clone())));
    }
    response.context_menu(|ui| context_menu(ui, layer, actions));
    response
}

/// What people call a layer; the id stands in for an empty name.
pub(crate) fn display_name(layer: &Layer) -> String {
    if layer.name.is_empty() {
        layer.id.0.clone()
    } else {
        layer.name.clone()
    }
}

/// An eye that shows or hides what is called `name`; drawn, as not every font has one. Whether it was
/// clicked.
pub(crate) fn eye(ui: &mut Ui, is_open: bool, name: &str, what: &str) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(22.0, 22.0), Sense::click());
    let label = format!("Show {name}");
    response.widget_info(|| WidgetInfo::selected(Role::CheckBox, ui.is_enabled(), is_open, &label));
    let visuals = ui.style().interact(&response);
    let (centre, painter) = (rect.center(), ui.painter());
    let colour = if is_open {
        visuals.text_color()
    } else {
        visuals.text_color().gamma_multiply(0.55)
    };
    let stroke = Stroke::new(1.4, colour);
    // Two arcs that meet at the corners of the eye.
    let arc = |side: f32| -> Vec<Pos2> {
        (0..=12)
            .map(|i| {
                let t = i as f32 / 12.0;
                centre
                    + vec2(
                        -8.0 + 16.0 * t,
                        side * 5.5 * (core::f32::consts::PI * t).sin(),
                    )
            })
            .collect()
    };
    for side in [-1.0, 1.0] {
        painter.line(arc(side), stroke);
    }
    if is_open {
        painter.circle_filled(centre, 2.6, colour);
    } else {
        painter.line_segment([centre + vec2(-7.0, 6.0), centre + vec2(7.0, -6.0)], stroke);
    }
    if response.has_focus() {
        painter.rect_stroke(
            rect,
            CornerRadius::same(3),
            ui.visuals().selection.stroke,
            egui::StrokeKind::Inside,
        );
    }
    let hint = if is_open { "Hide" } else { "Show" };
    response
        .on_hover_text(format!("{hint} this {what}"))
        .clicked()
}

fn opacity(ui: &mut Ui, layer: &Layer, name: &str, actions: &mut Vec<Action>) {
    ui.spacing_mut().slider_width = OPACITY_WIDTH;
    let mut value = layer.opacity;
    let slider = Slider::new(&mut value, 0.0..=1.0)
        .show_value(false)
        .trailing_fill(true);
    let response = ui.add(slider);
    response.widget_info(|| {
        WidgetInfo::slider(ui.is_enabled(), layer.opacity, format!("Opacity of {name}"))
    });
    let response = response.on_hover_text(format!(
        "Opacity {:.0} %\n0 to 100 %, usually 100 %",
        layer.opacity * 100.0
    ));
    if response.drag_started() {
        actions.push(Action::BeginDrag);
    }
    if response.changed() && value != layer.opacity {
        actions.push(Action::Edit(Edit::SetOpacity {
            id: layer.id.clone(),
            opacity: value,
        }));
    }
    if response.drag_stopped() {
        actions.push(Action::EndDrag);
    }
    ui.add(
        Label::new(
            RichText::new(format!("{:.0} %", layer.opacity * 100.0))
                .small()
                .weak(),
        )
        .selectable(false),
    );
}

/// Takes the place of the opacity where there is nothing to see.
fn locate(ui: &mut Ui, layer: &Layer, name: &str, actions: &mut Vec<Action>) {
    ui.add_space(6.0);
    let button = egui::Button::new(RichText::new("Locate…").small());
    let response = ui.add(button.wrap_mode(egui::TextWrapMode::Extend));
    response.widget_info(|| {
        WidgetInfo::labeled(
            Role::Button,
            ui.is_enabled(),
            format!("Locate the file of {name}"),
        )
    });
    if response
        .on_hover_text(entry_of(Command::Locate).help)
        .clicked()
    {
        actions.push(Action::Select(Some(layer.id.clone())));
        actions.push(Action::Run(Command::Locate));
    }
}

fn state(engine: &Engine, layer: &Layer) -> State {
    let kind = match &layer.kind {
        LayerKind::Imagery(_) => "imagery",
        LayerKind::Height(_) => "heights",
        LayerKind::Noise(_) => "noise heights",
        LayerKind::Detail(_) => "detail of the heights below",
        LayerKind::Tint(_) => "height colours",
        LayerKind::Slope(_) => "slopes",
        LayerKind::Contours(_) => "contour lines",
        LayerKind::Vector(_) => "features",
        LayerKind::Unknown { kind } => {
            return State::LeftOut(format!("{kind}: of a newer Relievo, without effect"));
        }
    };
    let kind = if layer.locked {
        format!("{kind}, locked")
    } else {
        kind.to_owned()
    };
    match engine.sources().state(&layer.kind, engine.folder()) {
        Some(SourceState::Opening(share)) => return State::Opening(share),
        Some(SourceState::Failed(reason)) => return State::Broken(reason),
        Some(SourceState::Open(_) | SourceState::Features(_)) | None => {}
    }
    if !layer.visible {
        return State::Fine(format!("{kind}, hidden"));
    }
    match engine.left_out().iter().find(|(id, _)| *id == layer.id) {
        Some((_, reason)) => State::LeftOut(format!("{kind}: {reason}")),
        None => State::Fine(kind),
    }
}

fn state_line(ui: &mut Ui, state: &State) {
    let small = |text: String| {
        Label::new(RichText::new(text).small().weak())
            .truncate()
            .selectable(false)
    };
    match state {
        State::Fine(text) => {
            ui.add(small(text.clone()));
        }
        State::LeftOut(text) => {
            ui.add(small(text.clone())).on_hover_text(text);
        }
        State::Opening(share) => {
            let text = if *share > 0.0 {
                format!("preparing, {:.0} %", share * 100.0)
            } else {
                "opening".to_owned()
            };
            let bar = egui::ProgressBar::new(*share)
                .desired_height(12.0)
                .text(RichText::new(text).small());
            ui.add(bar)
                .on_hover_text("Overviews of big files are made once and kept");
        }
        State::Broken(reason) => {
            let text = RichText::new(format!("! {reason}"))
                .small()
                .color(ui.visuals().error_fg_color);
            ui.add(Label::new(text).truncate().selectable(false))
                .on_hover_text(reason);
        }
    }
}

fn context_menu(ui: &mut Ui, layer: &Layer, actions: &mut Vec<Action>) {
    let (id, locked) = (&layer.id, layer.locked);
    let commands = [
        Command::ToggleVisible,
        Command::ZoomToLayer,
        Command::Locate,
        Command::MoveUp,
        Command::MoveDown,
        Command::RemoveLayer,
    ];
    for command in commands {
        if command == Command::Locate && layer.source().is_none() {
            continue;
        }
        let entry = entry_of(command);
        let button = egui::Button::new(entry.title).shortcut_text(entry.shortcut_text(ui.ctx()));
        let enabled = !locked || command == Command::ZoomToLayer;
        if ui
            .add_enabled(enabled, button)
            .on_hover_text(entry.help)
            .clicked()
        {
            actions.push(Action::Select(Some(id.clone())));
            actions.push(Action::Run(command));
            ui.close();
        }
    }
    ui.separator();
    let title = if locked { "Unlock" } else { "Lock" };
    if ui
        .button(title)
        .on_hover_text("A locked layer cannot be changed in the window")
        .clicked()
    {
        actions.push(Action::Edit(Edit::SetLocked {
            id: id.clone(),
            locked: !locked,
        }));
        ui.close();
    }
}
