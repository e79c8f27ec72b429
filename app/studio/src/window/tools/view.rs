//! From the ground to the screen.

use eframe::egui::{Pos2, Rect, pos2};
use glam::DVec3;
use relievo_engine::Engine;
use relievo_engine::planet::camera::Basis;
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::Vertex;

/// A point counts as hidden when the ground before it is nearer by this share of its distance.
const HIDDEN: f64 = 0.01;

/// What puts places of the drawn ground on the screen.
pub(crate) struct Projector<'a> {
    engine: &'a Engine,
    rect: Rect,
    eye: DVec3,
    basis: Basis,
    /// Tangents of half the fields of view.
    half: [f64; 2],
    radius_m: f64,
    exaggeration: f64,
}

impl<'a> Projector<'a> {
    /// For a camera's picture in a rectangle.
    pub(crate) fn new(engine: &'a Engine, camera: &Camera, rect: Rect) -> Self {
        let planet = engine.project().planet.body.figure();
        let half_y = (0.5 * camera.fov_y_rad).tan();
        Self {
            engine,
            rect,
            eye: camera.eye(&planet),
            basis: camera.basis(&planet),
            half: [half_y * f64::from(rect.aspect_ratio()), half_y],
            radius_m: planet.radius_m,
            exaggeration: engine.exaggeration(),
        }
    }

    /// A place on the drawn ground in the world, metres.
    pub(crate) fn world(&self, point: MapPoint) -> DVec3 {
        let height_m = self.engine.ground_m(point) * self.exaggeration;
        point.to_unit() * (self.radius_m + height_m)
    }

    /// Where a place of the ground is on the screen, also outside of the rectangle; `None` behind the
    /// eye and behind the planet.
    pub(crate) fn screen(&self, point: MapPoint) -> Option<Pos2> {
        let world = self.world(point);
        let to = world - self.eye;
        // On the far side of the ball, with room for what stands above it.
        let radius = world.length();
        if self.eye.length() > radius && to.dot(world) > 0.02 * to.length() * radius {
            return None;
        }
        let view = self.basis.view_from_world(to);
        if view.z <= 1e-3 {
            return None;
        }
        let ndc = [
            view.x / (view.z * self.half[0]),
            view.y / (view.z * self.half[1]),
        ];
        if ndc.iter().any(|v| v.abs() > 50.0) {
            return None;
        }
        let size = self.rect.size() * 0.5;
        let centre = self.rect.center();
        Some(pos2(
            centre.x + ndc[0] as f32 * size.x,
            centre.y - ndc[1] as f32 * size.y,
        ))
    }

    /// Where a place is on the screen, if it is inside the picture and no ground stands before it.
    pub(crate) fn visible(&self, point: MapPoint) -> Option<Pos2> {
        let at = self.screen(point).filter(|at| self.rect.contains(*at))?;
        let to = self.world(point) - self.eye;
        let (hit, _) = self.engine.cast(self.eye, to)?;
        let nearer = (self.world(hit) - self.eye).length() < to.length() * (1.0 - HIDDEN) - 1.0;
        (!nearer).then_some(at)
    }

    /// The way between two places over the ground, as runs of points on the screen.
    pub(crate) fn draped(&self, from: MapPoint, to: MapPoint) -> Vec<Vec<Pos2>> {
        let (a, b) = (from.to_unit(), to.to_unit());
        let steps = match (self.screen(from), self.screen(to)) {
            (Some(a), Some(b)) => ((a.distance(b) / 12.0).ceil() as usize).clamp(1, 48),
            _ => 48,
        };
        self.runs((0..=steps).map(|i| {
            let share = i as f64 / steps as f64;
            MapPoint::from_direction(a.lerp(b, share))
        }))
    }

    /// A line through places of the ground, as runs of points on the screen.
    pub(crate) fn runs(&self, places: impl Iterator<Item = MapPoint>) -> Vec<Vec<Pos2>> {
        let mut runs: Vec<Vec<Pos2>> = vec![Vec::new()];
        for point in places {
            match (self.screen(point), runs.last_mut()) {
                (Some(at), Some(run)) => run.push(at),
                (None, Some(run)) if !run.is_empty() => runs.push(Vec::new()),
                _ => {}
            }
        }
        runs.retain(|run| run.len() > 1);
        runs
    }
}

/// A stored vertex on the map.
pub(crate) fn place(vertex: &Vertex) -> MapPoint {
    MapPoint::from_degrees(vertex.lon_deg, vertex.lat_deg).normalised()
}

/// A place of the map as a vertex beside `near`: longitudes of neighbours differ by less than half a
/// turn, also across the antimeridian.
pub(crate) fn vertex(point: MapPoint, near: Option<&Vertex>) -> Vertex {
    let (mut lon_deg, lat_deg) = point.to_degrees();
    if let Some(near) = near {
        lon_deg += 360.0 * ((near.lon_deg - lon_deg) / 360.0).round();
        if lon_deg.abs() > 360.0 {
            lon_deg -= 360.0 * lon_deg.signum();
        }
    }
    Vertex::new(lon_deg, lat_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_across_the_antimeridian_goes_on_beyond_180() {
        let near = Vertex::new(179.9, 10.0);
        let next = vertex(MapPoint::from_degrees(-179.8, 10.0), Some(&near));
        assert!((next.lon_deg - 180.2).abs() < 1e-9, "{next:?}");
        assert!(place(&next).angle_to(MapPoint::from_degrees(-179.8, 10.0)) < 1e-12);
        let alone = vertex(MapPoint::from_degrees(-179.8, 10.0), None);
        assert!((alone.lon_deg + 179.8).abs() < 1e-9);
    }
}
