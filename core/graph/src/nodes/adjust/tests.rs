use proptest::prelude::*;

use super::*;

fn adjusted(params: AdjustParams, rgb: [f32; 3]) -> [f32; 3] {
    let [r, g, b, a] = Adjust::new(&params).colour([rgb[0], rgb[1], rgb[2], 1.0]);
    assert_eq!(a, 1.0);
    [r, g, b]
}

fn luma(rgb: [f32; 3]) -> f64 {
    rgb.iter().zip(LUMA).map(|(v, w)| f64::from(*v) * w).sum()
}

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() < 2e-6)
}

#[test]
fn defaults_and_whole_turns_of_hue_are_the_identity() {
    assert!(Adjust::new(&AdjustParams::default()).is_identity());
    assert!(
        Adjust::new(&AdjustParams {
            hue_deg: -720.0,
            ..AdjustParams::default()
        })
        .is_identity()
    );
    assert!(
        !Adjust::new(&AdjustParams {
            gamma: 1.01,
            ..AdjustParams::default()
        })
        .is_identity()
    );
}

#[test]
fn each_step_does_what_its_name_says() {
    let grey = [0.25; 3];
    assert_eq!(
        adjusted(
            AdjustParams {
                brightness: 2.0,
                ..AdjustParams::default()
            },
            grey
        ),
        [0.5; 3]
    );
    assert_eq!(
        adjusted(
            AdjustParams {
                contrast: 2.0,
                ..AdjustParams::default()
            },
            grey
        ),
        [0.0; 3]
    );
    assert!(close(
        adjusted(
            AdjustParams {
                gamma: 2.0,
                ..AdjustParams::default()
            },
            grey
        ),
        [0.5; 3]
    ));
    let offset = AdjustParams {
        gain: [2.0, 1.0, 0.0],
        offset: [0.0, 0.5, 1.0],
        ..AdjustParams::default()
    };
    assert_eq!(adjusted(offset, grey), [0.5, 0.75, 1.0]);
    let grey_luma = luma([1.0, 0.5, 0.0]) as f32;
    let faded = adjusted(
        AdjustParams {
            saturation: 0.0,
            ..AdjustParams::default()
        },
        [1.0, 0.5, 0.0],
    );
    assert!(close(faded, [grey_luma; 3]));
}

#[test]
fn gain_comes_before_contrast_and_gamma_comes_last() {
    let params = AdjustParams {
        gain: [2.0; 3],
        contrast: 0.5,
        gamma: 0.5,
        ..AdjustParams::default()
    };
    // 0.25 → 0.5 → 0.5 → 0.25
    assert!(close(adjusted(params, [0.25; 3]), [0.25; 3]));
}

#[test]
fn transparency_stays_nothing_whatever_is_added() {
    let node = Adjust::new(&AdjustParams {
        offset: [0.5; 3],
        ..AdjustParams::default()
    });
    assert_eq!(node.colour([0.0; 4]), [0.0; 4]);
}

#[test]
fn senseless_numbers_count_as_defaults() {
    let params = AdjustParams {
        brightness: f64::NAN,
        gamma: f64::INFINITY,
        ..AdjustParams::default()
    };
    assert!(Adjust::new(&params).is_identity());
    let zero = Adjust::new(&AdjustParams {
        gamma: 0.0,
        ..AdjustParams::default()
    });
    assert!(
        zero.colour([0.5, 0.5, 0.5, 1.0])
            .iter()
            .all(|v| v.is_finite())
    );
}

proptest! {
    #[test]
    fn planes_of_any_length_agree_with_single_colours_to_the_bit(
        samples in prop::collection::vec((prop::array::uniform3(-0.5..2.0_f32), prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32]), 1..200),
        gamma in prop_oneof![Just(1.0), 0.2..4.0_f64], hue_deg in -180.0..180.0_f64,
    ) {
        let node = Adjust::new(&AdjustParams { gamma, hue_deg, contrast: 1.3, ..AdjustParams::default() });
        let mut block = Block::new(Bands::Colour, samples.len(), 1);
        for (i, (rgb, a)) in samples.iter().enumerate() {
            for (plane, v) in [rgb[0], rgb[1], rgb[2], *a].into_iter().enumerate() {
                block.plane_mut(plane)[i] = v;
            }
        }
        let mut out = Block::new(Bands::Colour, samples.len(), 1);
        let grid = relievo_planet::TileKey::new(relievo_planet::LevelKey::new(1, 0), 0, 0).unwrap().grid();
        let cancel = relievo_raster::Cancel::default();
        node.render(&Job { grid: &grid, cancel: &cancel }, &[&block], &mut out).unwrap();
        for (i, (rgb, a)) in samples.iter().enumerate() {
            for (plane, v) in node.colour([rgb[0], rgb[1], rgb[2], *a]).into_iter().enumerate() {
                prop_assert_eq!(out.plane(plane)[i].to_bits(), v.to_bits(), "{:?} {}", rgb, a);
            }
        }
    }

    #[test]
    fn turning_hue_keeps_luma_and_greys_and_adds_up(
        rgb in prop::array::uniform3(0.0..1.0_f32), a in -400.0..400.0_f64, b in -400.0..400.0_f64,
    ) {
        let turn = |hue_deg, rgb| adjusted(AdjustParams { hue_deg, ..AdjustParams::default() }, rgb);
        prop_assert!((luma(turn(a, rgb)) - luma(rgb)).abs() < 1e-6);
        prop_assert!(close(turn(a, [rgb[0]; 3]), [rgb[0]; 3]));
        prop_assert!(close(turn(a, turn(b, rgb)), turn(a + b, rgb)));
    }

    #[test]
    fn blocks_are_adjusted_sample_by_sample(
        values in prop::collection::vec(0.0..1.0_f32, 36), gamma in 0.3..3.0_f64, hue_deg in 0.0..360.0_f64,
    ) {
        let mut input = Block::new(Bands::Colour, 9, 1);
        input.samples_mut().copy_from_slice(&values);
        let node = Adjust::new(&AdjustParams { gamma, hue_deg, contrast: 1.5, ..AdjustParams::default() });
        let mut out = Block::new(Bands::Colour, 9, 1);
        let grid = relievo_planet::TileKey::new(relievo_planet::LevelKey::new(0, 0), 0, 0).unwrap().grid();
        let cancel = relievo_raster::Cancel::default();
        node.render(&Job { grid: &grid, cancel: &cancel }, &[&input], &mut out).unwrap();
        for i in 0..9 {
            let at = |block: &Block| core::array::from_fn(|plane| block.plane(plane)[i]);
            prop_assert_eq!(node.colour(at(&input)), at(&out));
        }
    }
}
