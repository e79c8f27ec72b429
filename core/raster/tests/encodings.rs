//! Encodings that few files have, and files beside files: all samples as they were before GDAL wrote
//! them (`fixtures/make.sh`).

#![expect(
    clippy::unwrap_used,
    reason = "a fixture that does not open fails the test"
)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_raster::open::{OpenError, OpenOptions, Stretch, open};
use relievo_raster::{Bands, Block, Cancel, PixelRect, RasterFile};

const WIDTH: u32 = 16;
const HEIGHT: u32 = 12;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
}

fn options(bands: Bands) -> OpenOptions {
    OpenOptions {
        make_pyramid: false,
        as_bands: Some(bands),
        stretch: Stretch::Full,
        ..OpenOptions::default()
    }
}

fn opened(name: &str, bands: Bands) -> Arc<dyn RasterFile> {
    open(&fixture(name), &options(bands)).unwrap()
}

fn level(file: &dyn RasterFile, level: usize) -> Block {
    let size = file.info().overviews[level];
    let (width, height) = (size.width, size.height);
    let whole = PixelRect {
        x: 0,
        y: 0,
        width,
        height,
    };
    let mut block = Block::new(Bands::Height, 0, 0);
    file.read(level, whole, &mut block, &Cancel::default())
        .unwrap();
    block
}

/// Asserts every sample of the first plane, and of a part of it.
fn assert_samples(file: &dyn RasterFile, expected: impl Fn(u32, u32) -> f32) {
    let name = file.path().display();
    let whole = level(file, 0);
    assert_eq!(
        (whole.width() as u32, whole.height() as u32),
        (WIDTH, HEIGHT),
        "{name}"
    );
    for (i, found) in whole.plane(0).iter().enumerate() {
        let (x, y) = (i as u32 % WIDTH, i as u32 / WIDTH);
        let e = expected(x, y);
        assert!(
            *found == e || (found.is_nan() && e.is_nan()),
            "{name} at ({x}, {y}): expected {e}, found {found}"
        );
    }
    let mut part = Block::new(Bands::Height, 0, 0);
    let rect = PixelRect {
        x: 5,
        y: 3,
        width: 7,
        height: 4,
    };
    file.read(0, rect, &mut part, &Cancel::default()).unwrap();
    for (i, found) in part.plane(0).iter().enumerate() {
        assert_eq!(
            *found,
            whole.plane(0)[(3 + i / 7) * WIDTH as usize + 5 + i % 7],
            "{name}"
        );
    }
}

fn ramp_with_a_hole(x: u32, y: u32) -> f32 {
    if (x, y) == (3, 4) {
        f32::NAN
    } else {
        100.0 + x as f32 + 0.5 * y as f32
    }
}

#[test]
fn lerc_gives_back_every_sample_whatever_it_is_wrapped_in() {
    for (name, compression) in [("lerc", "LERC"), ("lerc-zstd-big-endian", "LERC and ZSTD")] {
        let file = opened(&format!("{name}.tif"), Bands::Height);
        assert_eq!(file.info().compression, compression);
        assert_samples(&*file, ramp_with_a_hole);
    }
    let file = opened("lerc-deflate.tif", Bands::Height);
    assert_eq!(file.info().compression, "LERC and Deflate");
    assert_samples(&*file, |x, y| {
        (100 * i64::from(x) - 37 * i64::from(y)) as f32
    });
}

#[test]
fn colours_in_lerc_and_webp_are_those_that_went_in() {
    for name in ["lerc-rgb.tif", "webp.tif"] {
        let file = opened(name, Bands::Colour);
        let whole = level(&*file, 0);
        for i in 0..(WIDTH * HEIGHT) as usize {
            let (x, y) = (i % WIDTH as usize, i / WIDTH as usize);
            let found: Vec<usize> = (0..4)
                .map(|p| (whole.plane(p)[i] * 255.0).round() as usize)
                .collect();
            assert_eq!(
                found,
                [10 * x, 20 * y, 5 * x + 5 * y, 255],
                "{name} at ({x}, {y})"
            );
        }
    }
}

#[test]
fn bits_that_fill_no_bytes_are_unpacked() {
    let ten = |x: u32, y: u32| (60 * x + 9 * y) as f32;
    for (name, sample_type) in [
        ("ten-bits.tif", "uint10"),
        ("twelve-bits-planar.tif", "uint12"),
        ("fourteen-bits-big-endian.tif", "uint14"),
    ] {
        let file = opened(name, Bands::Height);
        assert_eq!(file.info().sample_type, sample_type);
        assert_samples(&*file, ten);
    }
    assert_samples(&*opened("twenty-bits.tif", Bands::Height), |x, y| {
        (60_000 * x + 9999 * y) as f32
    });
    assert_samples(&*opened("half.tif", Bands::Height), ramp_with_a_hole);
    // As colours they fill their own range.
    let shown = level(&*opened("ten-bits.tif", Bands::Colour), 0);
    assert_eq!(shown.plane(0)[15], 900.0 / 1023.0);
}

#[test]
fn jpeg_strips_with_coarse_chroma_are_rgb() {
    let file = opened("jpeg-strips.tif", Bands::Colour);
    let whole = level(&*file, 0);
    for (x, y) in [(5, 5), (20, 15), (21, 17), (40, 33), (30, 36)] {
        let found = [0, 1, 2].map(|p| whole.plane(p)[y * 45 + x] * 255.0);
        let stored = [5 * x + 10, 6 * y + 5, 3 * (x + y)];
        for (f, s) in found.iter().zip(stored) {
            assert!(
                (f - s as f32).abs() < 12.0,
                "({x}, {y}): {found:?}, not {stored:?}"
            );
        }
    }
}

#[test]
fn overviews_beside_a_file_are_levels_of_it() {
    let file = opened("beside.tif", Bands::Height);
    let sizes: Vec<_> = file
        .info()
        .overviews
        .iter()
        .map(|o| (o.width, o.height))
        .collect();
    assert_eq!(sizes, [(45, 37), (23, 19), (12, 10)]);
    // As `gdallocationinfo -overview` finds them at column 5, row 5 of the full image, the nearest.
    assert_eq!(level(&*file, 1).plane(0)[3 * 23 + 3], 1_917.699_3);
    assert_eq!(level(&*file, 2).plane(0)[12 + 1], 1_991.779_4);
}

#[test]
fn overviews_beside_a_file_that_make_no_sense_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::copy(fixture("beside.tif"), &path).unwrap();
    let alone = open(&path, &options(Bands::Height)).unwrap();
    assert_eq!(alone.info().overviews.len(), 1);
    for bytes in [&b"nonsense"[..], b"II*\0\x08\0\0\0\xff\xff", b""] {
        std::fs::write(folder.path().join("a.tif.ovr"), bytes).unwrap();
        let file = open(&path, &options(Bands::Height)).unwrap();
        assert_eq!(file.info().overviews.len(), 1);
        assert_ne!(
            file.fingerprint(),
            alone.fingerprint(),
            "tiles made without it are not those with it"
        );
    }
}

#[test]
fn a_mask_beside_a_file_hides_what_it_hides_inside_one() {
    let beside = level(&*opened("masked-beside.tif", Bands::Height), 0);
    let inside = level(&*opened("masked.tif", Bands::Height), 0);
    let bits = |block: &Block| {
        block
            .samples()
            .iter()
            .map(|v| v.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&beside), bits(&inside));
    assert!(beside.plane(0)[18 * 45 + 20].is_nan());
    // A damaged mask must not show what it hides.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::copy(fixture("masked-beside.tif"), &path).unwrap();
    std::fs::write(folder.path().join("a.tif.msk"), "nonsense").unwrap();
    let error = open(&path, &options(Bands::Height))
        .err()
        .expect("a damaged mask")
        .to_string();
    assert!(
        error.contains("a.tif.msk") && !error.contains('\n'),
        "{error}"
    );
}

#[test]
fn notes_beside_a_file_count_where_it_says_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let value = |path: &Path| level(&*open(path, &options(Bands::Height)).unwrap(), 0).plane(0)[1];
    let notes = "<PAMDataset><PAMRasterBand band=\"1\"><NoDataValue>100</NoDataValue><Scale>2</Scale>\
                 </PAMRasterBand></PAMDataset>";
    std::fs::copy(fixture("lerc-deflate.tif"), &path).unwrap();
    std::fs::write(folder.path().join("a.tif.aux.xml"), notes).unwrap();
    assert!(value(&path).is_nan(), "100 is nodata");
    std::fs::write(
        folder.path().join("a.tif.aux.xml"),
        notes.replace("100", "7"),
    )
    .unwrap();
    assert_eq!(value(&path), 200.0);
    std::fs::write(
        folder.path().join("a.tif.aux.xml"),
        "<PAMDataset><PAMRasterBand band=\"1\"",
    )
    .unwrap();
    assert_eq!(value(&path), 100.0);
}

#[test]
fn control_points_place_an_image_that_they_fit_and_refuse_a_bent_one() {
    let file = opened("control-points.tif", Bands::Height);
    let place = file.info().georeference.clone().unwrap();
    assert_eq!(&*place.crs, "EPSG:32612");
    let exact = [440_000.0, 26.0, 15.0, 4_485_000.0, 15.0, -26.0];
    for (found, expected) in place.plane_from_pixel.iter().zip(exact) {
        assert!((found - expected).abs() < 4.0, "{place:?}");
    }
    let [remark] = file.remarks() else {
        panic!("{:?}", file.remarks())
    };
    assert!(
        remark.contains("5 ground control points") && remark.contains("pixels off"),
        "{remark}"
    );
    let refused = open(&fixture("bent.tif"), &options(Bands::Height))
        .err()
        .expect("no affine map");
    let OpenError::Unsupported { reason, .. } = &refused else {
        panic!("{refused}")
    };
    assert!(reason.contains("4 up to 2.7 pixels off"), "{reason}");
    // A place that is given makes them meaningless.
    let given = OpenOptions {
        georeference: Some(place),
        ..options(Bands::Height)
    };
    assert!(
        open(&fixture("bent.tif"), &given)
            .unwrap()
            .remarks()
            .is_empty()
    );
}

#[test]
fn a_rotated_matrix_is_taken_as_it_stands() {
    let place = opened("rotated.tif", Bands::Height)
        .info()
        .georeference
        .clone()
        .unwrap();
    assert_eq!(
        place.plane_from_pixel,
        [440_000.0, 26.0, 15.0, 4_485_000.0, 15.0, -26.0]
    );
}

#[test]
fn three_chosen_bands_are_colours_and_what_the_file_calls_alpha_is_not_theirs() {
    let opened = |select: Option<Vec<u16>>| {
        let chosen = OpenOptions {
            select,
            ..options(Bands::Colour)
        };
        level(&*open(&fixture("alpha.tif"), &chosen).unwrap(), 0)
    };
    let of_file = opened(None);
    assert!(of_file.plane(3).contains(&0.0), "a file with holes");
    let chosen = opened(Some(vec![0, 1, 2]));
    assert!(chosen.plane(3).iter().all(|alpha| *alpha == 1.0));
    // The fourth that is asked for is alpha, as the file says it, too.
    assert_eq!(opened(Some(vec![0, 1, 2, 3])), of_file);
}
