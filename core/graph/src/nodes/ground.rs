//! Where samples lie on the ground, for nodes that measure in metres.

use glam::{DVec2, I64Vec2};
use relievo_planet::{GridCrs, Lattice, MapPoint, Planet};
use relievo_raster::crs::Crs;

use crate::RenderError;

/// A lattice whose samples can be found on the planet.
pub(crate) struct Ground<'a> {
    lattice: &'a Lattice,
    crs: Option<Crs>,
}

impl<'a> Ground<'a> {
    /// `node` is the kind that an error names.
    pub(crate) fn new(lattice: &'a Lattice, node: &'static str) -> Result<Self, RenderError> {
        let crs = match &lattice.crs {
            GridCrs::Map => None,
            GridCrs::Projected(name) => {
                let crs = Crs::parse(name);
                Some(crs.map_err(|error| RenderError::Node {
                    node,
                    reason: error.to_string(),
                })?)
            }
        };
        Ok(Self { lattice, crs })
    }

    /// The place of a sample, columns and rows counted continuously; `None` where the plane shows
    /// no place.
    pub(crate) fn point(&self, sample: DVec2) -> Option<MapPoint> {
        let plane = self.lattice.origin + sample * self.lattice.step;
        match &self.crs {
            None => Some(MapPoint::new(plane.x, plane.y).normalised()),
            Some(crs) => {
                let (lon_rad, lat_rad) = crs.to_lonlat(plane.x, plane.y).ok()?;
                Some(MapPoint::new(
                    lon_rad,
                    core::f64::consts::FRAC_PI_2 - lat_rad,
                ))
            }
        }
    }

    /// Size of a sample in radians, where the plane is the map.
    pub(crate) fn map_step(&self) -> Option<DVec2> {
        self.crs.is_none().then_some(self.lattice.step)
    }

    /// Metres east and north on the ellipsoid from a sample to the next column, and to the next
    /// row, averaged over both sides; `None` where the plane shows no place.
    pub(crate) fn steps_m(&self, planet: &Planet, sample: I64Vec2) -> Option<[DVec2; 2]> {
        let centre = sample.as_dvec2() + 0.5;
        let here = self.point(centre)?;
        let mut steps = [DVec2::ZERO; 2];
        for (step, axis) in steps.iter_mut().zip([DVec2::X, DVec2::Y]) {
            let after = self.point(centre + 0.5 * axis)?;
            let before = self.point(centre - 0.5 * axis)?;
            *step = planet.offset_m(here, after) - planet.offset_m(here, before);
        }
        Some(steps)
    }
}
