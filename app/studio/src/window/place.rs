//! What made the ground under the pointer.

use eframe::egui::{Grid, RichText, ScrollArea, Ui};
use relievo_engine::project::{ElementId, LayerId, Project};
use relievo_engine::{Maker, PlaceAnswer};

use super::layers;
use super::status::{Notation, coordinates, length};

/// Draws what is known of a place; `None`: nothing is pointed at, or the answer is still to come.
pub(crate) fn show(
    ui: &mut Ui,
    project: &Project,
    notation: Notation,
    place: Option<&PlaceAnswer>,
) {
    let Some(place) = place else {
        ui.add_space(4.0);
        ui.weak("Rest the pointer on the ground to see what made it.");
        return;
    };
    let rows = ScrollArea::vertical().auto_shrink([false, false]);
    rows.show(ui, |ui| {
        Grid::new("place")
            .num_columns(2)
            .spacing([12.0, 3.0])
            .show(ui, |ui| {
                let mut row = |name: &str, text: String| {
                    ui.weak(name);
                    ui.label(text);
                    ui.end_row();
                };
                row("Place", coordinates(place.lon_deg, place.lat_deg, notation));
                row("Height", format!("{:.2} m", place.height_m));
                if let (Some(data_m), Some(below_m)) =
                    (place.data_height_m, place.synthesised_below_m)
                {
                    let finer = length(below_m);
                    row("Synthesised", format!("what is shorter than {finer}"));
                    row("By the data", format!("{data_m:.2} m"));
                }
                if let Some(slope) = place.slope_deg {
                    row("Slope", format!("{slope:.1}°"));
                }
                if let Some([r, g, b, a]) = place.colour {
                    row(
                        "Colour",
                        format!(
                            "#{r:02x}{g:02x}{b:02x}, opacity {:.0} %",
                            f64::from(a) / 2.55
                        ),
                    );
                }
                if let (Some([r, g, b, _]), Some(below_m)) =
                    (place.data_colour, place.colour_synthesised_below_m)
                {
                    let finer = length(below_m);
                    row("Synthesised", format!("patterns shorter than {finer}"));
                    row("By the files", format!("#{r:02x}{g:02x}{b:02x}"));
                }
                row("Spacing", length(place.spacing_m));
            });
        makers(ui, "Height made by", project, &place.height_made_by);
        makers(ui, "Colour made by", project, &place.colour_made_by);
    });
}

/// Nodes in order of evaluation, with the names of their layers and of elements that decide.
fn makers(ui: &mut Ui, title: &str, project: &Project, makers: &[Maker]) {
    if makers.is_empty() {
        return;
    }
    ui.add_space(4.0);
    ui.label(RichText::new(title).strong());
    for (at, maker) in makers.iter().enumerate() {
        let layer = maker.layer.as_ref().map(|id| LayerId(id.clone()));
        let name = layer.map_or_else(String::new, |id| {
            let name = project.layer(&id).map_or(id.0, layers::name_of);
            format!(" of {name}")
        });
        let element = maker.element.as_ref().map(|id| {
            let id = ElementId(id.clone());
            let element = project.element_in(project.scenario.as_ref(), &id);
            let name = element.map_or(id.0.clone(), |e| e.name.clone());
            let part = maker
                .part
                .map_or_else(String::new, |part| format!("{part} of "));
            format!(", {part}{name}")
        });
        let element = element.unwrap_or_default();
        ui.label(format!("{}. {}{name}{element}", at + 1, maker.node));
    }
}
