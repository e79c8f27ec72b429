//! Heights along a line: what is being measured, or the selected corridor or outline.
//!
//! The pointer in the plot marks its place on the terrain, and the pointer on the terrain its place in
//! the plot.

use std::fmt::Write as _;
use std::sync::Arc;

use eframe::egui::{Color32, Role, Ui, WidgetInfo};
use egui_plot::{Line, Plot, PlotPoints, Points, VLine};
use relievo_engine::analysis::Task;
use relievo_engine::planet::MapPoint;
use relievo_engine::{Profile, ProfileSettings};

use super::latest::Latest;
use super::status::length;
use super::studio::Studio;
use super::tools::view;
use super::waiting;

/// Points of a profile at most: more than any screen has pixels.
const MOST_POINTS: usize = 20_000;

/// A place of the terrain counts as on the line within this share of the line's length.
const NEAR: f64 = 0.02;

/// A line in a state of the project.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    line: Vec<MapPoint>,
    revision: u64,
}

/// The latest profile, or one line that says why there is none.
pub(crate) type Profiles = Latest<Wanted, Result<Arc<Profile>, String>>;

impl Studio {
    /// Draws the profile along what is being measured or is selected.
    pub(super) fn profile_pane(&mut self, ui: &mut Ui) {
        self.marked = None;
        let line = self.profile_line();
        if line.len() < 2 {
            ui.weak("Measure a way (M) or select an element to see heights along it.");
            return;
        }
        let wanted = Wanted {
            line,
            revision: self.state(),
        };
        if !ui.input(|i| i.pointer.any_down()) && self.status.opening == 0 {
            let engine = self.document.engine();
            self.profiles.ask(wanted.clone(), || {
                let (questions, wanted) = (engine.questions(), wanted.clone());
                move |task: &Task| {
                    let settings = ProfileSettings {
                        max_points: MOST_POINTS,
                        ..ProfileSettings::default()
                    };
                    let exact = questions.profile(&wanted.line, &settings, task);
                    let profile = exact.or_else(|_too_many| {
                        let way_m = questions.measure().length_m(&wanted.line);
                        let spacing_m = Some(way_m / (MOST_POINTS / 4) as f64);
                        let settings = ProfileSettings {
                            spacing_m,
                            ..settings
                        };
                        questions.profile(&wanted.line, &settings, task)
                    });
                    profile.map(Arc::new).map_err(|e| e.to_string())
                }
            });
        }
        waiting::show(ui, &mut self.profiles, "The profile");
        match self.profiles.last().map(|last| last.answer) {
            Some(Ok(profile)) => self.plot(ui, &profile),
            Some(Err(reason)) => {
                ui.colored_label(ui.visuals().error_fg_color, reason);
            }
            None => {}
        }
    }

    /// The draft of a line, or else the selected element's line.
    fn profile_line(&self) -> Vec<MapPoint> {
        if self.tools.draft.len() > 1 {
            return self.tools.draft.iter().map(view::place).collect();
        }
        let element = self.selected_element();
        let lists = element.as_ref().map(|e| e.vertex_lists());
        let list = lists.and_then(|lists| lists.first().map(|l| (*l).clone()));
        list.map(|l| l.as_slice().iter().map(view::place).collect())
            .unwrap_or_default()
    }

    fn plot(&mut self, ui: &mut Ui, profile: &Profile) {
        ui.horizontal_wrapped(|ui| {
            let range = profile.range_m.map_or_else(String::new, |(low, high)| {
                format!(", {low:.1} to {high:.1} m")
            });
            ui.weak(format!(
                "{} along, {} on the ground{range}, climbs {:.1} m, falls {:.1} m, steepest {:.1} %",
                length(profile.length_m),
                length(profile.surface_length_m),
                profile.climb_m,
                profile.descent_m,
                profile.steepest * 100.0
            ));
            let hint = "Distance, height, slope, longitude and latitude of every point";
            if ui.button("Copy as CSV").on_hover_text(hint).clicked() {
                ui.ctx().copy_text(csv(profile));
            }
        });
        let points: PlotPoints<'_> = profile
            .points
            .iter()
            .filter(|p| p.height_m.is_finite())
            .map(|p| [p.distance_m, p.height_m])
            .collect();
        let pointed = self.status.pointed.and_then(|p| nearest(profile, p.point));
        let response = Plot::new("profile")
            .allow_scroll(false)
            .x_axis_label("Metres along the line")
            .y_axis_label("Height in metres")
            .show(ui, |plot| {
                let colour = Color32::from_rgb(70, 150, 200);
                plot.line(Line::new("Height", points).color(colour).width(1.5));
                if let Some([x, y]) = pointed {
                    plot.vline(VLine::new("Pointer", x).color(Color32::from_rgb(255, 214, 102)));
                    plot.points(Points::new("Pointer", vec![[x, y]]).radius(4.0));
                }
                plot.pointer_coordinate()
                    .filter(|_| plot.response().hovered())
            });
        response
            .response
            .widget_info(|| WidgetInfo::labeled(Role::Image, true, "Heights along the line"));
        if let Some(at) = response.inner {
            let points = profile.points.iter();
            let off = |d: f64| (d - at.x).abs();
            let near = points.min_by(|a, b| off(a.distance_m).total_cmp(&off(b.distance_m)));
            self.marked = near.map(|p| p.place);
            ui.ctx().request_repaint();
        }
    }
}

/// Where on the plot a place of the terrain is, if it lies on the line.
fn nearest(profile: &Profile, at: MapPoint) -> Option<[f64; 2]> {
    let points = profile.points.iter().filter(|p| p.height_m.is_finite());
    let near = points.min_by(|a, b| at.angle_to(a.place).total_cmp(&at.angle_to(b.place)))?;
    let (first, last) = (profile.points.first()?, profile.points.last()?);
    let span = first.place.angle_to(last.place).max(1e-9);
    (at.angle_to(near.place) <= NEAR * span).then_some([near.distance_m, near.height_m])
}

/// All points as lines of text.
fn csv(profile: &Profile) -> String {
    let mut text = String::from("distance_m,height_m,slope_percent,lon_deg,lat_deg\n");
    let number = |v: f64, decimals: usize| {
        if v.is_finite() {
            format!("{v:.decimals$}")
        } else {
            String::new()
        }
    };
    for point in &profile.points {
        let (lon_deg, lat_deg) = point.place.to_degrees();
        // Writing to a text cannot fail.
        let _infallible = writeln!(
            text,
            "{},{},{},{lon_deg:.8},{lat_deg:.8}",
            number(point.distance_m, 3),
            number(point.height_m, 3),
            number(point.slope * 100.0, 3),
        );
    }
    text
}
