//! Rounding at cut points: a block holds exactly what its tile would give back.

use half::f16;
use relievo_raster::vector::on_widest;
use relievo_raster::{Block, Sample, SampleType, colour};

/// Rounds a block to what `to` stores. Idempotent; zeros and NaNs become the one of their kind, and
/// a colour whose alpha rounds to 0 becomes 0 as a whole.
///
/// # Panics
/// If the block holds other bands than `to` stores.
pub(super) fn block(block: &mut Block, to: SampleType) {
    assert_eq!(block.bands(), to.bands(), "bands of the sample type");
    match to {
        SampleType::Height => each(block.samples_mut(), height),
        SampleType::Mask => each(block.samples_mut(), eight_bit),
        SampleType::Normal => each(block.samples_mut(), half_float),
        SampleType::Rgba8 => colours(block, eight_bit),
        SampleType::Rgba16F => colours(block, half_float),
        SampleType::Rgba32F => colours(block, |v| v + 0.0),
        SampleType::Mask32F => each(block.samples_mut(), weight),
    }
}

/// Brings a block into the form in which [`relievo_raster::Tile::from_block`] stores what [`block`]
/// holds: everything but the rounding that it does itself.
///
/// # Panics
/// If the block holds other bands than `to` stores.
pub(super) fn before_storing(block: &mut Block, to: SampleType) {
    assert_eq!(block.bands(), to.bands(), "bands of the sample type");
    match to {
        SampleType::Height => each(block.samples_mut(), height),
        SampleType::Mask => {}
        SampleType::Mask32F => each(block.samples_mut(), weight),
        SampleType::Normal => each(block.samples_mut(), |v| v + 0.0),
        SampleType::Rgba8 => transparent(block, |a| a * 255.0 + 0.5 >= 1.0),
        SampleType::Rgba16F => transparent(block, |a| a > SMALLEST_HALF / 2.0),
        SampleType::Rgba32F => transparent(block, |a| a > 0.0),
    }
}

/// The smallest half float above 0; half of it rounds to 0.
const SMALLEST_HALF: f32 = 1.0 / 16_777_216.0;

/// Makes colours 0 as a whole where alpha does not stay.
fn transparent(block: &mut Block, stays: impl Fn(f32) -> bool) {
    /// Samples that are looked through at once.
    const CHUNK: usize = 64;
    let [r, g, b, a] = block.planes_mut();
    on_widest(
        #[inline(always)]
        || {
            let planes = (r.chunks_mut(CHUNK).zip(g.chunks_mut(CHUNK)))
                .zip(b.chunks_mut(CHUNK).zip(a.chunks_mut(CHUNK)));
            for ((r, g), (b, a)) in planes {
                let all_stay = a.iter().fold(true, |all, a| all & stays(*a));
                for plane in [r, g, b] {
                    if all_stay {
                        for v in plane {
                            *v += 0.0;
                        }
                    } else {
                        for (v, a) in plane.iter_mut().zip(&*a) {
                            *v = if stays(*a) { *v + 0.0 } else { 0.0 };
                        }
                    }
                }
                if !all_stay {
                    for a in a {
                        *a = if stays(*a) { *a } else { 0.0 };
                    }
                }
            }
        },
    );
}

fn each(samples: &mut [f32], round: impl Fn(f32) -> f32) {
    for v in samples {
        *v = round(*v);
    }
}

fn colours(block: &mut Block, round: impl Fn(f32) -> f32) {
    let [r, g, b, a] = block.planes_mut();
    each(a, &round);
    for plane in [r, g, b] {
        for (v, a) in plane.iter_mut().zip(a.iter()) {
            *v = if *a > 0.0 { round(*v) } else { 0.0 };
        }
    }
    for v in a {
        *v = if *v > 0.0 { *v } else { 0.0 };
    }
}

/// NaNs of every kind become one, for their bits depend on the platform.
fn height(v: f32) -> f32 {
    if v.is_nan() { f32::NAN } else { v }
}

/// A weight that is no number counts for nothing, as it does in 8 bits.
fn weight(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v + 0.0 }
}

fn eight_bit(v: f32) -> f32 {
    colour::from_u8(colour::to_u8(v))
}

fn half_float(v: f32) -> f32 {
    f16::from_f32(v + 0.0).to_f32()
}

/// One working value rounded to what `to` stores.
pub(super) fn value(value: [f32; 4], to: SampleType) -> [f32; 4] {
    let planes = to.bands().planes();
    let mut one = Block::filled(to.bands(), 1, 1, &value[..planes]);
    block(&mut one, to);
    core::array::from_fn(|plane| one.samples().get(plane).copied().unwrap_or(0.0))
}

/// A working value as it is stored.
pub(super) fn sample(working: [f32; 4], to: SampleType) -> Sample {
    let v = value(working, to);
    match to {
        SampleType::Height => Sample::Height(v[0]),
        SampleType::Rgba8 => Sample::Rgba8(v.map(colour::to_u8)),
        SampleType::Rgba16F => Sample::Rgba16F(v.map(f16::from_f32)),
        SampleType::Rgba32F => Sample::Rgba32F(v),
        SampleType::Mask => Sample::Mask(colour::to_u8(v[0])),
        SampleType::Mask32F => Sample::Mask32F(v[0]),
        SampleType::Normal => Sample::Normal([v[0], v[1]].map(f16::from_f32)),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_planet::TILE_SAMPLES;
    use relievo_raster::Tile;

    use super::*;

    const TYPES: [SampleType; 7] = [
        SampleType::Height,
        SampleType::Rgba8,
        SampleType::Rgba16F,
        SampleType::Rgba32F,
        SampleType::Mask,
        SampleType::Mask32F,
        SampleType::Normal,
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn a_rounded_block_is_what_its_tile_gives_back(
            values in prop::collection::vec(prop_oneof![-0.2..1.2_f32, 0.0..0.01_f32, 0.0..2e-7_f32, Just(f32::NAN), Just(-0.0_f32)], 64),
        ) {
            let side = TILE_SAMPLES as usize;
            for to in TYPES {
                let mut rounded = Block::new(to.bands(), side, side);
                for (i, v) in rounded.samples_mut().iter_mut().enumerate() {
                    *v = values[(i * 7 + i / 64) % 64];
                }
                let mut raw = rounded.clone();
                block(&mut rounded, to);
                before_storing(&mut raw, to);
                let tile = Tile::from_block(&raw, to);
                let stored = Tile::from_block(&rounded, to);
                prop_assert!(tile.bytes() == stored.bytes(), "{to:?}");
                let mut back = Block::new(to.bands(), side, side);
                tile.copy_to((0, 0), &mut back, (0, 0), (side, side));
                for (a, b) in rounded.samples().iter().zip(back.samples()) {
                    prop_assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{to:?} {a} {b}");
                }
            }
        }
    }

    #[test]
    fn a_colour_that_rounds_to_transparent_is_nothing_at_all() {
        assert_eq!(value([0.5, 0.5, 0.5, 0.001], SampleType::Rgba8), [0.0; 4]);
        assert_eq!(
            value([0.5, 0.5, 0.5, f32::NAN], SampleType::Rgba32F),
            [0.0; 4]
        );
    }
}
