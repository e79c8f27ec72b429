//! What planning needs of a camera: its axes, its frustum, and the frame of the ground below a point.

use glam::{DVec2, DVec3};

use crate::{Camera, MapPoint, Planet};

/// Axes of the local ground at a point of the map: x south, y east, z up, unit vectors in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FocusFrame {
    /// Towards the south pole: azimuth 0 of the mesh.
    pub south: DVec3,
    /// Towards the east: azimuth π/2 of the mesh.
    pub east: DVec3,
    /// Away from the planet's centre.
    pub up: DVec3,
}

impl FocusFrame {
    /// The frame at a point; defined at the poles too, where the longitude decides the azimuth.
    pub fn at(point: MapPoint) -> Self {
        let (sin_colat, cos_colat) = libm::sincos(point.colat_rad);
        let (sin_lon, cos_lon) = libm::sincos(point.lon_rad);
        Self {
            south: DVec3::new(cos_colat * cos_lon, cos_colat * sin_lon, -sin_colat),
            east: DVec3::new(-sin_lon, cos_lon, 0.0),
            up: DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat),
        }
    }

    /// Unit vector at `angle_rad` from the frame's point towards an azimuth (0 south, π/2 east).
    pub fn direction(&self, angle_rad: f64, azimuth_rad: f64) -> DVec3 {
        let (sin_angle, cos_angle) = libm::sincos(angle_rad);
        let (sin_azimuth, cos_azimuth) = libm::sincos(azimuth_rad);
        self.up * cos_angle + (self.south * cos_azimuth + self.east * sin_azimuth) * sin_angle
    }
}

/// A camera in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye, metres.
    pub eye: DVec3,
    /// Direction of view, unit.
    pub forward: DVec3,
    /// To the right of the picture, unit.
    pub right: DVec3,
    /// To the top of the picture, unit.
    pub up: DVec3,
    /// Tangents of half the horizontal and half the vertical field of view.
    pub tan_half: DVec2,
    /// Inward unit normals of the frustum's four sides, all of which pass through the eye.
    pub sides: [DVec3; 4],
}

impl View {
    /// The view of a camera onto a picture of the given size in pixels.
    pub fn new(camera: &Camera, planet: &Planet, viewport_px: [u32; 2]) -> Self {
        let nadir = MapPoint::new(
            camera.lon_rad,
            core::f64::consts::FRAC_PI_2 - camera.lat_rad,
        );
        let ground = FocusFrame::at(nadir);
        let (sin_heading, cos_heading) = libm::sincos(camera.heading_rad);
        let (sin_pitch, cos_pitch) = libm::sincos(camera.pitch_rad);
        let ahead = ground.east * sin_heading - ground.south * cos_heading;
        let forward = ahead * cos_pitch + ground.up * sin_pitch;
        let up = ground.up * cos_pitch - ahead * sin_pitch;
        let right = forward.cross(up);
        let aspect = f64::from(viewport_px[0].max(1)) / f64::from(viewport_px[1].max(1));
        let tan_y = libm::tan(0.5 * camera.fov_y_rad);
        let tan_half = DVec2::new(tan_y * aspect, tan_y);
        Self {
            eye: ground.up * (planet.radius_m + camera.altitude_m),
            forward,
            right,
            up,
            tan_half,
            sides: [
                (forward * tan_half.x - right).normalize(),
                (forward * tan_half.x + right).normalize(),
                (forward * tan_half.y - up).normalize(),
                (forward * tan_half.y + up).normalize(),
            ],
        }
    }

    /// Direction (not normalised) of a place in the picture, x and y from −1 to 1, y up.
    pub fn ray(&self, place: DVec2) -> DVec3 {
        let at = place * self.tan_half;
        self.forward + self.right * at.x + self.up * at.y
    }
}
