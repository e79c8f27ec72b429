//! How colours meet: the modes.

use crate::nodes::lanes::{LANES, Lanes};

/// Three planes of samples.
pub(super) type Rgb = [Lanes; 3];

/// How the colours of two layers meet, before they are mixed by alpha.
///
/// B(base, top) on straight, display-referred values. Source: W3C Compositing and Blending Level 1, 9.1
/// (a channel at a time) and 9.2 (the last four); `Add`, `Subtract` are the plain sum and difference.
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
    /// The base less the top, not clamped here: darkens.
    Subtract,
    /// How far they are apart.
    Difference,
    /// Like the difference, with less contrast.
    Exclusion,
    /// The darker of each channel.
    Darken,
    /// The lighter of each channel.
    Lighten,
    /// Brightens the base to reflect the top.
    ColourDodge,
    /// Darkens the base to reflect the top.
    ColourBurn,
    /// Multiplies where the top is dark, screens where it is bright.
    HardLight,
    /// Darkens or brightens gently, as the top says.
    SoftLight,
    /// The top's hue, the base's saturation and luminosity.
    Hue,
    /// The top's saturation, the base's hue and luminosity.
    Saturation,
    /// The top's hue and saturation, the base's luminosity.
    Colour,
    /// The top's luminosity, the base's hue and saturation.
    Luminosity,
}

impl BlendMode {
    /// All of them.
    pub const ALL: [Self; 18] = [
        Self::Normal,
        Self::Multiply,
        Self::Add,
        Self::Screen,
        Self::Overlay,
        Self::Subtract,
        Self::Difference,
        Self::Exclusion,
        Self::Darken,
        Self::Lighten,
        Self::ColourDodge,
        Self::ColourBurn,
        Self::HardLight,
        Self::SoftLight,
        Self::Hue,
        Self::Saturation,
        Self::Colour,
        Self::Luminosity,
    ];

    /// Stable over versions of the program.
    pub(super) fn tag(self) -> i64 {
        // The order of `ALL` is kept for it.
        Self::ALL.iter().position(|m| *m == self).unwrap_or(0) as i64
    }

    /// B of a colour.
    #[inline(always)]
    pub(super) fn blend(self, base: [f32; 3], top: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Hue => with_luminosity(with_saturation(top, saturation(base)), luminosity(base)),
            Self::Saturation => {
                with_luminosity(with_saturation(base, saturation(top)), luminosity(base))
            }
            Self::Colour => with_luminosity(top, luminosity(base)),
            Self::Luminosity => with_luminosity(base, luminosity(top)),
            Self::Normal
            | Self::Multiply
            | Self::Add
            | Self::Screen
            | Self::Overlay
            | Self::Subtract
            | Self::Difference
            | Self::Exclusion
            | Self::Darken
            | Self::Lighten
            | Self::ColourDodge
            | Self::ColourBurn
            | Self::HardLight
            | Self::SoftLight => core::array::from_fn(|c| self.channel(base[c], top[c])),
        }
    }

    /// B of one channel; of modes that need all three the top's.
    #[inline(always)]
    fn channel(self, base: f32, top: f32) -> f32 {
        match self {
            Self::Normal | Self::Hue | Self::Saturation | Self::Colour | Self::Luminosity => top,
            Self::Multiply => base * top,
            Self::Add => base + top,
            Self::Screen => base + top - base * top,
            Self::Overlay => hard(top, base),
            Self::Subtract => base - top,
            Self::Difference => (base - top).abs(),
            Self::Exclusion => base + top - 2.0 * base * top,
            Self::Darken => base.min(top),
            Self::Lighten => base.max(top),
            Self::ColourDodge if base <= 0.0 => 0.0,
            Self::ColourDodge if top >= 1.0 => 1.0,
            Self::ColourDodge => (base / (1.0 - top)).min(1.0),
            Self::ColourBurn if base >= 1.0 => 1.0,
            Self::ColourBurn if top <= 0.0 => 0.0,
            Self::ColourBurn => 1.0 - ((1.0 - base) / top).min(1.0),
            Self::HardLight => hard(base, top),
            Self::SoftLight if top <= 0.5 => base - (1.0 - 2.0 * top) * base * (1.0 - base),
            Self::SoftLight => {
                let lit = if base <= 0.25 {
                    ((16.0 * base - 12.0) * base + 4.0) * base
                } else {
                    base.sqrt()
                };
                base + (2.0 * top - 1.0) * (lit - base)
            }
        }
    }

    /// [`Self::blend`] of some samples, the same bits.
    #[inline(always)]
    pub(super) fn blend_lanes(self, base: &Rgb, top: &Rgb) -> Rgb {
        // A mode that is known where a loop begins makes a loop of its own, which runs on vectors.
        macro_rules! each {
            ($($mode:ident)*) => {
                match self {
                    $(Self::$mode => channels(base, top, |b, t| Self::$mode.channel(b, t)),)*
                    Self::Hue | Self::Saturation | Self::Colour | Self::Luminosity => {
                        self.colours(base, top)
                    }
                }
            };
        }
        each!(Normal Multiply Add Screen Overlay Subtract Difference Exclusion Darken Lighten
              ColourDodge ColourBurn HardLight SoftLight)
    }

    /// Colour by colour.
    #[inline(always)]
    fn colours(self, base: &Rgb, top: &Rgb) -> Rgb {
        let mut met = *base;
        for l in 0..LANES {
            let colour = |planes: &Rgb| core::array::from_fn(|c| planes[c][l]);
            let blended = self.blend(colour(base), colour(top));
            for (plane, v) in met.iter_mut().zip(blended) {
                plane[l] = v;
            }
        }
        met
    }
}

/// Multiplied where `by` is dark, screened where it is bright.
#[inline(always)]
fn hard(value: f32, by: f32) -> f32 {
    if by <= 0.5 {
        2.0 * by * value
    } else {
        let bright = 2.0 * by - 1.0;
        bright + value - bright * value
    }
}

#[inline(always)]
fn channels(base: &Rgb, top: &Rgb, blend: impl Fn(f32, f32) -> f32) -> Rgb {
    core::array::from_fn(|c| core::array::from_fn(|l| blend(base[c][l], top[c][l])))
}

/// Lum of the specification.
#[inline(always)]
fn luminosity([r, g, b]: [f32; 3]) -> f32 {
    0.3 * r + 0.59 * g + 0.11 * b
}

/// Sat of the specification.
#[inline(always)]
fn saturation([r, g, b]: [f32; 3]) -> f32 {
    r.max(g).max(b) - r.min(g).min(b)
}

/// SetLum of the specification, with its ClipColor.
#[inline(always)]
fn with_luminosity(colour: [f32; 3], wanted: f32) -> [f32; 3] {
    let lift = wanted - luminosity(colour);
    let colour = colour.map(|v| v + lift);
    let [r, g, b] = colour;
    let (grey, low, high) = (luminosity(colour), r.min(g).min(b), r.max(g).max(b));
    let colour = if low < 0.0 && grey > low {
        colour.map(|v| grey + (v - grey) * grey / (grey - low))
    } else {
        colour
    };
    if high > 1.0 && high > grey {
        colour.map(|v| grey + (v - grey) * (1.0 - grey) / (high - grey))
    } else {
        colour
    }
}

/// SetSat of the specification: the smallest channel 0, the largest `wanted`.
#[inline(always)]
fn with_saturation(colour: [f32; 3], wanted: f32) -> [f32; 3] {
    let [r, g, b] = colour;
    let (low, span) = (r.min(g).min(b), saturation(colour));
    if span > 0.0 {
        colour.map(|v| (v - low) * wanted / span)
    } else {
        [0.0; 3]
    }
}
