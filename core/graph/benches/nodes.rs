//! A 256² tile of each node, on one thread: `cargo bench -p relievo-graph --bench nodes`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo_graph::nodes::{
    Adjust, AdjustParams, BlendMode, Noise, NoiseParams, Normals, Overlay, OverlayHeights, Stop,
    Tint,
};
use relievo_graph::{ImageNode, Job};
use relievo_planet::{LevelKey, Planet, TileKey};
use relievo_raster::{Bands, Block, Cancel};

/// Values 0 to 1 without any order; colours are opaque.
fn varied(bands: Bands, side: usize, factor: f32) -> Block {
    let mut block = Block::new(bands, side, side);
    for (i, v) in block.samples_mut().iter_mut().enumerate() {
        *v = (i.wrapping_mul(2_654_435_761) % 1000) as f32 / 999.0 * factor;
    }
    if bands == Bands::Colour {
        block.plane_mut(3).fill(1.0);
    }
    block
}

fn node(c: &mut Criterion, name: &str, node: &dyn ImageNode, inputs: &[&Block]) {
    let grid = TileKey::new(LevelKey::new(8, 7), 100, 50)
        .expect("inside")
        .grid();
    let mut out = Block::new(node.output(), 256, 256);
    let cancel = Cancel::default();
    c.bench_function(name, |b| {
        b.iter(|| {
            let job = Job {
                grid: &grid,
                cancel: &cancel,
            };
            node.render(&job, black_box(inputs), &mut out)
                .expect("no errors");
            black_box(&mut out);
        });
    });
}

fn colours(c: &mut Criterion) {
    let opaque = varied(Bands::Colour, 256, 1.0);
    let mut partial = opaque.clone();
    for (i, a) in partial.plane_mut(3).iter_mut().enumerate() {
        *a = 0.05 + (i % 19) as f32 * 0.05;
    }
    let adjust = |change: fn(&mut AdjustParams)| {
        let mut params = AdjustParams::default();
        change(&mut params);
        Adjust::new(&params)
    };
    node(
        c,
        "adjust without gamma",
        &adjust(|p| p.hue_deg = 20.0),
        &[&opaque],
    );
    let all = |p: &mut AdjustParams| {
        (p.brightness, p.contrast, p.hue_deg, p.saturation, p.gamma) = (1.1, 1.2, 20.0, 0.8, 1.3);
    };
    node(c, "adjust with gamma", &adjust(all), &[&opaque]);
    let over = |mode, opacity| Overlay::new(mode, opacity, false);
    node(
        c,
        "overlay, partial alpha",
        &over(BlendMode::Normal, 1.0),
        &[&opaque, &partial],
    );
    node(
        c,
        "overlay, both partial",
        &over(BlendMode::Normal, 0.9),
        &[&partial, &partial],
    );
    node(
        c,
        "overlay, screen, partial alpha",
        &over(BlendMode::Screen, 1.0),
        &[&opaque, &partial],
    );
    node(
        c,
        "overlay, opaque",
        &over(BlendMode::Normal, 1.0),
        &[&opaque, &opaque],
    );
}

fn heights(c: &mut Criterion) {
    node(
        c,
        "normals",
        &Normals::new(Planet::EARTH, 1.0),
        &[&varied(Bands::Height, 258, 1000.0)],
    );
    let low = varied(Bands::Height, 256, 1000.0);
    let mut holes = low.clone();
    for v in holes.samples_mut().iter_mut().step_by(7) {
        *v = f32::NAN;
    }
    node(
        c,
        "overlay heights",
        &OverlayHeights::new(0.5, false),
        &[&low, &holes],
    );
    let stops = [0.0, 150.0, 320.0, 500.0, 640.0, 810.0, 990.0].map(|height_m| Stop {
        height_m,
        rgba: [height_m / 1000.0, 0.5, 1.0 - height_m / 1000.0, 1.0],
    });
    let tint = Tint::new(&stops, true).expect("seven stops");
    node(c, "tint of seven stops, any order", &tint, &[&low]);
    let mut smooth = low.clone();
    for (i, v) in smooth.samples_mut().iter_mut().enumerate() {
        *v = 400.0 + (i % 256) as f32 * 0.7 + (i / 256) as f32;
    }
    node(c, "tint of seven stops, a slope", &tint, &[&smooth]);
    for octaves in [1, 4] {
        let params = NoiseParams {
            seed: 1,
            amplitude_m: 100.0,
            wavelength_m: 1e6,
            octaves,
            lacunarity: 2.0,
            gain: 0.5,
            ridged: false,
        };
        node(
            c,
            &format!("noise, octaves: {octaves}"),
            &Noise::new(Planet::EARTH, &params),
            &[],
        );
    }
}

criterion_group!(benches, colours, heights);
criterion_main!(benches);
