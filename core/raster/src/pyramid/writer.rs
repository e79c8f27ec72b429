//! Tiled BigTIFF of several levels, tile after tile; what was written can be read back.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use super::store::Store;
use crate::file::{OverviewInfo, PixelRect, RasterInfo};
use crate::parts::parts;
use crate::{Bands, Block, colour};

/// Side of a tile.
pub(super) const TILE: u32 = 256;
/// Pixels of a tile.
const AREA: usize = (TILE * TILE) as usize;
/// Where the header says where the first directory is.
const FIRST_DIRECTORY_AT: u64 = 8;

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Samples {
    /// f32 heights, NaN is nodata.
    Height,
    /// RGBA, 8 bits each.
    Rgba8,
    /// RGBA, 16 bits each.
    Rgba16,
    /// RGBA, f32 each.
    RgbaF32,
}

impl Samples {
    /// What keeps the samples of a file.
    pub(super) fn for_file(info: &RasterInfo) -> Self {
        match info.bands {
            Bands::Colour if !info.deep_colour => Self::Rgba8,
            Bands::Colour if info.sample_type.starts_with("float") => Self::RgbaF32,
            Bands::Colour => Self::Rgba16,
            Bands::Height | Bands::Mask | Bands::Normal => Self::Height,
        }
    }

    fn channels(self) -> usize {
        if self == Self::Height { 1 } else { 4 }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Rgba8 => 1,
            Self::Rgba16 => 2,
            Self::Height | Self::RgbaF32 => 4,
        }
    }
}

/// Levels written so far.
pub(super) struct Writer {
    store: Store,
    samples: Samples,
    bands: Bands,
    levels: Vec<Level>,
}

struct Level {
    size: OverviewInfo,
    /// Position and length of each tile; 0 and 0 for tiles without content.
    tiles: Vec<(u64, u64)>,
}

impl Writer {
    /// Starts a file.
    pub(super) fn new(mut store: Store, samples: Samples, bands: Bands) -> io::Result<Self> {
        // "II", BigTIFF, offsets of 8 bytes; the first directory is filled in at the end.
        store.append(&[b'I', b'I', 43, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])?;
        Ok(Self {
            store,
            samples,
            bands,
            levels: Vec::new(),
        })
    }

    /// The tiles that follow are of a new level.
    pub(super) fn start_level(&mut self, size: OverviewInfo) {
        self.levels.push(Level {
            size,
            tiles: Vec::new(),
        });
    }

    /// Adds the next tile of the level, as [`Writer::encode`] gave it.
    pub(super) fn add_tile(&mut self, encoded: Option<Vec<u8>>) -> io::Result<()> {
        let place = match encoded {
            Some(bytes) => (self.store.append(&bytes)?, bytes.len() as u64),
            None => (0, 0),
        };
        if let Some(level) = self.levels.last_mut() {
            level.tiles.push(place);
        }
        Ok(())
    }

    /// Compresses a tile (or the part of one that lies in the level); `None` for all nodata.
    pub(super) fn encode(&self, block: &Block) -> Option<Vec<u8>> {
        let last = block.plane(block.bands().planes() - 1);
        let empty = if self.samples == Samples::Height {
            last.iter().all(|h| h.is_nan())
        } else {
            last.iter().all(|a| *a <= 0.0)
        };
        if empty {
            return None;
        }
        let channels = self.samples.channels();
        let mut raw = vec![0u8; AREA * channels * self.samples.bytes()];
        let row_bytes = TILE as usize * channels * self.samples.bytes();
        for (y, row) in raw
            .chunks_exact_mut(row_bytes)
            .enumerate()
            .take(block.height())
        {
            for c in 0..channels {
                let values = &block.plane(c)[y * block.width()..(y + 1) * block.width()];
                for (x, value) in values.iter().enumerate() {
                    let i = (x * channels + c) * self.samples.bytes();
                    match self.samples {
                        Samples::Rgba8 => row[i] = colour::to_u8(*value),
                        Samples::Rgba16 => row[i..i + 2]
                            .copy_from_slice(&((value * 65535.0 + 0.5) as u16).to_le_bytes()),
                        Samples::Height | Samples::RgbaF32 => {
                            row[i..i + 4].copy_from_slice(&value.to_le_bytes());
                        }
                    }
                }
            }
            self.difference(row);
        }
        let mut encoder = ZlibEncoder::new(Vec::with_capacity(raw.len() / 2), Compression::fast());
        // Writing to memory cannot fail.
        encoder.write_all(&raw).and_then(|()| encoder.finish()).ok()
    }

    /// Horizontal differences (predictor 2) of integer samples.
    fn difference(&self, row: &mut [u8]) {
        match self.samples {
            Samples::Rgba8 => (4..row.len())
                .rev()
                .for_each(|i| row[i] = row[i].wrapping_sub(row[i - 4])),
            Samples::Rgba16 => {
                for i in (8..row.len()).step_by(2).rev() {
                    let value = u16::from_le_bytes([row[i], row[i + 1]]);
                    let before = u16::from_le_bytes([row[i - 8], row[i - 7]]);
                    row[i..i + 2].copy_from_slice(&value.wrapping_sub(before).to_le_bytes());
                }
            }
            Samples::Height | Samples::RgbaF32 => {}
        }
    }

    /// Reads a rectangle of a level written before.
    pub(super) fn read(&self, level: usize, rect: PixelRect, out: &mut Block) -> io::Result<()> {
        out.reshape(self.bands, rect.width as usize, rect.height as usize);
        let level = &self.levels[level];
        let columns = level.size.width.div_ceil(TILE);
        for part in parts(rect, (TILE, TILE)) {
            let tile = self.decode(level.tiles[(part.row * columns + part.column) as usize])?;
            out.copy_from(&tile, part.in_cell, part.in_rect, part.size);
        }
        Ok(())
    }

    fn decode(&self, (at, length): (u64, u64)) -> io::Result<Block> {
        let mut block = Block::new(self.bands, TILE as usize, TILE as usize);
        if at == 0 {
            if self.samples == Samples::Height {
                block.samples_mut().fill(f32::NAN);
            }
            return Ok(block);
        }
        let (channels, bytes) = (self.samples.channels(), self.samples.bytes());
        let mut raw = vec![0u8; AREA * channels * bytes];
        ZlibDecoder::new(self.store.read(at, length as usize)?.as_slice()).read_exact(&mut raw)?;
        for row in raw.chunks_exact_mut(TILE as usize * channels * bytes) {
            match self.samples {
                Samples::Rgba8 => {
                    (4..row.len()).for_each(|i| row[i] = row[i].wrapping_add(row[i - 4]));
                }
                Samples::Rgba16 => {
                    for i in (8..row.len()).step_by(2) {
                        let sum = u16::from_le_bytes([row[i], row[i + 1]])
                            .wrapping_add(u16::from_le_bytes([row[i - 8], row[i - 7]]));
                        row[i..i + 2].copy_from_slice(&sum.to_le_bytes());
                    }
                }
                Samples::Height | Samples::RgbaF32 => {}
            }
        }
        for (i, pixel) in raw.chunks_exact(channels * bytes).enumerate() {
            for (c, sample) in pixel.chunks_exact(bytes).enumerate() {
                block.plane_mut(c)[i] = match *sample {
                    [v] => colour::from_u8(v),
                    [a, b] => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
                    [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                    _ => 0.0,
                };
            }
        }
        Ok(block)
    }

    /// Writes the directories and hands back the store.
    pub(super) fn finish(mut self) -> io::Result<Store> {
        let mut next_at = FIRST_DIRECTORY_AT;
        for (i, level) in core::mem::take(&mut self.levels).into_iter().enumerate() {
            let offsets = self.append_numbers(level.tiles.iter().map(|t| t.0))?;
            let lengths = self.append_numbers(level.tiles.iter().map(|t| t.1))?;
            let at = self.store.length();
            let directory = self.directory(i, &level, offsets, lengths);
            self.store.append(&directory)?;
            self.store.overwrite(next_at, &at.to_le_bytes())?;
            next_at = at + directory.len() as u64 - 8;
        }
        Ok(self.store)
    }

    fn append_numbers(&mut self, numbers: impl Iterator<Item = u64>) -> io::Result<u64> {
        let bytes: Vec<u8> = numbers.flat_map(u64::to_le_bytes).collect();
        self.store.append(&bytes)
    }

    fn directory(&self, number: usize, level: &Level, offsets: u64, lengths: u64) -> Vec<u8> {
        let channels = self.samples.channels() as u64;
        let count = level.tiles.len() as u64;
        let (bits, format) = match self.samples {
            Samples::Rgba8 => (8, 1),
            Samples::Rgba16 => (16, 1),
            Samples::Height | Samples::RgbaF32 => (32, 3),
        };
        let predictor = if bits == 32 { 1 } else { 2 };
        // Four shorts fit into an entry; a single one has zeros behind it.
        let shorts = |value: u64| {
            if channels == 4 {
                value * 0x0001_0001_0001_0001
            } else {
                value
            }
        };
        let inline = |values: &[u64]| if count == 1 { values[0] } else { values[1] };
        let (first_offset, first_length) = level.tiles.first().copied().unwrap_or_default();
        let mut entries: Vec<(u16, u16, u64, u64)> = vec![
            (254, 4, 1, u64::from(number > 0)),
            (256, 4, 1, level.size.width.into()),
            (257, 4, 1, level.size.height.into()),
            (258, 3, channels, shorts(bits)),
            (259, 3, 1, 8),
            (262, 3, 1, if channels == 4 { 2 } else { 1 }),
            (277, 3, 1, channels),
            (317, 3, 1, predictor),
            (322, 3, 1, TILE.into()),
            (323, 3, 1, TILE.into()),
            (324, 16, count, inline(&[first_offset, offsets])),
            (325, 16, count, inline(&[first_length, lengths])),
        ];
        if channels == 4 {
            entries.push((338, 3, 1, 2));
        }
        entries.push((339, 3, channels, shorts(format)));
        if self.samples == Samples::Height {
            entries.push((42113, 2, 4, u64::from_le_bytes(*b"nan\0\0\0\0\0")));
        }
        let mut out = (entries.len() as u64).to_le_bytes().to_vec();
        for (tag, kind, count, value) in entries {
            out.extend_from_slice(&tag.to_le_bytes());
            out.extend_from_slice(&kind.to_le_bytes());
            out.extend_from_slice(&count.to_le_bytes());
            out.extend_from_slice(&value.to_le_bytes());
        }
        out.extend_from_slice(&0u64.to_le_bytes());
        out
    }
}
