//! Halving: each sample of the result is the mean of two by two samples.

pub(crate) mod ratio;

use crate::{Bands, Block, colour, normal};

/// The block at half the size, rounded up: each sample covers two by two samples of `block`; where
/// a side is odd, the last column or row covers what is there.
///
/// - Heights: mean of the samples that are not NaN, NaN if there is none.
/// - Colours: mean of premultiplied linear light, so holes add no dark fringe.
/// - Masks: mean.
/// - Normals: direction of the sum of the unit vectors.
///
/// Sums are made in f64 in a fixed order: a constant block of heights or masks stays constant to
/// the bit, one of colours to 10⁻⁵.
pub fn halve(block: &Block) -> Block {
    let (width, height) = (block.width().div_ceil(2), block.height().div_ceil(2));
    let mut out = Block::new(block.bands(), width, height);
    match block.bands() {
        Bands::Height => halve_heights(block, &mut out),
        Bands::Mask => halve_plane(block.plane(0), block.width(), out.plane_mut(0)),
        Bands::Normal => halve_normals(block, &mut out),
        Bands::Colour => halve_colours(block, &mut out),
    }
    out
}

/// Calls `each` with the index of every output sample and the indices of the samples it covers.
fn for_each_quad(in_width: usize, in_len: usize, mut each: impl FnMut(usize, &[usize])) {
    if in_width == 0 {
        return;
    }
    let in_height = in_len / in_width;
    let out_width = in_width.div_ceil(2);
    for oy in 0..in_height.div_ceil(2) {
        let rows = if 2 * oy + 1 < in_height { 2 } else { 1 };
        for ox in 0..out_width {
            let first = 2 * oy * in_width + 2 * ox;
            let o = oy * out_width + ox;
            match (2 * ox + 1 < in_width, rows) {
                (true, 2) => each(
                    o,
                    &[first, first + 1, first + in_width, first + in_width + 1],
                ),
                (true, _) => each(o, &[first, first + 1]),
                (false, 2) => each(o, &[first, first + in_width]),
                (false, _) => each(o, &[first]),
            }
        }
    }
}

fn halve_plane(source: &[f32], width: usize, out: &mut [f32]) {
    for_each_quad(width, source.len(), |o, quad| {
        let sum: f64 = quad.iter().map(|i| f64::from(source[*i])).sum();
        out[o] = (sum / quad.len() as f64) as f32;
    });
}

fn halve_heights(block: &Block, out: &mut Block) {
    let (source, out) = (block.plane(0), out.plane_mut(0));
    for_each_quad(block.width(), source.len(), |o, quad| {
        let (mut sum, mut valid) = (0.0, 0.0);
        for h in quad.iter().map(|i| source[*i]).filter(|h| !h.is_nan()) {
            sum += f64::from(h);
            valid += 1.0;
        }
        out[o] = (sum / valid) as f32; // 0 / 0 is NaN: nothing valid
    });
}

fn halve_normals(block: &Block, out: &mut Block) {
    let (east, north) = (block.plane(0), block.plane(1));
    let [out_east, out_north] = out.planes_mut();
    for_each_quad(block.width(), east.len(), |o, quad| {
        let mut sum = glam::DVec3::ZERO;
        for i in quad {
            sum += normal::unit([east[*i], north[*i]]);
        }
        [out_east[o], out_north[o]] = normal::coordinates(sum);
    });
}

fn halve_colours(block: &Block, out: &mut Block) {
    let mut premultiplied = block.clone();
    colour::premultiply(&mut premultiplied);
    for plane in 0..4 {
        halve_plane(
            premultiplied.plane(plane),
            block.width(),
            out.plane_mut(plane),
        );
    }
    colour::unpremultiply(out);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn heights(width: usize, height: usize, samples: &[f32]) -> Block {
        let mut block = Block::new(Bands::Height, width, height);
        block.plane_mut(0).copy_from_slice(samples);
        block
    }

    #[test]
    fn a_hole_counts_for_nothing_in_the_mean_of_heights() {
        let half = halve(&heights(2, 2, &[1.0, f32::NAN, 3.0, 8.0]));
        assert_eq!(half.plane(0), [4.0]);
        assert!(halve(&heights(2, 2, &[f32::NAN; 4])).plane(0)[0].is_nan());
    }

    #[test]
    fn odd_sides_keep_their_last_column_and_row_to_themselves() {
        let half = halve(&heights(
            3,
            3,
            &[1.0, 1.0, 5.0, 1.0, 1.0, 7.0, 2.0, 4.0, 9.0],
        ));
        assert_eq!(half.plane(0), [1.0, 6.0, 3.0, 9.0]);
    }

    #[test]
    fn black_and_white_meet_in_the_middle_of_linear_light() {
        let mut block = Block::filled(Bands::Colour, 2, 1, &[0.0, 0.0, 0.0, 1.0]);
        for plane in 0..3 {
            block.plane_mut(plane)[1] = 1.0;
        }
        let half = halve(&block);
        assert_eq!(colour::to_u8(half.plane(0)[0]), 188);
    }

    #[test]
    fn a_transparent_neighbour_takes_alpha_but_no_colour() {
        let mut block = Block::filled(Bands::Colour, 2, 1, &[0.8, 0.4, 0.2, 1.0]);
        for plane in 0..4 {
            block.plane_mut(plane)[1] = 0.0;
        }
        let half = halve(&block);
        assert!((half.plane(0)[0] - 0.8).abs() < 1e-5);
        assert_eq!(half.plane(3), [0.5]);
    }

    proptest! {
        #[test]
        fn constant_heights_stay_constant_to_the_bit(
            width in 0..9_usize, height in 0..9_usize, value in -9000.0..9000.0_f32, holes in any::<u64>(),
        ) {
            let samples: Vec<f32> =
                (0..width * height).map(|i| if holes >> (i % 64) & 1 == 1 { f32::NAN } else { value }).collect();
            let half = halve(&heights(width, height, &samples));
            prop_assert_eq!((half.width(), half.height()), (width.div_ceil(2), height.div_ceil(2)));
            for h in half.plane(0) {
                prop_assert!(h.is_nan() || h.to_bits() == value.to_bits());
            }
        }
    }
}
