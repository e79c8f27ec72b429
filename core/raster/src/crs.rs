//! Coordinate reference systems: between plane coordinates of a file and longitude and latitude.

mod planets;

use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, LazyLock};

use proj4rs::Proj;
use proj4rs::transform::transform;

pub(crate) use planets::by_radii as planet_by_radii;

/// How far a point may move when it goes through a projection and back, as an angle in radians
/// (0.6 m on the Earth): more means that it lies outside of the projection's domain.
const ROUND_TRIP_RAD: f64 = 1e-7;

/// Slack beyond ±90° for rounding in files whose corners lie on a pole.
const POLE_SLACK_RAD: f64 = 1e-9;

/// Longitude and latitude on WGS 84: where a definition knows the way there.
static WGS84: LazyLock<Option<Proj>> =
    LazyLock::new(|| Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").ok());

/// Systems that ESRI numbers and EPSG does not, on the Earth, as PROJ 9's database defines them.
static ESRI: &[(u32, &str)] = &[
    (54001, "+proj=eqc +datum=WGS84 +units=m +no_defs"),
    (54008, "+proj=sinu +datum=WGS84 +units=m +no_defs"),
    (54009, "+proj=moll +datum=WGS84 +units=m +no_defs"),
    (54030, "+proj=robin +datum=WGS84 +units=m +no_defs"),
    (54034, "+proj=cea +datum=WGS84 +units=m +no_defs"),
    (
        102_003,
        "+proj=aea +lat_0=37.5 +lon_0=-96 +lat_1=29.5 +lat_2=45.5 +datum=NAD83 +units=m +no_defs",
    ),
    (
        102_008,
        "+proj=aea +lat_0=40 +lon_0=-96 +lat_1=20 +lat_2=60 +datum=NAD83 +units=m +no_defs",
    ),
    (
        102_020,
        "+proj=laea +lat_0=-90 +datum=WGS84 +units=m +no_defs",
    ),
    (
        102_100,
        "+proj=merc +a=6378137 +b=6378137 +units=m +nadgrids=@null +no_defs",
    ),
];

/// A coordinate reference system. Cheap to clone, shared by threads.
///
/// Plane coordinates are degrees (longitude, latitude) in geographic systems and lengths in the
/// system's own unit (see [`Crs::metres_per_unit`]) in projected ones; east and north are positive
/// whatever axis order an authority prefers.
///
/// Longitude and latitude are those of WGS 84 where the definition says how to get there (its
/// `towgs84`), else those of the system's own datum; on other bodies they pass as they are.
#[derive(Clone)]
pub struct Crs(Arc<System>);

struct System {
    name: Box<str>,
    /// Parts of the definition in a fixed order, to compare.
    canonical: Box<str>,
    proj: Proj,
    geographic: bool,
}

/// Why a definition is no system that can be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CrsError {
    /// The text is in none of the known forms.
    #[error(
        "expected a coordinate system as EPSG:n, ESRI:n or a proj string, found {definition:?}"
    )]
    Form {
        /// The text.
        definition: String,
    },
    /// An authority's number that is not known here.
    #[error("no coordinate system known as {definition}")]
    UnknownCode {
        /// The text.
        definition: String,
    },
    /// A definition with a projection, datum or parameter that is not supported.
    #[error("cannot use the coordinate system {definition:?}: {reason}")]
    Unsupported {
        /// The text.
        definition: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// A point has no counterpart: it lies outside of the projection's domain.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("({x}, {y}) lies outside of the coordinate system's domain")]
pub struct OutOfDomain {
    /// First coordinate as given.
    pub x: f64,
    /// Second coordinate as given.
    pub y: f64,
}

impl Crs {
    /// Reads `EPSG:n`, `ESRI:n` (planets, moons and a few systems of the Earth) or a proj string.
    ///
    /// # Errors
    /// [`CrsError`] where the text has another form, the number is unknown or the projection is
    /// not supported.
    pub fn parse(definition: &str) -> Result<Self, CrsError> {
        let name = definition.trim();
        let proj_string = if name.starts_with('+') {
            name.to_owned()
        } else if let Some((authority, code)) = name.split_once(':') {
            let Ok(code) = code.trim().parse::<u32>() else {
                return Err(form(name));
            };
            let found = match authority.trim().to_ascii_uppercase().as_str() {
                "EPSG" => u16::try_from(code)
                    .ok()
                    .and_then(crs_definitions::from_code)
                    .map(|def| def.proj4.to_owned()),
                "ESRI" => esri(code),
                _ => return Err(form(name)),
            };
            found.ok_or_else(|| CrsError::UnknownCode {
                definition: format!("{}:{code}", authority.trim().to_ascii_uppercase()),
            })?
        } else {
            return Err(form(name));
        };
        let unsupported = |reason: String| CrsError::Unsupported {
            definition: shown(name),
            reason: reason.replace(char::is_control, " "),
        };
        let proj = Proj::from_proj_string(&proj_string).map_err(|e| unsupported(e.to_string()))?;
        if proj.is_geocent() {
            return Err(unsupported(
                "expected a geographic or projected system, found a geocentric one".into(),
            ));
        }
        let (a_m, b_m) = proj.ellipse_parameters();
        if !(a_m.is_finite() && b_m.is_finite() && a_m > 0.0 && b_m > 0.0) {
            return Err(unsupported(format!(
                "expected positive radii, found {a_m} and {b_m} m"
            )));
        }
        let both_ways = proj.has_inverse() && proj.has_forward();
        if !(proj.is_latlong() || both_ways) {
            return Err(unsupported(format!(
                "the projection {} does not go both ways",
                proj.projname()
            )));
        }
        Ok(Self(Arc::new(System {
            name: name.into(),
            canonical: canonical(&proj_string).into(),
            geographic: proj.is_latlong(),
            proj,
        })))
    }

    /// The definition that it was made from.
    pub fn definition(&self) -> &str {
        &self.0.name
    }

    /// Whether plane coordinates are longitude and latitude in degrees.
    pub fn is_geographic(&self) -> bool {
        self.0.geographic
    }

    /// Length of a unit of plane coordinates in metres; 1 for geographic systems, whose unit is
    /// the degree.
    pub fn metres_per_unit(&self) -> f64 {
        if self.0.geographic {
            1.0
        } else {
            self.0.proj.to_meter()
        }
    }

    /// Equatorial and polar radius in metres.
    pub fn radii_m(&self) -> (f64, f64) {
        self.0.proj.ellipse_parameters()
    }

    /// Whether both give the same plane coordinates to the same places, as far as their
    /// definitions show.
    pub fn same_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.canonical == other.0.canonical
    }

    /// Longitude and latitude in radians of plane coordinates. Longitudes of geographic systems
    /// keep their turn (190° stays 190°) where there is no datum shift.
    ///
    /// # Errors
    /// [`OutOfDomain`] for points that no place on the body has, and for NaN and infinities.
    pub fn to_lonlat(&self, x: f64, y: f64) -> Result<(f64, f64), OutOfDomain> {
        let out = OutOfDomain { x, y };
        let (lon, lat) = if self.0.geographic {
            self.shift(x.to_radians(), y.to_radians(), true)
        } else {
            self.project(x, y, true)
        }
        .ok_or(out)?;
        if !(lon.is_finite() && lat.abs() <= FRAC_PI_2 + POLE_SLACK_RAD) {
            return Err(out);
        }
        let lat = lat.clamp(-FRAC_PI_2, FRAC_PI_2);
        if !self.0.geographic {
            // A point beside the map may come out as some place or other: it must lead back.
            let (x_back, y_back) = self.project(lon, lat, false).ok_or(out)?;
            let tolerance = ROUND_TRIP_RAD * self.radii_m().0 / self.metres_per_unit();
            if !((x_back - x).abs() <= tolerance && (y_back - y).abs() <= tolerance) {
                return Err(out);
            }
        }
        Ok((lon, lat))
    }

    /// Plane coordinates of a longitude and latitude in radians.
    ///
    /// # Errors
    /// [`OutOfDomain`] for places that the projection does not show, latitudes beyond the poles,
    /// NaN and infinities.
    pub fn from_lonlat(&self, lon_rad: f64, lat_rad: f64) -> Result<(f64, f64), OutOfDomain> {
        let out = OutOfDomain {
            x: lon_rad,
            y: lat_rad,
        };
        if !(lon_rad.is_finite() && lat_rad.abs() <= FRAC_PI_2 + POLE_SLACK_RAD) {
            return Err(out);
        }
        let lat = lat_rad.clamp(-FRAC_PI_2, FRAC_PI_2);
        if self.0.geographic {
            let (lon, lat) = self.shift(lon_rad, lat, false).ok_or(out)?;
            return Ok((lon.to_degrees(), lat.to_degrees()));
        }
        let lon = wrapped(lon_rad);
        let (x, y) = self.project(lon, lat, false).ok_or(out)?;
        let (lon_back, lat_back) = self.project(x, y, true).ok_or(out)?;
        // Meridians meet at the poles: a difference of longitudes counts as what it is on the ground.
        let across = wrapped(lon_back - lon) * libm::cos(lat);
        if !((lat_back - lat).abs() <= ROUND_TRIP_RAD && across.abs() <= ROUND_TRIP_RAD) {
            return Err(out);
        }
        Ok((x, y))
    }

    /// Between this datum and WGS 84, in radians; nothing happens where the way is not known.
    fn shift(&self, lon: f64, lat: f64, to_wgs84: bool) -> Option<(f64, f64)> {
        if !(lon.is_finite() && lat.is_finite() && lat.abs() <= FRAC_PI_2 + POLE_SLACK_RAD) {
            return None;
        }
        let wgs84 = WGS84.as_ref()?;
        // Datum shifts may normalise longitudes: the whole turns come back afterwards.
        let turn = if (-PI..=PI).contains(&lon) {
            0.0
        } else {
            lon - wrapped(lon)
        };
        let mut point = (lon - turn, lat.clamp(-FRAC_PI_2, FRAC_PI_2));
        if to_wgs84 {
            transform(&self.0.proj, wgs84, &mut point).ok()?;
        } else {
            transform(wgs84, &self.0.proj, &mut point).ok()?;
        }
        (point.0.is_finite() && point.1.is_finite()).then_some((point.0 + turn, point.1))
    }

    /// Through the projection, either way.
    fn project(&self, x: f64, y: f64, to_lonlat: bool) -> Option<(f64, f64)> {
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let wgs84 = WGS84.as_ref()?;
        let mut point = (x, y);
        if to_lonlat {
            transform(&self.0.proj, wgs84, &mut point).ok()?;
        } else {
            transform(wgs84, &self.0.proj, &mut point).ok()?;
        }
        (point.0.is_finite() && point.1.is_finite()).then_some(point)
    }
}

impl core::fmt::Debug for Crs {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Crs").field(&self.0.name).finish()
    }
}

/// The system that Well-Known Text (of OGC, ESRI or ISO 19162) or an old `.prj` means, as a definition
/// for [`Crs::parse`]; `None` where that is not known here.
pub fn from_wkt(text: &str) -> Option<String> {
    crate::prj::name_of(text)
}

/// The system that a file's `.prj` companion names, as [`from_wkt`] reads it; `None` where there is
/// none or it is not known.
pub fn from_prj_beside(file: &std::path::Path) -> Option<String> {
    crate::prj::beside(file)
}

fn form(definition: &str) -> CrsError {
    CrsError::Form {
        definition: shown(definition),
    }
}

/// The part of a definition that an error shows.
fn shown(definition: &str) -> String {
    const LONGEST: usize = 300;
    match definition.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &definition[..end]),
        None => definition.to_owned(),
    }
}

fn esri(code: u32) -> Option<String> {
    if let Some(body) = planets::by_code(code) {
        return Some(format!(
            "+proj=longlat +a={} +b={} +no_defs",
            body.a_m,
            body.b_m()
        ));
    }
    ESRI.iter()
        .find(|(number, _)| *number == code)
        .map(|(_, proj)| (*proj).to_owned())
}

/// The parts of a proj string that matter, sorted.
fn canonical(proj_string: &str) -> String {
    let mut parts: Vec<&str> = proj_string
        .split_whitespace()
        .filter(|part| {
            !matches!(
                *part,
                "+no_defs"
                    | "+type=crs"
                    | "+wktext"
                    | "+units=m"
                    | "+x_0=0"
                    | "+y_0=0"
                    | "+k=1"
                    | "+lon_0=0"
            )
        })
        .map(|part| match part {
            "+proj=latlong" | "+proj=lonlat" | "+proj=latlon" => "+proj=longlat",
            other => other,
        })
        .collect();
    parts.sort_unstable();
    parts.join(" ")
}

fn wrapped(lon_rad: f64) -> f64 {
    if (-PI..=PI).contains(&lon_rad) {
        lon_rad
    } else {
        relievo_planet::map::wrap_longitude(lon_rad)
    }
}
