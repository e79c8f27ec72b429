use std::io::BufReader;

use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::*;
use crate::file::{Cancel, Georeference, PixelRect};
use crate::{Bands, Block, colour, reduce};

type Failure = Box<dyn core::error::Error + Send + Sync>;

fn part(of: &Block, rect: PixelRect, out: &mut Block) {
    out.reshape(of.bands(), rect.width as usize, rect.height as usize);
    let (x, y) = (rect.x as usize, rect.y as usize);
    out.copy_from(
        of,
        (x, y),
        (0, 0),
        (rect.width as usize, rect.height as usize),
    );
}

fn write(path: &Path, of: &Block, samples: CogSamples) -> Result<(), WriteError> {
    let layout = CogLayout {
        width: of.width() as u32,
        height: of.height() as u32,
        samples,
        tile: 256,
        georeference: Some(Georeference {
            crs: "EPSG:32612".into(),
            plane_from_pixel: [400_000.0, 30.0, 0.0, 4_500_000.0, 0.0, -30.0],
        }),
    };
    let mut last = 0.0;
    let mut progress = |p: f64| {
        assert!(p >= last && p <= 1.0);
        last = p;
    };
    let mut source = |rect, out: &mut Block| -> Result<(), Failure> {
        part(of, rect, out);
        Ok(())
    };
    write_cog(
        path,
        &layout,
        &mut source,
        &mut progress,
        &Cancel::default(),
    )
}

fn heights(width: usize, height: usize) -> Block {
    let mut block = Block::new(Bands::Height, width, height);
    for (i, v) in block.plane_mut(0).iter_mut().enumerate() {
        let (x, y) = (i % width, i / width);
        *v = if x.abs_diff(200) + y.abs_diff(300) < 40 {
            f32::NAN
        } else {
            (x * 3) as f32 - y as f32 * 0.37
        };
    }
    block
}

fn decoder(path: &Path) -> Decoder<BufReader<std::fs::File>> {
    let file = std::fs::File::open(path).expect("written");
    Decoder::new(BufReader::new(file))
        .expect("a TIFF")
        .with_limits(Limits::default())
}

fn image(decoder: &mut Decoder<BufReader<std::fs::File>>) -> DecodingResult {
    decoder.read_image().expect("a readable image")
}

#[test]
fn heights_and_their_overviews_come_back_exactly() {
    let folder = tempfile::tempdir().expect("a folder");
    for (width, height) in [(700, 533), (256, 256), (1, 1), (257, 1100)] {
        let path = folder.path().join("heights.tif");
        let full = heights(width, height);
        write(&path, &full, CogSamples::Height { nodata: -9999.0 }).expect("written");
        let mut decoder = decoder(&path);
        let mut level = full;
        loop {
            assert_eq!(
                decoder.dimensions().expect("sides"),
                (level.width() as u32, level.height() as u32)
            );
            let DecodingResult::F32(samples) = image(&mut decoder) else {
                panic!("f32 expected")
            };
            for (a, b) in samples.iter().zip(level.samples()) {
                assert!(a == b || (*a == -9999.0 && b.is_nan()), "{a} {b}");
            }
            if !decoder.more_images() {
                break;
            }
            decoder.next_image().expect("another image");
            level = reduce::halve(&level);
        }
        assert!(level.width() <= 256 && level.height() <= 256);
    }
}

#[test]
fn colours_come_back_to_the_byte() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut block = Block::new(Bands::Colour, 300, 270);
    for plane in 0..4 {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            *v = colour::from_u8(((i * 7 + plane * 31) % 256) as u8);
        }
    }
    for (samples, channels) in [(CogSamples::Rgba8, 4), (CogSamples::Rgb8, 3)] {
        let path = folder.path().join("colours.tif");
        write(&path, &block, samples).expect("written");
        let DecodingResult::U8(bytes) = image(&mut decoder(&path)) else {
            panic!("u8 expected")
        };
        assert_eq!(bytes, picture::bytes_of(&block, channels));
    }
}

#[test]
fn normals_point_up_where_the_ground_is_level() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("normals.tif");
    let block = Block::filled(Bands::Normal, 20, 20, &[0.0, 0.6]);
    write(&path, &block, CogSamples::NormalF32).expect("written");
    let DecodingResult::F32(samples) = image(&mut decoder(&path)) else {
        panic!("f32 expected")
    };
    assert!((samples[0], samples[1]) == (0.0, 0.6) && (samples[2] - 0.8).abs() < 1e-6);
    write(
        &path,
        &Block::new(Bands::Normal, 20, 20),
        CogSamples::Normal8,
    )
    .expect("written");
    let DecodingResult::U8(samples) = image(&mut decoder(&path)) else {
        panic!("u8 expected")
    };
    assert_eq!(samples[..3], [127, 127, 254]);
}

#[test]
fn a_failed_or_cancelled_write_leaves_what_was_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kept.tif");
    std::fs::write(&path, "old").expect("writable");
    let layout = CogLayout {
        width: 600,
        height: 600,
        samples: CogSamples::Height { nodata: f32::NAN },
        tile: 256,
        georeference: None,
    };
    let mut fails = |rect: PixelRect, out: &mut Block| -> Result<(), Failure> {
        out.reshape(Bands::Height, rect.width as usize, rect.height as usize);
        if rect.y > 0 {
            Err("no more".into())
        } else {
            Ok(())
        }
    };
    let result = write_cog(&path, &layout, &mut fails, &mut |_| (), &Cancel::default());
    assert!(matches!(result, Err(WriteError::Samples(_))));
    let cancel = Cancel::default();
    cancel.cancel();
    let result = write_cog(&path, &layout, &mut fails, &mut |_| (), &cancel);
    assert!(matches!(result, Err(WriteError::Cancelled)));
    assert_eq!(std::fs::read(&path).expect("there"), b"old");
    // Neither a folder that is not there nor a device that takes no neighbour.
    for path in [
        folder.path().join("missing/new.tif"),
        "/dev/null/new.tif".into(),
    ] {
        let mut flat = |rect: PixelRect, out: &mut Block| -> Result<(), Failure> {
            out.reshape(Bands::Height, rect.width as usize, rect.height as usize);
            Ok(())
        };
        let error = write_cog(&path, &layout, &mut flat, &mut |_| (), &Cancel::default())
            .expect_err("no place to write");
        assert!(error.to_string().contains("new.tif"), "{error}");
        assert!(!path.exists());
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("there").count(),
        1,
        "nothing else is left"
    );
}

#[test]
fn what_cannot_be_stored_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let nowhere = folder.path().join("missing/x.tif");
    let error =
        write(&nowhere, &heights(4, 4), CogSamples::Height { nodata: 0.0 }).expect_err("no folder");
    assert!(matches!(error, WriteError::Io { .. }));
    let error =
        write_png(&folder.path().join("x.png"), &heights(4, 4), Png::Rgb8).expect_err("heights");
    assert!(
        error.to_string().contains("expected samples of Colour"),
        "{error}"
    );
}

#[test]
fn pictures_come_back_to_the_byte() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.png");
    let block = Block::filled(Bands::Colour, 3, 2, &[1.0, 0.5, 0.0, 0.25]);
    write_png(&path, &block, Png::Rgba8).expect("written");
    let read = image::open(&path).expect("a PNG").into_rgba8();
    assert_eq!(read.as_raw()[..4], [255, 128, 0, 64]);
    let mut ramp = Block::new(Bands::Height, 3, 1);
    ramp.plane_mut(0).copy_from_slice(&[f32::NAN, -10.0, 90.0]);
    write_png(
        &path,
        &ramp,
        Png::Heights16 {
            low_m: -10.0,
            high_m: 90.0,
        },
    )
    .expect("written");
    assert_eq!(
        image::open(&path).expect("a PNG").into_luma16().as_raw()[..],
        [0, 1, 65535]
    );
}
