//! Colours by height: the hypsometric tint.

use relievo_planet::Grid;
use relievo_raster::colour::{encode_each, linear_from_srgb, srgb_from_linear};
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::lanes::{self, Colours, LANES, Lanes};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

/// A colour at a height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Height in metres, finite.
    pub height_m: f32,
    /// Straight, display-referred colour with alpha, 0 to 1.
    pub rgba: [f32; 4],
}

/// Why stops make no tint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TintError {
    /// There are none.
    #[error("a tint needs at least 1 stop, this one has none")]
    Empty,
    /// Heights do not rise.
    #[error("stops of a tint must be finite and rise: {height_m} m follows {before_m} m")]
    Order {
        /// A stop's height.
        height_m: f32,
        /// The one before it.
        before_m: f32,
    },
    /// A colour is not one.
    #[error(
        "colours of a tint have finite channels and alpha 0 to 1, the one at {height_m} m has not"
    )]
    Colour {
        /// The stop's height.
        height_m: f32,
    },
}

/// Colours from heights by a table of stops; the ends continue. Input: heights.
///
/// Smooth: between two stops the colour is interpolated linearly in height, premultiplied and in
/// linear light. Stepped: the colour of the highest stop not above the height. At a stop the result
/// is its colour bit for bit. NaN gives transparency.
#[derive(Clone, Debug)]
pub struct Tint {
    /// Heights of the stops.
    heights_m: Vec<f32>,
    /// Below the first stop, between stops, from the last stop on: one more than there are stops.
    intervals: Vec<Interval>,
    /// Whether all stops are.
    opaque: bool,
    /// Of the stops and how they are joined.
    name: ContentId,
}

/// Most stops that are compared with a height one by one; with more it is searched.
const FEW: usize = 16;

/// The colours from one stop to the next.
#[derive(Clone, Copy, Debug)]
struct Interval {
    /// Height of the stop below.
    start_m: f32,
    /// 1 / the height of the interval; 0 where the colour does not change.
    per_m: f32,
    /// Premultiplied linear light and alpha at the stop below.
    linear: [f32; 4],
    /// What is added up to the stop above.
    change: [f32; 4],
    /// The colour of the stop below.
    rgba: [f32; 4],
}

impl Interval {
    /// Whether the colour at a height is exactly that of the stop below.
    #[inline(always)]
    fn is_exact(&self, height_m: f32) -> bool {
        self.per_m == 0.0 || height_m == self.start_m
    }

    /// How far a height is on the way to the stop above, at most 1.
    #[inline(always)]
    fn part(&self, height_m: f32) -> f32 {
        let part = (height_m - self.start_m) * self.per_m;
        if part < 1.0 { part } else { 1.0 }
    }

    /// A channel of premultiplied linear light, or alpha, part of the way to the stop above.
    #[inline(always)]
    fn channel(&self, channel: usize, part: f32) -> f32 {
        self.linear[channel] + part * self.change[channel]
    }

    /// All channels at a height that is not NaN.
    #[inline(always)]
    fn mixed(&self, height_m: f32) -> [f32; 4] {
        let part = self.part(height_m);
        core::array::from_fn(|c| self.channel(c, part))
    }
}

impl Tint {
    /// A tint of stops in rising order of height.
    ///
    /// # Errors
    /// [`TintError`] without stops, with heights that are not finite or do not rise, or with bad
    /// colours.
    pub fn new(stops: &[Stop], smooth: bool) -> Result<Self, TintError> {
        let first = stops.first().ok_or(TintError::Empty)?;
        if !first.height_m.is_finite() {
            return Err(TintError::Order {
                height_m: first.height_m,
                before_m: f32::NEG_INFINITY,
            });
        }
        for pair in stops.windows(2) {
            let (height_m, before_m) = (pair[1].height_m, pair[0].height_m);
            if !(height_m.is_finite() && height_m > before_m) {
                return Err(TintError::Order { height_m, before_m });
            }
        }
        let mut stops = stops.to_vec();
        for stop in &mut stops {
            if !stop.rgba.iter().all(|v| v.is_finite()) || !(0.0..=1.0).contains(&stop.rgba[3]) {
                return Err(TintError::Colour {
                    height_m: stop.height_m,
                });
            }
            if stop.rgba[3] == 0.0 {
                stop.rgba = [0.0; 4];
            }
        }
        let light = |stop: &Stop| {
            let [r, g, b, a] = stop.rgba;
            let [r, g, b] = [r, g, b].map(|v| linear_from_srgb(v) * a);
            [r, g, b, a]
        };
        let constant = |stop: &Stop| Interval {
            start_m: stop.height_m,
            per_m: 0.0,
            linear: light(stop),
            change: [0.0; 4],
            rgba: stop.rgba,
        };
        let mut intervals = vec![constant(&stops[0])];
        for pair in stops.windows(2) {
            let mut interval = constant(&pair[0]);
            if smooth && pair[0].rgba != pair[1].rgba {
                interval.per_m = 1.0 / (pair[1].height_m - pair[0].height_m);
                let above = light(&pair[1]);
                interval.change = core::array::from_fn(|c| above[c] - interval.linear[c]);
            }
            intervals.push(interval);
        }
        intervals.push(constant(&stops[stops.len() - 1]));
        let mut name = IdHasher::default();
        name.int(i64::from(smooth)).int(stops.len() as i64);
        for stop in &stops {
            name.float(f64::from(stop.height_m));
            for v in stop.rgba {
                name.float(f64::from(v));
            }
        }
        Ok(Self {
            heights_m: stops.iter().map(|stop| stop.height_m).collect(),
            intervals,
            opaque: stops.iter().all(|stop| stop.rgba[3] == 1.0),
            name: name.finish(),
        })
    }

    /// One sample.
    fn colour(&self, height_m: f32) -> [f32; 4] {
        if height_m.is_nan() {
            return [0.0; 4];
        }
        let interval = &self.intervals[self.heights_m.partition_point(|stop| *stop <= height_m)];
        if interval.is_exact(height_m) {
            return interval.rgba;
        }
        let [r, g, b, a] = interval.mixed(height_m);
        if a <= 0.0 {
            return [0.0; 4];
        }
        let [r, g, b] = [r, g, b].map(|v| srgb_from_linear(v / a));
        [r, g, b, a]
    }

    /// [`Self::colour`] of some samples, the same bits.
    #[inline(always)]
    fn colours(&self, height_m: &Lanes, out: &mut Colours) {
        let mut exact = [false; LANES];
        let mut at = [0_u32; LANES];
        if let Some(only) = self.find_one(height_m) {
            // As nearly everywhere: terrain does not jump. Plane by plane it runs on vectors.
            let interval = &self.intervals[only];
            at = [only as u32; LANES];
            let part = height_m.map(|h| interval.part(h));
            for (c, plane) in out.iter_mut().enumerate() {
                for (v, part) in plane.iter_mut().zip(&part) {
                    *v = interval.channel(c, *part);
                }
            }
            for (exact, h) in exact.iter_mut().zip(height_m) {
                *exact = interval.is_exact(*h);
            }
        } else {
            self.find(height_m, &mut at);
            for (l, h) in height_m.iter().enumerate() {
                let interval = &self.intervals[at[l] as usize];
                exact[l] = interval.is_exact(*h) || h.is_nan();
                let mixed = interval.mixed(*h);
                for (plane, v) in out.iter_mut().zip(mixed) {
                    plane[l] = v;
                }
            }
        }
        if !exact.iter().all(|exact| *exact) {
            let [r, g, b, a] = out;
            for plane in [r, g, b] {
                if !self.opaque {
                    for (v, a) in plane.iter_mut().zip(a.iter()) {
                        *v = if *a > 0.0 { *v / *a } else { 0.0 };
                    }
                }
                encode_each(plane);
            }
            if !self.opaque {
                for l in 0..LANES {
                    if out[3][l] <= 0.0 {
                        for plane in out.iter_mut() {
                            plane[l] = 0.0;
                        }
                    }
                }
            }
        }
        if exact.contains(&true) {
            for l in 0..LANES {
                if exact[l] {
                    let rgba = if height_m[l].is_nan() {
                        [0.0; 4]
                    } else {
                        self.intervals[at[l] as usize].rgba
                    };
                    for (plane, v) in out.iter_mut().zip(rgba) {
                        plane[l] = v;
                    }
                }
            }
        }
    }

    /// The interval in which all heights lie, if it is one.
    #[inline(always)]
    fn find_one(&self, height_m: &Lanes) -> Option<usize> {
        let at = self.heights_m.partition_point(|stop| *stop <= height_m[0]);
        let low = at
            .checked_sub(1)
            .map_or(f32::NEG_INFINITY, |below| self.heights_m[below]);
        let high = self.heights_m.get(at).copied();
        // Not short-circuited: one comparison of vectors after the other.
        let outside = height_m.iter().fold(0_u32, |outside, h| {
            let inside = *h >= low && high.is_none_or(|high| *h < high);
            outside | u32::from(!inside)
        });
        (outside == 0).then_some(at)
    }

    /// Intervals in which heights lie; NaN lies in the first.
    #[inline(always)]
    fn find(&self, height_m: &Lanes, at: &mut [u32; LANES]) {
        if self.heights_m.len() <= FEW {
            for stop in &self.heights_m {
                for (i, h) in at.iter_mut().zip(height_m) {
                    *i += u32::from(h >= stop);
                }
            }
        } else {
            for (i, h) in at.iter_mut().zip(height_m) {
                *i = self.heights_m.partition_point(|stop| stop <= h) as u32;
            }
        }
    }
}

impl ImageNode for Tint {
    fn kind(&self) -> &'static str {
        "tint"
    }

    fn version(&self) -> u32 {
        3
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform(height) => Known::Uniform(self.colour(height[0])),
            Known::Complete if self.opaque => Known::Complete,
            Known::Complete | Known::Nothing => Known::Nothing,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let heights = inputs[0].samples();
        let mut out: [&mut [f32]; 4] = out.planes_mut();
        on_widest(
            #[inline(always)]
            || {
                let mut height_m = [0.0; LANES];
                let mut colours = [[0.0; LANES]; 4];
                for first in (0..heights.len()).step_by(LANES) {
                    // What lies beyond the last sample is left over and written nowhere.
                    lanes::copy(&heights[first..], &mut height_m);
                    self.colours(&height_m, &mut colours);
                    for (plane, lanes) in out.iter_mut().zip(&colours) {
                        lanes::write(lanes, plane, first);
                    }
                }
            },
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests;
