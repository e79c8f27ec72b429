use core::f64::consts::TAU;

use proptest::prelude::*;

use super::*;

const SIDE: usize = 192;

/// Heights of many plane waves of random directions, as high as their lengths to the power of an exponent:
/// a power law from a quarter of a sample to some thousand.
fn surface(exponent: f64, seed: u32) -> impl Fn(f64, f64) -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state) / f64::from(u32::MAX)
    };
    let octaves = 14.0;
    let waves: Vec<[f64; 4]> = (0..420)
        .map(|i| {
            let length = libm::exp2(-2.0 + octaves * (f64::from(i) + random()) / 420.0);
            let (sin, cos) = libm::sincos(TAU * random());
            let height = 0.1 * libm::pow(length, exponent);
            [
                TAU * cos / length,
                TAU * sin / length,
                TAU * random(),
                height,
            ]
        })
        .collect();
    move |x, y| {
        let wave = |[kx, ky, phase, height]: &[f64; 4]| height * libm::cos(kx * x + ky * y + phase);
        waves.iter().map(wave).sum()
    }
}

/// Its mean squared second difference at a lag, over all directions and places: of each wave
/// 6 − 8 J₀ + 2 J₀ at twice the lag, times half of its height squared. By the law alone.
fn law_of(exponent: f64) -> impl Fn(f64) -> f64 {
    move |lag| {
        (0..4200)
            .map(|i| {
                let length = libm::exp2(-2.0 + 14.0 * (f64::from(i) + 0.5) / 4200.0);
                let height = 0.1 * libm::pow(length, exponent);
                let t = TAU * lag / length;
                0.1 * 0.5 * height * height * (6.0 - 8.0 * libm::j0(t) + 2.0 * libm::j0(2.0 * t))
            })
            .sum()
    }
}

fn square(height_m: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let at = |i: usize| height_m((i % SIDE) as f64, (i / SIDE) as f64) as f32;
    (0..SIDE * SIDE).map(at).collect()
}

fn measured(heights: &[f32]) -> Vec<Measured> {
    let surface = Surface::new(heights, SIDE, 1.0, |_| 1.0);
    let lags = [4, 8, 16, 32].into_iter();
    let found = lags.filter_map(|lag| {
        let energy = surface.energy(lag, 0..SIDE, 0..SIDE);
        Some(Measured {
            lag_m: surface.lag_m(lag),
            energy_m2: energy.mean_m2()?,
            independent: energy.independent(lag),
        })
    });
    found.collect()
}

fn decibels(one: f64, other: f64) -> f64 {
    10.0 * libm::log10(one / other)
}

#[test]
fn the_law_of_a_surface_is_found() {
    for exponent in [0.5, 0.7, 0.9] {
        for seed in [1, 2] {
            let heights = square(surface(exponent, seed));
            let law = PowerLaw::fit(&measured(&heights), 0.0).unwrap();
            assert!(
                (law.exponent - exponent).abs() < 0.12,
                "{exponent}: {law:?}"
            );
            let (found, true_m2) = (law.energy_m2(4.0), law_of(exponent)(4.0));
            assert!(decibels(found, true_m2).abs() < 1.5, "{found} {true_m2}");
        }
    }
}

#[test]
fn what_data_lack_is_put_back() {
    // Means over squares of 2 by 2, then bilinear between them.
    let spacing = 2.0;
    for exponent in [0.5, 0.7, 0.9] {
        let fine = surface(exponent, 7);
        let mean = |column: i32, row: i32| {
            let part = |i: i32| 0.5 * (f64::from(i % 4) - 1.5);
            let at = |c: i32, i: i32| f64::from(c) * spacing + part(i);
            (0..16)
                .map(|i| fine(at(column, i), at(row, i / 4)))
                .sum::<f64>()
                / 16.0
        };
        let columns = SIDE as i32 / 2 + 2;
        let data: Vec<f64> = (0..columns * columns)
            .map(|i| mean(i % columns, i / columns))
            .collect();
        let heights = square(|x, y| {
            let (c, r) = ((x / spacing) as i32, (y / spacing) as i32);
            let (fx, fy) = (x / spacing - f64::from(c), y / spacing - f64::from(r));
            let h = |dc: i32, dr: i32| data[((r + dr) * columns + c + dc) as usize];
            let north = h(0, 0) * (1.0 - fx) + h(1, 0) * fx;
            let south = h(0, 1) * (1.0 - fx) + h(1, 1) * fx;
            north * (1.0 - fy) + south * fy
        });
        // Lags of 2 to 16 samples of the data.
        let all = measured(&heights);
        let lacking = PowerLaw::fit(&all, 0.0).unwrap();
        let law = PowerLaw::fit(&all, spacing).unwrap();
        let whole = PowerLaw::fit(&measured(&square(&fine)), 0.0).unwrap();
        let whole_m2 = whole.energy_m2(spacing);
        let [without, with] = [lacking, law].map(|l| decibels(l.energy_m2(spacing), whole_m2));
        assert!(
            with.abs() < 1.0 && without < with - 0.5,
            "{exponent}: {without} {with}"
        );
    }
}

#[test]
fn neither_height_nor_tilt_nor_holes_are_rough() {
    let plain = square(|x, y| 1200.0 + 3.0 * x - 0.5 * y);
    assert!(measured(&plain).iter().all(|m| m.energy_m2 < 1e-6));
    let level = square(|_, _| 7.0);
    assert_eq!(PowerLaw::fit(&measured(&level), 0.0), None);
    let nothing = square(|_, _| f64::NAN);
    assert_eq!(measured(&nothing), Vec::new());
    assert_eq!(PowerLaw::fit(&[], 30.0), None);
    let one = Surface::new(&[5.0], 1, 1.0, |_| 1.0);
    assert_eq!(one.energy(4, 0..1, 0..1), Energy::default());
}

#[test]
fn holes_leave_the_law_of_the_rest() {
    let whole = square(surface(0.7, 3));
    let mut holed = whole.clone();
    for (i, h) in holed.iter_mut().enumerate() {
        if (i.wrapping_mul(2_654_435_761) >> 7) % 5 == 0 {
            *h = f32::NAN;
        }
    }
    let pairs = measured(&whole).into_iter().zip(measured(&holed));
    for (whole, holed) in pairs {
        assert!(decibels(whole.energy_m2, holed.energy_m2).abs() < 0.5);
        assert!(holed.independent < 0.7 * whole.independent);
    }
}

#[test]
fn narrow_samples_count_as_if_they_were_square() {
    let surface_m = surface(0.8, 5);
    let of = |across_m: f64| {
        let heights = square(|x, y| surface_m(x * across_m, y));
        let surface = Surface::new(&heights, SIDE, 1.0, |_| across_m);
        surface.energy(8, 0..SIDE, 0..SIDE).mean_m2().unwrap()
    };
    assert!(decibels(of(0.7), of(1.0)).abs() < 1.0);
    // Next to a pole only columns are compared.
    let heights = square(|x, y| surface_m(x * 0.01, y));
    let surface = Surface::new(&heights, SIDE, 1.0, |_| 0.01);
    let both = Surface::new(&heights, SIDE, 1.0, |_| 1.0);
    assert!(surface.energy(8, 0..SIDE, 0..SIDE).count < both.energy(8, 0..SIDE, 0..SIDE).count);
}

proptest! {
    #[test]
    fn any_energies_give_a_law_within_its_range(
        energies in prop::collection::vec((0.1..1e6_f64, 1e-12..1e12_f64, 0.0..1e6_f64), 0..6), spacing_m in 0.0..1e4_f64,
    ) {
        let measured: Vec<Measured> = energies
            .iter()
            .map(|(lag_m, energy_m2, independent)| Measured {
                lag_m: *lag_m,
                energy_m2: *energy_m2,
                independent: *independent,
            })
            .collect();
        if let Some(law) = PowerLaw::fit(&measured, spacing_m) {
            prop_assert!((EXPONENTS[0]..=EXPONENTS[1]).contains(&law.exponent));
            prop_assert!(law.energy_m2(1.0).is_finite());
        }
    }
}
