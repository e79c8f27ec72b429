//! The projection: reversed depth, infinite far plane, relative to the eye.

use glam::{DMat4, DVec3, DVec4, dcamera};

use super::Camera;
use crate::Planet;

impl Camera {
    /// Clip space from positions relative to the eye along the world's axes, metres.
    ///
    /// - `aspect`: width / height; `near_m`: distance of the near plane, see [`near_plane_m`].
    /// - Clip space is that of WebGPU: y up, depth 1 at the near plane, 0 at infinity.
    ///
    /// Convert at the very end (`.as_mat4()`): positions relative to the eye are small where
    /// precision counts. The vertical is the sphere's, so that the planet's size plays no part.
    pub fn view_projection(&self, planet: &Planet, aspect: f64, near_m: f64) -> DMat4 {
        let basis = self.basis(planet);
        let row = |v: DVec3| v.extend(0.0);
        let view = DMat4::from_cols(
            row(basis.right),
            row(basis.up),
            row(-basis.forward),
            DVec4::W,
        )
        .transpose();
        dcamera::rh::proj::directx::perspective_infinite_reverse(self.fov_y_rad, aspect, near_m)
            * view
    }
}

/// Distance of the near plane in metres for an eye `height_m` above the terrain below it.
///
/// A fiftieth of the height, at least 2 cm: at steep walls terrain comes much nearer than the
/// height. With reversed floating-point depth a near plane that near costs no precision: depth is
/// near / z, whose relative spacing is the same everywhere.
pub fn near_plane_m(height_m: f64) -> f64 {
    // Written so that NaN gives the least distance.
    if height_m > 1.0 {
        height_m.min(super::MAX_ALTITUDE_M) / 50.0
    } else {
        0.02
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use proptest::prelude::*;

    use super::super::tests::{cameras, ndcs};
    use super::*;

    proptest! {
        #[test]
        fn a_point_along_the_ray_of_a_place_projects_to_that_place(
            camera in cameras(), ndc in ndcs(), aspect in 0.3..3.0, exponent in -1.0..8.0_f64,
        ) {
            let near_m = near_plane_m(camera.altitude_m);
            let matrix = camera.view_projection(&Planet::EARTH, aspect, near_m);
            let point = camera.ray(ndc.x, ndc.y, aspect) * libm::exp10(exponent);
            let clip = matrix * point.extend(1.0);
            prop_assert!((DVec2::new(clip.x, clip.y) / clip.w - ndc).length() < 1e-12);
            prop_assert!((clip.z / clip.w * clip.w / near_m - 1.0).abs() < 1e-12, "depth is near / z");
        }

        #[test]
        fn in_single_precision_the_matrix_is_finite(camera in cameras(), aspect in 0.3..3.0) {
            let matrix = camera.view_projection(&Planet::EARTH, aspect, near_plane_m(camera.altitude_m));
            prop_assert!(matrix.as_mat4().is_finite());
        }
    }

    #[test]
    fn the_near_plane_follows_the_height_above_the_terrain() {
        assert_eq!(near_plane_m(1.0), 0.02);
        assert_eq!(near_plane_m(5000.0), 100.0);
        assert_eq!(near_plane_m(f64::NAN), 0.02);
        assert_eq!(near_plane_m(-3.0), 0.02);
    }
}
