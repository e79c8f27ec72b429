//! Simplex noise in three dimensions.

/// Twelve directions to the middles of a cube's edges.
const GRADIENTS: [[f64; 3]; 12] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
];

/// Brings the largest possible sum of four corners to 1.
const SCALE: f64 = 76.8;

/// Noise at a place, −1 to 1, twice continuously differentiable, 0 on average.
///
/// - `place`: in units of about one feature; each coordinate up to 10¹⁵ in size. Beyond 10⁹ its
///   fraction, and with it the noise, loses digits of f64 but stays defined.
/// - `seed`: another seed gives unrelated noise.
///
/// Sources: K. Perlin, *Noise hardware* (2001); S. Gustavson, *Simplex noise demystified* (2005). The
/// falloff radius is √½ instead of √0.6, which keeps it continuous across simplices, and corners
/// are hashed as integers instead of through a permutation table, so nothing repeats.
#[inline]
pub(super) fn simplex([x, y, z]: [f64; 3], seed: u64) -> f64 {
    // Skewed, the simplices fill cubes.
    let skew = (x + y + z) / 3.0;
    let [i, j, k] = [x + skew, y + skew, z + skew].map(floor);
    let unskew = (i + j + k) as f64 / 6.0;
    let [x0, y0, z0] = [
        x - (i as f64 - unskew),
        y - (j as f64 - unskew),
        z - (k as f64 - unskew),
    ];
    // The order of the coordinates tells which of the cube's six simplices it is.
    let (xy, xz, yz) = (x0 >= y0, x0 >= z0, y0 >= z0);
    let rank = [
        i64::from(xy) + i64::from(xz),
        i64::from(!xy) + i64::from(yz),
        i64::from(!xz) + i64::from(!yz),
    ];
    let mut sum = 0.0;
    for corner in 0..4 {
        // Corner c is reached by stepping along the c largest coordinates.
        let [di, dj, dk] = rank.map(|r| i64::from(r >= 3 - corner));
        let back = corner as f64 / 6.0;
        let d = [
            x0 - di as f64 + back,
            y0 - dj as f64 + back,
            z0 - dk as f64 + back,
        ];
        let falloff = 0.5 - (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if falloff > 0.0 {
            let g = GRADIENTS[direction(i + di, j + dj, k + dk, seed)];
            let square = falloff * falloff;
            sum += square * square * (g[0] * d[0] + g[1] * d[1] + g[2] * d[2]);
        }
    }
    sum * SCALE
}

#[inline]
fn floor(v: f64) -> i64 {
    let towards_zero = v as i64;
    towards_zero - i64::from((towards_zero as f64) > v)
}

/// One of the twelve gradients, by a hash of the corner.
#[inline]
fn direction(i: i64, j: i64, k: i64, seed: u64) -> usize {
    let mut h = seed
        ^ (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (j as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ (k as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
    h = (h ^ (h >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    h = (h ^ (h >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    (((h >> 32) * 12) >> 32) as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn noise_stays_within_its_range_and_has_no_jumps(
            place in prop::array::uniform3(-1e6..1e6_f64), step in prop::array::uniform3(-1e-4..1e-4_f64), seed: u64,
        ) {
            let near = core::array::from_fn(|c| place[c] + step[c]);
            let (a, b) = (simplex(place, seed), simplex(near, seed));
            prop_assert!(a.abs() <= 1.0);
            prop_assert!((a - b).abs() < 2e-3, "{a} {b}");
        }
    }

    #[test]
    fn noise_uses_its_range_and_is_nothing_on_average() {
        let n = 200_000;
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for i in 0..n {
            let v = simplex(
                [
                    f64::from(i) * 0.371,
                    f64::from(i) * 0.733,
                    f64::from(i) * 0.219,
                ],
                7,
            );
            sum += v;
            largest = largest.max(v.abs());
        }
        assert!((sum / f64::from(n)).abs() < 0.01, "{}", sum / f64::from(n));
        assert!(largest > 0.8, "{largest}");
    }

    #[test]
    fn seeds_are_unrelated() {
        let mut product = 0.0;
        for i in 0..20_000 {
            let place = [f64::from(i) * 0.61, f64::from(i) * 0.27, 0.4];
            product += simplex(place, 1) * simplex(place, 2);
        }
        assert!((product / 20_000.0_f64).abs() < 0.01);
    }

    #[test]
    fn coordinates_as_large_as_centimetres_on_a_planet_work() {
        let a = simplex([6.4e8, -6.4e8, 3.2e8], 1);
        let b = simplex([6.4e8 + 0.25, -6.4e8, 3.2e8], 1);
        assert!(a.abs() <= 1.0 && b.abs() <= 1.0 && a != b);
    }
}
