//! Lightness, chroma and hue as the eye has them.

use glam::{DMat3, DVec3};
use relievo_raster::power::power;

use super::affine::{Affine, matrix};

/// Adjustments in Oklab: of linear light to cones, their cube roots, an affine map, and back.
///
/// Source: \[Ott20\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Perceptual {
    /// Cone responses of linear light, after whatever comes before.
    cones: [[f32; 4]; 3],
    /// Of their cube roots.
    roots: [[f32; 4]; 3],
    /// Linear light of cone responses.
    light: [[f32; 4]; 3],
}

/// Cone responses of linear sRGB.
const CONES: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];

/// Lightness, a and b of the cube roots of cone responses.
const LAB: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];

/// What is done to lightness and chroma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strokes {
    pub(super) brightness: f64,
    pub(super) contrast: f64,
    pub(super) hue_rad: f64,
    pub(super) saturation: f64,
}

impl Strokes {
    /// Nothing done.
    pub(super) const NONE: Self = Self {
        brightness: 0.0,
        contrast: 1.0,
        hue_rad: 0.0,
        saturation: 1.0,
    };
}

impl Perceptual {
    /// After a map of linear light.
    pub(super) fn after(first: Affine, strokes: Strokes) -> Self {
        let cones = matrix(CONES);
        let lab = matrix(LAB);
        let (sin, cos) = libm::sincos(strokes.hue_rad);
        let chroma = strokes.saturation;
        let turned = DMat3::from_cols(
            DVec3::new(strokes.contrast, 0.0, 0.0),
            DVec3::new(0.0, chroma * cos, chroma * sin),
            DVec3::new(0.0, -chroma * sin, chroma * cos),
        );
        let back = lab.inverse();
        let lift = 0.5 * (1.0 - strokes.contrast) + strokes.brightness * strokes.contrast;
        let lift = back * DVec3::new(lift, 0.0, 0.0);
        let mut roots = Affine::of(back * turned * lab);
        for (row, lift) in roots.0.iter_mut().zip(lift.to_array()) {
            row[3] = lift;
        }
        Self {
            cones: Affine::linear(CONES).after(first).singles(),
            roots: roots.singles(),
            light: Affine::of(cones.inverse()).singles(),
        }
    }

    /// Linear light to linear light.
    #[inline(always)]
    pub(super) fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let cones = self.cones.map(|row| channel(row, rgb));
        let roots = cones.map(|v| power(v, 1.0 / 3.0));
        let roots = self.roots.map(|row| channel(row, roots));
        let cones = roots.map(|v| v * v * v);
        self.light.map(|row| channel(row, cones))
    }

    pub(super) fn numbers(&self) -> impl Iterator<Item = f32> {
        let maps = [self.cones, self.roots, self.light];
        maps.into_iter().flatten().flatten()
    }
}

#[inline(always)]
pub(super) fn channel(row: [f32; 4], [r, g, b]: [f32; 3]) -> f32 {
    row[0] * r + row[1] * g + row[2] * b + row[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lab([r, g, b]: [f32; 3]) -> DVec3 {
        let cones = matrix(CONES) * DVec3::new(r.into(), g.into(), b.into());
        matrix(LAB) * cones.map(libm::cbrt)
    }

    #[test]
    fn nothing_done_leaves_the_colour() {
        let nothing = Perceptual::after(Affine::IDENTITY, Strokes::NONE);
        for rgb in [[0.0; 3], [1.0; 3], [0.8, 0.1, 0.02], [0.0, 0.3, 1.0]] {
            let found = nothing.apply(rgb);
            assert!(
                rgb.iter().zip(found).all(|(a, b)| (a - b).abs() < 4e-6),
                "{rgb:?} {found:?}"
            );
        }
    }

    #[test]
    fn white_is_of_lightness_one_and_without_chroma() {
        let white = lab([1.0; 3]);
        assert!(
            white.abs_diff_eq(DVec3::new(1.0, 0.0, 0.0), 1e-6),
            "{white}"
        );
    }

    #[test]
    fn hue_and_saturation_keep_lightness_and_brightness_keeps_hue() {
        let rgb = [0.3, 0.4, 0.2];
        let before = lab(rgb);
        let turned = lab(Perceptual::after(
            Affine::IDENTITY,
            Strokes {
                hue_rad: 0.7,
                saturation: 1.2,
                ..Strokes::NONE
            },
        )
        .apply(rgb));
        assert!((turned.x - before.x).abs() < 1e-5);
        let chroma = |lab: DVec3| lab.y.hypot(lab.z);
        assert!((chroma(turned) / chroma(before) - 1.2).abs() < 1e-4);
        let angle = |lab: DVec3| libm::atan2(lab.z, lab.y);
        assert!((angle(turned) - angle(before) - 0.7).abs() < 1e-4);
        let lifted = lab(Perceptual::after(
            Affine::IDENTITY,
            Strokes {
                brightness: 0.1,
                ..Strokes::NONE
            },
        )
        .apply(rgb));
        assert!((lifted - before).abs_diff_eq(DVec3::new(0.1, 0.0, 0.0), 1e-5));
    }
}
