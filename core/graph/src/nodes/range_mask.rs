//! A mask by value: heights within a range, slopes within a range.

use relievo_planet::Grid;
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// 1 where a value lies within a range, fading smoothly to 0 beyond both ends. Input: heights, or
/// angles given as heights ([`SlopeAngle`](super::SlopeAngle)). Holes are 0.
#[derive(Clone, Copy, Debug)]
pub struct RangeMask {
    low: f32,
    high: f32,
    fade: f32,
}

impl RangeMask {
    /// From `low` to `high`, both included, in the input's unit; ends that are no numbers are open, a
    /// `high` below `low` leaves nothing. `fade` is how far beyond an end the mask reaches 0; what is not
    /// above 0 means at once.
    pub fn new(low: f64, high: f64, fade: f64) -> Self {
        let or = |v: f64, open: f32| if v.is_nan() { open } else { v as f32 };
        Self {
            low: or(low, f32::NEG_INFINITY),
            high: or(high, f32::INFINITY),
            fade: if fade > 0.0 && fade.is_finite() {
                fade as f32
            } else {
                0.0
            },
        }
    }

    /// Of one value; chosen from all that it could be, not branched to, so that it runs on vectors.
    #[inline(always)]
    fn weight(self, value: f32) -> f32 {
        let (below, above) = (self.low - value, value - self.high);
        let beyond = if below > above { below } else { above };
        let beyond = if beyond > 0.0 { beyond } else { 0.0 };
        let outside = faded(beyond, self.fade);
        let weight = if beyond > 0.0 { outside } else { 1.0 };
        let nowhere = value.is_nan() | (self.high < self.low);
        if nowhere { 0.0 } else { weight }
    }
}

/// Weight at a distance beyond an edge, above 0: a smooth step from 1 to 0 over `fade`.
#[inline(always)]
pub(super) fn faded(beyond: f32, fade: f32) -> f32 {
    let t = beyond / fade;
    let within = 1.0 - t * t * (3.0 - 2.0 * t);
    if beyond >= fade { 0.0 } else { within }
}

impl ImageNode for RangeMask {
    fn kind(&self) -> &'static str {
        "range mask"
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        for v in [self.low, self.high, self.fade] {
            id.float(f64::from(v));
        }
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        let weight = |value| Known::Uniform([self.weight(value), 0.0, 0.0, 0.0]);
        match inputs[0] {
            Known::Uniform([value, ..]) => weight(value),
            Known::Complete | Known::Nothing if self.high < self.low => weight(0.0),
            Known::Complete | Known::Nothing => Known::Nothing,
        }
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let (weights, values) = (out.plane_mut(0), inputs[0].plane(0));
        on_widest(
            #[inline(always)]
            || {
                for (weight, value) in weights.iter_mut().zip(values) {
                    *weight = self.weight(*value);
                }
            },
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_the_range_all_counts_and_beyond_it_fades_to_nothing() {
        let mask = RangeMask::new(100.0, 200.0, 10.0);
        for (value, weight) in [
            (100.0, 1.0),
            (150.0, 1.0),
            (200.0, 1.0),
            (205.0, 0.5),
            (95.0, 0.5),
            (210.0, 0.0),
            (f32::NAN, 0.0),
            (f32::INFINITY, 0.0),
        ] {
            assert_eq!(mask.weight(value), weight, "{value}");
        }
    }

    #[test]
    fn open_ends_and_empty_ranges_are_what_they_say() {
        let above = RangeMask::new(1000.0, f64::NAN, 0.0);
        assert_eq!((above.weight(1e30), above.weight(999.9)), (1.0, 0.0));
        let none = RangeMask::new(10.0, 5.0, 100.0);
        assert_eq!(none.weight(7.0), 0.0);
        let odd = RangeMask::new(0.0, 1.0, f64::NAN);
        assert_eq!((odd.weight(1.0), odd.weight(1.001)), (1.0, 0.0));
    }
}
