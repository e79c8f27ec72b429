//! Whether a grid meets a source at all, from outlines alone.

use core::f64::consts::{PI, TAU};
use std::collections::HashMap;

use glam::DVec2;
use parking_lot::Mutex;
use relievo_planet::map::wrap_longitude;
use relievo_planet::{Grid, GridCrs, SampleRect};

use super::plane::{SourcePlane, lonlat_from_plane};
use super::{Coverage, plane};

/// Points along a side when an outline is followed through a projection.
const POINTS: usize = 25;

/// Grids whose coverage is remembered; each takes about 100 bytes.
const REMEMBERED: usize = 16_384;

/// What was found for grids of the map: following an outline through a projection takes long, and
/// names are asked for whenever a project changes.
#[derive(Debug)]
pub(super) struct Memory<T>(Mutex<HashMap<Place, T>>);

/// A map grid by its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Place {
    origin: [u64; 2],
    step: [u64; 2],
    rect: SampleRect,
}

impl<T> Default for Memory<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Copy> Memory<T> {
    /// What is so of a grid, found by `find` unless it is remembered.
    pub(super) fn of(&self, grid: &Grid, find: impl FnOnce() -> T) -> T {
        let lattice = &grid.lattice;
        if lattice.crs != GridCrs::Map {
            return find();
        }
        let place = Place {
            origin: lattice.origin.to_array().map(f64::to_bits),
            step: lattice.step.to_array().map(f64::to_bits),
            rect: grid.rect,
        };
        if let Some(known) = self.0.lock().get(&place) {
            return *known;
        }
        let found = find();
        let mut remembered = self.0.lock();
        if remembered.len() >= REMEMBERED {
            remembered.clear();
        }
        remembered.insert(place, found);
        found
    }
}

/// A region of the map between two meridians and two parallels, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Westernmost longitude, on any turn.
    west: f64,
    /// Width in longitude; a full turn or more is the whole globe.
    width: f64,
    /// Lowest and highest latitude.
    south: f64,
    north: f64,
}

impl Extent {
    const GLOBE: Self = Self {
        west: -PI,
        width: TAU,
        south: -PI,
        north: PI,
    };

    fn overlaps(&self, other: &Self) -> bool {
        let reaches = |a: &Self, b: &Self| (b.west - a.west).rem_euclid(TAU) <= a.width;
        self.south <= other.north
            && other.south <= self.north
            && (reaches(self, other) || reaches(other, self))
    }

    fn contains(&self, other: &Self) -> bool {
        let offset = (other.west - self.west).rem_euclid(TAU);
        let lons = self.width >= TAU || offset + other.width <= self.width;
        lons && self.south <= other.south && other.north <= self.north
    }

    fn grown(self, margin: f64) -> Self {
        let widened = Self {
            west: self.west - margin,
            width: self.width + 2.0 * margin,
            ..self
        };
        Self {
            south: self.south - margin,
            north: self.north + margin,
            ..widened
        }
    }

    /// The extent of `POINTS`² points of a plane's rectangle, grown by the largest distance
    /// between neighbours; the globe if some point has no place.
    fn around(place: impl Fn(DVec2) -> Option<DVec2>) -> Self {
        let mut points = Vec::with_capacity(POINTS * POINTS);
        for i in 0..POINTS * POINTS {
            let at = DVec2::new((i % POINTS) as f64, (i / POINTS) as f64) / (POINTS - 1) as f64;
            match place(at) {
                Some(p) => points.push(p),
                None => return Self::GLOBE,
            }
        }
        let origin = points[points.len() / 2].x;
        for p in &mut points {
            p.x = wrap_longitude(p.x - origin);
        }
        let mut gap = 0.0_f64;
        for (i, p) in points.iter().enumerate() {
            let east = points.get(i + 1).filter(|_| i % POINTS + 1 < POINTS);
            for q in [east, points.get(i + POINTS)].into_iter().flatten() {
                gap = gap.max((p.x - q.x).abs()).max((p.y - q.y).abs());
            }
        }
        let low = points
            .iter()
            .copied()
            .reduce(DVec2::min)
            .unwrap_or_default();
        let high = points
            .iter()
            .copied()
            .reduce(DVec2::max)
            .unwrap_or_default();
        // Longitudes that jump show a pole or the seam inside: no box is safe but the globe.
        if gap > 0.5 {
            return Self {
                south: low.y - gap.min(PI),
                north: high.y + gap.min(PI),
                ..Self::GLOBE
            };
        }
        Self {
            west: origin + low.x,
            width: high.x - low.x,
            south: low.y,
            north: high.y,
        }
        .grown(gap)
    }
}

/// The extent of a source, never too small.
pub(crate) fn of_source(source: &SourcePlane) -> Extent {
    if source.is_upright_geographic() {
        return upright(source);
    }
    Extent::around(|at| {
        let p = source.plane_from_pixel.transform_point2(at * source.size);
        lonlat_from_plane(&source.crs, p).map(|p| DVec2::new(p.x, p.y))
    })
}

fn upright(source: &SourcePlane) -> Extent {
    let (a, b) = (
        source.plane_from_pixel.translation,
        source.plane_from_pixel.transform_point2(source.size),
    );
    let (low, high) = (a.min(b).map(f64::to_radians), a.max(b).map(f64::to_radians));
    let whole = source.columns_around.is_some();
    let (mut south, mut north) = (low.y, high.y);
    if source.reflects == [true; 2] {
        (south, north) = (-PI, PI);
    }
    Extent {
        west: low.x,
        width: if whole {
            TAU
        } else {
            (high.x - low.x).min(TAU)
        },
        south,
        north,
    }
}

/// The extent of a grid's samples, never too small; `None` for an empty one.
fn of_grid(grid: &Grid) -> Option<Extent> {
    if grid.rect.is_empty() {
        return None;
    }
    let corner = |p: glam::I64Vec2| grid.lattice.origin + p.as_dvec2() * grid.lattice.step;
    let (a, b) = (corner(grid.rect.min), corner(grid.rect.max));
    let (low, high) = (a.min(b), a.max(b));
    match &grid.lattice.crs {
        GridCrs::Map => {
            if low.y < 0.0 || high.y > PI {
                return Some(Extent::GLOBE);
            }
            let half = PI / 2.0;
            Some(Extent {
                west: low.x,
                width: (high.x - low.x).min(TAU),
                south: half - high.y,
                north: half - low.y,
            })
        }
        GridCrs::Projected(name) => {
            let Ok(crs) = plane::parse_crs(name) else {
                return Some(Extent::GLOBE);
            };
            if crs.is_geographic() {
                let (low, high) = (low.map(f64::to_radians), high.map(f64::to_radians));
                return Some(Extent {
                    west: low.x,
                    width: (high.x - low.x).min(TAU),
                    south: low.y,
                    north: high.y,
                });
            }
            Some(Extent::around(|at| {
                lonlat_from_plane(&crs, a + at * (b - a))
            }))
        }
    }
}

/// See [`super::Warp::coverage`].
pub(crate) fn coverage(source: &SourcePlane, extent: &Extent, grid: &Grid) -> Coverage {
    let Some(of_grid) = of_grid(grid) else {
        return Coverage::Outside;
    };
    // A hair for rounding; kernels need no margin, since samples outside of the outline are holes.
    if !extent.grown(1e-12).overlaps(&of_grid) {
        return Coverage::Outside;
    }
    let inside = if source.is_upright_geographic() {
        extent.contains(&of_grid.grown(1e-12))
    } else {
        inside_by_points(source, grid)
    };
    if inside {
        Coverage::Inside
    } else {
        Coverage::Partial
    }
}

/// Whether a grid's corners and middles lie well inside a source that is not upright.
fn inside_by_points(source: &SourcePlane, grid: &Grid) -> bool {
    span(source, grid).is_some_and(|[low, high]| {
        low.cmpge(DVec2::splat(1e-6)).all() && high.cmple(source.size - 1e-6).all()
    })
}

/// Between which pixels of the full image, continuous, a grid lies; never too narrow. `None` where part of it
/// has no place there.
pub(crate) fn span(source: &SourcePlane, grid: &Grid) -> Option<[DVec2; 2]> {
    const SIDE: usize = 5;
    let corner = |p: glam::I64Vec2| grid.lattice.origin + p.as_dvec2() * grid.lattice.step;
    let (a, b) = (corner(grid.rect.min), corner(grid.rect.max));
    let crs = match &grid.lattice.crs {
        GridCrs::Map => None,
        GridCrs::Projected(name) => match plane::parse_crs(name) {
            Ok(crs) => Some(crs),
            Err(_) => return None,
        },
    };
    let pixels: Option<Vec<DVec2>> = (0..SIDE * SIDE)
        .map(|i| {
            let p =
                a + (b - a) * DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) / (SIDE - 1) as f64;
            let mut lonlat = match &crs {
                None => DVec2::new(p.x, PI / 2.0 - p.y),
                Some(crs) => lonlat_from_plane(crs, p)?,
            };
            if source.crs.is_geographic() {
                let near = source.centre().x.to_radians();
                lonlat.x = near + wrap_longitude(lonlat.x - near);
            }
            Some(
                source
                    .pixel_from_plane
                    .transform_point2(plane::plane_from_lonlat(&source.crs, lonlat)?),
            )
        })
        .collect();
    let pixels = pixels?;
    if !pixels.iter().all(|p| p.is_finite()) {
        return None;
    }
    // Between points a smooth map strays by less than a quarter of their distance.
    let mut stride = DVec2::ZERO;
    for (i, p) in pixels.iter().enumerate() {
        let east = pixels.get(i + 1).filter(|_| i % SIDE + 1 < SIDE);
        for q in [east, pixels.get(i + SIDE)].into_iter().flatten() {
            stride = stride.max((*p - *q).abs());
        }
    }
    let margin = stride * 0.25;
    let low = pixels.iter().copied().reduce(DVec2::min)?;
    let high = pixels.iter().copied().reduce(DVec2::max)?;
    Some([low - margin, high + margin])
}
