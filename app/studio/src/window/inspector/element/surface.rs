//! Heights inside a polygon.

use eframe::egui::Ui;
use relievo_engine::project::{Edit, ElementKind, Polygon, SurfaceKind};

use super::{HEIGHT, OFFSET, Shown, replace};
use crate::window::action::Action;
use crate::window::controls::{self, Number};

const SLOPE: Number =
    Number::new("Slope", "How much the plane falls", 0.0..=200.0, 2.0).unit(" %", 2);

const ASPECT: Number = Number::new(
    "Falls towards",
    "Direction in which the plane falls, clockwise from north",
    0.0..=360.0,
    180.0,
)
.unit("°", 1);

/// Surfaces to choose from.
#[derive(Clone, Copy, PartialEq)]
enum SurfaceName {
    Platform,
    Plane,
    Tin,
    Offset,
    Smooth,
    Other,
}

const SURFACES: [(SurfaceName, &str); 5] = [
    (SurfaceName::Platform, "Platform"),
    (SurfaceName::Plane, "Plane"),
    (SurfaceName::Tin, "Through vertices"),
    (SurfaceName::Offset, "Ground, shifted"),
    (SurfaceName::Smooth, "Smooth infill"),
];

fn with_polygon(shown: &Shown<'_>, change: impl FnOnce(&mut Polygon)) -> Edit {
    replace(shown, |element| {
        if let ElementKind::Polygon(polygon) = &mut element.kind {
            change(polygon);
        }
    })
}

/// Draws them.
pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, polygon: &Polygon, actions: &mut Vec<Action>) {
    let kind = &polygon.surface.kind;
    let (now, height_m) = match kind {
        SurfaceKind::Platform { height_m } => (SurfaceName::Platform, *height_m),
        SurfaceKind::Plane { height_m, .. } => (SurfaceName::Plane, *height_m),
        SurfaceKind::Tin => (SurfaceName::Tin, 0.0),
        SurfaceKind::Offset { .. } => (SurfaceName::Offset, 0.0),
        SurfaceKind::Smooth => (SurfaceName::Smooth, 0.0),
        SurfaceKind::Unknown { .. } => (SurfaceName::Other, 0.0),
    };
    let hint = "How the heights inside are made";
    controls::choice(ui, "Surface", hint, &SURFACES, now, actions, |chosen| {
        let new = match chosen {
            SurfaceName::Platform => SurfaceKind::Platform { height_m },
            SurfaceName::Plane => SurfaceKind::Plane {
                height_m,
                slope_percent: 2.0,
                aspect_deg: 180.0,
            },
            SurfaceName::Tin => SurfaceKind::Tin,
            SurfaceName::Offset => SurfaceKind::Offset { offset_m: 0.0 },
            SurfaceName::Smooth => SurfaceKind::Smooth,
            SurfaceName::Other => kind.clone(),
        };
        with_polygon(shown, |p| p.surface.kind = new)
    });
    let set = |kind: SurfaceKind| with_polygon(shown, |p| p.surface.kind = kind);
    match *kind {
        SurfaceKind::Platform { height_m } => {
            controls::number(ui, &HEIGHT, height_m, actions, |height_m| {
                set(SurfaceKind::Platform { height_m })
            });
        }
        SurfaceKind::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => {
            let plane = |height_m, slope_percent, aspect_deg| {
                set(SurfaceKind::Plane {
                    height_m,
                    slope_percent,
                    aspect_deg,
                })
            };
            controls::number(ui, &HEIGHT, height_m, actions, |v| {
                plane(v, slope_percent, aspect_deg)
            });
            controls::number(ui, &SLOPE, slope_percent, actions, |v| {
                plane(height_m, v, aspect_deg)
            });
            let aspect = aspect_deg.rem_euclid(360.0);
            controls::number(ui, &ASPECT, aspect, actions, |v| {
                plane(height_m, slope_percent, v)
            });
        }
        SurfaceKind::Offset { offset_m } => {
            controls::number(ui, &OFFSET, offset_m, actions, |offset_m| {
                set(SurfaceKind::Offset { offset_m })
            });
        }
        SurfaceKind::Tin | SurfaceKind::Smooth | SurfaceKind::Unknown { .. } => {}
    }
}
