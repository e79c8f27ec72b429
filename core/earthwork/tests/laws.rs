//! What holds for every element: no jumps, no effect beyond the reach, precedence, one answer.

mod common;

use std::sync::Arc;

use common::{alps, at, corridor, platform, polygon, shaped, shaped_on, square, vertices};
use core::f64::consts::PI;
use glam::DVec2;
use proptest::prelude::*;
use relievo_earthwork::{
    Design, Element, Frame, MapRect, Outcome, Part, Polygon, Prepared, Samples, Section, Shape,
    Shaped, Side, Stroke, Surface, Tool, Vertex, WarningKind,
};
use relievo_planet::{MapPoint, Planet};

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

#[test]
fn a_grid_its_parts_and_single_places_agree_to_the_bit() {
    let frame = alps();
    let design = Design::new(Planet::EARTH, mixed(&frame));
    let origin = frame.origin();
    let step = 5.3e-7;
    let lon: Vec<f64> = (0..90)
        .map(|i| origin.lon_rad + (f64::from(i) - 45.0) * step * 1.4)
        .collect();
    let colat: Vec<f64> = (0..80)
        .map(|i| origin.colat_rad + (f64::from(i) - 40.0) * step)
        .collect();
    for spacing_m in [0.0, 2.0, 12.0] {
        let ground = |i: usize, k: usize| ((i * 7 + k * 13) % 29) as f64 * 0.3 - 2.0;
        let run = |columns: core::ops::Range<usize>, rows: core::ops::Range<usize>| {
            let mut out: Vec<Outcome> = rows
                .clone()
                .flat_map(|k| columns.clone().map(move |i| (i, k)))
                .map(|(i, k)| Outcome {
                    height_m: ground(i, k),
                    by: None,
                })
                .collect();
            let samples = Samples::Map {
                lon_rad: &lon[columns],
                colat_rad: &colat[rows],
            };
            design.outcomes(&samples, spacing_m, &mut out);
            out
        };
        let whole = run(0..90, 0..80);
        let changed = whole.iter().filter(|o| o.by.is_some()).count();
        assert!(changed > 3000, "{changed}");
        let part = run(31..77, 5..64);
        for (k, row) in part.chunks(46).enumerate() {
            for (i, o) in row.iter().enumerate() {
                let w = whole[(k + 5) * 90 + i + 31];
                assert_eq!(
                    (o.height_m.to_bits(), o.by),
                    (w.height_m.to_bits(), w.by),
                    "{i} {k}"
                );
            }
        }
        let places: Vec<MapPoint> = colat
            .iter()
            .flat_map(|c| lon.iter().map(move |l| MapPoint::new(*l, *c)))
            .collect();
        let mut out: Vec<Outcome> = (0..80)
            .flat_map(|k| (0..90).map(move |i| (i, k)))
            .map(|(i, k)| Outcome {
                height_m: ground(i, k),
                by: None,
            })
            .collect();
        design.outcomes(
            &Samples::Places {
                places: &places,
                width: 90,
            },
            spacing_m,
            &mut out,
        );
        assert!(
            out == whole,
            "places in rows give what rows and columns give"
        );
        if spacing_m == 0.0 {
            for k in (0..7200).step_by(61) {
                let o = design.height(places[k], ground(k % 90, k / 90));
                assert_eq!(o, whole[k], "{k}");
            }
        }
    }
}

#[test]
fn sides_have_no_jumps_not_even_at_reflex_corners() {
    let frame = alps();
    let ell = [
        (-60.0, -60.0),
        (60.0, -60.0),
        (60.0, -20.0),
        (-20.0, -20.0),
        (-20.0, 60.0),
        (-60.0, 60.0),
    ];
    let road = Section::Road {
        width_m: 9.0,
        crossfall_percent: 3.0,
    };
    let line = [
        (-150.0, 80.0, 3.0),
        (-20.0, 90.0, 9.0),
        (60.0, 20.0, 6.0),
        (80.0, 140.0, 14.0),
    ];
    let plane = Surface::Plane {
        height_m: 12.0,
        slope_percent: 20.0,
        aspect_deg: 30.0,
    };
    for element in [
        platform(&frame, &ell, 10.0),
        polygon(&frame, &ell, plane, Side::default()),
        corridor(&frame, &line, road, Side::default()),
    ] {
        let design = Design::new(Planet::EARTH, vec![shaped(&frame, element)]);
        for ground in [0.0, 25.0] {
            let mut worst: f64 = 0.0;
            for k in 0..700 {
                // Straight walks through everything in steps of 2 cm.
                let angle = f64::from(k) * 0.618;
                let dir = DVec2::new(libm::cos(angle), libm::sin(angle));
                let start = dir.perp() * (f64::from(k % 35) - 17.0) * 4.7
                    + dir * (f64::from(k / 35) - 10.0) * 9.0;
                let heights: Vec<f64> = (0..20)
                    .map(|i| {
                        let p = start + dir * f64::from(i) * 0.02;
                        at(&design, &frame, p.x, p.y, ground).height_m
                    })
                    .collect();
                for w in heights.windows(2) {
                    worst = worst.max((w[1] - w[0]).abs());
                }
            }
            // Slopes of at most 0.54, and arcs that are chords.
            assert!(worst < 0.0125 + 0.004, "a jump of {worst}");
        }
    }
}

#[test]
fn nothing_changes_beyond_the_reach_and_what_changes_is_in_it() {
    let frame = alps();
    let side = Side {
        max_reach_m: 30.0,
        fill_slope: 0.05,
        ..Side::default()
    };
    let pad = polygon(
        &frame,
        &square(20.0),
        Surface::Platform { height_m: 50.0 },
        side,
    );
    let prepared = Prepared::new(Planet::EARTH, Arc::new(pad.clone()));
    let design = Design::new(Planet::EARTH, vec![shaped(&frame, pad)]);
    assert!(at(&design, &frame, 49.9, 0.0, 0.0).by.is_some());
    assert!(
        at(&design, &frame, 50.1, 0.0, 0.0).by.is_none(),
        "it ends in a wall"
    );
    assert!(
        at(&design, &frame, 44.0, 44.0, 0.0).by.is_none(),
        "also at corners"
    );
    let rect_at = |x: f64, y: f64, size: f64| {
        let p = frame.to_map(DVec2::new(x, y));
        let half = size / 2.0 / 6.37e6;
        MapRect {
            west_rad: p.lon_rad - half,
            east_rad: p.lon_rad + half,
            north_rad: p.colat_rad - half,
            south_rad: p.colat_rad + half,
        }
    };
    assert!(
        prepared.touches(&rect_at(0.0, 0.0, 1.0)) && prepared.touches(&rect_at(49.0, 0.0, 4.0))
    );
    assert!(!prepared.touches(&rect_at(53.0, 0.0, 4.0)));
    assert!(
        !prepared.touches(&rect_at(45.0, 45.0, 4.0)),
        "finer than its box"
    );
    assert!(prepared.touches(&rect_at(0.0, 0.0, 1e7)));
    let wall = Side { wall: true, ..side };
    let walled = Design::new(
        Planet::EARTH,
        vec![shaped(
            &frame,
            polygon(
                &frame,
                &square(20.0),
                Surface::Platform { height_m: 50.0 },
                wall,
            ),
        )],
    );
    assert!(at(&walled, &frame, 20.01, 0.0, 0.0).by.is_none());
    assert_eq!(at(&walled, &frame, 19.99, 0.0, 0.0).height_m, 50.0);
}

#[test]
fn insides_beat_slopes_later_insides_beat_earlier_and_slopes_join() {
    let frame = alps();
    let moved = |x: f64, half: f64| square(half).map(|(a, b)| (a + x, b));
    let (low, high) = (
        platform(&frame, &moved(0.0, 20.0), 5.0),
        platform(&frame, &moved(45.0, 20.0), 15.0),
    );
    let both = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, low.clone()), shaped(&frame, high.clone())],
    );
    // The later one's slope would raise this place of the earlier one's inside.
    assert_eq!(at(&both, &frame, 19.0, 0.0, 0.0).height_m, 5.0);
    // Between them: fills join in the higher, and cuts of either in the lower.
    let h = at(&both, &frame, 22.0, 0.0, 0.0).height_m;
    assert!(
        (h - 13.5).abs() < 1e-4 && at(&both, &frame, 22.0, 0.0, 0.0).by == Some((1, Part::Fill)),
        "{h}"
    );
    let over = platform(&frame, &moved(10.0, 20.0), 8.0);
    let later = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, low.clone()), shaped(&frame, over.clone())],
    );
    let earlier = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, over), shaped(&frame, low)],
    );
    assert_eq!(at(&later, &frame, 10.0, 0.0, 0.0).height_m, 8.0);
    assert_eq!(at(&earlier, &frame, 10.0, 0.0, 0.0).height_m, 5.0);
    // Where slopes contradict each other the later wins: next to a deep pit a tower.
    let pit = platform(&frame, &moved(-30.0, 20.0), -20.0);
    let tower = platform(&frame, &moved(20.0, 20.0), 20.0);
    let pit_last = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, tower.clone()), shaped(&frame, pit.clone())],
    );
    let tower_last = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, pit), shaped(&frame, tower)],
    );
    assert!((at(&pit_last, &frame, -5.0, 0.0, 0.0).height_m + 17.5).abs() < 1e-4);
    assert!((at(&tower_last, &frame, -5.0, 0.0, 0.0).height_m - 17.5).abs() < 1e-4);
}

#[test]
fn brushes_act_on_what_lies_below_them_in_the_list() {
    let frame = alps();
    let pad = || shaped(&frame, platform(&frame, &square(20.0), 5.0));
    let raise = || {
        shaped(
            &frame,
            stroke(&frame, Tool::Raise { strength_m: 3.0 }, 10.0, &[(0.0, 0.0)]),
        )
    };
    let over = Design::new(Planet::EARTH, vec![pad(), raise()]);
    let under = Design::new(Planet::EARTH, vec![raise(), pad()]);
    assert_eq!(at(&over, &frame, 0.0, 0.0, 0.0).height_m, 8.0);
    assert_eq!(at(&under, &frame, 0.0, 0.0, 0.0).height_m, 5.0);
    assert_eq!(
        at(&over, &frame, 9.99, 0.0, 0.0).height_m.round(),
        5.0,
        "it fades out"
    );
    assert_eq!(
        at(&over, &frame, 10.01, 0.0, 0.0).by,
        Some((0, Part::Interior))
    );
}

#[test]
fn a_smoothing_stroke_flattens_a_bump_and_keeps_a_plane() {
    let frame = alps();
    let bumpy = |p: DVec2| 300.0 + 0.1 * p.x + 2.0 * libm::sin(p.x * 0.5) * libm::sin(p.y * 0.5);
    let smooth = stroke(
        &frame,
        Tool::Smooth { strength: 1.0 },
        20.0,
        &[(-30.0, 0.0), (30.0, 0.0)],
    );
    let design = Design::new(Planet::EARTH, vec![shaped_on(&frame, smooth, bumpy)]);
    for (x, y) in [(0.8, 0.8), (10.2, -3.0), (-20.0, 4.0)] {
        let h = at(&design, &frame, x, y, bumpy(DVec2::new(x, y))).height_m;
        assert!((h - (300.0 + 0.1 * x)).abs() < 0.3, "{x} {y} {h}");
    }
}

#[test]
fn a_boundary_steeper_than_its_sides_is_named_and_its_nearest_part_decides() {
    let frame = alps();
    let mut outline = vertices(&frame, &square(20.0), Some(0.0));
    outline[1].height_m = Some(60.0);
    let element = Element {
        shape: Shape::Polygon(Polygon {
            outline,
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface: Surface::Tin,
        }),
        side: Side::default(),
    };
    let design = Design::new(Planet::EARTH, vec![shaped(&frame, element)]);
    let warnings = design.elements()[0].warnings();
    assert!(
        warnings
            .iter()
            .any(|w| w.kind == WarningKind::SteeperThanSide && w.count == 2),
        "{warnings:?}"
    );
    let o = at(&design, &frame, 0.0, -20.5, 10.0);
    assert_eq!(o.by, Some((0, Part::Wall)));
    assert!((o.height_m - (30.0 - 0.25)).abs() < 1e-3, "{o:?}");
}

#[test]
fn the_same_element_is_the_same_at_the_antimeridian_and_at_the_poles() {
    let heights = |lon: f64, lat: f64| -> Vec<f64> {
        let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
        let design = Design::new(Planet::EARTH, mixed(&frame));
        (0..400)
            .map(|k| {
                let p = DVec2::new(f64::from(k % 20) - 10.0, f64::from(k / 20) - 10.0) * 15.3;
                at(&design, &frame, p.x, p.y, 1.0).height_m
            })
            .collect()
    };
    // Frames of parts are turned against each other near a pole, so not to the last digit.
    let here = heights(11.4, 47.2);
    for (lon, lat) in [
        (180.0, 47.2),
        (-180.0, -10.0),
        (33.0, 90.0),
        (0.0, -90.0),
        (120.0, 89.9995),
    ] {
        for (k, (a, b)) in here.iter().zip(heights(lon, lat)).enumerate() {
            // A plane's aspect turns with the meridians.
            assert!(
                (a - b).abs() < 2e-3 || lat.abs() > 80.0,
                "{lon} {lat} {k}: {a} {b}"
            );
        }
    }
    let pad = |lon: f64, lat: f64| {
        let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
        let design = Design::new(
            Planet::EARTH,
            vec![shaped(&frame, platform(&frame, &square(30.0), 9.0))],
        );
        (0..=40)
            .map(|k| {
                at(
                    &design,
                    &frame,
                    f64::from(k) * 2.0 - 40.0,
                    33.0 - f64::from(k % 7),
                    0.0,
                )
                .height_m
            })
            .collect::<Vec<f64>>()
    };
    for (lon, lat) in [(180.0, 0.0), (77.0, 90.0), (0.0, -90.0), (5.0, 89.9999)] {
        for (a, b) in pad(0.0, 50.0).iter().zip(pad(lon, lat)) {
            assert!((a - b).abs() < 1e-4, "{lon} {lat}: {a} {b}");
        }
    }
}

#[test]
fn a_road_finer_than_the_samples_is_no_row_of_dashes() {
    let frame = alps();
    let section = Section::Road {
        width_m: 10.0,
        crossfall_percent: 0.0,
    };
    let line: Vec<(f64, f64, f64)> = vec![(-4000.0, -900.0, 3.0), (4000.0, 1100.0, 3.0)];
    let design = Design::new(
        Planet::EARTH,
        vec![shaped(
            &frame,
            corridor(&frame, &line, section, Side::default()),
        )],
    );
    let exact = 8246.2 * (10.0 * 3.0 + 9.0 / 0.5);
    for spacing in [20.0, 60.0, 150.0] {
        let side = (9000.0 / spacing) as usize;
        let places: Vec<MapPoint> = (0..side * side)
            .map(|k| {
                let p = DVec2::new((k % side) as f64 + 0.5, (k / side) as f64 + 0.5) * spacing;
                frame.to_map(p - 4500.0)
            })
            .collect();
        let mut out = vec![
            Outcome {
                height_m: 0.0,
                by: None
            };
            side * side
        ];
        design.outcomes(
            &Samples::Places {
                places: &places,
                width: side,
            },
            spacing,
            &mut out,
        );
        let volume: f64 = out.iter().map(|o| o.height_m).sum::<f64>() * spacing * spacing;
        assert!(
            (volume / exact - 1.0).abs() < 0.06,
            "{spacing}: {volume} of {exact}"
        );
        // Every column that the road passes holds about as much of it.
        for i in side / 10..side * 9 / 10 {
            let column: f64 = (0..side).map(|k| out[k * side + i].height_m).sum::<f64>() * spacing;
            let mean = 48.0 * 8246.2 / 8000.0;
            assert!(
                (column / mean - 1.0).abs() < 0.25,
                "{spacing} {i}: {column} {mean}"
            );
        }
    }
}

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
