//! Heights and volumes against closed forms.

mod common;

use common::{alps, at, corridor, platform, polygon, shaped, shaped_on, square, vertices, volume};
use core::f64::consts::PI;
use glam::DVec2;
use relievo_earthwork::{
    Design, Element, Part, Polygon, Profile, Section, Shape, Side, Surface, Vertex,
};
use relievo_planet::Planet;

/// Errors at halved steps must fall at least with this order, or be nothing.
fn assert_converges(exact: f64, at_steps: &[f64], order: f64) {
    let errors: Vec<f64> = at_steps.iter().map(|v| (v - exact).abs() / exact).collect();
    let first = errors[0];
    let last = errors[errors.len() - 1];
    let seen = libm::log2(first / last.max(1e-9)) / (errors.len() - 1) as f64;
    assert!(
        last < 1e-4 && (seen > order || first < 1e-5),
        "{errors:?}, order {seen}"
    );
}

#[test]
fn a_platform_on_a_plain_is_a_frustum_with_round_corners() {
    let frame = alps();
    let (half, rise) = (30.0, 8.0);
    let design = Design::new(
        Planet::EARTH,
        vec![shaped(
            &frame,
            platform(&frame, &square(half), 100.0 + rise),
        )],
    );
    let slope = 0.5;
    let exact = (2.0 * half).powi(2) * rise
        + 4.0 * (2.0 * half) * rise * rise / (2.0 * slope)
        + PI * rise.powi(3) / (3.0 * slope * slope);
    let corner = DVec2::splat(half + rise / slope + 2.0);
    let at_steps: Vec<f64> = [2.0, 1.0, 0.5]
        .iter()
        .map(|step| volume(&design, &frame, (-corner, corner), *step, |_| 100.0))
        .collect();
    assert_converges(exact, &at_steps, 1.7);
}

#[test]
fn a_round_platform_on_a_cone_is_a_solid_of_revolution() {
    let frame = alps();
    let ring: Vec<(f64, f64)> = (0..480)
        .map(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) / 480.0 * 2.0 * PI);
            (40.0 * cos, 40.0 * sin)
        })
        .collect();
    // The hill falls by 0.2; the platform cuts its top and fills around it.
    let (top, fall, z, radius, slope) = (500.0, 0.2, 494.0, 40.0, 0.5);
    let ground = |p: DVec2| top - fall * p.length();
    let design = Design::new(
        Planet::EARTH,
        vec![shaped(&frame, platform(&frame, &ring, z))],
    );
    // ∫ (a + b r) 2πr dr between radii.
    let turned = |a: f64, b: f64, r0: f64, r1: f64| {
        PI * a * (r1 * r1 - r0 * r0) + 2.0 * PI * b / 3.0 * (r1.powi(3) - r0.powi(3))
    };
    let meets = (z + slope * radius - top) / (slope - fall);
    let exact = turned(z - top, fall, 0.0, radius)
        + turned(z + slope * radius - top, fall - slope, radius, meets);
    let corner = DVec2::splat(meets + 3.0);
    let corner = (corner / 2.0).ceil() * 2.0;
    let at_steps: Vec<f64> = [1.0, 0.5, 0.25]
        .iter()
        .map(|step| volume(&design, &frame, (-corner, corner), *step, ground))
        .collect();
    let errors: Vec<f64> = at_steps.iter().map(|v| (v / exact - 1.0).abs()).collect();
    // A cut and a fill nearly balance: the error is one of either.
    assert!(
        errors[2] < 1e-3 && errors[2] < errors[0],
        "{errors:?} of {exact}"
    );
}

#[test]
fn a_dam_across_a_valley_has_its_volume() {
    let frame = alps();
    let (k, z, width, slope) = (0.4, 20.0, 6.0, 0.5);
    let line = [(-80.0, 0.0, z), (80.0, 0.0, z)];
    let dam = corridor(
        &frame,
        &line,
        Section::Dam {
            crest_width_m: width,
        },
        Side {
            fill_slope: slope,
            ..Side::default()
        },
    );
    let design = Design::new(Planet::EARTH, vec![shaped(&frame, dam)]);
    let ground = |p: DVec2| k * p.x.abs();
    let exact = width * z * z / k + 2.0 * z * z * z / (3.0 * slope * k);
    let corner = DVec2::new(64.0, 48.0);
    let at_steps: Vec<f64> = [2.0, 1.0, 0.5]
        .iter()
        .map(|step| volume(&design, &frame, (-corner, corner), *step, ground))
        .collect();
    assert_converges(exact, &at_steps, 1.7);
}

#[test]
fn a_cut_and_a_fill_meet_an_inclined_plane_where_they_must() {
    let frame = alps();
    let pad = polygon(
        &frame,
        &square(20.0),
        Surface::Platform { height_m: 100.0 },
        Side {
            cut_slope: 1.0,
            fill_slope: 0.5,
            ..Side::default()
        },
    );
    let design = Design::new(Planet::EARTH, vec![shaped(&frame, pad)]);
    // Rises to the east by 0.25.
    let ground = |x: f64| 100.0 + 0.25 * x;
    for d in [0.5, 2.0, 5.0, 6.5, 7.0, 30.0] {
        let (east, west) = (20.0 + d, -20.0 - d);
        let cut = at(&design, &frame, east, 3.0, ground(east));
        let fill = at(&design, &frame, west, 3.0, ground(west));
        assert!(
            (cut.height_m - ground(east).min(100.0 + d)).abs() < 1e-4,
            "{d} {cut:?}"
        );
        assert!(
            (fill.height_m - ground(west).max(100.0 - 0.5 * d)).abs() < 1e-4,
            "{d} {fill:?}"
        );
    }
    assert_eq!(
        at(&design, &frame, 22.0, 0.0, ground(22.0)).by,
        Some((0, Part::Cut))
    );
    assert_eq!(
        at(&design, &frame, -22.0, 0.0, ground(-22.0)).by,
        Some((0, Part::Fill))
    );
    assert_eq!(
        at(&design, &frame, 9.0, 0.0, ground(9.0)).by,
        Some((0, Part::Interior))
    );
    assert_eq!(at(&design, &frame, 60.0, 0.0, ground(60.0)).by, None);
}

#[test]
fn a_plane_falls_where_its_aspect_points() {
    let frame = alps();
    let plane = Surface::Plane {
        height_m: 50.0,
        slope_percent: 10.0,
        aspect_deg: 90.0,
    };
    let design = Design::new(
        Planet::EARTH,
        vec![shaped(
            &frame,
            polygon(&frame, &square(10.0), plane, Side::default()),
        )],
    );
    // 50 at the first vertex in the south-west, 0.1 a metre down to the east.
    for (x, y) in [(-9.0, -9.0), (0.0, 5.0), (9.0, 0.0)] {
        let h = at(&design, &frame, x, y, 0.0).height_m;
        assert!((h - (50.0 - 0.1 * (x + 10.0))).abs() < 1e-5, "{h}");
    }
}

#[test]
fn triangles_follow_their_breaklines_and_take_missing_heights_from_the_ground() {
    let frame = alps();
    let mut outline = vertices(&frame, &square(10.0), Some(5.0));
    outline[2].height_m = None;
    let ridge = |points: &[(f64, f64)], h: f64| vertices(&frame, points, Some(h));
    let element = |breaklines: Vec<Vec<Vertex>>| Element {
        shape: Shape::Polygon(Polygon {
            outline: outline.clone(),
            holes: Vec::new(),
            breaklines,
            surface: Surface::Tin,
        }),
        side: Side::default(),
    };
    // A ridge at 9 m from side to side, crossed by another line at 7 m: the mean where they meet.
    let lines = vec![
        ridge(&[(-8.0, 0.0), (8.0, 0.0)], 9.0),
        ridge(&[(0.0, -6.0), (0.0, 6.0)], 7.0),
    ];
    let shape = shaped_on(&frame, element(lines), |_| 5.0);
    let design = Design::new(Planet::EARTH, vec![shape]);
    let h = |x, y| at(&design, &frame, x, y, 0.0).height_m;
    assert!((h(4.0, 0.0) - 8.5).abs() < 1e-3, "{}", h(4.0, 0.0));
    assert!((h(0.0, 3.0) - 7.5).abs() < 1e-3, "{}", h(0.0, 3.0));
    assert!((h(0.0, 0.0) - 8.0).abs() < 1e-3);
    assert!((h(9.99, 9.99) - 5.0).abs() < 0.02, "from the ground");
    let kinds: Vec<_> = design.elements()[0]
        .warnings()
        .iter()
        .map(|w| w.kind)
        .collect();
    assert_eq!(kinds, [relievo_earthwork::WarningKind::HeightsDisagree]);
}

#[test]
fn a_road_falls_to_both_sides_and_keeps_its_profile_around_bends() {
    let frame = alps();
    let section = Section::Road {
        width_m: 8.0,
        crossfall_percent: 2.5,
    };
    let road = corridor(
        &frame,
        &[(0.0, 0.0, 100.0), (100.0, 0.0, 105.0), (100.0, 80.0, 113.0)],
        section,
        Side::default(),
    );
    let design = Design::new(Planet::EARTH, vec![shaped(&frame, road)]);
    for (x, y, exact) in [
        (0.5, 0.0, 100.025),
        (50.0, 0.0, 102.5),
        (50.0, 3.0, 102.5 - 0.075),
        (50.0, -3.0, 102.5 - 0.075),
        (100.0, 0.0, 105.0),
        (100.0, 40.0, 109.0),
        (97.0, 40.0, 109.0 - 0.075),
    ] {
        let h = at(&design, &frame, x, y, 0.0).height_m;
        assert!((h - exact).abs() < 1e-3, "{x} {y}: {h} {exact}");
    }
    // Flat ends.
    assert_ne!(
        at(&design, &frame, -0.5, 0.0, 0.0).by.unwrap().1,
        Part::Interior
    );
}

#[test]
fn a_trench_a_channel_and_a_dam_do_what_they_are_for() {
    let frame = alps();
    let line = [(0.0, 0.0, 100.0), (100.0, 0.0, 100.0)];
    let design = |section| {
        Design::new(
            Planet::EARTH,
            vec![shaped(
                &frame,
                corridor(&frame, &line, section, Side::default()),
            )],
        )
    };
    let trench = design(Section::Trench {
        bottom_width_m: 2.0,
        depth_m: 3.0,
    });
    let h = |d: &Design, y, ground| at(d, &frame, 50.0, y, ground).height_m;
    assert!((h(&trench, 0.5, 100.0) - 97.0).abs() < 1e-9);
    assert!((h(&trench, 3.0, 100.0) - 98.0).abs() < 1e-6, "cut 1 in 2");
    assert_eq!(h(&trench, 0.5, 90.0), 90.0, "never filled");
    let channel = design(Section::Channel {
        bottom_width_m: 2.0,
        depth_m: 3.0,
        bank_slope: 1.0,
    });
    assert!((h(&channel, 0.5, 100.0) - 97.0).abs() < 1e-9);
    assert!(
        (h(&channel, 2.5, 100.0) - 98.5).abs() < 1e-6,
        "its own bank"
    );
    assert!(
        (h(&channel, 5.0, 98.0) - 99.5).abs() < 1e-6,
        "on a dam where the ground is low"
    );
    let dam = design(Section::Dam { crest_width_m: 4.0 });
    assert_eq!(h(&dam, 0.5, 120.0), 120.0, "never cut");
    assert!((h(&dam, 6.0, 0.0) - 98.0).abs() < 1e-6);
}

#[test]
fn a_corridor_that_follows_the_ground_lies_on_its_average() {
    let frame = alps();
    let ground = |p: DVec2| 400.0 + 0.05 * p.x + 2.0 * libm::sin(p.x / 200.0 * 2.0 * PI);
    let mut road = corridor(
        &frame,
        &[(0.0, 0.0, 0.0), (1000.0, 0.0, 0.0)],
        Section::Road {
            width_m: 8.0,
            crossfall_percent: 0.0,
        },
        Side::default(),
    );
    if let Shape::Corridor(c) = &mut road.shape {
        c.profile = Profile::Follow {
            offset_m: 1.5,
            smooth_m: 200.0,
        };
    }
    let design = Design::new(Planet::EARTH, vec![shaped_on(&frame, road, ground)]);
    // Averaged over one whole wave only the plane is left.
    for x in [150.0, 375.0, 500.0, 777.0] {
        let h = at(&design, &frame, x, 0.0, 0.0).height_m;
        assert!((h - (401.5 + 0.05 * x)).abs() < 0.05, "{x}: {h}");
    }
    // Its ends stay at the ground.
    assert!((at(&design, &frame, 0.01, 0.0, 0.0).height_m - 401.5).abs() < 0.05);
}

#[test]
fn an_offset_lies_above_the_ground_and_an_infill_within_it() {
    let frame = alps();
    let ground = |p: DVec2| 200.0 + 0.1 * p.x + 3.0 * libm::exp(-p.length_squared() / 50.0);
    let offset = polygon(
        &frame,
        &square(40.0),
        Surface::Offset { offset_m: 2.0 },
        Side::default(),
    );
    let raised = Design::new(Planet::EARTH, vec![shaped_on(&frame, offset, ground)]);
    let p = DVec2::new(3.0, -4.0);
    assert!((at(&raised, &frame, p.x, p.y, ground(p)).height_m - ground(p) - 2.0).abs() < 1e-9);
    // One metre outside: half a metre lower than the boundary.
    let p = DVec2::new(41.0, 0.0);
    let h = at(&raised, &frame, p.x, p.y, ground(p)).height_m;
    assert!((h - (204.0 + 2.0 - 0.5)).abs() < 0.15, "{h}");
    // The bump inside is smoothed away: the boundary's plane is harmonic.
    let smooth = polygon(&frame, &square(40.0), Surface::Smooth, Side::default());
    let filled = Design::new(Planet::EARTH, vec![shaped_on(&frame, smooth, ground)]);
    for (x, y) in [(0.0, 0.0), (10.0, 5.0), (-30.0, 20.0), (39.9, 0.0)] {
        let h = at(&filled, &frame, x, y, ground(DVec2::new(x, y))).height_m;
        assert!((h - (200.0 + 0.1 * x)).abs() < 1e-2, "{x} {y} {h}");
    }
}

#[test]
fn a_daylight_line_lies_where_slopes_meet_the_ground_and_names_walls() {
    let frame = alps();
    let side = Side {
        max_reach_m: 25.0,
        ..Side::default()
    };
    let pad = polygon(
        &frame,
        &square(20.0),
        Surface::Platform { height_m: 108.0 },
        side,
    );
    let shape = shaped(&frame, pad);
    // Level in the west, in the east a valley that fills do not reach the bottom of.
    let ground = |p: DVec2| if p.x < 0.0 { 100.0 } else { 100.0 - 2.0 * p.x };
    let lines = shape
        .daylight::<core::convert::Infallible>(1.0, &mut |places| {
            Ok(places.iter().map(|p| ground(frame.from_map(*p))).collect())
        })
        .unwrap_or_default();
    let (mut met, mut walls) = (0, 0);
    for line in &lines {
        for place in &line.places[1..] {
            let p = frame.from_map(*place);
            let out = (p.abs() - 20.0).max(DVec2::ZERO).length();
            match line.ending {
                relievo_earthwork::Ending::Meets => {
                    met += 1;
                    assert!(
                        (out - 2.0 * (108.0 - ground(p))).abs() < 0.05 || p.x > -1.0,
                        "{p} {out}"
                    );
                }
                relievo_earthwork::Ending::ReachWall => {
                    walls += 1;
                    assert!((out - 25.0).abs() < 0.01 && p.x > 0.0, "{p} {out}");
                }
            }
        }
    }
    assert!(met > 60 && walls > 60, "{met} {walls}");
}
