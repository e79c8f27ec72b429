//! Measurements on a revision: profiles, contours, sight, water, lengths and areas.
//!
//! All are asked of [`Questions`], on any thread, and evaluate the graph on grids of their own at the
//! data's resolution, so no answer depends on what is on the screen. Detail beyond that resolution is
//! synthesised and left out, as [`Questions::left_out_of_measures`] says.

mod compare;
mod difference;
mod extent;
mod ground;
mod pictures;

use relievo_planet::MapPoint;
use relievo_raster::Cancel;

pub use relievo_analysis::colour;
pub use relievo_analysis::{
    Amount, AnalysisError, Between, Change, ContourLine, ContourSettings, Flood, FloodSettings,
    Ground, LocalFrame, MapBox, Measure, Profile, ProfilePoint, ProfileSettings, RingArea, Sight,
    Viewshed, ViewshedSettings, VolumeSettings, Volumes, Watch,
};

pub use self::compare::{Comparison, ComparisonReport, ElementChange, Step, Version};
pub(crate) use self::ground::{SceneGround, failed};
pub use self::pictures::{DIFFERENCE_COLOURS, Picture, SitePictures};
use crate::query::Questions;

/// Somebody who waits for a measurement: asks to stop through a token, and hears of the progress.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Asks to stop.
    pub cancel: &'a Cancel,
    /// Told the part that is done, 0 to 1, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Task<'a> {
    /// A task whose progress nobody wants to know.
    pub fn quiet(cancel: &'a Cancel) -> Self {
        Self {
            cancel,
            progress: &|_| {},
        }
    }
}

impl Watch for Task<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    fn progress(&self, share: f64) {
        (self.progress)(share);
    }
}

impl Questions {
    /// Lengths, directions and areas on the project's planet, without its heights.
    pub fn measure(&self) -> Measure {
        Measure::new(&self.planet)
    }

    /// Heights along a line of geodesics; see [`relievo_analysis::profile()`].
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn profile(
        &self,
        line: &[MapPoint],
        settings: &ProfileSettings,
        task: &Task,
    ) -> Result<Profile, AnalysisError> {
        relievo_analysis::profile(&self.ground(task), line, settings, task)
    }

    /// Contours inside an area; see [`relievo_analysis::contours()`].
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn contours(
        &self,
        area: &MapBox,
        settings: &ContourSettings,
        task: &Task,
    ) -> Result<Vec<ContourLine>, AnalysisError> {
        relievo_analysis::contours(&self.ground(task), area, settings, task)
    }

    /// What can be seen from above a place; see [`relievo_analysis::viewshed()`].
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn viewshed(
        &self,
        observer: MapPoint,
        settings: &ViewshedSettings,
        task: &Task,
    ) -> Result<Viewshed, AnalysisError> {
        relievo_analysis::viewshed(&self.ground(task), observer, settings, task)
    }

    /// Still water at a level that reaches a place; see [`relievo_analysis::flood()`].
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn flood(
        &self,
        seed: MapPoint,
        settings: &FloodSettings,
        task: &Task,
    ) -> Result<Flood, AnalysisError> {
        relievo_analysis::flood(&self.ground(task), seed, settings, task)
    }

    fn ground<'a>(&'a self, task: &Task<'a>) -> SceneGround<'a> {
        SceneGround {
            scene: &self.surveyed,
            node: self.surveyed.roots.height,
            planet: self.planet,
            cancel: task.cancel,
        }
    }
}
