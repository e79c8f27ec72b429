//! A revision's heights as the ground of measurements.

use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_analysis::{AnalysisError, Ground, MapBox};
use relievo_graph::{NodeIndex, RenderError};
use relievo_planet::tile::TILE_SAMPLES;
use relievo_planet::{Grid, Planet, SampleRect};
use relievo_raster::Cancel;

use crate::scene::Scene;

/// Spacing in metres at which planning elements, which are exact, are measured where data are coarser.
const EXACT_M: f64 = 1.0;

/// A node of heights, evaluated.
#[derive(Clone, Copy)]
pub(crate) struct SceneGround<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) node: NodeIndex,
    pub(crate) planet: Planet,
    pub(crate) cancel: &'a Cancel,
}

impl Ground for SceneGround<'_> {
    fn planet(&self) -> Planet {
        self.planet
    }

    fn finest_level(&self, area: &MapBox) -> u8 {
        let step_rad = EXACT_M / self.planet.radius_m;
        let rows = core::f64::consts::PI / step_rad / TILE_SAMPLES as f64;
        let exact = libm::ceil(libm::log2(rows)).clamp(0.0, 30.0);
        self.scene.finest_in(Some(exact as u8), |n| {
            let level = area.level(n);
            let lattice = level.lattice();
            let at = |x, y| lattice.sample_from_plane(DVec2::new(x, y));
            let (first, last) = (
                at(area.west_rad, area.north_colat_rad),
                at(area.east_rad, area.south_colat_rad),
            );
            let rect = SampleRect::new(
                first.floor().as_i64vec2(),
                last.ceil()
                    .as_i64vec2()
                    .max(first.floor().as_i64vec2() + I64Vec2::ONE),
            );
            Grid::new(Arc::new(lattice), rect)
        })
    }

    fn heights(&self, grid: &Grid) -> Result<Vec<f32>, AnalysisError> {
        let evaluated = self.scene.graph.evaluate(self.node, grid, self.cancel);
        Ok(evaluated.map_err(failed)?.plane(0).to_vec())
    }
}

/// A graph's error as a measurement's.
pub(crate) fn failed(error: RenderError) -> AnalysisError {
    match error {
        RenderError::Cancelled => AnalysisError::Cancelled,
        error @ (RenderError::Read(_) | RenderError::Node { .. }) => {
            AnalysisError::Ground(Box::new(error))
        }
    }
}
