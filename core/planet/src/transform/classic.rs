//! The map transforms that \[CH06\] prints, kept as comparisons for measurements only.
//!
//! Nothing that draws uses them: `examples/transform_error.rs` shows what they cost.

use glam::Vec2;

/// \[CH06\] 4.2 in single precision: Δθ = acos(p_z) − θv, Δφ = atan2(v, px).
///
/// - `vertex`: [u, v, 1 − w]; `colat_rad`: θv.
///
/// The difference cancels: near the focus it loses everything below 10⁻⁷ rad and more where
/// |p_z| is near 1.
pub fn map_delta_acos_f32(vertex: [f32; 3], colat_rad: f32) -> Vec2 {
    let [u, v, one_minus_w] = vertex;
    let (s, c) = libm::sincosf(colat_rad);
    let w = 1.0 - one_minus_w;
    let px = s * w + c * u;
    let pz = c * w - s * u;
    Vec2::new(
        libm::atan2f(v, px),
        libm::acosf(pz.clamp(-1.0, 1.0)) - colat_rad,
    )
}

/// \[CH06\] eq. 11 and 14 in single precision: Δφ ≈ v · D(θv), Δθ ≈ u, with the empirical distortion
/// D = 1 + (1/π) / (¼ − q²) − q²/6 − 4/π, q = θv/π − ½, which stands for 1 / sin θv.
///
/// - `vertex`: [u, v, 1 − w]; `colat_rad`: θv.
///
/// Eq. 14 prints θ̃; Δθ has a sign, so this reads it as the southward part u. Meant for
/// π/48 < θv < 47π/48 and θ̃ < π/1024, where D is good to 10⁻³; not finite at a pole.
pub fn map_delta_empirical_f32(vertex: [f32; 3], colat_rad: f32) -> Vec2 {
    use core::f32::consts::{FRAC_1_PI, PI};
    let [u, v, _] = vertex;
    let q = colat_rad / PI - 0.5;
    let distortion = 1.0 + FRAC_1_PI / (0.25 - q * q) - q * q / 6.0 - 4.0 * FRAC_1_PI;
    Vec2::new(v * distortion, u)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::MapPoint;
    use crate::transform::{FocusFrame, RingVertex};

    /// Worst distance in radians between a form and the exact one on a circle about colatitude 45°.
    fn worst(angle_rad: f64, form: fn([f32; 3], f32) -> Vec2) -> f64 {
        let colat = core::f64::consts::FRAC_PI_4;
        let frame = FocusFrame::new(MapPoint::new(0.0, colat));
        (0..64)
            .map(|k| {
                let vertex = RingVertex::from_polar(angle_rad, f64::from(k) * 0.098);
                let off: DVec2 =
                    form(vertex.to_f32(), colat as f32).as_dvec2() - frame.delta(vertex);
                libm::hypot(off.x * libm::sin(colat), off.y)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_printed_forms_lose_what_the_paper_says_they_lose() {
        // acos: absolute noise of half a metre on Earth that does not shrink with the ring.
        let noise = worst(1e-6, map_delta_acos_f32);
        assert!(noise > 3e-8 && noise < 1e-6, "{noise:e}");
        // The approximation: 10⁻³ of a small ring, far more of a large one.
        let small = worst(1e-5, map_delta_empirical_f32) / 1e-5;
        assert!(small < 1.2e-3, "{small:e}");
        assert!(worst(8e-3, map_delta_empirical_f32) / 8e-3 > 2e-3);
    }
}
