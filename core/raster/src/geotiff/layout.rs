//! How an image of a TIFF is cut into chunks, and what a sample is.

use std::sync::Arc;

use super::fault::{Fault, damaged, unsupported};
use super::ifd::{Entry, Ifd, TiffBytes, tag};

/// Decoded bytes of one chunk at most: a strip of a reasonable file is far smaller.
const MAX_CHUNK_BYTES: u64 = 512 << 20;
/// Bytes of a compressed chunk beyond twice what it decodes to: headers and tables.
const MOST_OVERHEAD: u64 = 1 << 16;
/// Longest side of an image; beyond, positions of pixels no longer fit comfortably.
const MAX_SIDE: u64 = 1 << 30;
/// Uncompressed strips are read in pieces of about so many bytes, however high the strip is.
const UNCOMPRESSED_PIECE_BYTES: u64 = 1 << 18;

/// How the bits of a sample read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleFormat {
    /// Unsigned integer.
    Unsigned,
    /// Signed integer, two's complement.
    Signed,
    /// IEEE 754.
    Float,
}

/// Compression numbers of TIFF.
pub(crate) mod compression {
    pub(crate) const NONE: u16 = 1;
    pub(crate) const LZW: u16 = 5;
    pub(crate) const JPEG: u16 = 7;
    pub(crate) const DEFLATE: u16 = 8;
    pub(crate) const OLD_DEFLATE: u16 = 32946;
    pub(crate) const PACK_BITS: u16 = 32773;
    pub(crate) const LERC: u16 = 34887;
    pub(crate) const ZSTD: u16 = 50000;
    pub(crate) const WEBP: u16 = 50001;
}

/// Photometric numbers of TIFF.
pub(crate) mod photometric {
    pub(crate) const WHITE_IS_ZERO: u16 = 0;
    pub(crate) const BLACK_IS_ZERO: u16 = 1;
    pub(crate) const RGB: u16 = 2;
    pub(crate) const PALETTE: u16 = 3;
    pub(crate) const MASK: u16 = 4;
    pub(crate) const YCBCR: u16 = 6;
}

/// What LERC blobs are compressed with once more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LercWrapping {
    None,
    Deflate,
    Zstd,
}

/// One image of a file: sizes, sample type, where its chunks are.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) chunk_width: u32,
    pub(crate) chunk_height: u32,
    pub(crate) planar: bool,
    pub(crate) samples: u16,
    pub(crate) bits: u16,
    pub(crate) format: SampleFormat,
    pub(crate) photometric: u16,
    pub(crate) compression: u16,
    pub(crate) predictor: u16,
    pub(crate) lerc: LercWrapping,
    pub(crate) extra_samples: Vec<u16>,
    pub(crate) jpeg_tables: Option<Arc<[u8]>>,
    tiled: bool,
    /// Rows of a strip as stored, where uncompressed strips are read in pieces.
    stored_rows: u32,
    offsets: Entry,
    byte_counts: Option<Entry>,
}

/// Chunks whose positions are looked at to find out whether some are missing.
const MOST_CHUNKS_LOOKED_AT: u64 = 1 << 20;

impl Layout {
    /// Reads and checks what one directory says.
    pub(crate) fn read(file: &TiffBytes, ifd: &Ifd) -> Result<Self, Fault> {
        let width = side(file, ifd, tag::IMAGE_WIDTH, "width")?;
        let height = side(file, ifd, tag::IMAGE_LENGTH, "height")?;
        let short = |tag: u16, default: u16| -> Result<u16, Fault> {
            let value = file.unsigned(ifd, tag)?.unwrap_or(default.into());
            u16::try_from(value)
                .or_else(|_| damaged(format!("expected tag {tag} below 65536, found {value}")))
        };
        let samples = short(tag::SAMPLES_PER_PIXEL, 1)?;
        let (format, bits) = sample_format(file, ifd)?;
        if samples == 0 {
            return damaged("expected at least one sample a pixel, found 0");
        }
        let compression = short(tag::COMPRESSION, compression::NONE)?;
        check_compression(compression)?;
        let predictor = short(tag::PREDICTOR, 1)?;
        check_predictor(predictor, format, bits)?;
        if short(tag::FILL_ORDER, 1)? != 1 && is_packed(format, bits) {
            return unsupported("expected fill order 1 of bits, found 2");
        }
        check_codec(compression, format, bits)?;
        let lerc = lerc_wrapping(file, ifd)?;
        let planar = match short(tag::PLANAR_CONFIGURATION, 1)? {
            1 => false,
            2 => samples > 1,
            other => {
                return damaged(format!(
                    "expected a planar configuration 1 or 2, found {other}"
                ));
            }
        };
        let jpeg_tables = match compression {
            compression::JPEG => file
                .byte_vec(ifd, tag::JPEG_TABLES, 1 << 16)?
                .map(Arc::from),
            _ => None,
        };
        let extra_samples = file.unsigned_vec(ifd, tag::EXTRA_SAMPLES, samples.into())?;
        let tiled = ifd.find(tag::TILE_OFFSETS).is_some();
        let (offset_tag, count_tag) = if tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS)
        };
        let Some(offsets) = ifd.find(offset_tag).copied() else {
            return damaged("expected positions of strips or tiles, found neither");
        };
        let (chunk_width, stored_rows) = if tiled {
            (
                side(file, ifd, tag::TILE_WIDTH, "tile width")?,
                side(file, ifd, tag::TILE_LENGTH, "tile height")?,
            )
        } else {
            let rows = file.unsigned(ifd, tag::ROWS_PER_STRIP)?.unwrap_or(u64::MAX);
            if rows == 0 {
                return damaged("expected at least one row a strip, found 0");
            }
            (width, rows.min(height.into()) as u32)
        };
        if compression == compression::WEBP && (planar || !matches!(samples, 3 | 4)) {
            return unsupported(format!(
                "expected 3 or 4 interleaved samples in WebP compression, found {samples}"
            ));
        }
        let mut layout = Self {
            width,
            height,
            chunk_width,
            chunk_height: stored_rows,
            planar,
            samples,
            bits,
            format,
            photometric: short(tag::PHOTOMETRIC, photometric::BLACK_IS_ZERO)?,
            compression,
            predictor,
            lerc,
            extra_samples: extra_samples.iter().map(|e| *e as u16).collect(),
            jpeg_tables,
            tiled,
            stored_rows,
            offsets,
            byte_counts: ifd.find(count_tag).copied(),
        };
        if !tiled && compression == compression::NONE {
            let rows =
                (UNCOMPRESSED_PIECE_BYTES / layout.row_bytes()).clamp(1, stored_rows.into()) as u32;
            // A piece lies within one strip: the strip's rows must be a multiple of the piece's.
            let whole = stored_rows == height;
            layout.chunk_height = (1..=rows)
                .rev()
                .find(|r| whole || stored_rows % r == 0)
                .unwrap_or(1);
        }
        layout.check_chunks(file)?;
        Ok(layout)
    }

    fn check_chunks(&self, file: &TiffBytes) -> Result<(), Fault> {
        // All planes of a place count: they are read together.
        let samples = self.samples / self.chunk_samples();
        let bytes = self.chunk_bytes().saturating_mul(samples.into());
        if bytes > MAX_CHUNK_BYTES {
            return unsupported(format!(
                "expected strips or tiles of at most {} MiB, found {} x {} pixels of {} samples",
                MAX_CHUNK_BYTES >> 20,
                self.chunk_width,
                self.chunk_height,
                self.samples
            ));
        }
        let planes = if self.planar {
            u64::from(self.samples)
        } else {
            1
        };
        let stored =
            u64::from(self.columns()) * u64::from(self.height.div_ceil(self.stored_rows)) * planes;
        if self.offsets.count < stored {
            return damaged(format!(
                "expected {stored} strip or tile positions, found {}",
                self.offsets.count
            ));
        }
        // An image cannot be larger than its table of chunks says, whatever its sides claim.
        let tables = [Some(&self.offsets), self.byte_counts.as_ref()];
        if !tables.into_iter().flatten().all(|t| file.holds(t, stored)) {
            return damaged(format!(
                "expected {stored} strip or tile positions, found a file that ends before them"
            ));
        }
        match self.byte_counts {
            Some(counts) if counts.count < stored => damaged(format!(
                "expected {stored} strip or tile lengths, found {}",
                counts.count
            )),
            None if self.compression != compression::NONE => {
                damaged("expected lengths of strips or tiles, found none")
            }
            _ => Ok(()),
        }
    }

    /// Whether samples do not fill whole bytes or words and are unpacked here.
    pub(crate) fn is_packed(&self) -> bool {
        is_packed(self.format, self.bits)
    }

    /// Samples of a pixel within a chunk.
    pub(crate) fn chunk_samples(&self) -> u16 {
        if self.planar { 1 } else { self.samples }
    }

    /// Stored bytes of a row of a chunk, before compression.
    pub(crate) fn row_bytes(&self) -> u64 {
        (u64::from(self.chunk_width) * u64::from(self.chunk_samples()) * u64::from(self.bits))
            .div_ceil(8)
    }

    /// Bytes of a whole chunk's samples in memory, where bits take the next wider type.
    pub(crate) fn chunk_bytes(&self) -> u64 {
        let sample = u64::from(self.bits).div_ceil(8).next_power_of_two();
        let row = u64::from(self.chunk_width) * u64::from(self.chunk_samples()) * sample;
        row.saturating_mul(self.chunk_height.into())
    }

    /// Chunks side by side.
    pub(crate) fn columns(&self) -> u32 {
        self.width.div_ceil(self.chunk_width)
    }

    /// Chunks one above the other.
    pub(crate) fn rows(&self) -> u32 {
        self.height.div_ceil(self.chunk_height)
    }

    /// Pixel rows in a chunk row: tiles are always whole, the last strip ends with the image.
    pub(crate) fn rows_in(&self, chunk_row: u32) -> u32 {
        if self.tiled {
            self.chunk_height
        } else {
            self.chunk_height
                .min(self.height - chunk_row * self.chunk_height)
        }
    }

    /// Position and length of a chunk's bytes; `None` where the file leaves the chunk out.
    pub(crate) fn chunk_range(
        &self,
        file: &TiffBytes,
        plane: u16,
        column: u32,
        row: u32,
    ) -> Result<Option<(u64, u64)>, Fault> {
        if self.compression == compression::NONE && !self.tiled {
            return self.piece_range(file, plane, row);
        }
        let index = (u64::from(plane) * u64::from(self.rows()) + u64::from(row))
            * u64::from(self.columns())
            + u64::from(column);
        let offset = file.unsigned_at(&self.offsets, index)?;
        let length = match &self.byte_counts {
            Some(counts) => file.unsigned_at(counts, index)?,
            None => self.row_bytes() * u64::from(self.rows_in(row)),
        };
        // Holes in a file make it as long as anybody wants; no compression doubles its input.
        let decoded = self.row_bytes() * u64::from(self.rows_in(row));
        if self.compression != compression::NONE && length > 2 * decoded + MOST_OVERHEAD {
            return damaged(format!(
                "expected a strip or tile of {decoded} bytes, found {length} compressed ones"
            ));
        }
        Ok((offset != 0 && length != 0).then_some((offset, length)))
    }

    /// Whether the file may leave chunks out: it does, or it has too many to look at.
    pub(crate) fn may_be_sparse(&self, file: &TiffBytes) -> bool {
        let missing = |entry: &Entry| {
            file.unsigned_all(entry, MOST_CHUNKS_LOOKED_AT)
                .map_or(true, |values| values.contains(&0))
        };
        missing(&self.offsets) || self.byte_counts.as_ref().is_some_and(missing)
    }

    /// Position and length of a piece of an uncompressed strip.
    fn piece_range(
        &self,
        file: &TiffBytes,
        plane: u16,
        row: u32,
    ) -> Result<Option<(u64, u64)>, Fault> {
        let strips = u64::from(self.height.div_ceil(self.stored_rows));
        let first_row = row * self.chunk_height;
        let strip = u64::from(first_row / self.stored_rows);
        let within = u64::from(first_row % self.stored_rows);
        let offset = file.unsigned_at(&self.offsets, u64::from(plane) * strips + strip)?;
        if offset == 0 {
            return Ok(None);
        }
        let length = self.row_bytes() * u64::from(self.rows_in(row));
        match offset.checked_add(within * self.row_bytes()) {
            Some(start) => Ok(Some((start, length))),
            None => damaged("a strip lies beyond any file"),
        }
    }
}

fn side(file: &TiffBytes, ifd: &Ifd, tag: u16, name: &str) -> Result<u32, Fault> {
    match file.unsigned(ifd, tag)? {
        Some(n @ 1..=MAX_SIDE) => Ok(n as u32),
        Some(other) => damaged(format!(
            "expected a {name} of 1 to {MAX_SIDE} pixels, found {other}"
        )),
        None => damaged(format!("expected a {name}, found none")),
    }
}

/// The value that all samples share.
fn uniform(file: &TiffBytes, ifd: &Ifd, tag: u16, default: u16, name: &str) -> Result<u16, Fault> {
    let values = file.unsigned_vec(ifd, tag, 1 << 16)?;
    let first = values.first().copied().unwrap_or(default.into());
    if let Some(other) = values.iter().find(|v| **v != first) {
        return unsupported(format!(
            "expected the same {name} in all bands, found {first} and {other}"
        ));
    }
    u16::try_from(first).or_else(|_| damaged(format!("expected {name} below 65536, found {first}")))
}

fn check_compression(number: u16) -> Result<(), Fault> {
    match number {
        compression::NONE
        | compression::LZW
        | compression::JPEG
        | compression::DEFLATE
        | compression::OLD_DEFLATE
        | compression::PACK_BITS
        | compression::LERC
        | compression::ZSTD
        | compression::WEBP => Ok(()),
        other => {
            let name = match other {
                2..=4 => "a fax compression",
                6 => "old-style JPEG",
                34712 => "JPEG 2000",
                34925 => "LZMA",
                50002 => "JPEG XL",
                _ => "another compression",
            };
            unsupported(format!(
                "expected no compression, LZW, Deflate, ZSTD, PackBits, LERC, WebP or JPEG, found {name} (number {other})"
            ))
        }
    }
}

/// A compression's name, for people.
pub(crate) fn compression_name(layout: &Layout) -> &'static str {
    match layout.compression {
        compression::NONE => "none",
        compression::LZW => "LZW",
        compression::JPEG => "JPEG",
        compression::PACK_BITS => "PackBits",
        compression::ZSTD => "ZSTD",
        compression::WEBP => "WebP",
        compression::LERC => match layout.lerc {
            LercWrapping::None => "LERC",
            LercWrapping::Deflate => "LERC and Deflate",
            LercWrapping::Zstd => "LERC and ZSTD",
        },
        _ => "Deflate",
    }
}

/// Kind and width of the samples, if they are some that can be read.
fn sample_format(file: &TiffBytes, ifd: &Ifd) -> Result<(SampleFormat, u16), Fault> {
    let bits = uniform(file, ifd, tag::BITS_PER_SAMPLE, 1, "bits per sample")?;
    let format = match uniform(file, ifd, tag::SAMPLE_FORMAT, 1, "sample format")? {
        // 4 is "undefined", which means unsigned in practice.
        1 | 4 => SampleFormat::Unsigned,
        2 => SampleFormat::Signed,
        3 => SampleFormat::Float,
        5 | 6 => return unsupported("expected real samples, found complex ones"),
        other => return damaged(format!("expected a sample format 1 to 6, found {other}")),
    };
    match (format, bits) {
        (SampleFormat::Unsigned, 1..=32 | 64)
        | (SampleFormat::Signed, 8 | 16 | 32 | 64)
        | (SampleFormat::Float, 16 | 24 | 32 | 64) => Ok((format, bits)),
        _ => unsupported(format!(
            "expected unsigned integers of 1 to 32 or of 64 bits, signed ones of 8, 16, 32 or 64, or floats of 16, 24, 32 or 64, found {bits}-bit {format:?} samples"
        )),
    }
}

fn is_packed(format: SampleFormat, bits: u16) -> bool {
    match format {
        SampleFormat::Unsigned => !matches!(bits, 8 | 16 | 32 | 64),
        SampleFormat::Float => bits == 24,
        SampleFormat::Signed => false,
    }
}

/// Refuses samples that a compression cannot hold.
fn check_codec(number: u16, format: SampleFormat, bits: u16) -> Result<(), Fault> {
    let (fits, expected) = match number {
        compression::JPEG => (
            format == SampleFormat::Unsigned && bits == 8,
            "8-bit samples in JPEG",
        ),
        compression::WEBP => (
            format == SampleFormat::Unsigned && bits == 8,
            "8-bit samples in WebP",
        ),
        compression::LERC => (
            match format {
                SampleFormat::Float => matches!(bits, 32 | 64),
                SampleFormat::Unsigned | SampleFormat::Signed => matches!(bits, 8 | 16 | 32),
            },
            "integers of 8, 16 or 32 bits or floats of 32 or 64 in LERC",
        ),
        _ => return Ok(()),
    };
    if fits {
        return Ok(());
    }
    unsupported(format!(
        "expected {expected} compression, found {bits}-bit {format:?} ones"
    ))
}

/// What the LERC parameters say: a version, then the second compression.
fn lerc_wrapping(file: &TiffBytes, ifd: &Ifd) -> Result<LercWrapping, Fault> {
    match file.unsigned_vec(ifd, tag::LERC_PARAMETERS, 16)?.get(1) {
        None | Some(0) => Ok(LercWrapping::None),
        Some(1) => Ok(LercWrapping::Deflate),
        Some(2) => Ok(LercWrapping::Zstd),
        Some(other) => unsupported(format!(
            "expected LERC plain or in Deflate or ZSTD, found another compression (number {other})"
        )),
    }
}

/// Refuses predictors that do not fit the samples.
fn check_predictor(predictor: u16, format: SampleFormat, bits: u16) -> Result<(), Fault> {
    match (predictor, format, bits) {
        (1, ..) | (2, _, 8 | 16 | 32 | 64) | (3, SampleFormat::Float, 16 | 32 | 64) => Ok(()),
        _ => unsupported(format!(
            "expected predictor 1, 2 or 3 fit for the samples, found {predictor} for {bits}-bit {format:?}"
        )),
    }
}
