//! Contour lines: where the ground crosses heights of a regular interval.

mod join;
mod march;

use core::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, Lattice, MapPoint, SampleRect};

use crate::ground::{AnalysisError, Ground, Watch, go_on};
use crate::map_box::MapBox;

pub(crate) use join::Chain;
pub(crate) use march::Segments;

/// Samples that are read at once.
const STRIP: i64 = 1 << 20;

/// Which contours are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourSettings {
    /// Metres between contours, positive.
    pub interval_m: f64,
    /// A height in metres that has a contour.
    pub base_m: f64,
    /// Most samples that are read; an area that needs more is refused.
    pub max_samples: u64,
    /// Most segments; an interval that gives more is refused.
    pub max_segments: usize,
}

impl ContourSettings {
    /// Contours at whole multiples of an interval, of at most 2²⁷ samples and 2²² segments.
    pub fn every(interval_m: f64) -> Self {
        Self {
            interval_m,
            base_m: 0.0,
            max_samples: 1 << 27,
            max_segments: 1 << 22,
        }
    }
}

/// A contour.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourLine {
    /// Its height in metres.
    pub height_m: f64,
    /// Its vertices; higher ground lies to the left. Longitudes run on without a jump from vertex to
    /// vertex (beyond ±π across the antimeridian).
    pub points: Vec<MapPoint>,
    /// Whether it closes; the first vertex is not repeated.
    pub closed: bool,
}

/// Contours of a ground inside an area, lowest first.
///
/// Marching squares between the samples of the data's own level, which is one lattice for the whole
/// planet: contours of neighbouring areas meet, and nothing shows where tiles do. Vertices lie on the
/// edges between neighbouring samples by linear interpolation; a sample exactly at a contour's height
/// counts as above. In a saddle, where opposite corners lie above, the mean of the four decides
/// whether the high ones are joined. A missing sample is an edge: contours end there. The area is
/// grown to whole cells. Once around the planet contours close across the antimeridian.
///
/// # Errors
/// [`AnalysisError`]; `Refused` for an interval that is not positive or a limit that is exceeded.
pub fn contours(
    ground: &dyn Ground,
    area: &MapBox,
    settings: &ContourSettings,
    watch: &dyn Watch,
) -> Result<Vec<ContourLine>, AnalysisError> {
    let refused = |text: String| Err(AnalysisError::Refused(text));
    let (interval_m, base_m) = (settings.interval_m, settings.base_m);
    if !(interval_m.is_finite() && interval_m > 0.0 && base_m.is_finite()) {
        return refused(format!(
            "expected a positive interval and a finite base in metres, found {interval_m} and {base_m}"
        ));
    }
    let level = area.level(ground.finest_level(area));
    let (rect, around) = nodes(&level.lattice(), area, level.samples());
    let samples = rect.width() as u64 * rect.height() as u64;
    if samples > settings.max_samples {
        return refused(format!(
            "expected an area of at most {} samples of the data, found {} × {} = {samples}",
            settings.max_samples,
            rect.width(),
            rect.height()
        ));
    }
    let lattice = Arc::new(level.lattice());
    let mut segments = Segments::new(
        rect.width(),
        around,
        interval_m,
        base_m,
        settings.max_segments,
    );
    let rows_at_once = (STRIP / rect.width()).max(1);
    let mut above: Vec<f32> = Vec::new();
    let mut row = rect.min.y;
    while row < rect.max.y {
        go_on(watch)?;
        let rows = rows_at_once.min(rect.max.y - row);
        let strip = SampleRect::at(rect.min.x, row, rect.width(), rows);
        let heights = ground.heights(&Grid::new(Arc::clone(&lattice), strip))?;
        let width = rect.width() as usize;
        for (i, below) in heights.chunks_exact(width).enumerate() {
            if !above.is_empty() {
                segments.row(row + i as i64 - 1 - rect.min.y, &above, below)?;
            }
            above.clear();
            above.extend_from_slice(below);
        }
        row += rows;
        watch.progress((row - rect.min.y) as f64 / rect.height() as f64);
    }
    let mut lines = Vec::new();
    for (index, chains) in segments.chains() {
        go_on(watch)?;
        let height_m = base_m + index as f64 * interval_m;
        for chain in chains {
            lines.push(placed(&lattice, rect.min, &chain, height_m));
        }
    }
    Ok(lines)
}

/// The samples whose cells cover an area, and whether the columns go once around.
fn nodes(lattice: &Lattice, area: &MapBox, size: I64Vec2) -> (SampleRect, bool) {
    let first = lattice.sample_from_plane(DVec2::new(area.west_rad, area.north_colat_rad)) - 0.5;
    let last = lattice.sample_from_plane(DVec2::new(area.east_rad, area.south_colat_rad)) - 0.5;
    // What lies a hair beyond a sample lies on it: bounds are decimal.
    let (first, last) = (
        (first + 1e-6).floor().as_i64vec2(),
        (last - 1e-6).ceil().as_i64vec2(),
    );
    let around = area.width_rad() >= TAU - 1e-12 || last.x - first.x >= size.x;
    let (west, east) = if around {
        (0, size.x)
    } else {
        (first.x, last.x + 1)
    };
    let (north, south) = (first.y.clamp(0, size.y - 1), (last.y + 1).clamp(1, size.y));
    (
        SampleRect::new(
            I64Vec2::new(west, north),
            I64Vec2::new(east, south.max(north + 1)),
        ),
        around,
    )
}

/// A chain of lattice positions as a line of places.
pub(crate) fn placed(
    lattice: &Lattice,
    first: I64Vec2,
    chain: &Chain,
    height_m: f64,
) -> ContourLine {
    let mut points: Vec<MapPoint> = Vec::with_capacity(chain.points.len());
    for at in &chain.points {
        let plane = lattice.origin + (first.as_dvec2() + *at + 0.5) * lattice.step;
        let mut lon_rad = plane.x;
        if let Some(before) = points.last() {
            lon_rad -= TAU * libm::round((lon_rad - before.lon_rad) / TAU);
        }
        let point = MapPoint::new(lon_rad, plane.y);
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    if chain.closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    ContourLine {
        height_m,
        points,
        closed: chain.closed,
    }
}
