//! Laws that hold for every node, and for graphs of them.
//!
//! A new node is added to [`registry()`]; nothing else is needed.

#[path = "../common/flat.rs"]
mod flat;
mod registry;

use std::collections::BTreeMap;
use std::sync::Arc;

use proptest::prelude::*;
use relievo_graph::nodes::{
    AddHeights, BlendMode, Constant, DetailMethod, Memory, Noise, Normals, Overlay, OverlayHeights,
};
use relievo_graph::{ContentId, Graph, GraphBuilder, IdHasher, ImageNode as _, Job, NodeIndex};
use relievo_planet::{Grid, LevelKey, Planet, SampleRect, TileKey};
use relievo_raster::{Bands, Block, Cancel, SampleType, Tile};
use relievo_vector::style::Length;

use crate::registry::{
    Entry, adjust, colour_detail, colour_noise, detail, memory, noise_params, registry, seam_blend,
    tint, vector,
};

/// Valid samples of every kind, holes among them, from a place's hash.
fn sample(bands: Bands, hash: u64) -> [f32; 4] {
    let part = |k: u32| ((hash >> (16 * k)) & 0xFFFF) as f32 / 65_535.0;
    match (bands, hash % 5) {
        (Bands::Height, 0) => [f32::NAN, 0.0, 0.0, 0.0],
        (Bands::Height, _) => [part(1) * 3000.0 - 800.0, 0.0, 0.0, 0.0],
        (Bands::Colour | Bands::Mask, 0) => [0.0; 4],
        (Bands::Colour, 1 | 2) => [part(1), part(2), part(3), 1.0],
        (Bands::Colour, _) => [part(1), part(2), part(3), part(0).max(0.01)],
        (Bands::Mask, 1) => [1.0, 0.0, 0.0, 0.0],
        (Bands::Mask, _) => [part(1), 0.0, 0.0, 0.0],
        (Bands::Normal, _) => [part(1) * 0.5, part(2) * 0.5, 0.0, 0.0],
    }
}

fn hash(x: i64, y: i64, seed: u64) -> u64 {
    let mut h = seed
        ^ (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    h = (h ^ (h >> 31)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    h ^ (h >> 32)
}

fn fill_at(block: &mut Block, rect: SampleRect, seed: u64) {
    let width = block.width().max(1);
    for i in 0..block.width() * block.height() {
        let v = sample(
            block.bands(),
            hash(
                rect.min.x + (i % width) as i64,
                rect.min.y + (i / width) as i64,
                seed,
            ),
        );
        for (plane, v) in v.into_iter().enumerate().take(block.bands().planes()) {
            block.plane_mut(plane)[i] = v;
        }
    }
}

fn fill(block: &mut Block, seed: u64) {
    let (width, height) = (block.width() as i64, block.height() as i64);
    fill_at(block, SampleRect::at(0, 0, width, height), seed);
}

fn block(bands: Bands, rect: &SampleRect) -> Block {
    Block::new(bands, rect.width() as usize, rect.height() as usize)
}

/// Renders a rectangle of a node over samples that depend on places only.
fn render(entry: &Entry, level: LevelKey, rect: SampleRect) -> Block {
    let inputs: Vec<Block> = entry
        .inputs
        .iter()
        .enumerate()
        .map(|(k, bands)| {
            let needs = entry.node.required(k, rect);
            let mut input = block(*bands, &needs);
            fill_at(&mut input, needs, k as u64);
            input
        })
        .collect();
    let inputs: Vec<&Block> = inputs.iter().collect();
    // Garbage that a node must overwrite.
    let mut out = block(entry.node.output(), &rect);
    out.samples_mut().fill(f32::NAN);
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    render_from(entry, &grid, &inputs, &mut out, |input, grid| {
        let mut read = block(entry.inputs[input], &grid.rect);
        fill_at(&mut read, grid.rect, input as u64);
        read
    });
    out
}

/// Renders a grid of a node, with what it asks to be made before from blocks that `read` gives.
fn render_from(
    entry: &Entry,
    grid: &Grid,
    inputs: &[&Block],
    out: &mut Block,
    read: impl Fn(usize, &Grid) -> Block,
) {
    let cancel = &Cancel::default();
    let artefacts = entry.node.artefacts(grid);
    let made: Vec<_> = artefacts
        .iter()
        .map(|artefact| {
            let reads = artefact.reads();
            let samples: Vec<Block> = reads.iter().map(|(k, grid)| read(*k, grid)).collect();
            artefact.make(&samples, cancel).expect("no errors")
        })
        .collect();
    let job = Job { grid, cancel };
    let rendered = entry.node.render_from(&job, &made, inputs, out);
    rendered.expect("no errors");
}

fn bits(block: &Block) -> Vec<u32> {
    block
        .samples()
        .iter()
        .map(|v| if v.is_nan() { u32::MAX } else { v.to_bits() })
        .collect()
}

fn part(whole: &Block, from: (usize, usize), size: (usize, usize)) -> Block {
    let mut part = Block::new(whole.bands(), size.0, size.1);
    part.copy_from(whole, from, (0, 0), size);
    part
}

fn rects() -> impl Strategy<Value = SampleRect> {
    (-20..1050_i64, -20..520_i64, 1..40_i64, 1..40_i64)
        .prop_map(|(x, y, w, h)| SampleRect::at(x, y, w, h))
}

fn parameters_id(entry: &Entry, grid: &Grid) -> ContentId {
    let mut id = IdHasher::default();
    id.bytes(entry.node.kind().as_bytes());
    entry.node.identify(grid, &mut id);
    id.finish()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn what_required_a_change_is_invalidated_by_it(out in rects(), changed in rects()) {
        for entry in registry() {
            for k in 0..entry.inputs.len() {
                let needs = entry.node.required(k, out).overlaps(&changed);
                prop_assert!(!needs || entry.node.invalidated(k, changed).overlaps(&out), "{}", entry.name);
                prop_assert!(entry.node.required(k, SampleRect::default()).is_empty(), "{}", entry.name);
                if entry.node.is_pointwise() {
                    prop_assert_eq!(entry.node.required(k, out), out);
                    prop_assert_eq!(entry.node.invalidated(k, changed), changed);
                }
            }
        }
    }

    #[test]
    fn a_whole_equals_its_parts(rect in rects(), cut in (0.0..1.0_f64, 0.0..1.0_f64)) {
        let level = LevelKey::new(2, 1);
        let (w, h) = (rect.width(), rect.height());
        let split = ((cut.0 * w as f64) as i64, (cut.1 * h as f64) as i64);
        for entry in registry() {
            let whole = render(&entry, level, rect);
            prop_assert!(entry.node.output() == Bands::Height || whole.samples().iter().all(|v| v.is_finite()));
            for (x, width) in [(0, split.0), (split.0, w - split.0)] {
                for (y, height) in [(0, split.1), (split.1, h - split.1)] {
                    let rect = SampleRect::at(rect.min.x + x, rect.min.y + y, width, height);
                    if rect.is_empty() {
                        continue;
                    }
                    let of_whole = part(&whole, (x as usize, y as usize), (width as usize, height as usize));
                    prop_assert_eq!(bits(&render(&entry, level, rect)), bits(&of_whole), "{}", entry.name);
                }
            }
        }
    }
}

#[test]
fn parameters_that_differ_have_ids_that_differ() {
    let grid = TileKey::new(LevelKey::new(2, 1), 1, 1).unwrap().grid();
    let mut seen = BTreeMap::new();
    for entry in registry() {
        let id = parameters_id(&entry, &grid);
        assert_eq!(id, parameters_id(&entry, &grid));
        assert_eq!(seen.insert(id, entry.name), None, "{}", entry.name);
    }
}

#[test]
fn what_is_known_of_uniform_inputs_is_what_is_rendered() {
    let rect = SampleRect::at(40, 40, 3, 2);
    let grid = Grid::new(Arc::new(LevelKey::new(2, 1).lattice()), rect);
    for entry in registry() {
        for seed in 0..60_u64 {
            let values: Vec<[f32; 4]> = entry
                .inputs
                .iter()
                .enumerate()
                .map(|(k, bands)| sample(*bands, hash(k as i64, 0, seed)))
                .collect();
            let known: Vec<_> = values
                .iter()
                .map(|v| relievo_graph::Known::Uniform(*v))
                .collect();
            let inputs: Vec<Block> = entry
                .inputs
                .iter()
                .zip(&values)
                .enumerate()
                .map(|(k, (bands, v))| {
                    let needs = entry.node.required(k, rect);
                    Block::filled(
                        *bands,
                        needs.width() as usize,
                        needs.height() as usize,
                        &v[..bands.planes()],
                    )
                })
                .collect();
            let mut out = block(entry.node.output(), &rect);
            let uniform = |k: usize, grid: &Grid| {
                let (width, height) = (grid.rect.width() as usize, grid.rect.height() as usize);
                let bands = entry.inputs[k];
                Block::filled(bands, width, height, &values[k][..bands.planes()])
            };
            let inputs: Vec<&Block> = inputs.iter().collect();
            render_from(&entry, &grid, &inputs, &mut out, uniform);
            if let Some(k) = entry.node.identity(&grid, &known) {
                let v = &values[k][..out.bands().planes()];
                let same = Block::filled(out.bands(), out.width(), out.height(), v);
                assert_eq!(bits(&out), bits(&same), "{}", entry.name);
            }
            match entry.node.known(&grid, &known) {
                relievo_graph::Known::Uniform(v) => {
                    let same = Block::filled(
                        out.bands(),
                        out.width(),
                        out.height(),
                        &v[..out.bands().planes()],
                    );
                    assert_eq!(bits(&out), bits(&same), "{}", entry.name);
                }
                relievo_graph::Known::Complete => {
                    let last = out.plane(out.bands().planes() - 1);
                    let full = |v: &f32| {
                        if out.bands() == Bands::Height {
                            !v.is_nan()
                        } else {
                            *v == 1.0
                        }
                    };
                    assert!(last.iter().all(full), "{}", entry.name);
                }
                relievo_graph::Known::Nothing => {}
            }
        }
    }
}

/// A graph that uses every kind of node, and its cut points.
fn every_node() -> (Graph, Vec<NodeIndex>) {
    let mut b = GraphBuilder::default();
    let base = b.add(
        Arc::new(Noise::new(Planet::EARTH, &noise_params(1, false))),
        &[],
    );
    let ridges = b.add(
        Arc::new(Noise::new(Planet::EARTH, &noise_params(2, true))),
        &[],
    );
    let sum = b.add(Arc::new(AddHeights), &[base, ridges]);
    let other = b.add(Arc::new(Constant::height(100.0)), &[]);
    let heights = b.add(Arc::new(OverlayHeights::new(0.25, false)), &[sum, other]);
    b.cut(heights, SampleType::Height);
    let heights = b.add(detail(DetailMethod::Simplex), &[heights]);
    b.cut(heights, SampleType::Height);
    let normals = b.add(Arc::new(Normals::new(Planet::EARTH, 40.0)), &[heights]);
    b.cut(normals, SampleType::Normal);
    let tinted = b.add(tint(true), &[heights]);
    let stepped = b.add(tint(false), &[sum]);
    let pasted = b.add(memory(), &[]);
    let colours = b.add(
        Arc::new(Overlay::new(BlendMode::Overlay, 0.7, false)),
        &[tinted, stepped],
    );
    b.cut(colours, SampleType::Rgba16F);
    let drawn = b.add(vector(Length::Pixels(3.0)), &[]);
    let colours = b.add(
        Arc::new(Overlay::new(BlendMode::Normal, 0.8, false)),
        &[colours, drawn],
    );
    b.cut(colours, SampleType::Rgba16F);
    let detailed = b.add(colour_detail(1, false), &[colours, tinted, stepped]);
    b.cut(detailed, SampleType::Rgba16F);
    let detailed = b.add(colour_noise(1, false), &[detailed]);
    b.cut(detailed, SampleType::Rgba16F);
    let met = b.add(seam_blend(2e6, false), &[detailed, pasted]);
    let over = b.add(
        Arc::new(Overlay::new(BlendMode::Normal, 1.0, false)),
        &[detailed, met],
    );
    let adjusted = b.add(adjust(|p| p.gamma = 1.4), &[over]);
    let twice = b.add(
        Arc::new(Overlay::new(BlendMode::Multiply, 0.5, false)),
        &[adjusted, over],
    );
    b.cut(twice, SampleType::Rgba8);
    (b.build(), vec![heights, normals, colours, detailed, twice])
}

type Tiles = BTreeMap<(NodeIndex, TileKey), Arc<Tile>>;

/// Makes a tile and everything it depends on.
fn make(graph: &Graph, node: NodeIndex, key: TileKey, tiles: &mut Tiles) -> Arc<Tile> {
    if let Some(tile) = tiles.get(&(node, key)) {
        return Arc::clone(tile);
    }
    let needs = graph.dependencies(node, key);
    for (input, key) in &needs {
        make(graph, *input, *key, tiles);
    }
    let read = |input, key| {
        assert!(needs.contains(&(input, key)), "only what was named is read");
        Arc::clone(&tiles[&(input, key)])
    };
    let tile = Arc::new(
        graph
            .make(node, key, &read, &Cancel::default())
            .expect("no errors"),
    );
    tiles.insert((node, key), Arc::clone(&tile));
    tile
}

fn unpacked(tile: &Tile) -> Block {
    let mut block = Block::new(tile.sample_type().bands(), 256, 256);
    tile.copy_to((0, 0), &mut block, (0, 0), (256, 256));
    block
}

#[test]
fn tiles_equal_evaluation_bit_for_bit_also_at_the_antimeridian_and_the_poles() {
    let (graph, cuts) = every_node();
    let mut tiles = Tiles::new();
    for (m, n, column, row) in [
        (0, 0, 0, 0),
        (1, 0, 1, 0),
        (2, 1, 0, 0),
        (2, 1, 3, 1),
        (3, 2, 5, 1),
    ] {
        let key = TileKey::new(LevelKey::new(m, n), column, row).unwrap();
        for node in &cuts {
            let tile = unpacked(&make(&graph, *node, key, &mut tiles));
            let whole = graph
                .evaluate(*node, &key.grid(), &Cancel::default())
                .unwrap();
            assert!(bits(&tile) == bits(&whole), "{node:?} {key}");
        }
    }
}

#[test]
fn a_grid_across_the_antimeridian_and_a_pole_is_put_together_from_tiles() {
    let (graph, cuts) = every_node();
    let level = LevelKey::new(2, 1);
    let rect = SampleRect::at(-40, -30, 80, 60);
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    let mut tiles = Tiles::new();
    for node in cuts {
        let across = graph.evaluate(node, &grid, &Cancel::default()).unwrap();
        for (x, y) in [(0, 0), (39, 29), (40, 30), (79, 59), (12, 45), (60, 5)] {
            let place = rect.min + glam::I64Vec2::new(x, y);
            let inside = level.wrap_sample(place);
            let key = TileKey::new(level, inside.x / 256, inside.y / 256).unwrap();
            let tile = unpacked(&make(&graph, node, key, &mut tiles));
            let turned = if tile.bands() == Bands::Normal && place.y < 0 {
                -1.0
            } else {
                1.0
            };
            for plane in 0..tile.bands().planes() {
                let expected =
                    tile.plane(plane)[((inside.y % 256) * 256 + inside.x % 256) as usize] * turned;
                assert_eq!(
                    across.plane(plane)[(y * 80 + x) as usize],
                    expected,
                    "{node:?} {place}"
                );
            }
        }
    }
}

#[test]
fn any_number_of_threads_and_any_order_give_the_same_bytes() {
    let (graph, cuts) = every_node();
    let level = LevelKey::new(1, 0);
    let mut wanted: Vec<(NodeIndex, TileKey)> = cuts
        .iter()
        .flat_map(|node| (0..2).map(|c| (*node, TileKey::new(level, c, 0).unwrap())))
        .collect();
    let mut first = Tiles::new();
    for (node, key) in &wanted {
        make(&graph, *node, *key, &mut first);
    }
    for threads in [2, 4] {
        wanted.reverse();
        wanted.rotate_left(3);
        let shares: Vec<Tiles> = std::thread::scope(|scope| {
            let share = |t: usize| {
                let (graph, wanted) = (&graph, &wanted);
                scope.spawn(move || {
                    let mut tiles = Tiles::new();
                    for (node, key) in wanted.iter().skip(t).step_by(threads) {
                        make(graph, *node, *key, &mut tiles);
                    }
                    tiles
                })
            };
            let all: Vec<_> = (0..threads).map(share).collect();
            all.into_iter()
                .map(|thread| thread.join().unwrap())
                .collect()
        });
        for (place, tile) in shares.iter().flatten() {
            assert_eq!(tile.bytes(), first[place].bytes(), "{place:?}");
            assert_eq!(tile.as_uniform(), first[place].as_uniform(), "{place:?}");
        }
    }
}

#[test]
fn equal_ids_mean_equal_bytes_and_tiles_that_differ_have_ids_that_differ() {
    let (graph, cuts) = every_node();
    let mut tiles = Tiles::new();
    let mut by_id: BTreeMap<ContentId, Arc<Tile>> = BTreeMap::new();
    for (column, row) in [(0, 0), (1, 0), (2, 1), (3, 1)] {
        let key = TileKey::new(LevelKey::new(2, 1), column, row).unwrap();
        for node in &cuts {
            let tile = make(&graph, *node, key, &mut tiles);
            let id = graph.content_id(*node, key);
            let before = by_id.entry(id).or_insert_with(|| Arc::clone(&tile));
            assert_eq!(before.bytes(), tile.bytes());
            assert_eq!(before.as_uniform(), tile.as_uniform());
        }
    }
    assert_eq!(by_id.len(), 20, "no two of these are equal");
}

#[test]
fn samples_outside_of_what_is_required_do_not_matter() {
    // A hole and a spike just outside of what the middle of a tile's normals require.
    let level = LevelKey::new(2, 1);
    let out = SampleRect::at(100, 100, 20, 20);
    let normals = |outside: f32| {
        let mut b = GraphBuilder::default();
        let around = SampleRect::at(90, 90, 40, 40);
        let mut samples = block(Bands::Height, &around);
        fill_at(&mut samples, around, 1);
        let needs = Normals::new(Planet::EARTH, 1.0).required(0, out);
        for (i, v) in samples.samples_mut().iter_mut().enumerate() {
            if !needs.contains(around.min + glam::I64Vec2::new(i as i64 % 40, i as i64 / 40)) {
                *v = outside;
            }
        }
        let grid = Grid::new(Arc::new(level.lattice()), around);
        let heights = b.add(Arc::new(Memory::new(&grid, samples)), &[]);
        let normals = b.add(Arc::new(Normals::new(Planet::EARTH, 1.0)), &[heights]);
        b.build()
            .evaluate(normals, &grid.with_rect(out), &Cancel::default())
            .unwrap()
    };
    assert_eq!(bits(&normals(f32::NAN)), bits(&normals(1e9)));
}
