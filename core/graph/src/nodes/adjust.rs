//! Brightness, contrast, hue, saturation, gamma, gain and offset of colours.

use relievo_planet::Grid;
use relievo_raster::power::power;
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::lanes::{self, Colours, LANES};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

/// Rec. 709 weights of red, green and blue in luma.
const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What to adjust; the default changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdjustParams {
    /// Factor of each channel (red, green, blue).
    pub gain: [f64; 3],
    /// Added to each channel after `gain`, in display-referred units (1 is white).
    pub offset: [f64; 3],
    /// Factor of all channels: 0 is black, 1 unchanged.
    pub brightness: f64,
    /// Factor of the distance to middle grey (0.5): 0 is grey, 1 unchanged.
    pub contrast: f64,
    /// Rotation of hue in degrees; any finite angle.
    pub hue_deg: f64,
    /// Factor of the distance to the grey of equal luma: 0 is grey, 1 unchanged.
    pub saturation: f64,
    /// Exponent 1 / gamma of each channel: above 1 brightens the middle. Clamped to 0.01 to 100.
    pub gamma: f64,
}

impl Default for AdjustParams {
    fn default() -> Self {
        Self {
            gain: [1.0; 3],
            offset: [0.0; 3],
            brightness: 1.0,
            contrast: 1.0,
            hue_deg: 0.0,
            saturation: 1.0,
            gamma: 1.0,
        }
    }
}

/// Adjusted colours; input: colours. Works on straight, display-referred values, as users know them
/// from image editors, in this order:
///
/// 1. gain and offset: c·gain + offset
/// 2. brightness: c·b
/// 3. contrast: ½ + (c − ½)·k
/// 4. hue: a rotation about the grey axis that keeps luma
/// 5. saturation: y + (c − y)·s, y the Rec. 709 luma
/// 6. gamma: c^(1/γ), for negative values −|c|^(1/γ)
///
/// Steps 1 to 5 are one affine map. Alpha stays; what is transparent stays nothing. Values are not
/// clamped here: sinks do that.
///
/// Sources: order and meaning of brightness and contrast as in CesiumJS' imagery layers, except that
/// gamma comes last; the hue matrix is `hueRotate` of W3C Filter Effects 1 with Rec. 709 weights.
#[derive(Clone, Copy, Debug)]
pub struct Adjust {
    /// Rows: one output channel from (red, green, blue, 1).
    matrix: [[f32; 4]; 3],
    /// 1 / γ.
    exponent: f32,
    /// Of both.
    name: ContentId,
}

impl Adjust {
    /// Values that are not finite count as their defaults.
    pub fn new(params: &AdjustParams) -> Self {
        let sane = |v: f64, default: f64| if v.is_finite() { v } else { default };
        let mut map = IDENTITY;
        for (c, row) in map.iter_mut().enumerate() {
            row[c] = sane(params.gain[c], 1.0);
            row[3] = sane(params.offset[c], 0.0);
        }
        let (b, k) = (sane(params.brightness, 1.0), sane(params.contrast, 1.0));
        for row in &mut map {
            for v in row.iter_mut() {
                *v *= b * k;
            }
            row[3] += 0.5 * (1.0 - k);
        }
        let hue_deg = sane(params.hue_deg, 0.0).rem_euclid(360.0);
        if hue_deg != 0.0 {
            map = after(&hue_rotation(hue_deg.to_radians()), &map);
        }
        let saturation = sane(params.saturation, 1.0);
        if saturation != 1.0 {
            map = after(&luma_mix(saturation), &map);
        }
        let gamma = sane(params.gamma, 1.0).clamp(0.01, 100.0);
        let matrix = map.map(|row| row.map(|v| v as f32 + 0.0));
        let exponent = (1.0 / gamma) as f32;
        let mut name = IdHasher::default();
        for v in matrix.as_flattened() {
            name.float(f64::from(*v));
        }
        Self {
            matrix,
            exponent,
            name: name.float(f64::from(exponent)).finish(),
        }
    }

    fn is_identity(&self) -> bool {
        self.exponent == 1.0 && self.matrix == IDENTITY.map(|row| row.map(|v| v as f32))
    }

    #[inline(always)]
    fn channel(&self, row: usize, rgb: [f32; 3]) -> f32 {
        let m = &self.matrix[row];
        m[0] * rgb[0] + m[1] * rgb[1] + m[2] * rgb[2] + m[3]
    }

    /// Some colours; `last` makes the last step of each channel.
    #[inline(always)]
    fn adjust_lanes(&self, colours: &mut Colours, last: impl Fn(f32) -> f32) {
        let [r, g, b, a] = *colours;
        for (row, out) in colours.iter_mut().take(3).enumerate() {
            for (l, v) in out.iter_mut().enumerate() {
                let adjusted = last(self.channel(row, [r[l], g[l], b[l]]));
                *v = if a[l] > 0.0 { adjusted } else { 0.0 };
            }
        }
    }

    /// All samples of planes.
    #[inline(always)]
    fn adjust_planes(&self, planes: [&[f32]; 4], out: &mut [&mut [f32]; 4]) {
        let mut colours = [[0.0; LANES]; 4];
        for first in (0..planes[0].len()).step_by(LANES) {
            // What lies beyond the last sample is left over from before and written nowhere.
            lanes::read(planes, first, &mut colours);
            if self.exponent == 1.0 {
                self.adjust_lanes(&mut colours, |v| v);
            } else {
                self.adjust_lanes(&mut colours, |v| power(v, self.exponent));
            }
            for (plane, lanes) in out.iter_mut().zip(&colours) {
                lanes::write(lanes, plane, first);
            }
        }
    }

    /// One colour.
    fn colour(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let mut out = [0.0; 4];
        if a > 0.0 {
            for (c, v) in out.iter_mut().take(3).enumerate() {
                let affine = self.channel(c, [r, g, b]);
                *v = if self.exponent == 1.0 {
                    affine
                } else {
                    power(affine, self.exponent)
                };
            }
            out[3] = a;
        }
        out
    }
}

/// Rows of an affine map of (red, green, blue, 1).
type Affine = [[f64; 4]; 3];

const IDENTITY: Affine = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

/// `second` after `first`.
fn after(second: &[[f64; 3]; 3], first: &Affine) -> Affine {
    second.map(|row| {
        core::array::from_fn(|c| row[0] * first[0][c] + row[1] * first[1][c] + row[2] * first[2][c])
    })
}

/// luma + s · (colour − luma).
fn luma_mix(s: f64) -> [[f64; 3]; 3] {
    core::array::from_fn(|r| {
        core::array::from_fn(|c| LUMA[c] * (1.0 - s) + if r == c { s } else { 0.0 })
    })
}

/// Rotation about the grey axis within planes of equal luma: L + cos·(I − L) + sin·S, where S turns
/// by a right angle and its rows, weighted by luma, add up to nothing.
fn hue_rotation(angle_rad: f64) -> [[f64; 3]; 3] {
    let [lr, lg, lb] = LUMA;
    let (sin, cos) = libm::sincos(angle_rad);
    let quarter = [
        [-lr, -lg, 1.0 - lb],
        [
            (lr * lr + lb * (1.0 - lr)) / lg,
            lr - lb,
            -(lr * (1.0 - lb) + lb * lb) / lg,
        ],
        [lr - 1.0, lg, lb],
    ];
    let mix = luma_mix(cos);
    core::array::from_fn(|r| core::array::from_fn(|c| mix[r][c] + sin * quarter[r][c]))
}

impl ImageNode for Adjust {
    fn kind(&self) -> &'static str {
        "adjust"
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
        id.id(self.name);
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform(rgba) => Known::Uniform(self.colour(rgba)),
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
