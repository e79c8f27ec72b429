//! Colours over colours.

mod blend;

use relievo_planet::Grid;
use relievo_raster::colour::{decode_each, encode_each, linear_from_srgb, srgb_from_linear};
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::lanes::{self, Colours, LANES, Lanes};
use crate::{IdHasher, ImageNode, Job, Known, RenderError};
pub use blend::BlendMode;

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
    fn composite(self, base: [f32; 4], top: [f32; 4], weight: f32) -> [f32; 4] {
        let [br, bg, bb, ab] = base;
        let at = top[3] * weight;
        if at <= 0.0 || at.is_nan() {
            return base;
        }
        let [tr, tg, tb, _] = top;
        if ab <= 0.0 || (at >= 1.0 && self.mode == BlendMode::Normal) {
            return [tr, tg, tb, at];
        }
        let blended = self.mode.blend([br, bg, bb], [tr, tg, tb]);
        if at >= 1.0 && ab >= 1.0 {
            let [r, g, b] = blended;
            return [r, g, b, at];
        }
        let alpha = if ab >= 1.0 { ab } else { at + ab * (1.0 - at) };
        let channels = [
            (br, tr, blended[0]),
            (bg, tg, blended[1]),
            (bb, tb, blended[2]),
        ];
        let [r, g, b] = channels.map(|(b, t, blended)| {
            let top = linear_from_srgb(t);
            let met = if self.mode == BlendMode::Normal {
                top
            } else {
                top + ab * (linear_from_srgb(blended) - top)
            };
            srgb_from_linear((at * met + (1.0 - at) * ab * linear_from_srgb(b)) / alpha)
        });
        [r, g, b, alpha]
    }
}

/// For each of some samples all bits, or none.
type Mask = [u32; LANES];

/// The samples of which something is so.
#[inline(always)]
fn those(is_so: impl Fn(usize) -> bool) -> Mask {
    core::array::from_fn(|l| if is_so(l) { u32::MAX } else { 0 })
}

/// Whether it is so of all. Not short-circuited, so that it runs on vectors.
#[inline(always)]
fn all(mask: &Mask) -> bool {
    mask.iter().fold(u32::MAX, |all, m| all & m) == u32::MAX
}

/// Whether it is so of none.
#[inline(always)]
fn none(mask: &Mask) -> bool {
    mask.iter().fold(0, |any, m| any | m) == 0
}

/// One of two values, by bits: of a choice between values in memory the compiler would make a choice
/// between places in memory, which no vector can follow.
#[inline(always)]
fn choose(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits((yes.to_bits() & mask) | (no.to_bits() & !mask))
}

impl Overlay {
    /// [`Self::composite`] of some samples, the same bits: `base` becomes the result.
    #[inline(always)]
    fn composite_lanes(self, base: &mut Colours, top: &Colours, weight: &Lanes) {
        let normal = self.mode == BlendMode::Normal;
        let mut alpha_t = top[3];
        for (a, w) in alpha_t.iter_mut().zip(weight) {
            *a *= w;
        }
        let alpha_b = base[3];
        // In the order in which `composite` asks: who decides a sample.
        let shows = those(|l| alpha_t[l] > 0.0);
        if none(&shows) {
            return;
        }
        let hides =
            those(|l| (shows[l] != 0) & ((alpha_b[l] <= 0.0) | (normal & (alpha_t[l] >= 1.0))));
        if all(&hides) {
            base[..3].copy_from_slice(&top[..3]);
            base[3] = alpha_t;
            return;
        }
        let blends = those(|l| (alpha_t[l] >= 1.0) & (alpha_b[l] >= 1.0) & (hides[l] == 0));
        let mixes: Mask = core::array::from_fn(|l| shows[l] & !hides[l] & !blends[l]);

        let over_opaque = all(&those(|l| alpha_b[l] == 1.0));
        for (l, alpha) in base[3].iter_mut().enumerate() {
            let (at, ab) = (alpha_t[l], alpha_b[l]);
            let mixed = at + ab * (1.0 - at);
            let mixed = if ab >= 1.0 { ab } else { mixed };
            *alpha = choose(mixes[l], mixed, choose(shows[l], at, ab));
        }
        let alpha = base[3];
        let (only_mixes, any_mixes) = (all(&mixes), !none(&mixes));
        let [br, bg, bb, _] = *base;
        let [tr, tg, tb, _] = *top;
        let met = self.mode.blend_lanes(&[br, bg, bb], &[tr, tg, tb]);
        for ((base, top), blended) in base.iter_mut().zip(top).zip(&met) {
            let mut mixed = *blended;
            if any_mixes {
                let (mut light_b, mut light_t) = (*base, *top);
                decode_each(&mut light_b);
                decode_each(&mut light_t);
                if !normal {
                    decode_each(&mut mixed);
                    for l in 0..LANES {
                        light_t[l] += alpha_b[l] * (mixed[l] - light_t[l]);
                    }
                }
                for l in 0..LANES {
                    let at = alpha_t[l];
                    mixed[l] = at * light_t[l] + (1.0 - at) * alpha_b[l] * light_b[l];
                }
                // Divided by 1 it stays what it is.
                if !over_opaque {
                    for l in 0..LANES {
                        mixed[l] /= alpha[l];
                    }
                }
                encode_each(&mut mixed);
            }
            if only_mixes {
                *base = mixed;
            } else {
                for l in 0..LANES {
                    let over = choose(blends[l], blended[l], mixed[l]);
                    let over = choose(hides[l], top[l], over);
                    base[l] = choose(shows[l], over, base[l]);
                }
            }
        }
    }

    /// All samples of planes.
    #[inline(always)]
    fn composite_planes(
        self,
        base_planes: [&[f32]; 4],
        top_planes: [&[f32]; 4],
        mask: Option<&[f32]>,
        out: &mut [&mut [f32]; 4],
    ) {
        let [mut base, mut top]: [Colours; 2] = [[[0.0; LANES]; 4]; 2];
        let mut weight = [self.opacity; LANES];
        for first in (0..out[0].len()).step_by(LANES) {
            // What lies beyond the last sample is left over from before and written nowhere.
            lanes::read(base_planes, first, &mut base);
            lanes::read(top_planes, first, &mut top);
            if let Some(mask) = mask {
                lanes::copy(&mask[first..], &mut weight);
                for w in &mut weight {
                    *w *= self.opacity;
                }
            }
            self.composite_lanes(&mut base, &top, &weight);
            for (plane, lanes) in out.iter_mut().zip(&base) {
                lanes::write(lanes, plane, first);
            }
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

    fn version(&self) -> u32 {
        2
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
            return Known::Uniform(self.composite(base, top, self.opacity * mask));
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
        let (base, top) = (lanes::planes(inputs[0]), lanes::planes(inputs[1]));
        let mask = self.masked.then(|| inputs[2].plane(0));
        let mut out: [&mut [f32]; 4] = out.planes_mut();
        on_widest(
            #[inline(always)]
            || self.composite_planes(base, top, mask, &mut out),
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests;
