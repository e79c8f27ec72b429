//! Where there is what detail, and where none.

use relievo_raster::reduce::halve;

use super::*;

/// Mean square of differences from sample to sample, eastward and southward.
fn roughness(block: &Block, columns: core::ops::Range<usize>) -> [f64; 2] {
    let (width, plane) = (block.width(), block.plane(1));
    let mut sums = [0.0; 2];
    for y in 0..block.height() - 1 {
        for x in columns.clone() {
            let at = y * width + x;
            sums[0] += f64::from(plane[at + 1] - plane[at]).powi(2);
            sums[1] += f64::from(plane[at + width] - plane[at]).powi(2);
        }
    }
    sums.map(|sum| sum / (columns.len() * (block.height() - 1)) as f64)
}

#[test]
fn every_colour_gets_the_pattern_of_the_exemplar_that_is_most_like_it() {
    // Forest in rows from west to east, soil in rows from north to south.
    let stripe = |at: i64| if at % 4 < 2 { 0.4 } else { -0.4 };
    let (forest, soil) = ([0.15, 0.35, 0.15], [0.6, 0.5, 0.4]);
    let samples = [
        sample(forest, move |_, y| stripe(y)),
        sample(soil, move |x, _| stripe(x)),
    ];
    let rect = SampleRect::at(600_000, 500_000, 40, 20);
    let imagery = colours(
        rect.grow(16),
        |x, _, c| {
            if x < 600_020 { forest[c] } else { soil[c] }
        },
    );
    let mut params = params();
    params.tolerance = 0.1;
    let scene = Scene::new(rect.grow(16), imagery, &samples, &params);
    let fine = scene.detailed(rect, 3);
    let west = roughness(&fine, 8..120);
    assert!(west[1] > 20.0 * west[0] && west[1] > 1e-3, "{west:?}");
    let east = roughness(&fine, 200..310);
    assert!(east[0] > 20.0 * east[1] && east[0] > 1e-3, "{east:?}");

    // Water is like neither.
    let water = colours(rect.grow(16), |_, _, c| [0.1, 0.2, 0.5][c]);
    let scene = Scene::new(rect.grow(16), water, &samples, &params);
    let fine = scene.detailed(rect, 3);
    for (c, expected) in [0.1, 0.2, 0.5].into_iter().enumerate() {
        assert!(fine.plane(c).iter().all(|v| (v - expected).abs() < 1e-5));
    }
    // Unless the nearest is good enough.
    params.tolerance = f64::INFINITY;
    let water = colours(rect.grow(16), |_, _, c| [0.1, 0.2, 0.5][c]);
    let scene = Scene::new(rect.grow(16), water, &samples, &params);
    let near = roughness(&scene.detailed(rect, 3), 8..310);
    assert!(near[0] + near[1] > 1e-3, "{near:?}");
}

#[test]
fn borders_of_coarse_samples_do_not_show_in_a_smooth_scene() {
    let rect = SampleRect::at(300_000, 600_000, 32, 32);
    let wave = |at: i64| libm::sin(at as f64 * 0.35) as f32;
    let imagery = colours(rect.grow(16), |x, y, c| {
        0.5 + 0.1 * wave(x + 3 * c as i64) + 0.1 * wave(y)
    });
    // With the noise of an exemplar without order, with one that has nothing to add, and by noise.
    let flat = sample([0.5; 3], |_, _| 0.0);
    // Noise on imagery as smooth as this, of which the kinks at borders are most of what there is, is the worst.
    for (samples, params, most) in [
        (rough(), params(), 1.15),
        (vec![flat], params(), 1.15),
        (Vec::new(), by_noise(), 1.25),
    ] {
        let scene = Scene::new(rect.grow(16), imagery.clone(), &samples, &params);
        for doublings in [2, 3, 4_u8] {
            let times = 1 << doublings;
            let fine = scene.detailed(rect, doublings);
            let (mut at_border, mut inside) = ([0.0, 0.0], [0.0, 0.0]);
            // Among steps from one sample of the level above to the next.
            let steps = (0..fine.plane(0).len()).step_by(2);
            for i in steps.filter(|i| i % fine.width() > 0) {
                let step = f64::from(fine.plane(0)[i] - fine.plane(0)[i - 1]).abs();
                let sums = if i % times == 0 {
                    &mut at_border
                } else {
                    &mut inside
                };
                *sums = [sums[0] + step, sums[1] + 1.0];
            }
            let (at_border, inside) = (at_border[0] / at_border[1], inside[0] / inside[1]);
            assert!(
                at_border < most * inside,
                "{at_border} {inside}, {doublings}"
            );
        }
    }
}

/// So large that chance cannot name all of its places, and so smooth that patches which do not fit would
/// show.
fn waves() -> Vec<Sample> {
    let wave = |at: i64| libm::sin(at as f64 * 0.3) as f32;
    let colours = colours(SampleRect::at(0, 0, 400, 400), |x, y, _| {
        0.4 + 0.2 * wave(x) * wave(y)
    });
    vec![Sample {
        colours,
        spacing_m: 2.5,
    }]
}

/// Sums of squares of second differences across a line before column (or row) `at`, which jump where a
/// smooth picture does, and their mean over all others.
fn bends(block: &Block, at: usize, along: usize) -> [f64; 2] {
    let (plane, width) = (block.plane(0), block.width());
    let (sides, strides) = ([width, block.height()], [1, width]);
    let (side, stride, other) = (sides[along], strides[along], strides[1 - along]);
    let bend = |i: usize| {
        let bends = (0..sides[1 - along]).map(|k| {
            let at = i * stride + k * other;
            f64::from(plane[at + stride] - 2.0 * plane[at] + plane[at - stride]).powi(2)
        });
        bends.sum::<f64>()
    };
    let others = (1..at - 2).chain(at + 2..side - 1);
    let count = others.clone().count() as f64;
    [
        0.5 * (bend(at - 1) + bend(at)),
        others.map(bend).sum::<f64>() / count,
    ]
}

#[test]
fn there_is_no_seam_at_the_antimeridian() {
    let around = COARSE.samples().x;
    let rect = SampleRect::at(-16, 480_000, 32, 24);
    let imagery = colours(rect.grow(16), |x, y, c| {
        0.4 + 0.004 * (x + y - 480_000) as f32 * (c as f32 - 1.0)
    });
    let scene = Scene::new(rect.grow(16), imagery, &waves(), &params());
    let fine = scene.detailed(rect, 3);
    let [seam, others] = bends(&fine, 128, 0);
    assert!(seam < 4.0 * others, "{seam} {others}");
    // Patches that do not fit make it 25 times as large. And it is the same from the other side.
    let other = scene.detailed(SampleRect::at(around - 16, 480_000, 32, 24), 3);
    assert_eq!(other, fine);
}

#[test]
fn there_is_no_seam_over_a_pole() {
    let mut b = GraphBuilder::default();
    let grey = b.add(Arc::new(Constant::colour([0.4, 0.4, 0.4, 1.0])), &[]);
    let node = ColourDetail::new(Planet::EARTH, &params(), places(&waves()), false);
    let mut inputs = vec![grey];
    inputs.extend(add_samples(&mut b, &waves()));
    let output = b.add(Arc::new(node), &inputs);
    let graph = b.build();
    let level = finer(COARSE, 3);
    for pole in [0, level.samples().y] {
        let rect = SampleRect::at(9_000_000, pole - 96, 160, 192);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let across = graph.evaluate(output, &grid, &Cancel::default());
        let [seam, others] = bends(&across.expect("no errors"), 96, 1);
        assert!(seam < 4.0 * others && others > 1e-3, "{seam} {others}");
    }
}

#[test]
fn a_mask_says_where_detail_is() {
    let rect = SampleRect::at(200_000, 300_000, 24, 24);
    let grid = Grid::new(Arc::new(COARSE.lattice()), rect.grow(16));
    let imagery = varied(rect.grow(16), 8);
    let mask = |weight: f32| Arc::new(Constant::mask(weight));
    let with = |weight: f32| {
        let mut b = GraphBuilder::default();
        let input = b.add(Arc::new(Memory::new(&grid, imagery.clone())), &[]);
        let mask = b.add(mask(weight), &[]);
        let node = ColourDetail::new(Planet::EARTH, &params(), places(&rough()), true);
        let mut inputs = vec![input, mask];
        inputs.extend(add_samples(&mut b, &rough()));
        let output = b.add(Arc::new(node), &inputs);
        let fine = Grid::new(
            Arc::new(finer(COARSE, 2).lattice()),
            SampleRect::new(rect.min * 4, rect.max * 4),
        );
        let graph = b.build();
        let at = |node| {
            graph
                .evaluate(node, &fine, &Cancel::default())
                .expect("no errors")
        };
        (at(input), at(output))
    };
    let (input, nothing) = with(0.0);
    assert_eq!(nothing, input);
    let (_, all) = with(1.0);
    let scene = Scene::new(rect.grow(16), imagery.clone(), &rough(), &params());
    assert_eq!(all, scene.detailed(rect, 2));
    let (_, half) = with(0.5);
    for ((a, b), mixed) in input
        .samples()
        .iter()
        .zip(all.samples())
        .zip(half.samples())
    {
        let expected = 0.5 * (linear_from_srgb(*a) + linear_from_srgb(*b));
        assert!((linear_from_srgb(*mixed) - expected).abs() < 1e-5);
    }
}

#[test]
fn imagery_of_the_exemplar_itself_is_as_rough_as_the_exemplar() {
    let truth = colours(SampleRect::at(0, 0, 256, 256), |x, y, c| {
        0.3 + 0.1 * c as f32 + 0.2 * noise(x / 2, y / 2, 4) + 0.15 * noise(x / 9, y / 7, 5)
    });
    let spacing_m = spacing_m(finer(COARSE, 3));
    let own = Sample {
        colours: truth.clone(),
        spacing_m,
    };
    let mut imagery = truth.clone();
    for _ in 0..3 {
        imagery = halve(&imagery);
    }
    // On the equator, where samples are square.
    let rect = SampleRect::at(100_000, COARSE.samples().y / 2, 32, 32);
    let scene = Scene::new(rect, imagery, &[own], &params());
    let inner = rect.grow(-8);
    let fine = scene.detailed(inner, 3);
    let smooth = Scene::new(
        rect,
        scene.at(scene.input, COARSE, rect),
        &[sample([0.5; 3], |_, _| 0.0)],
        &params(),
    )
    .detailed(inner, 3);
    let wanted = roughness(&truth, 0..255).iter().sum::<f64>();
    let got = roughness(&fine, 0..127).iter().sum::<f64>();
    let without = roughness(&smooth, 0..127).iter().sum::<f64>();
    assert!((0.6..1.4).contains(&(got / wanted)), "{got} for {wanted}");
    assert!(without < 0.1 * wanted, "{without} for {wanted}");
}
