//! Cameras.

/// Where the viewer is and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Longitude below the eye, radians.
    pub lon_rad: f64,
    /// Latitude below the eye, radians, −π/2 to π/2.
    pub lat_rad: f64,
    /// Height of the eye above the sphere (the datum) in metres.
    pub altitude_m: f64,
    /// Direction of view clockwise from north, radians.
    pub heading_rad: f64,
    /// Elevation of the view direction: −π/2 looks down, 0 to the horizontal.
    pub pitch_rad: f64,
    /// Vertical field of view, radians.
    pub fov_y_rad: f64,
}
