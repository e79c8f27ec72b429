//! The truth that errors of the map transform are measured against, held against numbers of more than
//! 40 digits.

use astro_float::{BigFloat, Consts, RoundingMode};
use glam::{DVec2, Vec2};
use relievo_planet::transform::classic::ClassicFocus;
use relievo_planet::transform::forms::{
    COLATITUDES, Form, LEVELS, ground_error_rad, ring_radius_rad, ring_vertices,
};
use relievo_planet::transform::{RingVertex, map_delta_f64};

/// Bits of a number.
const BITS: usize = 192;
const ROUND: RoundingMode = RoundingMode::ToEven;

/// Numbers of [`BITS`] bits.
struct Exact(Consts);

type Vector = [BigFloat; 3];

impl Exact {
    fn new() -> Self {
        Self(Consts::new().expect("memory for constants"))
    }

    fn number(value: f64) -> BigFloat {
        BigFloat::from_f64(value, BITS)
    }

    fn sin_cos(&mut self, angle: &BigFloat) -> (BigFloat, BigFloat) {
        let sin = angle.sin(BITS, ROUND, &mut self.0);
        (sin, angle.cos(BITS, ROUND, &mut self.0))
    }

    fn sum(a: &BigFloat, b: &BigFloat) -> BigFloat {
        a.add(b, BITS, ROUND)
    }

    fn product(a: &BigFloat, b: &BigFloat) -> BigFloat {
        a.mul(b, BITS, ROUND)
    }

    fn dot(a: &Vector, b: &Vector) -> BigFloat {
        let products = a.iter().zip(b).map(|(a, b)| Self::product(a, b));
        products.fold(Self::number(0.0), |sum, product| Self::sum(&sum, &product))
    }

    fn cross(a: &Vector, b: &Vector) -> Vector {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let (minuend, subtrahend) = (Self::product(&a[i], &b[j]), Self::product(&a[j], &b[i]));
            minuend.sub(&subtrahend, BITS, ROUND)
        })
    }

    /// Where a stored vertex lies: u south + v east + w up.
    fn vertex(&mut self, [u, v, one_minus_w]: [f64; 3], colat_rad: f64) -> Vector {
        let (s, c) = self.sin_cos(&Self::number(colat_rad));
        let w = Self::number(1.0).sub(&Self::number(one_minus_w), BITS, ROUND);
        let (u, v) = (Self::number(u), Self::number(v));
        let x = Self::sum(&Self::product(&u, &c), &Self::product(&w, &s));
        let z = Self::product(&w, &c).sub(&Self::product(&u, &s), BITS, ROUND);
        [x, v, z]
    }

    /// The place that (Δφ, Δθ) names.
    fn place(&mut self, delta: DVec2, colat_rad: f64) -> Vector {
        let colat = Self::sum(&Self::number(colat_rad), &Self::number(delta.y));
        let (sin_colat, cos_colat) = self.sin_cos(&colat);
        let (sin_lon, cos_lon) = self.sin_cos(&Self::number(delta.x));
        [
            Self::product(&sin_colat, &cos_lon),
            Self::product(&sin_colat, &sin_lon),
            cos_colat,
        ]
    }

    /// The angle between two directions less than a right angle apart.
    fn angle(&mut self, a: &Vector, b: &Vector) -> f64 {
        let normal = Self::cross(a, b);
        let sine = Self::dot(&normal, &normal).sqrt(BITS, ROUND);
        let tangent = sine.div(&Self::dot(a, b), BITS, ROUND);
        let angle = tangent.atan(BITS, ROUND, &mut self.0);
        angle.to_string().parse().expect("a decimal number")
    }
}

/// Levels and colatitudes, some of them: these numbers take their time.
fn rings() -> impl Iterator<Item = (u32, f64)> {
    let levels = LEVELS.filter(|level| [1, 2, 8, 16, 24].contains(level));
    levels.flat_map(|level| COLATITUDES.map(|colat_rad| (level, colat_rad)))
}

#[test]
fn the_ground_error_is_right_to_a_hundredth_of_the_smallest_that_is_told() {
    let mut exact = Exact::new();
    let mut worst = 0.0_f64;
    for (level, colat_rad) in rings() {
        let vertices = ring_vertices(level, colat_rad, 5);
        let mut deltas = vec![Vec2::ZERO; vertices.len()];
        for form in [Form::CancellationFreePoly, Form::Printed] {
            form.map_deltas(&vertices, &ClassicFocus::new(colat_rad), &mut deltas);
            for (vertex, delta) in vertices.iter().zip(&deltas) {
                let found = ground_error_rad(*vertex, colat_rad, *delta);
                let at = exact.vertex(vertex.map(f64::from), colat_rad);
                let place = exact.place(delta.as_dvec2(), colat_rad);
                worst = worst.max((found - exact.angle(&at, &place)).abs());
            }
        }
    }
    // The finest ring's error is 6·10⁻⁷ of its radius.
    let told = 6e-7 * ring_radius_rad(24);
    assert!(
        worst <= 4e-16 && worst <= told / 100.0,
        "{worst:e}, {told:e}"
    );
}

#[test]
fn in_double_precision_the_transform_is_right_to_a_millionth_of_the_single_precision_error() {
    let mut exact = Exact::new();
    for (level, colat_rad) in rings() {
        let sin_cos = libm::sincos(colat_rad);
        for stored in ring_vertices(level, colat_rad, 5) {
            let [u, v, one_minus_w] = stored.map(f64::from);
            let vertex = RingVertex { u, v, one_minus_w };
            let delta = map_delta_f64(vertex, sin_cos.0, sin_cos.1);
            let at = exact.vertex([u, v, one_minus_w], colat_rad);
            let place = exact.place(delta, colat_rad);
            let share = exact.angle(&at, &place) / ring_radius_rad(level);
            // Where the sine of π is not 0 the focus itself is rounded.
            assert!(
                share <= 6e-13,
                "level {level}, colatitude {colat_rad}: {share:e}"
            );
        }
    }
}
