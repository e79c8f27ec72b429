use glam::DMat3;
use proptest::prelude::*;

use super::super::TooFewPairs;
use super::*;

const METHODS: [MatchMethod; 3] = [
    MatchMethod::MeanAndSpread,
    MatchMethod::Histogram,
    MatchMethod::Regression,
];

/// Ground of many colours, and how another camera would see it.
fn ground(count: u32, camera: impl Fn(DVec3) -> DVec3) -> Vec<ColourPair> {
    (0..count)
        .map(|i| {
            let part = |k: u32| {
                f64::from(
                    i.wrapping_mul(2_654_435_761)
                        .wrapping_add(k.wrapping_mul(974_711))
                        >> 8
                        & 0xFFFF,
                ) / 65_535.0
            };
            let light = 0.2 + 0.5 * part(1);
            let colour = DVec3::new(
                light,
                light * (0.8 + 0.3 * part(77)),
                light * (0.6 + 0.3 * part(191)),
            );
            ColourPair {
                from: colour.as_vec3().to_array(),
                to: camera(colour).as_vec3().to_array(),
            }
        })
        .collect()
}

fn hazy(colour: DVec3) -> DVec3 {
    DMat3::from_cols_array(&[0.8, 0.05, 0.02, 0.1, 0.7, 0.05, 0.0, 0.1, 0.6]) * colour
        + DVec3::new(0.05, 0.08, 0.12)
}

/// A change that is found, and how good it is.
fn matched(pairs: &[ColourPair], method: MatchMethod) -> (ColourChange, ColourFit) {
    let ground = CommonGround::of(pairs).unwrap();
    let change = ground.change(method);
    let fit = ground.fit(|rgb| {
        let mapped = change.map.apply(rgb).to_array();
        core::array::from_fn(|c| between(&change.curves[c], mapped[c]) as f32)
    });
    (change, fit)
}

/// A curve straight between its points, near which all curves through them are.
fn between(points: &[[f64; 2]], x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    let after = points.partition_point(|p| p[0] <= x);
    match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
        (None, None) => x,
        (Some(only), None) => only[1],
        (None, Some(only)) => only[1],
        (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
    }
}

#[test]
fn alike_pictures_are_left_alone_by_every_method() {
    let pairs = ground(400, |c| c);
    for method in METHODS {
        let (_, fit) = matched(&pairs, method);
        assert!(
            fit.before.mean < 1e-9 && fit.after.mean < 0.05,
            "{method:?} {fit:?}"
        );
        assert_eq!(fit.same, 400);
    }
}

#[test]
fn regression_finds_a_cameras_map_though_a_third_is_cloud_or_newly_built() {
    let mut pairs = ground(900, hazy);
    for (i, pair) in pairs.iter_mut().enumerate() {
        match i % 6 {
            0 => pair.to = [0.95, 0.95, 0.97],
            1 => pair.to = [0.1, 0.5, 0.9],
            _ => {}
        }
    }
    let (change, fit) = matched(&pairs, MatchMethod::Regression);
    assert_eq!(fit.same, 600);
    assert!(fit.after.mean_of_same < 0.05, "{fit:?}");
    for colour in [DVec3::splat(0.3), DVec3::new(0.5, 0.45, 0.4)] {
        let mapped = change.map.apply(colour.as_vec3().to_array());
        assert!(mapped.abs_diff_eq(hazy(colour), 2e-3), "{mapped}");
    }
}

#[test]
fn mean_and_spread_give_means_and_spreads() {
    let pairs = ground(500, |c| {
        c * DVec3::new(0.5, 0.8, 1.1) + DVec3::new(0.2, 0.1, -0.05)
    });
    let (found, _) = matched(&pairs, MatchMethod::MeanAndSpread);
    let gain = [0, 1, 2].map(|c| found.map.matrix.col(c)[c]);
    for (found, expected) in gain.into_iter().zip([0.5, 0.8, 1.1]) {
        assert!((found - expected).abs() < 1e-3, "{gain:?}");
    }
    assert!(
        found
            .map
            .offset
            .abs_diff_eq(DVec3::new(0.2, 0.1, -0.05), 1e-3)
    );
}

#[test]
fn histograms_follow_what_bends() {
    let pairs = ground(2000, |c| c.powf(1.8));
    let (curved, bent) = matched(&pairs, MatchMethod::Histogram);
    let (_, straight) = matched(&pairs, MatchMethod::MeanAndSpread);
    assert!(
        bent.after.mean < 0.4 && bent.after.mean < straight.after.mean,
        "{bent:?}"
    );
    for curve in &curved.curves {
        assert!(
            curve
                .windows(2)
                .all(|p| p[0][0] < p[1][0] && p[0][1] <= p[1][1]),
            "{curve:?}"
        );
    }
}

#[test]
fn one_colour_and_no_colours_are_no_trouble() {
    let one = vec![
        ColourPair {
            from: [0.25; 3],
            to: [0.5, 0.4, 0.3]
        };
        60
    ];
    for method in METHODS {
        let (change, fit) = matched(&one, method);
        assert!(fit.after.mean < 0.3, "{method:?} {fit:?}");
        assert!(change.map.matrix.is_finite() && change.map.offset.is_finite());
    }
    let missing = [ColourPair {
        from: [f32::NAN; 3],
        to: [0.0; 3],
    }; 100];
    for none in [missing.as_slice(), &[]] {
        assert_eq!(CommonGround::of(none), Err(TooFewPairs { found: 0 }));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn no_method_makes_alike_ground_worse_and_the_same_pairs_give_the_same_fit(
        gain in prop::array::uniform3(0.5..1.5_f64), offset in prop::array::uniform3(-0.1..0.2_f64), outliers in 0..3_usize,
    ) {
        let mut pairs = ground(300, |c| c * DVec3::from(gain) + DVec3::from(offset));
        for pair in pairs.iter_mut().step_by(10).take(10 * outliers) {
            pair.to = [1.0, 0.0, 1.0];
        }
        for method in METHODS {
            let found = matched(&pairs, method);
            let (before, after) = (found.1.before, found.1.after);
            prop_assert!(after.mean_of_same <= before.mean_of_same + 0.5, "{method:?} {before:?} {after:?}");
            prop_assert_eq!(found, matched(&pairs, method));
        }
    }
}
