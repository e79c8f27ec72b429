//! Damaged files are answered with an error, or read as far as they go; nothing panics or hangs.

mod common;

use proptest::prelude::*;
use relievo_raster::crs::Crs;
use relievo_raster::open::OpenOptions;

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
