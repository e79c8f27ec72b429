//! Layers drawn from the shape of the ground: colours by slope, contour lines.

use eframe::egui::{self, DragValue, Ui, WidgetInfo};
use relievo_engine::project::{
    ContoursLayer, Edit, LayerId, SlopeLayer, SlopeStop, SlopeUnit, TintInterpolation,
};

use crate::window::action::Action;
use crate::window::controls::{self, Number};

/// Least distance between stops when they are dragged, degrees.
const LEAST_GAP_DEG: f64 = 0.01;

/// Steepest stop that can be dragged to, degrees: beyond it percents lose their meaning.
const STEEPEST_DEG: f64 = 89.0;

const UNITS: [(SlopeUnit, &str); 2] = [
    (SlopeUnit::Degrees, "Degrees"),
    (SlopeUnit::Percent, "Percent"),
];

const BETWEEN: [(TintInterpolation, &str); 2] = [
    (TintInterpolation::Stepped, "Classes"),
    (TintInterpolation::Smooth, "Smooth"),
];

const AUTOMATIC: [(bool, &str); 2] = [(true, "By distance"), (false, "Fixed")];

const INTERVAL: Number = Number::new("Interval", "Height between two lines", 0.1..=1000.0, 10.0)
    .unit(" m", 2)
    .logarithmic();
const BASE: Number = Number::new(
    "Base",
    "A height that has a line; index lines are counted from it",
    -1000.0..=1000.0,
    0.0,
)
.unit(" m", 2);
const INDEX: Number = Number::new(
    "Index every",
    "Every how many lines one is drawn wider; 0 for none",
    0.0..=20.0,
    5.0,
)
.whole();
const WIDTH: Number = Number::new("Width", "Width of lines", 0.0..=8.0, 1.0).unit(" px", 1);
const INDEX_WIDTH: Number =
    Number::new("Index width", "Width of index lines", 0.0..=8.0, 2.0).unit(" px", 1);

/// Colours by slope, the steepest on top.
pub(crate) fn slope(ui: &mut Ui, id: &LayerId, layer: &SlopeLayer, actions: &mut Vec<Action>) {
    let edit = |change: &dyn Fn(&mut SlopeLayer)| {
        let mut slope = layer.clone();
        change(&mut slope);
        Edit::SetSlope {
            id: id.clone(),
            slope,
        }
    };
    let hint = "What slopes are read and typed in: the angle, or metres up to 100 metres along";
    controls::choice(ui, "Unit", hint, &UNITS, layer.unit, actions, |unit| {
        edit(&|slope| slope.unit = unit)
    });
    let hint =
        "What happens between two stops: a class holds up to the next, smooth changes evenly";
    let value = layer.interpolation;
    controls::choice(ui, "Between", hint, &BETWEEN, value, actions, |between| {
        edit(&|slope| slope.interpolation = between)
    });
    for index in (0..layer.stops.len()).rev() {
        ui.horizontal(|ui| stop(ui, layer, index, &edit, actions));
    }
    let add = ui.button("Add stop");
    if add
        .on_hover_text("Add a colour above the steepest one")
        .clicked()
    {
        actions.push(Action::Edit(edit(&|slope| {
            let top = slope.stops.last();
            let deg = top.map_or(0.0, |s| (s.slope_deg + 5.0).min(STEEPEST_DEG));
            let colour = top.map_or([255, 0, 0], |s| s.colour);
            slope.stops.push(SlopeStop::new(deg, colour));
        })));
    }
}

fn stop(
    ui: &mut Ui,
    layer: &SlopeLayer,
    index: usize,
    edit: &impl Fn(&dyn Fn(&mut SlopeLayer)) -> Edit,
    actions: &mut Vec<Action>,
) {
    let shown = &layer.stops[index];
    let changed = |set: &dyn Fn(&mut SlopeStop)| edit(&|slope| set(&mut slope.stops[index]));
    let suffix = match layer.unit {
        SlopeUnit::Degrees => "°",
        SlopeUnit::Percent => " %",
    };
    let mut colour = shown.colour;
    let button = ui.color_edit_button_srgb(&mut colour);
    let slope = layer.unit.from_deg(shown.slope_deg);
    let label = format!("Colour from {slope:.1}{suffix}");
    button.widget_info(|| WidgetInfo::labeled(egui::Role::ColorWell, true, &label));
    if colour != shown.colour {
        actions.push(Action::Edit(changed(&|s| s.colour = colour)));
    }
    let neighbour = |at: Option<usize>| at.and_then(|i| layer.stops.get(i)).map(|s| s.slope_deg);
    let below = neighbour(index.checked_sub(1)).map_or(0.0, |deg| deg + LEAST_GAP_DEG);
    let above = neighbour(Some(index + 1)).map_or(STEEPEST_DEG, |deg| deg - LEAST_GAP_DEG);
    let range = layer.unit.from_deg(below)..=layer.unit.from_deg(above.max(below));
    let mut typed = slope;
    let field = DragValue::new(&mut typed)
        .range(range)
        .clamp_existing_to_range(false)
        .speed(0.2)
        .max_decimals(2)
        .suffix(suffix)
        .update_while_editing(false);
    let hint = "Slope from which the colour holds, between its neighbours";
    if dragged(
        ui,
        field,
        slope,
        &format!("Slope of stop {}", index + 1),
        hint,
        actions,
    ) && typed != slope
    {
        let deg = layer.unit.to_deg(typed).clamp(below, above.max(below));
        actions.push(Action::Edit(changed(&|s| s.slope_deg = deg)));
    }
    let percent = 100.0 * shown.opacity;
    let mut typed = percent;
    let field = DragValue::new(&mut typed)
        .range(0.0..=100.0)
        .clamp_existing_to_range(false)
        .max_decimals(0)
        .suffix(" %")
        .update_while_editing(false);
    let hint = "How much the colour covers, 0 to 100 %";
    if dragged(
        ui,
        field,
        percent,
        &format!("Opacity of stop {}", index + 1),
        hint,
        actions,
    ) && typed != percent
    {
        actions.push(Action::Edit(changed(&|s| s.opacity = typed / 100.0)));
    }
    let remove = ui.add_enabled(layer.stops.len() > 1, egui::Button::new("×").small());
    let label = format!("Remove stop {}", index + 1);
    remove.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &label));
    if remove.on_hover_text("Remove this colour").clicked() {
        actions.push(Action::Edit(edit(&|slope| {
            slope.stops.remove(index);
        })));
    }
}

/// A number field of a row, a whole drag of which is one undo step. Whether it changed.
fn dragged(
    ui: &mut Ui,
    field: DragValue<'_>,
    value: f64,
    name: &str,
    hint: &str,
    actions: &mut Vec<Action>,
) -> bool {
    let response = ui.add(field);
    response.widget_info(|| WidgetInfo {
        label: Some(name.to_owned()),
        ..WidgetInfo::drag_value(true, value)
    });
    let response = response.on_hover_text(hint);
    if response.drag_started() {
        actions.push(Action::BeginDrag);
    }
    if response.drag_stopped() {
        actions.push(Action::EndDrag);
    }
    response.changed()
}

/// Contour lines.
pub(crate) fn contours(
    ui: &mut Ui,
    id: &LayerId,
    layer: &ContoursLayer,
    actions: &mut Vec<Action>,
) {
    let edit = |change: &dyn Fn(&mut ContoursLayer)| {
        let mut contours = layer.clone();
        change(&mut contours);
        Edit::SetContours {
            id: id.clone(),
            contours,
        }
    };
    let hint = "Lines at round heights that suit the distance, or at heights of your choice";
    let value = layer.interval_m.is_none();
    controls::choice(
        ui,
        "Heights",
        hint,
        &AUTOMATIC,
        value,
        actions,
        |automatic| edit(&|contours| contours.interval_m = (!automatic).then_some(10.0)),
    );
    if let Some(interval_m) = layer.interval_m {
        controls::number(ui, &INTERVAL, interval_m, actions, |v| {
            edit(&|contours| contours.interval_m = Some(v))
        });
    }
    controls::number(ui, &BASE, layer.base_m, actions, |v| {
        edit(&|contours| contours.base_m = v)
    });
    let every = f64::from(layer.index_every);
    controls::number(ui, &INDEX, every, actions, |v| {
        edit(&|contours| contours.index_every = v.round() as u32)
    });
    controls::number(ui, &WIDTH, layer.width_px, actions, |v| {
        edit(&|contours| contours.width_px = v)
    });
    controls::number(ui, &INDEX_WIDTH, layer.index_width_px, actions, |v| {
        edit(&|contours| contours.index_width_px = v)
    });
    ui.horizontal(|ui| {
        let label = controls::name(ui, "Colour", false);
        let mut colour = layer.colour;
        let button = ui.color_edit_button_srgb(&mut colour).labelled_by(label.id);
        button.on_hover_text("Colour of the lines");
        if colour != layer.colour {
            actions.push(Action::Edit(edit(&|contours| contours.colour = colour)));
        }
    });
}
