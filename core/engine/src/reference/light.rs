//! Light on the ground and from light to display in f64: the formulas of
//! `shaders/wgsl/lib/light.wgsl`.

use glam::DVec3;

use super::air::smoothstep;
use crate::frame::Sun;

/// Linear light of ground that no source colours.
pub(super) const BARE_GROUND: DVec3 = DVec3::new(0.23, 0.22, 0.20);

/// Unit normal of the ground from its normal without exaggeration, steepened with the heights.
/// `normal`: of any length but zero; `up`: of unit length.
pub(super) fn steepened(normal: DVec3, up: DVec3, exaggeration: f64) -> DVec3 {
    let upward = normal.dot(up);
    let tilt = normal - up * upward;
    (tilt * exaggeration + up * upward).normalize_or(up)
}

/// Factor on the ground's colour. Level ground under a high sun gets 1.
pub(super) fn lit(normal: DVec3, up: DVec3, sun: &Sun) -> DVec3 {
    let towards = sun.direction_in_world;
    let ambient = f64::from(sun.ambient);
    let sun_up = up.dot(towards);
    let direct = normal.dot(towards).max(0.0) * smoothstep(-0.05, 0.10, sun_up);
    let warm = DVec3::new(1.0, 0.72, 0.50).lerp(DVec3::ONE, smoothstep(0.0, 0.35, sun_up));
    let open_sky = 0.6 + 0.4 * normal.dot(up);
    let day = 0.04 + 0.96 * smoothstep(-0.20, 0.15, sun_up);
    (1.0 - ambient) * 1.30 * direct * warm + ambient * open_sky * day * DVec3::new(0.92, 0.97, 1.08)
}

/// Display value of linear light: a shoulder above 0.8, then sRGB encoded.
pub(super) fn display(linear: DVec3) -> DVec3 {
    linear.map(|light| {
        let over = (light - 0.8).max(0.0);
        let kept = light.min(0.8) + over / (1.0 + over / 0.2);
        if kept <= 0.003_130_8 {
            kept * 12.92
        } else {
            1.055 * libm::pow(kept, 1.0 / 2.4) - 0.055
        }
    })
}
