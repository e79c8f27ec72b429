//! World files: six lines of text beside a picture that say where its pixels lie.
//!
//! Source: ESRI, "World files for raster datasets": x per column, y per column, x per row, y per
//! row, then x and y of the centre of the first pixel.

use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes of a world file at most; six numbers need far less.
const MAX_BYTES: u64 = 4096;

/// Reads the text of a world file as [`plane_from_pixel`](crate::file::Georeference::plane_from_pixel).
///
/// # Errors
/// A line that says what was expected and found.
pub fn parse(text: &str) -> Result<[f64; 6], String> {
    let mut numbers = [0.0; 6];
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    for (i, number) in numbers.iter_mut().enumerate() {
        let Some(line) = lines.next() else {
            return Err(format!("expected 6 numbers, found {i}"));
        };
        // Some programs write decimal commas.
        let parsed = line.replace(',', ".").parse::<f64>();
        *number = parsed.ok().filter(|v| v.is_finite()).ok_or_else(|| {
            let shown: String = line.chars().take(40).collect();
            format!("expected a number in line {}, found {shown:?}", i + 1)
        })?;
    }
    let [dx_dcol, dy_dcol, dx_drow, dy_drow, x, y] = numbers;
    let affine = [
        x - 0.5 * (dx_dcol + dx_drow),
        dx_dcol,
        dx_drow,
        y - 0.5 * (dy_dcol + dy_drow),
        dy_dcol,
        dy_drow,
    ];
    crate::geotiff::check_affine(&affine)?;
    Ok(affine)
}

/// The world file of a picture and what it says; `None` where there is none.
///
/// Looked for, in this order: the picture's extension with a `w` added (`.jpgw`), its first and last
/// letter and a `w` (`.jgw`), `.wld`; each also in capitals.
///
/// # Errors
/// The world file's path with a line that says what was expected and found.
pub(crate) fn beside(picture: &Path) -> Result<Option<[f64; 6]>, (PathBuf, String)> {
    let extension = picture
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
        .to_ascii_lowercase();
    let mut endings = Vec::new();
    if let (Some(first), Some(last)) = (extension.chars().next(), extension.chars().last()) {
        endings.push(format!("{extension}w"));
        endings.push(format!("{first}{last}w"));
    }
    endings.push("wld".into());
    for ending in endings
        .iter()
        .flat_map(|e| [e.clone(), e.to_ascii_uppercase()])
    {
        let path = picture.with_extension(ending);
        // A pipe of that name would keep the reader waiting.
        if !path.is_file() {
            continue;
        }
        let Ok(file) = std::fs::File::open(&path) else {
            continue;
        };
        let mut text = String::new();
        return match file.take(MAX_BYTES).read_to_string(&mut text) {
            Ok(_) => parse(&text).map(Some).map_err(|reason| (path, reason)),
            Err(error) => Err((path, format!("expected text: {error}"))),
        };
    }
    Ok(None)
}

/// `EPSG:4326` if plane coordinates of all corners could be degrees (longitudes −360 to 360,
/// latitudes −90 to 90), else `None`: world files do not name their system.
pub(crate) fn assumed_crs(affine: &[f64; 6], width: u32, height: u32) -> Option<&'static str> {
    let (w, h) = (f64::from(width), f64::from(height));
    let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)];
    let degrees = corners.iter().all(|(c, r)| {
        let x = affine[0] + affine[1] * c + affine[2] * r;
        let y = affine[3] + affine[4] * c + affine[5] * r;
        x.abs() <= 360.0 + 1e-6 && y.abs() <= 90.0 + 1e-6
    });
    degrees.then_some("EPSG:4326")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_file_names_the_centre_of_the_first_pixel() {
        let affine = parse("0.5\n0\n0\r\n-0,5\n -179.75 \n89.75\n").unwrap();
        assert_eq!(affine, [-180.0, 0.5, 0.0, 90.0, 0.0, -0.5]);
        assert_eq!(assumed_crs(&affine, 720, 360), Some("EPSG:4326"));
        assert_eq!(assumed_crs(&affine, 1720, 360), None);
    }

    #[test]
    fn a_world_file_with_too_few_or_senseless_numbers_is_refused() {
        assert!(parse("1\n2\n3").unwrap_err().contains("found 3"));
        assert!(parse("1\n0\n0\nnan\n5\n6").unwrap_err().contains("line 4"));
        assert!(parse("0\n0\n0\n0\n5\n6").unwrap_err().contains("area"));
    }
}
