//! Where a layer shows.

use eframe::egui::{CollapsingHeader, ComboBox, RichText, Ui};
use relievo_engine::project::{
    Edit, Extra, Layer, LayerId, LayerKind, Lens, LensShape, Mask, MaskRange, Project,
};

use crate::commands::{Command, entry_of};
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::status::area;
use crate::window::tools::Tool;
use crate::window::tools::lens::{shape, with_lens};

const FROM_M: Number = Number::new(
    "From",
    "Lowest height that shows fully",
    -12_000.0..=25_000.0,
    0.0,
)
.unit(" m", 0);
const TO_M: Number = Number::new(
    "To",
    "Highest height that shows fully",
    -12_000.0..=25_000.0,
    3000.0,
)
.unit(" m", 0);
const FADE_M: Number = Number::new(
    "Fade",
    "Metres of height beyond either end over which the layer fades out",
    0.0..=10_000.0,
    0.0,
)
.unit(" m", 0)
.logarithmic();
const FROM_DEG: Number = Number::new(
    "From",
    "Least slope that shows fully, against the horizontal",
    0.0..=90.0,
    30.0,
)
.unit("°", 1);
const TO_DEG: Number = Number::new(
    "To",
    "Greatest slope that shows fully, against the horizontal",
    0.0..=90.0,
    90.0,
)
.unit("°", 1);
const FADE_DEG: Number = Number::new(
    "Fade",
    "Degrees beyond either end over which the layer fades out",
    0.0..=90.0,
    0.0,
)
.unit("°", 1);
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
pub(super) fn show(ui: &mut Ui, project: &Project, layer: &Layer, actions: &mut Vec<Action>) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new("Mask").strong())
        .default_open(layer.mask.is_some())
        .show_unindented(ui, |ui| {
            let mask = layer.mask.clone().unwrap_or_default();
            heights(ui, &layer.id, &mask, actions);
            slopes(ui, &layer.id, &mask, actions);
            lens(ui, project, layer, &mask, actions);
            areas(ui, project, layer, &mask, actions);
            let mut invert = mask.invert;
            let hint = "Show the layer everywhere else instead";
            let tick = ui.checkbox(&mut invert, "Outside instead of inside");
            if tick.on_hover_text(hint).changed() {
                actions.push(Action::Edit(set(&layer.id, &mask, |m| m.invert = invert)));
            }
        });
}

/// An edit that changes a mask; one that is left without anything goes.
fn set(id: &LayerId, mask: &Mask, change: impl FnOnce(&mut Mask)) -> Edit {
    let mut mask = mask.clone();
    change(&mut mask);
    let says_nothing = mask == Mask::default();
    Edit::SetMask {
        id: id.clone(),
        mask: (!says_nothing).then(|| Box::new(mask)),
    }
}

fn usual(from: f64, to: f64, fade: f64) -> MaskRange {
    MaskRange {
        from,
        to,
        fade,
        extra: Extra::new(),
    }
}

fn heights(ui: &mut Ui, id: &LayerId, mask: &Mask, actions: &mut Vec<Action>) {
    let mut on = mask.heights.is_some();
    let tick = ui.checkbox(&mut on, "By height");
    let hint = "Show the layer only where the ground lies in a range of heights";
    if tick.on_hover_text(hint).changed() {
        let range = on.then(|| usual(0.0, 3000.0, 100.0));
        actions.push(Action::Edit(set(id, mask, |m| m.heights = range)));
    }
    if let Some(range) = &mask.heights {
        let numbers = [&FROM_M, &TO_M, &FADE_M];
        rows(ui, ("heights", numbers), range, actions, |range| {
            set(id, mask, |m| m.heights = Some(range))
        });
    }
}

fn slopes(ui: &mut Ui, id: &LayerId, mask: &Mask, actions: &mut Vec<Action>) {
    let mut on = mask.slopes.is_some();
    let tick = ui.checkbox(&mut on, "By slope");
    let hint = "Show the layer only where the ground is so steep";
    if tick.on_hover_text(hint).changed() {
        let range = on.then(|| usual(30.0, 90.0, 5.0));
        actions.push(Action::Edit(set(id, mask, |m| m.slopes = range)));
    }
    if let Some(range) = &mask.slopes {
        let numbers = [&FROM_DEG, &TO_DEG, &FADE_DEG];
        rows(ui, ("slopes", numbers), range, actions, |range| {
            set(id, mask, |m| m.slopes = Some(range))
        });
    }
}

/// The numbers of a range; either end gives way to the other.
fn rows(
    ui: &mut Ui,
    (name, [low, high, fade]): (&str, [&Number; 3]),
    range: &MaskRange,
    actions: &mut Vec<Action>,
    edit: impl Fn(MaskRange) -> Edit,
) {
    let with = |change: &dyn Fn(&mut MaskRange)| {
        let mut range = range.clone();
        change(&mut range);
        edit(range)
    };
    ui.push_id(name, |ui| {
        controls::number(ui, low, range.from, actions, |v| {
            with(&|r| (r.from, r.to) = (v, r.to.max(v)))
        });
        controls::number(ui, high, range.to, actions, |v| {
            with(&|r| (r.from, r.to) = (r.from.min(v), v))
        });
        controls::number(ui, fade, range.fade, actions, |v| with(&|r| r.fade = v));
    });
}

fn lens(ui: &mut Ui, project: &Project, layer: &Layer, mask: &Mask, actions: &mut Vec<Action>) {
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
                shape::as_circle(lens)
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

fn shown_name<'a>(name: Option<&'a str>, none: &'a str) -> &'a str {
    name.unwrap_or(none)
}

fn areas(ui: &mut Ui, project: &Project, layer: &Layer, mask: &Mask, actions: &mut Vec<Action>) {
    let words = Words {
        title: "In areas of",
        hint: "Show the layer only inside the areas of a vector layer, which may be hidden",
        none: "None",
    };
    let edit = |new| set(&layer.id, mask, |m| m.vector = new);
    vector_layer(
        ui,
        project,
        layer,
        (&words, mask.vector.as_ref()),
        actions,
        edit,
    );
}

/// What a choice of a vector layer is called.
pub(super) struct Words {
    pub(super) title: &'static str,
    pub(super) hint: &'static str,
    /// The choice of no layer.
    pub(super) none: &'static str,
}

/// A choice of a vector layer whose areas count; nothing where there is none to choose.
pub(super) fn vector_layer(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    (words, chosen): (&Words, Option<&LayerId>),
    actions: &mut Vec<Action>,
    edit: impl FnOnce(Option<LayerId>) -> Edit,
) {
    let others: Vec<&Layer> = project
        .layers
        .iter()
        .filter(|other| other.id != layer.id && matches!(other.kind, LayerKind::Vector(_)))
        .collect();
    if others.is_empty() && chosen.is_none() {
        return;
    }
    ui.horizontal(|ui| {
        let label = controls::name(ui, words.title, false).on_hover_text(words.hint);
        let found = others.iter().find(|other| Some(&other.id) == chosen);
        let missing = if chosen.is_some() {
            "a layer that is gone"
        } else {
            words.none
        };
        let combo = ComboBox::from_id_salt(words.title)
            .selected_text(shown_name(found.map(|other| other.name.as_str()), missing))
            .width(ui.available_width() - 8.0);
        let combo = combo.show_ui(ui, |ui| {
            let mut new = chosen.cloned();
            ui.selectable_value(&mut new, None, words.none);
            for other in &others {
                ui.selectable_value(&mut new, Some(other.id.clone()), &other.name);
            }
            if new.as_ref() != chosen {
                actions.push(Action::Edit(edit(new)));
            }
        });
        combo
            .response
            .labelled_by(label.id)
            .on_hover_text(words.hint);
    });
}
