//! Simplex noise in three dimensions.

use crate::nodes::lanes::{LANES, Lanes};

/// Brings the largest possible sum of four corners to 1.
const SCALE: f32 = 76.8;

/// 1.5 · 2⁵²: adding it rounds a float to the nearest integer and leaves that in the low bits.
const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// Large odd factors that spread the cells along the three axes over all hashes.
const SPREAD: [u32; 3] = [0x9E37_79B1, 0x85EB_CA77, 0xC2B2_AE3D];

/// A place among the simplices: its cell and how far it lies from the cell's first corner.
#[derive(Clone, Copy)]
struct Place {
    cell: [u32; 3],
    from_corner: [f32; 3],
}

/// Noise at many places: `noise[l]` at `unit[..][l] · scale`, −1 to 1, twice continuously
/// differentiable, 0 on average.
///
/// - `unit · scale`: in units of about one feature, each coordinate up to 10¹⁵ in size. Beyond 10⁹ its
///   fraction, and with it the noise, loses digits of f64 but stays defined; cells are counted modulo
///   2³².
/// - `seed`: another seed gives unrelated noise.
///
/// Only places are computed in f64; what is left inside a cell is small, and f32 keeps seven digits
/// of it. Nothing branches, so both loops run on vectors.
///
/// Sources: K. Perlin, *Noise hardware* (2001); S. Gustavson, *Simplex noise demystified* (2005). The
/// falloff radius is √½ instead of √0.6, which keeps it continuous across simplices, and corners
/// are hashed as integers instead of through a permutation table, so nothing repeats.
#[inline(always)]
pub(in crate::nodes) fn simplex(
    unit: &[[f64; LANES]; 3],
    scale: f64,
    seed: u32,
    noise: &mut Lanes,
) {
    let mut cell = [[0_u32; LANES]; 3];
    let mut from_corner = [[0.0_f32; LANES]; 3];
    for l in 0..LANES {
        let place = locate(unit[0][l] * scale, unit[1][l] * scale, unit[2][l] * scale);
        for axis in 0..3 {
            cell[axis][l] = place.cell[axis];
            from_corner[axis][l] = place.from_corner[axis];
        }
    }
    for (l, noise) in noise.iter_mut().enumerate() {
        *noise = value(
            Place {
                cell: [cell[0][l], cell[1][l], cell[2][l]],
                from_corner: [from_corner[0][l], from_corner[1][l], from_corner[2][l]],
            },
            seed,
        );
    }
}

/// Finds the cell of a place.
#[inline(always)]
fn locate(x: f64, y: f64, z: f64) -> Place {
    // Skewed, the simplices fill cubes.
    let skew = (x + y + z) * (1.0 / 3.0);
    let (i, cell_i) = floor(x + skew);
    let (j, cell_j) = floor(y + skew);
    let (k, cell_k) = floor(z + skew);
    let unskew = (i + j + k) * (1.0 / 6.0);
    Place {
        cell: [cell_i, cell_j, cell_k],
        from_corner: [
            (x - (i - unskew)) as f32,
            (y - (j - unskew)) as f32,
            (z - (k - unskew)) as f32,
        ],
    }
}

/// The integer below, also modulo 2³².
#[inline(always)]
fn floor(v: f64) -> (f64, u32) {
    let shifted = v + SHIFTER;
    let nearest = shifted - SHIFTER;
    let above = nearest > v;
    (
        nearest - if above { 1.0 } else { 0.0 },
        (shifted.to_bits() as u32).wrapping_sub(u32::from(above)),
    )
}

/// The sum of the contributions of a simplex's four corners.
#[inline(always)]
fn value(place: Place, seed: u32) -> f32 {
    let [x, y, z] = place.from_corner;
    let [i, j, k] = place.cell;
    let first = i
        .wrapping_mul(SPREAD[0])
        .wrapping_add(j.wrapping_mul(SPREAD[1]))
        .wrapping_add(k.wrapping_mul(SPREAD[2]));
    // The order of the coordinates tells which of the cube's six simplices it is: the second corner
    // lies along the largest of them, the third along all but the smallest.
    let (xy, xz, yz) = (x >= y, x >= z, y >= z);
    let second = [xy & xz, !xy & yz, !(xz | yz)];
    let third = [xy | xz, !xy | yz, !(xz & yz)];
    let sum = corner([x, y, z], first, seed)
        + step([x, y, z], first, second, 1.0 / 6.0, seed)
        + step([x, y, z], first, third, 2.0 / 6.0, seed)
        + step([x, y, z], first, [true; 3], 3.0 / 6.0, seed);
    sum * SCALE
}

/// The contribution of the corner that lies one cell further along some axes.
#[inline(always)]
fn step([x, y, z]: [f32; 3], first: u32, along: [bool; 3], back: f32, seed: u32) -> f32 {
    let one = |yes: bool| if yes { 1.0 } else { 0.0 };
    let hash = |axis: usize| if along[axis] { SPREAD[axis] } else { 0 };
    corner(
        [
            x - one(along[0]) + back,
            y - one(along[1]) + back,
            z - one(along[2]) + back,
        ],
        first
            .wrapping_add(hash(0))
            .wrapping_add(hash(1))
            .wrapping_add(hash(2)),
        seed,
    )
}

/// The contribution of a corner to a place at this distance from it.
#[inline(always)]
fn corner([x, y, z]: [f32; 3], cell: u32, seed: u32) -> f32 {
    let falloff = 0.5 - (x * x + y * y + z * z);
    let falloff = if falloff > 0.0 { falloff } else { 0.0 };
    let square = falloff * falloff;
    square * square * slope([x, y, z], hash(cell ^ seed))
}

/// Two rounds of shifting and multiplying: every bit of the input reaches the upper bits.
///
/// Source of the factors: C. Wellons' search for integer hashes of low bias.
#[inline(always)]
fn hash(mut h: u32) -> u32 {
    h = (h ^ (h >> 16)).wrapping_mul(0x21F0_AAAD);
    (h ^ (h >> 15)).wrapping_mul(0x735A_2D97)
}

/// Product with one of the twelve directions to the middles of a cube's edges: the upper two bits
/// are the signs, the others say in thirds which two axes.
#[inline(always)]
fn slope([x, y, z]: [f32; 3], hash: u32) -> f32 {
    const SIGN: u32 = 0x8000_0000;
    const THIRD: i32 = 0x1555_5555;
    let axes = (hash & 0x3FFF_FFFF) as i32;
    let u = if axes < 2 * THIRD { x } else { y };
    let v = if axes < THIRD { y } else { z };
    f32::from_bits(u.to_bits() ^ (hash & SIGN)) + f32::from_bits(v.to_bits() ^ ((hash << 1) & SIGN))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Noise at one place.
    fn at([x, y, z]: [f64; 3], seed: u32) -> f64 {
        f64::from(value(locate(x, y, z), seed))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn noise_stays_within_its_range_and_has_no_jumps(
            place in prop::array::uniform3(-1e6..1e6_f64), step in prop::array::uniform3(-1e-4..1e-4_f64), seed: u32,
        ) {
            let near = core::array::from_fn(|c| place[c] + step[c]);
            let (a, b) = (at(place, seed), at(near, seed));
            prop_assert!(a.abs() <= 1.0);
            prop_assert!((a - b).abs() < 2e-3, "{a} {b}");
        }

        #[test]
        fn noise_goes_on_smoothly_where_simplices_meet(
            cell in prop::array::uniform3(-1000..1000_i32), (u, v) in (0.0..1.0_f64, 0.0..1.0_f64), face in 0..3_usize, seed: u32,
        ) {
            // On a face of a skewed cube, and just before and behind it.
            let beside = |offset: f64| {
                let mut skewed = [f64::from(cell[0]) + u, f64::from(cell[1]) + v, f64::from(cell[2]) + 0.5 * (u + v)];
                skewed[face] = f64::from(cell[face]) + offset;
                let back = (skewed[0] + skewed[1] + skewed[2]) / 6.0;
                at(skewed.map(|s| s - back), seed)
            };
            prop_assert!((beside(-1e-9) - beside(1e-9)).abs() < 1e-5);
        }

        #[test]
        fn many_places_agree_with_single_ones_to_the_bit(
            places in prop::collection::vec(prop::array::uniform3(-1e5..1e5_f64), LANES), scale in 0.1..100.0_f64, seed: u32,
        ) {
            let unit = core::array::from_fn(|axis| core::array::from_fn(|l| places[l][axis]));
            let mut noise = [0.0; LANES];
            relievo_raster::vector::on_widest(
                #[inline(always)]
                || simplex(&unit, scale, seed, &mut noise),
            );
            for (noise, place) in noise.iter().zip(&places) {
                prop_assert_eq!(f64::from(*noise).to_bits(), at(place.map(|v| v * scale), seed).to_bits());
            }
        }
    }

    #[test]
    fn noise_uses_its_range_and_is_nothing_on_average() {
        let n = 200_000;
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for i in 0..n {
            let v = at([0.371, 0.733, 0.219].map(|step| f64::from(i) * step), 7);
            sum += v;
            largest = largest.max(v.abs());
        }
        assert!((sum / f64::from(n)).abs() < 0.01, "{}", sum / f64::from(n));
        assert!(largest > 0.8, "{largest}");
    }

    #[test]
    fn seeds_and_neighbouring_cells_are_unrelated() {
        let products = |shift: [f64; 3], seed: u32| {
            let mut product = 0.0;
            for i in 0..20_000 {
                let place = [f64::from(i) * 0.61, f64::from(i) * 0.27, 0.4];
                let other = core::array::from_fn(|c| place[c] + shift[c]);
                product += at(place, 1) * at(other, seed);
            }
            (product / 20_000.0_f64).abs()
        };
        for seed in [0, 2, 3, 0x8000_0001, u32::MAX] {
            assert!(products([0.0; 3], seed) < 0.01, "{seed}");
        }
        // Whole cells along each axis and the diagonal, where the same fractions meet.
        for shift in [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0], [3.0; 3]] {
            let skewed: f64 = shift.iter().sum::<f64>() / 6.0;
            assert!(products(shift.map(|s| s - skewed), 1) < 0.01, "{shift:?}");
        }
    }

    #[test]
    fn all_twelve_directions_are_equally_frequent() {
        let mut counts = std::collections::BTreeMap::new();
        for cell in 0..120_000_u32 {
            let h =
                hash((cell % 347).wrapping_mul(SPREAD[0]) ^ (cell / 347).wrapping_mul(SPREAD[1]));
            let direction = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| slope(axis, h) as i32);
            *counts.entry(direction).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 12);
        assert!(
            counts.values().all(|n| (9_400..10_600).contains(n)),
            "{counts:?}"
        );
    }

    #[test]
    fn coordinates_as_large_as_centimetres_on_a_planet_work() {
        let a = at([6.4e8, -6.4e8, 3.2e8], 1);
        let b = at([6.4e8 + 0.25, -6.4e8, 3.2e8], 1);
        assert!(a.abs() <= 1.0 && b.abs() <= 1.0 && a != b);
        assert!(at([1e15, -1e15, 3e14], 1).abs() <= 1.0);
    }
}
