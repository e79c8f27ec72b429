//! Places, distances and pictures: from where and how one may look.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DMat4, DVec3, Vec3, Vec4};
use relievo_engine::planet::camera::near_plane_m;
use relievo_engine::planet::clipmap::view::FocusFrame as Axes;
use relievo_engine::planet::transform::forms::{Form, LEVELS, ring_radius_rad, worst_error_rad};
use relievo_engine::planet::transform::{FocusFrame, RingVertex, displaced_f32};
use relievo_engine::planet::{Camera, MapPoint, Planet};

use super::{Case, Extent, Found, worst};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "poles, exactly and 1 mm away: map transform in single precision",
        truth: "the vertex turned by vectors in f64",
        unit: "parts of the ring's radius",
        limit: 6e-7,
        degrades: "no worse than elsewhere; the longitude at the pole itself is any",
        measure: poles,
    },
    Case {
        name: "antimeridian: the same vertices from longitude +180° and −180°",
        truth: "each other, as places",
        unit: "m on Earth",
        limit: 1e-8,
        degrades: "not at all",
        measure: antimeridian,
    },
    Case {
        name: "altitudes of 1 m to 10⁸ m: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.02,
        degrades: "single precision of the mesh: the same at every altitude",
        measure: altitudes,
    },
    Case {
        name: "planets of 1 km to 70 000 km: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.02,
        degrades: "not at all",
        measure: planets,
    },
    Case {
        name: "field of view of 1° to 170°: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.2,
        degrades: "grows as pixels shrink: 1° on 960 rows has pixels of 18 millionths of a radian",
        measure: fields_of_view,
    },
    Case {
        name: "windows of 1 × 1 to 16384 pixels: ground on the screen",
        truth: "projection in f64",
        unit: "pixels",
        limit: 0.2,
        degrades: "grows with the number of pixels; larger pictures than the device holds are refused",
        measure: windows,
    },
];

fn poles(extent: Extent) -> Found {
    let millimetre = 1e-3 / Planet::EARTH.radius_m;
    let of = |form| {
        let each = [0.0, millimetre, PI - millimetre, PI]
            .into_iter()
            .flat_map(|colat| {
                LEVELS.map(move |level| {
                    worst_error_rad(form, level, colat, extent.pick(64, 4000))
                        / ring_radius_rad(level)
                })
            });
        worst(each)
    };
    Found {
        worst: of(Form::CancellationFreePoly),
        plain: Some(of(Form::ALL[0])),
    }
}

fn antimeridian(extent: Extent) -> Found {
    let count = extent.pick(500, 20_000);
    let errors = (0..count).map(|k| {
        let k = f64::from(k);
        let colat = PI * (k * 0.618_034).fract();
        let vertex =
            RingVertex::from_polar(2.0 * libm::exp2(-24.0 * (k * 0.754_878).fract()), k * 2.399);
        let [east, west] =
            [PI, -PI].map(|lon| FocusFrame::new(MapPoint::new(lon, colat)).map_point(vertex));
        east.angle_to(west) * Planet::EARTH.radius_m
    });
    Found::only(worst(errors))
}

/// A picture and the eye it is seen by.
#[derive(Clone, Copy)]
pub(super) struct Shot {
    pub(super) planet: Planet,
    pub(super) camera: Camera,
    pub(super) size_px: [u32; 2],
    /// Drawn height of the ground below the eye, metres.
    pub(super) ground_m: f64,
}

impl Shot {
    /// On Earth from an altitude, 30° downward, 60° wide, 1280 × 960.
    pub(super) fn from(altitude_m: f64) -> Self {
        Self {
            planet: Planet::EARTH,
            camera: Camera {
                lon_rad: 0.2,
                lat_rad: 0.8,
                altitude_m,
                heading_rad: 0.5,
                pitch_rad: -0.5,
                fov_y_rad: PI / 3.0,
            },
            size_px: [1280, 960],
            ground_m: 0.0,
        }
    }

    /// Worst error in pixels of vertices on the screen as the device places them: rings around a focus
    /// near the eye, lifted by `rise_m` of distance (in heights of the eye) and azimuth over the ground
    /// below the eye. `None` where none of them is on the screen.
    pub(super) fn screen_error_px(
        &self,
        samples: u32,
        rise_m: impl Fn(f64, f64) -> f64,
        displace: impl Fn(Lifted) -> Vec3,
    ) -> Option<f64> {
        let Self {
            planet,
            camera,
            size_px,
            ground_m,
        } = *self;
        let height_m = camera.altitude_m - ground_m;
        let nadir = camera.map_point();
        let ahead = (height_m / planet.radius_m).min(0.5);
        let frame = Axes::at(nadir);
        let focus = MapPoint::from_direction(frame.direction(ahead, PI - camera.heading_rad));
        let axes = Axes::at(focus);
        let world_from_focus = DMat3::from_cols(axes.south, axes.east, axes.up);
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        let clip_from_world = camera.view_projection(&planet, aspect, near_plane_m(height_m));
        let clip_from_focus = clip_from_world * DMat4::from_mat3(world_from_focus);
        let single = clip_from_focus.as_mat4();
        let eye = world_from_focus.transpose() * camera.eye(&planet);
        let half_px = glam::DVec2::new(f64::from(size_px[0]), f64::from(size_px[1])) * 0.5;
        let largest = (planet.horizon_angle_rad(height_m) + ahead).min(PI);
        let mut worst_px: Option<f64> = None;
        for k in 0..samples {
            let k = f64::from(k);
            let angle = largest * libm::exp2(-20.0 * (k * 0.754_878).fract());
            let azimuth = TAU * (k * 0.618_034).fract();
            let stored = RingVertex::from_polar(angle, azimuth).to_f32();
            let rise = rise_m(angle * planet.radius_m / height_m, azimuth);
            let [u, v, one_minus_w] = stored.map(f64::from);
            let radius = planet.radius_m + ground_m + rise;
            let exact = DVec3::new(
                radius * u - eye.x,
                radius * v - eye.y,
                (planet.radius_m + ground_m - eye.z) + rise - radius * one_minus_w,
            );
            let truth = clip_from_focus * exact.extend(1.0);
            let place = truth.truncate().truncate() / truth.w;
            if truth.w <= 0.0 || place.abs().max_element() > 1.0 {
                continue;
            }
            let lifted = Lifted {
                stored,
                radius_m: planet.radius_m,
                ground_m,
                rise_m: rise,
                eye,
            };
            let found: Vec4 = single * displace(lifted).extend(1.0);
            let found = found.as_dvec4();
            let off = (found.truncate().truncate() / found.w - place) * half_px;
            worst_px = Some(super::worse(worst_px.unwrap_or(0.0), off.length()));
        }
        worst_px
    }
}

/// A vertex and how high it is to be lifted.
#[derive(Clone, Copy)]
pub(super) struct Lifted {
    pub(super) stored: [f32; 3],
    pub(super) radius_m: f64,
    /// Drawn height below the eye.
    pub(super) ground_m: f64,
    /// Over that.
    pub(super) rise_m: f64,
    /// From the planet's centre along the focus' axes.
    pub(super) eye: DVec3,
}

impl Lifted {
    /// As the device does it.
    pub(super) fn relative(self) -> Vec3 {
        let from_eye = DVec3::new(0.0, 0.0, self.radius_m + self.ground_m) - self.eye;
        displaced_f32(
            self.stored,
            self.radius_m as f32,
            self.rise_m as f32,
            self.ground_m as f32,
            from_eye.as_vec3(),
        )
    }

    /// With the whole height in single precision.
    pub(super) fn absolute(self) -> Vec3 {
        let from_eye = DVec3::new(0.0, 0.0, self.radius_m) - self.eye;
        let height_m = (self.ground_m + self.rise_m) as f32;
        displaced_f32(
            self.stored,
            self.radius_m as f32,
            height_m,
            0.0,
            from_eye.as_vec3(),
        )
    }
}

fn on_screen(shots: impl IntoIterator<Item = Shot>, extent: Extent) -> Found {
    let samples = extent.pick(200, 4000);
    let errors = shots
        .into_iter()
        .filter_map(|shot| shot.screen_error_px(samples, |_, _| 0.0, Lifted::relative));
    // Nothing on any screen measures nothing.
    Found::only(errors.reduce(super::worse).unwrap_or(f64::NAN))
}

fn altitudes(extent: Extent) -> Found {
    let shots = (0..=8).flat_map(|decade| {
        [-FRAC_PI_2, -0.9, -0.2].map(|pitch_rad| {
            let mut shot = Shot::from(libm::exp10(f64::from(decade)));
            shot.camera.pitch_rad = pitch_rad;
            shot
        })
    });
    on_screen(shots, extent)
}

fn planets(extent: Extent) -> Found {
    let shots = [1e3, 1e5, 1e7, 7e7].into_iter().flat_map(|radius_m| {
        [1.0, 30.0, 1e3, 1e6, 1e8].map(|altitude_m| {
            let mut shot = Shot::from(altitude_m);
            shot.planet = Planet::sphere(radius_m);
            shot.camera.pitch_rad = -FRAC_PI_2;
            shot
        })
    });
    on_screen(shots, extent)
}

fn fields_of_view(extent: Extent) -> Found {
    let shots = [1.0, 5.0, 60.0, 120.0, 170.0_f64]
        .into_iter()
        .flat_map(|degrees| {
            [2.0, 5e3, 1e7].map(|altitude_m| {
                let mut shot = Shot::from(altitude_m);
                shot.camera.fov_y_rad = degrees.to_radians();
                shot.camera.pitch_rad = -FRAC_PI_2;
                shot
            })
        });
    on_screen(shots, extent)
}

fn windows(extent: Extent) -> Found {
    let sizes = [[1, 1], [16384, 1], [1, 16384], [640, 480], [16384, 16384]];
    let shots = sizes.into_iter().flat_map(|size_px| {
        [2.0, 5e3, 1e7].map(|altitude_m| {
            let mut shot = Shot::from(altitude_m);
            shot.size_px = size_px;
            shot.camera.pitch_rad = -1.2;
            shot
        })
    });
    on_screen(shots, extent)
}
