//! Lattices and grids: where samples lie, as integers plus one affine map.

use std::sync::Arc;

use glam::{DVec2, I64Vec2};

use crate::{MapPoint, SampleRect};

/// In which plane a lattice is regular.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum GridCrs {
    /// The map: x = longitude, y = colatitude, radians.
    Map,
    /// A projected or other system, named as `relievo-raster` resolves it (`EPSG:26912`, a proj
    /// string): x = easting, y = northing in the system's own unit.
    Projected(Arc<str>),
}

/// A regular lattice of sample areas in a plane. Sample (i, j) has its centre at
/// `origin + (i + ½, j + ½) · step`.
///
/// Coordinates always come from these global indices, so that a block and the whole it was cut
/// from agree bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// The plane.
    pub crs: GridCrs,
    /// Outer corner of sample (0, 0), in units of the plane.
    pub origin: DVec2,
    /// Size of a sample along columns and rows; y is negative in a projected system where rows
    /// run south. Never zero.
    pub step: DVec2,
    /// Samples once around the planet where the lattice closes upon itself (tile levels do), so
    /// that columns wrap and rows reflect over the poles by index; `None` otherwise.
    pub columns_around: Option<i64>,
}

impl Lattice {
    /// Centre of sample (i, j) in units of the plane.
    pub fn centre(&self, sample: I64Vec2) -> DVec2 {
        self.origin + (sample.as_dvec2() + 0.5) * self.step
    }

    /// Centre of sample (i, j) of a lattice on the map, brought into range.
    pub fn map_point(&self, sample: I64Vec2) -> MapPoint {
        debug_assert_eq!(self.crs, GridCrs::Map);
        let c = self.centre(sample);
        MapPoint::new(c.x, c.y).normalised()
    }

    /// Continuous sample coordinates of a point in units of the plane: the centre of sample i is
    /// at i + ½.
    pub fn sample_from_plane(&self, point: DVec2) -> DVec2 {
        (point - self.origin) / self.step
    }
}

/// The samples that one evaluation makes: a rectangle of a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Where samples lie.
    pub lattice: Arc<Lattice>,
    /// Which of them.
    pub rect: SampleRect,
}

impl Grid {
    /// The grid of `rect` on `lattice`.
    pub const fn new(lattice: Arc<Lattice>, rect: SampleRect) -> Self {
        Self { lattice, rect }
    }

    /// Another rectangle of the same lattice.
    #[must_use]
    pub fn with_rect(&self, rect: SampleRect) -> Self {
        Self::new(Arc::clone(&self.lattice), rect)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sample_coordinates_and_plane_round_trip(
            origin in (-1e6..1e6, -1e6..1e6), step in (0.01..100.0, -100.0..-0.01),
            sample in (-100_000..100_000_i64, -100_000..100_000_i64),
        ) {
            let lattice = Lattice {
                crs: GridCrs::Projected("EPSG:26912".into()),
                origin: origin.into(),
                step: step.into(),
                columns_around: None,
            };
            let sample = I64Vec2::new(sample.0, sample.1);
            let back = lattice.sample_from_plane(lattice.centre(sample));
            prop_assert!((back - (sample.as_dvec2() + 0.5)).length() < 1e-6);
        }
    }
}
