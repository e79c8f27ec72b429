//! Heights over heights.

use relievo_planet::Grid;
use relievo_raster::{Bands, Block};

use super::overlay::clamped;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// `height = base + w · (top − base)` in metres, w = opacity · mask from 0 to 1.
///
/// Inputs: base heights, top heights and, if masked, a mask. Where the top has no height (NaN) or w
/// is 0 the result is the base bit for bit; where w is 1, or the base has no height and w exceeds
/// 0, it is the top bit for bit: a source fills the holes of what lies below.
#[derive(Clone, Copy, Debug)]
pub struct OverlayHeights {
    opacity: f32,
    masked: bool,
}

impl OverlayHeights {
    /// `opacity` is clamped to 0..=1, NaN counts as 0; `masked` says whether there is a third input.
    pub fn new(opacity: f32, masked: bool) -> Self {
        Self {
            opacity: clamped(opacity),
            masked,
        }
    }

    fn mask_known(self, inputs: &[Known]) -> Known {
        if self.masked {
            inputs[2]
        } else {
            Known::Complete
        }
    }
}

#[inline]
fn mix(base: f32, top: f32, weight: f32) -> f32 {
    let between = base + weight * (top - base);
    let covered = if weight >= 1.0 || base.is_nan() {
        top
    } else {
        between
    };
    // A weight of NaN is no weight.
    if weight > 0.0 && !top.is_nan() {
        covered
    } else {
        base
    }
}

impl ImageNode for OverlayHeights {
    fn kind(&self) -> &'static str {
        "overlay heights"
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.float(f64::from(self.opacity))
            .int(i64::from(self.masked));
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        let mask = if self.masked {
            inputs[2].as_uniform().map(|m| m[0])
        } else {
            Some(1.0)
        };
        if let (Known::Uniform(base), Known::Uniform(top), Some(mask)) =
            (inputs[0], inputs[1], mask)
        {
            return Known::Uniform([mix(base[0], top[0], self.opacity * mask), 0.0, 0.0, 0.0]);
        }
        let covered = self.opacity == 1.0
            && inputs[1].is_complete(Bands::Height)
            && self.mask_known(inputs).is_complete(Bands::Mask);
        if covered || inputs[0].is_complete(Bands::Height) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    fn identity(&self, _grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let mask = self.mask_known(inputs);
        if self.opacity == 0.0 || inputs[1].is_absent(Bands::Height) || mask.is_absent(Bands::Mask)
        {
            return Some(0);
        }
        let unweighted = self.opacity == 1.0 && mask.is_complete(Bands::Mask);
        let decides = inputs[1].is_complete(Bands::Height) || inputs[0].is_absent(Bands::Height);
        (unweighted && decides).then_some(1)
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let (base, top) = (inputs[0].samples(), inputs[1].samples());
        let heights = out.samples_mut().iter_mut().zip(base).zip(top);
        if self.masked {
            for (((h, b), t), m) in heights.zip(inputs[2].samples()) {
                *h = mix(*b, *t, self.opacity * m);
            }
        } else {
            for ((h, b), t) in heights {
                *h = mix(*b, *t, self.opacity);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn each_layer_fills_the_holes_of_the_other() {
        assert_eq!(mix(f32::NAN, 5.0, 0.25), 5.0);
        assert_eq!(mix(3.0, f32::NAN, 1.0), 3.0);
        assert!(mix(f32::NAN, 5.0, 0.0).is_nan());
        assert!(mix(f32::NAN, f32::NAN, 1.0).is_nan());
    }

    proptest! {
        #[test]
        fn a_mixture_lies_between_its_ends(base in -500.0..9000.0_f32, top in -500.0..9000.0_f32, w in 0.0..1.0_f32) {
            let h = mix(base, top, w);
            prop_assert!(h >= base.min(top) - 1e-3 && h <= base.max(top) + 1e-3);
            prop_assert_eq!(mix(base, top, 0.0), base);
            prop_assert_eq!(mix(base, top, 1.0), top);
        }
    }
}
