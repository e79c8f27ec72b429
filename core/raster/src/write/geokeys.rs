//! The tags by which a GeoTIFF says where it lies.
//!
//! Source: OGC 19-008r4, GeoTIFF 1.1.

use super::ifd::{Field, Value};
use crate::crs::Crs;

/// "Defined by the other keys of this file."
const USER_DEFINED: u16 = 32_767;

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
        (None, false) => {
            return Err(format!(
                "expected a projected system with an EPSG code, found {definition:?}"
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
