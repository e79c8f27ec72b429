use proptest::prelude::*;

use relievo_raster::colour::linear_from_srgb;

use super::*;

const MODES: [BlendMode; 18] = BlendMode::ALL;

fn colours() -> impl Strategy<Value = [f32; 4]> {
    (
        prop::array::uniform3(0.0..=1.0_f32),
        prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32],
    )
        .prop_map(|([r, g, b], a)| if a > 0.0 { [r, g, b, a] } else { [0.0; 4] })
}

proptest! {
    #[test]
    fn a_weight_of_nothing_gives_the_base_to_the_bit(base in colours(), top in colours(), mode in 0..MODES.len()) {
        let node = Overlay::new(MODES[mode], 1.0, true);
        prop_assert_eq!(node.composite(base, top, 0.0), base);
        prop_assert_eq!(node.composite(base, [0.0; 4], 1.0), base);
    }

    #[test]
    fn an_opaque_top_in_normal_mode_hides_the_base_to_the_bit(base in colours(), top in colours()) {
        let opaque = [top[0], top[1], top[2], 1.0];
        prop_assert_eq!(Overlay::new(BlendMode::Normal, 1.0, false).composite(base, opaque, 1.0), opaque);
    }

    #[test]
    fn nothing_below_leaves_the_top_to_the_bit(top in colours(), mode in 0..MODES.len()) {
        prop_assert_eq!(Overlay::new(MODES[mode], 1.0, false).composite([0.0; 4], top, 1.0), top);
    }

    #[test]
    fn many_samples_agree_with_single_ones_to_the_bit(
        samples in prop::collection::vec((colours(), colours(), prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32]), LANES),
        mode in 0..MODES.len(), kind in 0..5_usize,
    ) {
        // All kinds of samples together, and lanes of one kind.
        let samples: Vec<_> = samples.into_iter().map(|(mut base, mut top, mut w)| {
            if kind == 1 { top = [0.0; 4]; }
            if kind >= 2 { (top[3], w) = (1.0, 1.0); }
            if kind == 3 { base = [0.0; 4]; }
            if kind == 4 { base[3] = 1.0; }
            (base, top, w)
        }).collect();
        let node = Overlay::new(MODES[mode], 1.0, true);
        let mut base: Colours = core::array::from_fn(|plane| core::array::from_fn(|l| samples[l].0[plane]));
        let top: Colours = core::array::from_fn(|plane| core::array::from_fn(|l| samples[l].1[plane]));
        let weight = core::array::from_fn(|l| samples[l].2);
        on_widest(
            #[inline(always)]
            || node.composite_lanes(&mut base, &top, &weight),
        );
        for (l, (b, t, w)) in samples.into_iter().enumerate() {
            let one = node.composite(b, t, w);
            for (plane, v) in one.into_iter().enumerate() {
                prop_assert_eq!(v.to_bits(), base[plane][l].to_bits(), "{:?} over {:?}", t, b);
            }
        }
    }

    #[test]
    fn an_opaque_base_stays_opaque(base in colours(), top in colours(), w in 0.0..1.0_f32, mode in 0..MODES.len()) {
        let base = [base[0], base[1], base[2], 1.0];
        prop_assert_eq!(Overlay::new(MODES[mode], w, false).composite(base, top, w)[3], 1.0);
    }

    #[test]
    fn normal_mode_agrees_with_premultiplied_over(base in colours(), top in colours(), w in 0.0..1.0_f32) {
        let node = Overlay::new(BlendMode::Normal, w, false);
        let mixed = node.composite(base, top, w);
        let at = top[3] * w;
        let alpha = at + base[3] * (1.0 - at);
        prop_assume!(alpha > 0.01);
        prop_assert!((mixed[3] - alpha).abs() < 1e-6);
        for c in 0..3 {
            let linear = |v| f64::from(linear_from_srgb(v));
            let over = f64::from(at) * linear(top[c]) + f64::from((1.0 - at) * base[3]) * linear(base[c]);
            prop_assert!((linear(mixed[c]) - over / f64::from(alpha)).abs() < 2e-5);
        }
    }
}

#[test]
fn modes_give_the_values_of_the_specification() {
    let value = |mode: BlendMode, b: f32, t: f32| mode.blend([b; 3], [t; 3])[0];
    assert_eq!(value(BlendMode::Multiply, 0.5, 0.5), 0.25);
    assert_eq!(value(BlendMode::Screen, 0.5, 0.5), 0.75);
    assert_eq!(value(BlendMode::Overlay, 0.25, 0.5), 0.25);
    assert_eq!(value(BlendMode::Overlay, 0.75, 0.5), 0.75);
    assert_eq!(value(BlendMode::Add, 0.75, 0.5), 1.25);
    assert_eq!(value(BlendMode::Subtract, 0.75, 0.5), 0.25);
    assert_eq!(value(BlendMode::Difference, 0.25, 0.5), 0.25);
    assert_eq!(value(BlendMode::Exclusion, 0.25, 0.5), 0.5);
    assert_eq!(value(BlendMode::Darken, 0.25, 0.5), 0.25);
    assert_eq!(value(BlendMode::Lighten, 0.25, 0.5), 0.5);
    assert_eq!(value(BlendMode::ColourDodge, 0.25, 0.5), 0.5);
    assert_eq!(value(BlendMode::ColourDodge, 0.0, 1.0), 0.0);
    assert_eq!(value(BlendMode::ColourBurn, 0.75, 0.5), 0.5);
    assert_eq!(value(BlendMode::ColourBurn, 1.0, 0.0), 1.0);
    assert_eq!(value(BlendMode::HardLight, 0.5, 0.25), 0.25);
    assert_eq!(value(BlendMode::SoftLight, 0.5, 0.5), 0.5);
    // 0.64 + (2 · 0.75 − 1) (√0.64 − 0.64)
    assert!((value(BlendMode::SoftLight, 0.64, 0.75) - 0.72).abs() < 1e-6);
    // 0.5 − (1 − 2 · 0.25) 0.5 · 0.5
    assert!((value(BlendMode::SoftLight, 0.5, 0.25) - 0.375).abs() < 1e-6);
}

#[test]
fn modes_of_whole_colours_take_what_they_are_named_for_from_the_top() {
    let (base, top) = ([0.2, 0.4, 0.6], [0.7, 0.5, 0.5]);
    let luminosity = |[r, g, b]: [f32; 3]| 0.3 * r + 0.59 * g + 0.11 * b;
    let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
    for mode in [BlendMode::Hue, BlendMode::Saturation, BlendMode::Colour] {
        assert!(
            close(luminosity(mode.blend(base, top)), luminosity(base)),
            "{mode:?}"
        );
    }
    let lit = BlendMode::Luminosity.blend(base, top);
    assert!(close(luminosity(lit), luminosity(top)));
    // The top's differences between channels: its colour.
    let [r, g, b] = BlendMode::Colour.blend(base, top);
    assert!(close(r - g, 0.2) && close(g, b));
    // The base's saturation, 0.4, on the top's hue, red; pure greys have none.
    let [r, g, b] = BlendMode::Hue.blend(base, top);
    assert!(close(r - g, 0.4) && close(g, b));
    let grey = BlendMode::Saturation.blend(base, [0.3; 3]);
    assert!(grey.iter().all(|v| close(*v, luminosity(base))));
    // Never out of range, whatever meets.
    for mode in &MODES[14..] {
        let met = mode.blend([1.0, 0.9, 0.0], [0.0, 0.0, 1.0]);
        assert!(
            met.iter().all(|v| (-1e-6..=1.0 + 1e-6).contains(v)),
            "{mode:?} {met:?}"
        );
    }
}
