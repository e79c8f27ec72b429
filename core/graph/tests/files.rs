//! Raster files as nodes: what is known of them, their holes, and their fading edges.

#[path = "common/flat.rs"]
mod flat;

use std::sync::Arc;

use flat::Flat;
use relievo_graph::nodes::{Constant, EdgeDistances, FileSource, OverlayHeights, RangeMask};
use relievo_graph::{Graph, GraphBuilder, ImageNode, Known, NodeIndex};
use relievo_planet::{Grid, LevelKey, Planet, SampleRect, TileKey};
use relievo_raster::{Bands, Cancel, SampleType};

/// The file, perhaps with holes, over a ground of 2 m, faded over `width_m`.
fn faded(holes: bool, width_m: f64) -> (Graph, NodeIndex) {
    let warp = Flat::warp(holes, Planet::EARTH);
    let mut b = GraphBuilder::default();
    let ground = b.add(Arc::new(Constant::height(2.0)), &[]);
    let file = b.add(Arc::new(FileSource::new(Arc::clone(&warp), 1.0, 0.0)), &[]);
    let distances = b.add(Arc::new(EdgeDistances::new(warp, width_m)), &[]);
    let mask = RangeMask::new(width_m, f64::NAN, width_m);
    let fade = b.add(Arc::new(mask), &[distances]);
    let over = b.add(
        Arc::new(OverlayHeights::new(1.0, true)),
        &[ground, file, fade],
    );
    b.cut(over, SampleType::Height);
    (b.build(), over)
}

fn grid_at(lon_deg: f64, lat_deg: f64) -> Grid {
    let level = LevelKey::new(5, 4);
    let sample = level.sample_from_map(relievo_planet::MapPoint::from_degrees(lon_deg, lat_deg));
    Grid::new(
        Arc::new(level.lattice()),
        SampleRect::at(sample.x as i64, sample.y as i64, 1, 1),
    )
}

#[test]
fn heights_are_scaled_and_there_are_none_beyond_the_file() {
    let node = FileSource::new(Flat::warp(true, Planet::EARTH), 2.0, 1.0);
    assert!(
        node.known(&grid_at(-60.0, 0.0), &[])
            .is_absent(Bands::Height)
    );
    assert_eq!(
        node.known(&grid_at(4.0, 4.0), &[]),
        Known::Nothing,
        "it may have holes"
    );
    let mut b = GraphBuilder::default();
    let file = b.add(Arc::new(node), &[]);
    let graph = b.build();
    let height_m = |grid| {
        graph
            .evaluate(file, &grid, &Cancel::default())
            .unwrap()
            .samples()[0]
    };
    assert_eq!(height_m(grid_at(4.0, 4.0)), 21.0);
    assert!(height_m(grid_at(-60.0, 0.0)).is_nan());
}

#[test]
fn a_file_without_holes_is_complete_where_it_covers_a_grid_well() {
    let known = |holes: bool, lon_deg: f64, samples: i64| {
        let node = FileSource::new(Flat::warp(holes, Planet::EARTH), 1.0, 0.0);
        let grid = grid_at(lon_deg, 4.0);
        let at = grid.rect.min;
        let grid = grid.with_rect(SampleRect::at(at.x, at.y, samples, samples));
        let known = node.known(&grid, &[]);
        let mut b = GraphBuilder::default();
        let file = b.add(Arc::new(node), &[]);
        let made = b.build().evaluate(file, &grid, &Cancel::default()).unwrap();
        let whole = made.samples().iter().all(|h| !h.is_nan());
        assert!(whole || known != Known::Complete, "never wrong");
        (known, whole)
    };
    assert_eq!(known(false, 4.0, 4), (Known::Complete, true));
    assert_eq!(known(true, 4.0, 4), (Known::Nothing, true));
    // Across the outline, and beside it where rounding may put a sample on either side.
    assert_eq!(known(false, 7.0, 40), (Known::Nothing, false));
    assert_eq!(known(false, 7.95, 1), (Known::Nothing, true));
    for step in 0..60 {
        known(false, -0.3 + 0.01 * f64::from(step), 3);
    }
}

#[test]
fn a_file_fades_into_the_ground_towards_its_edge() {
    let (graph, node) = faded(true, 200_000.0);
    let height_m = |lon| {
        graph
            .evaluate(node, &grid_at(lon, 4.0), &Cancel::default())
            .unwrap()
            .samples()[0]
    };
    assert_eq!(height_m(4.0), 10.0);
    assert_eq!(height_m(-3.0), 2.0);
    let near = height_m(0.9);
    assert!(near > 3.0 && near < 9.0, "{near}");
}

#[test]
fn tiles_beyond_a_file_are_named_as_if_it_were_not_there() {
    let far = TileKey::new(LevelKey::new(4, 3), 1, 1).unwrap();
    let (graph, node) = faded(true, 1000.0);
    let mut b = GraphBuilder::default();
    let ground = b.add(Arc::new(Constant::height(2.0)), &[]);
    b.cut(ground, SampleType::Height);
    assert_eq!(
        graph.content_id(node, far),
        b.build().content_id(ground, far)
    );
    assert_eq!(graph.made_by(node, &far.grid()), [NodeIndex(0)]);
    let (other, other_node) = faded(true, 2000.0);
    let near = TileKey::new(LevelKey::new(4, 3), 8, 3).unwrap();
    assert_ne!(
        graph.content_id(node, near),
        other.content_id(other_node, near)
    );
}

#[test]
fn well_inside_a_file_that_fades_nothing_below_it_is_looked_at() {
    let grid = grid_at(4.0, 4.0);
    let makers = |holes, width_m| {
        let (graph, node) = faded(holes, width_m);
        let height_m = graph.evaluate(node, &grid, &Cancel::default()).unwrap();
        assert_eq!(height_m.samples()[0], 10.0);
        let made_by = graph.made_by(node, &grid);
        made_by.into_iter().map(|n| graph.node(n).kind()).collect()
    };
    let alone: Vec<&str> = makers(false, 50_000.0);
    assert_eq!(alone, ["file"]);
    let with_holes: Vec<&str> = makers(true, 50_000.0);
    assert!(with_holes.contains(&"edge distances"), "{with_holes:?}");
    let near_its_edge: Vec<&str> = makers(false, 440_000.0);
    assert!(near_its_edge.contains(&"constant"), "{near_its_edge:?}");
}

#[test]
fn distances_to_an_edge_are_other_ones_on_another_planet() {
    let name = |planet| {
        let mut b = GraphBuilder::default();
        let warp = Flat::warp(true, planet);
        let distances = b.add(Arc::new(EdgeDistances::new(warp, 1000.0)), &[]);
        b.build().evaluation_id(distances, &grid_at(1.0, 4.0))
    };
    let moon = Planet::sphere(1_737_400.0);
    assert_ne!(name(Planet::EARTH), name(moon));
    assert_eq!(name(moon), name(moon));
}
