//! Files written by GDAL: samples as `gdallocationinfo` finds them, places as `gdaltransform` does.

use std::path::{Path, PathBuf};

use relievo_raster::crs::Crs;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::{Bands, Block, Cancel, PixelRect, RasterFile};

const UTM: &str = "EPSG:32612";
const UTM_PLACE: [f64; 6] = [440_000.0, 30.0, 0.0, 4_485_000.0, 0.0, -30.0];
const NONE: f32 = f32::NAN;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
}

/// A rectangle of a level.
fn read(file: &dyn RasterFile, level: usize, x: u32, y: u32, size: (u32, u32)) -> Block {
    let mut block = Block::new(Bands::Height, 0, 0);
    let (width, height) = size;
    let rect = PixelRect {
        x,
        y,
        width,
        height,
    };
    file.read(level, rect, &mut block, &Cancel::default())
        .expect("a file in order");
    block
}

/// One pixel: a height, or red, green, blue and alpha in 255ths.
fn pixel(file: &dyn RasterFile, level: usize, x: u32, y: u32) -> Vec<f32> {
    let block = read(file, level, x, y, (1, 1));
    let unit = if block.bands() == Bands::Colour {
        255.0
    } else {
        1.0
    };
    block.samples().iter().map(|v| v * unit).collect()
}

fn without_pyramid() -> OpenOptions {
    OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    }
}

/// Asserts what the five pixels at which GDAL was asked hold.
fn assert_pixels(name: &str, expected: [&[f32]; 5], tolerance: f32) {
    let file = open(&fixture(name), &without_pyramid()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let size = file.info().overviews[0];
    assert_eq!((size.width, size.height), (45, 37), "{name}");
    let places = [(0, 0), (44, 0), (21, 17), (3, 30), (44, 36)];
    for ((x, y), expected) in places.into_iter().zip(expected) {
        let found = pixel(&*file, 0, x, y);
        let same = |(f, e): (&f32, &f32)| (f - e).abs() <= tolerance || (f.is_nan() && e.is_nan());
        assert!(
            found.len() == expected.len() && found.iter().zip(expected).all(same),
            "{name} at ({x}, {y}): expected {expected:?}, found {found:?}"
        );
    }
    // A part is the same part of the whole.
    let whole = read(&*file, 0, 0, 0, (45, 37));
    for (x, y) in [(0, 0), (15, 16), (16, 15), (44, 36)] {
        let one = pixel(&*file, 0, x, y);
        for (plane, v) in one.iter().enumerate() {
            let unit = if one.len() == 4 { 255.0 } else { 1.0 };
            let w = whole.plane(plane)[(y * 45 + x) as usize] * unit;
            assert_eq!(v.to_bits(), w.to_bits(), "{name}");
        }
    }
}

#[test]
fn heights_in_every_compression_predictor_and_byte_order() {
    let floats: [&[f32]; 5] = [
        &[1500.0],
        &[NONE],
        &[2_355.741],
        &[1_703.790_3],
        &[1_712.658_7],
    ];
    for name in [
        "zstd-2-float.tif",
        "deflate-3-float.tif",
        "big-endian-float.tif",
        "big-endian-plain.tif",
    ] {
        assert_pixels(name, floats, 1e-3);
    }
    let shorts: [&[f32]; 5] = [&[300.0], &[NONE], &[1153.0], &[503.0], &[507.0]];
    for name in ["lzw-2-short.tif", "big-endian-short.tif"] {
        assert_pixels(name, shorts, 0.0);
    }
    let bytes: [&[f32]; 5] = [&[0.0], &[6.0], &[12.0], &[2.0], &[11.0]];
    assert_pixels("packbits-byte.tif", bytes, 0.0);
    let doubles: [&[f32]; 5] = [
        &[1_500.333_4],
        &[1_709.688_8],
        &[2_353.449_5],
        &[1_703.748_5],
        &[1_707.492],
    ];
    assert_pixels("big-tiff.tif", doubles, 1e-3);
    // Scale 0.1 and offset -500.
    let scaled: [&[f32]; 5] = [&[1000.0], &[1209.3], &[1853.1], &[1203.4], &[1207.1]];
    assert_pixels("scaled.tif", scaled, 1e-3);
}

#[test]
fn masks_alpha_and_tiles_left_out_are_holes() {
    let masked: [&[f32]; 5] = [
        &[1_500.333_4],
        &[1_709.688_8],
        &[NONE],
        &[1_703.748_5],
        &[1_707.492],
    ];
    assert_pixels("masked.tif", masked, 1e-3);
    let alpha: [&[f32]; 5] = [
        &[10.0, 5.0, 0.0, 255.0],
        &[230.0, 5.0, 132.0, 255.0],
        &[0.0; 4],
        &[25.0, 185.0, 99.0, 255.0],
        &[230.0, 221.0, 240.0, 255.0],
    ];
    assert_pixels("alpha.tif", alpha, 1e-3);
    let sparse: [&[f32]; 5] = [&[NONE], &[NONE], &[NONE], &[1_703.415_3], &[NONE]];
    assert_pixels("sparse.tif", sparse, 1e-3);
}

#[test]
fn colours_by_planes_palettes_bits_and_jpeg() {
    let rgb: [&[f32]; 5] = [
        &[10.0, 5.0, 0.0, 255.0],
        &[230.0, 5.0, 132.0, 255.0],
        &[115.0, 107.0, 114.0, 255.0],
        &[25.0, 185.0, 99.0, 255.0],
        &[230.0, 221.0, 240.0, 255.0],
    ];
    assert_pixels("planar.tif", rgb, 1e-3);
    let entry = |i: f32| [i * 17.0, 255.0 - i * 9.0, i * i, 255.0];
    let palette = [0.0, 6.0, 12.0, 2.0, 11.0].map(entry);
    assert_pixels("palette.tif", palette.each_ref().map(|p| &p[..]), 1e-2);
    let (black, white) = ([0.0, 0.0, 0.0, 255.0], [255.0; 4]);
    assert_pixels("one-bit.tif", [&black, &black, &white, &black, &white], 0.0);
    // As libjpeg decodes it; another decoder may round and interpolate chroma otherwise.
    let jpeg: [&[f32]; 5] = [
        &[9.0, 6.0, 1.0, 255.0],
        &[226.0, 8.0, 131.0, 255.0],
        &[114.0, 107.0, 114.0, 255.0],
        &[25.0, 185.0, 99.0, 255.0],
        &[228.0, 221.0, 239.0, 255.0],
    ];
    assert_pixels("jpeg.tif", jpeg, 4.0);
}

#[test]
fn overviews_of_a_file_are_its_own() {
    let file = open(&fixture("jpeg.tif"), &without_pyramid()).unwrap();
    let sizes: Vec<_> = file
        .info()
        .overviews
        .iter()
        .map(|o| (o.width, o.height))
        .collect();
    assert_eq!(sizes, [(45, 37), (23, 19), (12, 10)]);
    let cases = [
        ((0, 0), [11.0, 8.0, 3.0]),
        ((10, 9), [111.0, 112.0, 114.0]),
        ((22, 18), [226.0, 217.0, 238.0]),
    ];
    for ((x, y), expected) in cases {
        let found = pixel(&*file, 1, x, y);
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() <= 4.0, "({x}, {y}): {found:?}");
        }
    }
}

#[test]
fn only_files_that_can_have_holes_say_so() {
    let may = |name: &str, nodata: Option<f64>| {
        let options = OpenOptions {
            nodata,
            ..without_pyramid()
        };
        open(&fixture(name), &options)
            .unwrap()
            .info()
            .may_have_holes
    };
    for name in [
        "jpeg",
        "planar",
        "palette",
        "one-bit",
        "scaled",
        "packbits-byte",
    ] {
        assert!(!may(&format!("{name}.tif"), None), "{name}");
        assert!(may(&format!("{name}.tif"), Some(3.0)), "{name}");
    }
    for name in ["masked", "alpha", "sparse", "lzw-2-short", "big-tiff"] {
        assert!(may(&format!("{name}.tif"), None), "{name}");
    }
}

#[test]
fn the_nodata_value_that_is_asked_for_replaces_the_files_own() {
    let options = OpenOptions {
        nodata: Some(1153.0),
        ..without_pyramid()
    };
    let file = open(&fixture("lzw-2-short.tif"), &options).unwrap();
    assert!(pixel(&*file, 0, 21, 17)[0].is_nan());
    assert_eq!(pixel(&*file, 0, 44, 0), [-9999.0]);
    assert_eq!(file.info().nodata, Some(1153.0));
    let own = open(&fixture("lzw-2-short.tif"), &without_pyramid()).unwrap();
    assert_ne!(own.fingerprint(), file.fingerprint());
    // A colour is nodata where all of its bands have the value, in pictures as in TIFF.
    let folder = tempfile::tempdir().unwrap();
    let picture = image::RgbImage::from_fn(4, 1, |x, _| image::Rgb([7, 7, 6 + (x % 2) as u8]));
    let path = folder.path().join("picture.png");
    picture.save(&path).unwrap();
    let options = OpenOptions {
        nodata: Some(7.0),
        ..without_pyramid()
    };
    let file = open(&path, &options).unwrap();
    assert_eq!(pixel(&*file, 0, 0, 0), [7.0, 7.0, 6.0, 255.0]);
    assert_eq!(pixel(&*file, 0, 1, 0), [0.0; 4]);
    let heights = image::ImageBuffer::from_fn(4, 1, |x, _| image::Luma([1000 + x as u16]));
    let path = folder.path().join("heights.png");
    heights.save(&path).unwrap();
    let options = OpenOptions {
        nodata: Some(1002.0),
        as_bands: Some(Bands::Height),
        ..without_pyramid()
    };
    let file = open(&path, &options).unwrap();
    assert_eq!(pixel(&*file, 0, 1, 0), [1001.0]);
    assert!(pixel(&*file, 0, 2, 0)[0].is_nan());
}

#[test]
fn files_lie_where_gdal_puts_them() {
    // Longitude and latitude of the outer corners of the first and the last pixel.
    let cases: [(&str, &str, [f64; 6], [f64; 4]); 5] = [
        (
            "zstd-2-float.tif",
            UTM,
            UTM_PLACE,
            [
                -111.708_239_177_609,
                40.513_552_778_112_4,
                -111.692_202_093_98,
                40.503_650_072_690_9,
            ],
        ),
        (
            "polar.tif",
            "EPSG:3413",
            [-200_000.0, 10_000.0, 0.0, -300_000.0, 0.0, -10_000.0],
            [
                -78.690_067_525_979_8,
                86.672_511_836_685_7,
                -24.537_728_476_577_8,
                83.405_499_177_181,
            ],
        ),
        (
            "mars.tif",
            "ESRI:104971",
            [130.0, 0.15, 0.0, 20.0, 0.0, -0.15],
            [130.0, 20.0, 136.75, 14.45],
        ),
        (
            "point.tif",
            "EPSG:4326",
            [9.5, 1.0, 0.0, 50.5, 0.0, -1.0],
            [9.5, 50.5, 54.5, 13.5],
        ),
        (
            "south-up.tif",
            "EPSG:4326",
            [10.0, 0.25, 0.0, 40.0, 0.0, 0.25],
            [10.0, 40.0, 21.25, 49.25],
        ),
    ];
    for (name, crs, place, corners) in cases {
        let file = open(&fixture(name), &without_pyramid()).unwrap();
        let found = file.info().georeference.clone().expect("a georeference");
        let expected = Crs::parse(crs).unwrap();
        let system = Crs::parse(&found.crs).unwrap();
        assert!(
            system.same_as(&expected) || system.radii_m() == expected.radii_m(),
            "{name}: {}",
            found.crs
        );
        for (f, e) in found.plane_from_pixel.iter().zip(place) {
            assert!((f - e).abs() < 1e-9 * e.abs().max(1.0), "{name}: {found:?}");
        }
        let [x0, dx, _, y0, _, dy] = found.plane_from_pixel;
        for (i, (column, row)) in [(0.0, 0.0), (45.0, 37.0)].into_iter().enumerate() {
            let (lon, lat) = system
                .to_lonlat(x0 + column * dx, y0 + row * dy)
                .expect("inside");
            let (lon, lat) = (lon.to_degrees(), lat.to_degrees());
            assert!(
                (lon - corners[2 * i]).abs() < 1e-8 && (lat - corners[2 * i + 1]).abs() < 1e-8,
                "{name}: {lon} {lat}"
            );
        }
    }
}
