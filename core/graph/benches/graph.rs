//! Names and tiles of a chain of ten nodes, on one thread: `cargo bench -p relievo-graph --bench graph`.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo_graph::nodes::{Adjust, AdjustParams, Noise, NoiseParams, Stop, Tint};
use relievo_graph::{Graph, GraphBuilder, NodeIndex};
use relievo_planet::{LevelKey, Planet, TileKey};
use relievo_raster::{Cancel, SampleType, Tile};

/// Noise, cut; a tint and `adjusts` of its colours, cut.
fn chain(adjusts: usize, to: SampleType) -> (Graph, NodeIndex, NodeIndex) {
    let noise = NoiseParams {
        seed: 1,
        amplitude_m: 100.0,
        wavelength_m: 1e6,
        octaves: 1,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: false,
    };
    let mut b = GraphBuilder::default();
    let heights = b.add(Arc::new(Noise::new(Planet::EARTH, &noise)), &[]);
    b.cut(heights, SampleType::Height);
    let stops = [0.0, 100.0].map(|height_m| Stop {
        height_m,
        rgba: [height_m / 100.0, 0.5, 0.2, 1.0],
    });
    let mut last = b.add(
        Arc::new(Tint::new(&stops, true).expect("two stops")),
        &[heights],
    );
    for i in 0..adjusts {
        let node = Adjust::new(&AdjustParams {
            brightness: 0.01 + i as f64 * 0.01,
            ..AdjustParams::default()
        });
        last = b.add(Arc::new(node), &[last]);
    }
    b.cut(last, to);
    (b.build(), heights, last)
}

fn graph(c: &mut Criterion) {
    let key = TileKey::new(LevelKey::new(8, 7), 100, 50).expect("inside");
    let (names, _, last) = chain(8, SampleType::Rgba8);
    c.bench_function("content id of 10 nodes", |b| {
        b.iter(|| names.content_id(last, black_box(key)));
    });
    let cases = [
        (0, SampleType::Rgba8, "a tile of a tint"),
        (8, SampleType::Rgba8, "a tile of a tint and 8 adjusts"),
        (0, SampleType::Rgba32F, "an exact tile of a tint"),
        (
            8,
            SampleType::Rgba32F,
            "an exact tile of a tint and 8 adjusts",
        ),
    ];
    for (adjusts, to, name) in cases {
        let (graph, heights, last) = chain(adjusts, to);
        let none = |_, _| -> Arc<Tile> { unreachable!("noise reads nothing") };
        let tile = graph
            .make(heights, key, &none, &Cancel::default())
            .expect("no errors");
        let tile = Arc::new(tile);
        c.bench_function(name, |b| {
            b.iter(|| {
                graph
                    .make(
                        last,
                        black_box(key),
                        &|_, _| Arc::clone(&tile),
                        &Cancel::default(),
                    )
                    .expect("no errors")
            });
        });
    }
}

criterion_group!(benches, graph);
criterion_main!(benches);
