//! Lines of equal height, drawn as colour.

use relievo_planet::{Grid, GridCrs, Planet};
use relievo_raster::{Bands, Block, normal};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// What contour lines look like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourStyle {
    /// Metres between lines, positive. `None`: as the samples ask for, see [`automatic_interval_m`].
    pub interval_m: Option<f64>,
    /// A height in metres that has a line; index lines are counted from it.
    pub base_m: f64,
    /// Every how many lines one is an index line; 0 for none, 1 for all.
    pub index_every: u32,
    /// Straight, display-referred colour, 0 to 1 each.
    pub rgb: [f32; 3],
    /// Width of lines in samples, 0 or more.
    pub width: f32,
    /// Width of index lines in samples.
    pub index_width: f32,
}

/// Why a style gives no lines.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ContourStyleError {
    /// The interval is none.
    #[error("contours need a positive interval and a finite base in metres, found {0:?} and {1}")]
    Interval(Option<f64>, f64),
    /// A width is none.
    #[error("contours are 0 to 100 samples wide, found {0}")]
    Width(f32),
    /// A colour is none.
    #[error("colours of contours have finite channels")]
    Colour,
}

/// Contour lines of constant width, anti-aliased, transparent between them. Inputs: heights, and their
/// normals.
///
/// How far a sample lies from the nearest line follows from its height and slope to first order,
/// |h − line| / |∇h|, measured in rows of samples on the ground; a line covers a sample by half of its width
/// plus one half, minus that distance. So a sample needs nothing but itself, lines go on across tiles,
/// and level ground has none. Lines that lie closer than twice their width fade, and vanish at once
/// their width, so that steep ground does not fill up; index lines do so at their own, wider spacing.
#[derive(Clone, Copy, Debug)]
pub struct ContourLines {
    style: ContourStyle,
    radius_m: f64,
}

impl ContourLines {
    /// Lines in a style on a planet.
    ///
    /// # Errors
    /// [`ContourStyleError`].
    pub fn new(planet: Planet, style: ContourStyle) -> Result<Self, ContourStyleError> {
        let interval = style.interval_m.is_none_or(|m| m.is_finite() && m > 0.0);
        if !interval || !style.base_m.is_finite() {
            return Err(ContourStyleError::Interval(style.interval_m, style.base_m));
        }
        for width in [style.width, style.index_width] {
            if !(0.0..=100.0).contains(&width) {
                return Err(ContourStyleError::Width(width));
            }
        }
        if !style.rgb.iter().all(|v| v.is_finite()) {
            return Err(ContourStyleError::Colour);
        }
        Ok(Self {
            style,
            radius_m: planet.radius_m,
        })
    }

    /// Height of a row of samples on the ground in metres.
    fn sample_m(&self, grid: &Grid) -> f64 {
        let step = grid.lattice.step.y.abs();
        match grid.lattice.crs {
            GridCrs::Map => step * self.radius_m,
            GridCrs::Projected(_) => step,
        }
    }

    /// The lines as they lie on a grid.
    fn on(&self, grid: &Grid) -> Lines {
        let sample_m = self.sample_m(grid);
        Lines {
            style: self.style,
            interval_m: self
                .style
                .interval_m
                .unwrap_or_else(|| automatic_interval_m(sample_m)),
            sample_m,
        }
    }
}

/// What [`automatic_interval_m`] chooses from; each divides the next.
const INTERVALS_M: [f64; 18] = [
    1e-2, 5e-2, 0.1, 0.5, 1.0, 5.0, 10.0, 50.0, 1e2, 5e2, 1e3, 5e3, 1e4, 5e4, 1e5, 5e5, 1e6, 5e6,
];

/// Metres between contours where samples are as large as that: 1 or 5 times a power of ten, at least two
/// samples, so that ground that rises by a fifth has one about every ten samples or less often. Intervals
/// divide each other, so a line that is there from afar stays there from near by.
pub fn automatic_interval_m(sample_m: f64) -> f64 {
    let wide = |m: &f64| *m >= 2.0 * sample_m;
    let [.., widest] = INTERVALS_M;
    INTERVALS_M.into_iter().find(wide).unwrap_or(widest)
}

/// Contour lines on a grid.
struct Lines {
    style: ContourStyle,
    interval_m: f64,
    sample_m: f64,
}

impl Lines {
    /// How much lines cover a sample, 0 to 1. `rise_m` is what the ground rises over a sample.
    fn cover(&self, height_m: f64, rise_m: f64) -> f32 {
        let Self {
            style, interval_m, ..
        } = self;
        let all = lines(height_m, rise_m, *interval_m, style.base_m, style.width);
        if style.index_every == 0 {
            return all;
        }
        let interval_m = interval_m * f64::from(style.index_every);
        all.max(lines(
            height_m,
            rise_m,
            interval_m,
            style.base_m,
            style.index_width,
        ))
    }

    /// One sample.
    fn colour(&self, height_m: f32, east: f32, north: f32) -> [f32; 4] {
        let rise_m = normal::rise([east, north]) * self.sample_m;
        let alpha = self.cover(f64::from(height_m), rise_m);
        // Also where the height is missing.
        if alpha > 0.0 {
            let [r, g, b] = self.style.rgb;
            [r, g, b, alpha]
        } else {
            [0.0; 4]
        }
    }
}

/// How much lines of one kind cover a sample.
fn lines(height_m: f64, rise_m: f64, interval_m: f64, base_m: f64, width: f32) -> f32 {
    if rise_m <= 0.0 || width <= 0.0 || !height_m.is_finite() {
        return 0.0;
    }
    let width = f64::from(width);
    let at = (height_m - base_m) / interval_m;
    let off_m = (at - (at + 0.5).floor()).abs() * interval_m;
    // Thinner than a sample, a line is fainter instead.
    let cover = (0.5 * width + 0.5 - off_m / rise_m).clamp(0.0, width.min(1.0));
    let apart = interval_m / rise_m;
    let shown = (apart / width - 1.0).clamp(0.0, 1.0);
    (cover * shown) as f32
}

impl ImageNode for ContourLines {
    fn kind(&self) -> &'static str {
        "contour lines"
    }

    fn version(&self) -> u32 {
        2
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        let style = &self.style;
        let lines = self.on(grid);
        id.float(lines.interval_m).float(style.base_m);
        id.int(i64::from(style.index_every));
        for v in style.rgb {
            id.float(f64::from(v));
        }
        id.float(f64::from(style.width));
        id.float(f64::from(style.index_width));
        id.float(lines.sample_m);
    }

    fn known(&self, grid: &Grid, inputs: &[Known]) -> Known {
        match (inputs[0], inputs[1]) {
            (Known::Uniform([h, ..]), _) if h.is_nan() => Known::Uniform([0.0; 4]),
            (_, Known::Uniform([east, north, ..])) if east == 0.0 && north == 0.0 => {
                Known::Uniform([0.0; 4])
            }
            (Known::Uniform([h, ..]), Known::Uniform([east, north, ..])) => {
                Known::Uniform(self.on(grid).colour(h, east, north))
            }
            _ => Known::Nothing,
        }
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        if job.cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        let lines = self.on(job.grid);
        let heights = inputs[0].plane(0);
        let (east, north) = (inputs[1].plane(0), inputs[1].plane(1));
        let [red, green, blue, alpha] = out.planes_mut();
        for (i, height_m) in heights.iter().enumerate() {
            let [r, g, b, a] = lines.colour(*height_m, east[i], north[i]);
            (red[i], green[i], blue[i], alpha[i]) = (r, g, b, a);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn style() -> ContourStyle {
        ContourStyle {
            interval_m: Some(100.0),
            base_m: 0.0,
            index_every: 5,
            rgb: [0.4, 0.2, 0.1],
            width: 1.5,
            index_width: 3.0,
        }
    }

    fn drawn(sample_m: f64) -> Lines {
        Lines {
            style: style(),
            interval_m: 100.0,
            sample_m,
        }
    }

    /// Coverage summed along a line up a plane that rises by `rise_m` a sample, past one contour.
    fn across(lines: &Lines, contour_m: f64, rise_m: f64) -> f32 {
        (-40..=40)
            .map(|i| lines.cover(contour_m + (f64::from(i) + 0.31) * rise_m, rise_m))
            .sum()
    }

    proptest! {
        #[test]
        fn a_line_is_as_wide_as_asked_however_steep_the_ground(rise_m in 0.5..1.0_f64) {
            let lines = drawn(30.0);
            prop_assert!((across(&lines, 200.0, rise_m) - 1.5).abs() < 0.05);
            prop_assert!((across(&lines, 500.0, rise_m) - 3.0).abs() < 0.05);
            prop_assert!((across(&lines, -1000.0, rise_m) - 3.0).abs() < 0.05);
        }

        #[test]
        fn coverage_is_never_beyond_none_and_all(h in -1e4..1e4_f64, rise in 0.0..1e4_f64) {
            let lines = drawn(30.0);
            prop_assert!((0.0..=1.0).contains(&lines.cover(h, rise)));
        }
    }

    #[test]
    fn where_lines_crowd_only_index_lines_stay_and_then_none() {
        let lines = drawn(30.0);
        assert_eq!(across(&lines, 0.0, 1e5), 0.0);
        // 100 m are 1.25 samples: closer than a line is wide; 500 m are 6.25 samples.
        let crowded = |h: f64| lines.cover(h, 80.0);
        assert_eq!(crowded(200.0), 0.0);
        assert!(crowded(500.0) > 0.9);
    }

    #[test]
    fn level_ground_and_missing_ground_have_no_lines() {
        let lines = drawn(30.0);
        assert_eq!(lines.colour(500.0, 0.0, 0.0), [0.0; 4]);
        assert_eq!(lines.colour(f32::NAN, 0.3, 0.0), [0.0; 4]);
        assert_eq!(lines.colour(500.0, 0.01, 0.0), [0.4, 0.2, 0.1, 1.0]);
    }

    #[test]
    fn automatic_intervals_are_round_and_each_divides_the_next() {
        assert_eq!(automatic_interval_m(4.8), 10.0);
        assert_eq!(automatic_interval_m(9.6), 50.0);
        assert_eq!(automatic_interval_m(0.3), 1.0);
        for pair in INTERVALS_M.windows(2) {
            let times = pair[1] / pair[0];
            assert!((times - times.round()).abs() < 1e-9 && times > 1.5);
        }
    }

    #[test]
    fn styles_without_sense_are_refused() {
        for wrong in [
            ContourStyle {
                interval_m: Some(0.0),
                ..style()
            },
            ContourStyle {
                base_m: f64::NAN,
                ..style()
            },
            ContourStyle {
                width: -1.0,
                ..style()
            },
            ContourStyle {
                index_width: f32::INFINITY,
                ..style()
            },
            ContourStyle {
                rgb: [f32::NAN; 3],
                ..style()
            },
        ] {
            assert!(ContourLines::new(Planet::EARTH, wrong).is_err());
        }
    }
}
