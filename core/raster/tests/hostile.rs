//! Damaged files are answered with an error, or read as far as they go; nothing panics or hangs.

mod common;

use std::path::Path;

use proptest::prelude::*;
use relievo_raster::crs::Crs;
use relievo_raster::open::{OpenOptions, open};

fn truncate_everywhere(name: &str, bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = OpenOptions::default();
    let mut refused = 0;
    for length in 0..bytes.len() {
        let path = common::put(folder.path(), name, &bytes[..length]);
        match common::open_and_read(&path, &options) {
            Ok(_) => {}
            Err(line) => {
                assert!(
                    !line.contains('\n') && line.contains(name),
                    "one line that names the file: {line}"
                );
                refused += 1;
            }
        }
    }
    assert!(
        refused > bytes.len() / 2,
        "most truncated files are refused: {refused} of {}",
        bytes.len()
    );
}

#[test]
fn a_tiff_that_ends_anywhere_is_refused_in_one_line() {
    truncate_everywhere("cut.tif", &common::heights(9, 7, false));
}

#[test]
fn a_png_that_ends_anywhere_is_refused_in_one_line() {
    truncate_everywhere("cut.png", &common::picture(9, 7, image::ImageFormat::Png));
}

#[test]
fn a_webp_that_ends_anywhere_is_refused_in_one_line() {
    truncate_everywhere("cut.webp", &common::picture(9, 7, image::ImageFormat::WebP));
}

#[test]
fn a_lossless_webp_shows_what_the_same_png_does() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [png, webp] = [image::ImageFormat::Png, image::ImageFormat::WebP].map(|format| {
        let path = common::put(folder.path(), "picture", &common::picture(301, 97, format));
        common::open_and_read(&path, &OpenOptions::default()).expect("a picture that opens")
    });
    assert_eq!(png, webp);
}

#[test]
fn a_jpeg_that_ends_anywhere_is_answered() {
    let bytes = common::picture(9, 7, image::ImageFormat::Jpeg);
    truncate_everywhere("cut.jpg", &bytes);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_tiff_with_changed_bytes_never_panics(changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..6)) {
        let folder = tempfile::tempdir().unwrap();
        let mut bytes = common::heights(9, 7, false);
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        let path = common::put(folder.path(), "changed.tif", &bytes);
        common::open_and_read(&path, &OpenOptions::default()).ok();
    }

    #[test]
    fn a_png_with_changed_bytes_never_panics(at in 8usize..60, value in any::<u8>()) {
        let folder = tempfile::tempdir().unwrap();
        let mut bytes = common::picture(9, 7, image::ImageFormat::Png);
        bytes[at] = value;
        let path = common::put(folder.path(), "changed.png", &bytes);
        common::open_and_read(&path, &OpenOptions::default()).ok();
    }

    #[test]
    fn no_text_makes_a_coordinate_system_panic(text in "(\\+proj=(utm|tmerc|lcc|stere|aea|laea|merc|omerc|longlat)( \\+(zone|lat_0|lat_1|lon_0|R|a|b|k_0|to_meter|pm)=-?[0-9.e]{0,6}){0,4})|[A-Z]{3,5}:[0-9]{0,9}", x in -1e8..1e8f64, y in any::<f64>()) {
        if let Ok(crs) = Crs::parse(&text) {
            if let Ok((lon, lat)) = crs.to_lonlat(x, y) {
                prop_assert!(lon.is_finite() && lat.abs() <= core::f64::consts::FRAC_PI_2);
            }
            crs.from_lonlat(0.3, 0.4).ok();
        }
    }
}

#[test]
fn a_circle_of_directories_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = common::heights(9, 7, false);
    let first = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
    let entries = usize::from(u16::from_le_bytes(
        bytes[first..first + 2].try_into().unwrap(),
    ));
    let next = first + 2 + entries * 12;
    bytes[next..next + 4].copy_from_slice(&(first as u32).to_le_bytes());
    let path = common::put(folder.path(), "circle.tif", &bytes);
    let line = common::open_and_read(&path, &OpenOptions::default()).unwrap_err();
    assert!(line.contains("circle"), "{line}");
}

#[test]
fn a_file_that_shrinks_while_it_is_open_is_an_error_where_bytes_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    for make_pyramid in [false, true] {
        let options = OpenOptions {
            make_pyramid,
            ..OpenOptions::default()
        };
        for name in ["deflate-3-float.tif", "big-endian-plain.tif", "planar.tif"] {
            let fixture = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("tests/fixtures")
                .join(name);
            let bytes = std::fs::read(fixture).unwrap();
            let path = common::put(folder.path(), name, &bytes);
            let file = open(&path, &options).unwrap();
            for length in [bytes.len() / 2, 8, 0] {
                // The same file, not a new one in its place.
                let shrunk = std::fs::File::options().write(true).open(&path).unwrap();
                shrunk.set_len(length as u64).unwrap();
                let line = common::read_level(&*file, 0).unwrap_err();
                assert!(line.contains(name) && line.lines().count() == 1, "{line}");
            }
            std::fs::remove_file(&path).unwrap();
            common::read_level(&*file, 0).unwrap_err();
        }
    }
}

#[test]
fn a_picture_that_shrinks_before_it_is_decoded_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in [
        ("a.png", image::ImageFormat::Png),
        ("a.jpg", image::ImageFormat::Jpeg),
    ] {
        let bytes = common::picture(90, 70, format);
        let path = common::put(folder.path(), name, &bytes);
        let options = OpenOptions {
            make_pyramid: false,
            ..OpenOptions::default()
        };
        let file = open(&path, &options).unwrap();
        std::fs::write(&path, &bytes[..60]).unwrap();
        let line = common::read_level(&*file, 0).unwrap_err();
        assert!(line.contains(name), "{line}");
        // The failure is kept: nothing is tried again for every tile.
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(common::read_level(&*file, 0).unwrap_err(), line);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_refused_and_not_waited_for() {
    for device in ["/dev/zero", "/dev/null", "/dev/full"] {
        let line = common::open_and_read(Path::new(device), &OpenOptions::default()).unwrap_err();
        assert!(line.contains("device") && line.contains(device), "{line}");
    }
    let folder = tempfile::tempdir().unwrap();
    let bytes = common::picture(9, 7, image::ImageFormat::Png);
    let path = common::put(folder.path(), "a.png", &bytes);
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("a.pgw"))
        .status();
    if made.is_ok_and(|status| status.success()) {
        common::open_and_read(&path, &OpenOptions::default()).unwrap();
        let pipe = folder.path().join("a.pgw");
        let line = common::open_and_read(&pipe, &OpenOptions::default()).unwrap_err();
        assert!(line.contains("pipe"), "{line}");
    }
}
