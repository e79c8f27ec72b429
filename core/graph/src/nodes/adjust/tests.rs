use proptest::prelude::*;

use super::affine::LUMA;
use super::*;

fn adjusted(params: &AdjustParams, rgb: [f32; 3]) -> [f32; 3] {
    let [r, g, b, a] = Adjust::new(params).colour([rgb[0], rgb[1], rgb[2], 1.0]);
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
            &AdjustParams {
                brightness: 0.25,
                ..AdjustParams::default()
            },
            grey
        ),
        [0.5; 3]
    );
    assert_eq!(
        adjusted(
            &AdjustParams {
                contrast: 2.0,
                ..AdjustParams::default()
            },
            grey
        ),
        [0.0; 3]
    );
    assert!(close(
        adjusted(
            &AdjustParams {
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
    assert_eq!(adjusted(&offset, grey), [0.5, 0.75, 1.0]);
    let grey_luma = luma([1.0, 0.5, 0.0]) as f32;
    let faded = adjusted(
        &AdjustParams {
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
    assert!(close(adjusted(&params, [0.25; 3]), [0.25; 3]));
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

fn with(change: impl FnOnce(&mut AdjustParams)) -> AdjustParams {
    let mut params = AdjustParams::default();
    change(&mut params);
    params
}

#[test]
fn levels_take_black_and_white_points_to_the_ends() {
    // Black at 0.2, white at 0.7.
    let stretch = with(|p| {
        p.gain = [2.0; 3];
        p.offset = [-0.4; 3];
    });
    assert!(close(adjusted(&stretch, [0.2; 3]), [0.0; 3]));
    assert!(close(adjusted(&stretch, [0.7; 3]), [1.0; 3]));
}

#[test]
fn channels_are_mixed_before_their_gain() {
    let swap = with(|p| {
        p.mix = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        p.gain = [0.5, 1.0, 1.0];
    });
    assert!(close(adjusted(&swap, [0.1, 0.2, 0.8]), [0.4, 0.2, 0.1]));
}

#[test]
fn contrast_keeps_the_same_grey_in_every_space() {
    let shown = srgb(0.214_041_14);
    assert!((shown - 0.5).abs() < 1e-6);
    for space in [AdjustSpace::Display, AdjustSpace::Linear] {
        let params = with(|p| {
            p.space = space;
            p.contrast = 1.7;
        });
        assert!(close(adjusted(&params, [0.5; 3]), [0.5; 3]), "{space:?}");
    }
}

fn srgb(linear: f32) -> f32 {
    relievo_raster::colour::srgb_from_linear(linear)
}

#[test]
fn gain_in_linear_light_is_exposure() {
    let params = with(|p| {
        p.space = AdjustSpace::Linear;
        p.gain = [2.0; 3];
    });
    assert!(close(adjusted(&params, [srgb(0.1); 3]), [srgb(0.2); 3]));
}

#[test]
fn perceptual_saturation_and_hue_keep_greys_and_lightness_order() {
    let params = with(|p| {
        p.space = AdjustSpace::Perceptual;
        p.saturation = 0.0;
    });
    let [r, g, b] = adjusted(&params, [0.9, 0.2, 0.3]);
    assert!((r - g).abs() < 1e-4 && (g - b).abs() < 1e-4, "{r} {g} {b}");
    let turned = with(|p| {
        p.space = AdjustSpace::Perceptual;
        p.hue_deg = 90.0;
    });
    let grey = adjusted(&turned, [0.4; 3]);
    assert!(grey.iter().all(|v| (v - 0.4).abs() < 1e-4), "{grey:?}");
}

#[test]
fn curves_come_after_gamma_and_the_common_one_first() {
    let params = with(|p| {
        p.gamma = 2.0;
        p.curve = Curve::through(&[[0.0, 0.0], [0.5, 0.25], [1.0, 1.0]]);
        p.curves[2] = Curve::through(&[[0.0, 1.0], [1.0, 0.0]]);
    });
    // 0.25 → 0.5 → 0.25, blue 0.75.
    let [r, g, b] = adjusted(&params, [0.25; 3]);
    assert!(
        (r - 0.25).abs() < 1e-5 && r == g && (b - 0.75).abs() < 1e-5,
        "{r} {g} {b}"
    );
}

#[test]
fn inversion_twice_is_nothing_and_curves_are_inverted_after() {
    let inverted = with(|p| p.invert = true);
    let once = adjusted(&inverted, [0.1, 0.5, 0.8]);
    assert!(close(once, [0.9, 0.5, 0.2]));
    assert!(close(adjusted(&inverted, once), [0.1, 0.5, 0.8]));
    let both = with(|p| {
        p.invert = true;
        p.curve = Curve::through(&[[0.0, 0.5], [1.0, 0.5]]);
    });
    assert!(close(adjusted(&both, [0.3; 3]), [0.5; 3]));
}

#[test]
fn a_cleared_colour_is_transparent_and_the_rest_is_mixed_out_of_it() {
    let node = Adjust::new(&with(|p| {
        p.clear = Some(Clear {
            rgb: [1.0; 3],
            from: 0.0,
            to: 1.0,
        });
    }));
    assert_eq!(node.colour([1.0, 1.0, 1.0, 1.0]), [0.0; 4]);
    let [r, _, b, a] = node.colour([1.0, 0.5, 0.5, 0.8]);
    assert!((a - 0.4).abs() < 1e-6 && (r - 1.0).abs() < 1e-6 && b.abs() < 1e-6);
    // What covered everything may not any more.
    assert_eq!(node.known(&grid(), &[Known::Complete]), Known::Nothing);
}

fn grid() -> Grid {
    let level = relievo_planet::LevelKey::new(1, 0);
    relievo_planet::TileKey::new(level, 0, 0).unwrap().grid()
}

#[test]
fn no_strength_is_the_identity_and_half_is_half_way() {
    assert!(
        Adjust::new(&with(|p| {
            p.invert = true;
            p.strength = 0.0;
        }))
        .is_identity()
    );
    let half = with(|p| {
        p.gain = [0.0; 3];
        p.strength = 0.5;
    });
    assert!(close(adjusted(&half, [0.2, 0.4, 0.8]), [0.1, 0.2, 0.4]));
}

#[test]
fn nodes_that_do_different_things_have_different_names() {
    let node = |change: fn(&mut AdjustParams)| Adjust::new(&with(change)).name;
    let names = [
        node(|_| ()),
        node(|p| p.invert = true),
        node(|p| p.strength = 0.5),
        node(|p| p.white.temperature_k = 5000.0),
        node(|p| p.white.tint = 10.0),
        node(|p| p.mix[0][1] = 0.5),
        node(|p| p.curve = Curve::through(&[[0.0, 0.1], [1.0, 1.0]])),
        node(|p| p.curves[0] = Curve::through(&[[0.0, 0.1], [1.0, 1.0]])),
        node(|p| {
            p.space = AdjustSpace::Linear;
            p.contrast = 1.5;
        }),
        node(|p| {
            p.space = AdjustSpace::Perceptual;
            p.contrast = 1.5;
        }),
        node(|p| p.contrast = 1.5),
        node(|p| {
            p.clear = Some(Clear {
                rgb: [0.0; 3],
                from: 0.0,
                to: 1.0,
            });
        }),
    ];
    let different: std::collections::HashSet<_> = names.iter().collect();
    assert_eq!(different.len(), names.len());
    // A space in which nothing is done is nothing done.
    assert!(Adjust::new(&with(|p| p.space = AdjustSpace::Perceptual)).is_identity());
}

/// Adjustments of every kind.
fn any_params() -> impl Strategy<Value = AdjustParams> {
    let space = prop_oneof![
        Just(AdjustSpace::Display),
        Just(AdjustSpace::Linear),
        Just(AdjustSpace::Perceptual)
    ];
    let numbers = (
        0.3..3.0_f64,
        -180.0..180.0_f64,
        3000.0..9000.0_f64,
        0.0..1.0_f64,
    );
    (space, numbers, any::<[bool; 4]>()).prop_map(
        |(space, (gamma, hue_deg, temperature_k, strength), [warm, bent, clear, weak])| {
            with(|p| {
                p.space = space;
                (p.gamma, p.hue_deg, p.contrast) = (gamma, hue_deg, 1.3);
                if warm {
                    p.white.temperature_k = temperature_k;
                }
                if bent {
                    p.curve = Curve::through(&[[0.0, 0.05], [0.4, 0.6], [1.0, 0.9]]);
                }
                p.clear = clear.then_some(Clear {
                    rgb: [0.2, 0.9, 0.4],
                    from: 0.05,
                    to: 0.6,
                });
                p.strength = if weak { strength } else { 1.0 };
            })
        },
    )
}

proptest! {
    #[test]
    fn planes_of_any_length_agree_with_single_colours_to_the_bit(
        samples in prop::collection::vec((prop::array::uniform3(-0.5..2.0_f32), prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32]), 1..200),
        params in any_params(),
    ) {
        let node = Adjust::new(&params);
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
        let turn = |hue_deg, rgb| adjusted(&AdjustParams { hue_deg, ..AdjustParams::default() }, rgb);
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
