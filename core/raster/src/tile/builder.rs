//! Tiles from working samples: rounding, uniform content, the range of heights.

use core::ops::Range;
use std::sync::Arc;

use half::f16;
use half::slice::HalfFloatSliceExt as _;
use relievo_planet::TILE_SAMPLES;

use super::{AREA, Content, Normal, Sample, SampleType, Tile};
use crate::vector::on_widest;
use crate::{Block, colour};

/// Samples that are rounded together.
const CHUNK: usize = 64;

/// Puts a tile together from strips of rows, from the north.
///
/// Samples are rounded as they come, straight to where the tile keeps them, so strips can be made
/// in the same memory one after the other. As long as all samples are equal, one is all it keeps.
#[derive(Debug)]
pub struct TileBuilder {
    gathered: Gathered,
    /// Samples so far.
    count: usize,
    /// Lowest and highest height so far; the other way round without any.
    range_m: (f32, f32),
}

/// Rounded samples of each type.
#[derive(Debug)]
enum Gathered {
    Height(Samples<f32>),
    Rgba8(Samples<[u8; 4]>),
    Rgba16F(Samples<[f16; 4]>),
    Rgba32F(Samples<[f32; 4]>),
    Mask(Samples<u8>),
    Mask32F(Samples<f32>),
    Normal(Samples<Normal>),
}

/// The first sample, and once another one differs, all of them.
#[derive(Debug, Default)]
struct Samples<T> {
    first: Option<T>,
    all: Option<Arc<[T]>>,
}

impl<T: Copy + Default> Samples<T> {
    /// Adds `count` samples after the `before` first ones. `round` makes a range of them.
    #[inline(always)]
    fn add(
        &mut self,
        before: usize,
        count: usize,
        round: impl Fn(Range<usize>, &mut [T]),
        same: impl Fn(&T, &T) -> bool,
    ) {
        let mut done = 0;
        let mut chunk = [T::default(); CHUNK];
        while self.all.is_none() && done < count {
            let n = CHUNK.min(count - done);
            let chunk = &mut chunk[..n];
            round(done..done + n, chunk);
            let first = *self.first.get_or_insert(chunk[0]);
            if chunk.iter().fold(true, |all, v| all & same(v, &first)) {
                done += n;
            } else {
                self.all = Some(core::iter::repeat_n(first, AREA).collect());
            }
        }
        if let Some(all) = &mut self.all {
            let all = Arc::get_mut(all).expect("nobody else has it yet");
            for chunk in all[before + done..before + count].chunks_mut(CHUNK) {
                round(done..done + chunk.len(), chunk);
                done += chunk.len();
            }
        }
    }

    fn finish(self, uniform: impl Fn(T) -> Sample, all: impl Fn(Arc<[T]>) -> Content) -> Content {
        match (self.all, self.first) {
            (Some(samples), _) => all(samples),
            (None, first) => Content::Uniform(uniform(first.unwrap_or_default())),
        }
    }
}

impl TileBuilder {
    /// A tile without rows, to be stored as `to`.
    pub fn new(to: SampleType) -> Self {
        Self {
            gathered: match to {
                SampleType::Height => Gathered::Height(Samples::default()),
                SampleType::Rgba8 => Gathered::Rgba8(Samples::default()),
                SampleType::Rgba16F => Gathered::Rgba16F(Samples::default()),
                SampleType::Rgba32F => Gathered::Rgba32F(Samples::default()),
                SampleType::Mask => Gathered::Mask(Samples::default()),
                SampleType::Mask32F => Gathered::Mask32F(Samples::default()),
                SampleType::Normal => Gathered::Normal(Samples::default()),
            },
            count: 0,
            range_m: (f32::INFINITY, f32::NEG_INFINITY),
        }
    }

    fn sample_type(&self) -> SampleType {
        match self.gathered {
            Gathered::Height(_) => SampleType::Height,
            Gathered::Rgba8(_) => SampleType::Rgba8,
            Gathered::Rgba16F(_) => SampleType::Rgba16F,
            Gathered::Rgba32F(_) => SampleType::Rgba32F,
            Gathered::Mask(_) => SampleType::Mask,
            Gathered::Mask32F(_) => SampleType::Mask32F,
            Gathered::Normal(_) => SampleType::Normal,
        }
    }

    /// Adds the next rows.
    ///
    /// # Panics
    /// If the strip is not as wide as a tile, has more rows than the tile lacks, or other bands
    /// than the tile stores.
    pub fn push(&mut self, strip: &Block) {
        let bands = self.sample_type().bands();
        assert_eq!(strip.bands(), bands, "bands of the sample type");
        assert!(
            strip.width() == TILE_SAMPLES as usize && self.count + strip.plane(0).len() <= AREA,
            "rows of a tile, no more than it has"
        );
        on_widest(
            #[inline(always)]
            || self.push_rows(strip),
        );
    }

    #[inline(always)]
    fn push_rows(&mut self, strip: &Block) {
        let last = strip.bands().planes() - 1;
        let [p, q, r, s] = core::array::from_fn(|i| strip.plane(i.min(last)));
        let (before, count) = (self.count, p.len());
        self.count += count;
        match &mut self.gathered {
            Gathered::Height(samples) => {
                let (low, high) = range(p);
                self.range_m = (self.range_m.0.min(low), self.range_m.1.max(high));
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [f32]| out.copy_from_slice(&p[at]),
                    |a, b| a.to_bits() == b.to_bits(),
                );
            }
            Gathered::Mask32F(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [f32]| out.copy_from_slice(&p[at]),
                    |a, b| a.to_bits() == b.to_bits(),
                );
            }
            Gathered::Mask(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [u8]| {
                        for (out, v) in out.iter_mut().zip(&p[at]) {
                            *out = colour::to_u8(*v);
                        }
                    },
                    u8::eq,
                );
            }
            Gathered::Rgba8(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [[u8; 4]]| {
                        let [p, q, r, s] = [p, q, r, s].map(|plane| &plane[at.clone()]);
                        for ((((out, p), q), r), s) in out.iter_mut().zip(p).zip(q).zip(r).zip(s) {
                            let [p, q, r, s] = [p, q, r, s].map(|v| u32::from(colour::to_u8(*v)));
                            *out = (p | q << 8 | r << 16 | s << 24).to_le_bytes();
                        }
                    },
                    |a, b| u32::from_le_bytes(*a) == u32::from_le_bytes(*b),
                );
            }
            Gathered::Rgba32F(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [[f32; 4]]| {
                        let [p, q, r, s] = [p, q, r, s].map(|plane| &plane[at.clone()]);
                        for ((((out, p), q), r), s) in out.iter_mut().zip(p).zip(q).zip(r).zip(s) {
                            *out = [*p, *q, *r, *s];
                        }
                    },
                    <[f32; 4]>::eq,
                );
            }
            Gathered::Rgba16F(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [[f16; 4]]| {
                        for (channel, plane) in [p, q, r, s].into_iter().enumerate() {
                            halves(&plane[at.clone()], out, channel);
                        }
                    },
                    <[f16; 4]>::eq,
                );
            }
            Gathered::Normal(samples) => {
                samples.add(
                    before,
                    count,
                    #[inline(always)]
                    |at: Range<usize>, out: &mut [Normal]| {
                        halves(&p[at.clone()], out, 0);
                        halves(&q[at], out, 1);
                    },
                    <Normal>::eq,
                );
            }
        }
    }

    /// The tile.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(self) -> Tile {
        assert_eq!(self.count, AREA, "all rows of a tile");
        let (low, high) = self.range_m;
        Tile {
            height_range_m: (low <= high).then_some(self.range_m),
            content: match self.gathered {
                Gathered::Height(s) => s.finish(Sample::Height, Content::Height),
                Gathered::Rgba8(s) => s.finish(Sample::Rgba8, Content::Rgba8),
                Gathered::Rgba16F(s) => s.finish(Sample::Rgba16F, Content::Rgba16F),
                Gathered::Rgba32F(s) => s.finish(Sample::Rgba32F, Content::Rgba32F),
                Gathered::Mask(s) => s.finish(Sample::Mask, Content::Mask),
                Gathered::Mask32F(s) => s.finish(Sample::Mask32F, Content::Mask32F),
                Gathered::Normal(s) => s.finish(Sample::Normal, Content::Normal),
            },
        }
    }
}

/// A plane of at most [`CHUNK`] samples as half floats into one channel of interleaved ones.
#[inline(always)]
fn halves<const N: usize>(plane: &[f32], out: &mut [[f16; N]], channel: usize) {
    let mut rounded = [f16::ZERO; CHUNK];
    let rounded = &mut rounded[..plane.len()];
    rounded.convert_from_f32_slice(plane);
    for (out, v) in out.iter_mut().zip(&*rounded) {
        out[channel] = *v;
    }
}

/// Lowest and highest of some heights, NaN left out; +∞ and −∞ without any.
#[inline(always)]
pub(super) fn range(heights: &[f32]) -> (f32, f32) {
    // Lanes of their own, for the compiler may not change the order of comparisons.
    const LANES: usize = 16;
    let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    let mut take = |chunk: &[f32]| {
        for ((low, high), v) in low.iter_mut().zip(&mut high).zip(chunk) {
            // Comparisons with NaN are false.
            *low = if *v < *low { *v } else { *low };
            *high = if *v > *high { *v } else { *high };
        }
    };
    let whole = heights.chunks_exact(LANES);
    let rest = whole.remainder();
    whole.for_each(&mut take);
    take(rest);
    (
        low.into_iter().fold(f32::INFINITY, f32::min),
        high.into_iter().fold(f32::NEG_INFINITY, f32::max),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SIDE: usize = TILE_SAMPLES as usize;
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
        fn strips_of_any_height_give_the_tile_of_the_whole_and_every_sample_is_rounded_as_one_alone(
            cuts in prop::collection::vec(1..90_usize, 0..6), other_from in 0..SIDE * SIDE, seed: u32,
        ) {
            for to in TYPES {
                let mut whole = Block::new(to.bands(), SIDE, SIDE);
                for plane in 0..to.bands().planes() {
                    for (i, v) in whole.plane_mut(plane).iter_mut().enumerate() {
                        let varied = (i as u32 ^ seed).wrapping_mul(2_654_435_761) >> 16;
                        *v = if i < other_from { 0.25 } else { varied as f32 / 40_000.0 - 0.2 };
                    }
                }
                let mut builder = TileBuilder::new(to);
                let mut row = 0;
                for rows in cuts.iter().copied().chain([SIDE]) {
                    let rows = rows.min(SIDE - row);
                    let mut strip = Block::new(to.bands(), SIDE, rows);
                    strip.copy_from(&whole, (0, row), (0, 0), (SIDE, rows));
                    builder.push(&strip);
                    row += rows;
                }
                let tile = builder.finish();
                let reference = Tile::from_block(&whole, to);
                prop_assert_eq!(tile.bytes(), reference.bytes());
                prop_assert_eq!(tile.as_uniform(), reference.as_uniform());
                prop_assert_eq!(tile.height_range_m(), reference.height_range_m());
                for i in [0, other_from.saturating_sub(1), other_from, SIDE * SIDE - 1] {
                    let v: [f32; 4] = core::array::from_fn(|k| whole.plane(k.min(to.bands().planes() - 1))[i]);
                    let expected = match to {
                        SampleType::Height => Sample::Height(v[0]),
                        SampleType::Rgba8 => Sample::Rgba8(v.map(|v| (v * 255.0 + 0.5) as u8)),
                        SampleType::Rgba16F => Sample::Rgba16F(v.map(f16::from_f32)),
                        SampleType::Rgba32F => Sample::Rgba32F(v),
                        SampleType::Mask => Sample::Mask((v[0] * 255.0 + 0.5) as u8),
                        SampleType::Mask32F => Sample::Mask32F(v[0]),
                        SampleType::Normal => Sample::Normal([v[0], v[1]].map(f16::from_f32)),
                    };
                    prop_assert_eq!(tile.sample(i % SIDE, i / SIDE), expected);
                }
            }
        }
    }

    #[test]
    fn a_range_leaves_out_nan_and_holds_infinities() {
        let mut heights = vec![f32::NAN; 77];
        assert_eq!(range(&heights), (f32::INFINITY, f32::NEG_INFINITY));
        heights[76] = 3.0;
        assert_eq!(range(&heights), (3.0, 3.0));
        heights[5] = f32::INFINITY;
        heights[40] = -2.0;
        assert_eq!(range(&heights), (-2.0, f32::INFINITY));
    }

    #[test]
    #[should_panic(expected = "all rows of a tile")]
    fn a_tile_without_its_last_row_is_refused() {
        let mut builder = TileBuilder::new(SampleType::Mask);
        builder.push(&Block::new(crate::Bands::Mask, SIDE, SIDE - 1));
        builder.finish();
    }
}
