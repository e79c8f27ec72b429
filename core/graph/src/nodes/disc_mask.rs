//! A mask by place: a disc on the ground.

use glam::{DVec3, I64Vec2};
use relievo_planet::{Grid, GridCrs, MapPoint, Planet};
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use super::memory::add_grid;
use super::range_mask::faded;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "disc mask";

/// 1 within a distance of a place, fading smoothly to 0 beyond. No inputs.
///
/// Distances are along great circles of the planet's sphere. Tiles that the edge does not touch are
/// uniform: moving the disc makes only those again that it enters or leaves.
#[derive(Clone, Copy, Debug)]
pub struct DiscMask {
    centre: DVec3,
    radius_rad: f64,
    fade_rad: f64,
}

impl DiscMask {
    /// `radius_m` and `fade_m` in metres on the ground of the planet's sphere; what is not above 0 is
    /// none of it.
    pub fn new(planet: &Planet, centre: MapPoint, radius_m: f64, fade_m: f64) -> Self {
        let angle = |m: f64| {
            if m > 0.0 && m.is_finite() {
                m / planet.radius_m
            } else {
                0.0
            }
        };
        Self {
            centre: centre.normalised().to_unit(),
            radius_rad: angle(radius_m),
            fade_rad: angle(fade_m),
        }
    }

    /// Angle to a place: by the chord, which keeps its digits however small the disc is.
    fn angle_rad(&self, place: DVec3) -> f64 {
        2.0 * libm::asin((0.5 * place.distance(self.centre)).min(1.0))
    }

    fn weight(&self, place: DVec3) -> f32 {
        let beyond_rad = self.angle_rad(place) - self.radius_rad;
        if beyond_rad <= 0.0 {
            1.0
        } else if beyond_rad >= self.fade_rad {
            0.0
        } else {
            faded((beyond_rad / self.fade_rad) as f32, 1.0)
        }
    }

    /// What all samples of a part of the map have, where the edge does not touch it.
    fn uniform(&self, grid: &Grid) -> Option<f32> {
        if grid.lattice.crs != GridCrs::Map || grid.rect.is_empty() {
            return None;
        }
        let (first, last) = (
            grid.lattice.centre(grid.rect.min),
            grid.lattice.centre(grid.rect.max - I64Vec2::ONE),
        );
        let middle = 0.5 * (first + last);
        let half = 0.5 * (last - first).abs();
        // Along the meridian to a sample's row and along the row to the sample is no shortcut.
        let farthest_rad = half.y + half.x;
        let (sin_lon, cos_lon) = libm::sincos(middle.x);
        let (sin_colat, cos_colat) = libm::sincos(middle.y);
        let place = DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat);
        let angle_rad = self.angle_rad(place);
        // Rounding.
        let slack_rad = 1e-12;
        if angle_rad + farthest_rad + slack_rad < self.radius_rad {
            Some(1.0)
        } else if angle_rad - farthest_rad - slack_rad > self.radius_rad + self.fade_rad {
            Some(0.0)
        } else {
            None
        }
    }
}

impl ImageNode for DiscMask {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        for v in self.centre.to_array() {
            id.float(v);
        }
        id.float(self.radius_rad).float(self.fade_rad);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        self.uniform(grid)
            .map_or(Known::Nothing, |v| Known::Uniform([v, 0.0, 0.0, 0.0]))
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let width = out.width().max(1);
        let rows = out.plane_mut(0).chunks_exact_mut(width).zip(rect.min.y..);
        if lattice.crs == GridCrs::Map {
            let columns: Vec<(f64, f64)> = (rect.min.x..rect.max.x)
                .map(|x| libm::sincos(lattice.centre(I64Vec2::new(x, 0)).x))
                .collect();
            for (row, y) in rows {
                if job.cancel.is_cancelled() {
                    return Err(RenderError::Cancelled);
                }
                let (sin_colat, cos_colat) = libm::sincos(lattice.centre(I64Vec2::new(0, y)).y);
                for (weight, (sin_lon, cos_lon)) in row.iter_mut().zip(&columns) {
                    let place = DVec3::new(sin_colat * cos_lon, sin_colat * sin_lon, cos_colat);
                    *weight = self.weight(place);
                }
            }
            return Ok(());
        }
        let ground = Ground::new(lattice, KIND)?;
        for (row, y) in rows {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for (weight, x) in row.iter_mut().zip(rect.min.x..) {
                let place = ground.point(I64Vec2::new(x, y).as_dvec2() + 0.5);
                *weight = place.map_or(0.0, |place| self.weight(place.to_unit()));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;
    use relievo_planet::{LevelKey, SampleRect};
    use relievo_raster::Cancel;

    use super::*;

    fn made(mask: &DiscMask, grid: &Grid) -> Vec<f32> {
        let size = (grid.rect.width() as usize, grid.rect.height() as usize);
        let mut out = Block::new(Bands::Mask, size.0, size.1);
        let cancel = Cancel::default();
        let job = Job {
            grid,
            cancel: &cancel,
        };
        mask.render(&job, &[], &mut out).unwrap();
        out.plane(0).to_vec()
    }

    #[test]
    fn a_disc_of_a_metre_is_as_round_as_one_of_a_thousand_kilometres() {
        for radius_m in [1.0, 1e6] {
            let planet = Planet::EARTH;
            let centre = MapPoint::from_degrees(-179.9999, 40.0);
            let mask = DiscMask::new(&planet, centre, radius_m, radius_m);
            let angle = radius_m / planet.radius_m;
            let at = |share: f64| {
                let lat_deg = 40.0 + (share * angle).to_degrees();
                mask.weight(MapPoint::from_degrees(-179.9999, lat_deg).to_unit())
            };
            assert_eq!((at(0.0), at(0.99), at(2.01)), (1.0, 1.0, 0.0));
            assert!((at(1.5) - 0.5).abs() < 1e-3, "{radius_m} {}", at(1.5));
        }
    }

    proptest! {
        #[test]
        fn what_is_known_of_a_part_of_the_map_is_so(
            lon in -180.0..180.0_f64, lat in -90.0..90.0_f64, size in 0.0..7.0_f64,
            n in 2..14_u8, x in -300..300_i64, y in -20..300_i64, w in 1..40_i64, h in 1..40_i64,
        ) {
            let mask = DiscMask::new(
                &Planet::EARTH,
                MapPoint::from_degrees(lon, lat),
                libm::pow(10.0, size),
                libm::pow(10.0, 0.5 * size),
            );
            let lattice = Arc::new(LevelKey::new(n, n).lattice());
            let grid = Grid::new(lattice, SampleRect::at(x, y, w, h));
            if let Known::Uniform([known, ..]) = mask.known(&grid, &[]) {
                prop_assert!(made(&mask, &grid).iter().all(|v| *v == known));
            }
        }
    }
}
