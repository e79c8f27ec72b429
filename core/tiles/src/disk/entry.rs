//! One stored tile as bytes: a header, the samples, and a checksum over both.

use std::time::Duration;

use relievo_graph::ContentId;
use relievo_raster::{Sample, SampleType, Tile};

use super::Loaded;

/// Kind and version of the format, and the byte order of the samples.
const MAGIC: [u8; 8] = if cfg!(target_endian = "little") {
    *b"rlvtl-1<"
} else {
    *b"rlvtl-1>"
};

/// Bytes before the samples: magic, type, 7 reserved, cost in nanoseconds, content id, maker,
/// checksum.
pub(super) const HEADER: usize = 8 + 8 + 8 + 32 + 32 + 32;

/// Largest entry: four f32 a sample.
pub(super) const LARGEST: usize = HEADER + 256 * 256 * 16;

/// What stands for the program that made a tile: its version, and while it is being developed the
/// very build, whose nodes may differ although nobody has raised their version yet.
pub(super) fn maker() -> [u8; 32] {
    let mut hash = blake3::Hasher::new();
    hash.update(env!("CARGO_PKG_VERSION").as_bytes());
    if cfg!(debug_assertions)
        && let Ok(program) = std::env::current_exe()
        && let Ok(facts) = program.metadata()
    {
        hash.update(&facts.len().to_le_bytes());
        let modified = facts
            .modified()
            .ok()
            .and_then(|t| t.duration_since(std::time::UNIX_EPOCH).ok());
        hash.update(&modified.unwrap_or_default().as_nanos().to_le_bytes());
    }
    *hash.finalize().as_bytes()
}

/// A tile as it is stored.
pub(super) fn encode(id: ContentId, tile: &Tile, cost: Duration, maker: &[u8; 32]) -> Vec<u8> {
    let uniform = tile.as_uniform().map(Sample::to_bytes);
    let samples = tile.bytes().or(uniform.as_deref()).unwrap_or_default();
    let mut bytes = Vec::with_capacity(HEADER + samples.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&[tile.sample_type().tag(), 0, 0, 0, 0, 0, 0, 0]);
    let cost_ns = u64::try_from(cost.as_nanos()).unwrap_or(u64::MAX);
    bytes.extend_from_slice(&cost_ns.to_le_bytes());
    bytes.extend_from_slice(&id.0);
    bytes.extend_from_slice(maker);
    let sum = checksum(&bytes, samples);
    bytes.extend_from_slice(&sum);
    bytes.extend_from_slice(samples);
    bytes
}

/// The tile, if every byte is as [`encode`] wrote it for this id and maker.
pub(super) fn decode(bytes: &[u8], id: ContentId, maker: &[u8; 32]) -> Option<Loaded> {
    let (header, samples) = bytes.split_at_checked(HEADER)?;
    let (facts, sum) = header.split_at(HEADER - 32);
    let is_ours = facts.starts_with(&MAGIC) && facts[24..56] == id.0 && facts[56..88] == *maker;
    if !is_ours || checksum(facts, samples) != *sum {
        return None;
    }
    let tile = Tile::from_bytes(SampleType::from_tag(facts[8])?, samples)?;
    let cost_ns = u64::from_le_bytes(facts[16..24].try_into().ok()?);
    Some(Loaded {
        tile,
        cost: Duration::from_nanos(cost_ns),
    })
}

fn checksum(facts: &[u8], samples: &[u8]) -> [u8; 32] {
    let mut hash = blake3::Hasher::new();
    hash.update(facts).update(samples);
    *hash.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_raster::{Bands, Block};

    use super::*;

    const MAKER: [u8; 32] = [7; 32];
    const ID: ContentId = ContentId([3; 32]);

    fn tile() -> Tile {
        let mut block = Block::new(Bands::Height, 256, 256);
        for (i, h) in block.samples_mut().iter_mut().enumerate() {
            *h = i as f32;
        }
        block.samples_mut()[9] = f32::NAN;
        Tile::from_block(&block, SampleType::Height)
    }

    #[test]
    fn a_tile_comes_back_with_its_cost() {
        for tile in [tile(), Tile::uniform(Sample::Rgba8([1, 2, 3, 4]))] {
            let bytes = encode(ID, &tile, Duration::from_micros(1234), &MAKER);
            assert!(bytes.len() <= LARGEST);
            let back = decode(&bytes, ID, &MAKER).unwrap();
            assert_eq!(back.cost, Duration::from_micros(1234));
            assert_eq!(back.tile.bytes(), tile.bytes());
            assert_eq!(back.tile.as_uniform(), tile.as_uniform());
            assert_eq!(back.tile.height_range_m(), tile.height_range_m());
        }
    }

    #[test]
    fn another_id_or_maker_is_refused() {
        let bytes = encode(ID, &tile(), Duration::ZERO, &MAKER);
        assert!(decode(&bytes, ContentId([4; 32]), &MAKER).is_none());
        assert!(decode(&bytes, ID, &[8; 32]).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn no_damage_goes_unseen(at in 0.0..1.0_f64, flip in 1_u8..=255, cut in 0..200_usize) {
            let good = encode(ID, &tile(), Duration::ZERO, &MAKER);
            for anywhere in [(at * good.len() as f64) as usize, (at * HEADER as f64) as usize] {
                let mut bytes = good.clone();
                bytes[anywhere] ^= flip;
                prop_assert!(decode(&bytes, ID, &MAKER).is_none());
            }
            prop_assert!(decode(&good[..(at * good.len() as f64) as usize], ID, &MAKER).is_none());
            prop_assert!(decode(&good[..cut], ID, &MAKER).is_none());
            let mut longer = good.clone();
            longer.push(flip);
            prop_assert!(decode(&longer, ID, &MAKER).is_none());
        }
    }
}
