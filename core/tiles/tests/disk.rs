//! The cache on disk, from outside: what a second run makes, and what no disk can do to the picture.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::nodes::{
    Adjust, AdjustParams, BlendMode, Noise, NoiseParams, Overlay, Stop, Tint,
};
use relievo_graph::{Graph, GraphBuilder, NodeIndex};
use relievo_planet::{LevelKey, MapPoint, Planet, TileKey};
use relievo_raster::SampleType;
use relievo_tiles::{DiskOptions, Finished, TileState, Tiles, TilesOptions, Want};

/// Noise, its tint, and the tint adjusted.
fn graph(gamma: f64) -> (Arc<Graph>, NodeIndex) {
    let mut b = GraphBuilder::default();
    let params = NoiseParams {
        seed: 7,
        amplitude_m: 800.0,
        wavelength_m: 2.0e6,
        octaves: 2,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: false,
    };
    let noise = b.add(Arc::new(Noise::new(Planet::EARTH, &params)), &[]);
    b.cut(noise, SampleType::Height);
    let stop = |height_m, v| Stop {
        height_m,
        rgba: [v, 0.5, 1.0 - v, 1.0],
    };
    let tint = Tint::new(&[stop(-500.0, 0.1), stop(500.0, 0.9)], true).unwrap();
    let tint = b.add(Arc::new(tint), &[noise]);
    let params = AdjustParams {
        gamma,
        ..AdjustParams::default()
    };
    let adjusted = b.add(Arc::new(Adjust::new(&params)), &[tint]);
    let root = b.add(
        Arc::new(Overlay::new(BlendMode::Normal, 0.5, false)),
        &[tint, adjusted],
    );
    b.cut(root, SampleType::Rgba8);
    (Arc::new(b.build()), root)
}

fn tiles_with(disk: Option<DiskOptions>, memory: usize) -> Tiles {
    Tiles::new(TilesOptions {
        threads: 2,
        log: true,
        memory,
        disk,
        ..TilesOptions::default()
    })
    .unwrap()
}

fn on_disk(folder: &Path) -> Tiles {
    let disk = DiskOptions {
        dear: Duration::ZERO,
        ..DiskOptions::new(folder.to_owned())
    };
    tiles_with(Some(disk), 1 << 28)
}

fn keys() -> Vec<TileKey> {
    let level = LevelKey::new(5, 4);
    (0..12)
        .map(|c| TileKey::new(level, c, 7).unwrap())
        .collect()
}

fn wants(graph: &Arc<Graph>, node: NodeIndex) -> Vec<Want> {
    keys()
        .iter()
        .map(|key| Want {
            graph: Arc::clone(graph),
            node,
            key: *key,
            id: graph.content_id(node, *key),
        })
        .collect()
}

fn make(tiles: &Tiles, wants: Vec<Want>) -> Vec<Finished> {
    tiles.want(wants, MapPoint::new(0.0, 1.5));
    let mut all = Vec::new();
    loop {
        let idle = tiles.wait(Duration::from_secs(20));
        all.extend(tiles.take_finished());
        if idle {
            all.sort_by_key(|d| d.id);
            return all;
        }
    }
}

fn bytes(done: &[Finished]) -> Vec<Vec<u8>> {
    done.iter()
        .map(|d| match &d.state {
            TileState::Ready(tile) => tile.bytes().unwrap().to_vec(),
            TileState::Failed(error) => panic!("{error}"),
        })
        .collect()
}

fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.push(path);
        }
    }
    all.sort();
    all
}

#[test]
fn a_second_run_reads_what_the_first_one_made() {
    let dir = tempfile::tempdir().unwrap();
    let (graph, root) = graph(2.0);
    let first = {
        let tiles = on_disk(dir.path());
        let done = make(&tiles, wants(&graph, root));
        assert_eq!(tiles.take_log().len(), 24, "noise and colours");
        bytes(&done)
    };
    let tiles = on_disk(dir.path());
    let again = make(&tiles, wants(&graph, root));
    assert_eq!(bytes(&again), first);
    assert_eq!(tiles.take_log(), [], "not even what the colours read");
    assert_eq!(tiles.stats().loaded, 12);
    // Another program's edit reads the noise, which lies there, too.
    let (edited, root) = self::graph(2.1);
    make(&tiles, wants(&edited, root));
    let log = tiles.take_log();
    assert!(
        log.len() == 12 && log.iter().all(|e| e.kind == "overlay"),
        "{log:?}"
    );
}

#[test]
fn damage_on_disk_is_made_again_and_never_shown() {
    let dir = tempfile::tempdir().unwrap();
    let (graph, root) = graph(2.0);
    let first = bytes(&make(&on_disk(dir.path()), wants(&graph, root)));
    for (i, path) in files(dir.path()).iter().enumerate() {
        let mut content = std::fs::read(path).unwrap();
        match i % 3 {
            0 => content.truncate(i * 10),
            1 => content[100 + i * 999] ^= 0x10,
            _ => {}
        }
        std::fs::write(path, content).unwrap();
    }
    {
        let tiles = on_disk(dir.path());
        assert_eq!(bytes(&make(&tiles, wants(&graph, root))), first);
        let stats = tiles.stats();
        assert!(stats.made > 0 && stats.loaded > 0, "{stats:?}");
    }
    let tiles = on_disk(dir.path());
    assert_eq!(bytes(&make(&tiles, wants(&graph, root))), first);
    assert_eq!(tiles.take_log(), [], "mended");
}

#[test]
fn a_folder_that_cannot_be_used_changes_nothing_but_time() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    std::fs::write(&file, "in the way").unwrap();
    let (graph, root) = graph(2.0);
    let without = bytes(&make(&tiles_with(None, 1 << 28), wants(&graph, root)));
    let tiles = on_disk(&file);
    assert_eq!(bytes(&make(&tiles, wants(&graph, root))), without);
    assert_eq!(tiles.stats().stored, 0);
}

#[test]
fn what_is_cheap_is_not_stored_and_a_drag_stores_its_last_state_only() {
    let dir = tempfile::tempdir().unwrap();
    let disk = DiskOptions {
        dear: Duration::from_hours(1),
        ..DiskOptions::new(dir.path().join("cheap"))
    };
    std::fs::create_dir(&disk.folder).unwrap();
    let folder = disk.folder.clone();
    let (still, root) = graph(2.0);
    make(&tiles_with(Some(disk), 1 << 28), wants(&still, root));
    assert_eq!(files(&folder), Vec::<std::path::PathBuf>::new());

    let folder = dir.path().join("drag");
    {
        let disk = DiskOptions {
            dear: Duration::ZERO,
            calm: Duration::from_hours(1),
            ..DiskOptions::new(folder.clone())
        };
        let tiles = tiles_with(Some(disk), 1 << 28);
        for step in 0..6 {
            let (dragged, root) = graph(1.0 + f64::from(step) / 10.0);
            make(&tiles, wants(&dragged, root));
        }
    }
    assert_eq!(
        files(&folder).len(),
        24,
        "the noise, which all states share, and the last colours"
    );
}

#[test]
fn what_waits_to_be_written_keeps_no_memory() {
    let dir = tempfile::tempdir().unwrap();
    let (graph, root) = graph(2.0);
    let disk = DiskOptions {
        dear: Duration::ZERO,
        ..DiskOptions::new(dir.path().to_owned())
    };
    let tiles = tiles_with(Some(disk), 600_000);
    make(&tiles, wants(&graph, root));
    assert!(tiles.stats().cache_bytes <= 600_000);
    drop(tiles);
    assert!(
        files(dir.path()).len() < 24,
        "what has left memory is not written"
    );
}
