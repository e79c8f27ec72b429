//! Two compiled versions as a change of the ground.

use std::sync::Arc;

use relievo_analysis::{AnalysisError, Change, Ground, MapBox};
use relievo_planet::{Grid, Planet};
use relievo_raster::Cancel;

use crate::analysis::SceneGround;
use crate::scene::Scene;

use super::sites::Widths;

/// Finest spacing in metres to begin with.
pub(super) const FINEST_M: f64 = 0.02;

/// The heights of two scenes.
pub(super) struct Pair<'a> {
    pub(super) scenes: &'a [Arc<Scene>; 2],
    pub(super) planet: Planet,
    pub(super) cancel: &'a Cancel,
    pub(super) widths: &'a Widths,
    /// How many times farther apart samples may lie than narrow parts ask for.
    pub(super) coarser: f64,
}

impl Pair<'_> {
    pub(super) fn ground<'a>(&'a self, scene: &'a Scene) -> SceneGround<'a> {
        SceneGround {
            scene,
            node: scene.roots.height,
            planet: self.planet,
            cancel: self.cancel,
        }
    }
}

impl Change for Pair<'_> {
    fn planet(&self) -> Planet {
        self.planet
    }

    fn same(&self, grid: &Grid) -> bool {
        let name = |scene: &Scene| scene.graph.evaluation_id(scene.roots.height, grid);
        name(&self.scenes[0]) == name(&self.scenes[1])
    }

    fn spacing_m(&self, area: &MapBox) -> f64 {
        self.coarser * self.widths.spacing_m(area).max(FINEST_M)
    }

    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let heights = |scene| -> Result<Vec<f64>, AnalysisError> {
            let found = self.ground(scene).heights(grid)?;
            Ok(found.into_iter().map(f64::from).collect())
        };
        Ok((heights(&self.scenes[0])?, heights(&self.scenes[1])?))
    }
}
