//! Writing rasters where the system refuses after any number of bytes: a file appears whole or not
//! at all, and what was there before stays.
//!
//! The limit on the size of files stands for a full disk: the system lets writes through up to a
//! byte and refuses the rest, at every place where the program writes. It is one for the process, so
//! this file holds a single test.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use relievo_raster::file::Georeference;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::write::{
    CogLayout, CogSamples, CogWork, Png, WriteError, write_cog, write_png,
};
use relievo_raster::{Bands, Block, Cancel, PixelRect};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Limits files to so many bytes; `None` lifts the limit.
fn limit_files(bytes: Option<u64>) {
    let maximum = getrlimit(Resource::Fsize).maximum;
    let current = bytes.or(maximum);
    setrlimit(Resource::Fsize, Rlimit { current, maximum }).unwrap();
}

fn cog_of(path: &Path, resume: Option<[u8; 32]>) -> Result<(), WriteError> {
    let layout = CogLayout {
        width: 20,
        height: 10,
        samples: CogSamples::Height { nodata: -32767.0 },
        tile: 256,
        georeference: Some(Georeference {
            crs: "EPSG:4326".into(),
            plane_from_pixel: [10.0, 0.5, 0.0, 50.0, 0.0, -0.5],
        }),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: PixelRect| {
        let mut out = Block::new(Bands::Height, rect.width as usize, rect.height as usize);
        for (i, h) in out.plane_mut(0).iter_mut().enumerate() {
            *h = (i * i) as f32 * 0.37;
        }
        Ok(out)
    };
    let work = CogWork {
        threads: 1,
        resume,
        cancel: &Cancel::default(),
    };
    write_cog(path, &layout, &source, &work, &mut |_| {})
}

fn cog(path: &Path) -> Result<(), WriteError> {
    cog_of(path, None)
}

/// One whose finished tiles are kept beside it when it is stopped.
fn resumed_cog(path: &Path) -> Result<(), WriteError> {
    cog_of(path, Some([7; 32]))
}

fn png(path: &Path) -> Result<(), WriteError> {
    let mut block = Block::new(Bands::Colour, 12, 9);
    for plane in 0..4 {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            *v = (i * (plane + 3) % 17) as f32 / 17.0;
        }
    }
    write_png(path, &block, Png::Rgba8)
}

/// Writes under every limit from 0 bytes on until it succeeds; returns the file's length.
fn under_every_limit(
    path: &Path,
    write: fn(&Path) -> Result<(), WriteError>,
    most_left: usize,
) -> u64 {
    let folder = path.parent().unwrap();
    fs::write(path, "old").unwrap();
    for space in 0.. {
        limit_files(Some(space));
        let result = write(path);
        limit_files(None);
        let left = fs::read_dir(folder).unwrap().count();
        assert!(
            left <= most_left,
            "after {space} bytes {left} files are left"
        );
        match result {
            Ok(()) => {
                assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
                return space;
            }
            Err(error) => {
                assert!(matches!(error, WriteError::Io { .. }), "{error}");
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
                assert_eq!(fs::read(path).unwrap(), b"old", "after {space} bytes");
            }
        }
        assert!(space < 1 << 16, "a small file");
    }
    unreachable!("the loop ends by its assertion")
}

#[test]
fn a_disk_that_is_full_after_any_byte_leaves_the_old_file() {
    // Without a handler the signal that tells of the limit ends the process.
    let told = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, told).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.tif");
    under_every_limit(&path, cog, 1);
    let whole = fs::read(&path).unwrap();
    common::open_and_read(&path, &OpenOptions::default()).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.tif");
    under_every_limit(&path, resumed_cog, 2);
    assert_eq!(fs::read(&path).unwrap(), whole, "stops leave no trace");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.png");
    let needed = under_every_limit(&path, png, 1);
    assert_eq!(fs::metadata(&path).unwrap().len(), needed);

    // A pyramid that the cache folder cannot take is kept in memory.
    let folder = tempfile::tempdir().unwrap();
    let source = common::put(
        folder.path(),
        "picture.png",
        &common::picture(300, 200, image::ImageFormat::Png),
    );
    let options = OpenOptions {
        cache_dir: Some(folder.path().join("cache")),
        ..OpenOptions::default()
    };
    let whole = common::open_and_read(&source, &OpenOptions::default()).unwrap();
    for space in (0..4096).step_by(256) {
        limit_files(Some(space));
        let file = open(&source, &options);
        limit_files(None);
        let file = file.unwrap();
        let level = file.info().overviews.len() - 1;
        let block = common::read_level(&*file, level).unwrap();
        assert_eq!(block.samples(), whole[level].samples(), "{space}");
        let kept = fs::read_dir(folder.path().join("cache")).unwrap().count();
        assert_eq!(kept, 0, "no half pyramid is left behind");
    }
}
