use std::path::PathBuf;

use exr::compression::Compression;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Levels};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{LineOrder, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::WritableImage;
use half::f16;
use proptest::prelude::*;

use super::*;
use crate::open::open as open_any;

fn plain() -> OpenOptions {
    OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    }
}

fn encoding(compression: Compression, tile: Option<usize>) -> Encoding {
    Encoding {
        compression,
        blocks: tile.map_or(Blocks::ScanLines, |t| Blocks::Tiles(Vec2(t, t))),
        line_order: LineOrder::Increasing,
    }
}

fn attributes(name: &str) -> LayerAttributes {
    LayerAttributes::named(name).with_position(Vec2(-7, -3))
}

/// A file of some channels, its data window at (−7, −3).
fn file(
    folder: &Path,
    (width, height): (usize, usize),
    encoding: Encoding,
    channels: Vec<(&str, FlatSamples)>,
) -> PathBuf {
    let path = folder.join("made.exr");
    let channels = AnyChannels::sort(
        channels
            .into_iter()
            .map(|(name, samples)| AnyChannel::new(name, samples))
            .collect(),
    );
    let layer = Layer::new((width, height), attributes("made"), encoding, channels);
    Image::from_layer(layer).write().to_file(&path).unwrap();
    path
}

fn read(file: &dyn RasterFile, level: usize, x: u32, y: u32, width: u32, height: u32) -> Block {
    let mut block = Block::new(Bands::Height, 0, 0);
    let rect = PixelRect {
        x,
        y,
        width,
        height,
    };
    file.read(level, rect, &mut block, &Cancel::default())
        .unwrap();
    block
}

/// Whole numbers, so that half floats hold them exactly.
fn height_at(x: usize, y: usize) -> f32 {
    (x as f32) - 2.0 * (y as f32) + 300.0
}

#[test]
fn regions_are_exact_in_any_compression_type_and_layout() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (75, 43);
    let heights: Vec<f32> = (0..width * height)
        .map(|i| height_at(i % width, i / width))
        .collect();
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
    ];
    for compression in compressions {
        for tile in [None, Some(16), Some(100)] {
            let kinds = [
                FlatSamples::F32(heights.clone()),
                FlatSamples::F16(heights.iter().map(|h| f16::from_f32(*h)).collect()),
                FlatSamples::U32(heights.iter().map(|h| *h as u32).collect()),
            ];
            for samples in kinds {
                let how = format!("{compression:?} {tile:?} {}", samples.len());
                let other = FlatSamples::F16(vec![f16::ONE; width * height]);
                let path = file(
                    folder.path(),
                    (width, height),
                    encoding(compression, tile),
                    vec![("A", other), ("Z", samples)],
                );
                let file = open_any(&path, &plain()).unwrap();
                assert_eq!(file.info().bands, Bands::Height, "{how}");
                let part = read(&*file, 0, 13, 14, 37, 21);
                for (i, h) in part.plane(0).iter().enumerate() {
                    assert_eq!(*h, height_at(13 + i % 37, 14 + i / 37), "{how}");
                }
            }
        }
    }
}

#[test]
fn mip_levels_are_overviews() {
    let folder = tempfile::tempdir().unwrap();
    for rounding_mode in [RoundingMode::Down, RoundingMode::Up] {
        let sizes: Vec<(usize, usize)> = match rounding_mode {
            RoundingMode::Down => vec![(21, 10), (10, 5), (5, 2), (2, 1), (1, 1)],
            RoundingMode::Up => vec![(21, 10), (11, 5), (6, 3), (3, 2), (2, 1), (1, 1)],
        };
        let level_data = sizes
            .iter()
            .enumerate()
            .map(|(level, (w, h))| FlatSamples::F32(vec![level as f32; w * h]))
            .collect();
        let channel = AnyChannel::new(
            "height",
            Levels::Mip {
                rounding_mode,
                level_data,
            },
        );
        let layer = Layer::new(
            (21, 10),
            attributes("mip"),
            encoding(Compression::ZIP16, Some(8)),
            AnyChannels::sort([channel].into_iter().collect()),
        );
        let path = folder.path().join("mip.exr");
        Image::from_layer(layer).write().to_file(&path).unwrap();
        let file = open_any(&path, &plain()).unwrap();
        let found: Vec<(usize, usize)> = file
            .info()
            .overviews
            .iter()
            .map(|o| (o.width as usize, o.height as usize))
            .collect();
        assert_eq!(found, sizes);
        for (level, (w, h)) in sizes.into_iter().enumerate() {
            let block = read(&*file, level, 0, 0, w as u32, h as u32);
            assert!(block.plane(0).iter().all(|v| *v == level as f32));
        }
    }
}

#[test]
fn infinite_heights_are_holes_and_infinite_light_is_bright() {
    let folder = tempfile::tempdir().unwrap();
    let odd = vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0];
    let tile = encoding(Compression::Uncompressed, None);
    let path = file(
        folder.path(),
        (4, 1),
        tile,
        vec![("Y", FlatSamples::F32(odd.clone()))],
    );
    let heights = read(&*open_any(&path, &plain()).unwrap(), 0, 0, 0, 4, 1);
    assert!(heights.plane(0)[..3].iter().all(|h| h.is_nan()));
    assert_eq!(heights.plane(0)[3], 2.0);
    let path = file(
        folder.path(),
        (4, 1),
        tile,
        vec![
            ("R", FlatSamples::F32(odd)),
            ("G", FlatSamples::F32(vec![0.5; 4])),
            ("B", FlatSamples::F32(vec![0.0; 4])),
            ("A", FlatSamples::F32(vec![1.0, 1.0, 1.0, 0.5])),
        ],
    );
    let file = open_any(&path, &plain()).unwrap();
    assert!(file.info().deep_colour);
    let colours = read(&*file, 0, 0, 0, 4, 1);
    assert!(colours.samples().iter().all(|v| v.is_finite()));
    assert_eq!(colours.plane(3), [0.0, 1.0, 1.0, 0.5]);
    let light = |plane: usize, i: usize| crate::colour::linear_from_srgb(colours.plane(plane)[i]);
    assert!(
        (light(0, 1) / 65504.0 - 1.0).abs() < 1e-3,
        "{}",
        light(0, 1)
    );
    assert_eq!(light(0, 2), 0.0);
    // Half of it covers: twice the stored light shines through.
    assert!((light(0, 3) - 4.0).abs() < 1e-4 && (light(1, 3) - 1.0).abs() < 1e-5);
}

#[test]
fn the_first_part_that_can_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let layer = |name: &str, value: f32| {
        let samples = FlatSamples::F32(vec![value; 35]);
        let channels = AnyChannels::sort([AnyChannel::new("Z", samples)].into_iter().collect());
        Layer::new(
            (7, 5),
            attributes(name),
            encoding(Compression::ZIP1, None),
            channels,
        )
    };
    let layers = vec![layer("ground", 4.0), layer("roof", 9.0)];
    let size = exr::meta::attribute::IntegerBounds::new((-7, -3), (7, 5));
    let image = Image::from_layers(exr::meta::header::ImageAttributes::new(size), layers);
    let path = folder.path().join("parts.exr");
    image.write().to_file(&path).unwrap();
    let file = open_any(&path, &plain()).unwrap();
    let kind = &file.info().sample_type;
    assert!(kind.contains("ground") && kind.contains('Z'), "{kind}");
    assert!(
        read(&*file, 0, 0, 0, 7, 5)
            .plane(0)
            .iter()
            .all(|h| *h == 4.0)
    );
    // With deep data where the first part's type is said, the second is the first to be read.
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes
        .windows(13)
        .position(|w| w == b"scanlineimage")
        .unwrap();
    bytes[at..at + 13].copy_from_slice(b"deepscanline\0");
    std::fs::write(&path, bytes).unwrap();
    if let Ok(file) = open_any(&path, &plain()) {
        assert!(file.info().sample_type.contains("roof"));
    }
}

#[test]
fn attributes_place_the_data_window() {
    let folder = tempfile::tempdir().unwrap();
    let channels = AnyChannels::sort(
        [AnyChannel::new("Z", FlatSamples::F32(vec![0.0; 35]))]
            .into_iter()
            .collect(),
    );
    let affine = [500_000.5, 2.0, 0.25, 4e6, -0.25, -2.0];
    let mut place = attributes("placed");
    place.other.insert(
        Text::from(place::TRANSFORM),
        exr::meta::attribute::AttributeValue::Custom {
            kind: Text::from(place::TRANSFORM_KIND),
            bytes: place::transform_bytes(affine).into(),
        },
    );
    place.other.insert(
        Text::from(place::CRS),
        exr::meta::attribute::AttributeValue::Text("EPSG:32612".into()),
    );
    let layer = Layer::new((7, 5), place, encoding(Compression::ZIP1, None), channels);
    let path = folder.path().join("placed.exr");
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let file = open_any(&path, &plain()).unwrap();
    let found = file.info().georeference.clone().unwrap();
    assert_eq!(found.plane_from_pixel, affine);
    assert_eq!(&*found.crs, "EPSG:32612");
}

#[test]
fn a_file_without_heights_or_colours_says_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(
        folder.path(),
        (2, 1),
        encoding(Compression::ZIP1, None),
        vec![
            ("velocity.u", FlatSamples::F32(vec![0.0; 2])),
            ("velocity.v", FlatSamples::F32(vec![0.0; 2])),
        ],
    );
    let error = open_any(&path, &plain()).map(drop).unwrap_err().to_string();
    assert!(error.contains("velocity.u, velocity.v"), "{error}");
    let chosen = OpenOptions {
        select: Some(vec![1]),
        ..plain()
    };
    assert!(open_any(&path, &chosen).is_ok());
}

fn small(tile: Option<usize>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let samples = FlatSamples::F32((0..63).map(|i| i as f32).collect());
    let path = file(
        folder.path(),
        (9, 7),
        encoding(Compression::ZIP16, tile),
        vec![("Y", samples)],
    );
    std::fs::read(path).unwrap()
}

/// Opens and reads everything; the error's text.
fn answer(bytes: &[u8]) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.exr");
    std::fs::write(&path, bytes).unwrap();
    let file = open_any(&path, &plain()).map_err(|e| e.to_string())?;
    for (level, size) in file.info().overviews.iter().enumerate() {
        let mut block = Block::new(Bands::Height, 0, 0);
        let rect = PixelRect {
            x: 0,
            y: 0,
            width: size.width.min(4096),
            height: size.height.min(64),
        };
        file.read(level, rect, &mut block, &Cancel::default())
            .map_err(|e| e.to_string())?;
    }
    Ok(())
}

#[test]
fn a_file_that_ends_anywhere_is_refused_in_one_line() {
    for tile in [None, Some(4)] {
        let bytes = small(tile);
        answer(&bytes).unwrap();
        for length in 0..bytes.len() {
            let line = answer(&bytes[..length]).unwrap_err();
            assert!(!line.contains('\n') && line.contains("odd.exr"), "{line}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn changed_bytes_never_panic(
        tiled in any::<bool>(),
        changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..5),
    ) {
        let mut bytes = small(tiled.then_some(4));
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        answer(&bytes).ok();
    }
}
