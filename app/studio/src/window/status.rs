//! The status bar: what is under the pointer, where the viewer is, what is still to come.

use eframe::egui::{Align, Button, Label, Layout, RichText, Spinner, Ui};
use relievo_engine::planet::MapPoint;

use super::action::Action;
use super::panes::Pane;
use crate::commands::Command;

/// How coordinates are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Notation {
    /// 40.25000° N
    #[default]
    Decimal,
    /// 40°15′00.0″ N
    Sexagesimal,
}

/// The ground under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pointed {
    /// Where.
    pub(crate) point: MapPoint,
    /// Height of the drawn ground, metres.
    pub(crate) drawn_m: f64,
    /// Height, slope in degrees and spacing in metres at the data's own resolution, once known.
    pub(crate) measured: Option<(f64, Option<f64>, f64)>,
}

/// Everything that the bar shows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Status {
    /// What is under the pointer; `None` for the sky and outside of the viewport.
    pub(crate) pointed: Option<Pointed>,
    /// Height of the eye above the drawn ground, metres.
    pub(crate) above_ground_m: f64,
    /// Visible tiles to come.
    pub(crate) pending: usize,
    /// Files being opened.
    pub(crate) opening: usize,
    /// What the thread that draws did for the latest frame, milliseconds.
    pub(crate) frame_ms: f64,
    /// What the device did for it, milliseconds.
    pub(crate) gpu_ms: Option<f64>,
    /// Triangles of the latest frame.
    pub(crate) triangles: u64,
    /// Name of the adapter.
    pub(crate) adapter: String,
    /// Problems that are listed.
    pub(crate) problems: usize,
}

/// Draws the bar.
pub(crate) fn show(
    ui: &mut Ui,
    status: &Status,
    notation: &mut Notation,
    actions: &mut Vec<Action>,
) {
    ui.horizontal_centered(|ui| {
        place(ui, status, notation);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if status.problems > 0 {
                let text = if status.problems == 1 { "1 problem".to_owned() } else { format!("{} problems", status.problems) };
                let text = RichText::new(text).color(ui.visuals().warn_fg_color);
                if ui.add(Button::new(text).frame(false)).on_hover_text("Show or hide the messages").clicked() {
                    actions.push(Action::Run(Command::Toggle(Pane::Messages)));
                }
                ui.separator();
            }
            let gpu = status.gpu_ms.map(|ms| format!(" + {ms:.1}")).unwrap_or_default();
            let hint = format!(
                "Milliseconds of the latest frame: this program + graphics device\n{} triangles\n{}",
                status.triangles, status.adapter
            );
            ui.add(Label::new(format!("{:.1}{gpu} ms", status.frame_ms)).selectable(false)).on_hover_text(hint);
            ui.separator();
            activity(ui, status);
            ui.separator();
            let text = format!("{} above ground", length(status.above_ground_m));
            ui.add(Label::new(text).selectable(false)).on_hover_text("Height of the eye above the drawn ground");
        });
    });
}

fn place(ui: &mut Ui, status: &Status, notation: &mut Notation) {
    let Some(pointed) = &status.pointed else {
        ui.weak("Point at the ground to see coordinates and height");
        return;
    };
    let (lon_deg, lat_deg) = pointed.point.to_degrees();
    let text = coordinates(lon_deg, lat_deg, *notation);
    let hint = "Latitude and longitude under the pointer. Click for decimal degrees or degrees, minutes, seconds.";
    if ui
        .add(Button::new(RichText::new(text).monospace()).frame(false))
        .on_hover_text(hint)
        .clicked()
    {
        *notation = match notation {
            Notation::Decimal => Notation::Sexagesimal,
            Notation::Sexagesimal => Notation::Decimal,
        };
    }
    ui.separator();
    if let Some((height_m, slope_deg, spacing_m)) = pointed.measured {
        let slope = slope_deg
            .map(|s| format!("  slope {s:.1}°"))
            .unwrap_or_default();
        let text = RichText::new(format!("{height_m:.1} m{slope}"));
        let hint = format!(
            "Height above the datum and slope, evaluated at the data's resolution ({})",
            length(spacing_m)
        );
        ui.add(Label::new(text).selectable(false))
            .on_hover_text(hint);
    } else {
        let text = RichText::new(format!("≈ {:.0} m", pointed.drawn_m)).weak();
        ui.add(Label::new(text).selectable(false))
            .on_hover_text("Height above the datum, as drawn");
    }
}

fn activity(ui: &mut Ui, status: &Status) {
    let text = match (status.opening, status.pending) {
        (0, 0) => {
            ui.add(Label::new(RichText::new("complete").weak()).selectable(false))
                .on_hover_text("Nothing is missing in the picture");
            return;
        }
        (0, 1) => "1 tile".to_owned(),
        (0, tiles) => format!("{tiles} tiles"),
        (1, _) => "opening 1 file".to_owned(),
        (files, _) => format!("opening {files} files"),
    };
    ui.add(Label::new(text).selectable(false))
        .on_hover_text("Visible tiles that are still being made");
    ui.add(Spinner::new().size(12.0));
}

/// A length for people: metres below 10 km.
pub(crate) fn length(metres: f64) -> String {
    match metres.abs() {
        m if m < 10.0 => format!("{metres:.2} m"),
        m if m < 10_000.0 => format!("{metres:.0} m"),
        m if m < 1e6 => format!("{:.1} km", metres / 1e3),
        _ => format!("{:.0} km", metres / 1e3),
    }
}

/// An area for people: square metres below a hectare, square kilometres above a hundred of them.
pub(crate) fn area(square_m: f64) -> String {
    match square_m {
        a if a < 1e4 => format!("{a:.1} m²"),
        a if a < 1e6 => format!("{:.2} ha", a / 1e4),
        a if a < 1e9 => format!("{:.2} km²", a / 1e6),
        a => format!("{:.0} km²", a / 1e6),
    }
}

/// Latitude and longitude for people.
pub(crate) fn coordinates(lon_deg: f64, lat_deg: f64, notation: Notation) -> String {
    let north = if lat_deg < 0.0 { "S" } else { "N" };
    let east = if lon_deg < 0.0 { "W" } else { "E" };
    let angle = |deg: f64| match notation {
        Notation::Decimal => format!("{:.5}°", deg.abs()),
        Notation::Sexagesimal => sexagesimal(deg.abs()),
    };
    format!("{} {north}  {} {east}", angle(lat_deg), angle(lon_deg))
}

/// Degrees, minutes and seconds of an angle that is not negative, rounded once.
fn sexagesimal(deg: f64) -> String {
    let tenths = (deg * 36_000.0).round() as u64;
    let (degrees, rest) = (tenths / 36_000, tenths % 36_000);
    format!(
        "{degrees}°{:02}′{:02}.{}″",
        rest / 600,
        rest % 600 / 10,
        rest % 10
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_written_both_ways() {
        assert_eq!(
            coordinates(-111.65, 40.25, Notation::Decimal),
            "40.25000° N  111.65000° W"
        );
        assert_eq!(
            coordinates(-111.65, -40.25, Notation::Sexagesimal),
            "40°15′00.0″ S  111°39′00.0″ W"
        );
    }

    #[test]
    fn seconds_are_rounded_up_to_whole_minutes_and_degrees() {
        assert_eq!(sexagesimal(9.999_999_9), "10°00′00.0″");
        assert_eq!(sexagesimal(0.016_666_6), "0°01′00.0″");
    }

    #[test]
    fn areas_take_the_unit_that_reads_best() {
        assert_eq!(area(12.34), "12.3 m²");
        assert_eq!(area(25_000.0), "2.50 ha");
        assert_eq!(area(3_456_000.0), "3.46 km²");
        assert_eq!(area(5.1e14), "510000000 km²");
    }

    #[test]
    fn lengths_take_the_unit_that_reads_best() {
        assert_eq!(length(1.234), "1.23 m");
        assert_eq!(length(1234.0), "1234 m");
        assert_eq!(length(12_345.0), "12.3 km");
        assert_eq!(length(12_345_678.0), "12346 km");
    }
}
