//! Error against time: the measured front with what draws now, small, and in words.

use core::fmt::Write as _;
use core::ops::RangeInclusive;

use eframe::egui::{RichText, Role, Ui, WidgetInfo};
use egui_plot::{
    GridMark, HLine, Line, LineStyle, MarkerShape, Plot, PlotBounds, PlotPoints, Points, VLine,
};
use relievo_gpu::FrontPoint;

use super::governor::{Governor, Wish};

/// Height of the plot in points.
const HEIGHT: f32 = 150.0;

/// Room around the front, in powers of ten.
const MARGIN: f64 = 0.12;

/// Draws the front, and says in words what is in use.
pub(crate) fn show(ui: &mut Ui, governor: &Governor) {
    let text = told(governor);
    plot(ui, governor, &text);
    let signs = "dot: in use, cross: latest frame, dashes: wish";
    ui.label(RichText::new(signs).small().weak());
    ui.label(RichText::new(text).small());
}

/// What is in use, what it takes and what is wished for, in words.
fn told(governor: &Governor) -> String {
    let points = governor.front().points();
    let index = governor.index();
    let now = &points[index];
    let about = if governor.is_on_front() { "" } else { "About " };
    let mut text = format!("{about}{} px of error", number(now.error_px));
    match (governor.measured_ms(), governor.estimate_ms(index)) {
        (Some(ms), _) => write_to(&mut text, format_args!(", {} ms a frame.", number(ms))),
        (None, Some(ms)) => {
            write_to(
                &mut text,
                format_args!(", about {} ms a frame.", number(ms)),
            );
        }
        (None, None) => text.push_str("; no frame was measured yet."),
    }
    match governor.wish() {
        Wish::ErrorPx(wish) if now.error_px > wish => {
            text.push_str(" No measured setting has less error.");
        }
        Wish::FrameMs(wish) if index == 0 && governor.measured_ms().is_some_and(|ms| ms > wish) => {
            text.push_str(" No measured setting is faster.");
        }
        Wish::Adapter | Wish::ErrorPx(_) | Wish::FrameMs(_) => {}
    }
    text
}

fn plot(ui: &mut Ui, governor: &Governor, text: &str) {
    let points = governor.front().points();
    let index = governor.index();
    // Without a frame on this adapter the front is known in the times of another machine.
    let estimated = governor.estimate_ms(0).is_some();
    let ms = |i: usize, p: &FrontPoint| governor.estimate_ms(i).unwrap_or(p.frame_ms);
    let on_plot = |i: usize| [ms(i, &points[i]).log10(), points[i].error_px.log10()];
    let front: Vec<[f64; 2]> = (0..points.len()).map(on_plot).collect();
    let latest = governor.latest_ms();
    let (mut low, mut high) = (front[0], front[0]);
    let mut take_in = |at: [Option<f64>; 2]| {
        for axis in 0..2 {
            if let Some(value) = at[axis].filter(|v| v.is_finite()) {
                (low[axis], high[axis]) = (low[axis].min(value), high[axis].max(value));
            }
        }
    };
    for [x, y] in &front {
        take_in([Some(*x), Some(*y)]);
    }
    take_in([latest.map(f64::log10), None]);
    let wish = match governor.wish() {
        Wish::Adapter => [None, None],
        Wish::ErrorPx(px) => [None, Some(px.log10())],
        Wish::FrameMs(ms) => [Some(ms.log10()).filter(|_| estimated), None],
    };
    take_in(wish);
    let bounds = PlotBounds::from_min_max(low.map(|v| v - MARGIN), high.map(|v| v + MARGIN));
    let visuals = ui.visuals();
    let line = visuals.text_color().gamma_multiply(0.6);
    let (strong, accent) = (visuals.strong_text_color(), visuals.hyperlink_color);
    let warning = visuals.warn_fg_color;
    let described =
        format!("Error on the screen against time a frame, of measured settings. {text}");
    let axis = if estimated {
        "ms a frame"
    } else {
        "ms a frame, where it was measured"
    };
    let response = Plot::new("trade")
        .height(HEIGHT)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .allow_axis_zoom_drag(false)
        .show_x(false)
        .show_y(false)
        .x_axis_label(RichText::new(axis).small())
        .y_axis_label(RichText::new("error, px").small())
        .x_grid_spacer(|input| decades(input.bounds))
        .y_grid_spacer(|input| decades(input.bounds))
        .x_axis_formatter(tick)
        .y_axis_formatter(tick)
        .show(ui, |plot| {
            plot.set_plot_bounds(bounds);
            let dashed = LineStyle::dashed_dense();
            if let Some(x) = wish[0] {
                plot.vline(
                    VLine::new("wish", x)
                        .color(warning)
                        .style(dashed)
                        .width(1.5),
                );
            }
            if let Some(y) = wish[1] {
                plot.hline(
                    HLine::new("wish", y)
                        .color(warning)
                        .style(dashed)
                        .width(1.5),
                );
            }
            let at = on_plot(index);
            plot.line(
                Line::new("front", PlotPoints::from(front.clone()))
                    .color(line)
                    .width(1.5),
            );
            plot.points(Points::new("settings", front).color(line).radius(2.0));
            plot.points(Points::new("in use", vec![at]).color(accent).radius(5.0));
            if let Some(ms) = latest {
                let latest = Points::new("latest frame", vec![[ms.log10(), at[1]]]);
                let cross = latest.shape(MarkerShape::Cross).filled(false);
                plot.points(cross.color(strong).radius(6.0));
            }
        });
    response
        .response
        .widget_info(|| WidgetInfo::labeled(Role::Image, true, &described));
    response.response.on_hover_text(
        "Error on the screen of the measured settings of quality (9 in 10 pixels have less), against the \
         time that they should take here",
    );
}

/// Marks at every power of ten, with 2 and 5 of each where there is room; the axis counts powers of ten.
fn decades((low, high): (f64, f64)) -> Vec<GridMark> {
    if !(high - low).is_finite() || high - low > 20.0 {
        return Vec::new();
    }
    let factors: &[f64] = if high - low < 2.5 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let powers = low.floor() as i32..=high.ceil() as i32;
    let values = powers.flat_map(|power| {
        let of = move |factor: &f64| f64::from(power) + factor.log10();
        factors.iter().map(of)
    });
    let inside = values.filter(|value| (low..=high).contains(value));
    let mark = |value| GridMark {
        value,
        step_size: 1.0,
    };
    inside.map(mark).collect()
}

fn tick(mark: GridMark, _: &RangeInclusive<f64>) -> String {
    number(10.0_f64.powf(mark.value))
}

/// A number above 0 with two digits that count: `0.05`, `1.2`, `35`.
fn number(value: f64) -> String {
    let decimals = (1.0 - value.abs().max(1e-6).log10().floor()).clamp(0.0, 6.0);
    let text = format!("{value:.*}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn write_to(text: &mut String, arguments: core::fmt::Arguments<'_>) {
    // Writing to a text cannot fail.
    let _infallible = text.write_fmt(arguments);
}

#[cfg(test)]
mod tests {
    use relievo_gpu::{FrameTime, Front};

    use super::*;
    use crate::window::governor::Occasion;

    #[test]
    fn numbers_have_two_digits_that_count() {
        let written = [0.05, 0.123, 1.0, 1.24, 9.96, 35.4, 1234.0].map(number);
        assert_eq!(written, ["0.05", "0.12", "1", "1.2", "10", "35", "1234"]);
    }

    #[test]
    fn what_is_in_use_is_told_with_its_error_its_time_and_what_is_out_of_reach() {
        let mut governor = Governor::new(Front::measured());
        assert!(told(&governor).starts_with("About "));
        assert!(told(&governor).contains("no frame was measured"));
        governor.follow(Wish::ErrorPx(1e-3), 0, Occasion::Still);
        assert!(told(&governor).contains("No measured setting has less error"));
        governor.follow(Wish::ErrorPx(1e3), 0, Occasion::Still);
        assert!(!told(&governor).contains("No measured"));
        governor.follow(Wish::FrameMs(1.0), 0, Occasion::Still);
        for number in 0..20 {
            let frame = FrameTime {
                gpu_ms: 40.0,
                pixels: 100,
                number,
            };
            governor.measured(frame, 100.0);
        }
        let text = told(&governor);
        assert!(text.contains(", 40 ms a frame."), "{text}");
        assert!(text.contains("No measured setting is faster"), "{text}");
    }
}
