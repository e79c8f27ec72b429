//! From a vertex of the static rings to its place on the map, relative to the focus.
//!
//! A ring vertex is a point of the unit sphere in **focus** space, stored as
//! (u, v, 1 − w) = (sin θ̃ cos φ̃, sin θ̃ sin φ̃, 2 sin²(θ̃/2)) with θ̃ its angle from the focus, +u
//! south, +v east. \[CH06\] gets its colatitude as acos(p_z) − θv, which loses metres to
//! cancellation; the form here subtracts nothing of like size, so that in f32 its error on the
//! ground stays below 6·10⁻⁷ of the ring's radius at every level and colatitude.
//!
//! Invariant: [`map_delta_f32`] performs the operations of its WGSL twin in the same order, and
//! no finite input gives NaN. Absent: windows and texture scales; see `clipmap`.

pub mod classic;
pub mod forms;

use glam::{DVec2, Vec2, Vec3};

use crate::MapPoint;

/// Where the rings are centred, as the transform needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocusFrame {
    /// The focus; in range ([`MapPoint::normalised`]).
    pub focus: MapPoint,
    /// s = sin θv, never negative.
    pub sin_colat: f64,
    /// c = cos θv.
    pub cos_colat: f64,
}

impl FocusFrame {
    /// The frame at a map point, brought into range. At a pole the meridian of its longitude is
    /// the one along which +u points.
    pub fn new(focus: MapPoint) -> Self {
        let focus = focus.normalised();
        let (sin_colat, cos_colat) = libm::sincos(focus.colat_rad);
        Self {
            focus,
            sin_colat: sin_colat.max(0.0),
            cos_colat,
        }
    }

    /// (Δφ, Δθ) of a vertex relative to the focus; see [`map_delta_f64`].
    pub fn delta(&self, vertex: RingVertex) -> DVec2 {
        map_delta_f64(vertex, self.sin_colat, self.cos_colat)
    }

    /// Map point of a vertex, brought into range.
    pub fn map_point(&self, vertex: RingVertex) -> MapPoint {
        let delta = self.delta(vertex);
        MapPoint::new(self.focus.lon_rad + delta.x, self.focus.colat_rad + delta.y).normalised()
    }

    /// (sin θv, cos θv) rounded for the shader.
    pub fn sin_cos_f32(&self) -> Vec2 {
        DVec2::new(self.sin_colat, self.cos_colat).as_vec2()
    }
}

/// A point of the unit sphere in focus space, in the form that keeps small rings precise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingVertex {
    /// sin θ̃ cos φ̃, southward.
    pub u: f64,
    /// sin θ̃ sin φ̃, eastward.
    pub v: f64,
    /// 1 − cos θ̃ = 2 sin²(θ̃/2), 0 to 2.
    pub one_minus_w: f64,
}

impl RingVertex {
    /// The vertex `angle_rad` (θ̃, 0 to π) from the focus towards `azimuth_rad` (φ̃: 0 south, π/2
    /// east).
    pub fn from_polar(angle_rad: f64, azimuth_rad: f64) -> Self {
        let sin_half = libm::sin(angle_rad / 2.0);
        let sin_angle = libm::sin(angle_rad);
        let (sin_azimuth, cos_azimuth) = libm::sincos(azimuth_rad);
        Self {
            u: sin_angle * cos_azimuth,
            v: sin_angle * sin_azimuth,
            one_minus_w: 2.0 * sin_half * sin_half,
        }
    }

    /// As stored in a vertex buffer: [u, v, 1 − w].
    pub fn to_f32(self) -> [f32; 3] {
        [self.u as f32, self.v as f32, self.one_minus_w as f32]
    }
}

/// Longitude and colatitude of a ring vertex minus those of the focus, radians.
///
/// - `sin_colat`, `cos_colat`: of the focus, s = sin θv ≥ 0 and c = cos θv.
/// - Returns (Δφ, Δθ), −π ≤ Δφ ≤ π; (0, 0) at the focus. At a pole Δφ is what atan2 makes of the
///   residue: any value is right there.
///
/// With px = s·w + c·u, pz = c·w − s·u, ρ = √(px² + v²) and d = ρ − px (as v²/(ρ + px) where px is
/// positive): Δφ = atan2(v, px), Δθ = atan2(u + c·d, ρ·s + pz·c). The last is the angle between
/// (ρ, pz) and (s, c) in the meridian plane.
pub fn map_delta_f64(vertex: RingVertex, sin_colat: f64, cos_colat: f64) -> DVec2 {
    let RingVertex { u, v, one_minus_w } = vertex;
    let w = 1.0 - one_minus_w;
    let px = sin_colat * w + cos_colat * u;
    let pz = cos_colat * w - sin_colat * u;
    let rho = (px * px + v * v).sqrt();
    let d = if px > 0.0 {
        v * v / (rho + px)
    } else {
        rho - px
    };
    DVec2::new(
        libm::atan2(v, px),
        libm::atan2(u + cos_colat * d, rho * sin_colat + pz * cos_colat),
    )
}

/// [`map_delta_f64`] in single precision, operation by operation as the shader does it.
///
/// - `vertex`: [u, v, 1 − w] as stored; `sin_cos_colat`: (s, c) of the focus.
/// - Error as a distance on the ground: at most 6·10⁻⁷ of θ̃'s ring radius
///   (`tests/transform_error.rs`).
///
/// Twin: `map_delta` in WGSL, same names and order.
pub fn map_delta_f32(vertex: [f32; 3], sin_cos_colat: Vec2) -> Vec2 {
    map_delta_with(vertex, sin_cos_colat, atan2_poly)
}

/// [`map_delta_f32`] with any arc tangent of (y, x).
#[inline]
fn map_delta_with(vertex: [f32; 3], sin_cos_colat: Vec2, atan2: impl Fn(f32, f32) -> f32) -> Vec2 {
    let [u, v, one_minus_w] = vertex;
    let s = sin_cos_colat.x;
    let c = sin_cos_colat.y;
    let w = 1.0 - one_minus_w;
    let px = s * w + c * u;
    let pz = c * w - s * u;
    let rho = (px * px + v * v).sqrt();
    let d = if px > 0.0 {
        v * v / (rho + px)
    } else {
        rho - px
    };
    Vec2::new(atan2(v, px), atan2(u + c * d, rho * s + pz * c))
}

/// Where a ring vertex lies from the eye once it is lifted to the terrain, metres along the focus' axes
/// (south, east, up), as the shader does it.
///
/// - `vertex`: [u, v, 1 − w] as stored; `radius_m`: the planet's.
/// - `rise_m`: drawn height minus `reference_m`, formed before anything was rounded to metres of a
///   mountain; `reference_m`: a drawn height near that of the ground below the eye.
/// - `focus_from_eye_m`: the focus at `reference_m` above the sphere, minus the eye.
///
/// With (R + r + rise) · (u, v, w) − (0, 0, R + r) nothing of a planet's or a mountain's size is
/// subtracted, so that the error is some 10⁻⁷ of the distance from the eye.
///
/// Twin: `displace` in WGSL.
pub fn displaced_f32(
    vertex: [f32; 3],
    radius_m: f32,
    rise_m: f32,
    reference_m: f32,
    focus_from_eye_m: Vec3,
) -> Vec3 {
    let [u, v, one_minus_w] = vertex;
    let height_m = reference_m + rise_m;
    (radius_m + height_m) * Vec3::new(u, v, -one_minus_w)
        + Vec3::new(0.0, 0.0, rise_m)
        + focus_from_eye_m
}

/// Coefficients of [`atan_poly`] in powers of t², lowest first: minimax on 0 ≤ t ≤ 1.
pub const ATAN_POLY: [f32; 9] = [
    0.999_999_9,
    -0.333_325_98,
    0.199_859_05,
    -0.141_612_25,
    0.104_989_34,
    -0.072_348_37,
    0.039_781_02,
    -0.014_401_248,
    0.002_456_699_7,
];

/// Arc tangent of 0 ≤ t ≤ 1 in radians, relative error below 2·10⁻⁷.
///
/// Twin: `atan_poly` in WGSL.
pub fn atan_poly(t: f32) -> f32 {
    let s = t * t;
    let mut sum = ATAN_POLY[8];
    for k in (0..8).rev() {
        sum = ATAN_POLY[k] + s * sum;
    }
    t * sum
}

/// Angle of (x, y) from +x in radians, −π to π, maximum error 3·10⁻⁷; 0 for (0, 0).
///
/// Instead of WGSL's `atan2`, which some drivers compute to 4·10⁻⁶ only (22 m on Earth). Unlike
/// IEEE's it takes no notice of the sign of a zero.
///
/// Twin: `atan2_poly` in WGSL.
pub fn atan2_poly(y: f32, x: f32) -> f32 {
    let ax = x.abs();
    let ay = y.abs();
    let largest = ax.max(ay);
    let smallest = ax.min(ay);
    let mut r = atan_poly(smallest / largest.max(1e-37));
    if ay > ax {
        r = core::f32::consts::FRAC_PI_2 - r;
    }
    if x < 0.0 {
        r = core::f32::consts::PI - r;
    }
    if y < 0.0 { -r } else { r }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_polynomial_arc_tangent_is_right_to_three_in_ten_million() {
        let mut worst = 0.0_f64;
        for k in 0..200_000 {
            let angle = (f64::from(k) / 100_000.0 - 1.0) * PI;
            let (y, x) = (libm::sin(angle) as f32, libm::cos(angle) as f32);
            let truth = libm::atan2(f64::from(y), f64::from(x));
            worst = worst.max((f64::from(atan2_poly(y, x)) - truth).abs());
        }
        assert!(worst <= 3.0e-7, "{worst:e}");
        for k in 1..100_000 {
            let t = k as f32 / 100_000.0;
            let truth = libm::atan(f64::from(t));
            assert!(
                ((f64::from(atan_poly(t)) - truth) / truth).abs() < 2e-7,
                "{t}"
            );
        }
    }

    #[test]
    fn the_focus_itself_maps_to_zero_everywhere() {
        for colat in [0.0, 1e-9, 0.4, FRAC_PI_2, 2.5, PI - 1e-9, PI] {
            let frame = FocusFrame::new(MapPoint::new(1.0, colat));
            let at_focus = RingVertex::from_polar(0.0, 0.0);
            assert_eq!(frame.delta(at_focus).y, 0.0);
            let f32_delta = map_delta_f32(at_focus.to_f32(), frame.sin_cos_f32());
            assert_eq!(f32_delta.y, 0.0);
            assert_eq!(f32_delta.x, 0.0);
        }
    }

    #[test]
    fn from_a_pole_the_azimuth_is_the_longitude() {
        let frame = FocusFrame::new(MapPoint::new(0.0, 0.0));
        for k in 0..16 {
            let azimuth = f64::from(k) * 0.39 - PI;
            let delta = frame.delta(RingVertex::from_polar(1e-6, azimuth));
            assert!((delta.x - azimuth).abs() < 1e-9, "{azimuth} {delta}");
            assert!((delta.y - 1e-6).abs() < 1e-15);
        }
    }

    #[test]
    fn the_antipode_lies_half_way_around() {
        for colat in [0.3, FRAC_PI_2, 2.0] {
            let frame = FocusFrame::new(MapPoint::new(0.0, colat));
            let p = frame.map_point(RingVertex {
                u: 0.0,
                v: 0.0,
                one_minus_w: 2.0,
            });
            assert!(p.angle_to(MapPoint::new(PI, PI - colat)) < 1e-14);
        }
    }

    #[test]
    fn a_vertex_on_the_pole_reaches_it() {
        for colat in [1e-7, 0.01, 1.0, 3.0] {
            let frame = FocusFrame::new(MapPoint::new(0.0, colat));
            let delta = frame.delta(RingVertex::from_polar(colat, PI));
            assert!((delta.y + colat).abs() < 1e-15, "{colat}: {delta}");
            let single = map_delta_f32(
                RingVertex::from_polar(colat, PI).to_f32(),
                frame.sin_cos_f32(),
            );
            assert!(
                (f64::from(single.y) + colat).abs() < 5e-7 * colat.max(1e-30),
                "{colat}: {single}"
            );
        }
    }

    #[test]
    fn ground_beside_an_eye_on_any_mountain_is_placed_to_a_millionth_of_its_distance() {
        for planet_m in [1e3_f64, 6_371_008.8, 7e7] {
            for ground_m in [-0.5 * planet_m.min(2e5), 0.0, 8848.0, 1e5, 8.848e5] {
                for clearance_m in [1.0, 30.0, 1e4] {
                    // Steps beside the eye of up to the clearance, and rings around it.
                    for k in 0..400 {
                        let angle = clearance_m / planet_m * libm::exp2(f64::from(k % 9) - 6.0);
                        if angle > 1.0 {
                            continue;
                        }
                        let vertex = RingVertex::from_polar(angle, f64::from(k) * 2.399);
                        let stored = vertex.to_f32();
                        let rise = 0.7 * clearance_m * libm::sin(f64::from(k) * 1.7);
                        let reference = f64::from(ground_m as f32);
                        let eye = [
                            -0.4 * clearance_m,
                            0.3 * clearance_m,
                            planet_m + ground_m + clearance_m,
                        ];
                        let focus = [0.0, 0.0, planet_m + reference];
                        let from_eye: [f64; 3] = core::array::from_fn(|i| focus[i] - eye[i]);
                        let found = displaced_f32(
                            stored,
                            planet_m as f32,
                            rise as f32,
                            reference as f32,
                            Vec3::from_array(from_eye.map(|v| v as f32)),
                        );
                        let [u, v, z] = stored.map(f64::from);
                        let r = planet_m + reference + rise;
                        let exact = [
                            r * u - eye[0],
                            r * v - eye[1],
                            (r - planet_m - reference) - r * z + from_eye[2],
                        ];
                        let miss = (0..3)
                            .map(|i| (f64::from(found[i]) - exact[i]).powi(2))
                            .sum::<f64>()
                            .sqrt();
                        let distance = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
                        let at = (planet_m, ground_m, clearance_m, k);
                        assert!(
                            miss < 1e-6 * (distance + clearance_m),
                            "{at:?}: {miss} at {distance}"
                        );
                    }
                }
            }
        }
    }

    proptest! {
        #[test]
        fn no_vertex_of_any_ring_gives_nan(
            colat in prop_oneof![Just(0.0), Just(PI), 0.0..PI, 1e-12..1e-3],
            angle in prop_oneof![Just(0.0), Just(PI), 0.0..PI, 1e-30..1e-6],
            azimuth in -PI..PI,
        ) {
            let frame = FocusFrame::new(MapPoint::new(0.0, colat));
            let vertex = RingVertex::from_polar(angle, azimuth);
            prop_assert!(frame.delta(vertex).is_finite());
            prop_assert!(map_delta_f32(vertex.to_f32(), frame.sin_cos_f32()).is_finite());
        }

        #[test]
        fn in_double_precision_a_vertex_lies_at_its_angle(
            colat in 0.0..PI, angle in 1e-9..3.1, azimuth in -PI..PI,
        ) {
            let frame = FocusFrame::new(MapPoint::new(0.7, colat));
            let p = frame.map_point(RingVertex::from_polar(angle, azimuth));
            prop_assert!((frame.focus.angle_to(p) - angle).abs() < 4e-15);
        }
    }
}
