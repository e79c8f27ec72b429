//! Tiles as bytes and back, for caches on disk.

use std::sync::Arc;

use half::f16;

use super::{AREA, Content, Sample, SampleType, Tile, range};

impl SampleType {
    /// A number for the type that is the same in every version of the program.
    pub const fn tag(self) -> u8 {
        match self {
            Self::Height => 1,
            Self::Rgba8 => 2,
            Self::Rgba16F => 3,
            Self::Rgba32F => 4,
            Self::Mask => 5,
            Self::Normal => 6,
            Self::Mask32F => 7,
        }
    }

    /// The type with a tag, if one has it.
    pub const fn from_tag(tag: u8) -> Option<Self> {
        Some(match tag {
            1 => Self::Height,
            2 => Self::Rgba8,
            3 => Self::Rgba16F,
            4 => Self::Rgba32F,
            5 => Self::Mask,
            6 => Self::Normal,
            7 => Self::Mask32F,
            _ => return None,
        })
    }
}

impl Tile {
    /// The tile that gave these bytes: those of all samples ([`Tile::bytes`]), or those of the one
    /// sample of a uniform tile ([`Sample::to_bytes`]), in the byte order of this machine. `None` if
    /// the number of bytes fits neither.
    pub fn from_bytes(to: SampleType, bytes: &[u8]) -> Option<Self> {
        if bytes.len() == to.bytes() {
            return Some(Self::uniform(sample(to, bytes)));
        }
        if bytes.len() != AREA * to.bytes() {
            return None;
        }
        let content = match to {
            SampleType::Height => Content::Height(array(bytes, f32::from_ne_bytes)),
            SampleType::Rgba8 => Content::Rgba8(array(bytes, |b| b)),
            SampleType::Rgba16F => Content::Rgba16F(array(bytes, halves::<8, 4>)),
            SampleType::Rgba32F => Content::Rgba32F(array(bytes, floats)),
            SampleType::Mask => Content::Mask(bytes.into()),
            SampleType::Mask32F => Content::Mask32F(array(bytes, f32::from_ne_bytes)),
            SampleType::Normal => Content::Normal(array(bytes, halves::<4, 2>)),
        };
        let height_range_m = if let Content::Height(heights) = &content {
            range(heights)
        } else {
            None
        };
        Some(Self {
            content,
            height_range_m,
        })
    }
}

impl Sample {
    /// The sample as it is stored, in the byte order of this machine.
    pub fn to_bytes(self) -> Vec<u8> {
        match self {
            Self::Height(v) | Self::Mask32F(v) => v.to_ne_bytes().to_vec(),
            Self::Rgba8(c) => c.to_vec(),
            Self::Rgba16F(c) => c.into_iter().flat_map(f16::to_ne_bytes).collect(),
            Self::Rgba32F(c) => c.into_iter().flat_map(f32::to_ne_bytes).collect(),
            Self::Mask(w) => vec![w],
            Self::Normal(n) => n.into_iter().flat_map(f16::to_ne_bytes).collect(),
        }
    }
}

fn array<T, const N: usize>(bytes: &[u8], sample: impl Fn([u8; N]) -> T) -> Arc<[T]> {
    let (samples, _) = bytes.as_chunks::<N>();
    samples.iter().map(|b| sample(*b)).collect()
}

fn halves<const N: usize, const M: usize>(bytes: [u8; N]) -> [f16; M] {
    core::array::from_fn(|i| f16::from_ne_bytes([bytes[2 * i], bytes[2 * i + 1]]))
}

fn floats(bytes: [u8; 16]) -> [f32; 4] {
    core::array::from_fn(|i| {
        let at = 4 * i;
        f32::from_ne_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    })
}

/// The sample that `bytes`, as many as the type has, stand for.
fn sample(to: SampleType, bytes: &[u8]) -> Sample {
    let mut padded = [0; 16];
    padded[..bytes.len()].copy_from_slice(bytes);
    let values = floats(padded);
    let [a, b, c, d, ..] = padded;
    match to {
        SampleType::Height => Sample::Height(values[0]),
        SampleType::Rgba8 => Sample::Rgba8([a, b, c, d]),
        SampleType::Rgba16F => Sample::Rgba16F(halves(padded)),
        SampleType::Rgba32F => Sample::Rgba32F(values),
        SampleType::Mask => Sample::Mask(a),
        SampleType::Mask32F => Sample::Mask32F(values[0]),
        SampleType::Normal => Sample::Normal(halves(padded)),
    }
}

#[cfg(test)]
mod tests {
    use relievo_planet::TILE_SAMPLES;

    use super::*;
    use crate::Block;

    const TYPES: [SampleType; 7] = [
        SampleType::Height,
        SampleType::Rgba8,
        SampleType::Rgba16F,
        SampleType::Rgba32F,
        SampleType::Mask,
        SampleType::Mask32F,
        SampleType::Normal,
    ];

    fn bytes_of(tile: &Tile) -> Vec<u8> {
        tile.bytes().map_or_else(
            || tile.as_uniform().map(Sample::to_bytes).unwrap_or_default(),
            <[u8]>::to_vec,
        )
    }

    #[test]
    fn a_tile_comes_back_from_its_bytes() {
        let side = TILE_SAMPLES as usize;
        for to in TYPES {
            assert_eq!(SampleType::from_tag(to.tag()), Some(to));
            for uniform in [false, true] {
                let mut block = Block::new(to.bands(), side, side);
                for (i, v) in block.samples_mut().iter_mut().enumerate() {
                    *v = if uniform {
                        0.25
                    } else {
                        (i % 977) as f32 / 977.0
                    };
                }
                let tile = Tile::from_block(&block, to);
                let bytes = bytes_of(&tile);
                let back = Tile::from_bytes(to, &bytes).unwrap();
                assert_eq!(back.sample_type(), to);
                assert_eq!(back.as_uniform().is_some(), uniform);
                assert_eq!(bytes_of(&back), bytes);
                assert_eq!(back.height_range_m(), tile.height_range_m());
                assert!(Tile::from_bytes(to, &bytes[1..]).is_none());
            }
        }
        assert_eq!(SampleType::from_tag(0), None);
    }
}
