//! What readers give: samples, places, overviews.

mod common;

use std::sync::Arc;

use relievo_raster::chunk_cache::ChunkCache;
use relievo_raster::crs::Crs;
use relievo_raster::file::Georeference;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::{Bands, Block, Cancel, PixelRect};

#[test]
fn heights_come_in_metres_with_nan_for_nodata_and_points_are_centres() {
    let folder = tempfile::tempdir().unwrap();
    let area = common::put(folder.path(), "area.tif", &common::heights(9, 7, false));
    let file = open(&area, &OpenOptions::default()).unwrap();
    assert_eq!(file.info().bands, Bands::Height);
    let mut block = Block::new(Bands::Height, 0, 0);
    file.read(
        0,
        PixelRect {
            x: 0,
            y: 1,
            width: 3,
            height: 2,
        },
        &mut block,
        &Cancel::default(),
    )
    .unwrap();
    assert_eq!(block.samples()[0], 100.0);
    assert!(block.samples()[1].is_nan(), "101 is nodata");
    assert_eq!(&block.samples()[2..], [102.0, 200.0, 201.0, 202.0]);
    let place = file.info().georeference.clone().unwrap();
    assert_eq!(
        (&*place.crs, place.plane_from_pixel),
        ("EPSG:4326", [10.0, 1.0, 0.0, 50.0, 0.0, -1.0])
    );
    let point = common::put(folder.path(), "point.tif", &common::heights(9, 7, true));
    let file = open(&point, &OpenOptions::default()).unwrap();
    assert_eq!(
        file.info().georeference.clone().unwrap().plane_from_pixel,
        [9.5, 1.0, 0.0, 50.5, 0.0, -1.0]
    );
}

#[test]
fn a_pyramid_is_made_once_and_made_again_when_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let path = common::put(
        folder.path(),
        "big.png",
        &common::picture(700, 300, image::ImageFormat::Png),
    );
    let options = OpenOptions {
        cache_dir: Some(cache.clone()),
        ..OpenOptions::default()
    };
    let first = common::open_and_read(&path, &options).unwrap();
    assert_eq!(
        first
            .iter()
            .map(|b| (b.width(), b.height()))
            .collect::<Vec<_>>(),
        [(700, 300), (350, 150), (175, 75)]
    );
    let made = std::fs::read_dir(&cache)
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let written = std::fs::metadata(&made).unwrap().modified().unwrap();
    assert_eq!(common::open_and_read(&path, &options).unwrap(), first);
    assert_eq!(
        std::fs::metadata(&made).unwrap().modified().unwrap(),
        written,
        "not made again"
    );
    std::fs::write(&made, b"II damaged").unwrap();
    assert_eq!(common::open_and_read(&path, &options).unwrap(), first);
    // A folder that cannot be: the pyramid stays in memory.
    let options = OpenOptions {
        cache_dir: Some(path.join("no folder")),
        ..OpenOptions::default()
    };
    assert_eq!(common::open_and_read(&path, &options).unwrap(), first);
}

#[test]
fn a_cancelled_pyramid_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = common::put(
        folder.path(),
        "big.png",
        &common::picture(700, 300, image::ImageFormat::Png),
    );
    let options = OpenOptions::default();
    options.cancel.cancel();
    assert!(
        common::open_and_read(&path, &options)
            .unwrap_err()
            .contains("cancelled")
    );
}

#[test]
fn pictures_lie_where_a_world_file_or_the_options_say_and_else_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = common::put(
        folder.path(),
        "world.jpg",
        &common::picture(40, 20, image::ImageFormat::Jpeg),
    );
    assert!(
        open(&path, &OpenOptions::default())
            .unwrap()
            .info()
            .georeference
            .is_none()
    );
    common::put(folder.path(), "world.jgw", b"9\n0\n0\n-9\n-175.5\n85.5\n");
    let place = open(&path, &OpenOptions::default())
        .unwrap()
        .info()
        .georeference
        .clone()
        .unwrap();
    assert_eq!(place.plane_from_pixel, [-180.0, 9.0, 0.0, 90.0, 0.0, -9.0]);
    let given = Georeference {
        crs: Arc::from("ESRI:104971"),
        plane_from_pixel: [0.0, 1.0, 0.0, 9.0, 0.0, -1.0],
    };
    let options = OpenOptions {
        georeference: Some(given.clone()),
        ..OpenOptions::default()
    };
    assert_eq!(
        open(&path, &options).unwrap().info().georeference,
        Some(given)
    );
}

#[test]
fn many_threads_decode_a_chunk_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = common::put(folder.path(), "shared.tif", &common::heights(9, 7, false));
    let cache = Arc::new(ChunkCache::new(1 << 20));
    let options = OpenOptions {
        chunk_cache: Arc::clone(&cache),
        make_pyramid: false,
        ..OpenOptions::default()
    };
    let file = open(&path, &options).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| common::read_level(&*file, 0).unwrap());
        }
    });
    assert_eq!(cache.decoded(), 1);
    drop(file);
    assert_eq!(cache.bytes(), 0, "a closed file leaves nothing");
}

#[test]
fn coordinate_systems_go_there_and_back_and_refuse_what_lies_outside() {
    // Expected values: gdaltransform (GDAL with PROJ 9).
    let utm = Crs::parse("EPSG:32632").unwrap();
    let (x, y) = utm
        .from_lonlat(9f64.to_radians(), 48f64.to_radians())
        .unwrap();
    assert!(
        (x - 500_000.0).abs() < 1e-4 && (y - 5_316_300.224_451_5).abs() < 1e-4,
        "{x} {y}"
    );
    let (lon, lat) = utm.to_lonlat(x, y).unwrap();
    assert!((lon.to_degrees() - 9.0).abs() < 1e-9 && (lat.to_degrees() - 48.0).abs() < 1e-9);
    assert!(utm.to_lonlat(f64::NAN, 0.0).is_err() && utm.from_lonlat(0.0, 1.6).is_err());
    let web = Crs::parse("EPSG:3857").unwrap();
    let (lon, lat) = web
        .to_lonlat(-8_843_764.172_594_871, 4_848_553.578_185_286)
        .unwrap();
    assert!(
        (lon.to_degrees() + 79.444_885_3).abs() < 1e-6
            && (lat.to_degrees() - 39.880_234_9).abs() < 1e-6
    );
    let mars = Crs::parse("ESRI:104971").unwrap();
    assert!(mars.is_geographic() && mars.radii_m() == (3_396_190.0, 3_396_190.0));
    assert_eq!(
        mars.to_lonlat(180.0, -90.0).unwrap(),
        (core::f64::consts::PI, -core::f64::consts::FRAC_PI_2)
    );
    assert!(
        Crs::parse("EPSG:4326")
            .unwrap()
            .same_as(&Crs::parse("+proj=latlong +datum=WGS84").unwrap())
    );
    for text in [
        "EPSG:1",
        "ESRI:9",
        "IAU:49900",
        "+proj=nothing",
        "somewhere",
        "EPSG:x",
    ] {
        assert!(Crs::parse(text).is_err(), "{text}");
    }
}
