//! Seams that vanish, and what is left alone.

mod places;

use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use proptest::prelude::*;
use relievo_planet::{GridCrs, LevelKey, MapPoint, TileKey};
use relievo_raster::{Cancel, SampleType};

use super::*;
use crate::nodes::overlay::{BlendMode, Overlay};
use crate::{Graph, GraphBuilder, NodeIndex};

/// Around 5 m.
const FINE: LevelKey = LevelKey { m: 15, n: 14 };

/// A place on the equator, in columns and rows of [`FINE`].
const PLACE: glam::I64Vec2 = glam::I64Vec2::new(5_000_000, 2_097_152);

/// Colours or a mask by place and sample.
struct Painted<F> {
    bands: Bands,
    paint: F,
    /// Of all that are painted another one: a function has no name.
    number: u64,
}

fn painted<F>(bands: Bands, paint: F) -> Arc<Painted<F>> {
    static NUMBERS: AtomicU64 = AtomicU64::new(0);
    let number = NUMBERS.fetch_add(1, Ordering::Relaxed);
    Arc::new(Painted {
        bands,
        paint,
        number,
    })
}

impl<F: Fn(MapPoint, glam::I64Vec2) -> [f32; 4] + Send + Sync> ImageNode for Painted<F> {
    fn kind(&self) -> &'static str {
        "painted"
    }

    fn output(&self) -> Bands {
        self.bands
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.int(self.number as i64).grid(grid);
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let ground = super::super::ground::Ground::new(&job.grid.lattice, "painted")?;
        let rect = job.grid.rect;
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let sample = glam::I64Vec2::new(x, y);
                let place = ground.point(sample.as_dvec2() + 0.5).expect("a place");
                let i = ((y - rect.min.y) * rect.width() + x - rect.min.x) as usize;
                let value = (self.paint)(place, sample);
                for (plane, v) in value.into_iter().enumerate().take(self.bands.planes()) {
                    out.plane_mut(plane)[i] = v;
                }
            }
        }
        Ok(())
    }
}

fn colours(
    paint: impl Fn(MapPoint, glam::I64Vec2) -> [f32; 4] + Send + Sync + 'static,
) -> Arc<dyn ImageNode> {
    painted(Bands::Colour, paint)
}

fn masks(
    paint: impl Fn(MapPoint, glam::I64Vec2) -> f32 + Send + Sync + 'static,
) -> Arc<dyn ImageNode> {
    painted(Bands::Mask, move |place, sample| {
        [paint(place, sample), 0.0, 0.0, 0.0]
    })
}

/// A layer that blends into what is below.
struct Scene {
    graph: Graph,
    layer: NodeIndex,
    blended: NodeIndex,
}

impl Scene {
    fn new(planet: Planet, reach_m: f64, inputs: &[Arc<dyn ImageNode>]) -> Self {
        let mut b = GraphBuilder::default();
        let inputs: Vec<_> = inputs.iter().map(|n| b.add(Arc::clone(n), &[])).collect();
        let node = SeamBlend::new(planet, reach_m, inputs.len() == 3);
        let blended = b.add(Arc::new(node), &inputs);
        b.cut(blended, SampleType::Rgba32F);
        Self {
            graph: b.build(),
            layer: inputs[1],
            blended,
        }
    }

    fn at(&self, node: NodeIndex, grid: &Grid) -> Block {
        let samples = self.graph.evaluate(node, grid, &Cancel::default());
        samples.expect("no errors")
    }

    /// What is added to the first channel, by sample.
    fn added(&self, grid: &Grid) -> impl Fn(i64, i64) -> f32 + use<> {
        let (layer, blended) = (self.at(self.layer, grid), self.at(self.blended, grid));
        assert_eq!(layer.plane(3), blended.plane(3), "alpha is the layer's");
        let rect = grid.rect;
        move |x, y| {
            let i = ((y - rect.min.y) * rect.width() + x - rect.min.x) as usize;
            blended.plane(0)[i] - layer.plane(0)[i]
        }
    }
}

fn grid(level: LevelKey, rect: SampleRect) -> Grid {
    Grid::new(Arc::new(level.lattice()), rect)
}

/// Samples of [`FINE`] around [`PLACE`].
fn around(west: i64, north: i64, width: i64, height: i64) -> Grid {
    let rect = SampleRect::at(west, north, width, height).shift(PLACE);
    grid(FINE, rect)
}

/// Metres from row to row.
fn spacing_m(level: LevelKey) -> f64 {
    let planet = Planet::EARTH;
    level.lattice().step.y * planet.equatorial_radius_m * (1.0 - planet.flattening / 2.0)
}

/// Samples of [`FINE`] eastward and southward from [`PLACE`] to a place.
fn from_place(place: MapPoint) -> glam::DVec2 {
    FINE.sample_from_map(place) - PLACE.as_dvec2()
}

fn grey(v: f32) -> [f32; 4] {
    [v, v, v, 1.0]
}

/// 0 to 1, without any order.
fn noise(sample: glam::I64Vec2, seed: u64) -> f32 {
    let key = (sample.x as u64) << 32 ^ sample.y as u64 & 0xFFFF_FFFF ^ seed << 17;
    (crate::nodes::noise::scrambled(key) >> 40) as f32 / 16_777_216.0
}

/// Opaque west of [`PLACE`], of a colour.
fn west_of_place(v: f32) -> Arc<dyn ImageNode> {
    colours(move |place, _| {
        if from_place(place).x < 0.0 {
            grey(v)
        } else {
            [0.0; 4]
        }
    })
}

#[test]
fn an_offset_vanishes_at_the_seam_and_beyond_the_reach_the_layer_is_untouched() {
    // From the lattice's own samples to those of one 16 times as fine as the coarse lattice.
    for (reach, level_drop) in [(10.0, 0), (40.0, 0), (64.0, 1), (256.0, 0)] {
        let reach_m = reach * spacing_m(FINE);
        let below = colours(|_, _| grey(0.4));
        let scene = Scene::new(Planet::EARTH, reach_m, &[below, west_of_place(0.6)]);
        let times = 1 << level_drop;
        let level = LevelKey::new(FINE.m - level_drop, FINE.n - level_drop);
        let place = PLACE / times;
        let rect = SampleRect::at(-300, -4, 310, 8).shift(place);
        let added = scene.added(&grid(level, rect));
        let reach = reach as i64 / times;
        for y in -4..4 {
            let mut last = -0.2;
            for x in (-300..0).rev() {
                let v = added(place.x + x, place.y + y);
                assert!(v >= last - 1e-4, "rises inwards: {x} {v} {last}");
                last = v;
                assert!(
                    x >= -reach || v == 0.0,
                    "untouched beyond the reach: {x} {v}"
                );
            }
            let at_seam = added(place.x - 1, place.y + y);
            assert!(
                (at_seam + 0.2).abs() < 0.002 + 0.2 / (reach * reach) as f32,
                "{reach} {at_seam}"
            );
            assert_eq!(
                added(place.x, place.y + y),
                0.0,
                "where it is absent nothing is added"
            );
        }
    }
}

#[test]
fn along_a_straight_seam_what_varies_decays_as_a_membrane_does() {
    // A wave along the seam of 1024 samples, 8 of the coarse lattice: exp(−2 π h / 1024) at h samples
    // inside, times the taper.
    let reach = 2048.0;
    let wave = |place: MapPoint| (from_place(place).y / 1024.0 * core::f64::consts::TAU).cos();
    let below = colours(move |place, _| grey(0.5 + 0.2 * wave(place) as f32));
    let scene = Scene::new(
        Planet::EARTH,
        reach * spacing_m(FINE),
        &[below, west_of_place(0.5)],
    );
    let added = scene.added(&around(-300, -1, 300, 2));
    // The seam lies in the middle of a coarse sample: the layer ends half a sample before it there.
    let coarse = 128.0;
    for h in [1.0_f64, 128.0, 256.0, 299.0] {
        let inside = (h - coarse).max(0.0);
        let t = (inside + coarse / 2.0) / (SUPPORT * reach);
        let decayed = 0.2 * (-core::f64::consts::TAU * inside / 1024.0).exp();
        let expected = decayed * (1.0 - t * t * (3.0 - 2.0 * t));
        let found = f64::from(added(PLACE.x - h as i64, PLACE.y));
        assert!((found - expected).abs() < 0.02, "{h}: {found} {expected}");
    }
}

#[test]
fn the_step_across_a_seam_is_a_small_part_of_what_it_was() {
    // Below changes smoothly, the layer has an offset, a drift and a texture of its own.
    let smooth =
        |p: glam::DVec2| (0.5 + 0.1 * (p.x / 90.0).sin() + 0.08 * (p.y / 70.0).cos()) as f32;
    let inside = |p: glam::DVec2| p.length() < 100.0 + 12.0 * (p.y / 9.0).sin();
    let below = colours(move |place, _| grey(smooth(from_place(place))));
    let layer = colours(move |place, sample| {
        let p = from_place(place);
        if !inside(p) {
            return [0.0; 4];
        }
        let drift = 0.15 + 0.05 * (p.x / 60.0).sin() as f32;
        grey(smooth(p) + drift + 0.06 * (noise(sample, 1) - 0.5))
    });
    let reach_m = 64.0 * spacing_m(FINE);
    let scene = Scene::new(Planet::EARTH, reach_m, &[below, layer]);
    let grid = around(-130, -130, 260, 260);
    let step = |node| {
        let colours = scene.at(node, &grid);
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..260 * 260 - 1 {
            let at = |i: usize| (colours.plane(3)[i], f64::from(colours.plane(0)[i]));
            let ((alpha, v), (next, w)) = (at(i), at(i + 1));
            if alpha != next {
                let (x, y) = ((i % 260) as f64 - 129.5, (i / 260) as f64 - 129.5);
                let there = f64::from(smooth(glam::DVec2::new(x, y)));
                sum += (if alpha > 0.0 { v } else { w }) - there;
                count += 1.0;
            }
        }
        f64::abs(sum / count)
    };
    let (before, after) = (step(scene.layer), step(scene.blended));
    assert!(before > 0.14 && after < 0.05 * before, "{before} {after}");
}

#[test]
fn texture_finer_than_the_coarse_lattice_survives() {
    let below = colours(|place, _| grey(0.3 + 0.1 * (from_place(place).y / 80.0).sin() as f32));
    let layer = colours(|place, sample| {
        let opaque = from_place(place).x < 0.0;
        let v = 0.6 + 0.3 * (noise(sample, 3) - 0.5);
        if opaque { grey(v) } else { [0.0; 4] }
    });
    let scene = Scene::new(Planet::EARTH, 256.0 * spacing_m(FINE), &[below, layer]);
    let added = scene.added(&around(-256, 0, 256, 64));
    for y in PLACE.y..PLACE.y + 63 {
        for x in PLACE.x - 256..PLACE.x - 1 {
            // Steps of the texture are up to 0.3.
            let steps = [added(x + 1, y) - added(x, y), added(x, y + 1) - added(x, y)];
            assert!(steps.iter().all(|step| step.abs() < 0.03), "{steps:?}");
        }
    }
}

#[test]
fn a_hole_and_an_island_of_one_sample_blend_too() {
    let below = colours(|_, _| grey(0.2));
    let layer = colours(|place, _| {
        let p = from_place(place).floor();
        let hole = p.x.abs() < 3.0 && p.y.abs() < 3.0;
        let island = p == glam::DVec2::new(60.0, 60.0);
        let opaque = (p.abs().max_element() < 50.0 && !hole) || island;
        if opaque { grey(0.5) } else { [0.0; 4] }
    });
    let scene = Scene::new(Planet::EARTH, 16.0 * spacing_m(FINE), &[below, layer]);
    let added = scene.added(&around(-64, -64, 128, 128));
    let added = |x: i64, y: i64| added(PLACE.x + x, PLACE.y + y);
    for (x, y) in [(-3, 0), (3, 2), (0, 3), (-49, 20), (49, 49), (60, 60)] {
        assert!(
            (added(x, y) + 0.3).abs() < 0.004,
            "{x} {y}: {}",
            added(x, y)
        );
    }
    assert_eq!(added(25, 0), 0.0);
    assert_eq!(added(0, 0), 0.0);
}

#[test]
fn where_nothing_is_below_there_is_no_seam() {
    // Something below the northern half of the edge only.
    let below = colours(|place, _| {
        let there = from_place(place).y < 0.0;
        if there {
            grey(0.2)
        } else {
            [0.9, 0.9, 0.9, 0.4]
        }
    });
    let scene = Scene::new(
        Planet::EARTH,
        16.0 * spacing_m(FINE),
        &[below, west_of_place(0.5)],
    );
    let added = scene.added(&around(-8, -40, 8, 80));
    assert!((added(PLACE.x - 1, PLACE.y - 20) + 0.3).abs() < 0.004);
    assert_eq!(added(PLACE.x - 1, PLACE.y + 20), 0.0);
}

#[test]
fn a_mask_moves_the_seam_and_what_it_hides_is_untouched() {
    // Rising from 0 to 1 within 40 samples.
    let mask = masks(|place, _| (0.5 - from_place(place).x / 40.0).clamp(0.0, 1.0) as f32);
    let below = colours(|_, _| grey(0.2));
    let layer = colours(|_, _| grey(0.5));
    let scene = Scene::new(Planet::EARTH, 64.0 * spacing_m(FINE), &[below, layer, mask]);
    let added = scene.added(&around(-80, 0, 160, 1));
    let added = |x: i64| added(PLACE.x + x, PLACE.y);
    assert!((added(-1) + 0.3).abs() < 0.01 && (added(0) + 0.3).abs() < 0.01);
    assert!(
        added(10) < -0.2,
        "where it fades it has met what is below: {}",
        added(10)
    );
    assert_eq!(added(20), 0.0);
    assert_eq!(added(-64), 0.0);
}

#[test]
fn nothing_comes_from_samples_that_are_no_number() {
    let odd = |sample: glam::I64Vec2| noise(sample, 5) < 0.1;
    let with = move |nan: f32| {
        let below = colours(move |_, sample| {
            let v = if noise(sample, 6) < 0.1 { nan } else { 0.2 };
            [0.2, v, 0.2, 1.0]
        });
        let layer = colours(move |place, sample| {
            let v = if odd(sample) { nan } else { 0.5 };
            let alpha = if from_place(place).x < 0.0 { 1.0 } else { 0.0 };
            [0.5, 0.5, v, alpha]
        });
        let mask = masks(move |_, sample| if noise(sample, 7) < 0.1 { nan } else { 1.0 });
        Scene::new(Planet::EARTH, 16.0 * spacing_m(FINE), &[below, layer, mask])
    };
    for nan in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let scene = with(nan);
        let grid = around(-20, 0, 20, 60);
        let (layer, blended) = (scene.at(scene.layer, &grid), scene.at(scene.blended, &grid));
        for (a, b) in layer.samples().iter().zip(blended.samples()) {
            assert!(!a.is_finite() || b.is_finite());
            assert!(a.is_finite() || (a.is_nan() && b.is_nan()) || a == b);
        }
        let changed = layer.plane(0).iter().zip(blended.plane(0));
        assert!(changed.filter(|(a, b)| a != b).count() > 200);
    }
}

#[test]
fn values_beyond_white_stay_and_none_are_made() {
    let below = colours(|_, _| [1.0, 0.0, 0.6, 1.0]);
    let layer = colours(|place, _| {
        let alpha = if from_place(place).x < 0.0 { 1.0 } else { 0.0 };
        // The first channel rises beyond white away from the seam, where differences are 0.3 still.
        let v = if from_place(place).x < -2.0 { 4.0 } else { 0.7 };
        [v, if v > 1.0 { -0.5 } else { 0.3 }, 0.5, alpha]
    });
    let scene = Scene::new(Planet::EARTH, 16.0 * spacing_m(FINE), &[below, layer]);
    let grid = around(-10, 0, 10, 1);
    let blended = scene.at(scene.blended, &grid);
    for x in 0..8 {
        assert_eq!(blended.plane(0)[x], 4.0);
        assert_eq!(blended.plane(1)[x], -0.5);
    }
    assert!(
        blended.plane(0)[8..]
            .iter()
            .all(|v| (0.95..=1.0).contains(v))
    );
    assert!(
        blended.plane(1)[8..]
            .iter()
            .all(|v| (0.0..=0.05).contains(v))
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_piece_made_alone_is_part_of_the_whole(
        x in 0..320_i64, y in 0..320_i64, width in 1..120_i64, height in 1..120_i64,
        reach in prop_oneof![2.0..30.0_f64, 30.0..600.0_f64],
    ) {
        let below = colours(|_, sample| grey(noise(sample / 9, 1)));
        let layer = colours(|_, sample| {
            let alpha = if noise(sample.div_euclid(glam::I64Vec2::splat(37)), 2) < 0.6 { 1.0 } else { 0.0 };
            [noise(sample, 3), noise(sample, 4), 0.3, alpha]
        });
        let scene = Scene::new(Planet::EARTH, reach * spacing_m(FINE), &[below, layer]);
        let whole = around(-220, -220, 440, 440);
        let piece = SampleRect::at(x, y, width, height).shift(whole.rect.min);
        let alone = scene.at(scene.blended, &whole.with_rect(piece));
        let mut part = Block::new(Bands::Colour, width as usize, height as usize);
        let all = scene.at(scene.blended, &whole);
        part.copy_from(&all, (x as usize, y as usize), (0, 0), (width as usize, height as usize));
        prop_assert!(alone == part);
    }
}

#[test]
fn without_a_reach_or_where_the_layer_is_absent_it_is_not_there_at_all() {
    let tile = TileKey::new(FINE, 9000, 5000).expect("inside").grid();
    let node = |reach_m: f64| SeamBlend::new(Planet::EARTH, reach_m, true);
    let known = [Known::Nothing, Known::Complete, Known::Complete];
    for reach_m in [
        0.0,
        -5.0,
        f64::NAN,
        f64::NEG_INFINITY,
        0.9 * spacing_m(FINE),
    ] {
        assert_eq!(node(reach_m).identity(&tile, &known), Some(1), "{reach_m}");
        assert!(node(reach_m).artefacts(&tile).is_empty());
        let input = Block::filled(Bands::Colour, 256, 256, &[0.1, 0.2, 0.3, 1.0]);
        let (below, mask) = (
            Block::new(Bands::Colour, 0, 0),
            Block::new(Bands::Mask, 256, 256),
        );
        let mut out = Block::new(Bands::Colour, 256, 256);
        let job = Job {
            grid: &tile,
            cancel: &Cancel::default(),
        };
        let rendered = node(reach_m).render(&job, &[&below, &input, &mask], &mut out);
        rendered.expect("no errors");
        assert_eq!(out, input);
    }
    for reach_m in [100.0, 1e5, f64::INFINITY] {
        let node = node(reach_m);
        assert_eq!(node.identity(&tile, &known), None, "{reach_m}");
        assert_eq!(node.known(&tile, &known), Known::Complete);
        let absent = Known::Uniform([0.0; 4]);
        assert_eq!(node.identity(&tile, &[known[0], absent, known[2]]), Some(1));
        assert_eq!(node.identity(&tile, &[known[0], known[1], absent]), Some(1));
        assert_eq!(node.known(&tile, &[Known::Nothing; 3]), Known::Nothing);
    }
}

#[test]
fn everything_that_decides_is_part_of_the_name() {
    let tile = TileKey::new(FINE, 9000, 5000).expect("inside").grid();
    let name = |planet: Planet, reach_m: f64, masked: bool| {
        let mut id = IdHasher::default();
        let node = SeamBlend::new(planet, reach_m, masked);
        node.identify(&tile, &mut id);
        for artefact in node.artefacts(&tile) {
            artefact.identify(&mut id);
        }
        id.finish()
    };
    let names = [
        name(Planet::EARTH, 100.0, false),
        name(Planet::EARTH, 101.0, false),
        name(Planet::EARTH, 100.0, true),
        name(Planet::MARS, 100.0, false),
    ];
    let distinct: std::collections::BTreeSet<_> = names.iter().collect();
    assert_eq!(distinct.len(), names.len());
    let (none, nan) = (
        name(Planet::EARTH, 0.0, false),
        name(Planet::EARTH, f64::NAN, false),
    );
    assert_eq!(none, nan);
}

#[test]
fn a_change_of_what_is_below_far_along_the_reach_renames_a_tile() {
    let tile = TileKey::new(FINE, PLACE.x / 256, PLACE.y / 256).expect("inside");
    let top = west_of_place(0.5);
    let id = |value: f32| {
        let mut b = GraphBuilder::default();
        let held = around(-40, 0, 30, 30);
        let patch = Block::filled(Bands::Colour, 30, 30, &grey(value));
        let below = b.add(Arc::new(crate::nodes::Memory::new(&held, patch)), &[]);
        let layer = b.add(Arc::clone(&top), &[]);
        let node = SeamBlend::new(Planet::EARTH, 64.0 * spacing_m(FINE), false);
        let blended = b.add(Arc::new(node), &[below, layer]);
        b.cut(blended, SampleType::Rgba8);
        b.build().content_id(blended, tile)
    };
    assert_ne!(id(0.2), id(0.3));
    assert_eq!(id(0.2), id(0.2));
}

#[test]
fn below_layers_over_layers_every_sample_is_made_once() {
    static MADE: AtomicUsize = AtomicUsize::new(0);
    let mut b = GraphBuilder::default();
    let ground = colours(|_, _| {
        MADE.fetch_add(1, Ordering::Relaxed);
        grey(0.2)
    });
    let mut base = b.add(ground, &[]);
    for v in [0.3, 0.4, 0.5, 0.6, 0.7] {
        let layer = b.add(west_of_place(v), &[]);
        let node = SeamBlend::new(Planet::EARTH, 16.0 * spacing_m(FINE), false);
        let met = b.add(Arc::new(node), &[base, layer]);
        let over = Overlay::new(BlendMode::Normal, 1.0, false);
        base = b.add(Arc::new(over), &[base, met]);
    }
    let graph = b.build();
    let evaluate = |grid: &Grid| {
        let made = graph.evaluate(base, grid, &Cancel::default());
        made.expect("no errors")
    };
    let made = evaluate(&around(-20, 0, 24, 2));
    assert!((made.plane(0)[0] - 0.7).abs() < 1e-6 && made.plane(0)[23] == 0.2);
    assert!(
        (made.plane(0)[19] - 0.2).abs() < 0.02,
        "{}",
        made.plane(0)[19]
    );
    // Artefacts are there by now.
    MADE.store(0, Ordering::Relaxed);
    evaluate(&around(-3, 0, 7, 2));
    assert_eq!(MADE.load(Ordering::Relaxed), 14);
}

#[test]
fn work_that_nobody_wants_stops() {
    let below = colours(|_, _| grey(0.2));
    let scene = Scene::new(
        Planet::EARTH,
        64.0 * spacing_m(FINE),
        &[below, west_of_place(0.5)],
    );
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = scene
        .graph
        .evaluate(scene.blended, &around(-4, 0, 8, 2), &cancel);
    assert!(matches!(stopped, Err(RenderError::Cancelled)));
}
