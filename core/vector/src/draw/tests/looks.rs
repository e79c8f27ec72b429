//! What styles ask for: classes, scales, seams, and numbers that make no sense.

use super::*;

#[test]
fn neighbours_of_one_class_leave_no_seam() {
    let mut b = Builder::degrees();
    for i in 0..40 {
        let x = f64::from(i) * 0.0371;
        b.ring(
            [
                [x, 0.0],
                [x + 0.0371, 0.0],
                [x + 0.0471, 1.0],
                [x + 0.01, 1.0],
            ],
            false,
        )
        .unwrap();
        b.feature().unwrap();
    }
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let grid = around(LevelKey::new(9, 8), 0.7, 0.5, 100);
    assert!(
        draw(&drawing, &grid).plane(3)[40 * 100 + 10..40 * 100 + 90]
            .iter()
            .all(|a| *a == 1.0)
    );
}

#[test]
fn a_style_is_drawn_only_at_its_scales() {
    let style = Style {
        max_sample_m: Some(100.0),
        ..fill(RED)
    };
    let drawing = drawing(mix(0.0, 0.0), style);
    assert!(!drawing.reaches(&around(LevelKey::new(5, 5), 0.0, 0.5, 16)));
    assert!(drawing.reaches(&around(LevelKey::new(13, 12), 0.0, 0.5, 16)));
}

#[test]
fn classes_by_value_and_range_have_their_colours() {
    let mut b = Builder::degrees();
    for (i, height) in [3.0, 12.0, 40.0].into_iter().enumerate() {
        let x = i as f64;
        b.ring([[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]], false)
            .unwrap();
        b.property("height", Value::Float(height)).unwrap();
        b.feature().unwrap();
    }
    let class = |min, max, colour| Class {
        of: ClassOf::Range { min, max },
        fill: Some(colour),
        stroke: None,
    };
    let style = Style {
        by: Some(By {
            property: "height".into(),
            classes: vec![
                class(None, Some(10.0), [0.0, 1.0, 0.0, 1.0]),
                class(Some(10.0), Some(20.0), [0.0, 0.0, 1.0, 1.0]),
            ],
        }),
        ..fill(RED)
    };
    let drawing = drawing(b.finish().unwrap(), style);
    for (lon, expected) in [
        (0.5, [0.0, 1.0, 0.0]),
        (1.5, [0.0, 0.0, 1.0]),
        (2.5, [1.0, 0.0, 0.0]),
    ] {
        let block = draw(&drawing, &around(LevelKey::new(10, 9), lon, 0.5, 1));
        for (plane, v) in expected.into_iter().enumerate() {
            assert!((block.plane(plane)[0] - v).abs() < 1e-4, "{lon}");
        }
    }
}

#[test]
fn absurd_widths_and_coordinates_draw_something_or_nothing_but_end() {
    let mut b = Builder::degrees();
    b.line([
        [-36_000.0, -90.0],
        [36_000.0, 90.0],
        [1e-300, 0.0],
        [0.0, 0.0],
    ])
    .unwrap();
    b.ring([[0.0, 90.0], [120.0, 90.0], [240.0, 90.0]], false)
        .unwrap();
    b.ring([[0.0, 0.0], [1e-15, 0.0], [0.0, 1e-15], [0.0, 0.0]], false)
        .unwrap();
    let features = Arc::new(b.finish().unwrap());
    for length in [0.0, f64::NAN, -1.0, 1e-300, 1e300, f64::INFINITY] {
        for unit in [Length::Metres, Length::Pixels] {
            let style = Style {
                stroke_width: Some(unit(length)),
                dash: vec![length, 1e-9, length],
                hatch: Some(Hatch {
                    colour: RED,
                    spacing: unit(length),
                    width: unit(1.0),
                    angle_deg: length,
                    crossed: false,
                }),
                symbol: Some(Symbol {
                    shape: SymbolShape::Circle,
                    size: unit(length),
                }),
                ..full()
            };
            let drawing = Drawing::new(Arc::clone(&features), style, Planet::EARTH);
            for level in [LevelKey::new(1, 0), LevelKey::new(25, 24)] {
                let block = draw(&drawing, &around(level, 0.0, 0.0, 64));
                assert!(block.samples().iter().all(|v| v.is_finite()));
            }
        }
    }
}

#[test]
fn where_a_file_cut_a_polygon_at_the_antimeridian_there_is_no_stroke() {
    let mut b = Builder::degrees();
    b.ring(
        [[170.0, 60.0], [180.0, 60.0], [180.0, 70.0], [170.0, 70.0]],
        false,
    )
    .unwrap();
    b.ring(
        [
            [-180.0, 60.0],
            [-170.0, 60.0],
            [-170.0, 70.0],
            [-180.0, 70.0],
        ],
        false,
    )
    .unwrap();
    let drawing = drawing(b.finish().unwrap(), stroke(Length::Pixels(2.0)));
    for (lon, there) in [
        (180.0, false),
        (-179.99, false),
        (170.0, true),
        (-170.0, true),
    ] {
        let block = draw(&drawing, &around(LevelKey::new(6, 5), lon, 65.0, 4));
        let any = block.plane(3).iter().any(|a| *a > 0.0);
        assert_eq!(any, there, "{lon}");
    }
}
