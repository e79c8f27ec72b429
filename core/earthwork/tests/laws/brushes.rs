//! Brushes: on top of what lies below, smooth where they smooth.

use glam::DVec2;
use relievo_earthwork::{Design, Part, Tool};
use relievo_planet::Planet;

use crate::common::{alps, at, platform, shaped, shaped_on, square};
use crate::stroke;

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
