//! The table of colours by height.

use eframe::egui::{self, DragValue, Ui, WidgetInfo};
use relievo_engine::project::{Edit, LayerId, Tint, TintInterpolation, TintStop};

use crate::window::action::Action;
use crate::window::controls;

/// Least distance between stops when they are dragged, metres.
const LEAST_GAP_M: f64 = 0.1;

/// Lowest and highest stop, metres.
const RANGE_M: [f64; 2] = [-1e7, 1e7];

const INTERPOLATIONS: [(TintInterpolation, &str); 2] = [
    (TintInterpolation::Smooth, "Smooth"),
    (TintInterpolation::Stepped, "Steps"),
];

/// Draws it, the highest stop on top.
pub(crate) fn show(ui: &mut Ui, id: &LayerId, tint: &Tint, actions: &mut Vec<Action>) {
    let edit = |tint| {
        Action::Edit(Edit::SetTint {
            id: id.clone(),
            tint,
        })
    };
    let hint = "What happens between two stops";
    controls::choice(
        ui,
        "Between",
        hint,
        &INTERPOLATIONS,
        tint.interpolation,
        actions,
        |interpolation| Edit::SetTint {
            id: id.clone(),
            tint: Tint {
                interpolation,
                ..tint.clone()
            },
        },
    );
    for index in (0..tint.stops.len()).rev() {
        ui.horizontal(|ui| stop(ui, tint, index, &edit, actions));
    }
    if ui
        .button("Add stop")
        .on_hover_text("Add a colour above the highest one")
        .clicked()
    {
        let mut tint = tint.clone();
        let top = tint.stops.last().map_or(0.0, |s| s.height_m);
        let colour = tint.stops.last().map_or([255; 3], |s| s.colour);
        tint.stops
            .push(TintStop::new((top + 500.0).min(RANGE_M[1]), colour));
        actions.push(edit(tint));
    }
}

fn stop(
    ui: &mut Ui,
    tint: &Tint,
    index: usize,
    edit: &impl Fn(Tint) -> Action,
    actions: &mut Vec<Action>,
) {
    let shown = &tint.stops[index];
    let changed = |set: &dyn Fn(&mut TintStop)| {
        let mut tint = tint.clone();
        set(&mut tint.stops[index]);
        edit(tint)
    };
    let mut colour = shown.colour;
    let button = ui.color_edit_button_srgb(&mut colour);
    let label = format!("Colour at {} m", shown.height_m);
    button.widget_info(|| WidgetInfo::labeled(egui::Role::ColorWell, true, &label));
    if colour != shown.colour {
        actions.push(changed(&|s| s.colour = colour));
    }
    let below = index
        .checked_sub(1)
        .map_or(RANGE_M[0], |i| tint.stops[i].height_m + LEAST_GAP_M);
    let above = tint
        .stops
        .get(index + 1)
        .map_or(RANGE_M[1], |s| s.height_m - LEAST_GAP_M);
    let mut height_m = shown.height_m;
    let field = DragValue::new(&mut height_m)
        .range(below..=above.max(below))
        .clamp_existing_to_range(false)
        .speed(10.0)
        .suffix(" m")
        .update_while_editing(false);
    let response = ui.add(field);
    response.widget_info(|| WidgetInfo {
        label: Some(format!("Height of stop {}", index + 1)),
        ..WidgetInfo::drag_value(true, shown.height_m)
    });
    let response =
        response.on_hover_text("Height above the datum in metres, between its neighbours");
    if response.drag_started() {
        actions.push(Action::BeginDrag);
    }
    if response.changed() && height_m != shown.height_m {
        actions.push(changed(&|s| s.height_m = height_m));
    }
    if response.drag_stopped() {
        actions.push(Action::EndDrag);
    }
    let remove = ui.add_enabled(tint.stops.len() > 1, egui::Button::new("×").small());
    remove.widget_info(|| {
        WidgetInfo::labeled(
            egui::Role::Button,
            true,
            format!("Remove stop {}", index + 1),
        )
    });
    if remove.on_hover_text("Remove this colour").clicked() {
        let mut tint = tint.clone();
        tint.stops.remove(index);
        actions.push(edit(tint));
    }
}
