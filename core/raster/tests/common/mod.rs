//! Small files made for tests.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]
#![allow(dead_code, reason = "each test program uses a part of them")]

use std::io::Cursor;
use std::path::{Path, PathBuf};

use relievo_raster::open::{OpenError, OpenOptions, open};
use relievo_raster::{Block, Cancel, PixelRect, RasterFile};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// Writes bytes into a folder.
pub(crate) fn put(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// A GeoTIFF of heights `column + 100 · row` in EPSG:4326, pixels of 1°, from 10° E 50° N.
pub(crate) fn heights(width: u32, height: u32, point: bool) -> Vec<u8> {
    let samples: Vec<i16> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x + 100 * y) as i16))
        .collect();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder
        .new_image::<colortype::GrayI16>(width, height)
        .unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[1.0, 1.0, 0.0][..])
        .unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 10.0, 50.0, 0.0][..])
        .unwrap();
    let keys: [u16; 16] = [
        1,
        1,
        0,
        3,
        1024,
        0,
        1,
        2,
        1025,
        0,
        1,
        1 + u16::from(point),
        2048,
        0,
        1,
        4326,
    ];
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    tags.write_tag(Tag::GdalNodata, "101").unwrap();
    image.write_data(&samples).unwrap();
    bytes.into_inner()
}

/// A picture in a format of the `image` crate.
pub(crate) fn picture(width: u32, height: u32, format: image::ImageFormat) -> Vec<u8> {
    let picture = image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([(x * 7) as u8, (y * 5) as u8, 128])
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Opens a file and reads all of every level.
pub(crate) fn open_and_read(path: &Path, options: &OpenOptions) -> Result<Vec<Block>, String> {
    let file = open(path, options).map_err(|e: OpenError| e.to_string())?;
    (0..file.info().overviews.len())
        .map(|level| read_level(&*file, level))
        .collect()
}

/// All of one level.
pub(crate) fn read_level(file: &dyn RasterFile, level: usize) -> Result<Block, String> {
    let size = file.info().overviews[level];
    let mut block = Block::new(file.info().bands, 0, 0);
    let rect = PixelRect {
        x: 0,
        y: 0,
        width: size.width.min(2048),
        height: size.height.min(2048),
    };
    file.read(level, rect, &mut block, &Cancel::default())
        .map_err(|e| e.to_string())?;
    Ok(block)
}
