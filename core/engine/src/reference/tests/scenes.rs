//! Grounds from formulas, and what looks at them.

use glam::{DVec3, I64Vec2};
use relievo_planet::{Camera, Grid};
use relievo_raster::{Bands, Cancel};

use super::*;

pub(super) const RADIUS_M: f64 = 6_371_008.8;

/// Heights from a formula over the unit vector of a place; colours are stripes.
pub(super) struct Formula {
    height: Box<dyn Fn(DVec3) -> f64 + Sync>,
    finest: u8,
}

impl Formula {
    pub(super) fn new(finest: u8, height: impl Fn(DVec3) -> f64 + Sync + 'static) -> Self {
        Self {
            height: Box::new(height),
            finest,
        }
    }

    pub(super) fn level(height_m: f64) -> Self {
        Self::new(10, move |_| height_m)
    }

    /// Hills of 400 m and half a kilometre to 6 km.
    pub(super) fn hills(finest: u8) -> Self {
        Self::new(finest, |up| {
            let p = up * RADIUS_M;
            let wave = |along: DVec3, length_m: f64| {
                libm::sin(core::f64::consts::TAU * p.dot(along.normalize()) / length_m)
            };
            900.0
                + 300.0 * wave(DVec3::new(1.0, 0.3, 0.2), 6100.0)
                + 80.0 * wave(DVec3::new(-0.4, 1.0, 0.1), 1700.0)
                + 20.0 * wave(DVec3::new(0.2, -0.5, 1.0), 520.0)
        })
    }

    pub(super) fn times(self, factor: f64) -> Self {
        let height = self.height;
        Self::new(self.finest, move |up| factor * height(up))
    }

    pub(super) fn height_m(&self, up: DVec3) -> f64 {
        (self.height)(up)
    }
}

/// Unit vectors of a grid's samples, row by row.
fn places(grid: &Grid) -> impl Iterator<Item = DVec3> + '_ {
    let rect = grid.rect;
    (rect.min.y..rect.max.y)
        .flat_map(move |y| (rect.min.x..rect.max.x).map(move |x| I64Vec2::new(x, y)))
        .map(|at| grid.lattice.map_point(at).to_unit())
}

impl Field for Formula {
    fn heights(&self, grid: &Grid, cancel: &Cancel) -> Result<Vec<f32>, RenderError> {
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        Ok(places(grid).map(|up| self.height_m(up) as f32).collect())
    }

    fn colours(
        &self,
        grid: &Grid,
        _cancel: &Cancel,
    ) -> Result<Option<relievo_raster::Block>, RenderError> {
        let (width, height) = (grid.rect.width() as usize, grid.rect.height() as usize);
        let mut block = relievo_raster::Block::new(Bands::Colour, width, height);
        let [red, green, blue, alpha] = block.planes_mut();
        for (i, up) in places(grid).enumerate() {
            let stripe = 0.5 + 0.5 * libm::sin(up.z * RADIUS_M / 100.0) as f32;
            (red[i], green[i], blue[i], alpha[i]) = (stripe, 0.5, 1.0 - stripe, 1.0);
        }
        Ok(Some(block))
    }

    fn normals(
        &self,
        grid: &Grid,
        _cancel: &Cancel,
    ) -> Result<Option<relievo_raster::Block>, RenderError> {
        let (width, height) = (grid.rect.width() as usize, grid.rect.height() as usize);
        Ok(Some(relievo_raster::Block::new(
            Bands::Normal,
            width,
            height,
        )))
    }

    fn finest(&self) -> u8 {
        self.finest
    }
}

/// A camera over a place in degrees (longitude, latitude), heading and pitch in degrees.
pub(super) fn camera(place: (f64, f64), altitude_m: f64, heading: f64, pitch: f64) -> Camera {
    Camera::from_degrees(place.0, place.1, altitude_m, heading, pitch, 50.0).expect("a camera")
}

/// A sphere of Earth's size under a camera.
pub(super) fn stage(camera: Camera) -> Stage {
    Stage {
        planet: Planet::sphere(RADIUS_M),
        exaggeration: 1.0,
        camera,
        sun: Sun {
            direction_in_world: DVec3::new(0.6, 0.0, 0.8),
            ambient: 0.3,
        },
        air: 1.0,
    }
}

pub(super) fn settings(size_px: [u32; 2]) -> ReferenceSettings {
    ReferenceSettings::new(size_px, 2)
}

/// Where a ray meets a formula's surface, by steps of a metre at most and bisection; `None` within
/// `reach_m`.
pub(super) fn by_fine_steps(
    field: &Formula,
    eye: DVec3,
    direction: DVec3,
    reach_m: f64,
) -> Option<f64> {
    let clearance = |t: f64| {
        let p = eye + direction * t;
        p.length() - RADIUS_M - field.height_m(p.normalize())
    };
    let (mut above, mut t) = (0.0, 0.0);
    while t < reach_m {
        let gap = clearance(t);
        if gap <= 0.0 {
            let mut below = t;
            for _ in 0..50 {
                let middle = 0.5 * (above + below);
                if clearance(middle) > 0.0 {
                    above = middle;
                } else {
                    below = middle;
                }
            }
            return Some(below);
        }
        above = t;
        // The hills are nowhere steeper than 1 in 0.8.
        t += (gap * 0.5).max(0.5);
    }
    None
}
