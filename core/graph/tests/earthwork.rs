//! Planning elements in a graph: what an edit makes anew, and what it does not.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec2;
use relievo_earthwork::{
    Corridor, Element, Frame, Polygon, Prepared, Profile, Section, Shape, Side, Stroke, Surface,
    Tool, Vertex,
};
use relievo_graph::nodes::{Constant, Earthwork, Memory, PlacedElement};
use relievo_graph::{
    Artefacts, ContentId, Graph, GraphBuilder, IdHasher, ImageNode as _, NodeIndex,
};
use relievo_planet::{Grid, GridCrs, Lattice, LevelKey, MapPoint, Planet, SampleRect, TileKey};
use relievo_raster::{Bands, Block, Cancel, SampleType};

/// Ground of some metres in steps of 40 m, around a place; holes far from it.
fn hills() -> Memory {
    let level = LevelKey::new(11, 11);
    let middle = level.sample_from_map(alps().origin()).as_i64vec2();
    let grid = Grid::new(
        Arc::new(level.lattice()),
        SampleRect::at(middle.x - 32, middle.y - 32, 64, 64),
    );
    let mut dice = Dice(3);
    let mut block = Block::new(Bands::Height, 64, 64);
    for h in block.samples_mut() {
        *h = dice.within(-4.0, 4.0) as f32;
    }
    Memory::new(&grid, block)
}

fn alps() -> Frame {
    Frame::new(Planet::EARTH, MapPoint::from_degrees(11.4, 47.2))
}

fn place(element: Element) -> Arc<PlacedElement> {
    let prepared = Prepared::new(Planet::EARTH, Arc::new(element));
    Arc::new(PlacedElement::new(Arc::new(prepared)))
}

fn graph(elements: &[Arc<PlacedElement>], store: &Arc<Artefacts>) -> (Graph, NodeIndex) {
    let mut b = GraphBuilder::default();
    b.keep_artefacts(store);
    let ground = b.add(Arc::new(hills()), &[]);
    b.cut(ground, SampleType::Height);
    let node = Earthwork::new(Planet::EARTH, elements.to_vec());
    let planned = b.add(Arc::new(node), &[ground]);
    b.cut(planned, SampleType::Height);
    (b.build(), planned)
}

fn vertices(frame: &Frame, points: &[(f64, f64)], height_m: Option<f64>) -> Vec<Vertex> {
    points
        .iter()
        .map(|(x, y)| Vertex {
            place: frame.to_map(DVec2::new(*x, *y)),
            height_m,
        })
        .collect()
}

fn square(frame: &Frame, x: f64, y: f64, half: f64, surface: Surface) -> Element {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    Element {
        shape: Shape::Polygon(Polygon {
            outline: vertices(frame, &corners.map(|(a, b)| (a + x, b + y)), None),
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface,
        }),
        side: Side {
            max_reach_m: 40.0,
            ..Side::default()
        },
    }
}

/// Numbers that look random and are always the same.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll(100_000) as f64 / 1e5
    }
}

fn random_element(frame: &Frame, dice: &mut Dice) -> Element {
    let (x, y) = (dice.within(-250.0, 250.0), dice.within(-250.0, 250.0));
    let size = dice.within(8.0, 40.0);
    let height = dice.within(-12.0, 12.0);
    match dice.roll(8) {
        0 | 1 => square(frame, x, y, size, Surface::Platform { height_m: height }),
        2 => square(
            frame,
            x,
            y,
            size,
            Surface::Plane {
                height_m: height,
                slope_percent: 9.0,
                aspect_deg: 70.0,
            },
        ),
        3 => square(frame, x, y, size, Surface::Tin),
        4 => square(
            frame,
            x,
            y,
            size,
            Surface::Offset {
                offset_m: height / 4.0,
            },
        ),
        5 => square(frame, x, y, size, Surface::Smooth),
        6 => Element {
            shape: Shape::Corridor(Corridor {
                line: vertices(
                    frame,
                    &[
                        (x, y),
                        (x + 2.0 * size, y + size),
                        (x + size, y + 3.0 * size),
                    ],
                    None,
                ),
                profile: Profile::Follow {
                    offset_m: height / 6.0,
                    smooth_m: 30.0,
                },
                section: Section::Road {
                    width_m: 7.0,
                    crossfall_percent: 2.0,
                },
            }),
            side: Side {
                max_reach_m: 25.0,
                ..Side::default()
            },
        },
        _ => Element {
            shape: Shape::Brush(vec![Stroke {
                tool: if height > 0.0 {
                    Tool::Raise { strength_m: height }
                } else {
                    Tool::Smooth { strength: 0.7 }
                },
                radius_m: size / 2.0,
                hardness: 0.5,
                points: [(x, y), (x + size, y)]
                    .map(|(x, y)| frame.to_map(DVec2::new(x, y)))
                    .to_vec(),
            }]),
            side: Side::default(),
        },
    }
}

/// Pieces of 32 by 32 samples, 2.4 m apart, around a place.
fn pieces(frame: &Frame, around: i64) -> Vec<Grid> {
    let level = LevelKey::new(15, 15);
    let lattice = Arc::new(level.lattice());
    let middle = level.sample_from_map(frame.origin());
    let (x, y) = (middle.x as i64 / 32, middle.y as i64 / 32);
    (-around..around)
        .flat_map(|j| (-around..around).map(move |i| (i, j)))
        .map(|(i, j)| {
            let rect = SampleRect::at((x + i) * 32, (y + j) * 32, 32, 32);
            Grid::new(Arc::clone(&lattice), rect)
        })
        .collect()
}

fn bits(block: &Block) -> Vec<u32> {
    block.samples().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn edits_rename_what_changes_and_only_what_is_in_reach() {
    let frame = alps();
    let mut dice = Dice(42);
    let store = Arc::new(Artefacts::default());
    let grids = pieces(&frame, 4);
    let mut elements: Vec<Arc<PlacedElement>> = (0..24)
        .map(|_| place(random_element(&frame, &mut dice)))
        .collect();
    let cancel = Cancel::default();
    let mut kept: HashMap<ContentId, Vec<u32>> = HashMap::new();
    let ids = |(g, n): &(Graph, NodeIndex)| -> Vec<ContentId> {
        grids.iter().map(|grid| g.evaluation_id(*n, grid)).collect()
    };
    let mut now = graph(&elements, &store);
    let mut names = ids(&now);
    let (mut renamed, mut changed) = (0, 0);
    for edit in 0..250 {
        let which = dice.roll(elements.len() as u64) as usize;
        let before = Arc::clone(&elements[which]);
        let after = match dice.roll(10) {
            // Others win now.
            0 => {
                let last = elements.len() - 1;
                elements.swap(which, last);
                None
            }
            _ => Some(place(random_element(&frame, &mut dice))),
        };
        let mut touched = vec![Arc::clone(&before)];
        match &after {
            Some(after) => {
                elements[which] = Arc::clone(after);
                touched.push(Arc::clone(after));
            }
            None => touched.push(Arc::clone(&elements[which])),
        }
        let next = graph(&elements, &store);
        let new_names = ids(&next);
        let of_touched = Earthwork::new(Planet::EARTH, touched);
        let mut same = Vec::new();
        let mut differ = Vec::new();
        for (k, grid) in grids.iter().enumerate() {
            if names[k] == new_names[k] {
                same.push(k);
            } else {
                assert!(
                    !of_touched.is_idle(grid),
                    "edit {edit} renamed what it does not reach"
                );
                differ.push(k);
            }
        }
        // Some of either kind: equal names are equal bytes, before and after.
        let some = |all: &[usize], dice: &mut Dice| {
            all.get(dice.roll(all.len().max(1) as u64) as usize)
                .copied()
        };
        for k in [some(&same, &mut dice), some(&differ, &mut dice)]
            .into_iter()
            .flatten()
        {
            let old = kept
                .entry(names[k])
                .or_insert_with(|| bits(&now.0.evaluate(now.1, &grids[k], &cancel).unwrap()))
                .clone();
            let new = bits(&next.0.evaluate(next.1, &grids[k], &cancel).unwrap());
            if names[k] == new_names[k] {
                assert!(old == new, "edit {edit} changed what kept its name");
            } else {
                renamed += 1;
                changed += usize::from(old != new);
            }
            kept.insert(new_names[k], new);
        }
        (now, names) = (next, new_names);
    }
    // Reach is a promise, not a measurement: some that get new names keep their bytes.
    println!("{changed} of {renamed} renamed pieces changed");
    assert!(
        renamed > 60 && changed * 2 > renamed,
        "{changed} of {renamed}"
    );
    // Everything anew, nothing shared, gives the same.
    let again: Vec<Arc<PlacedElement>> = elements
        .iter()
        .map(|e| place(Element::clone(e.prepared().element())))
        .collect();
    let fresh = graph(&again, &Arc::new(Artefacts::default()));
    for (k, grid) in grids.iter().enumerate() {
        assert_eq!(fresh.0.evaluation_id(fresh.1, grid), names[k]);
        let new = fresh.0.evaluate(fresh.1, grid, &cancel).unwrap();
        if let Some(old) = kept.get(&names[k]) {
            assert!(*old == bits(&new), "{k}");
        }
    }
}

#[test]
fn what_stands_on_the_ground_is_made_once_for_all_tiles_and_revisions() {
    let frame = alps();
    let store = Arc::new(Artefacts::default());
    let offset = place(square(
        &frame,
        0.0,
        0.0,
        100.0,
        Surface::Offset { offset_m: 3.0 },
    ));
    let other = place(square(
        &frame,
        150.0,
        0.0,
        20.0,
        Surface::Platform { height_m: 5.0 },
    ));
    let cancel = Cancel::default();
    for elements in [vec![Arc::clone(&offset)], vec![offset, other]] {
        let (g, n) = graph(&elements, &store);
        for grid in pieces(&frame, 2) {
            g.evaluate(n, &grid, &cancel).unwrap();
        }
        assert_eq!(store.made(), 1);
    }
}

#[test]
fn where_nothing_is_planned_the_ground_is_handed_through() {
    let frame = alps();
    let far = place(square(
        &frame,
        50_000.0,
        0.0,
        20.0,
        Surface::Platform { height_m: 5.0 },
    ));
    let (with, n) = graph(&[far], &Arc::default());
    let (without, m) = graph(&[], &Arc::default());
    for grid in pieces(&frame, 2) {
        assert_eq!(
            with.evaluation_id(n, &grid),
            without.evaluation_id(m, &grid)
        );
    }
    let level = LevelKey::new(15, 15);
    let at = level.sample_from_map(frame.origin()).as_i64vec2() / 256;
    let key = TileKey::new(level, at.x, at.y).unwrap();
    assert_eq!(with.content_id(n, key), with.content_id(NodeIndex(0), key));
}

#[test]
fn an_element_is_where_it_is_on_any_grid_across_the_antimeridian_and_at_a_pole() {
    for (lon, lat) in [(180.0, 10.0), (20.0, 90.0), (11.4, 47.2), (0.0, -90.0)] {
        let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
        let pad = place(square(
            &frame,
            0.0,
            0.0,
            3000.0,
            Surface::Platform { height_m: 777.0 },
        ));
        let mut b = GraphBuilder::default();
        let ground = b.add(Arc::new(Constant::height(776.0)), &[]);
        let node = Arc::new(Earthwork::new(Planet::EARTH, vec![pad]));
        let planned = b.add(node, &[ground]);
        b.cut(planned, SampleType::Height);
        let g = b.build();
        // A polar level has few columns; a grid over the pole or the antimeridian is pieces of tiles.
        let level = if lat.abs() > 80.0 {
            LevelKey::new(4, 10)
        } else {
            LevelKey::new(11, 10)
        };
        let at = level.sample_from_map(frame.origin()).as_i64vec2();
        let rect = SampleRect::at(at.x - 50, at.y - 50, 100, 100);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let heights = g.evaluate(planned, &grid, &Cancel::default()).unwrap();
        let mut inside = 0;
        for (k, h) in heights.samples().iter().enumerate() {
            let sample = rect.min + glam::I64Vec2::new(k as i64 % 100, k as i64 / 100);
            let p = frame.from_map(grid.lattice.map_point(sample));
            if p.abs().max_element() < 2999.0 {
                assert_eq!(*h, 777.0, "{lon} {lat} {p}");
                inside += 1;
            } else if p.abs().max_element() > 3003.0 {
                assert_eq!(*h, 776.0, "{lon} {lat} {p}");
            }
        }
        assert!(inside > 1000, "{lon} {lat}: {inside}");
    }
}

#[test]
fn a_projected_grid_sees_the_same_heights() {
    let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(15.0, 45.0));
    let pad = place(square(
        &frame,
        0.0,
        0.0,
        40.0,
        Surface::Platform { height_m: 30.0 },
    ));
    let (g, n) = graph(&[pad], &Arc::default());
    let lattice = Lattice {
        crs: GridCrs::Projected("EPSG:32633".into()),
        origin: DVec2::new(500_000.0 - 100.0, 4_982_950.4 + 100.0),
        step: DVec2::new(2.0, -2.0),
        columns_around: None,
    };
    let grid = Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 100, 100));
    let heights = g.evaluate(n, &grid, &Cancel::default()).unwrap();
    let level = heights.samples().iter().filter(|h| **h == 30.0).count();
    // 80 m by 80 m in samples of 2 m.
    assert!((1500..1700).contains(&level), "{level}");
    assert_eq!(heights.samples()[50 * 100 + 50], 30.0);
}

#[test]
fn what_follows_another_list_is_reached_as_a_new_one_is() {
    let frame = alps();
    let mut dice = Dice(7);
    let mut pad = || {
        let (x, y) = (dice.within(-3000.0, 3000.0), dice.within(-3000.0, 3000.0));
        let height_m = dice.within(0.0, 20.0);
        place(square(&frame, x, y, 20.0, Surface::Platform { height_m }))
    };
    let name = |node: &Earthwork, grid: &Grid| {
        let mut id = IdHasher::default();
        node.identify(grid, &mut id);
        id.finish()
    };
    let mut list: Vec<_> = (0..150).map(|_| pad()).collect();
    let mut node = Earthwork::new(Planet::EARTH, list.clone());
    for step in 0..24 {
        match step % 8 {
            0 => list.truncate(list.len() - 1),
            1 => list.push(pad()),
            2 => list.iter_mut().take(80).for_each(|e| *e = pad()),
            3 => drop(list.remove(step)),
            4 => list.insert(step, pad()),
            5 => list[10..60].rotate_left(step),
            _ => list[step * 3] = pad(),
        }
        assert!(!node.is_of(Planet::EARTH, &list));
        node = node.following(Planet::EARTH, list.clone());
        assert!(node.is_of(Planet::EARTH, &list));
        let fresh = Earthwork::new(Planet::EARTH, list.clone());
        for n in 12..16 {
            let level = LevelKey::new(n, n);
            let middle = level.sample_from_map(frame.origin()).as_i64vec2();
            let rect = SampleRect::at(middle.x - 20, middle.y - 30, 40, 60);
            let grid = Grid::new(Arc::new(level.lattice()), rect);
            assert_eq!(node.touching(&grid), fresh.touching(&grid));
            assert_eq!(name(&node, &grid), name(&fresh, &grid));
        }
    }
}
