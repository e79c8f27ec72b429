//! Tiles: immutable, shared squares of stored samples, as caches keep them and GPUs take them.

mod builder;
mod stored;

use std::sync::Arc;

use half::f16;
use relievo_planet::TILE_SAMPLES;

use crate::vector::on_widest;
use crate::{Bands, Block, colour};
pub use builder::TileBuilder;

/// Samples of a tile.
const AREA: usize = (TILE_SAMPLES * TILE_SAMPLES) as usize;

/// How a tile stores a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SampleType {
    /// f32 metres, NaN is nodata.
    Height,
    /// Straight RGBA, 8 bits each, sRGB encoded.
    Rgba8,
    /// Straight RGBA, half floats, sRGB encoded and unbounded above.
    Rgba16F,
    /// Colours exactly as nodes compute them: straight RGBA, four f32 (a pinned input).
    Rgba32F,
    /// 8-bit weight.
    Mask,
    /// A weight exactly as nodes compute it, f32: heights that fade show 255 steps.
    Mask32F,
    /// East and north component of the unit normal as half floats.
    Normal,
}

impl SampleType {
    /// What a block of such samples holds.
    pub const fn bands(self) -> Bands {
        match self {
            Self::Height => Bands::Height,
            Self::Rgba8 | Self::Rgba16F | Self::Rgba32F => Bands::Colour,
            Self::Mask | Self::Mask32F => Bands::Mask,
            Self::Normal => Bands::Normal,
        }
    }

    /// Whether it stores colours or weights exactly as nodes compute them.
    pub const fn is_exact(self) -> bool {
        matches!(self, Self::Rgba32F | Self::Mask32F)
    }

    /// Bytes a stored sample takes.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Mask => 1,
            Self::Height | Self::Rgba8 | Self::Mask32F | Self::Normal => 4,
            Self::Rgba16F => 8,
            Self::Rgba32F => 16,
        }
    }
}

/// One stored sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// Height in metres.
    Height(f32),
    /// Straight RGBA.
    Rgba8([u8; 4]),
    /// Straight RGBA.
    Rgba16F([f16; 4]),
    /// Straight RGBA.
    Rgba32F([f32; 4]),
    /// Weight in 255ths.
    Mask(u8),
    /// Weight.
    Mask32F(f32),
    /// Surface normal.
    Normal(Normal),
}

/// Stereographic coordinates of a unit surface normal towards east and north, see [`normal`](crate::normal);
/// (0, 0) is level ground.
pub type Normal = [f16; 2];

/// The samples of a tile: row by row from the north, interleaved.
#[derive(Clone, Debug)]
enum Content {
    Uniform(Sample),
    Height(Arc<[f32]>),
    Rgba8(Arc<[[u8; 4]]>),
    Rgba16F(Arc<[[f16; 4]]>),
    Rgba32F(Arc<[[f32; 4]]>),
    Mask(Arc<[u8]>),
    Mask32F(Arc<[f32]>),
    Normal(Arc<[Normal]>),
}

/// An immutable tile of [`TILE_SAMPLES`]² samples; a clone shares the samples.
///
/// A uniform tile holds one value and no buffer. [`Tile::from_block`] finds out, so nodes need not.
#[derive(Clone, Debug)]
pub struct Tile {
    content: Content,
    height_range_m: Option<(f32, f32)>,
}

impl Tile {
    /// Stores a block of [`TILE_SAMPLES`]² samples, rounding to `to`; finds uniform content and the
    /// range of heights.
    ///
    /// # Panics
    /// If the block has another size or other bands than `to` stores.
    pub fn from_block(block: &Block, to: SampleType) -> Self {
        let mut builder = TileBuilder::new(to);
        builder.push(block);
        builder.finish()
    }

    /// A tile with the same sample everywhere.
    pub fn uniform(sample: Sample) -> Self {
        let height_range_m = if let Sample::Height(h) = sample
            && !h.is_nan()
        {
            Some((h, h))
        } else {
            None
        };
        Self {
            content: Content::Uniform(sample),
            height_range_m,
        }
    }

    /// How samples are stored.
    pub fn sample_type(&self) -> SampleType {
        match &self.content {
            Content::Uniform(Sample::Height(_)) | Content::Height(_) => SampleType::Height,
            Content::Uniform(Sample::Rgba8(_)) | Content::Rgba8(_) => SampleType::Rgba8,
            Content::Uniform(Sample::Rgba16F(_)) | Content::Rgba16F(_) => SampleType::Rgba16F,
            Content::Uniform(Sample::Rgba32F(_)) | Content::Rgba32F(_) => SampleType::Rgba32F,
            Content::Uniform(Sample::Mask(_)) | Content::Mask(_) => SampleType::Mask,
            Content::Uniform(Sample::Mask32F(_)) | Content::Mask32F(_) => SampleType::Mask32F,
            Content::Uniform(Sample::Normal(_)) | Content::Normal(_) => SampleType::Normal,
        }
    }

    /// The one sample of a uniform tile.
    pub fn as_uniform(&self) -> Option<Sample> {
        if let Content::Uniform(sample) = self.content {
            Some(sample)
        } else {
            None
        }
    }

    /// Stored samples as bytes, row by row from the north; `None` for a uniform tile.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.content {
            Content::Uniform(_) => None,
            Content::Height(s) | Content::Mask32F(s) => Some(bytemuck::cast_slice(s)),
            Content::Rgba8(s) => Some(bytemuck::cast_slice(s)),
            Content::Rgba16F(s) => Some(bytemuck::cast_slice(s)),
            Content::Rgba32F(s) => Some(bytemuck::cast_slice(s)),
            Content::Mask(s) => Some(s),
            Content::Normal(s) => Some(bytemuck::cast_slice(s)),
        }
    }

    /// Memory it keeps in bytes, its own struct included.
    pub fn memory(&self) -> usize {
        size_of::<Self>() + self.bytes().map_or(0, <[u8]>::len)
    }

    /// Lowest and highest height in metres, nodata left out; `None` without any height.
    pub fn height_range_m(&self) -> Option<(f32, f32)> {
        self.height_range_m
    }

    /// The sample at (column, row), both below [`TILE_SAMPLES`].
    ///
    /// # Panics
    /// If it lies outside.
    pub fn sample(&self, column: usize, row: usize) -> Sample {
        assert!(
            column.max(row) < TILE_SAMPLES as usize,
            "a sample of the tile"
        );
        let i = row * TILE_SAMPLES as usize + column;
        match &self.content {
            Content::Uniform(sample) => *sample,
            Content::Height(s) => Sample::Height(s[i]),
            Content::Rgba8(s) => Sample::Rgba8(s[i]),
            Content::Rgba16F(s) => Sample::Rgba16F(s[i]),
            Content::Rgba32F(s) => Sample::Rgba32F(s[i]),
            Content::Mask(s) => Sample::Mask(s[i]),
            Content::Mask32F(s) => Sample::Mask32F(s[i]),
            Content::Normal(s) => Sample::Normal(s[i]),
        }
    }

    /// Writes the rectangle of samples at `from` into `out` at `to` as working f32.
    ///
    /// # Panics
    /// If `out` holds other bands or a rectangle does not fit.
    pub fn copy_to(
        &self,
        from: (usize, usize),
        out: &mut Block,
        to: (usize, usize),
        size: (usize, usize),
    ) {
        assert_eq!(
            out.bands(),
            self.sample_type().bands(),
            "a block of the tile's bands"
        );
        let side = TILE_SAMPLES as usize;
        assert!(
            from.0 + size.0 <= side && from.1 + size.1 <= side,
            "a rectangle of the tile"
        );
        // Rows as wide as both are one run.
        let (length, runs) = if size.0 == side && out.width() == side {
            (size.0 * size.1, size.1.min(1))
        } else {
            size
        };
        for y in 0..runs {
            let (s, d) = (
                (from.1 + y) * side + from.0,
                (to.1 + y) * out.width() + to.0,
            );
            let (source, target) = (s..s + length, d..d + length);
            match &self.content {
                Content::Uniform(sample) => {
                    for (plane, v) in working(*sample)
                        .iter()
                        .take(out.bands().planes())
                        .enumerate()
                    {
                        out.plane_mut(plane)[target.clone()].fill(*v);
                    }
                }
                Content::Height(t) | Content::Mask32F(t) => {
                    out.plane_mut(0)[target].copy_from_slice(&t[source]);
                }
                Content::Mask(t) => spread(&t[source], target, out, |v| [colour::from_u8(v)]),
                Content::Rgba8(t) => spread(&t[source], target, out, |v| {
                    // Bytes of a number are shifts, which vectors have.
                    let v = u32::from_le_bytes(v);
                    [v, v >> 8, v >> 16, v >> 24].map(|v| colour::from_u8(v as u8))
                }),
                Content::Rgba16F(t) => spread(&t[source], target, out, |v| v.map(f16::to_f32)),
                Content::Rgba32F(t) => spread(&t[source], target, out, |v| v),
                Content::Normal(t) => spread(&t[source], target, out, |v| v.map(f16::to_f32)),
            }
        }
    }
}

/// Working values of a sample, one a plane; the rest is 0.
fn working(sample: Sample) -> [f32; 4] {
    match sample {
        Sample::Height(v) | Sample::Mask32F(v) => [v, 0.0, 0.0, 0.0],
        Sample::Rgba8(c) => c.map(colour::from_u8),
        Sample::Rgba16F(c) => c.map(f16::to_f32),
        Sample::Rgba32F(c) => c,
        Sample::Mask(w) => [colour::from_u8(w), 0.0, 0.0, 0.0],
        Sample::Normal([e, n]) => [e.to_f32(), n.to_f32(), 0.0, 0.0],
    }
}

/// Samples as working values into planes.
fn spread<T: Copy, const N: usize>(
    source: &[T],
    target: core::ops::Range<usize>,
    out: &mut Block,
    working: impl Fn(T) -> [f32; N],
) {
    /// Samples that are spread together: memory of their own shows the compiler that planes are
    /// not among the source.
    const CHUNK: usize = 64;
    let mut planes: [&mut [f32]; N] = out.planes_mut().map(|plane| &mut plane[target.clone()]);
    on_widest(
        #[inline(always)]
        || {
            let mut values = [[0.0_f32; CHUNK]; N];
            let whole = source.chunks_exact(CHUNK);
            let (rest, first) = (whole.remainder(), source.len() - whole.remainder().len());
            for (k, source) in whole.enumerate() {
                for i in 0..CHUNK {
                    let v = working(source[i]);
                    for (values, v) in values.iter_mut().zip(v) {
                        values[i] = v;
                    }
                }
                for (plane, values) in planes.iter_mut().zip(&values) {
                    plane[k * CHUNK..][..CHUNK].copy_from_slice(values);
                }
            }
            for (i, v) in rest.iter().enumerate() {
                for (plane, v) in planes.iter_mut().zip(working(*v)) {
                    plane[first + i] = v;
                }
            }
        },
    );
}

/// Lowest and highest of some heights, NaN left out; `None` without any.
fn range(heights: &[f32]) -> Option<(f32, f32)> {
    let (low, high) = builder::range(heights);
    (low <= high).then_some((low, high))
}
