//! The outline of the selected layer's lens over the picture, and its handles.

use eframe::egui::{Color32, CornerRadius, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};
use glam::{DVec2, DVec3};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{Lens, LensShape};

use super::grip::{Grip, handles};
use super::shape;
use crate::window::studio::Studio;
use crate::window::tools::paint::{BAND, SELECTED};
use crate::window::tools::view::Projector;

/// Parts of the drawn circle.
const PARTS: u32 = 96;

/// Parts of a drawn edge: one for so many points of the screen, and at most.
const PART: f32 = 12.0;
const MOST_PARTS: usize = 64;

impl Studio {
    /// The outline of the selected layer's lens.
    pub(in crate::window::tools) fn paint_lens(
        &self,
        painter: &Painter,
        projector: &Projector<'_>,
        stroke: Stroke,
    ) {
        let Some(lens) = self.lens() else { return };
        let runs = match &lens.shape {
            LensShape::Circle { radius_m } => self.rim(projector, lens, *radius_m),
            LensShape::Polygon { corners_m } => self.edges(projector, lens, corners_m),
        };
        for run in runs {
            painter.add(Shape::line(run, stroke));
        }
    }

    fn rim(&self, projector: &Projector<'_>, lens: &Lens, radius_m: f64) -> Vec<Vec<Pos2>> {
        let planet = self.document.project().planet.body.figure();
        let centre = MapPoint::from_degrees(lens.lon_deg, lens.lat_deg).to_unit();
        let (sin, cos) = (radius_m / planet.radius_m).sin_cos();
        let east = DVec3::Z.cross(centre).try_normalize().unwrap_or(DVec3::X);
        let north = centre.cross(east);
        let places = (0..=PARTS).map(|k| {
            let turn = core::f64::consts::TAU * f64::from(k) / f64::from(PARTS);
            let away = east * turn.sin() + north * turn.cos();
            MapPoint::from_direction(centre * cos + away * sin)
        });
        projector.runs(places)
    }

    /// The edges are straight in the lens's plane, and bent as the ground is on the screen.
    fn edges(
        &self,
        projector: &Projector<'_>,
        lens: &Lens,
        corners_m: &[[f64; 2]],
    ) -> Vec<Vec<Pos2>> {
        let planet = self.document.project().planet.body.figure();
        let frame = shape::frame(planet, lens);
        let corners: Vec<DVec2> = corners_m.iter().map(|c| DVec2::from_array(*c)).collect();
        let next = corners.iter().cycle().skip(1);
        let mut places = Vec::new();
        for (a, b) in corners.iter().zip(next) {
            let ends = [a, b].map(|c| projector.screen(frame.to_map(*c)));
            let parts = match ends {
                [Some(a), Some(b)] => ((a.distance(b) / PART).ceil() as usize).clamp(1, MOST_PARTS),
                _ => MOST_PARTS,
            };
            let points = (0..parts).map(|k| a.lerp(*b, k as f64 / parts as f64));
            places.extend(points.map(|p| frame.to_map(p)));
        }
        places.extend(places.first().copied());
        projector.runs(places.into_iter())
    }

    /// The handles of the selected layer's polygon.
    pub(in crate::window::tools) fn paint_lens_handles(
        &self,
        painter: &Painter,
        projector: &Projector<'_>,
    ) {
        let Some(lens) = self.lens().filter(|_| self.lens_layer().is_some()) else {
            return;
        };
        let planet = self.document.project().planet.body.figure();
        let chosen = self.chosen_corner();
        let rim = Color32::from_gray(20);
        for (grip, place) in handles(projector, planet, lens) {
            let Some(at) = projector.visible(place) else {
                continue;
            };
            let is_meant = self.tools.lens.hover == Some(grip);
            match grip {
                Grip::Corner(index) => {
                    let fill = if chosen == Some(index) {
                        BAND
                    } else {
                        SELECTED
                    };
                    let side = if is_meant { 12.0 } else { 9.0 };
                    painter.rect(
                        Rect::from_center_size(at, vec2(side, side)),
                        CornerRadius::same(2),
                        fill,
                        Stroke::new(1.5, rim),
                        StrokeKind::Inside,
                    );
                }
                Grip::Middle(_) => {
                    let (radius, fill) = if is_meant {
                        (5.0, SELECTED)
                    } else {
                        (3.0, SELECTED.gamma_multiply(0.6))
                    };
                    painter.circle(at, radius, fill, Stroke::new(1.0, rim));
                }
                Grip::Whole(_) | Grip::Centre => {}
            }
        }
    }
}
