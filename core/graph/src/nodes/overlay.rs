//! Colours over colours.

use relievo_planet::Grid;
use relievo_raster::colour::Transfer;
use relievo_raster::{Bands, Block};

use super::light::{LANES, Lanes, Light};
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

/// How the colours of two layers meet, before they are mixed by alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum BlendMode {
    /// The top's colour.
    #[default]
    Normal,
    /// Product: darkens.
    Multiply,
    /// Sum, not clamped here: brightens.
    Add,
    /// Inverse of the product of inverses: brightens without clipping.
    Screen,
    /// Multiplies where the base is dark, screens where it is bright.
    Overlay,
}

impl BlendMode {
    /// B(base, top) of one channel of straight, display-referred values.
    ///
    /// Source: W3C Compositing and Blending Level 1, 9.1; `Add` is the plain sum.
    #[inline]
    fn blend(self, base: f32, top: f32) -> f32 {
        match self {
            Self::Normal => top,
            Self::Multiply => base * top,
            Self::Add => base + top,
            Self::Screen => base + top - base * top,
            Self::Overlay if base <= 0.5 => 2.0 * base * top,
            Self::Overlay => {
                let bright = 2.0 * base - 1.0;
                bright + top - bright * top
            }
        }
    }

    /// Stable over versions of the program.
    fn tag(self) -> i64 {
        match self {
            Self::Normal => 0,
            Self::Multiply => 1,
            Self::Add => 2,
            Self::Screen => 3,
            Self::Overlay => 4,
        }
    }
}

/// The top over the base.
///
/// Inputs: base colours, top colours and, if masked, a mask. With αt = alpha of the top · opacity ·
/// mask and αb = alpha of the base:
///
/// - α = αt + αb (1 − αt)
/// - α·C = αt (1 − αb) Ct + αt αb B(Cb, Ct) + (1 − αt) αb Cb
///
/// where B works on display-referred values and everything else in linear light. Where αt is 0 the
/// result is the base bit for bit; where αb is 0, or αt is 1 in normal mode, its colour is the
/// top's bit for bit; where both are 1 it is B.
///
/// Source: W3C Compositing and Blending Level 1, 5.
#[derive(Clone, Copy, Debug)]
pub struct Overlay {
    mode: BlendMode,
    opacity: f32,
    masked: bool,
}

impl Overlay {
    /// `opacity` is clamped to 0..=1, NaN counts as 0; `masked` says whether there is a third input.
    pub fn new(mode: BlendMode, opacity: f32, masked: bool) -> Self {
        Self {
            mode,
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

    /// One sample.
    fn composite(self, transfer: Transfer, base: [f32; 4], top: [f32; 4], weight: f32) -> [f32; 4] {
        let [br, bg, bb, ab] = base;
        let at = top[3] * weight;
        if at <= 0.0 || at.is_nan() {
            return base;
        }
        let [tr, tg, tb, _] = top;
        if ab <= 0.0 || (at >= 1.0 && self.mode == BlendMode::Normal) {
            return [tr, tg, tb, at];
        }
        let channels = [(br, tr), (bg, tg), (bb, tb)];
        if at >= 1.0 && ab >= 1.0 {
            let [r, g, b] = channels.map(|(b, t)| self.mode.blend(b, t));
            return [r, g, b, at];
        }
        let alpha = if ab >= 1.0 { ab } else { at + ab * (1.0 - at) };
        let [r, g, b] = channels.map(|(b, t)| {
            let top = transfer.decode(t);
            let met = if self.mode == BlendMode::Normal {
                top
            } else {
                let blended = transfer.decode(self.mode.blend(b, t));
                top + ab * (blended - top)
            };
            transfer.encode((at * met + (1.0 - at) * ab * transfer.decode(b)) / alpha)
        });
        [r, g, b, alpha]
    }
}

/// Some samples: red, green, blue, alpha.
type Colours = [Lanes; 4];

/// Which inputs decide a sample, in the order in which [`Overlay::composite`] asks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decides {
    Base,
    Top,
    /// B of both.
    Blend,
    /// A mixture in linear light.
    Mix,
}

impl Overlay {
    #[inline]
    fn decides(self, top_alpha: f32, base_alpha: f32) -> Decides {
        let shown = top_alpha > 0.0;
        let hides = base_alpha <= 0.0 || (top_alpha >= 1.0 && self.mode == BlendMode::Normal);
        let full = top_alpha >= 1.0 && base_alpha >= 1.0;
        let over = if full { Decides::Blend } else { Decides::Mix };
        let over = if hides { Decides::Top } else { over };
        if shown { over } else { Decides::Base }
    }

    /// [`Self::composite`] of some samples, the same bits: `base` becomes the result.
    fn composite_lanes(self, light: &Light, base: &mut Colours, top: &Colours, weight: &Lanes) {
        let mut alpha_t = top[3];
        for (a, w) in alpha_t.iter_mut().zip(weight) {
            *a *= w;
        }
        let decides: [Decides; LANES] =
            core::array::from_fn(|l| self.decides(alpha_t[l], base[3][l]));
        let all = |one| decides.iter().all(|d| *d == one);
        if all(Decides::Base) {
            return;
        }
        if all(Decides::Top) {
            base[..3].copy_from_slice(&top[..3]);
            base[3] = alpha_t;
            return;
        }
        let mixes = decides.contains(&Decides::Mix);
        let alpha_b = base[3];
        for l in 0..LANES {
            let (at, ab) = (alpha_t[l], alpha_b[l]);
            let mixed = if ab >= 1.0 { ab } else { at + ab * (1.0 - at) };
            base[3][l] = match decides[l] {
                Decides::Base => ab,
                Decides::Top | Decides::Blend => at,
                Decides::Mix => mixed,
            };
        }
        let alpha = base[3];
        for (base, top) in base.iter_mut().zip(top).take(3) {
            let mut mixed = self.blend_lanes(base, top);
            let blended = mixed;
            if mixes {
                let (mut light_b, mut light_t) = (*base, *top);
                light.decode(&mut light_b);
                light.decode(&mut light_t);
                if self.mode != BlendMode::Normal {
                    light.decode(&mut mixed);
                    for l in 0..LANES {
                        light_t[l] += alpha_b[l] * (mixed[l] - light_t[l]);
                    }
                }
                for l in 0..LANES {
                    let at = alpha_t[l];
                    let sum = at * light_t[l] + (1.0 - at) * alpha_b[l] * light_b[l];
                    // What is not mixed would only be slow to encode.
                    mixed[l] = if decides[l] == Decides::Mix {
                        sum / alpha[l]
                    } else {
                        0.0
                    };
                }
                light.encode(&mut mixed);
            }
            for l in 0..LANES {
                base[l] = match decides[l] {
                    Decides::Base => base[l],
                    Decides::Top => top[l],
                    Decides::Blend => blended[l],
                    Decides::Mix => mixed[l],
                };
            }
        }
    }

    /// B of one channel of some samples.
    fn blend_lanes(self, base: &Lanes, top: &Lanes) -> Lanes {
        let each = |blend: fn(f32, f32) -> f32| -> Lanes {
            core::array::from_fn(|l| blend(base[l], top[l]))
        };
        // Each arm is a loop of its own.
        match self.mode {
            BlendMode::Normal => *top,
            BlendMode::Multiply => each(|b, t| BlendMode::Multiply.blend(b, t)),
            BlendMode::Add => each(|b, t| BlendMode::Add.blend(b, t)),
            BlendMode::Screen => each(|b, t| BlendMode::Screen.blend(b, t)),
            BlendMode::Overlay => each(|b, t| BlendMode::Overlay.blend(b, t)),
        }
    }
}

/// A weight brought to 0..=1; NaN becomes 0.
pub(crate) fn clamped(weight: f32) -> f32 {
    if weight > 0.0 { weight.min(1.0) } else { 0.0 }
}

impl ImageNode for Overlay {
    fn kind(&self) -> &'static str {
        "overlay"
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, _grid: &Grid, id: &mut IdHasher) {
        id.int(self.mode.tag())
            .float(f64::from(self.opacity))
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
            return Known::Uniform(self.composite(
                Transfer::srgb(),
                base,
                top,
                self.opacity * mask,
            ));
        }
        let covered = self.opacity == 1.0
            && inputs[1].is_complete(Bands::Colour)
            && self.mask_known(inputs).is_complete(Bands::Mask);
        if covered || inputs[0].is_complete(Bands::Colour) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    fn identity(&self, _grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let mask = self.mask_known(inputs);
        if self.opacity == 0.0 || inputs[1].is_absent(Bands::Colour) || mask.is_absent(Bands::Mask)
        {
            return Some(0);
        }
        let unweighted = self.opacity == 1.0 && mask.is_complete(Bands::Mask);
        let covers = self.mode == BlendMode::Normal && inputs[1].is_complete(Bands::Colour);
        (unweighted && (covers || inputs[0].is_absent(Bands::Colour))).then_some(1)
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let light = Light::srgb();
        let mut out: [&mut [f32]; 4] = out.planes_mut();
        let [mut base, mut top]: [Colours; 2] = [[[0.0; LANES]; 4]; 2];
        let mut weight = [self.opacity; LANES];
        for first in (0..out[0].len()).step_by(LANES) {
            // What lies beyond the last sample is left over from before and written nowhere.
            let n = LANES.min(out[0].len() - first);
            for (lanes, input) in [&mut base, &mut top].into_iter().zip(inputs) {
                for (plane, lanes) in lanes.iter_mut().enumerate() {
                    lanes[..n].copy_from_slice(&input.plane(plane)[first..first + n]);
                }
            }
            if self.masked {
                for (w, m) in weight.iter_mut().zip(&inputs[2].plane(0)[first..first + n]) {
                    *w = self.opacity * m;
                }
            }
            self.composite_lanes(light, &mut base, &top, &weight);
            for (plane, lanes) in out.iter_mut().zip(&base) {
                plane[first..first + n].copy_from_slice(&lanes[..n]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
