//! SRTM height files (`.hgt`): big-endian metres in a square of one degree that the name places.
//!
//! The file has no header: its length says how many samples a degree has, its name where the
//! south-western corner lies. Samples are points on the degree's edges, so neighbours share a row
//! or column, and the outer pixel edges lie half a sample outside of the degree.
//!
//! Source: NASA, "SRTM data product specification", void is −32768.

use std::path::Path;
use std::sync::Arc;

use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::geotiff::Bytes;
use crate::open::{OpenError, OpenOptions, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, pyramid};

/// The format's name in messages.
const FORMAT: &str = "SRTM";
/// Stored value of a sample that the radar did not see.
const VOID: i16 = -32768;
/// Columns and rows that files have: 3, 1 (also with half the columns, as beyond 50° of latitude),
/// ½ and ⅓ arc seconds.
const SIZES: [(u32, u32); 6] = [
    (1201, 1201),
    (601, 1201),
    (3601, 3601),
    (1801, 3601),
    (7201, 7201),
    (10_801, 10_801),
];

/// An open height file. Rows are read from the file each time: the system caches them well enough.
struct Hgt {
    info: RasterInfo,
    bytes: Bytes,
    /// Another value that means nodata; voids do in any case.
    nodata: Option<f64>,
    fingerprint: [u8; 32],
}

/// Whether length and name leave no doubt, whatever the first samples look like.
pub(crate) fn is_one(path: &Path, length: u64) -> bool {
    size_of(length).is_some() && position(path).is_some()
}

/// Whether the name ends in `.hgt`.
pub(crate) fn is_named(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("hgt"))
}

/// Columns and rows of a file of so many bytes.
fn size_of(length: u64) -> Option<(u32, u32)> {
    SIZES
        .into_iter()
        .find(|(w, h)| u64::from(*w) * u64::from(*h) * 2 == length)
}

/// Longitude and latitude in degrees of the south-western corner that a name such as `N41E001.hgt`
/// or `s09w070.SRTMGL1.hgt` begins with.
fn position(path: &Path) -> Option<(f64, f64)> {
    let name = path.file_name()?.to_str()?.to_ascii_uppercase();
    let latitude = name.get(..3)?;
    let longitude = name.get(3..7)?;
    // What follows must not be a part of the number.
    if name[7..].starts_with(|c: char| c.is_ascii_alphanumeric()) {
        return None;
    }
    let degrees = |text: &str, positive: char, negative: char, most: f64| {
        let sign = match text.chars().next()? {
            c if c == positive => 1.0,
            c if c == negative => -1.0,
            _ => return None,
        };
        let digits = &text[1..];
        let number = digits
            .bytes()
            .all(|b| b.is_ascii_digit())
            .then(|| digits.parse::<f64>().ok())??;
        let value = sign * number;
        // The corner of a whole degree inside of the map.
        (-most..most).contains(&value).then_some(value)
    };
    Some((
        degrees(longitude, 'E', 'W', 180.0)?,
        degrees(latitude, 'N', 'S', 90.0)?,
    ))
}

/// Opens a height file and finds or makes its pyramid.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(options.sample_facts().as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let bytes = Bytes::open(path).map_err(io)?;
    let Some((width, height)) = size_of(bytes.length()) else {
        let sides: Vec<String> = SIZES.iter().map(|(w, h)| format!("{w} × {h}")).collect();
        return Err(OpenError::Damaged {
            format: FORMAT,
            reason: format!(
                "expected two bytes for each of {} samples, found {} bytes",
                sides.join(", "),
                bytes.length()
            ),
            path: path.to_owned(),
        });
    };
    let refused = |reason: &str| OpenError::Options {
        reason: reason.into(),
        path: path.to_owned(),
    };
    if options.as_bands.is_some_and(|b| b != Bands::Height) {
        return Err(refused("expected use as heights, found use as colours"));
    }
    if options.select.as_ref().is_some_and(|s| s != &[0]) {
        return Err(refused("expected band 1, found another: the file has one"));
    }
    let own = position(path).map(|(west, south)| {
        let (dx, dy) = (1.0 / f64::from(width - 1), 1.0 / f64::from(height - 1));
        [west - 0.5 * dx, dx, 0.0, south + 1.0 + 0.5 * dy, 0.0, -dy]
    });
    if own.is_none() && options.georeference.is_none() {
        return Err(OpenError::Unsupported {
            format: FORMAT,
            reason: "expected a name that begins with the south-western corner, such as \
                     N41E001.hgt, or a given extent"
                .into(),
            path: path.to_owned(),
        });
    }
    let info = RasterInfo {
        path: path.to_owned(),
        format: FORMAT,
        overviews: vec![OverviewInfo { width, height }],
        bands: Bands::Height,
        band_count: 1,
        sample_type: "int16".into(),
        compression: "none".into(),
        deep_colour: false,
        nodata: Some(options.nodata.unwrap_or_else(|| f64::from(VOID))),
        may_have_holes: true,
        georeference: placed(own, Some("EPSG:4326".into()), options),
    };
    let file = Hgt {
        info,
        bytes,
        nodata: options.nodata,
        fingerprint,
    };
    pyramid::complete(Arc::new(file), false, fingerprint, options)
}

impl RasterFile for Hgt {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn fingerprint(&self) -> [u8; 32] {
        self.fingerprint
    }

    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        assert_inside(rect, self.info.overviews[overview]);
        if cancel.is_cancelled() {
            return Err(ReadError::Cancelled);
        }
        let width = rect.width as usize;
        out.reshape(Bands::Height, width, rect.height as usize);
        let mut row = vec![0; width * 2];
        let file_width = u64::from(self.info.overviews[0].width);
        for (y, samples) in out.plane_mut(0).chunks_exact_mut(width.max(1)).enumerate() {
            let first = (u64::from(rect.y) + y as u64) * file_width + u64::from(rect.x);
            self.bytes
                .read_at(first * 2, &mut row)
                .map_err(|e| ReadError::Io {
                    reason: e.to_string(),
                    path: self.info.path.clone(),
                })?;
            for (sample, bytes) in samples.iter_mut().zip(row.as_chunks::<2>().0) {
                let value = i16::from_be_bytes(*bytes);
                let hole = value == VOID || self.nodata == Some(f64::from(value));
                *sample = if hole { f32::NAN } else { f32::from(value) };
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::Georeference;

    fn plain() -> OpenOptions {
        OpenOptions {
            make_pyramid: false,
            ..OpenOptions::default()
        }
    }

    /// A file of 601 × 1201 samples whose value is column − row, with a void at (5, 7).
    fn file(folder: &Path, name: &str) -> std::path::PathBuf {
        let mut bytes = Vec::new();
        for y in 0..1201_i16 {
            for x in 0..601_i16 {
                let value = if (x, y) == (5, 7) { VOID } else { x - y };
                bytes.extend_from_slice(&value.to_be_bytes());
            }
        }
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    #[test]
    fn the_name_places_samples_as_points_on_the_edges_of_the_degree() {
        let folder = tempfile::tempdir().unwrap();
        let file = open(&file(folder.path(), "S09W070.hgt"), &plain()).unwrap();
        let place = file.info().georeference.clone().unwrap();
        assert_eq!(&*place.crs, "EPSG:4326");
        let [x, dx, _, y, _, dy] = place.plane_from_pixel;
        let first = (x + 0.5 * dx, y + 0.5 * dy);
        let last = (x + 600.5 * dx, y + 1200.5 * dy);
        assert!((first.0 + 70.0).abs() < 1e-12 && (first.1 + 8.0).abs() < 1e-12);
        assert!((last.0 + 69.0).abs() < 1e-12 && (last.1 + 9.0).abs() < 1e-12);
    }

    #[test]
    fn a_region_has_big_endian_metres_and_nan_for_the_void() {
        let folder = tempfile::tempdir().unwrap();
        let file = open(&file(folder.path(), "n60e010.hgt"), &plain()).unwrap();
        let rect = PixelRect {
            x: 4,
            y: 7,
            width: 3,
            height: 2,
        };
        let mut block = Block::new(Bands::Height, 0, 0);
        file.read(0, rect, &mut block, &Cancel::default()).unwrap();
        let h = block.plane(0);
        assert!(h[1].is_nan());
        assert_eq!(
            [h[0], h[2], h[3], h[4], h[5]],
            [-3.0, -1.0, -4.0, -3.0, -2.0]
        );
    }

    #[test]
    fn a_name_without_a_position_is_refused_unless_a_place_is_given() {
        let folder = tempfile::tempdir().unwrap();
        let path = file(folder.path(), "heights.hgt");
        let error = open(&path, &plain()).map(drop).unwrap_err().to_string();
        assert!(error.contains("N41E001.hgt"), "{error}");
        let given = OpenOptions {
            georeference: Some(Georeference {
                crs: "EPSG:4326".into(),
                plane_from_pixel: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0],
            }),
            ..plain()
        };
        assert!(open(&path, &given).is_ok());
    }

    #[test]
    fn names_say_corners_inside_of_the_map_only() {
        let at = |name: &str| position(Path::new(name));
        assert_eq!(at("N41E001.hgt"), Some((1.0, 41.0)));
        assert_eq!(at("s90w180.SRTMGL1.hgt"), Some((-180.0, -90.0)));
        for wrong in [
            "N90E000.hgt",
            "N00E180.hgt",
            "N4xE001.hgt",
            "N41E0011.hgt",
            "N+1E001.hgt",
            "N41",
            "Ñ41E001.hgt",
        ] {
            assert_eq!(at(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn any_other_length_is_refused_with_what_was_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("N00E000.hgt");
        for length in [0, 1, 2 * 1201 * 1201 - 1, 2 * 1201 * 1201 + 1] {
            std::fs::write(&path, vec![0; length]).unwrap();
            let error = open(&path, &plain()).map(drop).unwrap_err().to_string();
            assert!(error.contains(&format!("found {length} bytes")), "{error}");
        }
    }
}
