//! How the features of a vector layer are drawn.

mod classes;

use eframe::egui::{self, TextEdit, Ui, WidgetInfo};
use relievo_engine::project::{
    Casing, Edit, Extra, Extrude, Hatch, Label, LayerId, PointSymbol, Symbol, VectorStyle, Width,
    WidthUnit,
};
use relievo_engine::vector::Features;

use crate::window::action::Action;
use crate::window::controls::{self, Number};

const FILL_OPACITY: Number =
    Number::new("Fill opacity", "How much the fill covers", 0.0..=1.0, 1.0);
const STROKE_PX: Number =
    Number::new("Line width", "Width of lines", 0.0..=64.0, 1.0).unit(" px", 2);
const STROKE_M: Number = Number::new(
    "Line width",
    "Width of lines on the ground",
    0.0..=10_000.0,
    1.0,
)
.unit(" m", 2)
.logarithmic();
const CASING: Number = Number::new(
    "Casing",
    "How far a wider line stands out below",
    0.0..=64.0,
    1.0,
)
.unit(" px", 2);
const SPACING: Number = Number::new(
    "Hatch",
    "Distance between the lines across areas",
    1.0..=256.0,
    8.0,
)
.unit(" px", 1);
const ANGLE: Number = Number::new(
    "Hatch angle",
    "Direction of these lines, clockwise from north",
    0.0..=180.0,
    45.0,
)
.unit("°", 1);
const SIZE: Number =
    Number::new("Symbol size", "Diameter of symbols", 1.0..=128.0, 6.0).unit(" px", 1);
const LETTERS: Number =
    Number::new("Letters", "Height of letters", 4.0..=200.0, 12.0).unit(" px", 1);

const BODY_M: Number = Number::new(
    "Height",
    "Height of bodies above the ground",
    0.0..=1000.0,
    10.0,
)
.unit(" m", 1);

const STANDINGS: [(Standing, &str); 3] = [
    (Standing::Flat, "lie on the ground"),
    (Standing::AllAlike, "stand, all alike"),
    (Standing::ByProperty, "stand, by a property"),
];

const UNITS: [(WidthUnit, &str); 2] = [
    (WidthUnit::Pixels, "pixels on the screen"),
    (WidthUnit::Metres, "metres on the ground"),
];

const SYMBOLS: [(Option<Symbol>, &str); 7] = [
    (None, "None"),
    (Some(Symbol::Circle), "Disc"),
    (Some(Symbol::Square), "Square"),
    (Some(Symbol::Diamond), "Diamond"),
    (Some(Symbol::Triangle), "Triangle"),
    (Some(Symbol::Cross), "Cross"),
    (Some(Symbol::Star), "Star"),
];

/// Draws it.
///
/// `features`: those of the file, once it is open.
pub(crate) fn show(
    ui: &mut Ui,
    id: &LayerId,
    style: &VectorStyle,
    features: Option<&Features>,
    actions: &mut Vec<Action>,
) {
    let set = |change: &dyn Fn(&mut VectorStyle)| {
        let mut style = style.clone();
        change(&mut style);
        Edit::SetVectorStyle {
            id: id.clone(),
            style: Box::new(style),
        }
    };
    if let Some(fill) = colour(ui, "Fill", style.fill) {
        actions.push(Action::Edit(set(&|s| s.fill = fill)));
    }
    if style.fill.is_some() {
        controls::number(ui, &FILL_OPACITY, style.fill_opacity, actions, |v| {
            set(&|s| s.fill_opacity = v)
        });
    }
    if let Some(stroke) = colour(ui, "Lines", style.stroke) {
        actions.push(Action::Edit(set(&|s| s.stroke = stroke)));
    }
    if style.stroke.is_some() {
        let width = &style.stroke_width;
        let number = if width.unit == WidthUnit::Metres {
            &STROKE_M
        } else {
            &STROKE_PX
        };
        controls::number(ui, number, width.value, actions, |v| {
            set(&|s| s.stroke_width.value = v)
        });
        let hint = "Metres grow when one comes nearer, pixels do not";
        controls::choice(ui, "Width in", hint, &UNITS, width.unit, actions, |unit| {
            set(&|s| s.stroke_width.unit = unit)
        });
        dashes(ui, style, &set, actions);
    }
    if let Some(casing) = colour(ui, "Casing", style.casing.as_ref().map(|c| c.colour)) {
        let width = style
            .casing
            .as_ref()
            .map_or_else(|| Width::px(1.0), |c| c.width.clone());
        actions.push(Action::Edit(set(&|s| {
            s.casing = casing.map(|colour| Casing {
                colour,
                width: width.clone(),
                extra: Extra::new(),
            });
        })));
    }
    if let Some(casing) = &style.casing {
        controls::number(ui, &CASING, casing.width.value, actions, |v| {
            set(&|s| {
                if let Some(casing) = &mut s.casing {
                    casing.width.value = v;
                }
            })
        });
    }
    classes::show(ui, id, style, features, &set, actions);
    hatch(ui, style, &set, actions);
    symbol(ui, style, &set, actions);
    bodies(ui, style, &set, actions);
    label(ui, style, &set, actions);
}

type Set<'a> = dyn Fn(&dyn Fn(&mut VectorStyle)) -> Edit + 'a;

/// Solid, or strokes and gaps of four and three widths.
fn dashes(ui: &mut Ui, style: &VectorStyle, set: &Set<'_>, actions: &mut Vec<Action>) {
    let mut dashed = !style.dash.is_empty();
    let hint = "Strokes and gaps of four and three line widths";
    if ui
        .checkbox(&mut dashed, "Dashed")
        .on_hover_text(hint)
        .changed()
    {
        let width = style.stroke_width.value.max(0.1);
        let dash = if dashed {
            vec![4.0 * width, 3.0 * width]
        } else {
            Vec::new()
        };
        actions.push(Action::Edit(set(&|s| s.dash.clone_from(&dash))));
    }
}

fn hatch(ui: &mut Ui, style: &VectorStyle, set: &Set<'_>, actions: &mut Vec<Action>) {
    let mut hatched = style.hatch.is_some();
    let hint = "Parallel lines across areas";
    if ui
        .checkbox(&mut hatched, "Hatched")
        .on_hover_text(hint)
        .changed()
    {
        actions.push(Action::Edit(set(&|s| {
            s.hatch = hatched.then(|| Hatch {
                spacing: Width::px(8.0),
                angle_deg: 45.0,
                colour: None,
                width: Width::px(1.0),
                cross: false,
                extra: Extra::new(),
            });
        })));
    }
    let Some(hatch) = &style.hatch else { return };
    let change = |change: &dyn Fn(&mut Hatch)| {
        set(&|s| {
            if let Some(hatch) = &mut s.hatch {
                change(hatch);
            }
        })
    };
    controls::number(ui, &SPACING, hatch.spacing.value, actions, |v| {
        change(&|h| h.spacing.value = v)
    });
    let angle = hatch.angle_deg.rem_euclid(180.0);
    controls::number(ui, &ANGLE, angle, actions, |v| change(&|h| h.angle_deg = v));
}

fn symbol(ui: &mut Ui, style: &VectorStyle, set: &Set<'_>, actions: &mut Vec<Action>) {
    let now = style.point.as_ref().map(|p| p.symbol);
    let hint = "What stands at points";
    controls::choice(ui, "Symbol", hint, &SYMBOLS, now, actions, |symbol| {
        set(&|s| {
            s.point = symbol.map(|symbol| PointSymbol {
                symbol,
                ..s.point.clone().unwrap_or_default()
            });
        })
    });
    if let Some(point) = &style.point {
        controls::number(ui, &SIZE, point.size.value, actions, |v| {
            set(&|s| {
                if let Some(point) = &mut s.point {
                    point.size.value = v;
                }
            })
        });
    }
}

/// The name of a property as text; what it becomes, once somebody is through with it.
fn property(ui: &mut Ui, name: &str, help: &str, shown: &str) -> Option<String> {
    let row = ui.horizontal(|ui| {
        let label = controls::name(ui, name, !shown.is_empty());
        let key = ui.scope_id().with(name);
        let mut text = ui
            .data(|d| d.get_temp::<String>(key))
            .unwrap_or_else(|| shown.to_owned());
        let field = TextEdit::singleline(&mut text)
            .desired_width(f32::INFINITY)
            .char_limit(250)
            .hint_text("a property, such as name");
        let field = ui.add(field).labelled_by(label.id).on_hover_text(help);
        if field.has_focus() {
            ui.data_mut(|d| d.insert_temp(key, text.clone()));
        } else {
            ui.data_mut(|d| d.remove::<String>(key));
        }
        let kept = field.lost_focus() && !ui.input(|i| i.key_pressed(egui::Key::Escape));
        let text = text.trim();
        (kept && text != shown).then(|| text.to_owned())
    });
    row.inner
}

/// How areas stand.
#[derive(Clone, Copy, PartialEq)]
enum Standing {
    Flat,
    AllAlike,
    ByProperty,
}

/// Areas as bodies on the ground.
fn bodies(ui: &mut Ui, style: &VectorStyle, set: &Set<'_>, actions: &mut Vec<Action>) {
    let standing = match &style.extrude {
        None => Standing::Flat,
        Some(Extrude::HeightM(_)) => Standing::AllAlike,
        Some(Extrude::Property(_)) => Standing::ByProperty,
    };
    let hint = "Whether areas lie on the ground or stand on it as bodies, such as buildings";
    controls::choice(
        ui,
        "Areas",
        hint,
        &STANDINGS,
        standing,
        actions,
        |standing| {
            set(&|s| {
                s.extrude = match standing {
                    Standing::Flat => None,
                    Standing::AllAlike => Some(Extrude::HeightM(10.0)),
                    Standing::ByProperty => Some(Extrude::Property("height".to_owned())),
                };
            })
        },
    );
    match &style.extrude {
        None => {}
        Some(Extrude::HeightM(height_m)) => {
            controls::number(ui, &BODY_M, *height_m, actions, |v| {
                set(&|s| s.extrude = Some(Extrude::HeightM(v)))
            });
        }
        Some(Extrude::Property(name)) => {
            let help = "The property that holds each area's height in metres";
            let new = property(ui, "Height from", help, name).filter(|name| !name.is_empty());
            actions.extend(new.map(|name| {
                Action::Edit(set(&|s| s.extrude = Some(Extrude::Property(name.clone()))))
            }));
        }
    }
}

/// The property whose values stand as texts at features.
fn label(ui: &mut Ui, style: &VectorStyle, set: &Set<'_>, actions: &mut Vec<Action>) {
    let shown = style.label.as_ref().map_or("", |l| l.property.as_str());
    let help = "The property whose values stand as texts at features; empty: none";
    if let Some(name) = property(ui, "Texts from", help, shown) {
        actions.push(Action::Edit(set(&|s| {
            s.label = (!name.is_empty()).then(|| Label {
                property: name.clone(),
                ..s.label.clone().unwrap_or(Label {
                    property: String::new(),
                    size_px: 12.0,
                    colour: [20; 3],
                    halo: Some([255; 3]),
                    extra: Extra::new(),
                })
            });
        })));
    }
    if let Some(label) = &style.label {
        controls::number(ui, &LETTERS, label.size_px, actions, |v| {
            set(&|s| {
                if let Some(label) = &mut s.label {
                    label.size_px = v;
                }
            })
        });
    }
}

/// A colour that may be absent; what it becomes, if it changes.
#[expect(
    clippy::option_option,
    reason = "whether it changes, and to which colour if any"
)]
pub(crate) fn colour(ui: &mut Ui, name: &str, value: Option<[u8; 3]>) -> Option<Option<[u8; 3]>> {
    ui.horizontal(|ui| {
        let mut on = value.is_some();
        let tick = ui.checkbox(&mut on, name);
        let changed = tick.on_hover_text("Whether it is painted").changed();
        let mut new = value.unwrap_or([200, 200, 200]);
        if on && !changed {
            let button = ui.color_edit_button_srgb(&mut new);
            let label = format!("Colour of the {}", name.to_lowercase());
            button.widget_info(|| WidgetInfo::labeled(egui::Role::ColorWell, true, &label));
        }
        let new = on.then_some(new);
        (new != value).then_some(new)
    })
    .inner
}
