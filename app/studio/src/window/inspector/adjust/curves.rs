//! Tone curves: points that are dragged, typed or moved by keys.

mod points;

use eframe::egui::{
    self, ComboBox, DragValue, Event, EventFilter, Key, Pos2, Rect, Response, Role, Sense, Shape,
    Stroke, Ui, WidgetInfo, pos2, vec2,
};
use relievo_engine::graph::nodes::Curve;
use relievo_engine::project::{Adjust, CurvePoint, LayerId, ToneCurves};

use super::changed;
use crate::commands::uses_keys;
use crate::window::action::Action;
use crate::window::controls;
use points::{added, moved, removed};

const HINT: &str = "What display values become: left black, right white, upwards lighter. Click to add a point, drag to \
                    move it, double-click to remove it. Keys: Left and Right choose a point, Up and Down move it \
                    (Shift: ten times as far), Insert adds one, Delete removes it";

/// Height of the curve in points at most.
const MOST_SIDE: f32 = 190.0;

/// A point is hit within this distance, in points.
const REACH: f32 = 9.0;

/// What a key moves a point by.
const STEP: f64 = 0.01;

/// Whose curve is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Channel {
    #[default]
    All,
    Red,
    Green,
    Blue,
}

impl Channel {
    const ALL: [Self; 4] = [Self::All, Self::Red, Self::Green, Self::Blue];

    fn name(self) -> &'static str {
        match self {
            Self::All => "All channels",
            Self::Red => "Red",
            Self::Green => "Green",
            Self::Blue => "Blue",
        }
    }

    fn of(self, curves: &ToneCurves) -> &Vec<CurvePoint> {
        match self {
            Self::All => &curves.all,
            Self::Red => &curves.channels[0],
            Self::Green => &curves.channels[1],
            Self::Blue => &curves.channels[2],
        }
    }

    fn of_mut(self, curves: &mut ToneCurves) -> &mut Vec<CurvePoint> {
        match self {
            Self::All => &mut curves.all,
            Self::Red => &mut curves.channels[0],
            Self::Green => &mut curves.channels[1],
            Self::Blue => &mut curves.channels[2],
        }
    }

    fn colour(self, ui: &Ui) -> egui::Color32 {
        match self {
            Self::All => ui.visuals().strong_text_color(),
            Self::Red => egui::Color32::from_rgb(225, 80, 75),
            Self::Green => egui::Color32::from_rgb(70, 175, 90),
            Self::Blue => egui::Color32::from_rgb(80, 140, 235),
        }
    }
}

/// What is remembered from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
struct Chosen {
    channel: Channel,
    /// A point of its curve.
    point: Option<usize>,
}

/// Draws the curve of a channel and takes what is done to it.
pub(super) fn show(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    let key = ui.make_persistent_id(("tone curves", &id.0));
    let mut chosen: Chosen = ui.data(|d| d.get_temp(key)).unwrap_or_default();
    ui.horizontal(|ui| {
        let label = controls::name(ui, "Curve of", false);
        let combo = ComboBox::from_id_salt("curve of")
            .selected_text(chosen.channel.name())
            .width(ui.available_width() - 8.0);
        let shown = combo.show_ui(ui, |ui| {
            for channel in Channel::ALL {
                let bent = !channel.of(&adjust.curves).is_empty();
                let name = format!("{}{}", channel.name(), if bent { " •" } else { "" });
                if ui
                    .selectable_label(chosen.channel == channel, name)
                    .clicked()
                {
                    chosen = Chosen {
                        channel,
                        point: None,
                    };
                }
            }
        });
        let hint = "The common curve comes first, then that of each channel";
        shown.response.labelled_by(label.id).on_hover_text(hint);
    });
    let points = chosen.channel.of(&adjust.curves);
    chosen.point = chosen.point.filter(|i| *i < points.len());
    let mut new = None;
    let response = plane(ui, points, &mut chosen, &mut new);
    if response.drag_started() {
        actions.push(Action::BeginDrag);
    }
    fields(ui, points, &mut chosen, &mut new, actions);
    if let Some(new) = new
        && new != *points
    {
        let channel = chosen.channel;
        let edit = changed(id, adjust, |a| *channel.of_mut(&mut a.curves) = new);
        actions.push(edit);
    }
    if response.drag_stopped() {
        actions.push(Action::EndDrag);
    }
    ui.data_mut(|d| d.insert_temp(key, chosen));
}

/// The plane of inputs and outputs, the curve and its points.
fn plane(
    ui: &mut Ui,
    points: &[CurvePoint],
    chosen: &mut Chosen,
    new: &mut Option<Vec<CurvePoint>>,
) -> Response {
    let side = (ui.available_width() - 8.0).clamp(80.0, MOST_SIDE);
    let (outer, response) = ui.allocate_exact_size(vec2(side, side), Sense::click_and_drag());
    let rect = outer.shrink(6.0);
    let response = response.on_hover_text(HINT);
    let name = format!(
        "Tone curve of {}, {} points",
        chosen.channel.name().to_lowercase(),
        points.len()
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, &name));
    let at = response.interact_pointer_pos();
    let hit = |at: Pos2| {
        let distance = |i: &usize| to_screen(rect, &points[*i]).distance(at);
        let nearest = (0..points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.filter(|i| distance(i) <= REACH)
    };
    if let (Some(at), true) = (at, response.double_clicked()) {
        if let Some(i) = hit(at) {
            *new = Some(removed(points, i));
            chosen.point = None;
        }
    } else if let (Some(at), true) = (at, response.drag_started() || response.clicked()) {
        response.request_focus();
        // Where the button went down, not where the pointer has moved meanwhile.
        let at = ui.input(|i| i.pointer.press_origin()).unwrap_or(at);
        chosen.point = hit(at);
        if chosen.point.is_none() {
            let (more, i) = added(points, from_screen(rect, at));
            (*new, chosen.point) = (Some(more), Some(i));
        }
    } else if let (Some(at), Some(i), true) = (at, chosen.point, response.dragged()) {
        *new = Some(moved(points, i, from_screen(rect, at)));
    }
    if response.has_focus() {
        let filter = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        uses_keys(ui.ctx(), response.id);
        if let Some(changed) = keys(ui, points, chosen) {
            *new = Some(changed);
        }
    }
    paint(ui, (outer, rect), new.as_deref().unwrap_or(points), chosen);
    if response.has_focus() {
        let ring = Stroke::new(1.0, ui.visuals().selection.stroke.color);
        ui.painter()
            .rect_stroke(outer, 2.0, ring, egui::StrokeKind::Inside);
    }
    response
}

/// What keys do to the chosen point.
fn keys(ui: &Ui, points: &[CurvePoint], chosen: &mut Chosen) -> Option<Vec<CurvePoint>> {
    let pressed = ui.input(|input| {
        let events = input.events.iter();
        let keys = events.filter_map(|event| {
            let Event::Key {
                key,
                pressed: true,
                modifiers,
                ..
            } = event
            else {
                return None;
            };
            Some((*key, modifiers.shift))
        });
        keys.collect::<Vec<_>>()
    });
    let mut new = None;
    for (key, shift) in pressed {
        let points = new.as_deref().unwrap_or(points);
        let last = points.len().checked_sub(1);
        let step = if shift { 10.0 * STEP } else { STEP };
        let lift = |up: f64| {
            let i = chosen.point?;
            let point = points.get(i)?;
            Some(moved(points, i, [point.input, point.output + up]))
        };
        match (key, last) {
            (Key::ArrowRight, Some(last)) => {
                chosen.point = Some(chosen.point.map_or(0, |i| (i + 1).min(last)));
            }
            (Key::ArrowLeft, Some(last)) => {
                chosen.point = Some(chosen.point.map_or(last, |i| i.saturating_sub(1)));
            }
            (Key::ArrowUp, _) => new = lift(step).or(new),
            (Key::ArrowDown, _) => new = lift(-step).or(new),
            (Key::Insert, _) => {
                let (more, i) = added(points, points::widest_gap(points));
                (new, chosen.point) = (Some(more), Some(i));
            }
            (Key::Delete, Some(_)) => {
                if let Some(i) = chosen.point.take() {
                    new = Some(removed(points, i));
                }
            }
            _ => {}
        }
    }
    new
}

/// Numbers of the chosen point, and what is done to the whole curve.
fn fields(
    ui: &mut Ui,
    points: &[CurvePoint],
    chosen: &mut Chosen,
    new: &mut Option<Vec<CurvePoint>>,
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        let chosen_point = chosen.point.and_then(|i| Some((i, points.get(i)?)));
        if let Some((i, point)) = chosen_point {
            let mut at = [point.input, point.output];
            let names = ["In", "Out"];
            for (value, name) in at.iter_mut().zip(names) {
                let label = ui.label(name);
                let field = DragValue::new(value)
                    .range(0.0..=1.0)
                    .speed(0.002)
                    .fixed_decimals(3);
                let hint = format!("{name}put of the chosen point, 0 to 1");
                let response = ui.add(field).labelled_by(label.id).on_hover_text(hint);
                if response.drag_started() {
                    actions.push(Action::BeginDrag);
                }
                if response.drag_stopped() {
                    actions.push(Action::EndDrag);
                }
            }
            if at != [point.input, point.output] {
                *new = Some(moved(points, i, at));
            }
        } else {
            let hint = "Without points the curve changes nothing";
            ui.weak("No point chosen").on_hover_text(hint);
        }
        let add = ui.button("Add");
        if add
            .on_hover_text("Add a point in the widest gap (Insert)")
            .clicked()
        {
            let (more, i) = added(points, points::widest_gap(points));
            (*new, chosen.point) = (Some(more), Some(i));
        }
        let straight = ui.add_enabled(!points.is_empty(), egui::Button::new("Straighten"));
        let hint = "Take all points of this curve away";
        if straight.on_hover_text(hint).clicked() {
            (*new, chosen.point) = (Some(Vec::new()), None);
        }
    });
}

fn to_screen(rect: Rect, point: &CurvePoint) -> Pos2 {
    place(rect, [point.input, point.output])
}

fn place(rect: Rect, [x, y]: [f64; 2]) -> Pos2 {
    pos2(
        egui::lerp(rect.left()..=rect.right(), x as f32),
        egui::lerp(rect.bottom()..=rect.top(), y as f32),
    )
}

fn from_screen(rect: Rect, at: Pos2) -> [f64; 2] {
    [
        f64::from((at.x - rect.left()) / rect.width()),
        f64::from((rect.bottom() - at.y) / rect.height()),
    ]
}

fn paint(ui: &Ui, (outer, rect): (Rect, Rect), points: &[CurvePoint], chosen: &Chosen) {
    let painter = ui.painter_at(outer);
    let visuals = ui.visuals();
    painter.rect_filled(outer, 2.0, visuals.extreme_bg_color);
    let faint = Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color);
    for part in 0..=4 {
        let v = f64::from(part) / 4.0;
        painter.line_segment([place(rect, [v, 0.0]), place(rect, [v, 1.0])], faint);
        painter.line_segment([place(rect, [0.0, v]), place(rect, [1.0, v])], faint);
    }
    painter.line_segment([place(rect, [0.0; 2]), place(rect, [1.0; 2])], faint);
    let pairs: Vec<[f64; 2]> = points.iter().map(|p| [p.input, p.output]).collect();
    let curve = Curve::through(&pairs);
    let columns = rect.width().max(2.0) as usize;
    let line = (0..=columns).map(|k| {
        let x = k as f64 / columns as f64;
        place(rect, [x, curve.at(x)])
    });
    let colour = chosen.channel.colour(ui);
    painter.add(Shape::line(line.collect(), Stroke::new(1.5, colour)));
    for (i, point) in points.iter().enumerate() {
        let at = to_screen(rect, point);
        if chosen.point == Some(i) {
            painter.circle(
                at,
                5.0,
                colour,
                Stroke::new(1.5, visuals.strong_text_color()),
            );
        } else {
            painter.circle(at, 4.0, visuals.extreme_bg_color, Stroke::new(1.5, colour));
        }
    }
}
