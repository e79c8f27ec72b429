use std::fs;
use std::io::{Cursor, Write};
use std::path::PathBuf;

use image::{ImageFormat, Rgba, RgbaImage};
use proptest::prelude::*;
use rusqlite::Connection;

use super::frame::HALF_MAP_M;
use super::*;
use crate::open::{TileRows, open as open_any};

/// A tile of a set: zoom, column, row from north, content.
type Made = (u8, u32, u32, Vec<u8>);

fn picture(side: u32, colour: impl Fn(u32, u32) -> [u8; 4], format: ImageFormat) -> Vec<u8> {
    let image = RgbaImage::from_fn(side, side, |x, y| Rgba(colour(x, y)));
    let mut bytes = Cursor::new(Vec::new());
    let image = image::DynamicImage::ImageRgba8(image);
    if format == ImageFormat::Jpeg {
        image.to_rgb8().write_to(&mut bytes, format).unwrap();
    } else {
        image.write_to(&mut bytes, format).unwrap();
    }
    bytes.into_inner()
}

/// A tile of one colour.
fn flat(colour: [u8; 4]) -> Vec<u8> {
    picture(64, |_, _| colour, ImageFormat::Png)
}

/// Red is the zoom times 10, green the column, blue the row.
fn coded(zoom: u8, column: u32, row: u32) -> Made {
    let colour = [zoom * 10, column as u8, row as u8, 255];
    (zoom, column, row, flat(colour))
}

/// All tiles of zooms 0 to 2.
fn world() -> Vec<Made> {
    (0..3)
        .flat_map(|zoom| {
            let side = 1_u32 << zoom;
            (0..side * side).map(move |i| coded(zoom, i % side, i / side))
        })
        .collect()
}

fn folder(at: &Path, tiles: &[Made], ending: &str) -> PathBuf {
    for (zoom, column, row, bytes) in tiles {
        let folder = at.join(format!("{zoom}/{column}"));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(format!("{row}{ending}")), bytes).unwrap();
    }
    at.to_owned()
}

fn mbtiles(at: &Path, tiles: &[Made], metadata: &[(&str, &str)]) -> PathBuf {
    let path = at.join("set.mbtiles");
    let db = Connection::open(&path).unwrap();
    db.execute_batch(
        "PRAGMA page_size = 512; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;
         CREATE TABLE metadata (name text, value text);
         CREATE TABLE tiles (zoom_level integer, tile_column integer, tile_row integer, tile_data blob);
         CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row);",
    )
    .unwrap();
    for (name, value) in metadata {
        db.execute("INSERT INTO metadata VALUES (?1, ?2)", [name, value])
            .unwrap();
    }
    for (zoom, column, row, bytes) in tiles {
        let south = (1_u32 << zoom) - 1 - row;
        db.execute(
            "INSERT INTO tiles VALUES (?1, ?2, ?3, ?4)",
            (zoom, column, south, bytes),
        )
        .unwrap();
    }
    path
}

fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Entries of number, run, length and offset + 1.
fn directory_bytes(entries: &[[u64; 4]], gzip: bool) -> Vec<u8> {
    let mut out = Vec::new();
    varint(&mut out, entries.len() as u64);
    let mut last = 0;
    for [id, ..] in entries {
        varint(&mut out, id - last);
        last = *id;
    }
    for field in 1..4 {
        for entry in entries {
            varint(&mut out, entry[field]);
        }
    }
    if gzip {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&out).unwrap();
        return encoder.finish().unwrap();
    }
    out
}

/// A file as the specification says; `leaves`: tiles are in a directory below the root.
fn pmtiles(at: &Path, tiles: &[Made], metadata: &str, leaves: bool) -> PathBuf {
    let mut sorted: Vec<(u64, &Vec<u8>)> = tiles
        .iter()
        .map(|(zoom, column, row, bytes)| {
            let id = pmtiles::id_of(TileAt {
                zoom: *zoom,
                column: *column,
                row: *row,
            });
            (id, bytes)
        })
        .collect();
    sorted.sort();
    let mut data = Vec::new();
    let mut entries = Vec::new();
    for (id, bytes) in sorted {
        entries.push([id, 1, bytes.len() as u64, data.len() as u64 + 1]);
        data.extend_from_slice(bytes);
    }
    let mut leaf = directory_bytes(&entries, leaves);
    let root = if leaves {
        directory_bytes(&[[entries[0][0], 0, leaf.len() as u64, 1]], true)
    } else {
        core::mem::take(&mut leaf)
    };
    let mut json = metadata.as_bytes().to_vec();
    if leaves {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&json).unwrap();
        json = encoder.finish().unwrap();
    }
    let mut file = b"PMTiles\x03".to_vec();
    let root_at = 127_u64;
    let json_at = root_at + root.len() as u64;
    let leaves_at = json_at + json.len() as u64;
    let data_at = leaves_at + leaf.len() as u64;
    for number in [
        root_at,
        root.len() as u64,
        json_at,
        json.len() as u64,
        leaves_at,
        leaf.len() as u64,
        data_at,
        data.len() as u64,
        tiles.len() as u64,
        tiles.len() as u64,
        tiles.len() as u64,
    ] {
        file.extend_from_slice(&number.to_le_bytes());
    }
    let zooms = tiles.iter().map(|t| t.0);
    let compression = if leaves { 2 } else { 1 };
    file.extend_from_slice(&[1, compression, 1, 2]);
    file.extend_from_slice(&[zooms.clone().min().unwrap(), zooms.max().unwrap()]);
    for degrees in [-180.0, -85.051_13, 180.0, 85.051_13] {
        file.extend_from_slice(&((degrees * 1e7) as i32).to_le_bytes());
    }
    file.extend_from_slice(&[0; 9]);
    assert_eq!(file.len(), 127);
    for part in [root, json, leaf, data] {
        file.extend_from_slice(&part);
    }
    let path = at.join("set.pmtiles");
    fs::write(&path, file).unwrap();
    path
}

fn plain() -> OpenOptions {
    OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    }
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

fn bytes_at(block: &Block, i: usize) -> [u8; 4] {
    core::array::from_fn(|plane| crate::colour::to_u8(block.plane(plane)[i]))
}

fn refusal(path: &Path, options: &OpenOptions) -> String {
    open_any(path, options).map(drop).unwrap_err().to_string()
}

#[test]
fn every_kind_of_set_shows_the_same_map() {
    let at = tempfile::tempdir().unwrap();
    let tiles = world();
    let paths = [
        folder(&at.path().join("xyz"), &tiles, ".png"),
        folder(&at.path().join("double"), &tiles, "@2x.png"),
        mbtiles(at.path(), &tiles, &[]),
        pmtiles(at.path(), &tiles, "{}", false),
    ];
    for path in &paths {
        let file = open_any(path, &plain()).unwrap();
        let info = file.info();
        assert_eq!(info.bands, Bands::Colour);
        let place = info.georeference.clone().unwrap();
        assert_eq!(&*place.crs, "EPSG:3857");
        let [x, dx, _, y, _, dy] = place.plane_from_pixel;
        assert!((x + HALF_MAP_M).abs() < 1e-6 && (y - HALF_MAP_M).abs() < 1e-6);
        assert!((dx * 256.0 - 2.0 * HALF_MAP_M).abs() < 1e-6 && dy == -dx);
        let sides: Vec<u32> = info.overviews.iter().map(|o| o.width).collect();
        // Level 0 fits into one tile of the program's: nothing coarser is needed.
        assert_eq!(sides, [256], "{path:?}");
        let block = read(&*file, 0, 60, 125, 140, 10);
        for (i, (px, py)) in [(0, (60, 125)), (5, (65, 125)), (9 * 140 + 139, (199, 134))] {
            let expected = [20, (px / 64) as u8, (py / 64) as u8, 255];
            assert_eq!(bytes_at(&block, i), expected, "{path:?}");
        }
    }
    let leaves = pmtiles(at.path(), &tiles, "{}", true);
    let file = open_any(&leaves, &plain()).unwrap();
    assert_eq!(
        bytes_at(&read(&*file, 0, 70, 130, 1, 1), 0),
        [20, 1, 2, 255]
    );
}

#[test]
fn rows_from_south_are_turned_by_option_or_metadata() {
    let at = tempfile::tempdir().unwrap();
    let south: Vec<Made> = world()
        .into_iter()
        .map(|(zoom, column, row, bytes)| (zoom, column, (1 << zoom) - 1 - row, bytes))
        .collect();
    let path = folder(at.path(), &south, ".png");
    let top = |options: &OpenOptions| {
        let file = open_any(&path, options).unwrap();
        bytes_at(&read(&*file, 0, 0, 0, 1, 1), 0)
    };
    assert_eq!(top(&plain()), [20, 0, 3, 255]);
    let given = OpenOptions {
        tile_rows: Some(TileRows::FromSouth),
        ..plain()
    };
    assert_eq!(top(&given), [20, 0, 0, 255]);
    fs::write(path.join("metadata.json"), r#"{"scheme": "tms"}"#).unwrap();
    assert_eq!(top(&plain()), [20, 0, 0, 255]);
}

#[test]
fn a_missing_tile_shows_the_next_coarser_zoom_and_a_transparent_one_stays_empty() {
    let at = tempfile::tempdir().unwrap();
    // Sixteen tiles of 64 would fit into one level: six zooms make three levels.
    let mut tiles = vec![(0, 0, 0, flat([200, 100, 0, 255]))];
    for zoom in 1..=4_u8 {
        tiles.push((zoom, 0, 0, flat([50 * zoom, 0, 0, 255])));
    }
    tiles.push((4, 1, 0, flat([255, 255, 255, 0])));
    let path = mbtiles(
        at.path(),
        &tiles,
        &[("bounds", "-180,-85.0511,180,85.0511")],
    );
    let file = open_any(&path, &plain()).unwrap();
    let sides: Vec<u32> = file.info().overviews.iter().map(|o| o.width).collect();
    assert_eq!(sides, [1024, 512, 256]);
    let at_pixel = |x: u32, y: u32| bytes_at(&read(&*file, 0, x, y, 1, 1), 0);
    assert_eq!(at_pixel(10, 10), [200, 0, 0, 255]);
    assert_eq!(at_pixel(70, 10), [0; 4], "a transparent tile is empty");
    // Zoom 3 covers 128 pixels of zoom 4, zoom 2 covers 256.
    assert_eq!(at_pixel(30, 100), [150, 0, 0, 255]);
    assert_eq!(at_pixel(200, 200), [100, 0, 0, 255]);
    // Coarser zooms than the raster's levels fill nothing.
    assert_eq!(at_pixel(900, 900), [0; 4]);
}

#[test]
fn filled_heights_run_linearly_and_parts_equal_the_whole() {
    let at = tempfile::tempdir().unwrap();
    // A plane of heights in Terrarium: whole metres x + 2 y at zoom 3.
    let plane = picture(
        256,
        |x, y| {
            let code = 32_768 + x + 2 * y;
            [(code >> 8) as u8, code as u8, 0, 255]
        },
        ImageFormat::Png,
    );
    let path = folder(
        at.path(),
        &[(3, 2, 2, plane.clone()), (4, 4, 4, plane)],
        ".png",
    );
    let options = OpenOptions {
        encoding: Some(HeightEncoding::Terrarium),
        ..plain()
    };
    let file = open_any(&path, &options).unwrap();
    assert_eq!(file.info().bands, Bands::Height);
    let sizes: Vec<u32> = file.info().overviews.iter().map(|o| o.width).collect();
    assert_eq!(sizes, [512, 256]);
    let whole = read(&*file, 0, 0, 0, 512, 512);
    for (x, y) in [(300_u32, 7_u32), (301, 8), (400, 400), (511, 300)] {
        let h = whole.plane(0)[(y * 512 + x) as usize];
        // Beyond the outermost centres the last sample goes on.
        let coarse = |i: u32| (f64::from(i) * 0.5 - 0.25).clamp(0.0, 255.0);
        let expected = coarse(x) + 2.0 * coarse(y);
        assert!(
            (f64::from(h) - expected).abs() < 1e-4,
            "{x} {y}: {h} {expected}"
        );
    }
    for (x, y, w, h) in [
        (255, 250, 9, 20),
        (0, 300, 33, 1),
        (479, 0, 33, 512),
        (256, 256, 1, 1),
    ] {
        let part = read(&*file, 0, x, y, w, h);
        for (i, v) in part.plane(0).iter().enumerate() {
            let (px, py) = (x + i as u32 % w, y + i as u32 / w);
            let expected = whole.plane(0)[(py * 512 + px) as usize];
            assert_eq!(v.to_bits(), expected.to_bits(), "{px} {py}");
        }
    }
}

#[test]
fn heights_are_decoded_exactly_and_black_is_nodata() {
    let at = tempfile::tempdir().unwrap();
    let codes = [
        [1, 134, 160, 255],
        [1, 135, 4, 255],
        [0, 0, 0, 255],
        [9, 9, 9, 0],
    ];
    let tile = picture(64, |x, _| codes[x as usize % 4], ImageFormat::Png);
    let json = r#"{"encoding": "mapbox"}"#;
    let path = mbtiles(at.path(), &[(0, 0, 0, tile.clone())], &[("json", json)]);
    let heights = |options: &OpenOptions| {
        let file = open_any(&path, options).unwrap();
        read(&*file, 0, 0, 5, 4, 1).plane(0).to_vec()
    };
    let found = heights(&plain());
    assert_eq!(found[..2], [0.0, 10.0]);
    assert!(found[2].is_nan() && found[3].is_nan());
    let with_nodata = OpenOptions {
        nodata: Some(10.0),
        ..plain()
    };
    let found = heights(&with_nodata);
    assert!(found[1].is_nan() && found[2] == -10_000.0);
    // Without a word about the encoding they are colours, and heights are refused.
    let path = folder(&at.path().join("plain"), &[(0, 0, 0, tile)], ".png");
    let wanted = OpenOptions {
        as_bands: Some(Bands::Height),
        ..plain()
    };
    let line = refusal(&path, &wanted);
    assert!(line.contains("terrarium"), "{line}");
    let lossy = picture(64, |_, _| [1, 134, 160, 255], ImageFormat::Jpeg);
    let path = folder(&at.path().join("lossy"), &[(0, 0, 0, lossy)], ".jpg");
    let encoded = OpenOptions {
        encoding: Some(HeightEncoding::TerrainRgb),
        ..plain()
    };
    let line = refusal(&path, &encoded);
    assert!(line.contains("lossless"), "{line}");
}

#[test]
fn lossless_webp_tiles_hold_heights() {
    let at = tempfile::tempdir().unwrap();
    let tile = picture(64, |_, _| [128, 7, 128, 255], ImageFormat::WebP);
    let path = folder(at.path(), &[(0, 0, 0, tile)], ".webp");
    let options = OpenOptions {
        encoding: Some(HeightEncoding::Terrarium),
        ..plain()
    };
    let file = open_any(&path, &options).unwrap();
    assert_eq!(read(&*file, 0, 3, 3, 1, 1).plane(0), [7.5]);
}

#[test]
fn a_set_a_billion_pixels_wide_costs_only_the_tiles_that_are_read() {
    let at = tempfile::tempdir().unwrap();
    let tile = picture(256, |_, _| [9, 8, 7, 255], ImageFormat::Png);
    let tiles: Vec<Made> = (0..=22_u8).map(|zoom| (zoom, 0, 0, tile.clone())).collect();
    let path = mbtiles(at.path(), &tiles, &[("bounds", "-180,-85.06,180,85.06")]);
    let file = open_any(&path, &plain()).unwrap();
    assert_eq!(file.info().overviews[0].width, 1 << 30);
    assert_eq!(file.info().overviews.len(), 23);
    let last = (1 << 30) - 3;
    assert_eq!(bytes_at(&read(&*file, 0, 0, 0, 1, 1), 0), [9, 8, 7, 255]);
    assert_eq!(
        bytes_at(&read(&*file, 0, last, last, 3, 3), 8),
        [9, 8, 7, 255]
    );
    let deeper: Vec<Made> = (0..=23_u8).map(|zoom| (zoom, 0, 0, tile.clone())).collect();
    fs::remove_file(&path).unwrap();
    let path = mbtiles(at.path(), &deeper, &[("bounds", "-180,-85.06,180,85.06")]);
    let line = refusal(&path, &plain());
    assert!(line.contains("2147483647 pixels"), "{line}");
}

#[test]
fn fine_zooms_alone_far_apart_are_refused_before_any_work() {
    let at = tempfile::tempdir().unwrap();
    let side = 1 << 20;
    let tiles = [coded(20, 0, 0), coded(20, side - 1, side - 1)];
    let path = mbtiles(at.path(), &tiles, &[]);
    let line = refusal(&path, &OpenOptions::default());
    assert!(line.contains("found zoom 20"), "{line}");
}

#[test]
fn bounds_crop_the_raster_to_whole_pixels_of_its_coarsest_level() {
    let at = tempfile::tempdir().unwrap();
    let tiles: Vec<Made> = (0..=8_u8).map(|zoom| coded(zoom, 0, 0)).collect();
    let path = mbtiles(at.path(), &tiles, &[("bounds", "10,-10,40,5")]);
    let file = open_any(&path, &plain()).unwrap();
    let info = file.info();
    let place = info.georeference.clone().unwrap();
    let [x, dx, _, y, _, dy] = place.plane_from_pixel;
    let east = x + dx * f64::from(info.overviews[0].width);
    let south = y + dy * f64::from(info.overviews[0].height);
    let degree_m = HALF_MAP_M / 180.0;
    let coarsest_m = dx * f64::from(1 << (info.overviews.len() - 1));
    assert!(x <= 10.0 * degree_m && x > 10.0 * degree_m - coarsest_m);
    assert!(east >= 40.0 * degree_m && east < 40.0 * degree_m + coarsest_m);
    assert!(y >= 557_305.0 && y < 557_306.0 + coarsest_m);
    assert!(south <= -1_118_889.0 && south > -1_118_890.0 - coarsest_m);
    for pair in info.overviews.windows(2) {
        assert_eq!(
            (pair[0].width, pair[0].height),
            (pair[1].width * 2, pair[1].height * 2)
        );
    }
}

#[test]
fn what_is_no_set_of_pictures_is_refused_in_one_line() {
    let at = tempfile::tempdir().unwrap();
    let empty = at.path().join("empty");
    fs::create_dir_all(empty.join("3")).unwrap();
    assert!(refusal(&empty, &plain()).contains("found none"));
    let vector = folder(
        &at.path().join("pbf"),
        &[(0, 0, 0, vec![0x1a, 1, 2])],
        ".pbf",
    );
    assert!(refusal(&vector, &plain()).contains("vector"));
    let odd = picture(64, |_, _| [1; 4], ImageFormat::Png);
    let path = mbtiles(at.path(), &[(0, 0, 0, odd)], &[("format", "pbf")]);
    assert!(refusal(&path, &plain()).contains("vector"));
    let other = at.path().join("other.gpkg");
    Connection::open(&other)
        .unwrap()
        .execute_batch("CREATE TABLE gpkg_contents (x)")
        .unwrap();
    assert!(refusal(&other, &plain()).contains("GeoPackage"));
    let endless = at.path().join("endless.mbtiles");
    Connection::open(&endless)
        .unwrap()
        .execute_batch(
            "CREATE VIEW tiles AS WITH RECURSIVE t(zoom_level) AS \
             (SELECT 1 UNION ALL SELECT 1 FROM t) \
             SELECT zoom_level, 0 AS tile_column, 0 AS tile_row, x'00' AS tile_data FROM t",
        )
        .unwrap();
    assert!(refusal(&endless, &plain()).contains("too long"));
}

/// Opens and reads a corner of every level; the error's text.
fn answer(path: &Path) -> Result<(), String> {
    let file = open_any(path, &plain()).map_err(|e| e.to_string())?;
    for (level, size) in file.info().overviews.iter().enumerate() {
        let mut block = Block::new(Bands::Height, 0, 0);
        let rect = PixelRect {
            x: 0,
            y: 0,
            width: size.width.min(64),
            height: size.height.min(64),
        };
        file.read(level, rect, &mut block, &Cancel::default())
            .map_err(|e| e.to_string())?;
    }
    Ok(())
}

#[test]
fn a_file_of_tiles_that_ends_anywhere_is_answered_in_one_line() {
    let at = tempfile::tempdir().unwrap();
    let tiles = [coded(0, 0, 0)];
    let made = [
        pmtiles(at.path(), &tiles, "{}", true),
        mbtiles(at.path(), &tiles, &[("name", "cut")]),
    ];
    for whole in made {
        answer(&whole).unwrap();
        let bytes = fs::read(&whole).unwrap();
        let cut = at.path().join("cut.tiles");
        let mut refused = 0;
        for length in 0..bytes.len() {
            fs::write(&cut, &bytes[..length]).unwrap();
            if let Err(line) = answer(&cut) {
                assert!(!line.contains('\n') && line.contains("cut.tiles"), "{line}");
                refused += 1;
            }
        }
        assert!(refused > bytes.len() / 2, "{refused} of {}", bytes.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn changed_bytes_never_panic(
        database in any::<bool>(),
        changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..5),
    ) {
        let at = tempfile::tempdir().unwrap();
        let tiles = [coded(0, 0, 0), coded(1, 1, 0)];
        let path = if database {
            mbtiles(at.path(), &tiles, &[("bounds", "-180,-85,180,85")])
        } else {
            pmtiles(at.path(), &tiles, "{}", false)
        };
        let mut bytes = fs::read(&path).unwrap();
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        fs::write(&path, bytes).unwrap();
        answer(&path).ok();
    }
}
