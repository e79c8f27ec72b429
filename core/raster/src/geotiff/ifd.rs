//! Headers and directories of TIFF and BigTIFF files, both byte orders.
//!
//! Arrays of chunk positions are never read whole: an image of a million by a million pixels costs no
//! more to open than a small one, and a header that lies about a count costs nothing.
//! Source: TIFF 6.0 (Adobe, 1992) section 2; BigTIFF as libtiff documents it.

use super::bytes::Bytes;
use super::fault::{Fault, damaged};

/// Directories read at most: more are no pyramid.
const MAX_DIRECTORIES: usize = 256;
/// Entries of a directory at most.
const MAX_ENTRIES: u64 = 4096;

/// Tags that the reader looks at.
pub(crate) mod tag {
    pub(crate) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(crate) const IMAGE_WIDTH: u16 = 256;
    pub(crate) const IMAGE_LENGTH: u16 = 257;
    pub(crate) const BITS_PER_SAMPLE: u16 = 258;
    pub(crate) const COMPRESSION: u16 = 259;
    pub(crate) const PHOTOMETRIC: u16 = 262;
    pub(crate) const FILL_ORDER: u16 = 266;
    pub(crate) const STRIP_OFFSETS: u16 = 273;
    pub(crate) const SAMPLES_PER_PIXEL: u16 = 277;
    pub(crate) const ROWS_PER_STRIP: u16 = 278;
    pub(crate) const STRIP_BYTE_COUNTS: u16 = 279;
    pub(crate) const PLANAR_CONFIGURATION: u16 = 284;
    pub(crate) const PREDICTOR: u16 = 317;
    pub(crate) const COLOUR_MAP: u16 = 320;
    pub(crate) const TILE_WIDTH: u16 = 322;
    pub(crate) const TILE_LENGTH: u16 = 323;
    pub(crate) const TILE_OFFSETS: u16 = 324;
    pub(crate) const TILE_BYTE_COUNTS: u16 = 325;
    pub(crate) const EXTRA_SAMPLES: u16 = 338;
    pub(crate) const SAMPLE_FORMAT: u16 = 339;
    pub(crate) const JPEG_TABLES: u16 = 347;
    pub(crate) const MODEL_PIXEL_SCALE: u16 = 33550;
    pub(crate) const MODEL_TIEPOINT: u16 = 33922;
    pub(crate) const MODEL_TRANSFORMATION: u16 = 34264;
    pub(crate) const GEO_KEY_DIRECTORY: u16 = 34735;
    pub(crate) const GEO_DOUBLE_PARAMS: u16 = 34736;
    pub(crate) const GEO_ASCII_PARAMS: u16 = 34737;
    pub(crate) const GDAL_METADATA: u16 = 42112;
    pub(crate) const GDAL_NODATA: u16 = 42113;
    pub(crate) const LERC_PARAMETERS: u16 = 50674;
}

/// Byte order and offset size of a file, with its bytes.
#[derive(Debug)]
pub(crate) struct TiffBytes {
    pub(crate) bytes: Bytes,
    pub(crate) big_endian: bool,
    big_offsets: bool,
}

/// One entry of a directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    tag: u16,
    kind: u16,
    /// Number of values.
    pub(crate) count: u64,
    /// Where the values lie in the file, inline ones too.
    at: u64,
}

/// One directory: an image, an overview or a mask.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ifd {
    entries: Vec<Entry>,
}

impl TiffBytes {
    /// Reads the header and every directory of the chain.
    pub(crate) fn open(bytes: Bytes) -> Result<(Self, Vec<Ifd>), Fault> {
        let mut head = [0; 4];
        bytes.read_at(0, &mut head)?;
        let big_endian = match &head[..2] {
            b"II" => false,
            b"MM" => true,
            _ => return damaged("expected a TIFF header (II or MM)"),
        };
        let mut file = Self {
            bytes,
            big_endian,
            big_offsets: false,
        };
        let mut next = match file.number(&head[2..]) {
            42 => file.number_at(4, 4)?,
            43 => {
                file.big_offsets = true;
                if file.number_at(4, 2)? != 8 {
                    return damaged("expected 8-byte offsets in the BigTIFF header");
                }
                file.number_at(8, 8)?
            }
            other => return damaged(format!("expected TIFF version 42 or 43, found {other}")),
        };
        let mut directories = Vec::new();
        let mut seen = Vec::new();
        while next != 0 {
            if seen.contains(&next) {
                return damaged("the chain of directories runs in a circle");
            }
            if directories.len() == MAX_DIRECTORIES {
                return damaged(format!("expected at most {MAX_DIRECTORIES} directories"));
            }
            seen.push(next);
            let (directory, following) = file.directory(next)?;
            directories.push(directory);
            next = following;
        }
        if directories.is_empty() {
            return damaged("expected an image, found no directory");
        }
        Ok((file, directories))
    }

    fn directory(&self, at: u64) -> Result<(Ifd, u64), Fault> {
        let (count_size, entry_size, offset_size) = if self.big_offsets {
            (8, 20, 8)
        } else {
            (2, 12, 4)
        };
        let count = self.number_at(at, count_size)?;
        if count == 0 || count > MAX_ENTRIES {
            return damaged(format!(
                "expected 1 to {MAX_ENTRIES} entries in a directory, found {count}"
            ));
        }
        let start = at + count_size as u64;
        let table = self.bytes.vec_at(start, count * entry_size + offset_size)?;
        let mut entries = Vec::with_capacity(count as usize);
        for (i, raw) in table
            .chunks_exact(entry_size as usize)
            .take(count as usize)
            .enumerate()
        {
            let kind = self.number(&raw[2..4]) as u16;
            let (count_bytes, value) = raw[4..].split_at(offset_size as usize);
            let count = self.number(count_bytes);
            let inline = count
                .checked_mul(value_size(kind))
                .is_some_and(|n| n <= offset_size);
            let value_at = start + i as u64 * entry_size + 4 + offset_size;
            entries.push(Entry {
                tag: self.number(&raw[..2]) as u16,
                kind,
                count,
                at: if inline { value_at } else { self.number(value) },
            });
        }
        let following = self.number(&table[(count * entry_size) as usize..]);
        Ok((Ifd { entries }, following))
    }

    fn number_at(&self, at: u64, size: usize) -> Result<u64, Fault> {
        let mut buffer = [0; 8];
        self.bytes.read_at(at, &mut buffer[..size])?;
        Ok(self.number(&buffer[..size]))
    }

    /// An unsigned integer of up to 8 bytes in the file's order.
    fn number(&self, bytes: &[u8]) -> u64 {
        let fold = |n: u64, b: &u8| (n << 8) | u64::from(*b);
        if self.big_endian {
            bytes.iter().fold(0, fold)
        } else {
            bytes.iter().rev().fold(0, fold)
        }
    }

    /// Value `index` of an entry as an unsigned integer.
    pub(crate) fn unsigned_at(&self, entry: &Entry, index: u64) -> Result<u64, Fault> {
        if index >= entry.count {
            return damaged(format!(
                "expected more than {} values in tag {}",
                entry.count, entry.tag
            ));
        }
        check_unsigned(entry)?;
        let size = value_size(entry.kind);
        let at = index
            .checked_mul(size)
            .and_then(|n| n.checked_add(entry.at));
        let Some(at) = at else {
            return damaged("a position beyond any file");
        };
        self.number_at(at, size as usize)
    }

    /// Whether the file has the first `count` values of an entry.
    pub(crate) fn holds(&self, entry: &Entry, count: u64) -> bool {
        count
            .checked_mul(value_size(entry.kind))
            .and_then(|n| n.checked_add(entry.at))
            .is_some_and(|end| end <= self.bytes.length())
    }

    /// The first value of a tag as an unsigned integer.
    pub(crate) fn unsigned(&self, ifd: &Ifd, tag: u16) -> Result<Option<u64>, Fault> {
        ifd.find(tag)
            .map(|entry| self.unsigned_at(entry, 0))
            .transpose()
    }

    /// All values of a tag as unsigned integers; at most `limit` of them.
    pub(crate) fn unsigned_vec(&self, ifd: &Ifd, tag: u16, limit: u64) -> Result<Vec<u64>, Fault> {
        ifd.find(tag)
            .map_or(Ok(Vec::new()), |entry| self.unsigned_all(entry, limit))
    }

    /// All values of an entry as unsigned integers; at most `limit` of them.
    pub(crate) fn unsigned_all(&self, entry: &Entry, limit: u64) -> Result<Vec<u64>, Fault> {
        check_count(entry, limit)?;
        check_unsigned(entry)?;
        let size = value_size(entry.kind);
        let raw = self.bytes.vec_at(entry.at, entry.count * size)?;
        Ok(raw
            .chunks_exact(size as usize)
            .map(|value| self.number(value))
            .collect())
    }

    /// All values of a tag of doubles or floats; at most `limit` of them.
    pub(crate) fn f64_vec(&self, ifd: &Ifd, tag: u16, limit: u64) -> Result<Vec<f64>, Fault> {
        let Some(entry) = ifd.find(tag) else {
            return Ok(Vec::new());
        };
        check_count(entry, limit)?;
        let raw = self
            .bytes
            .vec_at(entry.at, entry.count * value_size(entry.kind))?;
        match entry.kind {
            11 => Ok(raw
                .chunks_exact(4)
                .map(|b| f64::from(f32::from_bits(self.number(b) as u32)))
                .collect()),
            12 => Ok(raw
                .chunks_exact(8)
                .map(|b| f64::from_bits(self.number(b)))
                .collect()),
            other => damaged(format!("expected doubles in tag {tag}, found type {other}")),
        }
    }

    /// The bytes of a tag of bytes or text; at most `limit`.
    pub(crate) fn byte_vec(
        &self,
        ifd: &Ifd,
        tag: u16,
        limit: u64,
    ) -> Result<Option<Vec<u8>>, Fault> {
        let Some(entry) = ifd.find(tag) else {
            return Ok(None);
        };
        check_count(entry, limit)?;
        match entry.kind {
            1 | 2 | 6 | 7 => Ok(Some(self.bytes.vec_at(entry.at, entry.count)?)),
            other => damaged(format!("expected bytes in tag {tag}, found type {other}")),
        }
    }

    /// The text of a tag, without what follows the first NUL.
    pub(crate) fn text(&self, ifd: &Ifd, tag: u16, limit: u64) -> Result<Option<String>, Fault> {
        Ok(self.byte_vec(ifd, tag, limit)?.map(|bytes| {
            let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
            String::from_utf8_lossy(&bytes[..end]).into_owned()
        }))
    }
}

impl Ifd {
    /// The entry of a tag that has at least one value.
    pub(crate) fn find(&self, tag: u16) -> Option<&Entry> {
        self.entries
            .iter()
            .find(|entry| entry.tag == tag && entry.count > 0)
    }
}

fn check_count(entry: &Entry, limit: u64) -> Result<(), Fault> {
    if entry.count > limit {
        return damaged(format!(
            "expected at most {limit} values in tag {}, found {}",
            entry.tag, entry.count
        ));
    }
    Ok(())
}

fn check_unsigned(entry: &Entry) -> Result<(), Fault> {
    match entry.kind {
        1 | 3 | 4 | 13 | 16 | 18 => Ok(()),
        other => damaged(format!(
            "expected an unsigned integer in tag {}, found type {other}",
            entry.tag
        )),
    }
}

/// Bytes of one value of a field type; unknown types count as one.
fn value_size(kind: u16) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => 1,
    }
}
