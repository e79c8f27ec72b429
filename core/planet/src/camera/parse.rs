//! Cameras from what users write: degrees and metres, checked.

use core::str::FromStr;

use super::{Camera, DEFAULT_FOV_Y_RAD, MAX_ALTITUDE_M, wrap_heading};
use crate::map::wrap_longitude;

/// Deepest altitude that a camera may be asked for, metres below the datum.
const MIN_ALTITUDE_M: f64 = -1e5;

/// Why a camera is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraError {
    /// The text has the wrong number of fields.
    Fields(usize),
    /// A field is no number.
    Number {
        /// Which field.
        field: &'static str,
        /// What was found.
        found: String,
    },
    /// A value is out of its range.
    Range {
        /// Which field.
        field: &'static str,
        /// What was expected, with its unit.
        expected: &'static str,
        /// What was found.
        found: f64,
    },
}

impl core::fmt::Display for CameraError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Fields(found) => write!(
                f,
                "a camera is LON,LAT,ALT or LON,LAT,ALT,HEADING,PITCH, this one has {found} fields"
            ),
            Self::Number { field, found } => {
                write!(f, "the camera's {field} is a number, this one is {found:?}")
            }
            Self::Range {
                field,
                expected,
                found,
            } => {
                write!(f, "the camera's {field} is {expected}, this one is {found}")
            }
        }
    }
}

impl core::error::Error for CameraError {}

impl Camera {
    /// A camera from degrees and metres, checked.
    ///
    /// - `lon_deg`: −360 to 360, east; `lat_deg`: −90 to 90; `altitude_m`: −10⁵ to 10⁸ above the
    ///   datum.
    /// - `heading_deg`: clockwise from north, −360 to 360; `pitch_deg`: −90 (down) to 89;
    ///   `fov_y_deg`: vertical, 0.1 to 170.
    ///
    /// # Errors
    /// If a value is not finite or out of its range; the message names it.
    pub fn from_degrees(
        lon_deg: f64,
        lat_deg: f64,
        altitude_m: f64,
        heading_deg: f64,
        pitch_deg: f64,
        fov_y_deg: f64,
    ) -> Result<Self, CameraError> {
        check("longitude", "-360 to 360 degrees", lon_deg, -360.0, 360.0)?;
        check("latitude", "-90 to 90 degrees", lat_deg, -90.0, 90.0)?;
        check(
            "altitude",
            "-1e5 to 1e8 metres",
            altitude_m,
            MIN_ALTITUDE_M,
            MAX_ALTITUDE_M,
        )?;
        check("heading", "-360 to 360 degrees", heading_deg, -360.0, 360.0)?;
        check("pitch", "-90 to 89 degrees", pitch_deg, -90.0, 89.0)?;
        check("field of view", "0.1 to 170 degrees", fov_y_deg, 0.1, 170.0)?;
        let lon_rad = lon_deg.to_radians();
        Ok(Self {
            lon_rad: if lon_deg.abs() <= 180.0 {
                lon_rad
            } else {
                wrap_longitude(lon_rad)
            },
            lat_rad: lat_deg.to_radians(),
            altitude_m,
            heading_rad: wrap_heading(heading_deg.to_radians()),
            pitch_rad: super::clamp_pitch(pitch_deg.to_radians()),
            fov_y_rad: fov_y_deg.to_radians(),
        })
    }
}

/// Whether `found` lies in `least..=greatest`, as an error that names the field otherwise.
fn check(
    field: &'static str,
    expected: &'static str,
    found: f64,
    least: f64,
    greatest: f64,
) -> Result<(), CameraError> {
    if (least..=greatest).contains(&found) {
        Ok(())
    } else {
        Err(CameraError::Range {
            field,
            expected,
            found,
        })
    }
}

impl FromStr for Camera {
    type Err = CameraError;

    /// Reads `LON,LAT,ALT[,HEADING,PITCH]` in degrees and metres; without heading and pitch it
    /// looks down with north up. The field of view is 60°.
    fn from_str(text: &str) -> Result<Self, CameraError> {
        const NAMES: [&str; 5] = ["longitude", "latitude", "altitude", "heading", "pitch"];
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        if fields.len() != 3 && fields.len() != 5 {
            return Err(CameraError::Fields(fields.len()));
        }
        let mut values = [0.0, 0.0, 0.0, 0.0, -90.0];
        for ((value, field), text) in values.iter_mut().zip(NAMES).zip(fields) {
            *value = text.parse().ok().ok_or_else(|| CameraError::Number {
                field,
                found: text.to_owned(),
            })?;
        }
        let [lon, lat, altitude, heading, pitch] = values;
        Self::from_degrees(
            lon,
            lat,
            altitude,
            heading,
            pitch,
            DEFAULT_FOV_Y_RAD.to_degrees(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_alone_looks_down_with_north_up() {
        let camera: Camera = "11.4, 46.5,12000".parse().expect("three numbers");
        assert_eq!(camera.pitch_rad, -core::f64::consts::FRAC_PI_2);
        assert!((camera.heading_rad, camera.altitude_m) == (0.0, 12_000.0));
        assert!((camera.fov_y_rad.to_degrees() - 60.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_with_a_camera_is_said_in_one_line() {
        for (text, part) in [
            ("1,2", "2 fields"),
            ("1,2,3,4", "4 fields"),
            ("1,x,3", "latitude is a number, this one is \"x\""),
            ("1,91,3", "latitude is -90 to 90 degrees, this one is 91"),
            ("1,nan,3", "latitude"),
            ("1,2,inf", "altitude"),
            ("1,2,3,0,90", "pitch"),
            ("", "fields"),
        ] {
            let message = text.parse::<Camera>().expect_err(text).to_string();
            assert!(
                message.contains(part) && !message.contains('\n'),
                "{message}"
            );
        }
    }
}
