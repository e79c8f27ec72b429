//! OpenEXR, tile by tile.
//!
//! The place of the pixels goes into two attributes: `gdal:geoTransform` (m33d), which GDAL reads
//! too, and `relievo:crs` (string) with the name of the system. This program's reader takes both.

use std::io;
use std::path::Path;

use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{
    AttributeValue, ChannelDescription, LevelMode, LineOrder, SampleType, Text, TileDescription,
};
use ::exr::meta::header::Header;
use half::f16;

use super::{WriteError, atomically};
use crate::file::{Cancel, Georeference, PixelRect};
use crate::openexr::place;
use crate::{Bands, Block, colour, normal};

/// Largest half float: brighter light is stored as this.
const BRIGHTEST: f32 = 65504.0;

/// What a file stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExrSamples {
    /// One channel of f32 called `height`, in metres; NaN for holes.
    Height,
    /// Four channels of half floats: linear light, premultiplied by alpha, as the format has it.
    Colour,
    /// Three channels of f32 called `X`, `Y`, `Z`: east, north and up component of unit normals.
    Normal,
}

impl ExrSamples {
    /// What blocks hold.
    pub const fn bands(self) -> Bands {
        match self {
            Self::Height => Bands::Height,
            Self::Colour => Bands::Colour,
            Self::Normal => Bands::Normal,
        }
    }

    /// Channels in the order of the file, which is that of their names.
    fn channels(self) -> Vec<ChannelDescription> {
        let (names, kind): (&[&str], _) = match self {
            Self::Height => (&["height"], SampleType::F32),
            Self::Colour => (&["A", "B", "G", "R"], SampleType::F16),
            Self::Normal => (&["X", "Y", "Z"], SampleType::F32),
        };
        names
            .iter()
            .map(|name| ChannelDescription::named(*name, kind))
            .collect()
    }
}

/// Shape and place of a file to be written.
#[derive(Clone, Debug)]
pub struct ExrLayout {
    /// Columns, 1 to 2³⁰.
    pub width: u32,
    /// Rows, 1 to 2³⁰.
    pub height: u32,
    /// What is stored.
    pub samples: ExrSamples,
    /// Side of a tile, 16 to 4096.
    pub tile: u32,
    /// Where the pixels lie, if anywhere.
    pub georeference: Option<Georeference>,
}

/// What gives the samples of a file that is written: fills a block with a rectangle of them.
pub type ExrSource<'a> =
    dyn FnMut(PixelRect, &mut Block) -> Result<(), Box<dyn core::error::Error + Send + Sync>> + 'a;

/// Writes an OpenEXR file: tiled, one level, ZIP compression; whole or not at all. Memory holds one
/// tile, whatever the size.
///
/// - `source`: fills a block (reshaped to fit) with the samples of a rectangle; called once per
///   tile, row by row from the north.
/// - `progress`: called with the part that is done, 0 to 1, never falling.
///
/// # Errors
/// [`WriteError`] when the layout cannot be stored, the source fails, the system refuses, or work
/// was cancelled. No file is left then, and one that was there before is untouched.
pub fn write_exr(
    path: &Path,
    layout: &ExrLayout,
    source: &mut ExrSource<'_>,
    progress: &mut dyn FnMut(f64),
    cancel: &Cancel,
) -> Result<(), WriteError> {
    let unsupported = |reason: String| WriteError::Unsupported {
        reason,
        path: path.to_owned(),
    };
    let sides = 1..=1_u32 << 30;
    if !sides.contains(&layout.width) || !sides.contains(&layout.height) {
        return Err(unsupported(format!(
            "expected sides of 1 to 2³⁰ pixels, found {} × {}",
            layout.width, layout.height
        )));
    }
    if !(16..=4096).contains(&layout.tile) {
        return Err(unsupported(format!(
            "expected tiles of 16 to 4096, found {}",
            layout.tile
        )));
    }
    let header = header(layout).map_err(unsupported)?;
    let mut trouble = None;
    let written = atomically(path, |out| {
        let result =
            ::exr::block::write(out, [header].into_iter().collect(), true, |meta, chunks| {
                let mut tiles = Tiles {
                    layout,
                    source,
                    cancel,
                    block: Block::new(layout.samples.bands(), 0, 0),
                };
                let (columns, rows) = tiles.count();
                for index in 0..u64::from(columns) * u64::from(rows) {
                    let (column, row) = (
                        (index % u64::from(columns)) as u32,
                        (index / u64::from(columns)) as u32,
                    );
                    let tile = match tiles.make(column, row) {
                        Ok(tile) => tile,
                        Err(error) => {
                            trouble = Some(error);
                            return Err(::exr::error::Error::Aborted);
                        }
                    };
                    let chunk = tile.compress_to_chunk(&meta.headers)?;
                    chunks.write_chunk(index as usize, chunk)?;
                    progress((index + 1) as f64 / (u64::from(columns) * u64::from(rows)) as f64);
                }
                Ok(())
            });
        result.map_err(|error| match error {
            ::exr::error::Error::Io(error) => error,
            other @ (::exr::error::Error::Aborted
            | ::exr::error::Error::NotSupported(_)
            | ::exr::error::Error::Invalid(_)) => io::Error::other(other.to_string()),
        })
    });
    match trouble {
        Some(error) => Err(error),
        None => written,
    }
}

fn header(layout: &ExrLayout) -> Result<Header, String> {
    let name = match layout.samples {
        ExrSamples::Height => "height",
        ExrSamples::Colour => "colour",
        ExrSamples::Normal => "normal",
    };
    let size = (layout.width as usize, layout.height as usize);
    let tiles = TileDescription {
        tile_size: Vec2(layout.tile as usize, layout.tile as usize),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    };
    let mut header = Header::new(
        Text::from(name),
        size,
        layout.samples.channels().into_iter().collect(),
    )
    .with_encoding(
        Compression::ZIP16,
        BlockDescription::Tiles(tiles),
        LineOrder::Increasing,
    );
    if let Some(georeference) = &layout.georeference {
        let crs = Text::new_or_none(&*georeference.crs)
            .ok_or_else(|| format!("expected a system in Latin letters, found {georeference:?}"))?;
        let transform = AttributeValue::Custom {
            kind: Text::from(place::TRANSFORM_KIND),
            bytes: place::transform_bytes(georeference.plane_from_pixel).into(),
        };
        // One attribute in each map: their order in the file is the same every time.
        header
            .own_attributes
            .other
            .insert(Text::from(place::TRANSFORM), transform);
        header
            .shared_attributes
            .other
            .insert(Text::from(place::CRS), AttributeValue::Text(crs));
    }
    Ok(header)
}

/// Tiles on their way to the file.
struct Tiles<'a, 'b> {
    layout: &'a ExrLayout,
    source: &'a mut ExrSource<'b>,
    cancel: &'a Cancel,
    block: Block,
}

impl Tiles<'_, '_> {
    /// Columns and rows of tiles.
    fn count(&self) -> (u32, u32) {
        (
            self.layout.width.div_ceil(self.layout.tile),
            self.layout.height.div_ceil(self.layout.tile),
        )
    }

    fn make(&mut self, column: u32, row: u32) -> Result<UncompressedBlock, WriteError> {
        if self.cancel.is_cancelled() {
            return Err(WriteError::Cancelled);
        }
        let ExrLayout {
            width,
            height,
            samples,
            tile,
            ..
        } = *self.layout;
        let (x, y) = (column * tile, row * tile);
        let rect = PixelRect {
            x,
            y,
            width: tile.min(width - x),
            height: tile.min(height - y),
        };
        (self.source)(rect, &mut self.block).map_err(WriteError::Samples)?;
        let shape = (self.block.width(), self.block.height());
        if shape != (rect.width as usize, rect.height as usize)
            || self.block.bands() != samples.bands()
        {
            return Err(WriteError::Samples(
                "the source gave a block of another shape than asked for".into(),
            ));
        }
        Ok(UncompressedBlock {
            index: BlockIndex {
                layer: 0,
                pixel_position: Vec2(x as usize, y as usize),
                pixel_size: Vec2(shape.0, shape.1),
                level: Vec2(0, 0),
            },
            data: bytes(&mut self.block, samples),
        })
    }
}

/// A block as the format has it: for each row, for each channel, the row's samples in the machine's
/// byte order.
fn bytes(block: &mut Block, samples: ExrSamples) -> Vec<u8> {
    if samples == ExrSamples::Colour {
        colour::premultiply(block);
    }
    let width = block.width();
    let mut out = Vec::new();
    for y in 0..block.height() {
        let row = |plane: usize| block.plane(plane)[y * width..(y + 1) * width].iter();
        match samples {
            ExrSamples::Height => out.extend(row(0).flat_map(|h| h.to_ne_bytes())),
            ExrSamples::Colour => {
                for plane in [3, 2, 1, 0] {
                    out.extend(
                        row(plane).flat_map(|v| {
                            f16::from_f32(v.clamp(-BRIGHTEST, BRIGHTEST)).to_ne_bytes()
                        }),
                    );
                }
            }
            ExrSamples::Normal => {
                let units = row(0)
                    .zip(row(1))
                    .map(|(x, y)| normal::unit([*x, *y]).as_vec3());
                let units: Vec<[f32; 3]> = units.map(Into::into).collect();
                for component in 0..3 {
                    out.extend(units.iter().flat_map(|unit| unit[component].to_ne_bytes()));
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::{OpenOptions, open};

    fn layout(samples: ExrSamples) -> ExrLayout {
        ExrLayout {
            width: 70,
            height: 41,
            samples,
            tile: 32,
            georeference: Some(Georeference {
                crs: "EPSG:32612".into(),
                plane_from_pixel: [440_000.25, 2.0, 0.0, 4_455_000.5, 0.0, -2.0],
            }),
        }
    }

    fn fill(
        rect: PixelRect,
        out: &mut Block,
        value: impl Fn(u32, u32, usize) -> f32,
        bands: Bands,
    ) {
        out.reshape(bands, rect.width as usize, rect.height as usize);
        for plane in 0..bands.planes() {
            for (i, v) in out.plane_mut(plane).iter_mut().enumerate() {
                let i = i as u32;
                *v = value(rect.x + i % rect.width, rect.y + i / rect.width, plane);
            }
        }
    }

    fn write(path: &Path, layout: &ExrLayout, value: impl Fn(u32, u32, usize) -> f32) {
        let bands = layout.samples.bands();
        let mut parts = Vec::new();
        write_exr(
            path,
            layout,
            &mut |rect, out| {
                fill(rect, out, &value, bands);
                Ok(())
            },
            &mut |part| parts.push(part),
            &Cancel::default(),
        )
        .unwrap();
        assert!(parts.is_sorted() && parts.last() == Some(&1.0));
    }

    fn read(path: &Path, bands: Bands) -> Block {
        let options = OpenOptions {
            make_pyramid: false,
            ..OpenOptions::default()
        };
        let file = open(path, &options).unwrap();
        let info = file.info();
        assert_eq!(info.bands, bands);
        assert_eq!(info.georeference, layout(ExrSamples::Height).georeference);
        assert_eq!(info.compression, "ZIP");
        let mut block = Block::new(bands, 0, 0);
        let rect = PixelRect {
            x: 0,
            y: 0,
            width: 70,
            height: 41,
        };
        file.read(0, rect, &mut block, &Cancel::default()).unwrap();
        block
    }

    #[test]
    fn heights_come_back_to_the_bit_with_their_place_and_holes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.exr");
        let height = |x: u32, y: u32, _: usize| {
            if (x, y) == (33, 2) {
                f32::NAN
            } else {
                1e3 / (x as f32 + 0.3) - y as f32
            }
        };
        write(&path, &layout(ExrSamples::Height), height);
        let block = read(&path, Bands::Height);
        for (i, h) in block.plane(0).iter().enumerate() {
            let expected = height(i as u32 % 70, i as u32 / 70, 0);
            assert!(h.to_bits() == expected.to_bits() || (h.is_nan() && expected.is_nan()));
        }
    }

    #[test]
    fn colours_come_back_within_a_half_float() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.exr");
        let value = |x: u32, y: u32, plane: usize| match plane {
            3 => {
                if y == 7 {
                    0.0
                } else {
                    0.5
                }
            }
            _ if y == 7 => 0.0,
            p => ((x + 7 * y + 40 * p as u32) % 256) as f32 / 200.0,
        };
        write(&path, &layout(ExrSamples::Colour), value);
        let block = read(&path, Bands::Colour);
        for plane in 0..4 {
            for (i, v) in block.plane(plane).iter().enumerate() {
                let expected = value(i as u32 % 70, i as u32 / 70, plane);
                // Eleven bits of linear light, and the tables of the transfer function.
                assert!((v - expected).abs() < 1e-3, "{plane} {i}: {v} {expected}");
            }
        }
    }

    #[test]
    fn the_same_samples_give_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let bytes: Vec<Vec<u8>> = (0..4)
            .map(|i| {
                let path = folder.path().join(format!("{i}.exr"));
                write(&path, &layout(ExrSamples::Normal), |x, y, _| {
                    ((x * y) % 7) as f32 / 20.0
                });
                std::fs::read(path).unwrap()
            })
            .collect();
        assert!(bytes.iter().all(|b| *b == bytes[0]));
    }

    #[test]
    fn a_source_that_fails_or_a_request_to_stop_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none.exr");
        let cancel = Cancel::default();
        let error = write_exr(
            &path,
            &layout(ExrSamples::Height),
            &mut |_, _| Err("no samples today".into()),
            &mut |_| {},
            &cancel,
        )
        .unwrap_err();
        assert!(error.to_string().contains("no samples today"));
        let error = write_exr(
            &path,
            &layout(ExrSamples::Height),
            &mut |rect, out| {
                cancel.cancel();
                fill(rect, out, |_, _, _| 0.0, Bands::Height);
                Ok(())
            },
            &mut |_| {},
            &cancel,
        )
        .unwrap_err();
        assert!(matches!(error, WriteError::Cancelled));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
