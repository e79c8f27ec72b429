//! Single blocks: found by the offset table, checked, decompressed.

use exr::block::UncompressedBlock;
use exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use half::f16;

use super::part::{Exr, fault};
use crate::fault::{Fault, damaged};

/// Where a channel's samples are in a decoded block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    /// Bytes of all channels before it, per pixel.
    pub(super) before: usize,
    /// Bytes of all channels, per pixel.
    pub(super) pixel: usize,
    pub(super) kind: SampleType,
}

/// A decoded block: for each row, for each channel, the row's samples.
pub(super) struct RawBlock {
    pub(super) width: usize,
    pub(super) height: usize,
    /// In the machine's byte order.
    data: Vec<u8>,
}

impl RawBlock {
    /// All samples of a channel, row by row.
    pub(super) fn samples(&self, channel: Channel) -> impl Iterator<Item = f32> + '_ {
        let row_bytes = (channel.pixel * self.width).max(1);
        let bytes = channel.kind.bytes_per_sample();
        self.data.chunks_exact(row_bytes).flat_map(move |row| {
            let first = channel.before * self.width;
            row[first..first + bytes * self.width]
                .chunks_exact(bytes)
                .map(move |sample| match (channel.kind, sample) {
                    (SampleType::F16, [a, b]) => f16::from_ne_bytes([*a, *b]).to_f32(),
                    (SampleType::F32, [a, b, c, d]) => f32::from_ne_bytes([*a, *b, *c, *d]),
                    (SampleType::U32, [a, b, c, d]) => u32::from_ne_bytes([*a, *b, *c, *d]) as f32,
                    _ => f32::NAN,
                })
        })
    }
}

impl Exr {
    /// Reads and decodes a block; `None` where the file leaves it out.
    pub(super) fn block(
        &self,
        level: usize,
        column: u32,
        row: u32,
    ) -> Result<Option<RawBlock>, Fault> {
        let Some((compressed_block, width, height)) = self.compressed(level, column, row)? else {
            return Ok(None);
        };
        let chunk = Chunk {
            layer_index: self.part,
            compressed_block,
        };
        let block = UncompressedBlock::decompress_chunk(chunk, &self.meta, false).map_err(fault)?;
        let expected = width * height * self.header().channels.bytes_per_pixel;
        if block.data.len() != expected || block.index.pixel_size != Vec2(width, height) {
            return damaged(format!(
                "expected {expected} bytes in a block, found {}",
                block.data.len()
            ));
        }
        Ok(Some(RawBlock {
            width,
            height,
            data: block.data,
        }))
    }

    /// A block as it is stored, with its columns and rows of pixels.
    fn compressed(
        &self,
        level: usize,
        column: u32,
        row: u32,
    ) -> Result<Option<(CompressedBlock, usize, usize)>, Fault> {
        let header = self.header();
        let place = &self.levels[level];
        let number = place.first + u64::from(row) * u64::from(place.columns) + u64::from(column);
        let mut offset = [0; 8];
        self.bytes
            .read_at(self.table_at + number * 8, &mut offset)?;
        let mut at = u64::from_le_bytes(offset);
        if at == 0 {
            return Ok(None);
        }
        let mut number = || -> Result<i32, Fault> {
            let mut bytes = [0; 4];
            self.bytes.read_at(at, &mut bytes)?;
            at += 4;
            Ok(i32::from_le_bytes(bytes))
        };
        if self.meta.headers.len() > 1 || self.meta.requirements.has_multiple_layers {
            let part = number()?;
            if part != self.part as i32 {
                return damaged(format!(
                    "expected a block of part {}, found one of part {part}",
                    self.part
                ));
            }
        }
        let tiled = matches!(header.blocks, BlockDescription::Tiles(_));
        let (bw, bh) = self.block_size(level);
        let lines = header.compression.scan_lines_per_block() as i64;
        let (expected, found) = if tiled {
            let found = [number()?, number()?, number()?, number()?];
            let level = level as i32;
            (
                [column as i32, row as i32, level, level].map(i64::from),
                found.map(i64::from),
            )
        } else {
            let first = i64::from(header.own_attributes.layer_position.1);
            (
                [first + i64::from(row) * lines, 0, 0, 0],
                [i64::from(number()?), 0, 0, 0],
            )
        };
        if expected != found {
            return damaged(format!(
                "expected the block at {expected:?}, found one at {found:?}"
            ));
        }
        let width = (place.size.width - column * bw).min(bw) as usize;
        let height = (place.size.height - row * bh).min(bh) as usize;
        let decoded = (width * height * header.channels.bytes_per_pixel) as u64;
        let length = number()?;
        let length = u64::try_from(length)
            .ok()
            .filter(|l| (1..=decoded).contains(l))
            .ok_or_else(|| {
                Fault::Damaged(format!(
                    "expected a block of 1 to {decoded} bytes, found {length}"
                ))
            })?;
        if length.saturating_mul(most_expansion(header.compression)) < decoded {
            return damaged(format!(
                "expected {decoded} bytes in a block, found {length} compressed ones"
            ));
        }
        let compressed_pixels_le = self.bytes.vec_at(at, length)?;
        let block = if tiled {
            CompressedBlock::Tile(CompressedTileBlock {
                coordinates: TileCoordinates {
                    tile_index: Vec2(column as usize, row as usize),
                    level_index: Vec2(level, level),
                },
                compressed_pixels_le,
            })
        } else {
            CompressedBlock::ScanLine(CompressedScanLineBlock {
                y_coordinate: found[0] as i32,
                compressed_pixels_le,
            })
        };
        Ok(Some((block, width, height)))
    }
}

/// How many bytes a compressed byte may become at most: a bound that keeps a small file from
/// claiming a large buffer.
fn most_expansion(compression: Compression) -> u64 {
    match compression {
        Compression::Uncompressed => 1,
        // A run of 128 bytes takes two.
        Compression::RLE => 64,
        // A match of 258 bytes takes at least two bits.
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 => 1100,
        // Flat blocks of 4 × 4 half floats take 3 bytes.
        Compression::B44 | Compression::B44A => 16,
        // Runs of 255 numbers of two bytes take nine bits; blocks of one value next to nothing.
        Compression::PIZ => 1 << 16,
        // Deflate inside of the codes of flat blocks of 8 × 8 samples.
        Compression::DWAA(_)
        | Compression::DWAB(_)
        | Compression::HTJ2K32
        | Compression::HTJ2K256 => 1 << 17,
    }
}
