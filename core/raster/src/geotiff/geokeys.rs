//! Geo keys: which coordinate system a GeoTIFF is in.
//!
//! Source: OGC GeoTIFF standard 1.1 (19-008r4), sections 7 and B; numbers of methods from the
//! GeoTIFF 1.0 specification, 6.3.3.3.

mod methods;

use core::fmt::Write;

use super::fault::{Fault, damaged, unsupported};
use super::ifd::{Ifd, TiffBytes, tag};
use crate::crs::planet_by_radii;

/// Numbers of keys.
mod key {
    pub(super) const MODEL_TYPE: u16 = 1024;
    pub(super) const RASTER_TYPE: u16 = 1025;
    pub(super) const CITATION: u16 = 1026;
    pub(super) const GEOGRAPHIC_TYPE: u16 = 2048;
    pub(super) const GEOGRAPHIC_CITATION: u16 = 2049;
    pub(super) const DATUM: u16 = 2050;
    pub(super) const ANGULAR_UNITS: u16 = 2054;
    pub(super) const ANGULAR_UNIT_SIZE: u16 = 2055;
    pub(super) const ELLIPSOID: u16 = 2056;
    pub(super) const SEMI_MAJOR_AXIS: u16 = 2057;
    pub(super) const SEMI_MINOR_AXIS: u16 = 2058;
    pub(super) const INVERSE_FLATTENING: u16 = 2059;
    pub(super) const PRIME_MERIDIAN_LONGITUDE: u16 = 2061;
    pub(super) const TO_WGS84: u16 = 2062;
    pub(super) const PROJECTED_TYPE: u16 = 3072;
    pub(super) const PROJECTION: u16 = 3074;
    pub(super) const LINEAR_UNITS: u16 = 3076;
    pub(super) const LINEAR_UNIT_SIZE: u16 = 3077;
    pub(super) const VERTICAL_UNITS: u16 = 4099;
}

/// Doubles of a key at most: seven are the most that any has.
const MOST_DOUBLES: usize = 16;
/// Bytes of a key's text at most that are looked at.
const LONGEST_TEXT: usize = 200;

/// "User-defined" as the value of a code.
const USER_DEFINED: u16 = 32767;

/// The keys of a file.
#[derive(Debug, Default)]
pub(crate) struct GeoKeys {
    shorts: Vec<(u16, u16)>,
    doubles: Vec<(u16, Vec<f64>)>,
    texts: Vec<(u16, String)>,
}

impl GeoKeys {
    /// Reads the keys; a file without any has none.
    pub(crate) fn read(file: &TiffBytes, ifd: &Ifd) -> Result<Self, Fault> {
        let directory = file.unsigned_vec(ifd, tag::GEO_KEY_DIRECTORY, 4096)?;
        let doubles = file.f64_vec(ifd, tag::GEO_DOUBLE_PARAMS, 4096)?;
        let texts = file
            .byte_vec(ifd, tag::GEO_ASCII_PARAMS, 1 << 16)?
            .unwrap_or_default();
        let mut keys = Self::default();
        let Some((head, entries)) = directory.split_at_checked(4) else {
            return Ok(keys);
        };
        for entry in entries.chunks_exact(4).take(head[3] as usize) {
            let (id, count, value) = (entry[0] as u16, entry[2] as usize, entry[3]);
            // No key needs many values, and many keys that share the same long ones would add up.
            let count = match entry[1] {
                n if n == u64::from(tag::GEO_DOUBLE_PARAMS) => count.min(MOST_DOUBLES),
                _ => count.min(LONGEST_TEXT),
            };
            let range = value as usize..(value as usize).saturating_add(count);
            match entry[1] {
                0 => keys.shorts.push((id, value as u16)),
                n if n == u64::from(tag::GEO_DOUBLE_PARAMS) => match doubles.get(range) {
                    Some(values) => keys.doubles.push((id, values.to_vec())),
                    None => {
                        return damaged(format!(
                            "expected {count} doubles for geo key {id}, found fewer"
                        ));
                    }
                },
                n if n == u64::from(tag::GEO_ASCII_PARAMS) => match texts.get(range) {
                    Some(bytes) => keys.texts.push((
                        id,
                        String::from_utf8_lossy(bytes)
                            .trim_end_matches(['|', '\0'])
                            .replace(char::is_control, " "),
                    )),
                    None => {
                        return damaged(format!(
                            "expected {count} characters for geo key {id}, found fewer"
                        ));
                    }
                },
                _ => {}
            }
        }
        Ok(keys)
    }

    /// Whether positions of pixels mean their centres.
    pub(crate) fn pixel_is_point(&self) -> bool {
        self.short(key::RASTER_TYPE) == Some(2)
    }

    /// Metres in a unit of height; 1 where the file does not say.
    pub(crate) fn vertical_metres(&self) -> Option<f64> {
        self.short(key::VERTICAL_UNITS).and_then(linear_unit_m)
    }

    /// Factor that makes the file's plane coordinates degrees, in geographic systems.
    pub(crate) fn degrees_per_unit(&self) -> f64 {
        if self.model_type() == Some(2) {
            self.angular_unit_deg()
        } else {
            1.0
        }
    }

    /// The coordinate system as `EPSG:n`, `ESRI:n` or a proj string; `None` if the file names none.
    pub(crate) fn crs(&self) -> Result<Option<String>, Fault> {
        match self.model_type() {
            Some(1) => self.projected().map(Some),
            Some(2) => self.geographic().map(Some),
            Some(3) => unsupported(
                "expected a geographic or projected coordinate system, found a geocentric one",
            ),
            _ => Ok(None),
        }
    }

    /// The model type, or what the other keys imply.
    fn model_type(&self) -> Option<u16> {
        let implied = || {
            if self.short(key::PROJECTED_TYPE).is_some() {
                Some(1)
            } else {
                self.short(key::GEOGRAPHIC_TYPE).map(|_| 2)
            }
        };
        self.short(key::MODEL_TYPE)
            .filter(|n| matches!(n, 1..=3))
            .or_else(implied)
    }

    fn projected(&self) -> Result<String, Fault> {
        if let Some(name) = self.short(key::PROJECTED_TYPE).and_then(code) {
            return Ok(name);
        }
        let datum = self.datum()?;
        let unit_m = self.linear_unit_m();
        // Zones of UTM have numbers of their own among the projections.
        let mut proj = match self.short(key::PROJECTION) {
            Some(n @ 16001..=16060) => format!("+proj=utm +zone={}", n - 16000),
            Some(n @ 16101..=16160) => format!("+proj=utm +zone={} +south", n - 16100),
            _ => methods::projection(self, unit_m, self.angular_unit_deg())?,
        };
        proj.push(' ');
        proj.push_str(&datum);
        if unit_m == 1.0 {
            proj.push_str(" +units=m");
        } else {
            write!(proj, " +to_meter={unit_m}").ok();
        }
        proj.push_str(" +no_defs");
        Ok(proj)
    }

    fn geographic(&self) -> Result<String, Fault> {
        if let Some(name) = self.short(key::GEOGRAPHIC_TYPE).and_then(code) {
            return Ok(name);
        }
        if let Some((a_m, b_m)) = self.radii_m()
            && self.prime_meridian_deg() == 0.0
            && let Some(body) = planet_by_radii(a_m, b_m, &self.citations())
        {
            return Ok(format!("ESRI:{}", body.code));
        }
        Ok(format!("+proj=longlat {} +no_defs", self.datum()?))
    }

    /// Datum, ellipsoid and prime meridian as parts of a proj string.
    fn datum(&self) -> Result<String, Fault> {
        let mut parts = if let Some(known) = self.known_datum() {
            known
        } else if let Some((a_m, b_m)) = self.radii_m() {
            if a_m == b_m {
                format!("+R={a_m}")
            } else {
                format!("+a={a_m} +b={b_m}")
            }
        } else {
            return unsupported(format!(
                "expected a datum by code or an ellipsoid by its axes, found neither ({})",
                self.citations()
            ));
        };
        let pm_deg = self.prime_meridian_deg();
        if pm_deg != 0.0 && !parts.contains("+pm=") {
            write!(parts, " +pm={pm_deg}").ok();
        }
        let shift = self.doubles(key::TO_WGS84);
        if matches!(shift.len(), 3 | 7)
            && shift.iter().all(|v| v.is_finite())
            && !parts.contains("+datum=")
        {
            let numbers: Vec<String> = shift.iter().map(f64::to_string).collect();
            write!(parts, " +towgs84={}", numbers.join(",")).ok();
        }
        Ok(parts)
    }

    /// The datum by the code of a geographic system, of a datum or of an ellipsoid.
    fn known_datum(&self) -> Option<String> {
        let by_system = self
            .short(key::GEOGRAPHIC_TYPE)
            .filter(|n| *n != USER_DEFINED)
            .and_then(crs_definitions::from_code);
        if let Some(definition) = by_system {
            let parts = definition
                .proj4
                .split_whitespace()
                .filter(|p| !matches!(*p, "+no_defs" | "+type=crs") && !p.starts_with("+proj="));
            return Some(parts.collect::<Vec<_>>().join(" "));
        }
        let datum = match self.short(key::DATUM) {
            Some(6326) => Some("+datum=WGS84"),
            Some(6269) => Some("+datum=NAD83"),
            Some(6258) => Some("+ellps=GRS80 +towgs84=0,0,0,0,0,0,0"),
            _ => None,
        };
        let ellipsoid = match self.short(key::ELLIPSOID) {
            Some(7001) => Some("+ellps=airy"),
            Some(7003) => Some("+ellps=aust_SA"),
            Some(7004) => Some("+ellps=bessel"),
            Some(7008) => Some("+ellps=clrk66"),
            Some(7012) => Some("+ellps=clrk80"),
            Some(7019) => Some("+ellps=GRS80"),
            Some(7022) => Some("+ellps=intl"),
            Some(7024) => Some("+ellps=krass"),
            Some(7030) => Some("+ellps=WGS84"),
            Some(7043) => Some("+ellps=WGS72"),
            Some(7048) => Some("+R=6371000"),
            _ => None,
        };
        datum.or(ellipsoid).map(str::to_owned)
    }

    /// Semi-axes in metres, where the file gives them and they are possible.
    fn radii_m(&self) -> Option<(f64, f64)> {
        let a_m = self.double(key::SEMI_MAJOR_AXIS)?;
        let inverse = self.double(key::INVERSE_FLATTENING);
        let b_m = match (self.double(key::SEMI_MINOR_AXIS), inverse) {
            (Some(b_m), _) => b_m,
            (None, Some(f)) if f != 0.0 => a_m * (1.0 - 1.0 / f),
            _ => a_m,
        };
        let possible = |r: f64| r.is_finite() && r > 0.0;
        (possible(a_m) && possible(b_m)).then_some((a_m, b_m))
    }

    fn prime_meridian_deg(&self) -> f64 {
        self.double(key::PRIME_MERIDIAN_LONGITUDE)
            .map_or(0.0, |pm| pm * self.angular_unit_deg())
    }

    fn angular_unit_deg(&self) -> f64 {
        match self.short(key::ANGULAR_UNITS) {
            Some(9101) => 180.0 / core::f64::consts::PI,
            Some(9103) => 1.0 / 60.0,
            Some(9104) => 1.0 / 3600.0,
            Some(9105 | 9106) => 0.9,
            Some(USER_DEFINED) => self
                .double(key::ANGULAR_UNIT_SIZE)
                .filter(|v| *v > 0.0)
                .map_or(1.0, f64::to_degrees),
            _ => 1.0,
        }
    }

    fn linear_unit_m(&self) -> f64 {
        match self.short(key::LINEAR_UNITS) {
            Some(USER_DEFINED) => self
                .double(key::LINEAR_UNIT_SIZE)
                .filter(|v| v.is_finite() && *v > 0.0)
                .unwrap_or(1.0),
            Some(number) => linear_unit_m(number).unwrap_or(1.0),
            None => 1.0,
        }
    }

    fn citations(&self) -> String {
        let texts = [key::CITATION, key::GEOGRAPHIC_CITATION].into_iter();
        texts
            .filter_map(|id| self.texts.iter().find(|(key, _)| *key == id))
            .map(|(_, text)| text.as_str())
            .collect::<Vec<_>>()
            .join("; ")
    }

    fn short(&self, id: u16) -> Option<u16> {
        self.shorts
            .iter()
            .find(|(key, _)| *key == id)
            .map(|(_, value)| *value)
    }

    fn double(&self, id: u16) -> Option<f64> {
        self.doubles(id).first().copied().filter(|v| v.is_finite())
    }

    fn doubles(&self, id: u16) -> &[f64] {
        self.doubles
            .iter()
            .find(|(key, _)| *key == id)
            .map(|(_, values)| values.as_slice())
            .unwrap_or_default()
    }
}

/// An authority's name for a code, if it is one.
fn code(number: u16) -> Option<String> {
    match number {
        0 | USER_DEFINED => None,
        // EPSG ends at 32766; GeoTIFF gives the numbers above to ESRI and to privates.
        1..USER_DEFINED => Some(format!("EPSG:{number}")),
        _ => Some(format!("ESRI:{number}")),
    }
}

/// Metres in a unit by its EPSG code.
fn linear_unit_m(number: u16) -> Option<f64> {
    Some(match number {
        9001 => 1.0,
        9002 => 0.3048,
        9003 => 1200.0 / 3937.0,
        9005 => 0.304_797_265_4,
        9014 => 1.8288,
        9030 => 1852.0,
        9036 => 1000.0,
        9093 => 1609.344,
        _ => return None,
    })
}
