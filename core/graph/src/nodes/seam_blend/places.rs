//! Where coarse samples lie, so near to each other that single precision will do.

use glam::{DVec3, I64Vec2};
use relievo_planet::{GridCrs, Lattice, Planet, SampleRect};

use super::super::ground::Ground;
use crate::RenderError;

/// Places of the samples of a rectangle in space, relative to its middle, in units of a length.
pub(super) struct Places<'a> {
    planet: &'a Planet,
    plane: Plane<'a>,
    /// Of the middle.
    origin: DVec3,
    unit_m: f64,
}

enum Plane<'a> {
    Map {
        lattice: &'a Lattice,
        rect: SampleRect,
        /// Sine and cosine of the longitude from the middle, column by column.
        columns: Vec<(f64, f64)>,
        /// Metres from the axis and above the equator, row by row.
        rows: Vec<(f64, f64)>,
    },
    Projected {
        ground: Ground<'a>,
        /// Metres from column to column and from row to row.
        steps_m: [f64; 2],
    },
}

impl<'a> Places<'a> {
    pub(super) fn new(
        planet: &'a Planet,
        lattice: &'a Lattice,
        rect: SampleRect,
        unit_m: f64,
    ) -> Result<Self, RenderError> {
        let middle = (rect.min + rect.max) / 2;
        let plane = if lattice.crs == GridCrs::Map {
            let columns = (rect.min.x..rect.max.x)
                .map(|x| libm::sincos((x - middle.x) as f64 * lattice.step.x))
                .collect();
            let rows = (rect.min.y..rect.max.y)
                .map(|y| meridian_m(planet, lattice.centre(I64Vec2::new(0, y)).y))
                .collect();
            Plane::Map {
                lattice,
                rect,
                columns,
                rows,
            }
        } else {
            let ground = Ground::new(lattice, super::KIND)?;
            let steps = ground.steps_m(planet, middle);
            Plane::Projected {
                steps_m: steps.map_or([1.0; 2], |steps| steps.map(glam::DVec2::length)),
                ground,
            }
        };
        let mut places = Self {
            planet,
            plane,
            origin: DVec3::ZERO,
            unit_m,
        };
        places.origin = places.in_space_m(middle).unwrap_or(DVec3::ZERO);
        Ok(places)
    }

    fn in_space_m(&self, sample: I64Vec2) -> Option<DVec3> {
        match &self.plane {
            Plane::Map {
                rect,
                columns,
                rows,
                ..
            } => {
                let at = sample - rect.min;
                let (sine, cosine) = columns[at.x as usize];
                let (from_axis, above) = rows[at.y as usize];
                Some(DVec3::new(from_axis * cosine, from_axis * sine, above))
            }
            Plane::Projected { ground, .. } => {
                let place = ground.point(sample.as_dvec2() + 0.5)?;
                let (from_axis, above) = meridian_m(self.planet, place.colat_rad);
                let (sine, cosine) = libm::sincos(place.lon_rad);
                let space = DVec3::new(from_axis * cosine, from_axis * sine, above);
                space.is_finite().then_some(space)
            }
        }
    }

    /// The place of a sample; `None` where the plane shows none.
    pub(super) fn at(&self, sample: I64Vec2) -> Option<[f32; 3]> {
        let from = (self.in_space_m(sample)? - self.origin) / self.unit_m;
        Some(from.to_array().map(|v| v as f32))
    }

    /// Units from column to column and from row to row at a sample.
    pub(super) fn steps(&self, sample: I64Vec2) -> [f32; 2] {
        let steps_m = match &self.plane {
            Plane::Map { lattice, .. } => {
                let radii_m = self.planet.metres_per_radian(lattice.centre(sample).y);
                (radii_m * lattice.step).abs().to_array()
            }
            Plane::Projected { steps_m, .. } => *steps_m,
        };
        steps_m.map(|step_m| (step_m / self.unit_m) as f32)
    }
}

/// Metres from the axis, and above the equator's plane, of the ellipsoid at a geodetic colatitude;
/// beyond a pole the distance from the axis is negative, which is the opposite meridian.
fn meridian_m(planet: &Planet, colat_rad: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(colat_rad);
    let e2 = planet.eccentricity_squared();
    let prime_vertical_m = planet.equatorial_radius_m / (1.0 - e2 * cosine * cosine).sqrt();
    (
        prime_vertical_m * sine,
        prime_vertical_m * (1.0 - e2) * cosine,
    )
}
