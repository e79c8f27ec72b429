//! Files made and read: baked ones are sources again, folders of tiles too.

use relievo_engine::raster::write::{Png, write_png};
use relievo_engine::raster::{Bands, Block};
use serde_json::Value;

use crate::shared::{NOISE, good, in_folder, refused, sample_file, text_file};

#[test]
fn a_baked_region_has_the_samples_that_sample_gives() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let out = in_folder(folder.path(), "heights.tif");
    let arguments = [
        "bake",
        &project,
        "-o",
        &out,
        "--output",
        "height",
        "--bounds",
        "-10,40,-9,41",
        "--resolution",
        "0.05",
    ];
    good(&arguments);
    let info = good(&["info", &out, "--json"]).json();
    assert_eq!(
        (&info["width"], &info["height"]),
        (&Value::from(20), &Value::from(20))
    );
    assert_eq!(info["read_as"], "heights");
    assert!((info["extent"]["west"].as_f64().unwrap() + 10.0).abs() < 1e-9);
    let first = std::fs::read(&out).unwrap();
    good(&[&arguments[..], &["--threads", "3"]].concat());
    assert_eq!(
        std::fs::read(&out).unwrap(),
        first,
        "the same bytes for any number of threads"
    );
}

#[test]
fn a_baked_openexr_file_is_a_source_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let region = ["--bounds", "-10,40,-9,41", "--resolution", "0.05"];
    let bake = |name: &str, output: &str| {
        let out = in_folder(folder.path(), name);
        let arguments = ["bake", &project, "-o", &out, "--output", output];
        good(&[&arguments[..], &region].concat());
        let first = std::fs::read(&out).unwrap();
        good(&[&arguments[..], &region, &["--threads", "3"]].concat());
        assert_eq!(std::fs::read(&out).unwrap(), first, "{name}");
        out
    };
    let (heights, colours) = (bake("h.exr", "height"), bake("c.exr", "colour"));
    let info = good(&["info", &colours, "--json"]).json();
    assert_eq!(
        (&info["format"], &info["read_as"]),
        (&"OpenEXR".into(), &"colours".into())
    );
    let info = good(&["info", &heights, "--json"]).json();
    assert_eq!(info["crs"], "EPSG:4326");
    assert!((info["extent"]["north"].as_f64().unwrap() - 41.0).abs() < 1e-9);
    // The same samples as a GeoTIFF has.
    let height_m = |source: &str| {
        let project = format!("{source}.relievo");
        good(&["new", &project, "--source", source]);
        let line = good(&["sample", &project, "--at", "-9.525,40.475"]).json();
        line["height_m"].as_f64().unwrap()
    };
    let (exr, tif) = (height_m(&heights), height_m(&bake("h.tif", "height")));
    assert!((exr - tif).abs() < 1e-6 && exr != 0.0, "{exr} {tif}");
}

#[test]
fn a_folder_of_tiles_is_heights_with_an_encoding_and_imagery_without() {
    let folder = tempfile::tempdir().unwrap();
    let tiles = folder.path().join("tiles");
    let tile = tiles.join("0/0");
    std::fs::create_dir_all(&tile).unwrap();
    // 256 · 128 + 7 + 128 / 256 − 32 768 = 7.5.
    let colour = [128.0, 7.0, 128.0, 255.0].map(|v| v / 255.0);
    let block = Block::filled(Bands::Colour, 64, 64, &colour);
    write_png(&tile.join("0.png"), &block, Png::Rgb8).unwrap();
    let tiles = tiles.to_str().unwrap();
    let heights = in_folder(folder.path(), "heights.relievo");
    let encoding = ["--encoding", "terrarium"];
    good(&[&["new", &heights, "--source", tiles][..], &encoding].concat());
    assert_eq!(
        good(&["check", &heights, "--json"]).json(),
        Value::Array(vec![])
    );
    let line = good(&["sample", &heights, "--at", "10,20"]).json();
    assert_eq!(line["height_m"], 7.5);
    let imagery = in_folder(folder.path(), "imagery.relievo");
    good(&["new", &imagery, "--source", tiles]);
    let info = good(&["info", &imagery, "--json"]).json();
    assert_eq!(info["layers"][0]["kind"], "imagery");
    let other = in_folder(folder.path(), "other.relievo");
    let file = sample_file("data/wasatch-dem.tif");
    let line = refused(&[&["new", &other, "--source", &file][..], &encoding].concat());
    assert!(line.contains("set of tiles"), "{line}");
}
