//! Side slopes and insides: no jumps, nothing beyond the reach, precedence.

use std::sync::Arc;

use glam::DVec2;
use relievo_earthwork::{
    Design, Element, MapRect, Part, Polygon, Prepared, Section, Shape, Side, Surface, WarningKind,
};
use relievo_planet::Planet;

use crate::common::{alps, at, corridor, platform, polygon, shaped, square, vertices};

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
