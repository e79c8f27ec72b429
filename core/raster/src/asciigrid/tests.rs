use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use proptest::prelude::*;

use super::*;
use crate::open::open as open_any;

fn put(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("grid.asc");
    fs::write(&path, text).unwrap();
    path
}

fn plain() -> OpenOptions {
    OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    }
}

fn read(file: &dyn RasterFile, x: u32, y: u32, width: u32, height: u32) -> Vec<f32> {
    let mut block = Block::new(Bands::Height, 0, 0);
    let rect = PixelRect {
        x,
        y,
        width,
        height,
    };
    file.read(0, rect, &mut block, &Cancel::default()).unwrap();
    block.plane(0).to_vec()
}

#[test]
fn the_header_places_corners_and_centres_alike() {
    let folder = tempfile::tempdir().unwrap();
    let rest = "1 2 3\n4 5.5 -9999\n";
    let corner = format!(
        "ncols 3\nnrows 2\nxllcorner 400000\nyllcorner 5000000\ncellsize 10\nNODATA_value -9999\n{rest}"
    );
    let centre = format!(
        "NCOLS 3\r\nNROWS 2\r\nXLLCENTER 400005\r\nYLLCENTER 5000005\r\nDX 10\r\nDY 10\r\nnodata_value -9999\r\n{rest}"
    );
    for text in [corner, centre] {
        let path = put(folder.path(), &text);
        let options = OpenOptions {
            crs: Some("EPSG:32633".into()),
            ..plain()
        };
        let file = open_any(&path, &options).unwrap();
        let place = file.info().georeference.clone().unwrap();
        assert_eq!(
            place.plane_from_pixel,
            [400_000.0, 10.0, 0.0, 5_000_020.0, 0.0, -10.0]
        );
        let values = read(&*file, 0, 0, 3, 2);
        assert_eq!(values[..5], [1.0, 2.0, 3.0, 4.0, 5.5]);
        assert!(values[5].is_nan());
    }
}

#[test]
fn a_prj_file_names_the_system_and_degrees_are_assumed_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let text = "ncols 1\nnrows 1\nxllcorner 12\nyllcorner 40\ncellsize 0.5\n7\n";
    let path = put(folder.path(), text);
    let crs = || {
        let file = open_any(&path, &plain()).unwrap();
        file.info().georeference.clone().map(|g| g.crs.to_string())
    };
    assert_eq!(crs().as_deref(), Some("EPSG:4326"));
    let prj = "Projection UTM\nZone 33\nDatum WGS84\nUnits METERS\n";
    fs::write(folder.path().join("grid.prj"), prj).unwrap();
    assert_eq!(crs().as_deref(), Some("EPSG:32633"));
}

#[test]
fn rows_may_be_broken_anywhere_and_odd_numbers_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let text = "ncols 4\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n\
                1,5 -2e2\n\n+3 *\n nan inf\t.25\n0";
    let file = open_any(&put(folder.path(), text), &plain()).unwrap();
    let values = read(&*file, 0, 0, 4, 2);
    assert_eq!(values[..3], [1.5, -200.0, 3.0]);
    assert!(values[3..6].iter().all(|v| v.is_nan()));
    assert_eq!(values[6..], [0.25, 0.0]);
}

#[test]
fn a_large_grid_is_the_same_by_regions_and_through_its_pyramid() {
    let folder = tempfile::tempdir().unwrap();
    // Rows longer than a run, and enough numbers to be copied.
    let (width, height) = (70_001_u32, 15_u32);
    let value = |x: u32, y: u32| ((x * 7 + y * 13) % 1000) as f32;
    let mut text =
        format!("ncols {width}\nnrows {height}\nxllcorner 0\nyllcorner 0\ncellsize 0.001\n");
    for y in 0..height {
        for x in 0..width {
            write!(text, "{} ", value(x, y)).unwrap();
        }
        text.push('\n');
    }
    let path = put(folder.path(), &text);
    let with_pyramid = OpenOptions {
        cache_dir: Some(folder.path().join("cache")),
        ..OpenOptions::default()
    };
    for options in [plain(), with_pyramid] {
        let file = open_any(&path, &options).unwrap();
        for (x, y, w, h) in [(0, 0, 1, 1), (65_000, 3, 2000, 4), (69_990, 14, 11, 1)] {
            for (i, v) in read(&*file, x, y, w, h).into_iter().enumerate() {
                let i = i as u32;
                assert_eq!(v, value(x + i % w, y + i / w));
            }
        }
    }
}

const SMALL: &str = "ncols 3\nnrows 2\nxllcorner 1\nyllcorner 2\ncellsize 0.5\nnodata_value -1\n\
                     10 20 30\n40 50 60\n";

fn answer(text: &[u8]) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.asc");
    fs::write(&path, text).unwrap();
    let file = open_any(&path, &OpenOptions::default()).map_err(|e| e.to_string())?;
    let size = file.info().overviews[0];
    let mut block = Block::new(Bands::Height, 0, 0);
    let rect = PixelRect {
        x: 0,
        y: 0,
        width: size.width.min(100),
        height: size.height.min(100),
    };
    file.read(0, rect, &mut block, &Cancel::default())
        .map_err(|e| e.to_string())
}

#[test]
fn a_grid_that_ends_anywhere_is_refused_in_one_line() {
    answer(SMALL.as_bytes()).unwrap();
    // The end of the line and the last digit may be missing: the numbers are all there.
    for length in 0..SMALL.len() - 2 {
        let line = answer(&SMALL.as_bytes()[..length]).unwrap_err();
        assert!(!line.contains('\n') && line.contains("odd.asc"), "{line}");
    }
}

#[test]
fn a_header_that_claims_more_than_the_file_holds_is_refused() {
    let text = SMALL.replace("ncols 3", "ncols 2000000000");
    let line = answer(text.as_bytes()).unwrap_err();
    assert!(line.contains("expected 4000000000 numbers"), "{line}");
    for (from, to, part) in [
        ("ncols 3", "ncols 0", "ncols"),
        ("ncols 3", "ncols 2.5", "ncols"),
        ("cellsize 0.5", "cellsize -1", "positive"),
        ("cellsize 0.5", "cellsize x", "cellsize"),
        ("xllcorner 1", "xllcorner nan", "finite"),
        ("30", "thirty", "thirty"),
    ] {
        let line = answer(SMALL.replace(from, to).as_bytes()).unwrap_err();
        assert!(line.contains(part), "{line}");
    }
}

proptest! {
    #[test]
    fn changed_bytes_never_panic(changes in prop::collection::vec((0..SMALL.len(), any::<u8>()), 1..5)) {
        let mut text = SMALL.as_bytes().to_vec();
        for (at, value) in changes {
            text[at] = value;
        }
        answer(&text).ok();
    }
}
