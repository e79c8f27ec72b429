//! Small files that claim to be large: memory follows the bytes that are there, never what a header
//! says. Allocations are counted, so the bounds are numbers, not impressions.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;

use parking_lot::Mutex;
use peak_alloc::PeakAlloc;
use relievo_raster::chunk_cache::ChunkCache;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::{Block, Cancel, PixelRect};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Tests that measure take turns: the count is one for the whole process.
static TURN: Mutex<()> = Mutex::new(());

/// Memory that reading a small file may take whatever it holds: decoders' tables and windows, the
/// blocks that are asked for.
const BASE_BYTES: usize = 24 << 20;
/// Bytes that a byte of the file may become at most without a word from the reader; what expands
/// more is bounded by [`MOST_BYTES`].
const MOST_BYTES: usize = 768 << 20;

/// What became of a file: the refusal's line if there was one, and the most bytes held at once.
struct Outcome {
    refused: Option<String>,
    peak_bytes: usize,
}

/// Opens a file and reads a small rectangle of its first and last level.
fn measure(name: &str, content: &[u8], options: &OpenOptions) -> Outcome {
    let folder = tempfile::tempdir().unwrap();
    let path = common::put(folder.path(), name, content);
    let _turn = TURN.lock();
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let refused = open_and_look(&path, options).err();
    let peak_bytes = MEMORY.peak_usage().saturating_sub(before);
    if let Some(line) = &refused {
        assert!(
            line.lines().count() == 1 && line.contains(name) && line.len() < 1000,
            "one line that names the file: {line}"
        );
    }
    Outcome {
        refused,
        peak_bytes,
    }
}

fn open_and_look(path: &Path, options: &OpenOptions) -> Result<(), String> {
    let file = open(path, options).map_err(|e| e.to_string())?;
    let info = file.info();
    for level in [0, info.overviews.len() - 1] {
        let size = info.overviews[level];
        let rect = PixelRect {
            x: size.width / 2,
            y: size.height / 2,
            width: (size.width - size.width / 2).min(64),
            height: (size.height - size.height / 2).min(64),
        };
        let mut block = Block::new(info.bands, 0, 0);
        file.read(level, rect, &mut block, &Cancel::default())
            .map_err(|e| e.to_string())?;
    }
    Ok(())
}

/// Options without and with a pyramid.
fn both() -> [OpenOptions; 2] {
    [false, true].map(|make_pyramid| OpenOptions {
        make_pyramid,
        ..OpenOptions::default()
    })
}

/// A file that must be refused, cheaply, with a line that says `part`.
fn refused_cheaply(name: &str, content: &[u8], part: &str) {
    for options in both() {
        let outcome = measure(name, content, &options);
        let line = outcome.refused.unwrap_or_else(|| panic!("{name} was read"));
        assert!(line.contains(part), "expected {part:?} in {line}");
        assert!(
            outcome.peak_bytes < BASE_BYTES,
            "{name} of {} bytes took {} bytes",
            content.len(),
            outcome.peak_bytes
        );
    }
}

/// A field of a directory: tag, type, count, and the value (or where it lies).
type Field = (u16, u16, u32, u32);

const SHORT: u16 = 3;
const LONG: u16 = 4;

/// A little-endian TIFF of one directory; `data` begins at byte `DATA_AT`.
fn tiff(fields: &[Field], data: &[u8]) -> Vec<u8> {
    let mut fields = fields.to_vec();
    fields.sort_unstable();
    let mut out = b"II\x2a\x00\x08\x00\x00\x00".to_vec();
    out.extend((fields.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in fields {
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(count.to_le_bytes());
        out.extend(value.to_le_bytes());
    }
    out.extend(0u32.to_le_bytes());
    assert!(out.len() <= DATA_AT as usize);
    out.resize(DATA_AT as usize, 0);
    out.extend(data);
    out
}

const DATA_AT: u32 = 512;

/// A single tile that holds `data`.
fn one_tile(side: u32, bits: u32, compression: u32, data: &[u8]) -> Vec<u8> {
    tiff(
        &[
            (256, LONG, 1, side),
            (257, LONG, 1, side),
            (258, SHORT, 1, bits),
            (259, SHORT, 1, compression),
            (262, SHORT, 1, 1),
            (277, SHORT, 1, 1),
            (322, LONG, 1, side),
            (323, LONG, 1, side),
            (324, LONG, 1, DATA_AT),
            (325, LONG, 1, data.len() as u32),
        ],
        data,
    )
}

/// `length` zeros as a zlib stream.
fn deflated_zeros(length: u64) -> Vec<u8> {
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::copy(
        &mut std::io::Read::take(std::io::repeat(0), length),
        &mut out,
    )
    .unwrap();
    out.finish().unwrap()
}

/// `length` zeros as a Zstandard frame of run-length blocks (RFC 8878, 3.1.1), with the window that
/// is claimed.
fn zstd_zeros(length: u64, window_log: u8) -> Vec<u8> {
    let mut out = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, (window_log - 10) << 3];
    let mut left = length;
    while left > 0 {
        let block = left.min(128 << 10);
        left -= block;
        let head = u32::from(left == 0) | 1 << 1 | (block as u32) << 3;
        out.extend(&head.to_le_bytes()[..3]);
        out.push(0);
    }
    out
}

#[test]
fn sides_that_no_image_has_are_refused() {
    for side in [1 << 31, u32::MAX] {
        let file = one_tile(side, 8, 1, &[0; 64]);
        refused_cheaply("side.tif", &file, "1073741824");
    }
    let file = one_tile(0, 8, 1, &[0; 64]);
    refused_cheaply("zero.tif", &file, "found 0");
}

#[test]
fn a_tile_that_claims_more_than_its_bytes_can_hold_is_refused() {
    for compression in [1, 5, 8, 32773, 50000] {
        let file = one_tile(16384, 8, compression, &[0; 64]);
        refused_cheaply("tile.tif", &file, "tile");
    }
}

#[test]
fn strip_positions_that_are_not_there_are_refused() {
    // 2^30 x 2^30 pixels in tiles of 256: 2^44 positions, of which the field can claim 2^32.
    let side = 1 << 30;
    for tile in [256, 32768] {
        let file = tiff(
            &[
                (256, LONG, 1, side),
                (257, LONG, 1, side),
                (258, SHORT, 1, 8),
                (259, SHORT, 1, 8),
                (262, SHORT, 1, 1),
                (322, LONG, 1, tile),
                (323, LONG, 1, tile),
                (324, LONG, u32::MAX, DATA_AT),
                (325, LONG, u32::MAX, DATA_AT),
            ],
            &[0; 4096],
        );
        refused_cheaply("positions.tif", &file, "expected");
    }
}

#[test]
fn counts_of_values_that_are_not_there_are_refused() {
    let base = |extra: Field| {
        tiff(
            &[
                (256, LONG, 1, 8),
                (257, LONG, 1, 8),
                (258, SHORT, 1, 8),
                (259, SHORT, 1, 1),
                (262, SHORT, 1, 1),
                (273, LONG, 1, DATA_AT),
                (278, LONG, 1, 8),
                (279, LONG, 1, 64),
                extra,
            ],
            &[0; 64],
        )
    };
    let ascii = 2;
    let double = 12;
    for (tag, kind) in [
        (42112, ascii),
        (42113, ascii),
        (33550, double),
        (33922, double),
        (34264, double),
        (34735, SHORT),
        (34736, double),
        (34737, ascii),
    ] {
        for count in [200, 1 << 20, u32::MAX] {
            let count = if tag == 42113 && count == 200 {
                201
            } else {
                count
            };
            let file = base((tag, kind, count, DATA_AT));
            refused_cheaply("count.tif", &file, "");
        }
    }
}

#[test]
fn sixty_five_thousand_bands_of_nothing_cost_nothing() {
    // The field holds 16 bits: 65535 bands, each of a chunk that is a megabyte high.
    for planar in [1, 2] {
        let file = tiff(
            &[
                (256, LONG, 1, 1 << 20),
                (257, LONG, 1, 1 << 20),
                (258, SHORT, 1, 8),
                (259, SHORT, 1, 8),
                (262, SHORT, 1, 1),
                (277, SHORT, 1, 65535),
                (284, SHORT, 1, planar),
                (278, LONG, 1, 1),
                (273, LONG, 1 << 20, DATA_AT),
                (279, LONG, 1 << 20, DATA_AT),
                (338, SHORT, 65535, DATA_AT),
            ],
            &[0; 256],
        );
        refused_cheaply("bands.tif", &file, "");
    }
}

#[test]
fn compressed_zeros_never_take_more_than_the_stated_memory() {
    let long = 16384 * 16384;
    for (name, compression, data) in [
        ("deflate.tif", 8, deflated_zeros(long)),
        ("zstd.tif", 50000, zstd_zeros(long, 17)),
        ("window.tif", 50000, zstd_zeros(long, 27)),
    ] {
        let file = one_tile(16384, 8, compression, &data);
        assert!(file.len() < 2 << 20, "a small file: {}", file.len());
        let options = OpenOptions {
            make_pyramid: false,
            ..OpenOptions::default()
        };
        let outcome = measure(name, &file, &options);
        assert!(
            outcome.peak_bytes < MOST_BYTES,
            "{name} took {} bytes",
            outcome.peak_bytes
        );
    }
}

#[test]
fn single_bits_count_as_the_bytes_that_they_become() {
    // 65536 x 65536 bits are 512 MiB packed and 4 GiB as samples.
    let data = zstd_zeros(65536 * 65536 / 8, 17);
    let file = one_tile(65536, 1, 50000, &data);
    refused_cheaply("bits.tif", &file, "MiB");
}

#[test]
fn a_kilobyte_that_claims_gigapixels_is_not_read_pixel_by_pixel() {
    // 64 tiles of 16384 x 16384 pixels that the file leaves out.
    let count = 64;
    let file = tiff(
        &[
            (256, LONG, 1, 16384 * 8),
            (257, LONG, 1, 16384 * 8),
            (258, SHORT, 1, 8),
            (259, SHORT, 1, 8),
            (262, SHORT, 1, 1),
            (322, LONG, 1, 16384),
            (323, LONG, 1, 16384),
            (324, LONG, count, DATA_AT),
            (325, LONG, count, DATA_AT),
        ],
        &[0; 256],
    );
    let [plain, pyramid] = both();
    let outcome = measure("sparse.tif", &file, &plain);
    assert_eq!(
        outcome.refused, None,
        "without overviews it is read where one looks"
    );
    assert!(outcome.peak_bytes < BASE_BYTES, "{}", outcome.peak_bytes);
    let outcome = measure("sparse.tif", &file, &pyramid);
    assert!(outcome.refused.unwrap().contains("overviews"));
    assert!(outcome.peak_bytes < BASE_BYTES, "{}", outcome.peak_bytes);
}

#[test]
fn an_image_of_one_compressed_strip_is_decoded_once() {
    let side = 4096;
    let file = one_tile(side, 8, 50000, &zstd_zeros(u64::from(side * side), 17));
    let options = OpenOptions {
        make_pyramid: false,
        chunk_cache: std::sync::Arc::new(ChunkCache::new(1 << 20)),
        ..OpenOptions::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = common::put(folder.path(), "strip.tif", &file);
    let file = open(&path, &options).unwrap();
    let mut block = Block::new(file.info().bands, 0, 0);
    for i in 0..16 {
        let rect = PixelRect {
            x: i * 256,
            y: i * 256,
            width: 256,
            height: 256,
        };
        file.read(0, rect, &mut block, &Cancel::default()).unwrap();
    }
    assert_eq!(options.chunk_cache.decoded(), 1);
    let kept = options.chunk_cache.bytes();
    assert!((1 << 24..1 << 25).contains(&kept), "{kept} bytes are kept");
    drop(file);
    assert_eq!(
        options.chunk_cache.bytes(),
        0,
        "a closed file keeps nothing"
    );
}

/// A PNG of RGBA with the given size in its header.
fn png(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut head = Vec::new();
    head.extend(width.to_be_bytes());
    head.extend(height.to_be_bytes());
    head.extend([8, 6, 0, 0, 0]);
    for (name, data) in [(b"IHDR", &head[..]), (b"IDAT", data), (b"IEND", &[])] {
        let mut crc = flate2::Crc::new();
        crc.update(name);
        crc.update(data);
        out.extend((data.len() as u32).to_be_bytes());
        out.extend(name);
        out.extend(data);
        out.extend(crc.sum().to_be_bytes());
    }
    out
}

#[test]
fn a_picture_header_alone_takes_no_memory() {
    for (width, height) in [(14_000, 14_000), (131_072, 1024), (100_000, 100_000)] {
        refused_cheaply("claim.png", &png(width, height, &[0; 64]), "pixels");
    }
    let jpeg = common::picture(64, 64, image::ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    for (marker, side) in [(0xc0, 16000u16), (0xc0, 65500), (0xc2, 9000), (0xc2, 16000)] {
        let mut claim = jpeg.clone();
        claim[frame + 1] = marker;
        claim[frame + 5..frame + 7].copy_from_slice(&side.to_be_bytes());
        claim[frame + 7..frame + 9].copy_from_slice(&side.to_be_bytes());
        refused_cheaply("claim.jpg", &claim, "pixels");
    }
}

#[test]
fn a_picture_of_one_colour_is_decoded_within_the_stated_memory() {
    let side = 8000;
    let file = png(
        side,
        side,
        &deflated_zeros(u64::from(side) * u64::from(side * 4 + 1)),
    );
    assert!(file.len() < 2 << 20, "a small file: {}", file.len());
    let options = OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    };
    let outcome = measure("zeros.png", &file, &options);
    assert_eq!(outcome.refused, None);
    assert!(outcome.peak_bytes < MOST_BYTES, "{}", outcome.peak_bytes);
}

#[test]
fn a_chunk_that_claims_gigabytes_of_a_file_of_holes_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut fields = vec![
        (256, LONG, 1, 64),
        (257, LONG, 1, 64),
        (258, SHORT, 1, 8),
        (259, SHORT, 1, 8),
        (262, SHORT, 1, 1),
        (322, LONG, 1, 64),
        (323, LONG, 1, 64),
        (324, LONG, 1, DATA_AT),
        (325, LONG, 1, 2_000_000_000),
    ];
    for metadata in [false, true] {
        if metadata {
            fields.push((42112, 2, 2_000_000_000, DATA_AT));
        }
        let path = common::put(folder.path(), "holes.tif", &tiff(&fields, &[0; 64]));
        std::fs::File::options()
            .write(true)
            .open(&path)
            .and_then(|file| file.set_len(3 << 30))
            .unwrap();
        let _turn = TURN.lock();
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let line = open_and_look(&path, &OpenOptions::default()).unwrap_err();
        let peak = MEMORY.peak_usage().saturating_sub(before);
        assert!(line.contains("2000000000"), "{line}");
        assert!(peak < BASE_BYTES, "{peak} bytes");
    }
}

#[test]
fn a_stretch_is_chosen_from_a_part_of_large_chunks() {
    // 16-bit colours in one tile of 8192 x 8192 pixels: a gigabyte as working samples.
    let side = 8192;
    let data = deflated_zeros(u64::from(side) * u64::from(side) * 2 * 3);
    let file = tiff(
        &[
            (256, LONG, 1, side),
            (257, LONG, 1, side),
            (258, SHORT, 1, 16),
            (259, SHORT, 1, 8),
            (262, SHORT, 1, 2),
            (277, SHORT, 1, 3),
            (322, LONG, 1, side),
            (323, LONG, 1, side),
            (324, LONG, 1, DATA_AT),
            (325, LONG, 1, data.len() as u32),
        ],
        &data,
    );
    let options = OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    };
    let outcome = measure("deep.tif", &file, &options);
    assert_eq!(outcome.refused, None);
    assert!(outcome.peak_bytes < MOST_BYTES, "{}", outcome.peak_bytes);
}

#[test]
fn a_thread_of_pixels_counts_as_the_tiles_that_it_fills() {
    // Two columns of 2^29 pixels, one below the other: a gigapixel, and four million tiles.
    let data = zstd_zeros(1 << 29, 17);
    let length = data.len() as u32;
    let tables: Vec<u8> = [1024, 1024, length, length]
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .collect();
    let mut data_and_tables = tables;
    data_and_tables.resize((1024 - DATA_AT) as usize, 0);
    data_and_tables.extend(&data);
    let file = tiff(
        &[
            (256, LONG, 1, 1),
            (257, LONG, 1, 1 << 30),
            (258, SHORT, 1, 8),
            (259, SHORT, 1, 50000),
            (262, SHORT, 1, 1),
            (278, LONG, 1, 1 << 29),
            (273, LONG, 2, DATA_AT),
            (279, LONG, 2, DATA_AT + 8),
        ],
        &data_and_tables,
    );
    let [_, pyramid] = both();
    let outcome = measure("thread.tif", &file, &pyramid);
    assert!(outcome.refused.unwrap().contains("overviews"));
    assert!(outcome.peak_bytes < BASE_BYTES, "{}", outcome.peak_bytes);
}
