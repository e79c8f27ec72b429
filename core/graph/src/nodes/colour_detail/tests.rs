//! The constraint, names, and what is left alone.

mod noise;
mod places;

use proptest::prelude::*;
use relievo_planet::{LevelKey, Planet, TileKey};
use relievo_raster::colour::{linear_from_srgb, srgb_from_linear, to_u8};
use relievo_raster::{Cancel, SampleType};

use super::*;
use crate::nodes::{Constant, Memory};
use crate::{Artefacts, Graph, GraphBuilder, NodeIndex};

/// Around 20 m.
const COARSE: LevelKey = LevelKey { m: 13, n: 12 };

/// Metres from row to row of a level.
fn spacing_m(level: LevelKey) -> f64 {
    level.lattice().step.y * Planet::EARTH.radius_m
}

fn finer(level: LevelKey, doublings: u8) -> LevelKey {
    LevelKey::new(level.m + doublings, level.n + doublings)
}

fn noise(x: i64, y: i64, seed: u64) -> f32 {
    let h = crate::nodes::noise::scrambled((x as u64) << 32 ^ y as u64 & 0xFFFF_FFFF ^ seed << 17);
    (h >> 40) as f32 / 16_777_216.0
}

/// Opaque colours by column, row and channel.
fn colours(rect: SampleRect, value: impl Fn(i64, i64, usize) -> f32) -> Block {
    let (width, height) = (rect.width() as usize, rect.height() as usize);
    let mut block = Block::filled(Bands::Colour, width, height, &[0.0, 0.0, 0.0, 1.0]);
    for plane in 0..3 {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            let (column, row) = ((i % width) as i64, (i / width) as i64);
            *v = value(rect.min.x + column, rect.min.y + row, plane);
        }
    }
    block
}

/// Colours of which an example is read.
#[derive(Clone)]
struct Sample {
    colours: Block,
    spacing_m: f64,
}

impl Sample {
    fn at(&self) -> ExampleAt {
        let lattice = relievo_planet::Lattice {
            crs: relievo_planet::GridCrs::Map,
            origin: glam::DVec2::new(0.1, 1.2),
            step: glam::DVec2::splat(self.spacing_m / Planet::EARTH.radius_m),
            columns_around: None,
        };
        let (width, height) = (self.colours.width() as i64, self.colours.height() as i64);
        ExampleAt {
            grid: Grid::new(Arc::new(lattice), SampleRect::at(0, 0, width, height)),
            spacing_m: self.spacing_m,
        }
    }
}

fn places(samples: &[Sample]) -> Vec<ExampleAt> {
    samples.iter().map(Sample::at).collect()
}

/// The nodes that examples are read from.
fn add_samples(b: &mut GraphBuilder, samples: &[Sample]) -> Vec<NodeIndex> {
    let add = |s: &Sample| b.add(Arc::new(Memory::new(&s.at().grid, s.colours.clone())), &[]);
    samples.iter().map(add).collect()
}

/// 96 × 96 samples that are 2.5 m apart, of a mean colour and a pattern around 0.
fn sample(mean: [f32; 3], pattern: impl Fn(i64, i64) -> f32) -> Sample {
    let colours = colours(SampleRect::at(0, 0, 96, 96), |x, y, c| {
        (mean[c] * (1.0 + pattern(x, y))).clamp(0.0, 1.0)
    });
    Sample {
        colours,
        spacing_m: 2.5,
    }
}

fn rough() -> Vec<Sample> {
    let speckled = sample([0.5, 0.4, 0.3], |x, y| noise(x, y, 1) - 0.5);
    let blotched = sample([0.2, 0.4, 0.2], |x, y| 1.6 * (noise(x / 3, y / 4, 2) - 0.5));
    vec![speckled, blotched]
}

fn params() -> ColourDetailParams {
    ColourDetailParams {
        coarse_spacing_m: spacing_m(COARSE),
        tolerance: f64::INFINITY,
        ..ColourDetailParams::default()
    }
}

fn by_noise() -> ColourDetailParams {
    ColourDetailParams {
        by: ColourDetailSource::Noise,
        ..params()
    }
}

/// Imagery at the coarse level, detail over it.
struct Scene {
    graph: Graph,
    artefacts: Arc<Artefacts>,
    input: NodeIndex,
    output: NodeIndex,
}

impl Scene {
    fn new(
        rect: SampleRect,
        imagery: Block,
        samples: &[Sample],
        params: &ColourDetailParams,
    ) -> Self {
        let grid = Grid::new(Arc::new(COARSE.lattice()), rect);
        let mut b = GraphBuilder::default();
        let artefacts = Arc::default();
        b.keep_artefacts(&artefacts);
        let input = b.add(Arc::new(Memory::new(&grid, imagery)), &[]);
        let node = ColourDetail::new(Planet::EARTH, params, places(samples), false);
        let mut inputs = vec![input];
        inputs.extend(add_samples(&mut b, samples));
        let output = b.add(Arc::new(node), &inputs);
        b.cut(output, SampleType::Rgba32F);
        Self {
            graph: b.build(),
            artefacts,
            input,
            output,
        }
    }

    fn at(&self, node: NodeIndex, level: LevelKey, rect: SampleRect) -> Block {
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        self.graph
            .evaluate(node, &grid, &Cancel::default())
            .expect("no errors")
    }

    /// The detailed imagery over coarse samples.
    fn detailed(&self, coarse: SampleRect, doublings: u8) -> Block {
        let times = 1 << doublings;
        let rect = SampleRect::new(coarse.min * times, coarse.max * times);
        self.at(self.output, finer(COARSE, doublings), rect)
    }
}

/// Means of straight linear light by the box, in f64: independent of the node's own arithmetic.
fn reduced(block: &Block, times: usize) -> Vec<[f64; 3]> {
    let (width, height) = (block.width() / times, block.height() / times);
    let mut means = vec![[0.0; 3]; width * height];
    for (plane, samples) in (0..3).map(|plane| (plane, block.plane(plane))) {
        for (i, v) in samples.iter().enumerate() {
            let (x, y) = (i % block.width() / times, i / block.width() / times);
            means[y * width + x][plane] += f64::from(linear_from_srgb(*v)) / (times * times) as f64;
        }
    }
    means
}

/// The largest difference of encoded colours.
fn largest_error(fine: &Block, times: usize, coarse: &Block) -> f64 {
    let encoded = |v: f64| {
        if v <= 0.003_130_8 {
            v * 12.92
        } else {
            1.055 * libm::pow(v, 1.0 / 2.4) - 0.055
        }
    };
    let means = reduced(fine, times);
    let errors = means.iter().enumerate().flat_map(|(i, mean)| {
        (0..3).map(move |c| (encoded(mean[c]) - f64::from(coarse.plane(c)[i])).abs())
    });
    errors.fold(0.0, f64::max)
}

fn varied(rect: SampleRect, seed: u64) -> Block {
    colours(rect, |x, y, c| {
        let v = noise(x / 3, y / 2, seed + c as u64) * 0.8 + 0.2 * noise(x, y, seed ^ 9);
        if (x + y) % 17 == 0 { v.round() } else { v }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn reduced_by_the_box_the_result_is_the_coarse_imagery_at_every_level(
        x in -8..2_000_000_i64, y in prop_oneof![-6..1_000_000_i64, Just(-3), Just(1_048_570)],
        by in prop_oneof![Just(ColourDetailSource::Examples), Just(ColourDetailSource::Noise)],
        seed: u64, strength in 0.1..4.0_f64, tolerance in prop_oneof![0.05..1.0_f64, Just(f64::INFINITY)],
    ) {
        let rect = SampleRect::at(x, y, 10, 9);
        let imagery = varied(rect.grow(16), seed % 1000);
        let params = ColourDetailParams { by, seed, strength, tolerance, ..params() };
        let scene = Scene::new(rect.grow(16), imagery, &rough(), &params);
        let coarse = scene.at(scene.input, COARSE, rect);
        let mut above = coarse.clone();
        for doublings in 1..=4_u8 {
            let fine = scene.detailed(rect, doublings);
            // Far below half an 8-bit step, 2 · 10⁻³, also where an encoded value is steepest.
            let error = largest_error(&fine, 1 << doublings, &coarse);
            prop_assert!(error < 1.5e-5, "{error:e} after {doublings}");
            let error = largest_error(&fine, 2, &above);
            prop_assert!(error < 1.5e-5, "{error:e} from {doublings} to the level above");
            prop_assert!(fine.samples().iter().all(|v| (-1e-5..=1.000_01).contains(v)));
            above = fine;
        }
    }
}

#[test]
fn far_below_the_resolution_of_the_exemplars_the_constraint_still_holds() {
    let rect = SampleRect::at(1_300_000, 250_000, 3, 2);
    for params in [params(), by_noise()] {
        let scene = Scene::new(rect.grow(16), varied(rect.grow(16), 2), &rough(), &params);
        let coarse = scene.at(scene.input, COARSE, rect);
        let error = largest_error(&scene.detailed(rect, 8), 256, &coarse);
        assert!(error < 1.5e-5, "{error:e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn a_piece_made_alone_is_part_of_the_whole(
        x in 0..320_i64, y in 0..320_i64, width in 1..120_i64, height in 1..120_i64, doublings in 1..6_u8,
        noisy: bool,
    ) {
        // Across squares in which coarse colours are read, so that pieces read other ones.
        let rect = SampleRect::at(640_000 - 20, 320_000 - 20, 40, 40);
        let held = rect.grow(120);
        let params = if noisy { by_noise() } else { params() };
        let scene = Scene::new(held, varied(held, 7), &rough(), &params);
        let level = finer(COARSE, doublings);
        let centre = (rect.min + 20) * (1 << doublings);
        let whole = SampleRect::new(centre - 220, centre + 220);
        let piece = SampleRect::at(whole.min.x + x, whole.min.y + y, width, height);
        let alone = scene.at(scene.output, level, piece);
        let mut part = Block::new(Bands::Colour, width as usize, height as usize);
        let size = (width as usize, height as usize);
        part.copy_from(&scene.at(scene.output, level, whole), (x as usize, y as usize), (0, 0), size);
        prop_assert!(alone == part);
    }
}

#[test]
fn everything_that_decides_is_part_of_the_name() {
    let grid = TileKey::new(finer(COARSE, 2), 9000, 5000)
        .expect("inside")
        .grid();
    let name = |planet: Planet, params: ColourDetailParams, examples, masked| {
        let mut id = IdHasher::default();
        ColourDetail::new(planet, &params, examples, masked).identify(&grid, &mut id);
        id.finish()
    };
    let all = places(&rough());
    let with = |change: fn(&mut ColourDetailParams)| {
        let mut params = params();
        change(&mut params);
        name(Planet::EARTH, params, all.clone(), false)
    };
    let mut moved = all.clone();
    moved[1].grid.rect = moved[1].grid.rect.grow(1);
    let mut sparser = all.clone();
    sparser[0].spacing_m = 2.6;
    let mut late = all.clone();
    late[0].spacing_m = 0.0;
    let names = [
        with(|_| {}),
        with(|p| p.seed = 1),
        with(|p| p.strength = 0.5),
        with(|p| p.tolerance = 0.2),
        with(|p| p.coarse_spacing_m *= 3.0),
        with(|p| p.by = ColourDetailSource::Noise),
        name(Planet::EARTH, params(), all.clone(), true),
        name(Planet::MARS, params(), all.clone(), false),
        name(Planet::EARTH, params(), moved, false),
        name(Planet::EARTH, params(), sparser, false),
        name(Planet::EARTH, params(), late, false),
        name(Planet::EARTH, params(), vec![all[1].clone()], false),
    ];
    let distinct: std::collections::BTreeSet<_> = names.iter().collect();
    assert_eq!(distinct.len(), names.len());
    // What no number can mean counts as what it is clamped to.
    assert_eq!(
        with(|p| p.strength = 1e9),
        with(|p| p.strength = MOST_STRENGTH)
    );
    assert_eq!(
        with(|p| p.tolerance = f64::NAN),
        with(|p| p.tolerance = -1.0)
    );
}

#[test]
fn what_8_bit_tiles_reduce_to_is_off_by_no_more_than_half_a_step() {
    let rect = SampleRect::at(700_000, 400_000, 24, 24);
    let scene = Scene::new(rect.grow(16), varied(rect.grow(16), 3), &rough(), &params());
    let coarse = scene.at(scene.input, COARSE, rect);
    let mut fine = scene.detailed(rect, 3);
    for v in fine.samples_mut() {
        *v = f32::from(to_u8(*v)) / 255.0;
    }
    let error = largest_error(&fine, 8, &coarse);
    assert!(error <= 0.5 / 255.0, "{error}");
}

#[test]
fn without_strength_or_exemplars_or_on_coarse_levels_it_is_not_there_at_all() {
    let mut varied_params = params();
    varied_params.strength = 0.0;
    let fine = TileKey::new(finer(COARSE, 2), 9000, 5000).expect("inside");
    let same_level = TileKey::new(COARSE, 3000, 1200).expect("inside");
    let known = [Known::Complete];
    for (node, grid) in [
        (
            ColourDetail::new(Planet::EARTH, &varied_params, places(&rough()), false),
            fine.grid(),
        ),
        (
            ColourDetail::new(Planet::EARTH, &params(), Vec::new(), false),
            fine.grid(),
        ),
        (
            ColourDetail::new(Planet::EARTH, &params(), places(&rough()), false),
            same_level.grid(),
        ),
    ] {
        assert_eq!(node.identity(&grid, &known), Some(0));
        assert!(node.artefacts(&grid).is_empty());
        let input = varied(SampleRect::at(0, 0, 256, 256), 4);
        let mut out = Block::new(Bands::Colour, 256, 256);
        let job = Job {
            grid: &grid,
            cancel: &Cancel::default(),
        };
        node.render(&job, &[&input], &mut out).expect("no errors");
        assert_eq!(out, input);
    }
    let node = ColourDetail::new(Planet::EARTH, &params(), places(&rough()), false);
    assert_eq!(node.identity(&fine.grid(), &known), None);
    assert_eq!(node.known(&fine.grid(), &known), Known::Complete);
}

#[test]
fn what_is_transparent_stays_and_lends_nothing_to_its_neighbours() {
    let rect = SampleRect::at(500, 700_000, 40, 40);
    let mut imagery = varied(rect, 5);
    let hole = |x: i64, y: i64| (12..20).contains(&x) && (10..30).contains(&y);
    for plane in 0..4 {
        for (i, v) in imagery.plane_mut(plane).iter_mut().enumerate() {
            if hole(i as i64 % 40, i as i64 / 40) {
                *v = 0.0;
            }
        }
    }
    let inner = SampleRect::at(504, 700_004, 30, 30);
    let scene = Scene::new(rect, imagery, &rough(), &params());
    let fine = scene.detailed(inner, 2);
    let coarse = scene.at(scene.input, COARSE, inner);
    for (i, alpha) in fine.plane(3).iter().enumerate() {
        let (x, y) = ((i % 120 / 4) as i64 + 4, (i / 120 / 4) as i64 + 4);
        assert_eq!(*alpha, if hole(x, y) { 0.0 } else { 1.0 });
        assert!(!hole(x, y) || (0..3).all(|c| fine.plane(c)[i] == 0.0));
    }
    // Next to the hole the constraint holds too.
    assert!(largest_error(&fine, 4, &coarse) < 1.5e-5);
}

#[test]
fn exemplars_of_any_size_and_spacing_can_be_given_together() {
    let rect = SampleRect::at(900_000, 700_000, 6, 6);
    let imagery = varied(rect.grow(16), 1);
    let of = |side: i64, spacing_m: f64| {
        let colours = varied(SampleRect::at(0, 0, side, side), side as u64);
        Sample { colours, spacing_m }
    };
    let scene = |samples: &[Sample]| Scene::new(rect.grow(16), imagery.clone(), samples, &params());
    for samples in [
        vec![of(8, 0.001), of(200, 9.0)],
        vec![of(8, 3.0), of(300, 0.5), of(16, 1e8)],
        vec![of(64, 4.0)],
        vec![of(8, 0.3)],
    ] {
        let scene = scene(&samples);
        for doublings in [1, 3, 6] {
            let coarse = scene.at(scene.input, COARSE, rect);
            let fine = scene.detailed(rect, doublings);
            assert!(largest_error(&fine, 1 << doublings, &coarse) < 1.5e-5);
        }
    }
    // What is coarser than the imagery is as good as nothing, as is what is transparent, too large or too
    // small; one beside it is not disturbed.
    let transparent = Sample {
        colours: Block::new(Bands::Colour, 30, 30),
        spacing_m: 2.0,
    };
    let fine = scene(&[of(64, 4.0)]).detailed(rect, 3);
    for nothing in [of(300, 20.0), of(7, 2.0), of(64, -1.0), transparent] {
        let alone = scene(std::slice::from_ref(&nothing));
        let level = finer(COARSE, 3);
        let whole = SampleRect::new(rect.min * 8, rect.max * 8);
        assert_eq!(
            alone.at(alone.output, level, whole),
            alone.at(alone.input, level, whole)
        );
        assert_eq!(fine, scene(&[nothing, of(64, 4.0)]).detailed(rect, 3));
    }
}

#[test]
fn examples_are_read_when_the_first_tile_needs_them_and_once() {
    let rect = SampleRect::at(900_000, 700_000, 6, 6);
    let scene = Scene::new(rect.grow(16), varied(rect.grow(16), 1), &rough(), &params());
    let key = TileKey::new(finer(COARSE, 2), 9000, 5000).expect("inside");
    scene.graph.content_id(scene.output, key);
    assert_eq!(scene.artefacts.made(), 0);
    scene.detailed(rect, 2);
    // The coarse colours and two examples.
    assert_eq!(scene.artefacts.made(), 3);
    scene.detailed(rect, 3);
    assert_eq!(scene.artefacts.made(), 3);
}

#[test]
fn work_that_nobody_wants_stops() {
    let rect = SampleRect::at(900_000, 700_000, 6, 6);
    let scene = Scene::new(rect.grow(16), varied(rect.grow(16), 1), &rough(), &params());
    let cancel = Cancel::default();
    cancel.cancel();
    let level = finer(COARSE, 2);
    let fine = Grid::new(
        Arc::new(level.lattice()),
        SampleRect::new(rect.min * 4, rect.max * 4),
    );
    let stopped = scene.graph.evaluate(scene.output, &fine, &cancel);
    assert!(matches!(stopped, Err(RenderError::Cancelled)));
    // Without what it asks for there is an error and no picture.
    let node = ColourDetail::new(Planet::EARTH, &params(), places(&rough()), false);
    let (input, mut out) = (varied(fine.rect, 1), Block::new(Bands::Colour, 24, 24));
    for cancel in [Cancel::default(), cancel] {
        let job = Job {
            grid: &fine,
            cancel: &cancel,
        };
        let coarse = node.artefacts(&fine)[0].reads()[0].1.rect;
        let all = node.artefacts(&fine);
        let made = |at: usize, samples: Block| {
            let made = all[at].make(&[samples], &Cancel::default());
            made.expect("no errors")
        };
        let made = [
            made(0, varied(coarse, 1)),
            made(1, rough()[0].colours.clone()),
        ];
        let stopped = node.render_from(&job, &made, &[&input], &mut out);
        assert_eq!(stopped.is_err(), cancel.is_cancelled());
        assert!(matches!(
            node.render(&job, &[&input], &mut out),
            Err(RenderError::Node { .. })
        ));
    }
}

#[test]
fn on_a_projected_grid_the_constraint_holds_too() {
    let crs = relievo_planet::GridCrs::Projected("EPSG:26912".into());
    let lattice = relievo_planet::Lattice {
        crs,
        origin: glam::DVec2::new(444_848.0, 4_449_195.0),
        step: glam::DVec2::new(2.0, -2.0),
        columns_around: None,
    };
    let coarse = relievo_planet::Lattice {
        step: lattice.step * 8.0,
        ..lattice.clone()
    };
    let rect = SampleRect::at(10, 10, 12, 12);
    let held = Grid::new(Arc::new(coarse), rect.grow(16));
    let imagery = varied(held.rect, 6);
    let mut b = GraphBuilder::default();
    let input = b.add(Arc::new(Memory::new(&held, imagery)), &[]);
    let mut params = params();
    params.coarse_spacing_m = 16.0;
    let node = ColourDetail::new(Planet::EARTH, &params, places(&rough()), false);
    let mut inputs = vec![input];
    inputs.extend(add_samples(&mut b, &rough()));
    let output = b.add(Arc::new(node), &inputs);
    let graph = b.build();
    let evaluate = |node, grid: &Grid| {
        let samples = graph.evaluate(node, grid, &Cancel::default());
        samples.expect("no errors")
    };
    let fine = Grid::new(
        Arc::new(lattice),
        SampleRect::new(rect.min * 8, rect.max * 8),
    );
    let detailed = evaluate(output, &fine);
    let coarse = evaluate(input, &held.with_rect(rect));
    assert_ne!(detailed, evaluate(input, &fine));
    assert!(largest_error(&detailed, 8, &coarse) < 1.5e-5);
}
