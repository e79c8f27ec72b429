//! Drawings as nobody should draw them: no panic, a number everywhere.

use core::f64::consts::PI;

use glam::DVec2;
use proptest::prelude::*;
use relievo_earthwork::{
    Design, Element, Frame, Outcome, Part, Polygon, Samples, Section, Shape, Side, Stroke, Surface,
    Tool, Vertex,
};
use relievo_planet::{MapPoint, Planet};

use crate::common::{alps, at, platform, shaped, shaped_on};

/// Polygons as nobody should draw them.
fn nasty() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let coordinate = prop_oneof![
        (-6..6_i32).prop_map(f64::from),
        -50.0..50.0_f64,
        Just(f64::NAN),
        Just(f64::INFINITY),
        (-3..3_i32).prop_map(|v| f64::from(v) * 1e-7),
    ];
    prop::collection::vec((coordinate.clone(), coordinate), 0..24)
}

fn odd_height() -> impl Strategy<Value = Option<f64>> {
    prop_oneof![
        Just(None),
        (-50.0..50.0_f64).prop_map(Some),
        Just(Some(f64::NAN)),
        Just(Some(1e300)),
    ]
}

fn odd_vertices(frame: &Frame, points: &[(f64, f64)], heights: &[Option<f64>]) -> Vec<Vertex> {
    points
        .iter()
        .enumerate()
        .map(|(i, (x, y))| Vertex {
            place: if x.is_finite() && y.is_finite() {
                frame.to_map(DVec2::new(*x, *y))
            } else {
                MapPoint::new(*x, *y)
            },
            height_m: heights[i % heights.len()],
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    #[test]
    fn no_drawing_panics_and_every_height_is_a_number(
        outline in nasty(), hole in nasty(), line in nasty(),
        heights in prop::collection::vec(odd_height(), 1..9),
        kind in 0..9_u8, wall in any::<bool>(),
        slope in prop_oneof![Just(0.5), Just(f64::NAN), Just(0.0), Just(-3.0), Just(1e9)],
        pole in any::<bool>(),
    ) {
        let frame = if pole { Frame::new(Planet::EARTH, MapPoint::new(0.0, 1e-7)) } else { alps() };
        let polygon = |surface| Shape::Polygon(Polygon {
            outline: odd_vertices(&frame, &outline, &heights),
            holes: vec![odd_vertices(&frame, &hole, &heights)],
            breaklines: vec![odd_vertices(&frame, &line, &heights)],
            surface,
        });
        let corridor = |section, profile| Shape::Corridor(relievo_earthwork::Corridor {
            line: odd_vertices(&frame, &line, &heights), profile, section,
        });
        let heights_profile = relievo_earthwork::Profile::Heights;
        let follow = relievo_earthwork::Profile::Follow { offset_m: slope, smooth_m: 20.0 };
        let shape = match kind {
            0 => polygon(Surface::Platform { height_m: 7.0 }),
            1 => polygon(Surface::Plane { height_m: 7.0, slope_percent: slope, aspect_deg: 10.0 }),
            2 | 3 => polygon(Surface::Tin),
            4 => polygon(Surface::Offset { offset_m: slope }),
            5 => polygon(Surface::Smooth),
            6 => corridor(Section::Road { width_m: 5.0, crossfall_percent: slope }, heights_profile),
            7 => corridor(Section::Channel { bottom_width_m: slope, depth_m: 2.0, bank_slope: slope }, follow),
            _ => Shape::Brush(vec![Stroke {
                tool: Tool::Smooth { strength: slope }, radius_m: 9.0, hardness: slope,
                points: odd_vertices(&frame, &line, &heights).iter().map(|v| v.place).collect(),
            }]),
        };
        let side = Side { cut_slope: slope, fill_slope: slope, wall, max_reach_m: 30.0 };
        let element = Element { shape, side };
        let drawn = shaped_on(&frame, element, |p| 0.1 * p.x);
        let design = Design::new(Planet::EARTH, vec![drawn]);
        for k in 0..120 {
            let angle = f64::from(k) * 2.4;
            let p = DVec2::new(libm::cos(angle), libm::sin(angle)) * f64::from(k) * 0.7;
            for spacing in [0.0, 3.0] {
                let mut out = [Outcome { height_m: 0.1 * p.x, by: None }];
                design.outcomes(&Samples::Places { places: &[frame.to_map(p)], width: 1 }, spacing, &mut out);
                prop_assert!(out[0].height_m.is_finite(), "{:?} at {p}", out[0]);
            }
        }
    }

    #[test]
    fn a_platform_lies_level_wherever_its_outline_goes_around(
        outline in prop::collection::vec((-20..20_i32, -20..20_i32), 3..12), x in -20..20_i32, y in -20..20_i32,
    ) {
        let frame = alps();
        let points: Vec<(f64, f64)> = outline.iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect();
        let p = (f64::from(x) + 0.317, f64::from(y) + 0.171);
        // Winding by angles: another way to the same answer.
        let mut around = 0.0;
        for i in 0..points.len() {
            let (a, b) = (points[i], points[(i + 1) % points.len()]);
            let (a, b) = (DVec2::new(a.0 - p.0, a.1 - p.1), DVec2::new(b.0 - p.0, b.1 - p.1));
            prop_assume!(a.perp_dot(b).abs() > 1e-3 * (b - a).length() || (b - a).length() == 0.0);
            around += libm::atan2(a.perp_dot(b), a.dot(b));
        }
        let winding = (around / (2.0 * PI)).round() as i32;
        let design = Design::new(Planet::EARTH, vec![shaped(&frame, platform(&frame, &points, 8.0))]);
        let o = at(&design, &frame, p.0, p.1, 8.5);
        prop_assert_eq!(o.by == Some((0, Part::Interior)), winding != 0, "{:?}", o);
    }
}
