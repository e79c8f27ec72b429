//! Hostile files against the whole program: a process of its own with a gibibyte of address space
//! and ten seconds of processor time, which the system enforces. Each must end with exit code 2 and
//! one line, or with a result where the file is odd but sound: a sound picture of hundreds of
//! millions of pixels may take a minute.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::io::{Read, Write};
use std::path::Path;
use std::process::Command;

/// What the shell limits: address space in KiB.
const LIMITS: &str = "ulimit -v 1048576; exec \"$0\" \"$@\"";

/// Processor time for a file that is refused, seconds.
const REFUSAL_S: u32 = 10;

/// Processor time for a picture that is sound and huge, seconds.
const HUGE_S: u32 = 60;

/// How a run of the program ended.
struct Ended {
    code: Option<i32>,
    out: String,
    err: String,
}

/// Runs the program under the limits in a folder, with caches there and nowhere else.
fn relievo(folder: &Path, seconds: u32, arguments: &[&str]) -> Ended {
    let limits = format!("ulimit -t {seconds}; {LIMITS}");
    let output = Command::new("sh")
        .args(["-c", &limits, env!("CARGO_BIN_EXE_relievo")])
        .args(arguments)
        .current_dir(folder)
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .env("HOME", folder)
        .env("RUST_BACKTRACE", "0")
        .output()
        .unwrap();
    Ended {
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// A run that must be refused as bad input, in one line that names the file and says `part`.
fn refused(folder: &Path, arguments: &[&str], name: &str, part: &str) {
    let ended = relievo(folder, REFUSAL_S, arguments);
    let text = &ended.err[..ended.err.len().min(2000)];
    assert_eq!(ended.code, Some(2), "{arguments:?}: {text}");
    assert!(
        ended.err.starts_with("relievo: ") && ended.err.lines().count() == 1,
        "{arguments:?}: {text}"
    );
    assert!(ended.err.len() < 2000, "{arguments:?}: {text}");
    assert!(
        ended.err.contains(name) && ended.err.contains(part),
        "{arguments:?}: expected {name:?} and {part:?} in {text}"
    );
}

/// A run that must give a result.
fn good(folder: &Path, arguments: &[&str]) -> String {
    let ended = relievo(folder, REFUSAL_S, arguments);
    assert_eq!(
        (ended.code, ended.err.as_str()),
        (Some(0), ""),
        "{arguments:?}"
    );
    ended.out
}

fn put(folder: &Path, name: &str, content: &[u8]) {
    std::fs::write(folder.join(name), content).unwrap();
}

/// A project whose one layer is a file with a given place.
fn project_of(folder: &Path, name: &str, file: &str) {
    let text = format!(
        r#"{{"version": 1, "layers": [{{"id": "a", "kind": "imagery", "path": "{file}",
            "georeference": {{"crs": "EPSG:4326", "west": 0, "south": 0, "east": 1, "north": 1}}}}]}}"#
    );
    put(folder, name, text.as_bytes());
}

/// A raster file that must be refused by whatever opens it.
fn refused_everywhere(folder: &Path, name: &str, content: &[u8], part: &str) {
    put(folder, name, content);
    refused(folder, &["info", name], name, part);
    refused(
        folder,
        &["new", "made.relievo", "--source", name],
        name,
        part,
    );
    project_of(folder, "p.relievo", name);
    refused(
        folder,
        &["sample", "p.relievo", "--at", "0.5,0.5"],
        name,
        part,
    );
}

/// A raster file that `info` may describe but whose samples cannot be had.
fn refused_when_read(folder: &Path, name: &str, content: &[u8]) {
    put(folder, name, content);
    let told = relievo(folder, REFUSAL_S, &["info", name]);
    assert!(matches!(told.code, Some(0 | 2)), "{name}: {}", told.err);
    project_of(folder, "p.relievo", name);
    refused(
        folder,
        &["sample", "p.relievo", "--at", "0.5,0.5"],
        name,
        "",
    );
}

/// A field of a directory: tag, type, count, and the value or where it lies.
type Field = (u16, u16, u32, u32);

const SHORT: u16 = 3;
const LONG: u16 = 4;
const DOUBLE: u16 = 12;
/// Where the data of [`tiff`] begin.
const DATA_AT: u32 = 512;

/// A little-endian TIFF of one directory.
fn tiff(fields: &[Field], data: &[u8]) -> Vec<u8> {
    let mut fields = fields.to_vec();
    fields.sort_unstable();
    let mut out = b"II\x2a\x00\x08\x00\x00\x00".to_vec();
    out.extend((fields.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in fields {
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(count.to_le_bytes());
        out.extend(value.to_le_bytes());
    }
    out.extend(0u32.to_le_bytes());
    out.resize(DATA_AT as usize, 0);
    out.extend(data);
    out
}

/// The fields of one tile of 8-bit grey.
fn one_tile(side: u32, compression: u32, length: usize) -> Vec<Field> {
    vec![
        (256, LONG, 1, side),
        (257, LONG, 1, side),
        (258, SHORT, 1, 8),
        (259, SHORT, 1, compression),
        (262, SHORT, 1, 1),
        (322, LONG, 1, side),
        (323, LONG, 1, side),
        (324, LONG, 1, DATA_AT),
        (325, LONG, 1, length as u32),
    ]
}

/// A tile of bytes with the given doubles behind them as pixel scale and tie point.
fn placed(scale: [f64; 3], tie: [f64; 6], keys: &[u16]) -> Vec<u8> {
    let mut data = vec![7; 64];
    for v in scale.into_iter().chain(tie) {
        data.extend(v.to_le_bytes());
    }
    for key in keys {
        data.extend(key.to_le_bytes());
    }
    let mut fields = one_tile(8, 1, 64);
    fields.push((33550, DOUBLE, 3, DATA_AT + 64));
    fields.push((33922, DOUBLE, 6, DATA_AT + 64 + 24));
    fields.push((34735, SHORT, keys.len() as u32, DATA_AT + 64 + 72));
    tiff(&fields, &data)
}

/// Geo keys of a geographic system with a code.
fn geographic(code: u16) -> [u16; 12] {
    [1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, code]
}

fn zlib_zeros(length: u64) -> Vec<u8> {
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::copy(&mut std::io::repeat(0).take(length), &mut out).unwrap();
    out.finish().unwrap()
}

/// Zeros as Zstandard blocks of one repeated byte (RFC 8878, 3.1.1).
fn zstd_zeros(length: u64, window_log: u8) -> Vec<u8> {
    let mut out = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, (window_log - 10) << 3];
    let mut left = length;
    while left > 0 {
        let block = left.min(128 << 10);
        left -= block;
        let head = u32::from(left == 0) | 1 << 1 | (block as u32) << 3;
        out.extend(&head.to_le_bytes()[..3]);
        out.push(0);
    }
    out
}

fn png(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(name);
        crc.update(data);
        out.extend((data.len() as u32).to_be_bytes());
        out.extend(name);
        out.extend(data);
        out.extend(crc.sum().to_be_bytes());
    };
    let mut head = Vec::new();
    head.extend(width.to_be_bytes());
    head.extend(height.to_be_bytes());
    head.extend([8, 6, 0, 0, 0]);
    chunk(b"IHDR", &head);
    chunk(b"IDAT", data);
    chunk(b"IEND", b"");
    out
}

/// A small picture of the fuzz targets' seeds.
fn seed(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/picture");
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn rasters_that_claim_more_than_there_is_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let tile =
        |side, compression, data: &[u8]| tiff(&one_tile(side, compression, data.len()), data);
    refused_everywhere(
        folder,
        "side.tif",
        &tile(1 << 31, 1, &[0; 64]),
        "1073741824",
    );
    refused_everywhere(folder, "zero.tif", &tile(0, 1, &[0; 64]), "found 0");
    refused_when_read(folder, "claim.tif", &tile(16384, 8, &[0; 64]));
    refused_everywhere(
        folder,
        "huge-tile.tif",
        &tile(1 << 20, 50000, &[0; 64]),
        "MiB",
    );
    refused_everywhere(folder, "empty.tif", b"", "an empty file");
    refused_everywhere(folder, "head.tif", b"II\x2a\x00", "");
    let mut bands = one_tile(4096, 8, 64);
    bands.push((277, SHORT, 1, 65535));
    refused_everywhere(folder, "bands.tif", &tiff(&bands, &[0; 64]), "65535");
    // The directory follows itself.
    let mut circle = tile(8, 1, &[0; 64]);
    let next = 8 + 2 + 9 * 12;
    circle[next..next + 4].copy_from_slice(&8u32.to_le_bytes());
    refused_everywhere(folder, "circle.tif", &circle, "circle");
    refused_everywhere(
        folder,
        "claim.png",
        &png(100_000, 100_000, &[0; 64]),
        "pixels",
    );
    refused_when_read(folder, "header.png", &png(14_000, 14_000, &[0; 64]));
    let mut jpeg = seed("rgb.jpg");
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0xff, 0xdc, 0xff, 0xdc]);
    refused_everywhere(folder, "claim.jpg", &jpeg, "pixels");
}

#[test]
fn rasters_that_expand_without_end_are_answered_within_the_limits() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let side = 16384;
    let area = u64::from(side) * u64::from(side);
    for (name, compression, data) in [
        ("deflate.tif", 8, zlib_zeros(area)),
        ("zstd.tif", 50000, zstd_zeros(area, 17)),
        ("window.tif", 50000, zstd_zeros(area, 30)),
    ] {
        put(
            folder,
            name,
            &tiff(&one_tile(side, compression, data.len()), &data),
        );
        let ended = relievo(folder, HUGE_S, &["info", name]);
        assert!(matches!(ended.code, Some(0 | 2)), "{name}: {}", ended.err);
        project_of(folder, "p.relievo", name);
        let ended = relievo(folder, HUGE_S, &["sample", "p.relievo", "--at", "0.5,0.5"]);
        assert!(matches!(ended.code, Some(0 | 2)), "{name}: {}", ended.err);
    }
    // A picture within the limits of a side that is one colour: a megabyte of text for 768 MiB.
    let data = zlib_zeros(13_000 * (13_000 * 4 + 1));
    put(folder, "zeros.png", &png(13_000, 13_000, &data));
    project_of(folder, "p.relievo", "zeros.png");
    let ended = relievo(folder, HUGE_S, &["sample", "p.relievo", "--at", "0.5,0.5"]);
    assert!(
        matches!(ended.code, Some(0 | 2)),
        "zeros.png: {}",
        ended.err
    );
}

#[test]
fn places_that_make_no_sense_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let (scale, tie) = ([1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 10.0, 50.0, 0.0]);
    let wgs = geographic(4326);
    put(folder, "sound.tif", &placed(scale, tie, &wgs));
    assert!(good(folder, &["info", "sound.tif"]).contains("EPSG:4326"));
    let nan = f64::NAN;
    let inf = f64::INFINITY;
    for (name, scale, tie) in [
        ("nan.tif", [nan, 1.0, 0.0], tie),
        ("inf.tif", scale, [0.0, 0.0, 0.0, inf, 50.0, 0.0]),
        ("flat.tif", [0.0, 1.0, 0.0], tie),
        ("far.tif", scale, [1e308, 0.0, 0.0, 10.0, 50.0, 0.0]),
    ] {
        put(folder, name, &placed(scale, tie, &wgs));
        refused(folder, &["info", name], name, "pixels");
        let new = ["new", "made.relievo", "--source", name];
        refused(folder, &new, name, "pixels");
    }
    put(folder, "nowhere.tif", &placed(scale, tie, &geographic(9)));
    refused(
        folder,
        &["new", "made.relievo", "--source", "nowhere.tif"],
        "nowhere.tif",
        "EPSG:9",
    );
    put(folder, "a.png", &seed("rgb.png"));
    for (text, part) in [
        ("1\n2\n3\n", "6 numbers"),
        ("nan\n0\n0\n-1\n0\n0\n", "line 1"),
        ("1e400\n0\n0\n-1\n0\n0\n", "line 1"),
        ("0\n0\n0\n0\n0\n0\n", "area"),
        ("\u{fffd}\u{fffd}\n", "line 1"),
    ] {
        put(folder, "a.pgw", text.as_bytes());
        refused(folder, &["info", "a.png"], "a.pgw", part);
    }
    put(folder, "a.pgw", &[0xff; 5000]);
    refused(folder, &["info", "a.png"], "a.pgw", "text");
    put(folder, "a.pgw", b"1\n0\n0\n-1\n0.5\n-0.5\n");
    assert!(good(folder, &["info", "a.png"]).contains("EPSG:4326"));
}

#[test]
fn projects_that_are_no_projects_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let layer =
        |members: &str| format!(r#"{{"version": 1, "layers": [{{"id": "a", {members}}}]}}"#);
    let nested = format!("{}{}", r#"{"version": 1, "x": "#, "[".repeat(1 << 20));
    let objects = format!(r#"{{"version": 1, "x": {}"#, r#"{"x":"#.repeat(1 << 20));
    let zeros = format!(r#"{{"version": 1, "x": [{}0]}}"#, "0,".repeat(20 << 20));
    let empties = format!(
        r#"{{"version": 1, "x": [{}0]}}"#,
        r#"{"":0},"#.repeat(5 << 20)
    );
    let long_name = format!(
        r#"{{"version": 1, "planet": {{"preset": "earth", "radius_m": {}"#,
        "9".repeat(1 << 20)
    );
    let kind = layer(&format!(r#""kind": "{}""#, "k".repeat(1 << 20)));
    let path = layer(&format!(
        r#""kind": "imagery", "path": "{}""#,
        "p".repeat(1 << 20)
    ));
    let number = format!(r#"{{"version": {}}}"#, "1".repeat(32 << 20));
    for (text, part) in [
        (r#"{"version": 1e999}"#.to_owned(), ""),
        (r#"{"version": 4294967297}"#.to_owned(), "version"),
        (r#"{"version": -1}"#.to_owned(), "version"),
        (r#"{"version": 1, "version": 1}"#.to_owned(), "twice"),
        (
            r#"{"version": 1, "camera": {"lon_deg": 1e300, "lat_deg": 0, "altitude_m": 0}}"#
                .to_owned(),
            "/camera/lon_deg",
        ),
        (
            layer(r#""kind": "noise", "amplitude_m": 1e308, "wavelength_m": 1"#),
            "amplitude_m",
        ),
        (
            layer(r#""kind": "noise", "amplitude_m": 1, "wavelength_m": 0"#),
            "wavelength_m",
        ),
        ("null".to_owned(), "object"),
        (String::new(), "JSON"),
        (nested, "recursion"),
        (objects, "recursion"),
        (zeros, "values"),
        (empties, "values"),
        (long_name, ""),
        (number, ""),
        (path, "path"),
    ] {
        put(folder, "bad.relievo", text.as_bytes());
        refused(folder, &["check", "bad.relievo"], "bad.relievo", part);
        let info = ["info", "bad.relievo"];
        refused(folder, &info, "bad.relievo", part);
    }
    // A kind that only a newer program knows is no fault, and named in a few of its letters.
    put(folder, "bad.relievo", kind.as_bytes());
    let told = good(folder, &["check", "bad.relievo"]);
    assert!(
        told.contains("kind") && told.len() < 1000,
        "{} bytes",
        told.len()
    );
    put(
        folder,
        "bad.relievo",
        b"{\"version\": 1, \"x\": \"\xff\xfe\"}",
    );
    refused(folder, &["check", "bad.relievo"], "bad.relievo", "UTF-8");
    // One layer of 100 MB.
    let mut file = std::fs::File::create(folder.join("long.relievo")).unwrap();
    file.write_all(
        layer(r#""kind": "imagery", "path": "a.tif", "note": ""#)
            .strip_suffix("}]}")
            .unwrap()
            .as_bytes(),
    )
    .unwrap();
    std::io::copy(&mut std::io::repeat(b'x').take(100 << 20), &mut file).unwrap();
    file.write_all(b"\"}]}").unwrap();
    drop(file);
    refused(
        folder,
        &["check", "long.relievo"],
        "long.relievo",
        "67108864",
    );
    refused(folder, &["check", "/dev/zero"], "zero", "not a file");
}

#[test]
fn edits_that_are_no_edits_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    put(folder, "p.relievo", br#"{"version": 1, "layers": []}"#);
    let batches = |n: usize| {
        format!(
            "[{}{}]",
            r#"{"edit": "batch", "edits": ["#.repeat(n),
            "]}".repeat(n)
        )
    };
    let unknown = format!(r#"[{{"edit": "set_sun", "{}": 1}}]"#, "\\n".repeat(1 << 20));
    for (text, part) in [
        ("{}".to_owned(), "array"),
        ("[1]".to_owned(), "object"),
        (r#"[{"edit": "explode"}]"#.to_owned(), "explode"),
        (
            r#"[{"edit": "set_visible", "id": "a", "visible": 1}]"#.to_owned(),
            "visible",
        ),
        (
            r#"[{"edit": "move_layer", "id": "a", "index": 1e9}]"#.to_owned(),
            "\"a\"",
        ),
        (
            r#"[{"edit": "set_sun", "sun": {"azimuth_deg": 1e999}}]"#.to_owned(),
            "",
        ),
        (batches(9), "nested"),
        (batches(1 << 16), "recursion"),
        (unknown, "sun"),
        (format!("[{}0]", "0,".repeat(20 << 20)), "values"),
    ] {
        put(folder, "e.json", text.as_bytes());
        let apply = ["apply", "p.relievo", "e.json", "-o", "out.relievo"];
        refused(folder, &apply, "e.json", part);
        assert!(!folder.join("out.relievo").exists());
    }
}
