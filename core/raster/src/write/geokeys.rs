//! The tags by which a GeoTIFF says where it lies.
//!
//! Source: OGC 19-008r4, GeoTIFF 1.1.

use super::ifd::{Field, Value};
use crate::crs::Crs;

/// "Defined by the other keys of this file."
const USER_DEFINED: u16 = 32_767;

/// The number of that projection.
const AZIMUTHAL_EQUIDISTANT: u16 = 12;

/// Latitude and longitude in degrees of the centre of an azimuthal equidistant system in metres without
/// offsets; `None` for any other.
fn centre(definition: &str) -> Option<[f64; 2]> {
    let mut found = [0.0; 2];
    let mut is_named = false;
    for part in definition.split_whitespace() {
        let (name, value) = part.split_once('=').unwrap_or((part, ""));
        match name {
            "+proj" => is_named = value == "aeqd",
            "+lat_0" => found[0] = value.parse().ok()?,
            "+lon_0" => found[1] = value.parse().ok()?,
            "+x_0" | "+y_0" if value.parse() == Ok(0.0) => {}
            "+a" | "+b" | "+no_defs" => {}
            "+units" if value == "m" => {}
            _ => return None,
        }
    }
    is_named.then_some(found)
}

/// The fields for a georeference; the reason if its system cannot be told in keys.
pub(super) fn fields(crs: &Crs, plane_from_pixel: [f64; 6]) -> Result<Vec<Field>, String> {
    let [x0, xc, xr, y0, yc, yr] = plane_from_pixel;
    let mut fields = if xr == 0.0 && yc == 0.0 && xc > 0.0 && yr < 0.0 {
        vec![
            Field::new(33_550, Value::Double(vec![xc, -yr, 0.0])),
            Field::new(33_922, Value::Double(vec![0.0, 0.0, 0.0, x0, y0, 0.0])),
        ]
    } else {
        let matrix = [
            xc, xr, 0.0, x0, yc, yr, 0.0, y0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ];
        vec![Field::new(34_264, Value::Double(matrix.to_vec()))]
    };
    let definition = crs.definition();
    let (authority, code) = definition.split_once(':').unwrap_or(("", ""));
    let epsg = code
        .trim()
        .parse::<u16>()
        .ok()
        .filter(|_| authority.eq_ignore_ascii_case("EPSG"));
    // Keys: number, where (0 = here, else the tag), how many, value or index. Ascending.
    let mut doubles = Vec::new();
    let mut citation = String::new();
    let mut keys: Vec<[u16; 4]> = match (epsg, crs.is_geographic()) {
        (Some(code), true) => vec![[1024, 0, 1, 2], [1025, 0, 1, 1], [2048, 0, 1, code]],
        (Some(code), false) => vec![[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, code]],
        (None, true) => {
            let (a_m, b_m) = crs.radii_m();
            doubles.extend([a_m, b_m]);
            let name: String = definition
                .chars()
                .filter(|c| c.is_ascii() && *c != '|')
                .collect();
            citation = format!("{name}|");
            let length = citation.len().min(usize::from(u16::MAX)) as u16;
            vec![
                [1024, 0, 1, 2],
                [1025, 0, 1, 1],
                [2048, 0, 1, USER_DEFINED],
                [2049, 34_737, length, 0],
                [2050, 0, 1, USER_DEFINED],
                [2054, 0, 1, 9102],
                [2056, 0, 1, USER_DEFINED],
                [2057, 34_736, 1, 0],
                [2058, 34_736, 1, 1],
            ]
        }
        (None, false) if centre(definition).is_some() => {
            let [lat_deg, lon_deg] = centre(definition).unwrap_or_default();
            let (a_m, b_m) = crs.radii_m();
            doubles.extend([a_m, b_m, 0.0, 0.0, lon_deg, lat_deg]);
            vec![
                [1024, 0, 1, 1],
                [1025, 0, 1, 1],
                [2048, 0, 1, USER_DEFINED],
                [2050, 0, 1, USER_DEFINED],
                [2054, 0, 1, 9102],
                [2056, 0, 1, USER_DEFINED],
                [2057, 34_736, 1, 0],
                [2058, 34_736, 1, 1],
                [3072, 0, 1, USER_DEFINED],
                [3074, 0, 1, USER_DEFINED],
                [3075, 0, 1, AZIMUTHAL_EQUIDISTANT],
                [3076, 0, 1, 9001],
                [3082, 34_736, 1, 2],
                [3083, 34_736, 1, 3],
                [3088, 34_736, 1, 4],
                [3089, 34_736, 1, 5],
            ]
        }
        (None, false) => {
            return Err(format!(
                "expected a projected system with an EPSG code, or an azimuthal equidistant one in metres, found {definition:?}"
            ));
        }
    };
    keys.insert(0, [1, 1, 0, keys.len() as u16]);
    fields.push(Field::new(34_735, Value::Short(keys.concat())));
    if !doubles.is_empty() {
        fields.push(Field::new(34_736, Value::Double(doubles)));
    }
    if !citation.is_empty() {
        fields.push(Field::new(34_737, Value::Ascii(citation)));
    }
    Ok(fields)
}
