//! What is not visible costs nothing: images far larger than memory, and layers without effect.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::time::Duration;

use relievo_engine::graph::ContentId;
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, View};

/// Side of a stored tile.
const TILE: u64 = 2048;

/// A `BigTIFF` of `side`² grey samples with all its overviews, which leaves out every tile but the one
/// in the middle of the full image.
fn write_sparse(path: &Path, side: u64) {
    let sides: Vec<u64> =
        std::iter::successors(Some(side), |s| (*s > TILE).then(|| s.div_ceil(2))).collect();
    let mut file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let tile_at = 16_u64;
    let mut at = tile_at + TILE * TILE;
    let mut header = b"II".to_vec();
    for word in [43_u16, 8, 0] {
        header.extend(word.to_le_bytes());
    }
    header.extend(at.to_le_bytes());
    file.write_all(&header).unwrap();
    for y in 0..TILE {
        let row: Vec<u8> = (0..TILE).map(|x| 100 + ((x ^ y) % 50) as u8).collect();
        file.write_all(&row).unwrap();
    }
    for (i, side) in sides.iter().enumerate() {
        let across = side.div_ceil(TILE);
        let count = across * across;
        let entries = 11_u64;
        let offsets_at = at + 8 + entries * 20 + 8;
        let sizes_at = offsets_at + 8 * count;
        let end = sizes_at + 8 * count;
        let next = if i + 1 < sides.len() { end } else { 0 };
        let list = |at: u64, only: u64| if count == 1 { only } else { at };
        let middle = (across / 2) * across + across / 2;
        let has_tile = i == 0;
        let mut bytes = entries.to_le_bytes().to_vec();
        let mut entry = |tag: u16, kind: u16, count: u64, value: u64| {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(count.to_le_bytes());
            bytes.extend(value.to_le_bytes());
        };
        entry(254, 4, 1, u64::from(i > 0)); // a reduced image
        entry(256, 4, 1, *side);
        entry(257, 4, 1, *side);
        entry(258, 3, 1, 8); // bits
        entry(259, 3, 1, 1); // not compressed
        entry(262, 3, 1, 1); // grey
        entry(277, 3, 1, 1);
        entry(322, 4, 1, TILE);
        entry(323, 4, 1, TILE);
        entry(324, 16, count, list(offsets_at, 0));
        entry(325, 16, count, list(sizes_at, 0));
        bytes.extend(next.to_le_bytes());
        for (there, value) in [(has_tile, tile_at), (has_tile, TILE * TILE)] {
            for n in 0..count {
                bytes.extend(if there && n == middle { value } else { 0 }.to_le_bytes());
            }
        }
        file.write_all(&bytes).unwrap();
        at = end;
    }
    file.flush().unwrap();
}

fn open(folder: &Path, layers: &str) -> Engine {
    let path = folder.join("project.relievo");
    let text =
        format!(r#"{{"version": 1, "planet": {{"preset": "earth"}}, "layers": [{layers}]}}"#);
    std::fs::write(&path, text).unwrap();
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let (mut engine, _) = Engine::open(&path, options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine
}

fn converge(engine: &mut Engine, altitude_m: f64) {
    engine.set_view(View {
        camera: Camera::from_degrees(5.0, 45.0, altitude_m, 0.0, -70.0, 60.0).unwrap(),
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    for _ in 0..3000 {
        if engine.drain(f32::INFINITY).unwrap().is_converged() {
            return;
        }
        engine.wait(Duration::from_millis(50));
    }
    panic!("does not converge: {:?}", engine.stats());
}

#[test]
fn an_image_of_a_million_by_a_million_samples_costs_what_is_seen_of_it() {
    let folder = tempfile::tempdir().unwrap();
    write_sparse(&folder.path().join("huge.tif"), 1_000_000);
    let layer = r#"{"id": "huge", "name": "huge", "kind": "imagery", "path": "huge.tif",
        "georeference": {"crs": "EPSG:4326", "west": 0, "south": 40, "east": 10, "north": 50}}"#;
    let mut engine = open(folder.path(), layer);
    for altitude_m in [2e7, 1e5, 500.0] {
        converge(&mut engine, altitude_m);
        let stats = engine.stats().tiles;
        assert!(
            stats.made < 400 && stats.failed == 0,
            "{altitude_m} m: {stats:?}"
        );
    }
    let colour_at = |lon: f64, lat: f64| {
        let point = MapPoint::from_degrees(lon, lat);
        let answer = engine.questions().place(point, &Cancel::default()).unwrap();
        answer.colour.unwrap()
    };
    let inside = colour_at(5.001, 44.995);
    assert!(
        inside[3] == 255 && (95..=155).contains(&inside[0]),
        "{inside:?}"
    );
    assert_eq!(colour_at(2.0, 48.0)[3], 0, "left out of the file");
}

#[test]
fn fifty_layers_without_effect_are_no_layers_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let noise = |id: &str, more: &str| {
        format!(
            r#"{{"id": "{id}", "name": "n", "kind": "noise", "amplitude_m": 900,
                "wavelength_m": 300000, "octaves": 3{more}}}"#
        )
    };
    let tint = |id: &str, more: &str| {
        format!(
            r##"{{"id": "{id}", "name": "t", "kind": "tint", "stops": [
                {{"height_m": -900, "colour": "#204060"}},
                {{"height_m": 900, "colour": "#e0d0c0"}}]{more}}}"##
        )
    };
    let mut layers = vec![noise("ground", ""), tint("colour", "")];
    let made = |layers: &[String]| -> BTreeSet<ContentId> {
        let mut engine = open(folder.path(), &layers.join(","));
        converge(&mut engine, 1e5);
        engine.take_log().iter().map(|e| e.id).collect()
    };
    let without = made(&layers);
    for n in 0..25 {
        let hidden = r#", "visible": false"#;
        let clear = r#", "opacity": 0"#;
        layers.insert(
            n % 3,
            noise(&format!("n{n}"), if n % 2 == 0 { hidden } else { clear }),
        );
        layers.push(tint(
            &format!("t{n}"),
            if n % 2 == 0 { clear } else { hidden },
        ));
    }
    assert_eq!(made(&layers), without, "the same names of the same tiles");
    assert!(!without.is_empty());
}
