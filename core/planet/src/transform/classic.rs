//! The map transforms that \[CH06\] prints, kept as comparisons for measurements only.
//!
//! Nothing that draws uses them; `relievo report --suite transform` shows what they cost. Twins:
//! `lib/classic.wgsl`, same names and order.

use glam::Vec2;

use crate::transform::atan2_poly;

/// Half of θ̃ at which \[CH06\] begins to approximate: π/1024, and where blending ends.
pub const APPROXIMATE_BELOW_RAD: f32 = core::f32::consts::PI / 1024.0;

/// Nearest colatitude to a pole at which \[CH06\] approximates, π/48.
pub const APPROXIMATE_FROM_POLE_RAD: f32 = core::f32::consts::PI / 48.0;

/// What the forms need of the focus, rounded from f64 as the CPU hands it to a shader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassicFocus {
    /// θv.
    pub colat_rad: f32,
    /// (sin θv, cos θv).
    pub sin_cos_colat: Vec2,
    /// D(θv); see [`map_delta_approximate`].
    pub distortion: f32,
}

impl ClassicFocus {
    /// At a colatitude of 0 to π.
    pub fn new(colat_rad: f64) -> Self {
        use core::f64::consts::{FRAC_1_PI, PI};
        let q = colat_rad / PI - 0.5;
        let distortion = 1.0 + FRAC_1_PI / (0.25 - q * q) - q * q / 6.0 - 4.0 * FRAC_1_PI;
        let (sin_colat, cos_colat) = libm::sincos(colat_rad);
        Self {
            colat_rad: colat_rad as f32,
            sin_cos_colat: Vec2::new(sin_colat as f32, cos_colat as f32),
            distortion: distortion as f32,
        }
    }
}

/// (px, pz, ρ²) of a vertex \[u, v, 1 − w\].
#[inline]
fn rotated([u, v, one_minus_w]: [f32; 3], focus: &ClassicFocus) -> [f32; 3] {
    let Vec2 { x: s, y: c } = focus.sin_cos_colat;
    let w = 1.0 - one_minus_w;
    let px = s * w + c * u;
    [px, c * w - s * u, px * px + v * v]
}

/// \[CH06\] eq. 4: Δθ = acos(p_z) − θv, Δφ = atan2(v, px), with the library's functions.
///
/// The difference cancels: near the focus it loses everything below 10⁻⁷ rad and more where
/// |p_z| is near 1.
#[inline]
pub fn map_delta_printed(vertex: [f32; 3], focus: &ClassicFocus) -> Vec2 {
    let [px, pz, _] = rotated(vertex, focus);
    Vec2::new(
        libm::atan2f(vertex[1], px),
        libm::acosf(pz.clamp(-1.0, 1.0)) - focus.colat_rad,
    )
}

/// [`map_delta_printed`] with the polynomial; acos(p_z) as the angle of (p_z, ρ).
#[inline]
pub fn map_delta_printed_poly(vertex: [f32; 3], focus: &ClassicFocus) -> Vec2 {
    let [px, pz, rho_squared] = rotated(vertex, focus);
    Vec2::new(
        atan2_poly(vertex[1], px),
        atan2_poly(rho_squared.sqrt(), pz) - focus.colat_rad,
    )
}

/// \[CH06\] eq. 11 and 14: Δφ ≈ v · D(θv), Δθ ≈ u, with the empirical distortion
/// D = 1 + (1/π) / (¼ − q²) − q²/6 − 4/π, q = θv/π − ½, which stands for 1 / sin θv.
///
/// Eq. 14 prints θ̃; Δθ has a sign, so this reads it as the southward part u. Meant for
/// π/48 < θv < 47π/48 and θ̃ < π/1024, where D is good to 10⁻³; not finite at a pole.
#[inline]
pub fn map_delta_approximate(vertex: [f32; 3], focus: &ClassicFocus) -> Vec2 {
    Vec2::new(vertex[1] * focus.distortion, vertex[0])
}

/// How much of the approximation is used at a vertex: 1 up to θ̃ = π/1024, 0 from π/512 and near the
/// poles, as \[CH06\] 4.2 asks for without saying how.
#[inline]
fn approximation_share(vertex: [f32; 3], focus: &ClassicFocus) -> f32 {
    let from_pole = focus.colat_rad.min(core::f32::consts::PI - focus.colat_rad);
    if from_pole < APPROXIMATE_FROM_POLE_RAD {
        return 0.0;
    }
    // θ̃ to third order: 1 − w = θ̃²/2 − …
    let angle_rad = (2.0 * vertex[2]).sqrt();
    (2.0 - angle_rad / APPROXIMATE_BELOW_RAD).clamp(0.0, 1.0)
}

/// [`map_delta_printed`] outside, [`map_delta_approximate`] inside, blended linearly between.
#[inline]
pub fn map_delta_blended(vertex: [f32; 3], focus: &ClassicFocus) -> Vec2 {
    blended(vertex, focus, map_delta_printed)
}

/// [`map_delta_blended`] with the polynomial.
#[inline]
pub fn map_delta_blended_poly(vertex: [f32; 3], focus: &ClassicFocus) -> Vec2 {
    blended(vertex, focus, map_delta_printed_poly)
}

#[inline]
fn blended(
    vertex: [f32; 3],
    focus: &ClassicFocus,
    printed: impl Fn([f32; 3], &ClassicFocus) -> Vec2,
) -> Vec2 {
    let share = approximation_share(vertex, focus);
    if share >= 1.0 {
        return map_delta_approximate(vertex, focus);
    }
    let printed = printed(vertex, focus);
    if share <= 0.0 {
        return printed;
    }
    printed + (map_delta_approximate(vertex, focus) - printed) * share
}
