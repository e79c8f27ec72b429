//! Where examples are read, and what becomes of them when the first tile needs them.

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, GridCrs, Lattice, MapPoint, Planet, SampleRect};
use relievo_raster::{Block, Cancel};

use super::exemplar::{Exemplar, LEAST_SAMPLES, MOST_SAMPLES, MOST_SPACING_M};
use crate::node::{Artefact, Made};
use crate::{IdHasher, RenderError};

/// Most samples along a side of an example that is laid around a place.
pub const MOST_SIDE: u32 = 1024;

/// Where the colours of an input are read as an example.
#[derive(Clone, Debug, PartialEq)]
pub struct ExampleAt {
    /// Samples with north up, 8 or more along a side and at most [`MOST_SAMPLES`]; what has more or less,
    /// or turns out to be transparent, counts as no example.
    pub grid: Grid,
    /// Metres on the ground from sample to sample, along rows and along columns.
    pub spacing_m: f64,
}

impl ExampleAt {
    /// The samples around a place: on a lattice of the map whose columns are as far apart at the place as
    /// its rows are, on the ground.
    ///
    /// - `spacing_m`: metres from sample to sample, those of the file that is to be an example or more.
    /// - `most`: columns and rows that the file has at that spacing; of more than [`MOST_SIDE`] the ones
    ///   in the middle are read.
    ///
    /// A distance d from the place, samples are off from square by d · tan(latitude) / radius: at latitude
    /// 60° by a thousandth for 1024 samples of 7 m. Near a pole, where that grows, patches come to lie
    /// skewed and stretched; nothing is read beyond a pole or twice around it, and at the pole itself (or
    /// for a spacing that is no length) nothing at all.
    pub fn around(planet: &Planet, centre: MapPoint, spacing_m: f64, most: [u32; 2]) -> Self {
        let centre = centre.normalised();
        let per_radian_m = planet.metres_per_radian(centre.colat_rad);
        let step = spacing_m / per_radian_m;
        let is_length = spacing_m > 0.0 && step.is_finite() && step.max_element() < 1.0;
        let (step, sides) = if is_length {
            let to_a_pole = centre.colat_rad.min(PI - centre.colat_rad);
            let fit = DVec2::new(TAU, 2.0 * to_a_pole) / step;
            let side = |most: u32, fit: f64| {
                let most = i64::from(most.min(MOST_SIDE));
                (libm::floor(fit) as i64).min(most)
            };
            (
                step,
                I64Vec2::new(side(most[0], fit.x), side(most[1], fit.y)),
            )
        } else {
            (DVec2::ONE, I64Vec2::ZERO)
        };
        let lattice = Lattice {
            crs: GridCrs::Map,
            origin: DVec2::new(centre.lon_rad, centre.colat_rad) - 0.5 * sides.as_dvec2() * step,
            step,
            columns_around: None,
        };
        let rect = SampleRect::at(0, 0, sides.x, sides.y);
        Self {
            grid: Grid::new(Arc::new(lattice), rect),
            spacing_m,
        }
    }

    /// Whether there can be an example.
    pub(super) fn is_usable(&self) -> bool {
        let (width, height) = (self.grid.rect.width(), self.grid.rect.height());
        width.min(height) >= LEAST_SAMPLES as i64
            && width.saturating_mul(height) <= MOST_SAMPLES as i64
            && self.spacing_m > 0.0
            && self.spacing_m <= MOST_SPACING_M
    }

    /// Adds what decides an example but for its colours.
    pub(super) fn identify(&self, id: &mut IdHasher) {
        id.float(self.spacing_m).grid(&self.grid);
    }
}

/// Reads an example.
#[derive(Debug)]
pub(super) struct Example {
    /// The number of the node's input.
    pub(super) input: usize,
    pub(super) at: ExampleAt,
}

/// What [`Example`] makes: nothing where there are no colours.
pub(super) type Found = Option<Arc<Exemplar>>;

impl Artefact for Example {
    fn identify(&self, id: &mut IdHasher) {
        id.bytes(b"example").int(self.input as i64);
        self.at.identify(id);
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        vec![(self.input, self.at.grid.clone())]
    }

    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError> {
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        // Without an example there is less to see, which is no reason to see nothing.
        let found = Exemplar::new(&samples[0], self.at.spacing_m);
        Ok(Arc::new(found.map(Arc::new) as Found))
    }

    fn bytes(&self) -> usize {
        Exemplar::bytes(self.at.grid.rect.area() as usize)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use relievo_raster::Bands;

    use super::*;

    const EARTH: Planet = Planet::EARTH;

    proptest! {
        #[test]
        fn samples_around_a_place_are_square_on_the_ground_with_the_place_in_their_middle(
            lon_deg in -180.0..180.0_f64, lat_deg in -80.0..80.0_f64, spacing_m in 0.1..30.0_f64,
            most in (8..3000_u32, 8..3000_u32),
        ) {
            let centre = MapPoint::from_degrees(lon_deg, lat_deg);
            let at = ExampleAt::around(&EARTH, centre, spacing_m, [most.0, most.1]);
            let rect = at.grid.rect;
            prop_assert_eq!(rect.width(), i64::from(most.0.min(1024)));
            prop_assert_eq!(rect.height(), i64::from(most.1.min(1024)));
            prop_assert!(at.is_usable());
            let lattice = &at.grid.lattice;
            let middle = lattice.origin + 0.5 * (rect.max - rect.min).as_dvec2() * lattice.step;
            let middle = MapPoint::new(middle.x, middle.y);
            prop_assert!(middle.angle_to(centre) < 1e-12);
            let next = |step: DVec2| {
                let to = MapPoint::new(middle.lon_rad + step.x, middle.colat_rad + step.y);
                EARTH.offset_m(middle, to)
            };
            let [east, south] = [DVec2::X, DVec2::Y].map(|axis| next(axis * lattice.step));
            prop_assert!((east - DVec2::new(spacing_m, 0.0)).length() < 1e-3 * spacing_m);
            prop_assert!((south - DVec2::new(0.0, -spacing_m)).length() < 1e-3 * spacing_m);
            // As far off from square at the end as is said.
            let end = lattice.centre(rect.max).y;
            let ratio = EARTH.metres_per_radian(end).x / EARTH.metres_per_radian(centre.colat_rad).x;
            let d_m = 0.5 * rect.height() as f64 * spacing_m;
            let said = d_m * libm::tan(lat_deg.to_radians().abs()) / EARTH.radius_m;
            prop_assert!((ratio - 1.0).abs() < 1.1 * said + 1e-3, "{ratio} {said}");
        }
    }

    #[test]
    fn near_a_pole_nothing_is_read_twice_and_what_is_no_length_reads_nothing() {
        let near = MapPoint::from_degrees(20.0, 89.9);
        let at = ExampleAt::around(&EARTH, near, 100.0, [1024; 2]);
        let rect = at.grid.rect;
        assert!(rect.height() > 200 && rect.height() <= 224, "{rect:?}");
        assert!(rect.width() as f64 * at.grid.lattice.step.x <= TAU && rect.width() > 600);
        let pole = MapPoint::new(0.0, 0.0);
        let place = MapPoint::from_degrees(8.0, 47.0);
        for at in [
            ExampleAt::around(&EARTH, pole, 1.0, [64; 2]),
            ExampleAt::around(&EARTH, place, 0.0, [64; 2]),
            ExampleAt::around(&EARTH, place, -1.0, [64; 2]),
            ExampleAt::around(&EARTH, place, f64::NAN, [64; 2]),
            ExampleAt::around(&EARTH, place, 1e12, [64; 2]),
            ExampleAt::around(&EARTH, place, 1.0, [64, 7]),
        ] {
            assert!(!at.is_usable(), "{at:?}");
        }
    }

    #[test]
    fn transparent_colours_make_no_example_and_no_error() {
        let place = MapPoint::from_degrees(8.0, 47.0);
        let example = Example {
            input: 2,
            at: ExampleAt::around(&EARTH, place, 1.0, [10, 9]),
        };
        let found = |samples: Block| {
            let made = example.make(&[samples], &Cancel::default());
            let found = made.expect("no errors").downcast_ref::<Found>().cloned();
            found.expect("what may be an example").is_some()
        };
        assert!(!found(Block::new(Bands::Colour, 10, 9)));
        assert!(found(Block::filled(Bands::Colour, 10, 9, &[0.5; 4])));
        let cancel = Cancel::default();
        cancel.cancel();
        let stopped = example.make(&[Block::new(Bands::Colour, 10, 9)], &cancel);
        assert!(matches!(stopped, Err(RenderError::Cancelled)));
    }
}
