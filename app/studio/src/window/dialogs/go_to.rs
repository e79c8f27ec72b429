//! Where to fly: coordinates, or a place by its name.

use eframe::egui::{self, DragValue, Grid, Key, RichText, TextEdit, Ui, WidgetInfo};
use relievo_engine::planet::Camera;
use relievo_engine::project::Body;
use relievo_engine::vector::places::{self, Place};

use super::Answer;

/// Places that are offered.
const OFFERED: usize = 6;

/// Height over a place that is flown to, metres.
const OVER_PLACE_M: f64 = 25_000.0;

/// A camera as people write it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Destination {
    lon_deg: f64,
    lat_deg: f64,
    altitude_m: f64,
    heading_deg: f64,
    pitch_deg: f64,
    /// A name that is being typed; `None` on planets without names.
    place: Option<String>,
}

impl Destination {
    /// The values of a camera.
    pub(crate) fn of(camera: &Camera, body: Body) -> Self {
        Self {
            lon_deg: camera.lon_rad.to_degrees(),
            lat_deg: camera.lat_rad.to_degrees(),
            altitude_m: camera.altitude_m,
            heading_deg: camera.heading_rad.to_degrees(),
            pitch_deg: camera.pitch_rad.to_degrees(),
            place: (body == Body::Earth).then(String::new),
        }
    }

    /// The camera, with the field of view of another.
    pub(crate) fn camera(&self, like: &Camera) -> Camera {
        Camera {
            lon_rad: self.lon_deg.to_radians(),
            lat_rad: self.lat_deg.to_radians(),
            altitude_m: self.altitude_m,
            heading_rad: self.heading_deg.to_radians(),
            pitch_rad: self.pitch_deg.to_radians(),
            fov_y_rad: like.fov_y_rad,
        }
    }
}

/// A field for a name and the places that have it; Enter takes the first.
fn places(ui: &mut Ui, to: &mut Destination) -> Option<Answer> {
    let place = to.place.as_mut()?;
    let field = TextEdit::singleline(place)
        .desired_width(f32::INFINITY)
        .hint_text("City or town, such as Grenoble or Paris, FRA");
    let field = ui.add(field);
    field.widget_info(|| WidgetInfo::labeled(egui::Role::TextInput, true, "Place"));
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    let found = places::find(place, OFFERED);
    if found.is_empty() && !place.trim().is_empty() {
        ui.weak("No place of this name is known here.");
    }
    let mut chosen: Option<&Place> = found.first().copied().filter(|_| entered);
    for place in found {
        let (lon, lat) = place.at.to_degrees();
        let text = format!("{}, {}", place.name, place.country);
        let hint = format!("{lat:.3}°, {lon:.3}°; {} people", place.people);
        if ui.button(text).on_hover_text(hint).clicked() {
            chosen = Some(place);
        }
    }
    let (lon_deg, lat_deg) = chosen?.at.to_degrees();
    Some(Answer::GoTo(Destination {
        lon_deg,
        lat_deg,
        altitude_m: OVER_PLACE_M,
        heading_deg: 0.0,
        pitch_deg: -90.0,
        place: None,
    }))
}

/// Draws the question; the answer once it is there.
pub(super) fn show(ui: &mut Ui, to: &mut Destination) -> Option<Answer> {
    ui.heading("Go to");
    if let Some(answer) = places(ui, to) {
        return Some(answer);
    }
    ui.add_space(6.0);
    ui.add_space(4.0);
    Grid::new("destination")
        .num_columns(2)
        .spacing([12.0, 6.0])
        .show(ui, |ui| {
            field(
                ui,
                "Longitude",
                "Degrees, east positive, -180 to 180",
                &mut to.lon_deg,
                -180.0..=180.0,
                "°",
                0.1,
            );
            field(
                ui,
                "Latitude",
                "Degrees, north positive, -90 to 90",
                &mut to.lat_deg,
                -90.0..=90.0,
                "°",
                0.1,
            );
            let speed = (to.altitude_m.abs() * 0.01).max(1.0);
            field(
                ui,
                "Altitude",
                "Metres above the datum",
                &mut to.altitude_m,
                -10_000.0..=1e8,
                " m",
                speed,
            );
            field(
                ui,
                "Heading",
                "Degrees clockwise from north, 0 to 360",
                &mut to.heading_deg,
                0.0..=360.0,
                "°",
                1.0,
            );
            field(
                ui,
                "Pitch",
                "Degrees: -90 looks down, 0 to the horizon",
                &mut to.pitch_deg,
                -90.0..=89.0,
                "°",
                1.0,
            );
        });
    ui.add_space(8.0);
    let entered = ui.input(|i| i.key_pressed(Key::Enter)) && !ui.ctx().text_edit_focused();
    super::buttons(ui, |ui| {
        let go = ui.button(RichText::new("Go").strong()).clicked() || entered;
        let cancel = ui.button("Cancel").clicked();
        if go {
            Some(Answer::GoTo(to.clone()))
        } else {
            cancel.then_some(Answer::Cancel)
        }
    })
}

fn field(
    ui: &mut Ui,
    name: &str,
    hint: &str,
    value: &mut f64,
    range: core::ops::RangeInclusive<f64>,
    unit: &str,
    speed: f64,
) {
    let label = ui.label(name);
    let field = DragValue::new(value)
        .range(range)
        .speed(speed)
        .suffix(unit)
        .max_decimals(6);
    ui.add(field).labelled_by(label.id).on_hover_text(hint);
    ui.end_row();
}
