//! Colours adjusted as in an image editor, never baked.

mod affine;
mod clear;
mod curve;
mod perceptual;
mod white;

use relievo_planet::Grid;
use relievo_raster::colour::{decode_each, encode_each};
use relievo_raster::power::power;
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::lanes::{self, Colours, LANES};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use affine::Affine;
pub use clear::Clear;
pub use curve::Curve;
use curve::Table;
use perceptual::{Perceptual, Strokes, channel};
pub use white::{NEUTRAL_K, WhiteBalance};

/// Which values gain, offset, brightness, contrast, hue and saturation work on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AdjustSpace {
    /// Display values (sRGB encoded), as image editors do.
    #[default]
    Display,
    /// Linear light, as a camera would.
    Linear,
    /// Gain and offset on linear light, the rest on lightness, chroma and hue as the eye has them (Oklab):
    /// hue and saturation change no lightness.
    Perceptual,
}

/// What to adjust; the default changes nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct AdjustParams {
    /// The values most steps work on.
    pub space: AdjustSpace,
    /// The light the picture was taken in.
    pub white: WhiteBalance,
    /// Rows of a matrix: one output channel from red, green and blue; the identity by default.
    pub mix: [[f64; 3]; 3],
    /// Factor of each channel (red, green, blue).
    pub gain: [f64; 3],
    /// Added to each channel after `gain`, 1 is white.
    pub offset: [f64; 3],
    /// Added to all channels: 0 changes nothing.
    pub brightness: f64,
    /// Factor of the distance to the middle: 0 is grey, 1 unchanged.
    pub contrast: f64,
    /// Rotation of hue in degrees; any finite angle.
    pub hue_deg: f64,
    /// Factor of the distance to the grey of equal luma: 0 is grey, 1 unchanged.
    pub saturation: f64,
    /// Exponent 1 / gamma of each channel's display value: above 1 brightens the middle. Clamped to 0.01
    /// to 100.
    pub gamma: f64,
    /// Tone curve of all channels' display values.
    pub curve: Curve,
    /// Tone curves of red, green and blue, after the common one.
    pub curves: [Curve; 3],
    /// Whether display values are turned over: 1 − c.
    pub invert: bool,
    /// A colour that becomes transparent.
    pub clear: Option<Clear>,
    /// How much of all this is shown: 0 the colours as they were, 1 adjusted; beyond is beyond.
    pub strength: f64,
}

impl Default for AdjustParams {
    fn default() -> Self {
        Self {
            space: AdjustSpace::Display,
            white: WhiteBalance::default(),
            mix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            gain: [1.0; 3],
            offset: [0.0; 3],
            brightness: 0.0,
            contrast: 1.0,
            hue_deg: 0.0,
            saturation: 1.0,
            gamma: 1.0,
            curve: Curve::default(),
            curves: [const { Curve::new() }; 3],
            invert: false,
            clear: None,
            strength: 1.0,
        }
    }
}

/// Adjusted colours; input: colours, straight and display-referred. The order of the steps:
///
/// 1. white balance, on linear light
/// 2. mix, gain, offset: M c · gain + offset
/// 3. brightness: c + b
/// 4. contrast: p + (c − p)·k, p = ½; on linear light 0.214, which is ½ on the display
/// 5. hue: a rotation about the grey axis that keeps luma
/// 6. saturation: y + (c − y)·s, y the Rec. 709 luma
/// 7. gamma: c^(1/γ), for negative values −|c|^(1/γ), on display values
/// 8. tone curves, the common one first, on display values
/// 9. inversion, on display values
/// 10. colour to alpha, on display values
/// 11. strength: a mix with the colour as it was
///
/// Steps 2 to 6 work in the space that is asked for and are one affine map (in [`AdjustSpace::Perceptual`]
/// two). Alpha stays but for step 10; what is transparent stays nothing. Values are not clamped here,
/// except by tone curves: sinks do that.
#[derive(Clone, Debug)]
pub struct Adjust {
    /// On linear light.
    light: Option<Light>,
    /// On display values.
    display: [[f32; 4]; 3],
    /// 1 / γ.
    exponent: f32,
    /// One a channel, where any curve bends; inverted already.
    curves: Option<[Table; 3]>,
    /// Only where there are no curves.
    invert: bool,
    clear: Option<Clear>,
    strength: f32,
    /// Of all of it.
    name: ContentId,
}

/// What is done to linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Light {
    Affine([[f32; 4]; 3]),
    Perceptual(Perceptual),
}

/// Linear light that is shown as ½.
const MIDDLE_OF_LIGHT: f64 = 0.214_041_140_482_232_55;

impl Adjust {
    /// Values that are not finite count as their defaults.
    pub fn new(params: &AdjustParams) -> Self {
        let sane = |v: f64, default: f64| if v.is_finite() { v } else { default };
        let mix = core::array::from_fn(|r| {
            core::array::from_fn(|c| sane(params.mix[r][c], if r == c { 1.0 } else { 0.0 }))
        });
        let mixed = Affine::linear(mix);
        let gained = Affine::channels(
            params.gain.map(|v| sane(v, 1.0)),
            params.offset.map(|v| sane(v, 0.0)),
        )
        .after(mixed);
        let brightness = sane(params.brightness, 0.0);
        let contrast = sane(params.contrast, 1.0);
        let hue_deg = sane(params.hue_deg, 0.0).rem_euclid(360.0);
        let saturation = sane(params.saturation, 1.0);
        let strokes = |pivot: f64| {
            let mut map = Affine::channels([1.0; 3], [brightness; 3]).after(gained);
            map = Affine::contrast(contrast, pivot).after(map);
            if hue_deg != 0.0 {
                map = Affine::hue(hue_deg.to_radians()).after(map);
            }
            if saturation != 1.0 {
                map = Affine::saturation(saturation).after(map);
            }
            map
        };
        let white = params.white.map();
        let affine = |map: Affine| (map != Affine::IDENTITY).then(|| Light::Affine(map.singles()));
        let (light, display) = match params.space {
            AdjustSpace::Display => (affine(white), strokes(0.5)),
            AdjustSpace::Linear => (
                affine(strokes(MIDDLE_OF_LIGHT).after(white)),
                Affine::IDENTITY,
            ),
            AdjustSpace::Perceptual => {
                let strokes = Strokes {
                    brightness,
                    contrast,
                    hue_rad: hue_deg.to_radians(),
                    saturation,
                };
                let first = gained.after(white);
                let light = if strokes == Strokes::NONE {
                    affine(first)
                } else {
                    Some(Light::Perceptual(Perceptual::after(first, strokes)))
                };
                (light, Affine::IDENTITY)
            }
        };
        let bent = !params.curve.is_identity() || params.curves.iter().any(|c| !c.is_identity());
        let curves = bent.then(|| {
            let tables = params.curves.each_ref();
            tables.map(|own| Table::of(|v| turned(own.at(params.curve.at(v)), params.invert)))
        });
        let mut node = Self {
            light,
            display: display.singles(),
            exponent: (1.0 / sane(params.gamma, 1.0).clamp(0.01, 100.0)) as f32,
            invert: params.invert && curves.is_none(),
            curves,
            clear: params.clear.map(Clear::sane),
            strength: sane(params.strength, 1.0) as f32,
            name: IdHasher::default().finish(),
        };
        node.name = node.named();
        node
    }

    /// The name of what it does.
    fn named(&self) -> ContentId {
        let mut name = IdHasher::default();
        let float = |name: &mut IdHasher, v: f32| {
            name.float(f64::from(v));
        };
        match self.light {
            None => name.int(0),
            Some(Light::Affine(_)) => name.int(1),
            Some(Light::Perceptual(_)) => name.int(2),
        };
        match &self.light {
            None => {}
            Some(Light::Affine(map)) => {
                map.as_flattened().iter().for_each(|v| float(&mut name, *v));
            }
            Some(Light::Perceptual(maps)) => maps.numbers().for_each(|v| float(&mut name, v)),
        }
        for v in self.display.as_flattened() {
            float(&mut name, *v);
        }
        float(&mut name, self.exponent);
        name.int(i64::from(self.invert));
        name.int(i64::from(self.curves.is_some()));
        for table in self.curves.iter().flatten() {
            for v in table.values() {
                float(&mut name, *v);
            }
        }
        name.int(i64::from(self.clear.is_some()));
        if let Some(clear) = self.clear {
            for v in clear.rgb.into_iter().chain([clear.from, clear.to]) {
                name.float(v);
            }
        }
        float(&mut name, self.strength);
        name.finish()
    }

    fn is_identity(&self) -> bool {
        let untouched = self.light.is_none()
            && self.display == Affine::IDENTITY.singles()
            && self.exponent == 1.0
            && self.curves.is_none()
            && !self.invert
            && self.clear.is_none();
        untouched || self.strength == 0.0
    }

    /// Some colours.
    #[inline(always)]
    fn adjust_lanes(&self, colours: &mut Colours) {
        let before = *colours;
        if let Some(light) = &self.light {
            let [red, green, blue, _] = colours;
            for lanes in [&mut *red, &mut *green, &mut *blue] {
                decode_each(lanes);
            }
            match light {
                Light::Affine(map) => map_lanes(map, colours),
                Light::Perceptual(map) => {
                    each_colour(colours, |rgb, _| *rgb = map.apply(*rgb));
                }
            }
            for lanes in colours.iter_mut().take(3) {
                encode_each(lanes);
            }
        }
        map_lanes(&self.display, colours);
        if self.exponent != 1.0 {
            for v in colours[..3].as_flattened_mut() {
                *v = power(*v, self.exponent);
            }
        }
        if let Some(tables) = &self.curves {
            for (lanes, table) in colours.iter_mut().zip(tables) {
                for v in lanes {
                    *v = table.at(*v);
                }
            }
        } else if self.invert {
            for v in colours[..3].as_flattened_mut() {
                *v = 1.0 - *v;
            }
        }
        if let Some(clear) = &self.clear {
            each_colour(colours, |rgb, alpha| {
                let left;
                (*rgb, left) = clear.apply(*rgb);
                *alpha *= left;
            });
        }
        if self.strength != 1.0 {
            self.weaken(&before, colours);
        }
        // What is transparent is nothing.
        let [red, green, blue, alpha] = colours;
        for lanes in [red, green, blue] {
            for (v, a) in lanes.iter_mut().zip(&*alpha) {
                *v = if *a > 0.0 { *v } else { 0.0 };
            }
        }
    }

    /// A mix with the colours as they were, by what each covers: nothing of a cleared colour shows.
    #[inline(always)]
    fn weaken(&self, before: &Colours, colours: &mut Colours) {
        let s = self.strength;
        for l in 0..LANES {
            let (was, is) = (before[3][l], colours[3][l]);
            let alpha = was + s * (is - was);
            for c in 0..3 {
                let (old, new) = (before[c][l], colours[c][l]);
                colours[c][l] = if was == is {
                    old + s * (new - old)
                } else {
                    (was * old + s * (is * new - was * old)) / alpha
                };
            }
            colours[3][l] = alpha.clamp(0.0, 1.0);
        }
    }

    /// All samples of planes.
    #[inline(always)]
    fn adjust_planes(&self, planes: [&[f32]; 4], out: &mut [&mut [f32]; 4]) {
        let mut colours = [[0.0; LANES]; 4];
        for first in (0..planes[0].len()).step_by(LANES) {
            // What lies beyond the last sample is left over from before and written nowhere.
            lanes::read(planes, first, &mut colours);
            self.adjust_lanes(&mut colours);
            for (plane, lanes) in out.iter_mut().zip(&colours) {
                lanes::write(lanes, plane, first);
            }
        }
    }

    /// One colour, straight and display-referred: the same bits as in a picture.
    pub fn colour(&self, rgba: [f32; 4]) -> [f32; 4] {
        let mut colours = rgba.map(|v| [v; LANES]);
        self.adjust_lanes(&mut colours);
        colours.map(|lanes| lanes[0])
    }
}

/// Calls `each` with every colour and its alpha.
#[inline(always)]
fn each_colour(colours: &mut Colours, each: impl Fn(&mut [f32; 3], &mut f32)) {
    let [red, green, blue, alpha] = colours;
    let lanes = red.iter_mut().zip(green).zip(blue).zip(alpha);
    for (((r, g), b), a) in lanes {
        let mut rgb = [*r, *g, *b];
        each(&mut rgb, a);
        [*r, *g, *b] = rgb;
    }
}

/// A display value, turned over or not.
fn turned(v: f64, over: bool) -> f64 {
    if over { 1.0 - v } else { v }
}

#[inline(always)]
fn map_lanes(map: &[[f32; 4]; 3], colours: &mut Colours) {
    let [r, g, b, _] = *colours;
    for (row, out) in map.iter().zip(colours.iter_mut()) {
        for (l, v) in out.iter_mut().enumerate() {
            *v = channel(*row, [r[l], g[l], b[l]]);
        }
    }
}

impl ImageNode for Adjust {
    fn kind(&self) -> &'static str {
        "adjust"
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
            Known::Uniform(rgba) => Known::Uniform(self.colour(rgba)),
            Known::Complete if self.clear.is_some() => Known::Nothing,
            unknown @ (Known::Complete | Known::Nothing) => unknown,
        }
    }

    fn identity(&self, _grid: &Grid, inputs: &[Known]) -> Option<usize> {
        (self.is_identity() || inputs[0].is_absent(Bands::Colour)).then_some(0)
    }

    fn render(&self, _job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let planes = lanes::planes(inputs[0]);
        let mut out: [&mut [f32]; 4] = out.planes_mut();
        on_widest(
            #[inline(always)]
            || self.adjust_planes(planes, &mut out),
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests;
