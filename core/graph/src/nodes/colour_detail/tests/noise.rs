//! What is added by noise.

use core::f64::consts::TAU;

use super::*;

/// Waves of all lengths and directions, of which the energy falls by 2^`falloff` from octave to octave.
struct Waves(Vec<Wave>);

struct Wave {
    /// Radians in a coarse sample.
    along: [f64; 2],
    phase: f64,
    amplitude: f64,
}

impl Waves {
    fn new(falloff: f64, seed: u64) -> Self {
        const COUNT: u64 = 900;
        let chance = |k: u64| f64::from(noise(k as i64, 5, seed));
        let wave = |k: u64| {
            // 64 coarse samples to a sixteenth of one.
            let octave = -6.0 + 10.0 * (k as f64 + 0.5) / COUNT as f64;
            let direction = TAU * chance(2 * k);
            let radians = TAU * libm::exp2(octave);
            Wave {
                along: [
                    radians * libm::cos(direction),
                    radians * libm::sin(direction),
                ],
                phase: TAU * chance(2 * k + 1),
                amplitude: libm::exp2(-0.5 * falloff * octave),
            }
        };
        let mut waves: Vec<Wave> = (0..COUNT).map(wave).collect();
        let squares: f64 = waves.iter().map(|w| w.amplitude * w.amplitude / 2.0).sum();
        for wave in &mut waves {
            wave.amplitude *= 0.15 / squares.sqrt();
        }
        Self(waves)
    }

    /// Means over samples of so many coarse ones along a side: values around 0, row by row.
    fn means(&self, rect: &SampleRect, side: f64) -> Vec<f64> {
        let mut all = vec![0.0; rect.area() as usize];
        let width = rect.width() as usize;
        let sinc = |v: f64| {
            if v.abs() < 1e-9 {
                1.0
            } else {
                libm::sin(v) / v
            }
        };
        for wave in &self.0 {
            let amplitude = wave.amplitude
                * wave
                    .along
                    .iter()
                    .map(|a| sinc(0.5 * a * side))
                    .product::<f64>();
            let turn =
                |axis: usize, at: i64| libm::sincos(wave.along[axis] * (at as f64 + 0.5) * side);
            let columns: Vec<_> = (rect.min.x..rect.max.x).map(|x| turn(0, x)).collect();
            for (row, y) in all.chunks_exact_mut(width).zip(rect.min.y..) {
                let (sin_y, cos_y) =
                    libm::sincos(wave.along[1] * (y as f64 + 0.5) * side + wave.phase);
                for (v, (sin_x, cos_x)) in row.iter_mut().zip(&columns) {
                    *v += amplitude * (cos_x * cos_y - sin_x * sin_y);
                }
            }
        }
        all
    }
}

/// Grey of a light that varies around a mean.
fn grey(values: &[f64], width: usize, light: f64) -> Block {
    let mut block = Block::filled(
        Bands::Colour,
        width,
        values.len() / width,
        &[0.0, 0.0, 0.0, 1.0],
    );
    for plane in 0..3 {
        for (v, value) in block.plane_mut(plane).iter_mut().zip(values) {
            *v = srgb_from_linear((light * (1.0 + value)) as f32);
        }
    }
    block
}

/// The light of a plane relative to a mean.
fn light(block: &Block, plane: usize, mean: f64) -> Vec<f64> {
    let of = |v: &f32| f64::from(linear_from_srgb(*v)) / mean;
    block.plane(plane).iter().map(of).collect()
}

/// Mean square of what samples are above the mean of two by two, from the finest halving on.
fn halvings(values: &[f64], width: usize, count: usize) -> Vec<f64> {
    let (mut values, mut width) = (values.to_vec(), width);
    let mut all = Vec::new();
    for _ in 0..count {
        let (half, rows) = (width / 2, values.len() / width / 2);
        let (mut means, mut sum) = (Vec::new(), 0.0);
        for y in 0..rows {
            for x in 0..half {
                let at = 2 * y * width + 2 * x;
                let quad = [at, at + 1, at + width, at + width + 1].map(|at| values[at]);
                let mean = quad.iter().sum::<f64>() / 4.0;
                sum += quad.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0;
                means.push(mean);
            }
        }
        all.push(sum / means.len() as f64);
        (values, width) = (means, half);
    }
    all
}

/// Of a scene on the equator, where samples are square.
fn origin() -> I64Vec2 {
    I64Vec2::new(400_000, COARSE.samples().y / 2 - 80)
}

/// By how much the first three halvings below imagery that follows a law are off from it, decibels: means
/// of several scenes.
///
/// - `imagery`: makes 160 × 160 coarse samples of the law.
/// - `coarse_spacing_m`: what the node is told.
fn off_db(falloff: f64, coarse_spacing_m: f64, imagery: impl Fn(&Waves) -> Vec<f64>) -> [f64; 3] {
    const SEEDS: u64 = 6;
    let rect = SampleRect::new(origin(), origin() + 160);
    let inner = rect.grow(-60);
    let mut off_db = [0.0; 3];
    for seed in 0..SEEDS {
        let waves = Waves::new(falloff, seed);
        let params = ColourDetailParams {
            seed,
            coarse_spacing_m,
            ..by_noise()
        };
        let imagery = grey(&imagery(&waves), 160, 0.2);
        let fine = Scene::new(rect, imagery, &[], &params).detailed(inner, 3);
        let got = halvings(&light(&fine, 1, 0.2), fine.width(), 3);
        let (min, max) = (inner.min - origin(), inner.max - origin());
        let truth = waves.means(&SampleRect::new(min * 8, max * 8), 0.125);
        let wanted = halvings(&truth, fine.width(), 3);
        for k in 0..3 {
            off_db[k] += 10.0 * (got[k] / wanted[k]).log10() / SEEDS as f64;
        }
    }
    off_db
}

#[test]
fn the_power_law_of_the_imagery_goes_on_without_a_step() {
    for falloff in [0.0, 0.3, 0.6, 1.0] {
        let all = SampleRect::at(0, 0, 160, 160);
        let off_db = off_db(falloff, spacing_m(COARSE), |waves| waves.means(&all, 1.0));
        assert!(
            off_db.iter().all(|db| db.abs() < 1.5),
            "{falloff}: {off_db:?}"
        );
        let steps = off_db.windows(2).map(|w| w[1] - w[0]);
        assert!(
            steps.into_iter().all(|db| db.abs() < 0.8),
            "{falloff}: {off_db:?}"
        );
    }
}

#[test]
fn of_imagery_sparser_than_the_samples_the_law_goes_on_too() {
    for falloff in [0.0, 0.3, 0.6, 1.0] {
        let sparse = SampleRect::at(-1, -1, 82, 82);
        let off_db = off_db(falloff, 1.99 * spacing_m(COARSE), |waves| {
            let means = waves.means(&sparse, 2.0);
            let between = |i: i64| {
                let from = 0.5 * (i as f64 + 1.5);
                (from.floor() as usize, from.fract())
            };
            let mut all = Vec::new();
            for (row, south) in (0..160).map(between) {
                for (column, east) in (0..160).map(between) {
                    let along = |row: usize| {
                        let at = row * 82 + column;
                        means[at] + east * (means[at + 1] - means[at])
                    };
                    all.push(along(row) + south * (along(row + 1) - along(row)));
                }
            }
            all
        });
        // Linear between sparse samples, much of what they tell is gone.
        assert!(
            off_db.iter().all(|db| db.abs() < 3.5),
            "{falloff}: {off_db:?}"
        );
    }
}

#[test]
fn what_is_level_stays_level_up_to_its_border() {
    // Rough ground in the west, water in the east.
    let rect = SampleRect::new(origin(), origin() + 160);
    let waves = Waves::new(0.3, 1).means(&SampleRect::at(0, 0, 160, 160), 1.0);
    let value = |i: usize| if i % 160 < 80 { waves[i] } else { -0.6 };
    let values: Vec<f64> = (0..waves.len()).map(value).collect();
    let imagery = grey(&values, 160, 0.2);
    let scene = Scene::new(rect, imagery, &[], &by_noise());
    let contrast = |from: i64, to: i64| {
        let min = origin() + I64Vec2::new(from, 60);
        let fine = scene.detailed(SampleRect::new(min, min + I64Vec2::new(to - from, 40)), 3);
        halvings(&light(&fine, 0, 0.2), fine.width(), 1)[0]
    };
    let ground = contrast(40, 76);
    assert!(ground > 3e-4, "{ground}");
    // Within two samples of the border there may be a little.
    for (from, to, most) in [(82, 84, 0.01), (84, 120, 1e-9)] {
        let water = contrast(from, to);
        assert!(
            water < most * ground,
            "{water} from {from} to {to}, {ground}"
        );
    }
}

#[test]
fn dark_ground_has_the_same_pattern_fainter_in_proportion() {
    let rect = SampleRect::new(origin(), origin() + 160);
    let waves = Waves::new(0.3, 2).means(&SampleRect::at(0, 0, 160, 160), 1.0);
    let made = |mean: f64| {
        let scene = Scene::new(rect, grey(&waves, 160, mean), &[], &by_noise());
        light(&scene.detailed(rect.grow(-70), 2), 2, mean)
    };
    let (bright, dark) = (made(0.4), made(0.04));
    for (a, b) in bright.iter().zip(&dark) {
        assert!((a - b).abs() < 2e-4, "{a} {b}");
    }
}

#[test]
fn hue_stays_as_brightness_varies() {
    let rect = SampleRect::new(origin(), origin() + 160);
    let values = Waves::new(0.3, 2).means(&SampleRect::at(0, 0, 160, 160), 1.0);
    let mut imagery = grey(&values, 160, 0.2);
    for v in imagery.plane_mut(0) {
        *v = srgb_from_linear(0.5 * linear_from_srgb(*v));
    }
    let fine = Scene::new(rect, imagery, &[], &by_noise()).detailed(rect.grow(-70), 3);
    let (red, green) = (light(&fine, 0, 1.0), light(&fine, 1, 1.0));
    for (red, green) in red.iter().zip(&green) {
        assert!((red / green - 0.5).abs() < 1e-3, "{red} {green}");
    }
}

#[test]
fn without_strength_noise_is_not_there_at_all_and_needs_no_examples() {
    let fine = TileKey::new(finer(COARSE, 2), 9000, 5000)
        .expect("inside")
        .grid();
    let node = |strength: f64| {
        let params = ColourDetailParams {
            strength,
            ..by_noise()
        };
        ColourDetail::new(Planet::EARTH, &params, places(&rough()), false)
    };
    let (none, some) = (node(0.0), node(1.0));
    assert_eq!(none.identity(&fine, &[Known::Complete]), Some(0));
    assert!(none.artefacts(&fine).is_empty());
    assert_eq!(none.synthesised_below_m(), None);
    assert_eq!(some.identity(&fine, &[Known::Complete]), None);
    // The coarse colours, and no examples.
    assert_eq!(some.artefacts(&fine).len(), 1);
    let input = varied(SampleRect::at(0, 0, 256, 256), 4);
    let mut out = Block::new(Bands::Colour, 256, 256);
    let job = Job {
        grid: &fine,
        cancel: &Cancel::default(),
    };
    none.render(&job, &[&input], &mut out).expect("no errors");
    assert_eq!(out, input);
}

#[test]
fn samples_are_synthesised_below_the_spacing_that_is_said() {
    let said_m = ColourDetail::new(Planet::EARTH, &by_noise(), Vec::new(), false)
        .synthesised_below_m()
        .expect("some are");
    let mut params = by_noise();
    for doublings in 0..4 {
        let level = finer(COARSE, doublings);
        let grid = TileKey::new(level, 900, 500).expect("inside").grid();
        for share in [0.7, 1.0, 1.3] {
            params.coarse_spacing_m = share * spacing_m(COARSE);
            let node = ColourDetail::new(Planet::EARTH, &params, Vec::new(), false);
            let said_m = node.synthesised_below_m().expect("some are");
            let is_synthesised = node.identity(&grid, &[Known::Complete]).is_none();
            assert_eq!(
                is_synthesised,
                spacing_m(level) <= said_m,
                "{doublings} {share}"
            );
        }
    }
    assert!((said_m / spacing_m(finer(COARSE, 1)) - 1.0).abs() < 0.02);
    params.coarse_spacing_m = 0.0;
    let node = ColourDetail::new(Planet::EARTH, &params, Vec::new(), false);
    assert_eq!(node.synthesised_below_m(), None);
}

#[test]
fn noise_knows_no_antimeridian_and_no_pole() {
    // From the other side it is the same, and across a pole as rough as beside it.
    let around = COARSE.samples().x;
    let rect = SampleRect::at(-16, 480_000, 32, 24);
    let scene = Scene::new(rect.grow(80), varied(rect.grow(80), 4), &[], &by_noise());
    let fine = scene.detailed(rect, 3);
    assert_eq!(
        scene.detailed(SampleRect::at(around - 16, 480_000, 32, 24), 3),
        fine
    );

    // Imagery that is the same on both sides of the pole, one on each meridian and its opposite.
    let mut b = GraphBuilder::default();
    let ground = crate::nodes::NoiseParams {
        seed: 1,
        amplitude_m: 0.4,
        wavelength_m: 4.0 * spacing_m(COARSE),
        octaves: 1,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: false,
    };
    let heights = b.add(
        Arc::new(crate::nodes::Noise::new(Planet::EARTH, &ground)),
        &[],
    );
    let stops = [(-0.5, [0.2, 0.2, 0.2, 1.0]), (0.5, [0.7, 0.6, 0.5, 1.0])]
        .map(|(height_m, rgba)| crate::nodes::Stop { height_m, rgba });
    let tint = crate::nodes::Tint::new(&stops, true).expect("stops that rise");
    let input = b.add(Arc::new(tint), &[heights]);
    let node = ColourDetail::new(Planet::EARTH, &by_noise(), Vec::new(), false);
    let output = b.add(Arc::new(node), &[input]);
    let graph = b.build();
    let level = finer(COARSE, 2);
    let (mut across, mut others) = (0.0, 0.0);
    for pole in [0, level.samples().y] {
        let at = |min: i64| {
            let rect = SampleRect::at(9_000_000, min, 320, 2);
            let grid = Grid::new(Arc::new(level.lattice()), rect);
            let block = graph
                .evaluate(output, &grid, &Cancel::default())
                .expect("no errors");
            let (north, south) = block.plane(1).split_at(320);
            let steps = north
                .iter()
                .zip(south)
                .map(|(n, s)| f64::from(s - n).powi(2));
            steps.sum::<f64>()
        };
        across += at(pole - 1);
        others += (1..9).map(|k| at(pole - 2 * k - 1)).sum::<f64>() / 8.0;
    }
    assert!((0.4..2.5).contains(&(across / others)), "{across} {others}");
}
