//! Which part of a file is read, and where its blocks lie.

use std::io::{self, BufReader, Read};

use exr::compression::Compression;
use exr::error::Error;
use exr::meta::attribute::LevelMode;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData, compute_level_count, compute_level_size};

use crate::fault::{Fault, damaged, unsupported};
use crate::file::OverviewInfo;
use crate::geotiff::Bytes;

/// Bytes of all headers at most: previews and other attributes are small.
const MAX_HEADER_BYTES: u64 = 64 << 20;
/// Decoded bytes of one block at most.
const MAX_BLOCK_BYTES: u64 = 256 << 20;
/// Channels of a part at most.
const MAX_CHANNELS: usize = 1024;

/// A file and the part of it that is read.
pub(super) struct Exr {
    pub(super) bytes: Bytes,
    pub(super) meta: MetaData,
    /// Number of the part.
    pub(super) part: usize,
    /// Where the part's offset table begins.
    pub(super) table_at: u64,
    /// Full image first.
    pub(super) levels: Vec<Level>,
}

/// One mip level.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) size: OverviewInfo,
    /// Columns of blocks.
    pub(super) columns: u32,
    /// Rows of blocks.
    pub(super) rows: u32,
    /// Number of the level's first block in the table.
    pub(super) first: u64,
}

/// Counts what is read through it.
struct Counting<R> {
    inner: R,
    count: u64,
}

impl<R: Read> Read for Counting<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.count += read as u64;
        Ok(read)
    }
}

/// The bytes from the beginning as a stream.
struct Stream<'a> {
    bytes: &'a Bytes,
    at: u64,
}

impl Read for Stream<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.bytes.length().min(MAX_HEADER_BYTES) - self.at;
        let count = (buffer.len() as u64).min(left) as usize;
        self.bytes.read_at(self.at, &mut buffer[..count])?;
        self.at += count as u64;
        Ok(count)
    }
}

/// A fault of the crate's as one of ours.
pub(super) fn fault(error: Error) -> Fault {
    match error {
        Error::NotSupported(reason) => Fault::Unsupported(reason.into_owned()),
        Error::Invalid(reason) => Fault::Damaged(reason.into_owned()),
        Error::Io(error) => error.into(),
        Error::Aborted => Fault::Damaged("reading was given up".into()),
    }
}

impl Exr {
    /// Reads all headers and chooses the first part that can be read.
    pub(super) fn open(bytes: Bytes) -> Result<Self, Fault> {
        let mut reader = Counting {
            inner: BufReader::new(Stream {
                bytes: &bytes,
                at: 0,
            }),
            count: 0,
        };
        let meta = MetaData::read_from_buffered(&mut reader, false).map_err(fault)?;
        let headers_end = reader.count;
        let mut first_refusal = None;
        let mut table_at = headers_end;
        for (part, header) in meta.headers.iter().enumerate() {
            let table_bytes = (header.chunk_count as u64).checked_mul(8);
            let next = table_bytes.and_then(|b| table_at.checked_add(b));
            let Some(next) = next.filter(|end| *end <= bytes.length()) else {
                return damaged(format!(
                    "expected a table of {} blocks, the file ends before",
                    header.chunk_count
                ));
            };
            match usable(header, meta.headers.len() > 1) {
                Ok(()) => {
                    let levels = levels(header);
                    return Ok(Self {
                        bytes,
                        meta,
                        part,
                        table_at,
                        levels,
                    });
                }
                Err(refusal) => first_refusal = first_refusal.or(Some(refusal)),
            }
            table_at = next;
        }
        Err(first_refusal.unwrap_or_else(|| Fault::Damaged("expected a part, found none".into())))
    }

    /// The header of the part.
    pub(super) fn header(&self) -> &Header {
        &self.meta.headers[self.part]
    }

    /// The part's name, where the file has several.
    pub(super) fn part_name(&self) -> Option<String> {
        if self.meta.headers.len() < 2 {
            return None;
        }
        let name = self.header().own_attributes.layer_name.as_ref();
        Some(name.map_or_else(|| format!("{}", self.part + 1), ToString::to_string))
    }

    /// Columns and rows of pixels of a whole block of a level.
    pub(super) fn block_size(&self, level: usize) -> (u32, u32) {
        let size = self.levels[level].size;
        let (width, height) = block_size(self.header());
        // A tile may be larger than the image.
        (width.min(size.width), height.min(size.height))
    }

    /// Decoded bytes of a whole block.
    pub(super) fn block_bytes(&self) -> u64 {
        let (width, height) = self.block_size(0);
        u64::from(width) * u64::from(height) * self.header().channels.bytes_per_pixel as u64
    }
}

/// Columns and rows of pixels of a block, as the header says.
fn block_size(header: &Header) -> (u32, u32) {
    match header.blocks {
        BlockDescription::Tiles(tiles) => (
            tiles.tile_size.0.try_into().unwrap_or(u32::MAX),
            tiles.tile_size.1.try_into().unwrap_or(u32::MAX),
        ),
        BlockDescription::ScanLines => (
            header.layer_size.0.try_into().unwrap_or(u32::MAX),
            header.compression.scan_lines_per_block() as u32,
        ),
    }
}

/// Whether a part can be read.
fn usable(header: &Header, several: bool) -> Result<(), Fault> {
    if header.deep {
        return unsupported("expected flat images, found deep data");
    }
    if matches!(
        header.compression,
        Compression::HTJ2K32 | Compression::HTJ2K256
    ) {
        return unsupported(
            "expected a compression of none, RLE, ZIP, PIZ, PXR24, B44 or DWA, found HTJ2K",
        );
    }
    let channels = &header.channels.list;
    if channels.is_empty() || channels.len() > MAX_CHANNELS {
        return damaged(format!(
            "expected 1 to {MAX_CHANNELS} channels, found {}",
            channels.len()
        ));
    }
    if channels
        .iter()
        .any(|c| c.sampling.0 != 1 || c.sampling.1 != 1)
    {
        return unsupported("expected channels of full resolution, found subsampled ones");
    }
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    if width == 0 || height == 0 || width.max(height) > i32::MAX as usize {
        return damaged(format!(
            "expected a data window with an area, found {width} × {height}"
        ));
    }
    header.validate(several, &mut false, false).map_err(fault)?;
    let (bw, bh) = block_size(header);
    let block = u64::from(bw.min(width as u32))
        .saturating_mul(u64::from(bh.min(height as u32)))
        .saturating_mul(header.channels.bytes_per_pixel as u64);
    if block > MAX_BLOCK_BYTES {
        return unsupported(format!(
            "expected blocks of at most {} MiB, found {} MiB",
            MAX_BLOCK_BYTES >> 20,
            block >> 20
        ));
    }
    Ok(())
}

/// The levels of a part; of rip maps the full image only.
fn levels(header: &Header) -> Vec<Level> {
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    let (bw, bh) = block_size(header);
    let mut first = 0;
    let mut levels = Vec::new();
    let count = match header.blocks {
        BlockDescription::Tiles(tiles) if tiles.level_mode == LevelMode::MipMap => {
            compute_level_count(tiles.rounding_mode, width.max(height))
        }
        BlockDescription::Tiles(_) | BlockDescription::ScanLines => 1,
    };
    for index in 0..count {
        let side = |full: usize| match header.blocks {
            BlockDescription::Tiles(tiles) if index > 0 => {
                compute_level_size(tiles.rounding_mode, full, index) as u32
            }
            BlockDescription::Tiles(_) | BlockDescription::ScanLines => full as u32,
        };
        let size = OverviewInfo {
            width: side(width),
            height: side(height),
        };
        let (columns, rows) = (size.width.div_ceil(bw), size.height.div_ceil(bh));
        levels.push(Level {
            size,
            columns,
            rows,
            first,
        });
        first += u64::from(columns) * u64::from(rows);
    }
    levels
}

/// The compression for people.
pub(super) fn compression_name(compression: Compression) -> &'static str {
    match compression {
        Compression::Uncompressed => "none",
        Compression::RLE => "RLE",
        Compression::ZIP1 => "ZIPS",
        Compression::ZIP16 => "ZIP",
        Compression::PIZ => "PIZ",
        Compression::PXR24 => "PXR24",
        Compression::B44 => "B44",
        Compression::B44A => "B44A",
        Compression::DWAA(_) => "DWAA",
        Compression::DWAB(_) => "DWAB",
        Compression::HTJ2K32 | Compression::HTJ2K256 => "HTJ2K",
    }
}
