//! Files that another program changes while they are open: no sample of two contents is ever given.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use relievo_raster::file::{Georeference, ReadError};
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::write::{CogLayout, CogSamples, CogWork, Png, write_cog, write_png};
use relievo_raster::{Bands, Block, Cancel, PixelRect, RasterFile};

const SIDE: u32 = 300;

fn block(value: f32) -> Block {
    let mut block = Block::new(Bands::Colour, SIDE as usize, SIDE as usize);
    block.samples_mut().fill(value);
    let [.., alpha] = block.planes_mut::<4>();
    alpha.fill(1.0);
    block
}

fn write(path: &Path, value: f32, seconds: u64) {
    if path.extension().is_some_and(|e| e == "png") {
        write_png(path, &block(value), Png::Rgb8).unwrap();
    } else {
        let layout = CogLayout {
            width: SIDE,
            height: SIDE,
            samples: CogSamples::Rgb8,
            tile: 256,
            georeference: Some(Georeference {
                crs: Arc::from("EPSG:4326"),
                plane_from_pixel: [0.0, 0.01, 0.0, 0.0, 0.0, -0.01],
            }),
            largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
        };
        let source = |rect: PixelRect| {
            let mut out = Block::new(Bands::Colour, rect.width as usize, rect.height as usize);
            out.samples_mut().fill(value);
            Ok(out)
        };
        let work = CogWork {
            threads: 1,
            resume: None,
            cancel: &Cancel::default(),
        };
        write_cog(path, &layout, &source, &work, &mut |_| {}).unwrap();
    }
    date(path, seconds);
}

/// Gives a file a time of change that no other content has.
fn date(path: &Path, seconds: u64) {
    let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
    let file = File::options().write(true).open(path).unwrap();
    file.set_modified(time).unwrap();
}

fn read(file: &Arc<dyn RasterFile>) -> Result<f32, ReadError> {
    let whole = PixelRect {
        x: 0,
        y: 0,
        width: SIDE,
        height: SIDE,
    };
    let mut out = Block::new(Bands::Colour, 1, 1);
    file.read(0, whole, &mut out, &Cancel::default())?;
    Ok(out.samples()[0])
}

fn opened(path: &Path) -> Arc<dyn RasterFile> {
    let options = OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    };
    open(path, &options).unwrap()
}

#[test]
fn samples_that_were_written_since_the_file_was_opened_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.tif", "a.png"] {
        let path = folder.path().join(name);
        let other = folder
            .path()
            .join("other")
            .with_extension(path.extension().unwrap());
        write(&path, 0.2, 1_000_000);
        write(&other, 0.8, 1_000_000);
        let file = opened(&path);
        // In place: the file is the same, its bytes are not.
        fs::write(&path, fs::read(&other).unwrap()).unwrap();
        date(&path, 1_000_001);
        let error = read(&file).unwrap_err();
        assert!(error.is_change(), "{name}: {error}");
        assert!(error.to_string().contains("changed on disk"), "{error}");
        assert_eq!(error.path(), Some(path.as_path()));
        let again = opened(&path);
        assert_ne!(again.fingerprint(), file.fingerprint());
        assert!((read(&again).unwrap() - 0.8).abs() < 0.01);
        // Cut short.
        let file = opened(&path);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 4]).unwrap();
        assert!(read(&file).unwrap_err().is_change(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_tiff_that_is_replaced_or_removed_by_name_is_read_as_it_was_opened() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    write(&path, 0.2, 1_000_000);
    write(&other, 0.8, 1_000_001);
    let file = opened(&path);
    fs::rename(&other, &path).unwrap();
    assert!((read(&file).unwrap() - 0.2).abs() < 0.01);
    fs::remove_file(&path).unwrap();
    assert!((read(&file).unwrap() - 0.2).abs() < 0.01);
}
