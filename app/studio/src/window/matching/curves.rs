//! Histograms of a match: as it was, as it became, as it should be.

use eframe::egui::{Color32, Role, Stroke, Ui, WidgetInfo};
use egui_plot::{Corner, Legend, Line, LineStyle, Plot, PlotPoints};
use relievo_engine::analysis::colour::{FIT_BINS, FitHistograms};

const CHANNELS: [(&str, Color32); 3] = [
    ("Red", Color32::from_rgb(225, 80, 75)),
    ("Green", Color32::from_rgb(70, 175, 90)),
    ("Blue", Color32::from_rgb(80, 140, 235)),
];

/// Height of a channel's plot in points.
const HEIGHT: f32 = 84.0;

/// Draws a plot for each channel: before faint, after a line, the target dotted.
pub(super) fn show(ui: &mut Ui, histograms: &FitHistograms) {
    ui.weak("Values where both show the same ground: faint before, solid after, dotted as they should be");
    for (channel, (name, colour)) in CHANNELS.into_iter().enumerate() {
        let plot = Plot::new(("match", name))
            .height(HEIGHT)
            .legend(Legend::default().position(Corner::RightTop))
            .show_axes([channel == 2, false])
            .allow_scroll(false)
            .allow_zoom(false)
            .allow_drag(false)
            .include_x(0.0)
            .include_x(1.0)
            .include_y(0.0);
        let response = plot.show(ui, |plot| {
            let faint = Stroke::new(1.5, colour.gamma_multiply(0.4));
            plot.line(line("before", &histograms.before[channel]).stroke(faint));
            plot.line(line(name, &histograms.after[channel]).stroke(Stroke::new(2.0, colour)));
            let target = line("target", &histograms.target[channel]);
            let target = target.style(LineStyle::dotted_dense());
            plot.line(target.stroke(Stroke::new(1.5, colour)));
        });
        let text = format!("{name} before, after and as it should be");
        response
            .response
            .widget_info(|| WidgetInfo::labeled(Role::Image, true, &text));
    }
}

fn line<'a>(name: &str, counts: &[u32; FIT_BINS]) -> Line<'a> {
    let at = |bin: usize| (bin as f64 + 0.5) / FIT_BINS as f64;
    let points: PlotPoints<'_> = counts
        .iter()
        .enumerate()
        .map(|(bin, n)| [at(bin), f64::from(*n)])
        .collect();
    Line::new(name.to_owned(), points)
}
