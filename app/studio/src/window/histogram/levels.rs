//! Black and white points of an adjustment: which values of the source become black and white.

use eframe::egui::{Button, DragValue, Ui};
use relievo_engine::histogram::{BINS, Histogram};
use relievo_engine::project::{Adjust, AdjustSpace, Edit, LayerId};
use relievo_engine::raster::colour::{linear_from_srgb, srgb_from_linear};

use crate::window::action::Action;
use crate::window::controls;

/// Black and white are at least this far apart: gains end at 16.
const LEAST_SPAN: f64 = 1.0 / 16.0;

/// Percent of the values that a stretch leaves out at either end unless told otherwise.
const CLIPPED_PERCENT: f64 = 1.0;

/// What becomes black and white in a channel, on display values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Levels {
    black: f64,
    white: f64,
}

/// A display value as gain and offset have it.
fn inner(space: AdjustSpace, display: f64) -> f64 {
    match space {
        AdjustSpace::Display => display,
        AdjustSpace::Linear | AdjustSpace::Perceptual => {
            f64::from(linear_from_srgb(display as f32))
        }
    }
}

fn outer(space: AdjustSpace, value: f64) -> f64 {
    match space {
        AdjustSpace::Display => value,
        AdjustSpace::Linear | AdjustSpace::Perceptual => f64::from(srgb_from_linear(value as f32)),
    }
}

impl Levels {
    /// Those of a channel; `None` where its gain leaves no black and white.
    fn of(adjust: &Adjust, channel: usize) -> Option<Self> {
        let (gain, offset) = (adjust.gain[channel], adjust.offset[channel]);
        let at = |shown: f64| outer(adjust.space, (shown - offset) / gain);
        (gain > 1e-6).then(|| Self {
            black: at(0.0),
            white: at(1.0),
        })
    }

    fn set(self, adjust: &mut Adjust, channel: usize) {
        let (black, white) = (
            inner(adjust.space, self.black),
            inner(adjust.space, self.white),
        );
        let gain = 1.0 / (white - black).max(LEAST_SPAN);
        adjust.gain[channel] = gain;
        adjust.offset[channel] = (-black * gain).clamp(-16.0, 16.0);
    }
}

/// Draws them and what stretches them.
pub(super) fn show(
    ui: &mut Ui,
    id: &LayerId,
    adjust: &Adjust,
    histogram: Option<&Histogram>,
    actions: &mut Vec<Action>,
) {
    let edit = |change: &dyn Fn(&mut Adjust)| {
        let mut adjust = adjust.clone();
        change(&mut adjust);
        Action::Edit(Edit::SetAdjust {
            id: id.clone(),
            adjust,
        })
    };
    ui.horizontal_wrapped(|ui| {
        for (channel, name) in ["Red", "Green", "Blue"].into_iter().enumerate() {
            let Some(levels) = Levels::of(adjust, channel) else {
                ui.weak(format!("{name}: no gain"));
                continue;
            };
            let mut new = levels;
            controls::name(ui, &format!("{name} levels"), false);
            for (value, what) in [(&mut new.black, "black"), (&mut new.white, "white")] {
                let field = DragValue::new(value)
                    .speed(0.002)
                    .range(-1.0..=2.0)
                    .fixed_decimals(3);
                let hint = format!(
                    "Value of {} that becomes {what}; 0 to 1, beyond where the file has more",
                    name.to_lowercase()
                );
                let response = ui.add(field).on_hover_text(&hint);
                response.widget_info(|| {
                    let text = format!("{name}, value that becomes {what}");
                    eframe::egui::WidgetInfo::labeled(eframe::egui::Role::SpinButton, true, text)
                });
                if response.drag_started() {
                    actions.push(Action::BeginDrag);
                }
                if response.drag_stopped() {
                    actions.push(Action::EndDrag);
                }
            }
            if new != levels {
                actions.push(edit(&|a| new.set(a, channel)));
            }
        }
        let key = ui.make_persistent_id("percent clipped by a stretch");
        let mut clipped = ui.data(|d| d.get_temp(key)).unwrap_or(CLIPPED_PERCENT);
        let colours = histogram.filter(|h| h.counts.len() == 3 && h.samples > 0);
        let stretches = [
            ("Stretch", "one range for all channels, so hues stay", false),
            (
                "Stretch each",
                "each channel by its own range, which also balances colours",
                true,
            ),
        ];
        for (title, how, each) in stretches {
            let button = ui.add_enabled(colours.is_some(), Button::new(title));
            let hint = format!("Make the darkest values seen black and the lightest white: {how}");
            if let (true, Some(seen)) = (button.on_hover_text(hint).clicked(), colours) {
                let levels = stretched(seen, clipped / 100.0, each);
                actions.push(edit(&|a| {
                    for (channel, levels) in levels.iter().enumerate() {
                        levels.set(a, channel);
                    }
                }));
            }
        }
        let field = DragValue::new(&mut clipped)
            .range(0.0..=25.0)
            .speed(0.05)
            .suffix(" %");
        let hint =
            "Percent of the values that a stretch leaves out at either end, 0 to 25, usually 1";
        if ui.add(field).on_hover_text(hint).changed() {
            ui.data_mut(|d| d.insert_temp(key, clipped));
        }
    });
}

/// Levels that leave out a share of the source's values at either end.
fn stretched(histogram: &Histogram, clipped: f64, each: bool) -> [Levels; 3] {
    let of = |counts: &[u32]| {
        let (low, high) = histogram.range;
        let at = |share: f64| low + (high - low) * quantile(counts, share);
        spanned(at(clipped), at(1.0 - clipped))
    };
    if each {
        return core::array::from_fn(|c| of(&histogram.counts[c].before));
    }
    let together: Vec<u32> = (0..BINS)
        .map(|bin| histogram.counts.iter().map(|c| c.before[bin]).sum())
        .collect();
    [of(&together); 3]
}

/// With room between: one colour everywhere stays what it is.
fn spanned(black: f64, white: f64) -> Levels {
    if white - black >= LEAST_SPAN {
        Levels { black, white }
    } else {
        let middle = f64::midpoint(black, white);
        Levels {
            black: middle - 0.5 * LEAST_SPAN,
            white: middle + 0.5 * LEAST_SPAN,
        }
    }
}

/// Where a share of the counts lies below, as a part of the bins; even within a bin.
fn quantile(counts: &[u32], share: f64) -> f64 {
    let total: f64 = counts.iter().map(|n| f64::from(*n)).sum();
    let wanted = share * total;
    let mut below = 0.0;
    let mut last = 0.0;
    for (bin, n) in counts.iter().enumerate() {
        let n = f64::from(*n);
        if n > 0.0 {
            if below + n >= wanted {
                let part = ((wanted - below) / n).clamp(0.0, 1.0);
                return (bin as f64 + part) / counts.len() as f64;
            }
            last = (bin + 1) as f64 / counts.len() as f64;
        }
        below += n;
    }
    last
}

#[cfg(test)]
mod tests {
    use relievo_engine::histogram::Counts;

    use super::*;

    fn seen(from: usize, to: usize) -> Counts {
        let mut before = vec![0; BINS];
        before[from..to].fill(10);
        Counts {
            name: "Red",
            after: before.clone(),
            before,
        }
    }

    #[test]
    fn a_stretch_takes_the_ends_of_what_is_seen_to_black_and_white() {
        let (a, b) = (BINS / 4, BINS / 2);
        let histogram = Histogram {
            range: (0.0, 1.0),
            counts: vec![seen(a, b), seen(0, BINS), seen(a, BINS)],
            samples: 10,
        };
        let each = stretched(&histogram, 0.0, true);
        assert_eq!((each[0].black, each[0].white), (0.25, 0.5));
        assert_eq!((each[1].black, each[1].white), (0.0, 1.0));
        let one = stretched(&histogram, 0.0, false);
        assert!(one.iter().all(|l| (l.black, l.white) == (0.0, 1.0)));
        let clipped = stretched(&histogram, 0.1, true)[1];
        assert!((clipped.black - 0.1).abs() < 1e-9 && (clipped.white - 0.9).abs() < 1e-9);
    }

    #[test]
    fn levels_are_read_back_as_they_were_set_in_every_space() {
        for space in [
            AdjustSpace::Display,
            AdjustSpace::Linear,
            AdjustSpace::Perceptual,
        ] {
            let mut adjust = Adjust {
                space,
                ..Adjust::default()
            };
            assert_eq!(
                Levels::of(&adjust, 0).map(|l| (l.black, l.white)),
                Some((0.0, 1.0))
            );
            let set = Levels {
                black: 0.2,
                white: 0.8,
            };
            set.set(&mut adjust, 1);
            let got = Levels::of(&adjust, 1).unwrap();
            assert!((got.black - 0.2).abs() < 1e-5 && (got.white - 0.8).abs() < 1e-5);
        }
    }

    #[test]
    fn one_colour_everywhere_and_none_at_all_make_levels_with_room_between() {
        for counts in [seen(7, 8), seen(0, 0)] {
            let histogram = Histogram {
                range: (0.0, 1.0),
                counts: vec![counts.clone(), counts.clone(), counts],
                samples: 10,
            };
            for levels in stretched(&histogram, 0.01, true) {
                assert!(levels.white - levels.black >= LEAST_SPAN * 0.999);
            }
        }
    }
}
