//! Time of the graph's work on one thread, per tile: names, adjusting, normals, noise, overlays.
//!
//! `cargo run --release -p relievo-graph --example timings`

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use relievo_graph::nodes::{
    Adjust, AdjustParams, BlendMode, Noise, NoiseParams, Normals, Overlay, Stop, Tint,
};
use relievo_graph::{GraphBuilder, ImageNode, Job};
use relievo_planet::{LevelKey, Planet, TileKey};
use relievo_raster::{Bands, Block, Cancel, SampleType};

#[expect(clippy::print_stdout, reason = "the example's result")]
/// Median time of a call in microseconds.
fn time_us(name: &str, mut call: impl FnMut()) {
    let mut times: Vec<f64> = (0..101)
        .map(|_| {
            let start = Instant::now();
            call();
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{name:30} {:10.1} µs, fastest {:10.1} µs",
        times[50], times[0]
    );
}

fn varied(bands: Bands, side: usize) -> Block {
    let mut block = Block::new(bands, side, side);
    for (i, v) in block.samples_mut().iter_mut().enumerate() {
        *v = (i.wrapping_mul(2_654_435_761) % 1000) as f32 / 999.0;
    }
    if bands == Bands::Colour {
        block.plane_mut(3).fill(1.0);
    }
    block
}

fn node_us(name: &str, node: &dyn ImageNode, inputs: &[&Block]) {
    let grid = TileKey::new(LevelKey::new(8, 7), 100, 50)
        .expect("inside")
        .grid();
    let mut out = Block::new(node.output(), 256, 256);
    let cancel = Cancel::default();
    time_us(name, || {
        node.render(
            &Job {
                grid: &grid,
                cancel: &cancel,
            },
            black_box(inputs),
            &mut out,
        )
        .expect("no errors");
        black_box(&out);
    });
}

fn main() {
    let colours = varied(Bands::Colour, 256);
    let adjust = |change: fn(&mut AdjustParams)| {
        let mut params = AdjustParams::default();
        change(&mut params);
        Adjust::new(&params)
    };
    node_us(
        "adjust without gamma",
        &adjust(|p| p.hue_deg = 20.0),
        &[&colours],
    );
    let all = |p: &mut AdjustParams| {
        (p.brightness, p.contrast, p.hue_deg, p.saturation, p.gamma) = (1.1, 1.2, 20.0, 0.8, 1.3);
    };
    node_us("adjust with gamma", &adjust(all), &[&colours]);
    node_us(
        "normals",
        &Normals::new(Planet::EARTH, 1.0),
        &[&varied(Bands::Height, 258)],
    );
    node_us(
        "overlay half",
        &Overlay::new(BlendMode::Normal, 0.5, false),
        &[&colours, &colours],
    );
    node_us(
        "overlay opaque",
        &Overlay::new(BlendMode::Normal, 1.0, false),
        &[&colours, &colours],
    );
    let params = NoiseParams {
        seed: 1,
        amplitude_m: 100.0,
        wavelength_m: 1e6,
        octaves: 1,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: false,
    };
    let noise = Noise::new(Planet::EARTH, &params);
    node_us("noise, an octave", &noise, &[]);

    let mut b = GraphBuilder::default();
    let heights = b.add(Arc::new(noise), &[]);
    b.cut(heights, SampleType::Height);
    let stops = [0.0, 100.0].map(|height_m| Stop {
        height_m,
        rgba: [height_m / 100.0, 0.5, 0.2, 1.0],
    });
    let mut last = b.add(
        Arc::new(Tint::new(&stops, true).expect("two stops")),
        &[heights],
    );
    for i in 0..8 {
        let brightness = 1.01 + f64::from(i) * 0.01;
        let node = Adjust::new(&AdjustParams {
            brightness,
            ..AdjustParams::default()
        });
        last = b.add(Arc::new(node), &[last]);
    }
    b.cut(last, SampleType::Rgba8);
    let graph = b.build();
    let key = TileKey::new(LevelKey::new(8, 7), 100, 50).expect("inside");
    time_us("content id of 10 nodes", || {
        black_box(graph.content_id(last, key));
    });
    let tile = Arc::new(
        graph
            .make(heights, key, &|_, _| unreachable!(), &Cancel::default())
            .expect("no errors"),
    );
    time_us("a tile of 9 nodes", || {
        black_box(
            graph
                .make(last, key, &|_, _| Arc::clone(&tile), &Cancel::default())
                .expect("no errors"),
        );
    });
}
