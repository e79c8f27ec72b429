//! A layer's lens in numbers: its shape, place, size and fade, and whose it is.

use eframe::egui::{ComboBox, Ui};
use relievo_engine::project::{Layer, Lens, LensShape, Mask, Project};

use super::{set, shown_name};
use crate::commands::{Command, entry_of};
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::status::area;
use crate::window::tools::Tool;
use crate::window::tools::lens::{shape, with_lens};

const LON: Number = Number::new(
    "Longitude",
    "Of the lens's centre, east positive",
    -180.0..=180.0,
    0.0,
)
.unit("°", 5);
const LAT: Number = Number::new(
    "Latitude",
    "Of the lens's centre, north positive",
    -90.0..=90.0,
    0.0,
)
.unit("°", 5);
const RADIUS: Number = Number::new(
    "Radius",
    "Of the circle, along the ground",
    1.0..=20_000_000.0,
    10_000.0,
)
.unit(" m", 0)
.logarithmic();
const LENS_FADE: Number = Number::new(
    "Fade",
    "Metres beyond the edge over which the layer fades out",
    0.0..=10_000_000.0,
    0.0,
)
.unit(" m", 0)
.logarithmic();

/// Draws it.
pub(super) fn show(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    mask: &Mask,
    actions: &mut Vec<Action>,
) {
    let id = &layer.id;
    let mut on = mask.lens.is_some();
    let hint = "Show the layer only in a circle or polygon on the ground. Layers with the same one move together";
    ui.horizontal(|ui| {
        let tick = ui.checkbox(&mut on, "In a lens");
        if tick.on_hover_text(hint).changed() {
            actions.push(if on {
                Action::PutLens(id.clone())
            } else {
                Action::Edit(set(id, mask, |m| m.lens = None))
            });
        }
        let mut uses = |ui: &mut Ui, text: &str, tool: Tool| {
            let command = Command::Use(tool);
            let button = ui.button(text).on_hover_text(entry_of(command).help);
            if button.clicked() {
                actions.push(Action::Run(command));
            }
        };
        if mask.lens.is_some() {
            uses(ui, "Move", Tool::Lens);
        }
        uses(ui, "Draw…", Tool::LensOutline);
    });
    let Some(lens) = &mask.lens else { return };
    others_with_lens(ui, project, layer, mask, actions);
    let with = |change: &dyn Fn(&mut Lens)| {
        let mut lens = lens.clone();
        change(&mut lens);
        with_lens(project, id, &lens)
    };
    ui.push_id("lens", |ui| {
        let is_polygon = matches!(lens.shape, LensShape::Polygon { .. });
        let shapes = [(false, "Circle"), (true, "Polygon")];
        let hint =
            "A circle, or a polygon whose corners are dragged. Changing it keeps place and area";
        controls::choice(ui, "Shape", hint, &shapes, is_polygon, actions, |polygon| {
            let changed = if polygon {
                shape::as_polygon(lens)
            } else {
                shape::as_circle(project.planet.body.figure(), lens)
            };
            with_lens(project, id, &changed)
        });
        controls::number(ui, &LON, lens.lon_deg, actions, |v| {
            with(&|l| l.lon_deg = v)
        });
        controls::number(ui, &LAT, lens.lat_deg, actions, |v| {
            with(&|l| l.lat_deg = v)
        });
        match &lens.shape {
            LensShape::Circle { radius_m } => {
                controls::number(ui, &RADIUS, *radius_m, actions, |radius_m| {
                    with(&|l| l.shape = LensShape::Circle { radius_m })
                });
            }
            LensShape::Polygon { corners_m } => corners(ui, corners_m.len(), &lens.shape),
        }
        controls::number(ui, &LENS_FADE, lens.fade_m, actions, |v| {
            with(&|l| l.fade_m = v)
        });
    });
}

/// What a polygon is like.
fn corners(ui: &mut Ui, count: usize, shape: &LensShape) {
    ui.horizontal(|ui| {
        let hint = format!(
            "Drag them with the tool Lens; {} to {}. The area is that of its plane",
            LensShape::LEAST_CORNERS,
            LensShape::MOST_CORNERS
        );
        let label = controls::name(ui, "Corners", false).on_hover_text(&hint);
        let text = format!("{count}, {} inside", area(shape::area_m2(shape)));
        ui.label(text).labelled_by(label.id).on_hover_text(hint);
    });
}

/// Lenses of other layers that this one can share.
fn others_with_lens(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    mask: &Mask,
    actions: &mut Vec<Action>,
) {
    let lens_of = |other: &Layer| other.mask.as_ref().and_then(|m| m.lens.clone());
    let others: Vec<_> = project
        .layers
        .iter()
        .filter(|other| other.id != layer.id)
        .filter_map(|other| Some((other.name.as_str(), lens_of(other)?)))
        .collect();
    if others.is_empty() {
        return;
    }
    let shared = others
        .iter()
        .find(|(_, lens)| Some(lens) == mask.lens.as_ref());
    ui.horizontal(|ui| {
        let hint = "Use the circle or polygon of another layer: both then move together";
        let label = controls::name(ui, "Lens of", false).on_hover_text(hint);
        let combo = ComboBox::from_id_salt("lens of")
            .selected_text(shown_name(
                shared.map(|(name, _)| *name),
                "this layer alone",
            ))
            .width(ui.available_width() - 8.0);
        let combo = combo.show_ui(ui, |ui| {
            for (name, lens) in &others {
                if ui
                    .selectable_label(Some(lens) == mask.lens.as_ref(), *name)
                    .clicked()
                {
                    let lens = lens.clone();
                    actions.push(Action::Edit(set(&layer.id, mask, |m| {
                        m.lens = Some(lens);
                    })));
                }
            }
        });
        combo.response.labelled_by(label.id).on_hover_text(hint);
    });
}
