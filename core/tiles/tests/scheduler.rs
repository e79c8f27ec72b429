//! The scheduler, tested on its log: what was made, in which order, and how often.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::nodes::{Adjust, AdjustParams, BlendMode, Constant, Overlay};
use relievo_graph::{Graph, GraphBuilder, IdHasher, ImageNode, Job, NodeIndex, RenderError};
use relievo_planet::{Grid, LevelKey, MapPoint, TileKey};
use relievo_raster::{Bands, Block, SampleType};
use relievo_tiles::{LogEntry, TileState, Tiles, TilesOptions, Want};

/// A source whose samples depend on position; may fail or panic on one column of tiles.
struct Ramp {
    slope: f32,
    fails_from_column: i64,
    panics: bool,
}

impl ImageNode for Ramp {
    fn kind(&self) -> &'static str {
        "ramp"
    }
    fn output(&self) -> Bands {
        Bands::Colour
    }
    fn is_pointwise(&self) -> bool {
        true
    }
    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.float(f64::from(self.slope))
            .int(grid.rect.min.x)
            .int(grid.rect.min.y);
    }
    fn render(&self, job: &Job, _: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let rect = job.grid.rect;
        if rect.min.x >= self.fails_from_column {
            assert!(!self.panics, "a bug in a node");
            return Err(RenderError::Node {
                node: "ramp",
                reason: "no data here".to_owned(),
            });
        }
        let (w, h) = (rect.width(), rect.height());
        for plane in 0..4 {
            let samples = out.plane_mut(plane);
            for (i, s) in samples.iter_mut().enumerate() {
                let (x, y) = (rect.min.x + i as i64 % w, rect.min.y + i as i64 / w);
                *s = if plane == 3 {
                    1.0
                } else {
                    ((x + 3 * y) % 1000) as f32 * self.slope
                };
            }
        }
        assert_eq!(out.height() as i64, h);
        Ok(())
    }
}

/// Two sources, each cut; the upper one adjusted; blended.
fn graph(upper: f32, gamma: f64) -> (Arc<Graph>, NodeIndex) {
    graph_with(
        Ramp {
            slope: upper,
            fails_from_column: i64::MAX,
            panics: false,
        },
        gamma,
    )
}

fn graph_with(upper: Ramp, gamma: f64) -> (Arc<Graph>, NodeIndex) {
    let mut b = GraphBuilder::default();
    let lower = b.add(
        Arc::new(Ramp {
            slope: 1e-3,
            fails_from_column: i64::MAX,
            panics: false,
        }),
        &[],
    );
    b.cut(lower, SampleType::Rgba8);
    let upper = b.add(Arc::new(upper), &[]);
    b.cut(upper, SampleType::Rgba8);
    let adjusted = b.add(
        Arc::new(Adjust::new(&AdjustParams {
            gamma,
            ..AdjustParams::default()
        })),
        &[upper],
    );
    let root = b.add(
        Arc::new(Overlay::new(BlendMode::Normal, 0.5, false)),
        &[lower, adjusted],
    );
    b.cut(root, SampleType::Rgba8);
    (Arc::new(b.build()), root)
}

fn tiles(threads: usize) -> Tiles {
    Tiles::new(TilesOptions {
        threads,
        log: true,
        ..TilesOptions::default()
    })
    .unwrap()
}

fn keys() -> Vec<TileKey> {
    let level = LevelKey::new(3, 2);
    (0..4)
        .flat_map(|row| (0..4).map(move |c| TileKey::new(level, c, row).unwrap()))
        .collect()
}

fn wants(graph: &Arc<Graph>, node: NodeIndex, keys: &[TileKey]) -> Vec<Want> {
    keys.iter()
        .map(|key| Want {
            graph: Arc::clone(graph),
            node,
            key: *key,
            id: graph.content_id(node, *key),
        })
        .collect()
}

/// Asks and waits; gives what finished.
fn make(tiles: &Tiles, wants: Vec<Want>) -> Vec<relievo_tiles::Finished> {
    tiles.want(wants, MapPoint::new(0.0, 1.5));
    let mut all = Vec::new();
    loop {
        let idle = tiles.wait(Duration::from_secs(20));
        all.extend(tiles.take_finished());
        if idle {
            return all;
        }
    }
}

fn kinds(log: &[LogEntry]) -> Vec<(&'static str, String)> {
    let mut made: Vec<_> = log.iter().map(|e| (e.kind, e.key.to_string())).collect();
    made.sort();
    made
}

#[test]
fn everything_wanted_is_made_once_with_what_it_reads() {
    let tiles = tiles(2);
    let (graph, root) = graph(5e-4, 2.0);
    let mut asked = wants(&graph, root, &keys());
    asked.extend(asked.clone());
    let done = make(&tiles, asked);
    assert_eq!(done.len(), 16);
    let log = tiles.take_log();
    assert_eq!(
        log.len(),
        48,
        "two sources and their blend for each of 16 tiles"
    );
    let ids: HashSet<_> = log.iter().map(|e| e.id).collect();
    assert_eq!(ids.len(), 48, "nothing is made twice");
}

#[test]
fn a_slider_makes_again_only_the_blend_and_undo_makes_nothing() {
    let tiles = tiles(2);
    let (before, root) = graph(5e-4, 2.0);
    make(&tiles, wants(&before, root, &keys()));
    tiles.take_log();

    let (after, root) = graph(5e-4, 2.1);
    make(&tiles, wants(&after, root, &keys()[..6]));
    let made = kinds(&tiles.take_log());
    assert_eq!(made.len(), 6);
    assert!(made.iter().all(|(kind, _)| *kind == "overlay"), "{made:?}");

    let done = make(&tiles, wants(&before, root, &keys()));
    assert_eq!(done.len(), 16, "what the cache has is told, too");
    assert_eq!(tiles.take_log(), []);
}

#[test]
fn inputs_come_before_what_reads_them_and_wants_keep_their_order() {
    let tiles = tiles(1);
    let (graph, root) = graph(5e-4, 2.0);
    make(&tiles, wants(&graph, root, &keys()));
    let blends: Vec<_> = tiles
        .take_log()
        .iter()
        .filter(|e| e.node == root)
        .map(|e| e.key)
        .collect();
    assert_eq!(blends, keys());
}

#[test]
fn a_failure_reaches_those_who_read_it_and_nobody_else() {
    let tiles = tiles(2);
    let (graph, root) = graph_with(
        Ramp {
            slope: 2e-3,
            fails_from_column: 512,
            panics: false,
        },
        2.0,
    );
    let done = make(&tiles, wants(&graph, root, &keys()));
    assert_eq!(done.len(), 16);
    let failed = done
        .iter()
        .filter(|d| matches!(d.state, TileState::Failed(_)))
        .count();
    assert_eq!(failed, 8);
    tiles.take_log();
    make(&tiles, wants(&graph, root, &keys()));
    assert_eq!(tiles.take_log(), [], "a failure is kept, not tried again");
    tiles.forget_failures();
    make(&tiles, wants(&graph, root, &keys()));
    assert!(!tiles.take_log().is_empty());
}

#[test]
fn a_panic_in_a_node_is_a_failed_tile_and_the_workers_live_on() {
    let tiles = tiles(1);
    let (graph, root) = graph_with(
        Ramp {
            slope: 2e-3,
            fails_from_column: 512,
            panics: true,
        },
        2.0,
    );
    let done = make(&tiles, wants(&graph, root, &keys()));
    let failed = done
        .iter()
        .filter(|d| matches!(d.state, TileState::Failed(_)))
        .count();
    assert_eq!((done.len(), failed), (16, 8));
}

#[test]
fn wants_that_change_drop_what_nobody_asks_for_any_more() {
    let tiles = tiles(1);
    let (graph, root) = graph(5e-4, 2.0);
    for chunk in keys().chunks(2) {
        tiles.want(wants(&graph, root, chunk), MapPoint::new(0.0, 1.5));
    }
    let last = wants(&graph, root, &keys()[14..]);
    let names: HashSet<_> = last.iter().map(|w| w.id).collect();
    make(&tiles, last);
    assert!(names.iter().all(|id| tiles.get(*id).is_some()));
    assert_eq!(tiles.stats().pending, 0);
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let bytes = |threads| {
        let tiles = tiles(threads);
        let (graph, root) = graph(5e-4, 1.7);
        let mut done = make(&tiles, wants(&graph, root, &keys()));
        done.sort_by_key(|d| d.id);
        done.into_iter()
            .map(|d| match d.state {
                TileState::Ready(t) => (d.id, t.bytes().map(<[u8]>::to_vec)),
                TileState::Failed(e) => panic!("{e}"),
            })
            .collect::<Vec<_>>()
    };
    let one = bytes(1);
    assert_eq!(one, bytes(4));
    assert_eq!(one, bytes(3));
}

#[test]
fn an_uncoloured_constant_needs_no_inputs() {
    let tiles = tiles(1);
    let mut b = GraphBuilder::default();
    let c = b.add(Arc::new(Constant::height(12.0)), &[]);
    b.cut(c, SampleType::Height);
    let graph = Arc::new(b.build());
    let done = make(&tiles, wants(&graph, c, &keys()));
    assert_eq!(done.len(), 1, "16 equal tiles are one content");
}

/// A source that answers only when the test lets it, one tile at a time.
struct Gate {
    open: Arc<(std::sync::Mutex<u32>, std::sync::Condvar)>,
    entered: Arc<std::sync::atomic::AtomicU32>,
}

impl ImageNode for Gate {
    fn kind(&self) -> &'static str {
        "gate"
    }
    fn output(&self) -> Bands {
        Bands::Height
    }
    fn is_pointwise(&self) -> bool {
        true
    }
    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.grid(grid);
    }
    fn render(&self, job: &Job, _: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        self.entered
            .fetch_add(1, std::sync::atomic::Ordering::SeqCst);
        let (tickets, came) = &*self.open;
        let mut left = tickets.lock().unwrap();
        while *left == 0 {
            left = came.wait(left).unwrap();
        }
        *left -= 1;
        out.samples_mut().fill(job.grid.rect.min.x as f32);
        out.samples_mut()[0] = -1.0;
        Ok(())
    }
}

#[test]
fn a_source_that_does_not_answer_holds_up_its_worker_and_nobody_else() {
    let open = Arc::new((std::sync::Mutex::new(0), std::sync::Condvar::new()));
    let entered = Arc::new(std::sync::atomic::AtomicU32::new(0));
    let gate = Gate {
        open: Arc::clone(&open),
        entered: Arc::clone(&entered),
    };
    let mut b = GraphBuilder::default();
    let node = b.add(Arc::new(gate), &[]);
    b.cut(node, SampleType::Height);
    let graph = Arc::new(b.build());
    // Coarse before fine, as a plan gives them.
    let tile =
        |level: u8, column| TileKey::new(LevelKey::new(level + 1, level), column, 0).unwrap();
    let keys: Vec<_> = (0..4).flat_map(|l| [tile(l, 0), tile(l, 1)]).collect();
    let tiles = tiles(1);
    tiles.want(wants(&graph, node, &keys), MapPoint::new(0.0, 1.5));
    while entered.load(std::sync::atomic::Ordering::SeqCst) == 0 {
        std::thread::yield_now();
    }
    // The only worker is inside the source. Whoever asks, looks or asks anew comes back at once; did
    // one of these wait for the source, this test would never end.
    assert!(tiles.take_finished().is_empty());
    assert!(tiles.get(graph.content_id(node, keys[0])).is_none());
    for from in [1, 0] {
        tiles.want(wants(&graph, node, &keys[from..]), MapPoint::new(0.0, 1.5));
    }
    assert!(tiles.stats().pending >= 1);
    let mut order = Vec::new();
    for _ in &keys {
        *open.0.lock().unwrap() += 1;
        open.1.notify_all();
        let before = order.len();
        while order.len() == before {
            tiles.wait(Duration::from_secs(20));
            // One that was finished when it was asked for anew is told once more.
            for done in tiles.take_finished() {
                if !order.contains(&done.id) {
                    order.push(done.id);
                }
            }
        }
    }
    let expected: Vec<_> = keys.iter().map(|k| graph.content_id(node, *k)).collect();
    assert_eq!(
        order, expected,
        "the coarse ones are there after as many answers as there are"
    );
}
