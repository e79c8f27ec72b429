//! What the compiled graph leaves out, names and reads. Laws that hold for every node: `tests/laws.rs`.

use std::sync::Arc;

use relievo_planet::{LevelKey, Planet, SampleRect, TileKey};
use relievo_raster::{Cancel, Sample, SampleType};

use super::*;
use crate::nodes::{
    AddHeights, Adjust, AdjustParams, BlendMode, Constant, Memory, Noise, NoiseParams, Normals,
    Overlay, OverlayHeights, Stop, Tint,
};

fn noise(seed: u64) -> Arc<Noise> {
    Arc::new(Noise::new(
        Planet::EARTH,
        &NoiseParams {
            seed,
            amplitude_m: 500.0,
            wavelength_m: 4e6,
            octaves: 3,
            lacunarity: 2.0,
            gain: 0.5,
            ridged: false,
        },
    ))
}

fn tint() -> Arc<Tint> {
    let stops = [(-500.0, 0.0), (500.0, 1.0)].map(|(height_m, v)| Stop {
        height_m,
        rgba: [v, 0.5, 0.25, 1.0],
    });
    Arc::new(Tint::new(&stops, true).unwrap())
}

fn key(m: u8, n: u8, column: i64, row: i64) -> TileKey {
    TileKey::new(LevelKey::new(m, n), column, row).unwrap()
}

fn none(_: NodeIndex, _: TileKey) -> Arc<Tile> {
    panic!("nothing is read")
}

/// noise → tint, and what stands between it and the cut point.
fn chain(add: impl FnOnce(&mut GraphBuilder, NodeIndex) -> NodeIndex) -> (Graph, NodeIndex) {
    let mut builder = GraphBuilder::default();
    let heights = builder.add(noise(1), &[]);
    let colours = builder.add(tint(), &[heights]);
    let last = add(&mut builder, colours);
    builder.cut(last, SampleType::Rgba8);
    (builder.build(), last)
}

#[test]
fn inert_nodes_leave_ids_and_dependencies_as_they_were() {
    let (plain, end) = chain(|_, colours| colours);
    let (inert, inert_end) = chain(|b, colours| {
        let same = b.add(Arc::new(Adjust::new(&AdjustParams::default())), &[colours]);
        let top = b.add(Arc::new(Constant::colour([1.0; 4])), &[]);
        let hidden = b.add(
            Arc::new(Overlay::new(BlendMode::Screen, 0.0, false)),
            &[same, top],
        );
        let hole = b.add(Arc::new(Constant::colour([0.0; 4])), &[]);
        b.add(
            Arc::new(Overlay::new(BlendMode::Normal, 1.0, false)),
            &[hidden, hole],
        )
    });
    let tile = key(2, 1, 3, 0);
    assert_eq!(
        plain.content_id(end, tile),
        inert.content_id(inert_end, tile)
    );
    assert_eq!(
        inert.made_by(inert_end, &tile.grid()),
        [NodeIndex(0), NodeIndex(1)]
    );
}

#[test]
fn the_name_of_a_region_follows_what_it_holds() {
    let (plain, end) = chain(|_, colours| colours);
    let (inert, inert_end) =
        chain(|b, colours| b.add(Arc::new(Adjust::new(&AdjustParams::default())), &[colours]));
    let (other, other_end) = chain(|b, colours| {
        let brighter = AdjustParams {
            brightness: 0.2,
            ..AdjustParams::default()
        };
        b.add(Arc::new(Adjust::new(&brighter)), &[colours])
    });
    let grid = |x, width| {
        let lattice = LevelKey::new(3, 2).lattice();
        Grid::new(Arc::new(lattice), SampleRect::at(x, 40, width, 500))
    };
    let name = plain.evaluation_id(end, &grid(10, 900));
    assert_eq!(inert.evaluation_id(inert_end, &grid(10, 900)), name);
    assert_ne!(other.evaluation_id(other_end, &grid(10, 900)), name);
    assert_ne!(plain.evaluation_id(end, &grid(11, 900)), name);
    assert_ne!(plain.evaluation_id(end, &grid(10, 901)), name);
}

#[test]
fn an_opaque_top_hides_everything_below_from_the_id() {
    let with_base = |seed| {
        let mut b = GraphBuilder::default();
        let base = b.add(noise(seed), &[]);
        let base = b.add(tint(), &[base]);
        let top = b.add(noise(9), &[]);
        let top = b.add(tint(), &[top]);
        let over = b.add(
            Arc::new(Overlay::new(BlendMode::Normal, 1.0, false)),
            &[base, top],
        );
        b.cut(over, SampleType::Rgba8);
        b.build().content_id(over, key(1, 0, 1, 0))
    };
    assert_eq!(with_base(1), with_base(2));
}

#[test]
fn a_cut_point_over_one_of_its_own_type_is_the_same_content_and_is_made_the_same_way() {
    let mut b = GraphBuilder::default();
    let colours = b.add(noise(1), &[]);
    let inner = b.add(tint(), &[colours]);
    b.cut(colours, SampleType::Height);
    b.cut(inner, SampleType::Rgba8);
    let outer = b.add(Arc::new(Adjust::new(&AdjustParams::default())), &[inner]);
    b.cut(outer, SampleType::Rgba8);
    let graph = b.build();
    let tile = key(2, 1, 0, 1);
    assert_eq!(graph.content_id(inner, tile), graph.content_id(outer, tile));
    assert_eq!(
        graph.dependencies(outer, tile),
        [(colours, tile)],
        "not on the tile that is itself"
    );
    assert_ne!(
        graph.content_id(colours, tile),
        graph.content_id(inner, tile)
    );
}

#[test]
fn uniform_content_is_named_by_value_and_read_from_nowhere() {
    let uniform = |node: Arc<dyn ImageNode>| {
        let mut b = GraphBuilder::default();
        let heights = b.add(node, &[]);
        let colours = b.add(tint(), &[heights]);
        b.cut(heights, SampleType::Height);
        b.cut(colours, SampleType::Rgba8);
        (b.build(), colours)
    };
    let (constant, end) = uniform(Arc::new(Constant::height(500.0)));
    let tile = key(3, 2, 1, 1);
    assert!(constant.dependencies(end, tile).is_empty());
    let made = constant.make(end, tile, &none, &Cancel::default()).unwrap();
    assert_eq!(made.as_uniform(), Some(Sample::Rgba8([255, 128, 64, 255])));
    let mut b = GraphBuilder::default();
    let direct = b.add(Arc::new(Constant::colour([1.0, 0.5, 0.25, 1.0])), &[]);
    b.cut(direct, SampleType::Rgba8);
    assert_eq!(
        b.build().content_id(direct, key(5, 4, 0, 0)),
        constant.content_id(end, tile)
    );
}

#[test]
fn normals_read_the_nine_tiles_around_and_over_the_poles() {
    let mut b = GraphBuilder::default();
    let heights = b.add(noise(1), &[]);
    let normals = b.add(Arc::new(Normals::new(Planet::EARTH, 1.0)), &[heights]);
    b.cut(normals, SampleType::Normal);
    let graph = b.build();
    assert_eq!(graph.cut_type(heights), Some(SampleType::Height));
    assert_eq!(graph.dependencies(normals, key(3, 2, 4, 1)).len(), 9);
    let at_pole = graph.dependencies(normals, key(3, 2, 0, 0));
    assert!(
        at_pole.contains(&(heights, key(3, 2, 4, 0))),
        "half way around: {at_pole:?}"
    );
    assert!(
        at_pole.contains(&(heights, key(3, 2, 7, 1))),
        "west of the antimeridian: {at_pole:?}"
    );
    assert_eq!(
        graph.dependencies(normals, key(0, 0, 0, 0)),
        [(heights, key(0, 0, 0, 0))]
    );
}

#[test]
fn a_change_of_one_tile_changes_ids_of_its_neighbours_only() {
    let level = LevelKey::new(4, 3);
    let graph = |height_m: f32| {
        let spot = Grid::new(Arc::new(level.lattice()), SampleRect::at(1100, 600, 20, 20));
        let mut b = GraphBuilder::default();
        let base = b.add(noise(1), &[]);
        let patch = Memory::new(&spot, Block::filled(Bands::Height, 20, 20, &[height_m]));
        let patch = b.add(Arc::new(patch), &[]);
        let heights = b.add(Arc::new(OverlayHeights::new(1.0, false)), &[base, patch]);
        let normals = b.add(Arc::new(Normals::new(Planet::EARTH, 1.0)), &[heights]);
        b.cut(normals, SampleType::Normal);
        (b.build(), normals)
    };
    let ((before, node), (after, _)) = (graph(10.0), graph(20.0));
    let mut changed = Vec::new();
    for row in 0..8 {
        for column in 0..16 {
            let key = TileKey::new(level, column, row).unwrap();
            if before.content_id(node, key) != after.content_id(node, key) {
                changed.push((column, row));
            }
        }
    }
    // The patch lies in tile (4, 2); normals around it read that tile.
    let around: Vec<(i64, i64)> = (1..4)
        .flat_map(|row| (3..6).map(move |column| (column, row)))
        .collect();
    assert_eq!(changed, around);
}

#[test]
fn added_detail_that_a_level_cannot_show_costs_nothing() {
    let mut b = GraphBuilder::default();
    let base = b.add(noise(1), &[]);
    let fine = NoiseParams {
        seed: 2,
        amplitude_m: 1.0,
        wavelength_m: 20.0,
        octaves: 3,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: true,
    };
    let detail = b.add(Arc::new(Noise::new(Planet::EARTH, &fine)), &[]);
    let sum = b.add(Arc::new(AddHeights), &[base, detail]);
    b.cut(base, SampleType::Height);
    b.cut(sum, SampleType::Height);
    let graph = b.build();
    assert_eq!(
        graph.content_id(sum, key(4, 3, 0, 0)),
        graph.content_id(base, key(4, 3, 0, 0))
    );
    assert_ne!(
        graph.content_id(sum, key(20, 19, 0, 1 << 18)),
        graph.content_id(base, key(20, 19, 0, 1 << 18))
    );
}

#[test]
fn a_cancelled_job_says_so() {
    let (graph, end) = chain(|_, colours| colours);
    let cancel = Cancel::default();
    cancel.cancel();
    let tile = key(2, 1, 3, 0);
    assert!(matches!(
        graph.make(end, tile, &none, &cancel),
        Err(RenderError::Cancelled)
    ));
    assert!(matches!(
        graph.evaluate(end, &tile.grid(), &cancel),
        Err(RenderError::Cancelled)
    ));
}

#[test]
fn thousands_of_layers_do_not_overflow_the_stack() {
    let (graph, end) = chain(|b, colours| {
        let mut last = colours;
        for i in 0..5000 {
            let brightness = f64::from(i % 2) * 0.01;
            last = b.add(
                Arc::new(Adjust::new(&AdjustParams {
                    brightness,
                    ..AdjustParams::default()
                })),
                &[last],
            );
        }
        last
    });
    let tile = key(2, 1, 3, 0);
    graph.content_id(end, tile);
    let grid = tile.grid().with_rect(SampleRect::at(800, 3, 2, 2));
    graph.evaluate(end, &grid, &Cancel::default()).unwrap();
}

#[test]
fn what_two_graphs_share_has_the_same_names_and_what_differs_is_not_shared() {
    let noise: Arc<dyn ImageNode> = Arc::new(Constant::height(7.0));
    let over: Arc<dyn ImageNode> = Arc::new(AddHeights);
    let graph = |second: f32, cut: bool| {
        let mut b = GraphBuilder::default();
        let first = b.add(Arc::clone(&noise), &[]);
        b.cut(first, SampleType::Height);
        let second = b.add(Arc::new(Constant::height(second)), &[]);
        let sum = b.add(Arc::clone(&over), &[first, second]);
        let twice = b.add(Arc::clone(&over), &[first, first]);
        if cut {
            b.cut(twice, SampleType::Height);
        }
        (b.build(), [first, second, sum, twice])
    };
    let (a, [first, _, _, twice]) = graph(1.0, true);
    let (b, _) = graph(2.0, true);
    let (c, _) = graph(1.0, false);
    let sorted = |shared: HashSet<NodeIndex>| {
        let mut shared: Vec<_> = shared.into_iter().collect();
        shared.sort_unstable();
        shared
    };
    // The sum reads what is another node.
    assert_eq!(sorted(b.shared_with(&a)), [first, twice]);
    assert_eq!(sorted(c.shared_with(&a)), [first], "stored another way");
    let key = TileKey::new(LevelKey::new(3, 2), 1, 1).unwrap();
    for node in sorted(b.shared_with(&a)) {
        assert_eq!(a.content_id(node, key), b.content_id(node, key));
    }
}
