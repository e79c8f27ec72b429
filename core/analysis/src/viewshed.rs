//! What can be seen from a place.

mod sight_lines;

use std::sync::Arc;

use glam::DVec2;
use relievo_planet::{Grid, LevelKey, MapPoint, SampleRect};

use crate::frame::LocalFrame;
use crate::ground::{AnalysisError, Ground, Watch, go_on};
use crate::map_box::MapBox;
use crate::parallel;

use sight_lines::Terrain;

/// Samples from the middle to the rim at least, unless somebody says how many.
const LEAST_REACH: f64 = 64.0;

/// Samples that are read at once.
const STRIP: i64 = 1 << 19;

/// From what height and how far somebody looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewshedSettings {
    /// Metres of the eye above the ground.
    pub observer_height_m: f64,
    /// Metres above the ground of what should be seen.
    pub target_height_m: f64,
    /// How far in metres.
    pub radius_m: f64,
    /// How much of the ellipsoid's curvature refraction takes away: 0 none, 1 all.
    pub refraction: f64,
    /// Metres between samples; `None` takes the spacing of the data, and a 64th of the radius where
    /// that is coarser, so that the circle is one.
    pub spacing_m: Option<f64>,
    /// Most samples of the square around the circle; a larger request is refused.
    pub max_samples: u64,
    /// Threads to work on.
    pub threads: usize,
}

impl ViewshedSettings {
    /// Looking `radius_m` metres far from 1.7 m above the ground at the ground itself, refraction 0.13
    /// as for visible light over land, the data's spacing, at most 2²⁵ samples, one thread.
    pub fn within(radius_m: f64) -> Self {
        Self {
            observer_height_m: 1.7,
            target_height_m: 0.0,
            radius_m,
            refraction: 0.13,
            spacing_m: None,
            max_samples: 1 << 25,
            threads: 1,
        }
    }
}

/// What one sample of a viewshed shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// It is beyond the radius or has no height.
    Outside,
    /// Something stands before it.
    Hidden,
    /// It is seen.
    Visible,
}

/// What is seen around a place.
#[derive(Clone, Debug)]
pub struct Viewshed {
    /// Frame around the observer.
    pub frame: LocalFrame,
    /// Metres between samples.
    pub spacing_m: f64,
    /// Samples from the observer's, in the middle, to each side.
    pub reach: usize,
    /// (2 · reach + 1)² samples, row by row from the north-west.
    pub sights: Vec<Sight>,
    /// Area in square metres of the ellipsoid that is seen.
    pub visible_m2: f64,
    /// Area in square metres within the radius that has heights.
    pub area_m2: f64,
    /// Height in metres of the ground below the observer.
    pub ground_m: f64,
}

impl Viewshed {
    /// Samples along a side.
    pub fn side(&self) -> usize {
        2 * self.reach + 1
    }

    /// What is seen at a place; `Outside` beyond the square.
    pub fn at(&self, place: MapPoint) -> Sight {
        self.sight(self.frame.point_m(place))
    }

    /// What is seen at a point of the frame in metres; `Outside` beyond the square.
    pub fn sight(&self, at_m: DVec2) -> Sight {
        let at = at_m / self.spacing_m;
        let reach = self.reach as f64;
        let (column, row) = (libm::round(at.x + reach), libm::round(reach - at.y));
        if !(0.0..=2.0 * reach).contains(&column) || !(0.0..=2.0 * reach).contains(&row) {
            return Sight::Outside;
        }
        self.sights[row as usize * self.side() + column as usize]
    }
}

/// What can be seen from above a place, within a radius.
///
/// Every sample has a line of sight of its own (the scheme that is called R3): heights where it crosses
/// the rows and columns of samples, linear between neighbours, hide what lies above the line from the eye
/// to the target. Blocks whose highest sample lies below the line are skipped, which changes no result.
/// Between crossings the ground is taken as straight, so the only errors are those of the samples: what is
/// narrower than their spacing may be missed.
///
/// Curvature lowers a sample at distance d by d² (1 − refraction) / 2R with the ellipsoid's radius R of
/// that direction at the observer: 0.05 m too much at 100 km, growing with the fourth power.
///
/// # Errors
/// [`AnalysisError`]; `Refused` for a radius that is not positive, heights or a refraction that are not
/// finite or out of range, no ground below the observer, or more samples than allowed.
pub fn viewshed(
    ground: &dyn Ground,
    observer: MapPoint,
    settings: &ViewshedSettings,
    watch: &dyn Watch,
) -> Result<Viewshed, AnalysisError> {
    check(settings)?;
    let planet = ground.planet();
    let frame = LocalFrame::new(planet, observer);
    let angle_rad = settings.radius_m / frame.mean_radius_m();
    let area = MapBox::around(frame.centre, angle_rad.min(core::f64::consts::PI));
    let spacing_m = settings.spacing_m.unwrap_or_else(|| {
        let data_m = LevelKey::new(0, ground.finest_level(&area)).step_rad().y * planet.radius_m;
        data_m.min(settings.radius_m / LEAST_REACH)
    });
    let reach = libm::ceil(settings.radius_m / spacing_m);
    let samples = (2.0 * reach + 1.0) * (2.0 * reach + 1.0);
    if samples > settings.max_samples as f64 || angle_rad > 1.0 {
        return Err(AnalysisError::Refused(format!(
            "expected a radius below {:.0} m at a spacing of {spacing_m:.3} m, found {} m: a coarser spacing or a smaller radius would do",
            (0.5 * libm::sqrt(settings.max_samples as f64) * spacing_m).min(frame.mean_radius_m()),
            settings.radius_m
        )));
    }
    let reach = reach as usize;
    let heights = read(ground, &frame, reach, spacing_m, watch)?;
    let ground_m = f64::from(heights[heights.len() / 2]);
    if !ground_m.is_finite() {
        return Err(AnalysisError::Refused(
            "expected ground below the observer, found none".to_owned(),
        ));
    }
    let terrain = Terrain::new(heights, reach, spacing_m, &frame, settings);
    let side = 2 * reach + 1;
    let rows = parallel::map(
        side,
        settings.threads,
        watch,
        &|done| watch.progress(0.2 + 0.8 * done as f64 / side as f64),
        &|row| Ok(terrain.row(row)),
    )?;
    let (mut visible_m2, mut area_m2) = (0.0, 0.0);
    for (row, sights) in rows.iter().enumerate() {
        for (column, sight) in sights.iter().enumerate() {
            if *sight != Sight::Outside {
                let at = DVec2::new(column as f64 - reach as f64, reach as f64 - row as f64);
                let cell_m2 = spacing_m * spacing_m * frame.area_scale(at * spacing_m);
                area_m2 += cell_m2;
                visible_m2 += if *sight == Sight::Visible {
                    cell_m2
                } else {
                    0.0
                };
            }
        }
    }
    Ok(Viewshed {
        frame,
        spacing_m,
        reach,
        sights: rows.concat(),
        visible_m2,
        area_m2,
        ground_m,
    })
}

fn check(settings: &ViewshedSettings) -> Result<(), AnalysisError> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let fine = positive(settings.radius_m)
        && settings.spacing_m.is_none_or(positive)
        && settings.observer_height_m.is_finite()
        && settings.target_height_m.is_finite()
        && (-1.0..=1.0).contains(&settings.refraction);
    if fine {
        return Ok(());
    }
    Err(AnalysisError::Refused(format!(
        "expected a positive radius, finite heights and a refraction from −1 to 1, found {} m, {} m, {} m, {}",
        settings.radius_m,
        settings.observer_height_m,
        settings.target_height_m,
        settings.refraction
    )))
}

/// Heights of the square around the observer.
fn read(
    ground: &dyn Ground,
    frame: &LocalFrame,
    reach: usize,
    spacing_m: f64,
    watch: &dyn Watch,
) -> Result<Vec<f32>, AnalysisError> {
    let side = 2 * reach as i64 + 1;
    let corner_m = (reach as f64 + 0.5) * spacing_m;
    let lattice = Arc::new(frame.lattice(DVec2::new(-corner_m, corner_m), spacing_m));
    let mut heights = Vec::new();
    let rows_at_once = (STRIP / side).max(1);
    let mut row = 0;
    while row < side {
        go_on(watch)?;
        let rows = rows_at_once.min(side - row);
        let rect = SampleRect::at(0, row, side, rows);
        heights.extend(ground.heights(&Grid::new(Arc::clone(&lattice), rect))?);
        row += rows;
        watch.progress(0.2 * row as f64 / side as f64);
    }
    Ok(heights)
}
