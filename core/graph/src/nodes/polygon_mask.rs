//! A mask by place: a polygon on the ground.

use glam::{DVec2, I64Vec2};
use relievo_earthwork::Frame;
use relievo_planet::{Grid, GridCrs, MapPoint, Planet};
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use super::memory::add_grid;
use super::range_mask::faded;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "polygon mask";

/// Corners farther from the centre than this are none, metres: beyond any planet, and squares of
/// lengths stay finite.
const FARTHEST_M: f64 = 1e15;

/// Distance from the frame's origin beyond which nothing is said of how it stretches, radians: it tears
/// at the antipode.
const FARTHEST_RAD: f64 = 3.0;

/// 1 inside a polygon by the even-odd rule, fading smoothly to 0 by the distance to its outline. No
/// inputs.
///
/// The polygon lies in an azimuthal equidistant frame ([`Frame`]) around a centre: its edges are straight
/// there, and distances are lengths in that plane. Tiles that neither outline nor fade touch are uniform:
/// moving or shaping the polygon makes only those again that it enters or leaves.
#[derive(Clone, Debug)]
pub struct PolygonMask {
    planet: Planet,
    frame: Frame,
    /// None where there is no polygon.
    edges: Vec<Edge>,
    fade_m: f64,
    /// Radius around the centre that holds outline and fade.
    farthest_m: f64,
}

/// An edge of the outline.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: DVec2,
    along: DVec2,
    /// 1 over the square of its length; 0 where both ends are the same.
    per_square: f64,
    min: DVec2,
    max: DVec2,
}

impl Edge {
    fn new(from: DVec2, to: DVec2) -> Self {
        let along = to - from;
        let square = along.length_squared();
        Self {
            from,
            along,
            per_square: if square > 0.0 { 1.0 / square } else { 0.0 },
            min: from.min(to),
            max: from.max(to),
        }
    }

    /// Square of the distance to a point.
    #[inline(always)]
    fn distance_squared(&self, point: DVec2) -> f64 {
        let to = point - self.from;
        let share = (to.dot(self.along) * self.per_square).clamp(0.0, 1.0);
        (to - self.along * share).length_squared()
    }

    /// Whether a ray eastward from a point crosses it. Only where [`Self::may_cross`] says so for any
    /// rectangle with the point.
    #[inline(always)]
    fn is_crossed(&self, point: DVec2) -> bool {
        if !(self.min.y <= point.y && point.y < self.max.y && point.x < self.max.x) {
            return false;
        }
        if point.x < self.min.x {
            return true;
        }
        let share = (point.y - self.from.y) / self.along.y;
        point.x < self.from.x + share * self.along.x
    }

    /// Whether rays eastward from a rectangle may cross it.
    fn may_cross(&self, area: &Area) -> bool {
        self.min.y <= area.max.y && area.min.y < self.max.y && area.min.x < self.max.x
    }

    /// Whether it may lie within a distance of something in a rectangle.
    fn may_reach(&self, area: &Area, distance_m: f64) -> bool {
        let gap = (self.min - area.max).max(area.min - self.max);
        gap.max_element() <= distance_m
    }
}

/// A rectangle of the frame's plane.
#[derive(Clone, Copy, Debug)]
struct Area {
    min: DVec2,
    max: DVec2,
}

/// The edges that decide the weights of a rectangle.
#[derive(Debug, Default)]
struct Near {
    /// For the even-odd rule.
    crossed: Vec<Edge>,
    /// For the fade.
    reached: Vec<Edge>,
}

impl PolygonMask {
    /// `corners_m` in metres east and north in the frame at `centre`; fewer than three, or any that is no
    /// number, leave nothing inside. `fade_m` in metres; what is not above 0 is none.
    pub fn new(planet: &Planet, centre: MapPoint, corners_m: &[[f64; 2]], fade_m: f64) -> Self {
        let corners: Vec<DVec2> = corners_m.iter().map(|c| DVec2::from_array(*c)).collect();
        let is_place = |c: &DVec2| c.is_finite() && c.abs().max_element() <= FARTHEST_M;
        let is_polygon = corners.len() >= 3
            && corners.iter().all(is_place)
            && centre.lon_rad.is_finite()
            && centre.colat_rad.is_finite();
        let next = corners.iter().cycle().skip(1);
        let edges: Vec<Edge> = if is_polygon {
            let pairs = corners.iter().zip(next);
            pairs.map(|(a, b)| Edge::new(*a, *b)).collect()
        } else {
            Vec::new()
        };
        let fade_m = if fade_m > 0.0 && fade_m.is_finite() {
            fade_m
        } else {
            0.0
        };
        let distances = edges.iter().map(|edge| edge.from.length());
        Self {
            planet: *planet,
            frame: Frame::new(*planet, centre),
            farthest_m: distances.fold(0.0, f64::max) + fade_m,
            edges,
            fade_m,
        }
    }

    /// Weight at a point of the frame, with all edges that may matter there.
    fn weight(&self, point: DVec2, near: &Near) -> f32 {
        let crossings = near.crossed.iter().filter(|e| e.is_crossed(point)).count();
        if crossings % 2 == 1 {
            return 1.0;
        }
        let squares = near.reached.iter().map(|e| e.distance_squared(point));
        let distance_m = squares.fold(f64::INFINITY, f64::min).sqrt();
        if distance_m >= self.fade_m {
            0.0
        } else {
            faded((distance_m / self.fade_m) as f32, 1.0)
        }
    }

    /// The edges that matter in a rectangle.
    fn near(&self, area: &Area, near: &mut Near) {
        near.crossed.clear();
        near.reached.clear();
        let edges = self.edges.iter();
        near.crossed
            .extend(edges.clone().filter(|e| e.may_cross(area)));
        if self.fade_m > 0.0 {
            // Room for rounding: what is left out is farther than the fade for certain.
            let reach_m = self.fade_m * (1.0 + 1e-9) + self.slack_m();
            near.reached
                .extend(edges.filter(|e| e.may_reach(area, reach_m)));
        }
    }

    /// Weights of points of the frame; 0 where there is none.
    fn row(&self, points: &[Option<DVec2>], near: &mut Near, out: &mut [f32]) {
        let known = points.iter().flatten();
        let area = known.fold(None, |area: Option<Area>, point| {
            let (min, max) = area.map_or((*point, *point), |a| (a.min, a.max));
            Some(Area {
                min: min.min(*point),
                max: max.max(*point),
            })
        });
        let Some(area) = area else {
            out.fill(0.0);
            return;
        };
        self.near(&area, near);
        if near.crossed.is_empty() && near.reached.is_empty() {
            out.fill(0.0);
            return;
        }
        for (weight, point) in out.iter_mut().zip(points) {
            *weight = point.map_or(0.0, |point| self.weight(point, near));
        }
    }

    /// More than rounding takes from a place in the frame.
    fn slack_m(&self) -> f64 {
        1e-9 * self.planet.equatorial_radius_m
    }

    /// What all samples of a part of the map have, where outline and fade do not touch it.
    fn uniform(&self, grid: &Grid) -> Option<f32> {
        if self.edges.is_empty() {
            return Some(0.0);
        }
        if grid.lattice.crs != GridCrs::Map || grid.rect.is_empty() {
            return None;
        }
        let (first, last) = (
            grid.lattice.centre(grid.rect.min),
            grid.lattice.centre(grid.rect.max - I64Vec2::ONE),
        );
        let middle = 0.5 * (first + last);
        let half = 0.5 * (last - first).abs();
        // Along the meridian to a sample's row and along the row to the sample is no shortcut.
        let widest = (libm::sin(middle.y).abs() + half.y).min(1.0);
        let spread_rad = half.y + half.x * widest + 1e-12;
        let place = MapPoint::new(middle.x, middle.y);
        let angle_rad = place.angle_to(self.frame.origin());
        let e2 = self.planet.eccentricity_squared();
        let equator_m = self.planet.equatorial_radius_m;
        // No radius of curvature is smaller than that of the meridian at the equator, so no place is
        // nearer to the frame's origin than by it.
        let nearest_m = (angle_rad - spread_rad) * equator_m * (1.0 - e2);
        if nearest_m > self.farthest_m + self.slack_m() {
            return Some(0.0);
        }
        let farthest_rad = angle_rad + spread_rad;
        if farthest_rad > FARTHEST_RAD {
            return None;
        }
        // The frame is azimuthal equidistant on the sphere of directions, which stretches lengths across
        // the direction to the origin by angle / sin(angle) and no length by more; then both axes are
        // scaled by radii of curvature at the middle of the way, of which none is above `largest_m` and
        // whose change is the second part: the middle moves by 1 / (2 cos(angle / 2)) of the way at most.
        let stretch = (farthest_rad / libm::sin(farthest_rad)).max(1.0);
        let root = (1.0 - e2).sqrt();
        let largest_m = equator_m / root;
        let change_m = 1.5 * equator_m * e2 / (root * root * root);
        let spread_m = spread_rad
            * (largest_m * stretch
                + farthest_rad * change_m / (2.0 * libm::cos(0.5 * farthest_rad)))
            + self.slack_m();
        let point = self
            .frame
            .at(&self.frame.row(middle.y), &self.frame.column(middle.x));
        let squares = self.edges.iter().map(|e| e.distance_squared(point));
        let distance_m = squares.fold(f64::INFINITY, f64::min).sqrt();
        let crossings = self.edges.iter().filter(|e| e.is_crossed(point)).count();
        if crossings % 2 == 1 {
            (distance_m > spread_m).then_some(1.0)
        } else {
            (distance_m > spread_m + self.fade_m).then_some(0.0)
        }
    }
}

impl ImageNode for PolygonMask {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Mask
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        let origin = self.frame.origin();
        id.float(origin.lon_rad).float(origin.colat_rad);
        id.int(self.edges.len() as i64);
        id.float(self.planet.equatorial_radius_m);
        id.float(self.planet.eccentricity_squared());
        for edge in &self.edges {
            id.float(edge.from.x).float(edge.from.y);
        }
        id.float(self.fade_m);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        self.uniform(grid)
            .map_or(Known::Nothing, |v| Known::Uniform([v, 0.0, 0.0, 0.0]))
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let width = out.width().max(1);
        let rows = out.plane_mut(0).chunks_exact_mut(width).zip(rect.min.y..);
        let mut points = vec![None; width];
        let mut near = Near::default();
        if lattice.crs == GridCrs::Map {
            let columns: Vec<_> = (rect.min.x..rect.max.x)
                .map(|x| self.frame.column(lattice.centre(I64Vec2::new(x, 0)).x))
                .collect();
            for (out, y) in rows {
                if job.cancel.is_cancelled() {
                    return Err(RenderError::Cancelled);
                }
                let row = self.frame.row(lattice.centre(I64Vec2::new(0, y)).y);
                for (point, column) in points.iter_mut().zip(&columns) {
                    *point = Some(self.frame.at(&row, column));
                }
                self.row(&points, &mut near, out);
            }
            return Ok(());
        }
        let ground = Ground::new(lattice, KIND)?;
        for (out, y) in rows {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for (point, x) in points.iter_mut().zip(rect.min.x..) {
                let place = ground.point(I64Vec2::new(x, y).as_dvec2() + 0.5);
                *point = place.map(|place| self.frame.from_map(place));
            }
            self.row(&points, &mut near, out);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
