//! White balance: the white of the light that a picture was taken in becomes the display's.

use glam::{DMat3, DVec2, DVec3};

use super::affine::{Affine, matrix};

/// The white of a picture's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhiteBalance {
    /// Colour temperature of the light in kelvin, clamped to 1667 to 25,000; [`NEUTRAL_K`] changes
    /// nothing, higher values warm the picture (they undo a bluer light).
    pub temperature_k: f64,
    /// Distance of the light's white from the locus of black bodies, −100 to 100, clamped: 100 are 0.02
    /// in CIE 1960 (u, v). Above 0 the light counts as greener, so the picture becomes more magenta.
    pub tint: f64,
}

/// Temperature of a black body whose colour temperature is that of the display's white, D65.
pub const NEUTRAL_K: f64 = 6504.0;

impl Default for WhiteBalance {
    fn default() -> Self {
        Self {
            temperature_k: NEUTRAL_K,
            tint: 0.0,
        }
    }
}

/// Steps off the locus in CIE 1960 (u, v) per unit of tint.
const DUV_PER_TINT: f64 = 2e-4;

/// XYZ of linear sRGB (IEC 61966-2-1).
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175_0],
    [0.019_333_9, 0.119_192_0, 0.950_304_1],
];

/// Responses of the Bradford transform, after which whites are scaled to each other.
const BRADFORD: [[f64; 3]; 3] = [
    [0.8951, 0.2664, -0.1614],
    [-0.7502, 1.7135, 0.0367],
    [0.0389, -0.0685, 1.0296],
];

impl WhiteBalance {
    /// The map of linear light; exactly the identity for the default.
    ///
    /// Chromatic adaptation by the Bradford transform (\[Lam85\]) from the light's
    /// white to the neutral one, both on or beside Krystek's approximation of the black-body locus.
    pub(super) fn map(self) -> Affine {
        let sane = |v: f64, default: f64| if v.is_finite() { v } else { default };
        let light = Self {
            temperature_k: sane(self.temperature_k, NEUTRAL_K).clamp(1667.0, 25_000.0),
            tint: sane(self.tint, 0.0).clamp(-100.0, 100.0),
        };
        if light == Self::default() {
            return Affine::IDENTITY;
        }
        let Self {
            temperature_k,
            tint,
        } = light;
        let to_cones = matrix(BRADFORD) * matrix(XYZ_FROM_RGB);
        let cones = |temperature_k: f64, tint: f64| {
            matrix(BRADFORD) * xyz_of_uv(white_uv(temperature_k, tint * DUV_PER_TINT))
        };
        let scale = cones(NEUTRAL_K, 0.0) / cones(temperature_k, tint);
        let map = to_cones.inverse() * DMat3::from_diagonal(scale) * to_cones;
        // Light is not changed in its luminance: a white balance is not an exposure.
        let luminance = DVec3::from(XYZ_FROM_RGB[1]);
        let white = luminance.dot(map * DVec3::ONE) / luminance.element_sum();
        let map = map * white.recip();
        Affine::of(map)
    }
}

/// CIE 1960 (u, v) of a black body, moved off the locus by `duv` (above 0 towards green).
///
/// Source: \[Kry85\]; within 8·10⁻⁵ in u and 9·10⁻⁵ in v from 1000 to 15,000 K.
fn white_uv(temperature_k: f64, duv: f64) -> DVec2 {
    let at = |t: f64| {
        DVec2::new(
            (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
                / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t),
            (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
                / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t),
        )
    };
    // With rising temperature u falls: green lies to the right of the way.
    let along = (at(temperature_k * 1.001) - at(temperature_k * 0.999)).normalize();
    at(temperature_k) + along.perp() * -duv
}

/// XYZ with Y = 1.
fn xyz_of_uv(uv: DVec2) -> DVec3 {
    let (u, v) = (uv.x, uv.y);
    DVec3::new(1.5 * u / v, 1.0, (2.0 - 0.5 * u) / v - 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn white_of(balance: WhiteBalance) -> [f64; 3] {
        balance.map().0.map(|row| row[0] + row[1] + row[2])
    }

    #[test]
    fn neutral_light_changes_nothing() {
        assert_eq!(WhiteBalance::default().map(), Affine::IDENTITY);
    }

    #[test]
    fn the_locus_is_where_tables_have_it() {
        // CIE illuminant A, 2856 K: (u, v) = (0.2560, 0.3495). Planckian 6500 K: (0.1978, 0.3115).
        let a = white_uv(2856.0, 0.0);
        assert!(
            (a.x - 0.2560).abs() < 2e-4 && (a.y - 0.3495).abs() < 2e-4,
            "{a}"
        );
        // The neutral white in XYZ lies beside the locus by less than D65's own distance, 0.0033.
        let d65 = DVec2::new(0.1978, 0.3122);
        assert!(white_uv(NEUTRAL_K, 0.0).distance(d65) < 0.004);
    }

    #[test]
    fn bluer_light_is_undone_by_warming_and_greener_light_by_magenta() {
        let [r, _, b] = white_of(WhiteBalance {
            temperature_k: 9000.0,
            tint: 0.0,
        });
        assert!(r > 1.05 && b < 0.9, "{r} {b}");
        let [r, g, b] = white_of(WhiteBalance {
            temperature_k: NEUTRAL_K,
            tint: 50.0,
        });
        assert!(g < r && g < b, "{r} {g} {b}");
    }

    #[test]
    fn luminance_of_white_stays() {
        for temperature_k in [1667.0, 3200.0, 5000.0, 12_000.0, 25_000.0] {
            for tint in [-100.0, 0.0, 100.0] {
                let white = white_of(WhiteBalance {
                    temperature_k,
                    tint,
                });
                let [r, g, b] = XYZ_FROM_RGB[1];
                let y = (r * white[0] + g * white[1] + b * white[2]) / (r + g + b);
                assert!((y - 1.0).abs() < 1e-9, "{temperature_k} {tint}: {y}");
                assert!(white.iter().all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn senseless_numbers_count_as_neutral() {
        let odd = WhiteBalance {
            temperature_k: f64::NAN,
            tint: f64::INFINITY,
        };
        assert_eq!(odd.map(), Affine::IDENTITY);
    }
}
