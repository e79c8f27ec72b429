use relievo_graph::GraphBuilder;
use relievo_graph::nodes::{Noise, NoiseParams};
use relievo_planet::{LevelKey, MapPoint, Planet};
use relievo_raster::{SampleType, Tile};

use super::*;
use crate::disk::Loaded;

/// A disk that says it has everything and does not answer until it is told to.
#[derive(Default)]
struct Stuck {
    answers: Mutex<bool>,
    told: Condvar,
    asked: Mutex<Vec<ContentId>>,
}

impl Stuck {
    fn answer(&self) {
        *self.answers.lock() = true;
        self.told.notify_all();
    }

    fn wait(&self) {
        let mut answers = self.answers.lock();
        while !*answers {
            self.told.wait(&mut answers);
        }
    }
}

impl Shelf for Stuck {
    fn list(&self) {}
    fn may_have(&self, _: ContentId) -> bool {
        true
    }
    fn load(&self, id: ContentId) -> Option<Loaded> {
        self.asked.lock().push(id);
        self.wait();
        None
    }
    fn save(&self, _: ContentId, _: &Tile, _: Duration) -> bool {
        self.wait();
        false
    }
}

fn wants() -> Vec<Want> {
    let mut b = GraphBuilder::default();
    let node = b.add(
        Arc::new(Noise::new(
            Planet::EARTH,
            &NoiseParams {
                seed: 7,
                amplitude_m: 800.0,
                wavelength_m: 2.0e6,
                octaves: 2,
                lacunarity: 2.0,
                gain: 0.5,
                ridged: false,
            },
        )),
        &[],
    );
    b.cut(node, SampleType::Height);
    let graph = Arc::new(b.build());
    let level = LevelKey::new(4, 4);
    let keys = (0..6).filter_map(|column| TileKey::new(level, column, 5));
    keys.map(|key| Want {
        graph: Arc::clone(&graph),
        node,
        key,
        id: graph.content_id(node, key),
    })
    .collect()
}

#[test]
fn a_disk_that_does_not_answer_holds_up_neither_workers_nor_closing() {
    let shelf = Arc::new(Stuck::default());
    let options = TilesOptions {
        threads: 1,
        log: true,
        ..TilesOptions::default()
    };
    let disk = Arc::clone(&shelf) as Arc<dyn Shelf>;
    let tiles = Tiles::with_shelf(options, Some((disk, Duration::ZERO, Duration::ZERO))).unwrap();
    let wants = wants();
    let mut names: Vec<_> = wants.iter().map(|w| w.id).collect();
    tiles.want(wants, MapPoint::new(0.0, 1.5));
    let mut finished = Vec::new();
    while finished.len() < names.len() {
        assert!(
            !tiles.wait(Duration::from_mins(1)) || !tiles.shared.state.lock().finished.is_empty()
        );
        finished.extend(tiles.take_finished().into_iter().map(|f| f.id));
    }
    assert_eq!(finished.len(), names.len(), "each once");
    // Those that are being read are given up a moment later than those that wait for their turn, which
    // are made in the order of wants.
    let reading = shelf.asked.lock().clone();
    assert!(!reading.is_empty() && names.iter().all(|name| finished.contains(name)));
    finished.retain(|name| !reading.contains(name));
    names.retain(|name| !reading.contains(name));
    assert_eq!(finished, names);
    drop(tiles);
    shelf.answer();
}

#[test]
fn a_tile_that_is_not_there_is_made_in_its_place_in_the_order() {
    let shelf = Arc::new(Stuck::default());
    shelf.answer();
    let options = TilesOptions {
        threads: 2,
        log: true,
        ..TilesOptions::default()
    };
    let tiles = Tiles::with_shelf(
        options,
        Some((shelf, Duration::from_hours(1), Duration::ZERO)),
    )
    .unwrap();
    let wants = wants();
    let names: std::collections::BTreeSet<_> = wants.iter().map(|w| w.id).collect();
    tiles.want(wants, MapPoint::new(0.0, 1.5));
    while !tiles.wait(Duration::from_mins(1)) {}
    // The last of them may have come between the last two looks.
    let finished: Vec<_> = tiles.take_finished().into_iter().map(|f| f.id).collect();
    assert_eq!(tiles.take_log().len(), names.len());
    assert_eq!(finished.len(), names.len());
    assert_eq!(
        finished
            .into_iter()
            .collect::<std::collections::BTreeSet<_>>(),
        names
    );
}
