//! Fractal noise at equal octaves beside other crates, 65,536 samples on one thread:
//! `cargo bench -p relievo-graph --bench noise`.
//!
//! All of them in three dimensions at the same places: those of a tile of 256² samples. The others work on
//! single f64 (`noise`) or f32 (`fastnoise-lite`) places that are given to them; places on the sphere are
//! part of the node's own time.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};
use glam::DVec3;
use noise::{Fbm, MultiFractal as _, NoiseFn as _, Simplex, SuperSimplex};
use relievo_graph::nodes::{Noise, NoiseParams};
use relievo_graph::{ImageNode as _, Job};
use relievo_planet::{Grid, LevelKey, Planet, TileKey};
use relievo_raster::{Bands, Block, Cancel};

/// Of the first octave.
const WAVELENGTH_M: f64 = 1e6;

const OCTAVES: u32 = 8;

fn grid() -> Grid {
    let tile = TileKey::new(LevelKey::new(13, 12), 3200, 1600);
    tile.expect("inside").grid()
}

/// Places of all samples in wavelengths of the first octave.
fn places() -> Vec<DVec3> {
    let Grid { lattice, rect } = grid();
    let samples =
        (rect.min.y..rect.max.y).flat_map(|y| (rect.min.x..rect.max.x).map(move |x| (x, y)));
    let unit = |(x, y)| lattice.map_point(glam::I64Vec2::new(x, y)).to_unit();
    samples
        .map(|at| unit(at) * (Planet::EARTH.radius_m / WAVELENGTH_M))
        .collect()
}

fn ours(c: &mut Criterion) {
    let params = NoiseParams {
        seed: 1,
        amplitude_m: 100.0,
        wavelength_m: WAVELENGTH_M,
        octaves: OCTAVES,
        lacunarity: 2.0,
        gain: 0.5,
        ridged: false,
    };
    let node = Noise::new(Planet::EARTH, &params);
    let grid = grid();
    let side = grid.rect.width() as usize;
    let mut out = Block::new(Bands::Height, side, side);
    let cancel = Cancel::default();
    c.bench_function("relievo, simplex", |b| {
        b.iter(|| {
            let job = Job {
                grid: &grid,
                cancel: &cancel,
            };
            node.render(&job, &[], &mut out).expect("no errors");
            black_box(&mut out);
        });
    });
}

fn others(c: &mut Criterion) {
    let places = places();
    let mut out = vec![0.0_f64; places.len()];
    let simplex = Fbm::<Simplex>::new(1).set_octaves(OCTAVES as usize);
    c.bench_function("noise, simplex", |b| {
        b.iter(|| {
            for (v, p) in out.iter_mut().zip(black_box(&places)) {
                *v = simplex.get(p.to_array());
            }
            black_box(&mut out);
        });
    });
    let smooth = Fbm::<SuperSimplex>::new(1).set_octaves(OCTAVES as usize);
    c.bench_function("noise, super simplex", |b| {
        b.iter(|| {
            for (v, p) in out.iter_mut().zip(black_box(&places)) {
                *v = smooth.get(p.to_array());
            }
            black_box(&mut out);
        });
    });
    let mut fast = FastNoiseLite::with_seed(1);
    fast.set_noise_type(Some(NoiseType::OpenSimplex2));
    fast.set_fractal_type(Some(FractalType::FBm));
    fast.set_fractal_octaves(Some(OCTAVES as i32));
    fast.set_frequency(Some(1.0));
    let singles: Vec<[f32; 3]> = places.iter().map(|p| p.as_vec3().to_array()).collect();
    let mut out = vec![0.0_f32; singles.len()];
    c.bench_function("fastnoise-lite, open simplex 2", |b| {
        b.iter(|| {
            for (v, [x, y, z]) in out.iter_mut().zip(black_box(&singles)) {
                *v = fast.get_noise_3d(*x, *y, *z);
            }
            black_box(&mut out);
        });
    });
}

criterion_group!(benches, ours, others);
criterion_main!(benches);
