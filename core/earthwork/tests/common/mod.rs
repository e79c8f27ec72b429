//! Elements drawn in metres around a place.
#![allow(dead_code, reason = "each test file uses some of these")]

use std::sync::Arc;

use glam::DVec2;
use relievo_earthwork::{
    Corridor, Design, Element, Frame, Outcome, Polygon, Prepared, Profile, Samples, Section, Shape,
    Shaped, Side, Surface, Vertex,
};
use relievo_planet::{MapPoint, Planet};

/// A place to build at.
pub(crate) fn alps() -> Frame {
    Frame::new(Planet::EARTH, MapPoint::from_degrees(11.4, 47.2))
}

pub(crate) fn vertices(frame: &Frame, points: &[(f64, f64)], height_m: Option<f64>) -> Vec<Vertex> {
    points
        .iter()
        .map(|(x, y)| Vertex {
            place: frame.to_map(DVec2::new(*x, *y)),
            height_m,
        })
        .collect()
}

pub(crate) fn polygon(
    frame: &Frame,
    outline: &[(f64, f64)],
    surface: Surface,
    side: Side,
) -> Element {
    Element {
        shape: Shape::Polygon(Polygon {
            outline: vertices(frame, outline, None),
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface,
        }),
        side,
    }
}

pub(crate) fn platform(frame: &Frame, outline: &[(f64, f64)], height_m: f64) -> Element {
    polygon(
        frame,
        outline,
        Surface::Platform { height_m },
        Side::default(),
    )
}

pub(crate) fn square(half: f64) -> [(f64, f64); 4] {
    [(-half, -half), (half, -half), (half, half), (-half, half)]
}

pub(crate) fn corridor(
    frame: &Frame,
    line: &[(f64, f64, f64)],
    section: Section,
    side: Side,
) -> Element {
    let line = line
        .iter()
        .map(|(x, y, h)| Vertex {
            place: frame.to_map(DVec2::new(*x, *y)),
            height_m: Some(*h),
        })
        .collect();
    Element {
        shape: Shape::Corridor(Corridor {
            line,
            profile: Profile::Heights,
            section,
        }),
        side,
    }
}

/// An element on a ground that is a function of the frame's coordinates.
pub(crate) fn shaped_on(
    frame: &Frame,
    element: Element,
    ground: impl Fn(DVec2) -> f64,
) -> Arc<Shaped> {
    let prepared = Prepared::new(Planet::EARTH, Arc::new(element));
    let places = prepared.need().map_or(Vec::new(), |n| n.places.clone());
    let heights: Vec<f64> = places.iter().map(|p| ground(frame.from_map(*p))).collect();
    prepared.shape(&heights)
}

pub(crate) fn shaped(frame: &Frame, element: Element) -> Arc<Shaped> {
    shaped_on(frame, element, |_| 0.0)
}

/// The design's height at a point of the frame.
pub(crate) fn at(design: &Design, frame: &Frame, x: f64, y: f64, ground_m: f64) -> Outcome {
    design.height(frame.to_map(DVec2::new(x, y)), ground_m)
}

/// What a design adds to the ground between corners of the frame, in cubic metres: cells of `step`
/// metres by their middles.
pub(crate) fn volume(
    design: &Design,
    frame: &Frame,
    (min, max): (DVec2, DVec2),
    step: f64,
    ground: impl Fn(DVec2) -> f64,
) -> f64 {
    let cells = ((max - min) / step).round();
    let (columns, rows) = (cells.x as usize, cells.y as usize);
    let mut sum = 0.0;
    for j in 0..rows {
        let line: Vec<DVec2> = (0..columns)
            .map(|i| min + (DVec2::new(i as f64, j as f64) + 0.5) * step)
            .collect();
        let places: Vec<MapPoint> = line.iter().map(|p| frame.to_map(*p)).collect();
        let mut outcomes: Vec<Outcome> = line
            .iter()
            .map(|p| Outcome {
                height_m: ground(*p),
                by: None,
            })
            .collect();
        design.outcomes(
            &Samples::Places {
                places: &places,
                width: columns,
            },
            0.0,
            &mut outcomes,
        );
        sum += outcomes
            .iter()
            .zip(&line)
            .map(|(o, p)| o.height_m - ground(*p))
            .sum::<f64>();
    }
    sum * step * step
}
