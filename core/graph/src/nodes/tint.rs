//! Colours by height: the hypsometric tint.

use relievo_planet::Grid;
use relievo_raster::colour::{linear_from_srgb, srgb_from_linear};
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

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
    stops: Vec<Stop>,
    /// Premultiplied linear light of each stop, and its alpha.
    linear: Vec<[f32; 4]>,
    smooth: bool,
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
        let linear = stops
            .iter()
            .map(|stop| {
                let [r, g, b, a] = stop.rgba;
                let [r, g, b] = [r, g, b].map(|v| linear_from_srgb(v) * a);
                [r, g, b, a]
            })
            .collect();
        Ok(Self {
            stops,
            linear,
            smooth,
        })
    }

    #[inline]
    fn colour(&self, height_m: f32) -> [f32; 4] {
        if height_m.is_nan() {
            return [0.0; 4];
        }
        let above = self.stops.partition_point(|stop| stop.height_m <= height_m);
        let Some(below) = above.checked_sub(1) else {
            return self.stops[0].rgba;
        };
        let stop = self.stops[below];
        if !self.smooth || above == self.stops.len() || height_m == stop.height_m {
            return stop.rgba;
        }
        let next = self.stops[above];
        if stop.rgba == next.rgba {
            return stop.rgba;
        }
        let t = (height_m - stop.height_m) / (next.height_m - stop.height_m);
        let (low, high) = (self.linear[below], self.linear[above]);
        let [r, g, b, a]: [f32; 4] = core::array::from_fn(|c| low[c] + t * (high[c] - low[c]));
        if a <= 0.0 {
            return [0.0; 4];
        }
        let [r, g, b] = [r, g, b].map(|v| srgb_from_linear(v / a));
        [r, g, b, a]
    }
}

impl ImageNode for Tint {
    fn kind(&self) -> &'static str {
        "tint"
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.int(i64::from(self.smooth)).int(self.stops.len() as i64);
        for stop in &self.stops {
            id.float(f64::from(stop.height_m));
            for v in stop.rgba {
                id.float(f64::from(v));
            }
        }
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform(height) => Known::Uniform(self.colour(height[0])),
            Known::Complete if self.stops.iter().all(|stop| stop.rgba[3] == 1.0) => Known::Complete,
            Known::Complete | Known::Nothing => Known::Nothing,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let [r, g, b, a] = out.planes_mut();
        for (i, height_m) in inputs[0].samples().iter().enumerate() {
            [r[i], g[i], b[i], a[i]] = self.colour(*height_m);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_raster::colour;

    use super::*;

    fn stops() -> [Stop; 3] {
        [(0.0, 0.2), (100.0, 0.6), (300.0, 1.0)].map(|(height_m, v)| Stop {
            height_m,
            rgba: [v, 1.0 - v, 0.5, 1.0],
        })
    }

    #[test]
    fn stops_and_what_lies_beyond_them_are_exact() {
        let tint = Tint::new(&stops(), true).unwrap();
        for stop in stops() {
            assert_eq!(tint.colour(stop.height_m), stop.rgba);
        }
        assert_eq!(tint.colour(-1e9), stops()[0].rgba);
        assert_eq!(tint.colour(f32::INFINITY), stops()[2].rgba);
        assert_eq!(tint.colour(f32::NAN), [0.0; 4]);
    }

    #[test]
    fn half_way_between_black_and_white_is_the_middle_of_linear_light() {
        let ends = [(0.0, 0.0), (1.0, 1.0)].map(|(height_m, v)| Stop {
            height_m,
            rgba: [v, v, v, 1.0],
        });
        let middle = Tint::new(&ends, true).unwrap().colour(0.5);
        assert_eq!(colour::to_u8(middle[0]), 188);
    }

    #[test]
    fn steps_keep_the_colour_of_the_stop_below() {
        let tint = Tint::new(&stops(), false).unwrap();
        assert_eq!(tint.colour(99.9), stops()[0].rgba);
        assert_eq!(tint.colour(100.0), stops()[1].rgba);
    }

    #[test]
    fn bad_stops_are_named() {
        assert_eq!(Tint::new(&[], true).unwrap_err(), TintError::Empty);
        let mut twice = stops();
        twice[1].height_m = 0.0;
        assert_eq!(
            Tint::new(&twice, true).unwrap_err(),
            TintError::Order {
                height_m: 0.0,
                before_m: 0.0
            }
        );
        twice[1] = Stop {
            height_m: 1.0,
            rgba: [0.0, 0.0, 0.0, 2.0],
        };
        assert_eq!(
            Tint::new(&twice, true).unwrap_err(),
            TintError::Colour { height_m: 1.0 }
        );
    }

    proptest! {
        #[test]
        fn a_smooth_tint_has_no_jumps(h in -50.0..350.0_f32) {
            let tint = Tint::new(&stops(), true).unwrap();
            for (a, b) in tint.colour(h).into_iter().zip(tint.colour(h + 0.01)) {
                prop_assert!((a - b).abs() < 1e-3);
            }
        }
    }
}
