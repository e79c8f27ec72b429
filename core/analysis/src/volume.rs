//! Volumes and areas between two surfaces, each with its discretisation error.

mod amount;
mod patch;
mod refine;

use core::f64::consts::{PI, TAU};

use relievo_planet::{Grid, Planet};

use crate::ground::{AnalysisError, Ground, Watch};
use crate::map_box::MapBox;

pub use amount::{Amount, Volumes};

/// Two grounds of one planet, before and after.
pub trait Change: Sync {
    /// The planet's figure.
    fn planet(&self) -> Planet;

    /// Whether both are known, without evaluating them, to be equal on all samples of a grid.
    fn same(&self, grid: &Grid) -> bool;

    /// How far apart in metres samples may lie in an area to begin with, lest something narrow be missed;
    /// infinite where nothing is known to be narrow.
    fn spacing_m(&self, _area: &MapBox) -> f64 {
        f64::INFINITY
    }

    /// Heights before and after in metres, each in the order of [`Ground::heights`], NaN where there
    /// are none.
    ///
    /// # Errors
    /// As [`Ground::heights`].
    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError>;
}

/// Two grounds that know nothing of each other.
#[derive(Clone, Copy)]
pub struct Between<'a> {
    /// The ground before.
    pub before: &'a dyn Ground,
    /// The ground after.
    pub after: &'a dyn Ground,
}

impl Change for Between<'_> {
    fn planet(&self) -> Planet {
        self.before.planet()
    }

    fn same(&self, _grid: &Grid) -> bool {
        false
    }

    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let exact = |heights: Vec<f32>| heights.into_iter().map(f64::from).collect();
        Ok((
            exact(self.before.heights(grid)?),
            exact(self.after.heights(grid)?),
        ))
    }
}

/// How finely a change is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSettings {
    /// Metres between samples to begin with, positive: the spacing of the data, or less where
    /// elements are narrower.
    pub spacing_m: f64,
    /// Share of cut and fill, and of the area, that their errors should not exceed; spacings are
    /// halved where they are largest until then. 0 halves until `max_samples`.
    pub tolerance: f64,
    /// Most samples that are evaluated; a quarter of them to begin with.
    pub max_samples: u64,
    /// A place counts as changed where heights differ by more than so many metres.
    pub differs_m: f64,
    /// Threads to work on.
    pub threads: usize,
}

impl VolumeSettings {
    /// From a spacing on: within a thousandth, at most 2²³ samples, changes above 1 mm, one thread.
    pub fn from_spacing(spacing_m: f64) -> Self {
        Self {
            spacing_m,
            tolerance: 1e-3,
            max_samples: 1 << 23,
            differs_m: 1e-3,
            threads: 1,
        }
    }
}

/// Measures what changes between two grounds inside an area.
///
/// The area is tiled by patches of 32² cells between meridians and circles of latitude, so nothing
/// outside of it counts and plan areas are the ellipsoid's own; those that are known to be equal cost
/// nothing. Towards a pole cells keep their shape on the ground. In a cell both surfaces are four
/// triangles around its centre, over which cut and fill are integrated exactly, so where surfaces are
/// continuous errors fall with the square of the spacing, at walls with the spacing. Each patch is
/// summed at its spacing and at twice as much. The stated error is the sum of the differences'
/// magnitudes over all patches (Richardson's estimate without dividing by 2ᵖ − 1, so that it holds for
/// p = 1 too), plus what cells leave open that have changed in part, through which the edge of the change
/// runs somewhere (half their area, a quarter of their volume), plus the rounding of single-precision
/// heights. Patches with the largest errors are halved until the tolerance is met or the samples are
/// spent. What is smaller than the first spacing (the settings', or what [`Change::spacing_m`] asks for)
/// and lies between its samples is not found.
///
/// The same for any number of threads.
///
/// # Errors
/// [`AnalysisError`]; `Refused` for an empty area, settings out of range, or an area that needs more
/// samples than allowed at the spacing to begin with.
pub fn volumes(
    change: &dyn Change,
    area: &MapBox,
    settings: &VolumeSettings,
    watch: &dyn Watch,
) -> Result<Volumes, AnalysisError> {
    check(area, settings)?;
    let found = refine::refined(change, area, settings, watch)?;
    watch.progress(1.0);
    Ok(found)
}

fn check(area: &MapBox, settings: &VolumeSettings) -> Result<(), AnalysisError> {
    let refused = |text: String| Err(AnalysisError::Refused(text));
    let (width_rad, height_rad) = (
        area.width_rad(),
        area.south_colat_rad - area.north_colat_rad,
    );
    let on_map = area.west_rad.is_finite()
        && width_rad > 0.0
        && width_rad <= TAU * (1.0 + f64::EPSILON)
        && area.north_colat_rad >= 0.0
        && height_rad > 0.0
        && area.south_colat_rad <= PI;
    if !on_map {
        return refused(format!(
            "expected an area of the map with an extent, found one of {} × {} degrees",
            width_rad.to_degrees(),
            height_rad.to_degrees()
        ));
    }
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if !positive(settings.spacing_m)
        || settings.tolerance.is_nan()
        || settings.tolerance < 0.0
        || settings.differs_m.is_nan()
        || settings.differs_m < 0.0
    {
        return refused(format!(
            "expected a positive spacing in metres and a tolerance of at least 0, found {} and {}",
            settings.spacing_m, settings.tolerance
        ));
    }
    Ok(())
}
