//! Where the pixels lie, as attributes say.
//!
//! `gdal:geoTransform` (m33d) is what GDAL writes and reads: rows `[dx/dcol, dx/drow, x0]` and
//! `[dy/dcol, dy/drow, y0]` for the outer corner of the data window's first pixel.
//! `relievo:crs` (string) is `EPSG:n`, `ESRI:n` or a proj string; without it `gdal:crsWkt` counts
//! where it names a known system.

use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::Header;

use crate::prj;

/// Attribute with the six numbers.
pub(crate) const TRANSFORM: &str = "gdal:geoTransform";
/// Its type.
pub(crate) const TRANSFORM_KIND: &str = "m33d";
/// Attribute with the system's name.
pub(crate) const CRS: &str = "relievo:crs";
/// Attribute with the system as Well-Known Text.
const CRS_WKT: &str = "gdal:crsWkt";

fn attribute<'a>(header: &'a Header, name: &str) -> Option<&'a AttributeValue> {
    let name = Text::new_or_none(name)?;
    let own = header.own_attributes.other.get(&name);
    own.or_else(|| header.shared_attributes.other.get(&name))
}

fn text(header: &Header, name: &str) -> Option<String> {
    if let AttributeValue::Text(text) = attribute(header, name)? {
        Some(text.to_string())
    } else {
        None
    }
}

/// `plane_from_pixel`, where the attribute is there and makes sense.
pub(super) fn affine(header: &Header) -> Option<[f64; 6]> {
    let AttributeValue::Custom { kind, bytes } = attribute(header, TRANSFORM)? else {
        return None;
    };
    if Some(kind) != Text::new_or_none(TRANSFORM_KIND).as_ref() || bytes.len() != 72 {
        return None;
    }
    let (numbers, _) = bytes.as_chunks::<8>();
    let n: Vec<f64> = numbers.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let affine = [n[2], n[0], n[1], n[5], n[3], n[4]];
    crate::geotiff::check_affine(&affine).ok()?;
    Some(affine)
}

/// The bytes of [`TRANSFORM`].
pub(crate) fn transform_bytes([x0, xx, xy, y0, yx, yy]: [f64; 6]) -> Vec<u8> {
    [xx, xy, x0, yx, yy, y0, 0.0, 0.0, 1.0]
        .into_iter()
        .flat_map(f64::to_le_bytes)
        .collect()
}

/// The name of the system.
pub(super) fn crs(header: &Header) -> Option<String> {
    text(header, CRS).or_else(|| prj::name_of(&text(header, CRS_WKT)?))
}
