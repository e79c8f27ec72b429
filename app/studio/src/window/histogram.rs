//! How often each value of the selected layer is seen, before and after its adjustment, and its levels.

mod levels;

use eframe::egui::{self, Color32, Role, Ui, WidgetInfo};
use egui_plot::{Bar, BarChart, Corner, Legend, Line, Plot, PlotPoints};
use relievo_engine::analysis::Task;
use relievo_engine::histogram::{BINS, Counts, Histogram};
use relievo_engine::planet::Camera;
use relievo_engine::project::{Adjust, LayerId, LayerKind};

use super::action::Action;
use super::latest::Latest;
use super::studio::Studio;
use super::waiting;

/// What a histogram is of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    layer: LayerId,
    revision: u64,
    camera: Camera,
    aspect: f64,
}

/// The latest histogram: `None` where there is none, or one line that says why.
pub(crate) type Histograms = Latest<Wanted, Result<Option<Histogram>, String>>;

impl Studio {
    /// Draws the histogram of the selected layer; one for the view as it is now is counted on another
    /// thread once the view rests.
    pub(super) fn histogram_pane(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let Some(layer) = self.selected.clone() else {
            ui.weak("Select a layer to see its values.");
            return;
        };
        let wanted = Wanted {
            layer: layer.clone(),
            revision: self.state(),
            camera: *self.camera(),
            aspect: self.aspect,
        };
        let rests = !self.navigation.is_moving() && !ui.input(|i| i.pointer.any_down());
        if rests && self.status.opening == 0 {
            let engine = self.document.engine();
            self.histograms.ask(wanted.clone(), || {
                let questions = engine.questions();
                let wanted = wanted.clone();
                move |task: &Task| {
                    questions
                        .histogram(&wanted.layer, &wanted.camera, wanted.aspect, task)
                        .map_err(|e| e.to_string())
                }
            });
        }
        waiting::show(ui, &mut self.histograms, "Counting");
        // While the next one is being counted the one before stays, unless it is another layer's.
        let last = self.histograms.last();
        let last = last.filter(|last| last.key.layer == layer);
        let stale = last.as_ref().is_some_and(|last| last.key != wanted);
        let answer = last.map(|last| last.answer);
        let project = self.document.project();
        if let Some(shown) = project.layer(&layer).filter(|l| !l.locked)
            && let Some(adjust) = adjust_of(&shown.kind)
        {
            let seen = answer.as_ref().and_then(|a| a.as_ref().ok()?.as_ref());
            levels::show(ui, &layer, adjust, seen, actions);
        }
        match answer {
            Some(Ok(Some(histogram))) => plot(ui, &histogram, stale),
            Some(Ok(None)) => {
                ui.weak("Nothing of this layer is seen.");
            }
            Some(Err(reason)) => {
                ui.colored_label(ui.visuals().error_fg_color, reason);
            }
            None => {}
        }
    }
}

/// The adjustment of a layer, if it has one.
pub(super) fn adjust_of(kind: &LayerKind) -> Option<&Adjust> {
    match kind {
        LayerKind::Imagery(imagery) => Some(&imagery.adjust),
        LayerKind::Tint(tint) => Some(&tint.adjust),
        LayerKind::Height(_)
        | LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Vector(_)
        | LayerKind::Unknown { .. } => None,
    }
}

fn plot(ui: &mut Ui, histogram: &Histogram, stale: bool) {
    let unit = if histogram.counts.len() == 1 {
        " m"
    } else {
        ""
    };
    let (low, high) = histogram.range;
    let summary = format!(
        "{} samples, {low:.2}{unit} to {high:.2}{unit}{}",
        histogram.samples,
        if stale { ", counting again…" } else { "" }
    );
    ui.weak(summary);
    let response = Plot::new("histogram")
        .legend(Legend::default().position(Corner::RightTop))
        .show_axes([true, false])
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_drag(false)
        .include_x(low)
        .include_x(high)
        .include_y(0.0)
        .x_axis_label(if unit.is_empty() {
            "Value"
        } else {
            "Height in metres"
        })
        .show(ui, |plot| {
            for counts in &histogram.counts {
                let colour = colour_of(counts.name);
                plot.bar_chart(before(histogram, counts, colour));
                plot.line(after(histogram, counts, colour));
            }
        });
    response
        .response
        .widget_info(|| WidgetInfo::labeled(Role::Image, true, "Histogram of the selected layer"));
}

fn width(histogram: &Histogram) -> f64 {
    (histogram.range.1 - histogram.range.0).max(1e-9) / BINS as f64
}

/// The source's values as faint bars.
fn before(histogram: &Histogram, counts: &Counts, colour: Color32) -> BarChart {
    let width = width(histogram);
    let bars = counts.before.iter().enumerate().map(|(bin, n)| {
        let at = histogram.range.0 + (bin as f64 + 0.5) * width;
        Bar::new(at, f64::from(*n))
            .width(width)
            .fill(colour.gamma_multiply(0.25))
            .stroke(egui::Stroke::NONE)
    });
    BarChart::new(format!("{} before", counts.name), bars.collect())
        .color(colour.gamma_multiply(0.4))
}

/// What became of them as a line.
fn after<'a>(histogram: &Histogram, counts: &Counts, colour: Color32) -> Line<'a> {
    let width = width(histogram);
    let points: PlotPoints<'_> = counts
        .after
        .iter()
        .enumerate()
        .map(|(bin, n)| {
            [
                histogram.range.0 + (bin as f64 + 0.5) * width,
                f64::from(*n),
            ]
        })
        .collect();
    Line::new(format!("{} after", counts.name), points)
        .color(colour)
        .width(1.5)
}

fn colour_of(name: &str) -> Color32 {
    match name {
        "Red" => Color32::from_rgb(225, 80, 75),
        "Green" => Color32::from_rgb(70, 175, 90),
        "Blue" => Color32::from_rgb(80, 140, 235),
        _ => Color32::from_rgb(150, 150, 160),
    }
}
