//! Grounds whose heights are formulas.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, I64Vec2};
use relievo_analysis::{AnalysisError, Ground, MapBox, Watch};
use relievo_planet::{Grid, GridCrs, MapPoint, Planet};

/// Heights by formula: of places on lattices of the map, of metres in local frames.
pub(crate) struct Formula<M, P> {
    pub(crate) planet: Planet,
    /// Level of its data.
    pub(crate) n: u8,
    pub(crate) on_map: M,
    pub(crate) in_frame: P,
    /// Samples that were asked for.
    pub(crate) asked: AtomicU64,
}

/// A ground for analyses on the map.
pub(crate) fn on_map<M: Fn(MapPoint) -> f64 + Sync>(
    planet: Planet,
    n: u8,
    on_map: M,
) -> Formula<M, fn(DVec2) -> f64> {
    Formula {
        planet,
        n,
        on_map,
        in_frame: |_| f64::NAN,
        asked: AtomicU64::new(0),
    }
}

/// A ground for analyses in local frames, on the Earth.
pub(crate) fn in_frame<P: Fn(DVec2) -> f64 + Sync>(in_frame: P) -> Formula<fn(MapPoint) -> f64, P> {
    Formula {
        planet: Planet::EARTH,
        n: 12,
        on_map: |_| f64::NAN,
        in_frame,
        asked: AtomicU64::new(0),
    }
}

impl<M: Fn(MapPoint) -> f64 + Sync, P: Fn(DVec2) -> f64 + Sync> Ground for Formula<M, P> {
    fn planet(&self) -> Planet {
        self.planet
    }

    fn finest_level(&self, _area: &MapBox) -> u8 {
        self.n
    }

    fn heights(&self, grid: &Grid) -> Result<Vec<f32>, AnalysisError> {
        let (lattice, rect) = (&grid.lattice, &grid.rect);
        self.asked.fetch_add(rect.area() as u64, Ordering::Relaxed);
        let mut heights = Vec::new();
        for row in rect.min.y..rect.max.y {
            for column in rect.min.x..rect.max.x {
                let sample = I64Vec2::new(column, row);
                heights.push(match lattice.crs {
                    GridCrs::Map => (self.on_map)(lattice.map_point(sample)) as f32,
                    GridCrs::Projected(_) => (self.in_frame)(lattice.centre(sample)) as f32,
                });
            }
        }
        Ok(heights)
    }
}

/// Stops work after it has told its progress so many times.
#[derive(Default)]
pub(crate) struct Impatient(pub(crate) AtomicU64);

impl Watch for Impatient {
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) >= 2
    }

    fn progress(&self, share: f64) {
        assert!((0.0..=1.0).contains(&share), "{share}");
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}
