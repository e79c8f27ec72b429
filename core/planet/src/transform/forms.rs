//! All forms of the map transform side by side, and their error on the ground, for measurements.
//!
//! The truth is none of the forms: the stored vertex is turned into world space by the focus' axes in
//! f64, and the angle between it and the place that a form names comes from atan2(|a × b|, a · b).
//! `tests/transform_truth.rs` holds it against numbers of 40 digits.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{DVec3, Vec2};

use super::classic::{self, ClassicFocus};
use super::{RingVertex, atan2_poly, map_delta_with};
use crate::clipmap::rings::KAPPA;

/// A form of the map transform in single precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// \[CH06\] eq. 4 with the library's functions.
    Printed,
    /// The same with the polynomial arc tangent.
    PrintedPoly,
    /// \[CH06\] eq. 11 and 14.
    Approximate,
    /// Eq. 4 outside, eq. 11 and 14 inside, blended.
    Blended,
    /// The same with the polynomial.
    BlendedPoly,
    /// Without cancellation, with the library's arc tangent.
    CancellationFree,
    /// Without cancellation, with the polynomial: what is drawn with.
    CancellationFreePoly,
}

impl Form {
    /// All of them, in the order of their numbers in `forms.wgsl`.
    pub const ALL: [Self; 7] = [
        Self::Printed,
        Self::PrintedPoly,
        Self::Approximate,
        Self::Blended,
        Self::BlendedPoly,
        Self::CancellationFree,
        Self::CancellationFreePoly,
    ];

    /// What people call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Printed => "[CH06] eq. 4",
            Self::PrintedPoly => "[CH06] eq. 4, polynomial",
            Self::Approximate => "[CH06] eq. 11 and 14",
            Self::Blended => "[CH06] blended",
            Self::BlendedPoly => "[CH06] blended, polynomial",
            Self::CancellationFree => "cancellation-free",
            Self::CancellationFreePoly => "cancellation-free, polynomial",
        }
    }

    /// (Δφ, Δθ) in radians of vertices [u, v, 1 − w], written over `deltas`, as many as both have.
    pub fn map_deltas(self, vertices: &[[f32; 3]], focus: &ClassicFocus, deltas: &mut [Vec2]) {
        let sin_cos = focus.sin_cos_colat;
        // The choice is made once, so that each loop is compiled for its form.
        match self {
            Self::Printed => each(vertices, deltas, |v| classic::map_delta_printed(v, focus)),
            Self::PrintedPoly => each(vertices, deltas, |v| {
                classic::map_delta_printed_poly(v, focus)
            }),
            Self::Approximate => each(vertices, deltas, |v| {
                classic::map_delta_approximate(v, focus)
            }),
            Self::Blended => each(vertices, deltas, |v| classic::map_delta_blended(v, focus)),
            Self::BlendedPoly => each(vertices, deltas, |v| {
                classic::map_delta_blended_poly(v, focus)
            }),
            Self::CancellationFree => each(vertices, deltas, |v| {
                map_delta_with(v, sin_cos, libm::atan2f)
            }),
            Self::CancellationFreePoly => {
                each(vertices, deltas, |v| map_delta_with(v, sin_cos, atan2_poly));
            }
        }
    }
}

fn each(vertices: &[[f32; 3]], deltas: &mut [Vec2], form: impl Fn([f32; 3]) -> Vec2) {
    for (delta, vertex) in deltas.iter_mut().zip(vertices) {
        *delta = form(*vertex);
    }
}

/// Levels whose rings are measured.
pub const LEVELS: core::ops::RangeInclusive<u32> = 1..=24;

/// Colatitudes of the focus that are measured: poles, their close neighbourhoods, equator, both
/// hemispheres.
pub const COLATITUDES: [f64; 18] = [
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

/// Outer radius of the ring of a level below 32, radians: κ · 2^−i · π.
pub fn ring_radius_rad(level: u32) -> f64 {
    KAPPA * PI / f64::from(1_u32 << level)
}

/// Vertices of a level's ring as stored, the same on every call: every eighth on an axis, where signs
/// and zeros meet, the others at random.
pub fn ring_vertices(level: u32, colat_rad: f64, count: u32) -> Vec<[f32; 3]> {
    let outer = ring_radius_rad(level);
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ (u64::from(level) << 32) ^ colat_rad.to_bits());
    let vertex = |k: u32| {
        let azimuth = if k.is_multiple_of(8) {
            f64::from(k / 8 % 4) * FRAC_PI_2
        } else {
            random.unit() * TAU
        };
        let angle = outer * (0.5 + 0.5 * random.unit());
        RingVertex::from_polar(angle, azimuth).to_f32()
    };
    (0..count).map(vertex).collect()
}

/// Error on the ground, radians: the angle between a stored vertex and the place at (`delta.x`,
/// `colat_rad + delta.y`). Good to 4·10⁻¹⁶; infinite where the form gave no number.
pub fn ground_error_rad(stored: [f32; 3], colat_rad: f64, delta: Vec2) -> f64 {
    if !delta.is_finite() {
        return f64::INFINITY;
    }
    let [u, v, one_minus_w] = stored.map(f64::from);
    let (sin_c, cos_c) = libm::sincos(colat_rad);
    let south = DVec3::new(cos_c, 0.0, -sin_c);
    let up = DVec3::new(sin_c, 0.0, cos_c);
    let truth = (u * south + v * DVec3::Y + (1.0 - one_minus_w) * up).normalize();
    // The place is built from the focus by sums that keep a tiny Δθ: sin(θ + Δ) and cos(θ + Δ).
    let (sin_d, cos_d) = libm::sincos(f64::from(delta.y));
    let (sin_lon, cos_lon) = libm::sincos(f64::from(delta.x));
    let sin_colat = sin_c * cos_d + cos_c * sin_d;
    let cos_colat = cos_c * cos_d - sin_c * sin_d;
    let found = DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat);
    libm::atan2(truth.cross(found).length(), truth.dot(found))
}

/// Largest error on the ground, radians, over `count` vertices of a level's ring.
pub fn worst_error_rad(form: Form, level: u32, colat_rad: f64, count: u32) -> f64 {
    let vertices = ring_vertices(level, colat_rad, count);
    let mut deltas = vec![Vec2::ZERO; vertices.len()];
    form.map_deltas(&vertices, &ClassicFocus::new(colat_rad), &mut deltas);
    vertices
        .iter()
        .zip(deltas)
        .map(|(vertex, delta)| ground_error_rad(*vertex, colat_rad, delta))
        .fold(0.0, f64::max)
}

/// SplitMix64 (G. Steele and others, 2014).
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
