//! What holds for every element: no jumps, no effect beyond the reach, precedence, one answer.

mod agreement;
mod brushes;
#[path = "../common/mod.rs"]
mod common;
mod odd_drawings;
mod slopes;

use std::sync::Arc;

use glam::DVec2;
use relievo_earthwork::{Element, Frame, Section, Shape, Shaped, Side, Stroke, Surface, Tool};

use common::{corridor, platform, polygon, shaped, shaped_on};

fn stroke(frame: &Frame, tool: Tool, radius_m: f64, points: &[(f64, f64)]) -> Element {
    Element {
        shape: Shape::Brush(vec![Stroke {
            tool,
            radius_m,
            hardness: 0.4,
            points: points
                .iter()
                .map(|(x, y)| frame.to_map(DVec2::new(*x, *y)))
                .collect(),
        }]),
        side: Side::default(),
    }
}

/// A few elements of every kind around a frame's origin.
fn mixed(frame: &Frame) -> Vec<Arc<Shaped>> {
    let ell = [
        (-60.0, -60.0),
        (40.0, -60.0),
        (40.0, -20.0),
        (-20.0, -20.0),
        (-20.0, 50.0),
        (-60.0, 50.0),
    ];
    let plane = Surface::Plane {
        height_m: 12.0,
        slope_percent: 8.0,
        aspect_deg: 30.0,
    };
    let road = Section::Road {
        width_m: 9.0,
        crossfall_percent: 3.0,
    };
    let line = [
        (-150.0, 80.0, 3.0),
        (-20.0, 90.0, 9.0),
        (60.0, 20.0, 6.0),
        (160.0, 40.0, 14.0),
    ];
    let ground = |p: DVec2| 0.02 * p.x - 0.01 * p.y;
    vec![
        shaped(frame, platform(frame, &ell, 10.0)),
        shaped(frame, corridor(frame, &line, road, Side::default())),
        shaped(
            frame,
            stroke(
                frame,
                Tool::Raise { strength_m: 4.0 },
                30.0,
                &[(0.0, 0.0), (80.0, 80.0)],
            ),
        ),
        shaped(
            frame,
            polygon(
                frame,
                &[(60.0, -90.0), (120.0, -80.0), (90.0, -30.0)],
                plane,
                Side::default(),
            ),
        ),
        shaped_on(
            frame,
            polygon(
                frame,
                &[(-120.0, -100.0), (-80.0, -110.0), (-90.0, -60.0)],
                Surface::Offset { offset_m: -3.0 },
                Side::default(),
            ),
            ground,
        ),
        shaped_on(
            frame,
            stroke(
                frame,
                Tool::Smooth { strength: 0.8 },
                25.0,
                &[(-100.0, 0.0), (-40.0, -80.0)],
            ),
            ground,
        ),
        shaped(
            frame,
            stroke(
                frame,
                Tool::Flatten {
                    height_m: 2.0,
                    strength: 0.7,
                },
                20.0,
                &[(100.0, 0.0)],
            ),
        ),
    ]
}
