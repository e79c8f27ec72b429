use std::io::BufReader;

use glam::DVec3;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::*;
use crate::file::OverviewInfo;
use crate::file::{Cancel, Georeference, PixelRect};
use crate::reduce::ratio::Reduction;
use crate::{Bands, Block, colour, normal};

type Failure = Box<dyn core::error::Error + Send + Sync>;

fn part(of: &Block, rect: PixelRect) -> Block {
    let (width, height) = (rect.width as usize, rect.height as usize);
    let mut out = Block::new(of.bands(), width, height);
    out.copy_from(
        of,
        (rect.x as usize, rect.y as usize),
        (0, 0),
        (width, height),
    );
    out
}

fn layout_of(of: &Block, samples: CogSamples) -> CogLayout {
    CogLayout {
        width: of.width() as u32,
        height: of.height() as u32,
        samples,
        tile: 256,
        georeference: Some(Georeference {
            crs: "EPSG:32612".into(),
            plane_from_pixel: [400_000.0, 30.0, 0.0, 4_500_000.0, 0.0, -30.0],
        }),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    }
}

fn write(path: &Path, of: &Block, samples: CogSamples) -> Result<(), WriteError> {
    write_on(path, of, &layout_of(of, samples), 2, None)
}

fn write_on(
    path: &Path,
    of: &Block,
    layout: &CogLayout,
    threads: usize,
    resume: Option<[u8; 32]>,
) -> Result<(), WriteError> {
    let mut last = 0.0;
    let mut progress = |p: f64| {
        assert!(p >= last && p <= 1.0);
        last = p;
    };
    let source = |rect| -> Result<Block, Failure> { Ok(part(of, rect)) };
    let cancel = Cancel::default();
    let work = CogWork {
        threads,
        resume,
        cancel: &cancel,
    };
    write_cog(path, layout, &source, &work, &mut progress)
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
            let size = |b: &Block| OverviewInfo {
                width: b.width() as u32,
                height: b.height() as u32,
            };
            let fine = size(&level);
            let coarse = OverviewInfo {
                width: fine.width.div_ceil(2),
                height: fine.height.div_ceil(2),
            };
            let whole = PixelRect {
                x: 0,
                y: 0,
                width: coarse.width,
                height: coarse.height,
            };
            level = Reduction::new(fine, coarse, whole).apply(&level);
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
    let leaning = normal::coordinates(DVec3::new(0.0, 0.6, 0.8));
    let block = Block::filled(Bands::Normal, 20, 20, &leaning);
    write(&path, &block, CogSamples::NormalF32).expect("written");
    let DecodingResult::F32(samples) = image(&mut decoder(&path)) else {
        panic!("f32 expected")
    };
    assert!(
        samples[0] == 0.0 && (samples[1] - 0.6).abs() < 1e-6 && (samples[2] - 0.8).abs() < 1e-6
    );
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
        georeference: None,
        ..layout_of(&heights(600, 600), CogSamples::Height { nodata: f32::NAN })
    };
    let flat = |rect: PixelRect| -> Result<Block, Failure> {
        Ok(Block::new(
            Bands::Height,
            rect.width as usize,
            rect.height as usize,
        ))
    };
    let fails = |rect: PixelRect| {
        if rect.y > 0 {
            Err("no more".into())
        } else {
            flat(rect)
        }
    };
    let on_two = |cancel| CogWork {
        threads: 2,
        resume: None,
        cancel,
    };
    let going = Cancel::default();
    let result = write_cog(&path, &layout, &fails, &on_two(&going), &mut |_| ());
    assert!(matches!(result, Err(WriteError::Samples(_))));
    let cancel = Cancel::default();
    cancel.cancel();
    let result = write_cog(&path, &layout, &flat, &on_two(&cancel), &mut |_| ());
    assert!(matches!(result, Err(WriteError::Cancelled)));
    assert_eq!(std::fs::read(&path).expect("there"), b"old");
    // Neither a folder that is not there nor a device that takes no neighbour.
    for path in [
        folder.path().join("missing/new.tif"),
        "/dev/null/new.tif".into(),
    ] {
        let error = write_cog(&path, &layout, &flat, &on_two(&going), &mut |_| ())
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

#[test]
fn threads_do_not_show_in_the_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let full = heights(1100, 700);
    let layout = layout_of(&full, CogSamples::Height { nodata: -9999.0 });
    let files = [1, 2, 7].map(|threads| {
        let path = folder.path().join(format!("{threads}.tif"));
        write_on(&path, &full, &layout, threads, None).expect("written");
        std::fs::read(&path).expect("there")
    });
    assert!(files[0] == files[1] && files[1] == files[2]);
}

#[test]
fn work_that_was_stopped_goes_on_and_ends_in_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let full = heights(1100, 700);
    let layout = layout_of(&full, CogSamples::Height { nodata: -9999.0 });
    let whole = folder.path().join("whole.tif");
    write_on(&whole, &full, &layout, 1, None).expect("written");
    let path = folder.path().join("stopped.tif");
    let kept = folder.path().join("stopped.tif.part");
    let made = std::sync::atomic::AtomicUsize::new(0);
    let run = |most: usize, request: u8| {
        made.store(0, std::sync::atomic::Ordering::Relaxed);
        let source = |rect| -> Result<Block, Failure> {
            if made.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= most {
                return Err("stopped".into());
            }
            Ok(part(&full, rect))
        };
        let cancel = Cancel::default();
        let work = CogWork {
            threads: 1,
            resume: Some([request; 32]),
            cancel: &cancel,
        };
        write_cog(&path, &layout, &source, &work, &mut |_| ())
    };
    // 5 × 3 tiles, four at a time.
    assert!(run(9, 1).is_err() && kept.exists() && !path.exists());
    let partial = std::fs::read(&kept).expect("kept");
    run(usize::MAX, 1).expect("goes on");
    assert_eq!(
        made.load(std::sync::atomic::Ordering::Relaxed),
        7,
        "eight were there"
    );
    let expected = std::fs::read(&whole).expect("there");
    let same = || std::fs::read(&path).expect("there") == expected && !kept.exists();
    assert!(same());
    // Whatever a crash left: cut anywhere, damaged anywhere, of another request.
    for cut in (0..partial.len()).step_by(partial.len() / 7) {
        std::fs::write(&kept, &partial[..cut]).expect("writable");
        run(usize::MAX, 1).expect("goes on");
        assert!(same(), "cut at {cut}");
        let mut damaged = partial.clone();
        damaged[cut] ^= 0x40;
        std::fs::write(&kept, &damaged).expect("writable");
        run(usize::MAX, 1).expect("goes on");
        if cut < 20 {
            // No longer ours: left alone.
            assert_eq!(std::fs::read(&kept).expect("there"), damaged);
            std::fs::remove_file(&kept).expect("removable");
        }
        assert!(same(), "damaged at {cut}");
    }
    std::fs::write(&kept, &partial).expect("writable");
    run(usize::MAX, 2).expect("begins anew");
    assert_eq!(made.load(std::sync::atomic::Ordering::Relaxed), 15);
    assert!(same());
}

#[test]
fn a_file_that_is_not_a_partial_one_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let full = heights(300, 20);
    let layout = layout_of(&full, CogSamples::Height { nodata: -9999.0 });
    let path = folder.path().join("a.tif");
    let other = folder.path().join("a.tif.part");
    std::fs::write(&other, "somebody's notes").expect("writable");
    write_on(&path, &full, &layout, 1, Some([0; 32])).expect("written");
    assert_eq!(std::fs::read(&other).expect("there"), b"somebody's notes");
    assert!(path.exists());
}

#[test]
fn large_files_are_big_and_hold_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let full = heights(300, 270);
    let classic = layout_of(&full, CogSamples::Height { nodata: -9999.0 });
    let path = folder.path().join("a.tif");
    let mut versions = Vec::new();
    for limit in [CogLayout::LARGEST_CLASSIC_BYTES, 1000] {
        let layout = CogLayout {
            largest_classic_bytes: limit,
            ..classic.clone()
        };
        write_on(&path, &full, &layout, 1, None).expect("written");
        versions.push(std::fs::read(&path).expect("there")[2]);
        let DecodingResult::F32(samples) = image(&mut decoder(&path)) else {
            panic!("f32 expected")
        };
        assert_eq!(samples[301], full.samples()[301]);
    }
    assert_eq!(versions, [42, 43]);
}
