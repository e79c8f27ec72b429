//! The day that series of layers are shown at.

use eframe::egui::{Slider, Ui};
use relievo_engine::project::{Date, Edit, Project, parse_date};

use crate::window::action::Action;
use crate::window::controls;

const LATEST: &str = "latest";
const HINT: &str =
    "The day that series of layers are shown at; at the right end the latest picture of each";

/// Draws a slider over all days that layers have, if any has one.
pub(super) fn show(ui: &mut Ui, project: &Project, actions: &mut Vec<Action>) {
    let dates = project.dates();
    if dates.is_empty() {
        return;
    }
    let latest = dates.len();
    let now = position(&dates, project.date);
    let mut new = now;
    ui.horizontal(|ui| {
        let name = controls::name(ui, "Date", project.date.is_some()).on_hover_text(HINT);
        ui.spacing_mut().slider_width = (ui.available_width() - 96.0).max(40.0);
        let text = |at: f64| {
            let date = dates.get(at.round().max(0.0) as usize);
            date.map_or(LATEST.to_owned(), Date::to_string)
        };
        let slider = Slider::new(&mut new, 0..=latest)
            .custom_formatter(|at, _| text(at))
            .custom_parser(|typed| {
                let date = parse_date(typed.trim());
                let at = date.map(|date| position(&dates, Some(date)));
                at.or((typed.trim() == LATEST).then_some(latest))
                    .map(|at| at as f64)
            });
        let response = ui.add(slider).labelled_by(name.id).on_hover_text(HINT);
        if response.drag_started() {
            actions.push(Action::BeginDrag);
        }
        if name.double_clicked() {
            new = latest;
        }
        if new != now {
            let date = dates.get(new).copied();
            actions.push(Action::Edit(Edit::ShowDate { date }));
        }
        if response.drag_stopped() {
            actions.push(Action::EndDrag);
        }
    });
}

/// The last of the dates that is not after a day; past all of them without a day.
fn position(dates: &[Date], shown: Option<Date>) -> usize {
    shown.map_or(dates.len(), |shown| {
        dates
            .partition_point(|date| *date <= shown)
            .saturating_sub(1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_between_two_shows_the_earlier_one() {
        let dates: Vec<Date> = ["2010-06-29", "2015-09-26"]
            .into_iter()
            .filter_map(parse_date)
            .collect();
        let at = |text: &str| position(&dates, parse_date(text));
        assert_eq!(
            [at("2010-06-29"), at("2012-01-01"), at("2020-01-01")],
            [0, 0, 1]
        );
        assert_eq!(position(&dates, None), 2);
        assert_eq!(at("1999-01-01"), 0, "nothing is earlier");
    }
}
