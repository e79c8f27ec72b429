//! Still water: what lies below a level and is joined to a place.

mod basin;
mod water;

use core::f64::consts::FRAC_PI_2;

use glam::{DVec2, I64Vec2};
use relievo_planet::{LevelKey, MapPoint, Planet};

use crate::contours::{ContourLine, Segments, placed};
use crate::ground::{AnalysisError, Ground, Watch, go_on};
use crate::map_box::{MapBox, level_at};
use crate::triangle::positive_part_of_cell;

use basin::Basin;

pub use water::Water;

/// How far around the seed the fineness of the data decides about the whole flood, in radians (1 km on
/// Earth).
const NEAR_RAD: f64 = 1.6e-4;

/// To what level water rises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloodSettings {
    /// Height of the water in metres.
    pub level_m: f64,
    /// Most samples that are read; water that spreads farther is refused.
    pub max_samples: u64,
}

impl FloodSettings {
    /// Up to a level, over at most 2²⁵ samples.
    pub fn to(level_m: f64) -> Self {
        Self {
            level_m,
            max_samples: 1 << 25,
        }
    }
}

/// A body of still water.
#[derive(Clone, Debug, PartialEq)]
pub struct Flood {
    /// Height of its surface in metres.
    pub level_m: f64,
    /// Area of its surface in square metres.
    pub area_m2: f64,
    /// Its volume in cubic metres.
    pub volume_m3: f64,
    /// Depth of its deepest sample in metres.
    pub deepest_m: f64,
    /// Its shore: rings with the dry ground to the left, so clockwise around the water and
    /// counter-clockwise around islands.
    pub shore: Vec<ContourLine>,
    /// Length of the shore in metres.
    pub shore_m: f64,
    /// Metres between rows of samples.
    pub spacing_m: f64,
    /// Samples under water.
    pub wet_samples: u64,
    /// How deep it is, sample by sample.
    pub water: Water,
}

/// Water that stands at a level and reaches a place.
///
/// Samples of the data's own level (as fine as around the seed) that lie below the water are joined to
/// their four neighbours; water does not pass between two that only touch at their corners. Depths are
/// integrated exactly over four triangles in each cell, so area and volume are of second order in the
/// spacing. Ground without height holds water back.
///
/// # Errors
/// [`AnalysisError`]; `Refused` where the seed is dry or the water spreads over more samples than
/// allowed.
pub fn flood(
    ground: &dyn Ground,
    seed: MapPoint,
    settings: &FloodSettings,
    watch: &dyn Watch,
) -> Result<Flood, AnalysisError> {
    let planet = ground.planet();
    let level_m = settings.level_m;
    let seed = seed.normalised();
    if !level_m.is_finite() || !seed.lon_rad.is_finite() || !seed.colat_rad.is_finite() {
        return Err(AnalysisError::Refused(format!(
            "expected a finite level and seed, found a level of {level_m} m"
        )));
    }
    let n = ground.finest_level(&MapBox::around(seed, NEAR_RAD));
    let level = level_at(n, libm::sin(seed.colat_rad));
    let mut basin = Basin::new(ground, level, level_m, settings.max_samples);
    let first = first_wet(&mut basin, seed, level, level_m)?;
    basin.fill(first, watch)?;
    measure(basin, planet, level, level_m, watch)
}

/// The sample nearest to the seed that lies under water, among the four around it.
fn first_wet(
    basin: &mut Basin,
    seed: MapPoint,
    level: LevelKey,
    level_m: f64,
) -> Result<I64Vec2, AnalysisError> {
    let at = level.sample_from_map(seed) - 0.5;
    let corner = at.floor().as_i64vec2();
    let mut around: Vec<(f64, I64Vec2)> = [(0, 0), (1, 0), (0, 1), (1, 1)]
        .into_iter()
        .map(|(x, y)| corner + I64Vec2::new(x, y))
        .map(|node| {
            (
                (node.as_dvec2() - at).length_squared(),
                level.wrap_sample(node),
            )
        })
        .collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found_m = f64::NAN;
    for (_, node) in around {
        let height_m = f64::from(basin.height_m(node)?);
        if height_m < level_m {
            return Ok(node);
        }
        found_m = found_m.min(height_m);
    }
    Err(AnalysisError::Refused(format!(
        "expected ground below the water level of {level_m} m at the place to flood from, found {found_m:.3} m"
    )))
}

/// Sums over the cells that touch water, and their shore.
fn measure(
    mut basin: Basin,
    planet: Planet,
    level: LevelKey,
    level_m: f64,
    watch: &dyn Watch,
) -> Result<Flood, AnalysisError> {
    let lattice = level.lattice();
    let size = level.samples();
    let wet = basin.wet_nodes();
    let first_row = wet.iter().map(|node| node.y).min().unwrap_or(0) - 1;
    // One contour, at the water's level; farther ones would lie beyond every mountain.
    let mut shore = Segments::new(size.x, true, 1e12, level_m, 1 << 23);
    let (mut area_m2, mut volume_m3, mut deepest_m) = (0.0, 0.0, 0.0_f64);
    for (index, node) in wet.iter().enumerate() {
        if index % 4096 == 0 {
            go_on(watch)?;
            watch.progress(0.7 + 0.3 * index as f64 / wet.len() as f64);
        }
        deepest_m = deepest_m.max(level_m - f64::from(basin.height_m(*node)?));
        // The cells to whose corners it belongs, by their north-western node.
        for (corner, (x, y)) in [(0, (0, 0)), (1, (-1, 0)), (2, (-1, -1)), (3, (0, -1))] {
            let first = *node + I64Vec2::new(x, y);
            if first.y < 0 || first.y + 1 >= size.y {
                // Half a sample around a pole.
                continue;
            }
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
                .map(|(x, y)| level.wrap_sample(first + I64Vec2::new(x, y)));
            // Each cell once, by the first of its corners that is wet.
            if corners[..corner].iter().any(|other| basin.is_wet(*other)) {
                continue;
            }
            let mut depths = [0.0; 4];
            for (depth, corner) in depths.iter_mut().zip(corners) {
                let below_m = level_m - f64::from(basin.height_m(corner)?);
                // Water elsewhere, and missing ground, end at this one's level.
                *depth = if basin.is_wet(corner) || below_m < 0.0 {
                    below_m
                } else {
                    0.0
                };
            }
            let colat_rad = lattice.origin.y + (first.y as f64 + 1.0) * lattice.step.y;
            let cell_m = planet.metres_per_radian(colat_rad) * lattice.step;
            let (share, mean_m) = positive_part_of_cell(depths);
            area_m2 += share * cell_m.element_product();
            volume_m3 += mean_m * cell_m.element_product();
            let heights = depths.map(|depth| level_m - depth);
            shore.cell(first.x.rem_euclid(size.x), first.y - first_row, heights)?;
        }
    }
    let mut lines = Vec::new();
    for (_, chains) in shore.chains() {
        let first = I64Vec2::new(0, first_row);
        lines.extend(
            chains
                .iter()
                .map(|chain| placed(&lattice, first, chain, level_m)),
        );
    }
    Ok(Flood {
        level_m,
        area_m2,
        volume_m3,
        deepest_m,
        shore_m: lines.iter().map(|line| length_m(&planet, line)).sum(),
        shore: lines,
        spacing_m: lattice.step.y * planet.meridian_radius_m(FRAC_PI_2 - basin.colat_rad()),
        wet_samples: wet.len() as u64,
        water: basin.water(),
    })
}

/// Length of a line of short steps on the ellipsoid.
fn length_m(planet: &Planet, line: &ContourLine) -> f64 {
    let step = |from: MapPoint, to: MapPoint| -> f64 {
        let offset: DVec2 = planet.offset_m(from, to);
        offset.length()
    };
    let open: f64 = line
        .points
        .windows(2)
        .map(|pair| step(pair[0], pair[1]))
        .sum();
    match (line.closed, line.points.first(), line.points.last()) {
        (true, Some(first), Some(last)) => open + step(*last, *first),
        _ => open,
    }
}
