//! How large a picture may be: what decoding takes in memory is known from the header, and a header
//! alone never makes anybody take it.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::Format;

/// Bytes that decoding takes at most: 16384 x 16384 pixels of three bytes.
pub(super) const MOST_BYTES: u64 = 768 << 20;
/// Longest side of a picture.
pub(super) const MAX_SIDE: u32 = 1 << 17;
/// Bytes of a decoded picture up to which nobody asks how many bytes it was made from.
const SMALL_BYTES: u64 = 1 << 20;
/// Segments of a JPEG before its frame at most.
const MOST_SEGMENTS: usize = 4096;

/// What is wrong with a picture's size.
pub(super) enum TooLarge {
    /// Its memory: bytes that it needs.
    Memory(u64),
    /// Its claim: bytes that the file has.
    Claim(u64),
}

/// Checks a picture of `bytes` decoded bytes before anything of that size is allocated.
pub(super) fn check(path: &Path, format: Format, bytes: u64) -> io::Result<Result<(), TooLarge>> {
    let length = std::fs::metadata(path)?.len();
    // Decoded bytes for a byte of the file at most.
    let (most_expansion, needed) = match format {
        // A match of 258 bytes takes at least two bits, and a bit of a palette may become four bytes.
        Format::Png => (1100 * 32, bytes),
        // A block of 8 x 8 pixels takes a bit at least; with colours at a quarter of both sides there
        // are 18 blocks for 1024 pixels of three bytes. A progressive picture is kept as coefficients
        // of two bytes besides.
        Format::Jpeg => (
            1400,
            if is_progressive(path)? {
                3 * bytes
            } else {
                bytes
            },
        ),
        // A few bytes may stand for any number of pixels of one colour; the decoder holds them twice.
        Format::WebP => (MOST_BYTES, 2 * bytes),
    };
    if needed > MOST_BYTES {
        return Ok(Err(TooLarge::Memory(needed)));
    }
    if bytes > SMALL_BYTES && bytes / most_expansion > length {
        return Ok(Err(TooLarge::Claim(length)));
    }
    Ok(Ok(()))
}

/// Whether the frame header of a JPEG announces several passes; `false` where there is none.
fn is_progressive(path: &Path) -> io::Result<bool> {
    let mut file = BufReader::new(File::open(path)?);
    file.seek(SeekFrom::Start(2))?;
    let mut segment = [0; 4];
    for _ in 0..MOST_SEGMENTS {
        // Any number of fill bytes may stand before a marker.
        while file.fill_buf()?.starts_with(&[0xff, 0xff]) {
            file.consume(1);
        }
        match file.read_exact(&mut segment) {
            Ok(()) => {}
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
            Err(e) => return Err(e),
        }
        match segment {
            [0xff, 0xc2 | 0xc6 | 0xca | 0xce, ..] => return Ok(true),
            [0xff, 0xc0 | 0xc1 | 0xc3 | 0xda, ..] => return Ok(false),
            [0xff, _, high, low] => {
                let length = i64::from(u16::from_be_bytes([high, low]));
                file.seek_relative((length - 2).max(0))?;
            }
            _ => return Ok(false),
        }
    }
    // Who hides the frame so well is taken for the worst.
    Ok(true)
}
