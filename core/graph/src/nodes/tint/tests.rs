use proptest::prelude::*;
use relievo_raster::colour;

use super::*;

fn stops() -> [Stop; 3] {
    [(0.0, 0.2), (100.0, 0.6), (300.0, 1.0)].map(|(height_m, v)| Stop {
        height_m,
        rgba: [v, 1.0 - v, 0.5, 1.0],
    })
}

#[test]
fn stops_and_what_lies_beyond_them_are_exact() {
    let tint = Tint::new(&stops(), true).unwrap();
    for stop in stops() {
        assert_eq!(tint.colour(stop.height_m), stop.rgba);
    }
    assert_eq!(tint.colour(-1e9), stops()[0].rgba);
    assert_eq!(tint.colour(f32::INFINITY), stops()[2].rgba);
    assert_eq!(tint.colour(f32::NAN), [0.0; 4]);
}

#[test]
fn half_way_between_black_and_white_is_the_middle_of_linear_light() {
    let ends = [(0.0, 0.0), (1.0, 1.0)].map(|(height_m, v)| Stop {
        height_m,
        rgba: [v, v, v, 1.0],
    });
    let middle = Tint::new(&ends, true).unwrap().colour(0.5);
    assert_eq!(colour::to_u8(middle[0]), 188);
}

#[test]
fn steps_keep_the_colour_of_the_stop_below() {
    let tint = Tint::new(&stops(), false).unwrap();
    assert_eq!(tint.colour(99.9), stops()[0].rgba);
    assert_eq!(tint.colour(100.0), stops()[1].rgba);
}

#[test]
fn bad_stops_are_named() {
    assert_eq!(Tint::new(&[], true).unwrap_err(), TintError::Empty);
    let mut twice = stops();
    twice[1].height_m = 0.0;
    assert_eq!(
        Tint::new(&twice, true).unwrap_err(),
        TintError::Order {
            height_m: 0.0,
            before_m: 0.0
        }
    );
    twice[1] = Stop {
        height_m: 1.0,
        rgba: [0.0, 0.0, 0.0, 2.0],
    };
    assert_eq!(
        Tint::new(&twice, true).unwrap_err(),
        TintError::Colour { height_m: 1.0 }
    );
}

proptest! {
    #[test]
    fn many_samples_agree_with_single_ones_to_the_bit(
        steps in prop::collection::vec((0.001..200.0_f32, prop::array::uniform4(0.0..1.0_f32), 0..4_u8), 1..30), smooth: bool,
        seed in prop::collection::vec((0.0..1.0_f32, 0..8_u8), LANES), near: bool,
    ) {
        let mut height_m = -100.0;
        let stops: Vec<Stop> = steps.iter().map(|(step, rgba, alpha)| {
            height_m += step;
            let a = match alpha { 0 => 0.0, 1 | 2 => 1.0, _ => rgba[3] };
            Stop { height_m, rgba: [rgba[0], rgba[1], rgba[2], a] }
        }).collect();
        let tint = Tint::new(&stops, smooth).unwrap();
        let heights: Lanes = core::array::from_fn(|l| match seed[l] {
            // Near one another, so that they lie in one interval or two.
            (v, _) if near => height_m - 100.0 + v * 0.5,
            (_, 0) => f32::NAN,
            (v, 1) => stops[(v * stops.len() as f32) as usize % stops.len()].height_m,
            (_, 2) => f32::INFINITY,
            (_, 3) => f32::NEG_INFINITY,
            (v, _) => -110.0 + v * (height_m + 130.0),
        });
        let mut many = [[f32::NAN; LANES]; 4];
        on_widest(
            #[inline(always)]
            || tint.colours(&heights, &mut many),
        );
        for (l, h) in heights.into_iter().enumerate() {
            for (plane, v) in tint.colour(h).into_iter().enumerate() {
                prop_assert_eq!(v.to_bits(), many[plane][l].to_bits(), "at {}", h);
            }
        }
    }

    #[test]
    fn a_smooth_tint_has_no_jumps(h in -50.0..350.0_f32) {
        let tint = Tint::new(&stops(), true).unwrap();
        for (a, b) in tint.colour(h).into_iter().zip(tint.colour(h + 0.01)) {
            prop_assert!((a - b).abs() < 1e-3);
        }
    }
}
