//! Where the clipmaps are centred.
//!
//! A clipmap is sharpest at its focus. Below the eye that is right only when looking down: with a
//! view that is tilted, most pixels show ground ahead. The focus is therefore moved along the view's
//! azimuth, by f(ν) heights, where ν is the angle of the view from the nadir:
//!
//! `f = tan ν / (1 + (tan ν / 3)⁴)^¼`
//!
//! which is the view's centre on flat ground up to about −45° (f = 0.997) and tends to three heights
//! at grazing angles, where the 90th percentile of texel size per pixel is flat in the focus anyway
//! while the nearest ground must stay inside the finest windows. On a sphere the distance is limited
//! in the same smooth way to half the horizon's, and it goes back to the nadir as the view leaves
//! the planet. All of it is continuous in every parameter of the camera.

use core::f64::consts::{FRAC_PI_2, PI};

use super::view::FocusFrame;
use crate::{Camera, MapPoint};

/// Where the clipmaps' focus lies for a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FocusRule {
    /// Below the eye, whatever the view: \[CH06\] 3.
    Nadir,
    /// Ahead of it, at most three heights and half the way to the horizon.
    Ahead,
    /// Where the middle of the picture meets the ground, or the horizon.
    Centre,
}

impl FocusRule {
    /// All of them, nearest first.
    pub const ALL: [Self; 3] = [Self::Nadir, Self::Ahead, Self::Centre];

    /// Most heights ahead at grazing angles, and which part of the way to the horizon the focus
    /// never passes.
    fn limits(self) -> (f64, f64) {
        match self {
            Self::Nadir => (0.0, 0.0),
            Self::Ahead => (3.0, 0.5),
            Self::Centre => (1e9, 1.0),
        }
    }
}

/// Central angle between the nadir and the focus of a rule, radians; along the camera's heading.
///
/// - `clearance_m`: height of the eye above the terrain, positive.
/// - `ground_radius_m`: distance of the terrain from the planet's centre, positive.
/// - Returns 0 for a view straight down or past the planet, and never more than the angle of the
///   horizon, of which [`FocusRule::Ahead`] goes half the way.
pub fn focus_angle_rad(
    rule: FocusRule,
    camera: &Camera,
    clearance_m: f64,
    ground_radius_m: f64,
) -> f64 {
    let (farthest_heights, horizon_part) = rule.limits();
    let nadir_angle = (FRAC_PI_2 + camera.pitch_rad).clamp(0.0, PI);
    let horizon_nadir_angle =
        libm::asin((ground_radius_m / (ground_radius_m + clearance_m)).min(1.0));
    let lowest_seen = nadir_angle - 0.5 * camera.fov_y_rad;
    // From 0, when the picture's lower edge touches the horizon, to 1 a quarter picture farther.
    let seen = (horizon_nadir_angle - lowest_seen) / (0.25 * camera.fov_y_rad).max(1e-6);
    let seen = smoothstep(seen);

    let (s, c) = libm::sincos(nadir_angle.min(FRAC_PI_2));
    let heights = soft_min(s, farthest_heights * c.max(0.0)) * farthest_heights;
    let ahead = heights * clearance_m / ground_radius_m;
    // acos(1 / (1 + x)) by its half angle, which keeps its digits for small heights.
    let x = clearance_m / ground_radius_m;
    let horizon = 2.0 * libm::asin((0.5 * x / (1.0 + x)).sqrt());
    let limit = horizon_part * horizon;
    seen * limit * soft_min(ahead, limit)
}

/// The focus of a view: [`focus_angle_rad`] ahead of the nadir. Normalised.
pub fn focus_of(
    rule: FocusRule,
    camera: &Camera,
    clearance_m: f64,
    ground_radius_m: f64,
) -> MapPoint {
    let nadir = MapPoint::new(camera.lon_rad, FRAC_PI_2 - camera.lat_rad).normalised();
    let angle = focus_angle_rad(rule, camera, clearance_m, ground_radius_m);
    if angle == 0.0 {
        return nadir;
    }
    // Heading is clockwise from north, the mesh's azimuth counterclockwise from south.
    let frame = FocusFrame::at(nadir);
    MapPoint::from_direction(frame.direction(angle, PI - camera.heading_rad)).normalised()
}

/// a / (a⁴ + b⁴)^¼: nearly a / b for a well below b, and tends to 1 above; 0 for a = 0.
fn soft_min(a: f64, b: f64) -> f64 {
    let largest = a.max(b);
    if largest <= 0.0 {
        return 0.0;
    }
    let (a, b) = (a / largest, b / largest);
    let sum = a * a * a * a + b * b * b * b;
    a / sum.sqrt().sqrt()
}

/// Rises from 0 at 0 to 1 at 1, with level ends.
fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const R: f64 = 6_371_008.8;
    const AHEAD: FocusRule = FocusRule::Ahead;

    fn camera(pitch_deg: f64, heading_deg: f64) -> Camera {
        Camera {
            lon_rad: 0.3,
            lat_rad: 0.8,
            altitude_m: 0.0,
            heading_rad: heading_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 1.0,
        }
    }

    #[test]
    fn it_lies_below_when_looking_down_one_height_ahead_at_45_and_three_at_most() {
        for height in [1.0, 100.0, 1e4] {
            let heights =
                |pitch| focus_angle_rad(AHEAD, &camera(pitch, 10.0), height, R) * R / height;
            assert_eq!(heights(-90.0), 0.0);
            assert!((heights(-45.0) - 1.0).abs() < 0.02, "{}", heights(-45.0));
            assert!((2.9..=3.0).contains(&heights(0.0)), "{}", heights(0.0));
        }
    }

    #[test]
    fn it_lies_below_when_the_view_misses_the_planet() {
        assert_eq!(focus_angle_rad(AHEAD, &camera(80.0, 0.0), 1.0, R), 0.0);
        assert_eq!(focus_angle_rad(AHEAD, &camera(-20.0, 0.0), 1e8, R), 0.0);
    }

    #[test]
    fn it_lies_towards_the_heading() {
        let c = camera(-45.0, 90.0);
        let f = focus_of(AHEAD, &c, 1000.0, R);
        assert!(f.lon_rad > c.lon_rad && (f.lat_rad() - c.lat_rad).abs() < 1e-6);
        let f = focus_of(AHEAD, &camera(-45.0, 0.0), 1000.0, R);
        assert!(f.lat_rad() > c.lat_rad && (f.lon_rad - c.lon_rad).abs() < 1e-9);
    }

    #[test]
    fn the_centre_of_the_picture_is_where_its_ray_meets_flat_ground_or_near_the_horizon() {
        let angle = |pitch| focus_angle_rad(FocusRule::Centre, &camera(pitch, 10.0), 10.0, R);
        for pitch in [-85.0, -60.0, -20.0, -5.0_f64] {
            let heights = libm::tan((90.0 + pitch).to_radians());
            assert!(
                (angle(pitch) * R / 10.0 / heights - 1.0).abs() < 1e-3,
                "{pitch}"
            );
        }
        let horizon = libm::acos(R / (R + 10.0));
        assert!((0.8..=1.0).contains(&(angle(0.0) / horizon)));
        for pitch in [-85.0, -20.0, 0.0] {
            let below = focus_angle_rad(FocusRule::Nadir, &camera(pitch, 10.0), 10.0, R);
            assert_eq!(below, 0.0);
        }
    }

    proptest! {
        #[test]
        fn it_is_continuous_and_never_beyond_the_horizon(
            log_height in 0.0..8.0_f64, pitch in -90.0..90.0_f64, fov in 0.05..2.0_f64,
            rule in prop::sample::select(FocusRule::ALL.to_vec()),
        ) {
            let height = libm::pow(10.0, log_height);
            let mut c = camera(pitch, 0.0);
            c.fov_y_rad = fov;
            let here = focus_angle_rad(rule, &c, height, R);
            let horizon = libm::acos(R / (R + height));
            prop_assert!(here >= 0.0 && here <= rule.limits().1 * horizon + 1e-7);
            c.pitch_rad += 1e-7;
            c.fov_y_rad *= 1.0 + 1e-7;
            let there = focus_angle_rad(rule, &c, height * (1.0 + 1e-7), R);
            prop_assert!((here - there).abs() <= 1e-4 * horizon, "{here} {there} {horizon}");
        }
    }
}
