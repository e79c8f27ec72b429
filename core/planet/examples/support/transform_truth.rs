//! Error of the single-precision map transforms as a distance on the ground, against vectors in f64.
//!
//! Shared by `examples/transform_error.rs` and `tests/transform_error.rs`.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{DVec3, Vec2};
use relievo_planet::MapPoint;
use relievo_planet::transform::classic::{map_delta_acos_f32, map_delta_empirical_f32};
use relievo_planet::transform::{FocusFrame, RingVertex, map_delta_f32};

/// Levels whose rings are measured.
pub(crate) const LEVELS: core::ops::RangeInclusive<u32> = 1..=24;

/// Colatitudes of the focus: poles, their close neighbourhoods, equator, both hemispheres.
pub(crate) const COLATITUDES: [f64; 18] = [
    0.0,
    1e-7,
    1e-5,
    1e-3,
    0.05,
    0.3,
    FRAC_PI_4,
    1.2,
    FRAC_PI_2,
    1.9,
    2.2,
    2.7,
    3.0,
    PI - 0.05,
    PI - 1e-3,
    PI - 1e-5,
    PI - 1e-7,
    PI,
];

/// Which transform is measured.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// Without cancellation.
    Exact,
    /// \[CH06\] as first printed.
    Acos,
    /// \[CH06\] eq. 11 and 14.
    Empirical,
}

/// Outer radius of the ring of a level, radians: κ · 2^−i · π with κ = 0.7.
pub(crate) fn ring_radius_rad(level: u32) -> f64 {
    0.7 * PI / f64::from(1_u32 << level)
}

/// Largest error, as an angle on the sphere, over `samples` vertices of the level's ring.
///
/// The truth is the stored vertex turned into world space by the focus' axes; the angle between
/// it and the point that the transform names comes from atan2(|a × b|, a · b) with a chord, none
/// of which is the transform's own formula.
pub(crate) fn worst_error(form: Form, level: u32, colat_rad: f64, samples: u32) -> f64 {
    let frame = FocusFrame::new(MapPoint::new(0.0, colat_rad));
    let outer = ring_radius_rad(level);
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (u64::from(level) << 32) ^ colat_rad.to_bits());
    let mut worst = 0.0_f64;
    for k in 0..samples {
        // Every eighth vertex on an axis, where signs and zeros meet.
        let azimuth = if k % 8 == 0 {
            f64::from(k / 8 % 4) * FRAC_PI_2
        } else {
            random.unit() * TAU
        };
        let angle = outer * (0.5 + 0.5 * random.unit());
        let stored = RingVertex::from_polar(angle, azimuth).to_f32();
        let delta: Vec2 = match form {
            Form::Exact => map_delta_f32(stored, frame.sin_cos_f32()),
            Form::Acos => map_delta_acos_f32(stored, colat_rad as f32),
            Form::Empirical => map_delta_empirical_f32(stored, colat_rad as f32),
        };
        let error = ground_distance(stored, colat_rad, delta);
        worst = if error.is_nan() {
            f64::INFINITY
        } else {
            worst.max(error)
        };
    }
    worst
}

/// Angle between the vertex itself and the map point at (`delta.x`, `colat_rad + delta.y`).
fn ground_distance(stored: [f32; 3], colat_rad: f64, delta: Vec2) -> f64 {
    let [u, v, one_minus_w] = stored.map(f64::from);
    let (sin_c, cos_c) = libm::sincos(colat_rad);
    let south = DVec3::new(cos_c, 0.0, -sin_c);
    let up = DVec3::new(sin_c, 0.0, cos_c);
    let truth = (u * south + v * DVec3::Y + (1.0 - one_minus_w) * up).normalize();
    // The point is built from the focus by sums that keep a tiny Δθ: sin(θ + Δ) and cos(θ + Δ).
    let (sin_d, cos_d) = libm::sincos(f64::from(delta.y));
    let (sin_lon, cos_lon) = libm::sincos(f64::from(delta.x));
    let sin_colat = sin_c * cos_d + cos_c * sin_d;
    let cos_colat = cos_c * cos_d - sin_c * sin_d;
    let found = DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat);
    libm::atan2(truth.cross(found).length(), truth.dot(found))
}

/// SplitMix64: the same vertices on every run.
struct Random(u64);

impl Random {
    /// Uniform in 0 ≤ x < 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
