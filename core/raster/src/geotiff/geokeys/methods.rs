//! User-defined projections: methods and their parameters as proj strings.

use super::GeoKeys;
use crate::geotiff::fault::{Fault, unsupported};

/// Number of the key that holds the method.
const METHOD: u16 = 3075;

/// A parameter: name in proj strings, and the keys that may hold it, best first.
type Parameter = (&'static str, &'static [u16]);

// Origins come under three names (natural, false, centre), and files mix them up.
const LAT_0: Parameter = ("lat_0", &[3081, 3085, 3089]);
const LON_0: Parameter = ("lon_0", &[3080, 3084, 3088, 3095]);
const LON_C: Parameter = ("lonc", &[3088, 3080, 3084]);
const POLE_LON: Parameter = ("lon_0", &[3095, 3080, 3088]);
const LAT_1: Parameter = ("lat_1", &[3078]);
const LAT_2: Parameter = ("lat_2", &[3079]);
const LAT_TS: Parameter = ("lat_ts", &[3078]);
const AZIMUTH: Parameter = ("alpha", &[3094]);
const SCALE: &[u16] = &[3092, 3093];
const EASTING: &[u16] = &[3082, 3086, 3090];
const NORTHING: &[u16] = &[3083, 3087, 3091];

/// The method and parameters of a user-defined projection, as the start of a proj string.
pub(super) fn projection(keys: &GeoKeys, unit_m: f64, unit_deg: f64) -> Result<String, Fault> {
    let Some(method) = keys.short(METHOD) else {
        return unsupported("expected a projection by code or method, found neither");
    };
    let latitude = |parameter: Parameter| first(keys, parameter.1);
    let (name, angles): (&str, &[Parameter]) = match method {
        1 => ("tmerc", &[LAT_0, LON_0]),
        3 => ("omerc", &[LAT_0, LON_C, AZIMUTH]),
        7 => ("merc", &[LON_0, LAT_TS]),
        8 => ("lcc", &[LAT_0, LON_0, LAT_1, LAT_2]),
        9 => ("lcc", &[LAT_0, LON_0]),
        10 => ("laea", &[LAT_0, LON_0]),
        11 => ("aea", &[LAT_0, LON_0, LAT_1, LAT_2]),
        12 => ("aeqd", &[LAT_0, LON_0]),
        13 => ("eqdc", &[LAT_0, LON_0, LAT_1, LAT_2]),
        14 => ("stere", &[LAT_0, LON_0]),
        15 => ("stere", &[POLE_LON]),
        16 => ("sterea", &[LAT_0, LON_0]),
        17 => ("eqc", &[LAT_0, LON_0, LAT_TS]),
        18 => ("cass", &[LAT_0, LON_0]),
        19 => ("gnom", &[LAT_0, LON_0]),
        20 => ("mill", &[LON_0]),
        21 => ("ortho", &[LAT_0, LON_0]),
        22 => ("poly", &[LAT_0, LON_0]),
        23 => ("robin", &[LON_0]),
        24 => ("sinu", &[LON_0]),
        28 => ("cea", &[LON_0, LAT_TS]),
        other => {
            return unsupported(format!(
                "expected a projection method that is known here, found number {other}"
            ));
        }
    };
    let mut parts = vec![format!("+proj={name}")];
    for parameter in angles {
        if let Some(value) = first(keys, parameter.1) {
            parts.push(format!("+{}={}", parameter.0, value * unit_deg));
        }
    }
    match method {
        // One standard parallel: it is the latitude of origin.
        9 => parts.extend(latitude(LAT_0).map(|lat| format!("+lat_1={}", lat * unit_deg))),
        // The key holds the latitude of true scale; with a scale factor it is the pole itself.
        15 => {
            let lat_deg = latitude(LAT_0).unwrap_or(90.0) * unit_deg;
            parts.push(format!("+lat_0={}", if lat_deg < 0.0 { -90 } else { 90 }));
            if lat_deg.abs() < 90.0 {
                parts.push(format!("+lat_ts={lat_deg}"));
            }
        }
        _ => {}
    }
    if let Some(scale) = first(keys, SCALE).filter(|k| *k > 0.0) {
        parts.push(format!("+k_0={scale}"));
    }
    for (name, ids) in [("x_0", EASTING), ("y_0", NORTHING)] {
        parts.push(format!(
            "+{name}={}",
            first(keys, ids).unwrap_or(0.0) * unit_m
        ));
    }
    Ok(parts.join(" "))
}

fn first(keys: &GeoKeys, ids: &[u16]) -> Option<f64> {
    ids.iter().find_map(|id| keys.double(*id))
}
