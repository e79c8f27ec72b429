//! Coarse imagery continued after examples and by noise, beside what is really there.
//!
//! `cargo run --release -p relievo-graph --example colour_detail -- [PICTURE.png] [AERIAL.tif]`
//!
//! The aerial photograph is reduced to an eighth of its resolution and refined again: after pieces of its
//! other half, and by noise. The picture shows the coarse imagery, what is made of it without detail, by
//! noise and after examples, and the truth. Any opaque picture of some hundred samples will do. Printed
//! are the error of the constraint, the contrast of every halving and the time of a sample.

#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;
use relievo_graph::nodes::{
    ColourDetail, ColourDetailParams, ColourDetailSource, ExampleAt, Memory,
};
use relievo_graph::{Graph, GraphBuilder, NodeIndex};
use relievo_planet::{Grid, GridCrs, Lattice, LevelKey, MapPoint, Planet, SampleRect, TileKey};
use relievo_raster::colour::srgb_from_linear;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::reduce::halve;
use relievo_raster::write::{Png, write_png};
use relievo_raster::{Bands, Block, Cancel, PixelRect, colour};

/// Coarse samples are this many times as large.
const TIMES: usize = 8;

/// How often every sample is repeated in the picture.
const ZOOM: usize = 3;

/// Metres from sample to sample of the photograph.
const SPACING_M: f64 = 2.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let picture = arguments
        .next()
        .map_or_else(|| PathBuf::from("colour_detail.png"), PathBuf::from);
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let aerial = arguments
        .next()
        .map_or_else(|| projects.join("provo-aerial.tif"), PathBuf::from);

    let photograph = read(&aerial)?;
    let (width, height) = (photograph.width() / 2, photograph.height());
    let half = |first: usize| part(&photograph, (first, 0), (width, height));
    let truth = whole_coarse(&half(0));
    let example = half(width);

    let mut coarse = truth.clone();
    for _ in 0..TIMES.ilog2() {
        coarse = halve(&coarse);
    }
    let lattice = Lattice {
        crs: GridCrs::Projected("EPSG:26912".into()),
        origin: DVec2::new(444_848.0, 4_449_195.0),
        step: DVec2::new(SPACING_M, -SPACING_M),
        columns_around: None,
    };
    let params = ColourDetailParams {
        coarse_spacing_m: SPACING_M * TIMES as f64,
        ..ColourDetailParams::default()
    };
    let with = |by: ColourDetailSource, strength: f64| {
        let params = ColourDetailParams {
            by,
            strength,
            ..params
        };
        detailed(&lattice, &coarse, &example, &params)
    };
    let smooth = with(ColourDetailSource::Noise, 1e-9)?;
    let noisy = with(ColourDetailSource::Noise, 1.0)?;
    let fine = with(ColourDetailSource::Examples, 1.0)?;
    let made = [
        ("interpolated", &smooth),
        ("by noise", &noisy),
        ("after examples", &fine),
    ];
    for (name, made) in made {
        let (largest, mean) = constraint_error(made, &coarse);
        println!("{name}: constraint off by at most {largest:.2e}, on average {mean:.2e}");
    }
    println!(
        "roughness (root mean square of steps) and contrast of the halvings from the finest on, dB, all and typical"
    );
    for (name, made) in made.into_iter().chain([("truth", &truth)]) {
        print!("{name:>16} {:.4}", roughness(made));
        for (all, typical) in halvings(made) {
            print!("  {all:6.1} {typical:6.1}");
        }
        println!();
    }
    let repeated = repeat(&coarse, TIMES);
    let nothing = Block::filled(Bands::Colour, truth.width(), truth.height(), &[1.0; 4]);
    let pictures = [&repeated, &smooth, &noisy, &fine, &truth, &nothing];
    write_png(&picture, &side_by_side(&pictures), Png::Rgb8)?;
    println!("{}", picture.display());
    time_of_tiles(&coarse, &example)
}

fn read(path: &Path) -> Result<Block, Box<dyn Error>> {
    let file = open(path, &OpenOptions::default())?;
    let overview = &file.info().overviews[0];
    let (width, height) = (overview.width, overview.height);
    let mut all = Block::new(Bands::Colour, width as usize, height as usize);
    let rect = PixelRect {
        x: 0,
        y: 0,
        width,
        height,
    };
    file.read(0, rect, &mut all, &Cancel::default())?;
    Ok(all)
}

fn part(block: &Block, from: (usize, usize), size: (usize, usize)) -> Block {
    let mut part = Block::new(block.bands(), size.0, size.1);
    part.copy_from(block, from, (0, 0), size);
    part
}

/// As much as whole coarse samples cover.
fn whole_coarse(block: &Block) -> Block {
    let size = (
        block.width() / TIMES * TIMES,
        block.height() / TIMES * TIMES,
    );
    part(block, (0, 0), size)
}

/// A graph of coarse imagery with detail over it.
fn graph(
    grid: &Grid,
    coarse: &Block,
    example: &Block,
    params: &ColourDetailParams,
) -> (Graph, NodeIndex) {
    let mut b = GraphBuilder::default();
    let input = b.add(Arc::new(Memory::new(grid, coarse.clone())), &[]);
    // Where it lies does not matter: it is read sample by sample.
    let (width, height) = (example.width() as i64, example.height() as i64);
    let size = [width as u32, height as u32];
    let centre = MapPoint::from_degrees(-111.6, 40.2);
    let mut at = ExampleAt::around(&Planet::EARTH, centre, SPACING_M, size);
    at.grid.rect = SampleRect::at(0, 0, width, height);
    let example = b.add(Arc::new(Memory::new(&at.grid, example.clone())), &[]);
    let node = ColourDetail::new(Planet::EARTH, params, vec![at], false);
    let output = b.add(Arc::new(node), &[input, example]);
    (b.build(), output)
}

fn detailed(
    lattice: &Lattice,
    coarse: &Block,
    example: &Block,
    params: &ColourDetailParams,
) -> Result<Block, Box<dyn Error>> {
    let (width, height) = (coarse.width() as i64, coarse.height() as i64);
    let above = Lattice {
        step: lattice.step * TIMES as f64,
        ..lattice.clone()
    };
    let held = Grid::new(Arc::new(above), SampleRect::at(0, 0, width, height));
    let (graph, output) = graph(&held, coarse, example, params);
    let times = TIMES as i64;
    let fine = Grid::new(
        Arc::new(lattice.clone()),
        SampleRect::at(0, 0, width * times, height * times),
    );
    Ok(graph.evaluate(output, &fine, &Cancel::default())?)
}

/// The largest and the mean difference of encoded colours, reduced by the box in linear light.
fn constraint_error(fine: &Block, coarse: &Block) -> (f64, f64) {
    let mut light = fine.clone();
    colour::premultiply(&mut light);
    let (mut largest, mut sum) = (0.0_f64, 0.0);
    for plane in 0..3 {
        for (i, wanted) in coarse.plane(plane).iter().enumerate() {
            let (x, y) = (i % coarse.width() * TIMES, i / coarse.width() * TIMES);
            let mut mean = 0.0;
            for row in y..y + TIMES {
                let first = row * fine.width() + x;
                let samples = &light.plane(plane)[first..first + TIMES];
                mean += samples.iter().map(|v| f64::from(*v)).sum::<f64>();
            }
            let mean = srgb_from_linear((mean / (TIMES * TIMES) as f64) as f32);
            let error = f64::from((mean - wanted).abs());
            largest = largest.max(error);
            sum += error;
        }
    }
    (largest, sum / (3 * coarse.plane(0).len()) as f64)
}

/// Root mean square of differences from sample to sample along rows.
fn roughness(block: &Block) -> f64 {
    let steps = (0..3).flat_map(|plane| block.plane(plane).windows(2));
    let (sum, count) = steps.fold((0.0, 0.0), |(sum, count), w| {
        (sum + f64::from(w[1] - w[0]).powi(2), count + 1.0)
    });
    (sum / count).sqrt()
}

/// The contrast of each halving, from the finest on: mean squares, relative to the light, of what samples
/// are above the mean of two by two, in decibels; and the same from the mean of fourth roots, which does
/// not heed a few that are large.
fn halvings(block: &Block) -> Vec<(f64, f64)> {
    let mut light = block.clone();
    colour::premultiply(&mut light);
    let mut width = block.width();
    let luminance = (0..width * block.height()).map(|at| {
        let [r, g, b] = [0, 1, 2].map(|plane| f64::from(light.plane(plane)[at]));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    });
    let mut luminance: Vec<f64> = luminance.collect();
    let mut all = Vec::new();
    for _ in 0..5 {
        let (half, rows) = (width / 2, luminance.len() / width / 2);
        let mut means = Vec::with_capacity(half * rows);
        let (mut sum, mut roots) = (0.0, 0.0);
        for y in 0..rows {
            for x in 0..half {
                let at = 2 * y * width + 2 * x;
                let quad = [at, at + 1, at + width, at + width + 1].map(|at| luminance[at]);
                let mean = quad.iter().sum::<f64>() / 4.0;
                let above = quad.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f64>() / 4.0;
                sum += above;
                roots += above.sqrt().sqrt();
                means.push(mean);
            }
        }
        let count = means.len() as f64;
        let decibels = |v: f64| 10.0 * v.log10();
        all.push((
            decibels(sum / count),
            decibels((roots / count).powi(4) / 0.7712),
        ));
        (luminance, width) = (means, half);
    }
    all
}

fn repeat(block: &Block, times: usize) -> Block {
    let (width, height) = (block.width() * times, block.height() * times);
    let mut out = Block::new(block.bands(), width, height);
    for plane in 0..block.bands().planes() {
        let from = block.plane(plane);
        for (i, v) in out.plane_mut(plane).iter_mut().enumerate() {
            *v = from[i / width / times * block.width() + i % width / times];
        }
    }
    out
}

/// Pictures three by two, enlarged.
fn side_by_side(pictures: &[&Block; 6]) -> Block {
    let gap = 4;
    let (width, height) = (pictures[0].width() * ZOOM, pictures[0].height() * ZOOM);
    let white = [1.0; 4];
    let mut all = Block::filled(Bands::Colour, 3 * width + 2 * gap, 2 * height + gap, &white);
    for (i, picture) in pictures.iter().enumerate() {
        let to = (i % 3 * (width + gap), i / 3 * (height + gap));
        all.copy_from(&repeat(picture, ZOOM), (0, 0), to, (width, height));
    }
    all
}

/// Times tiles of several levels, on one thread.
fn time_of_tiles(coarse: &Block, example: &Block) -> Result<(), Box<dyn Error>> {
    let level = LevelKey::new(13, 12);
    let lattice = Arc::new(level.lattice());
    let (width, height) = (coarse.width() as i64, coarse.height() as i64);
    // As many as four tiles of the coarse level, so that fine tiles find imagery around them.
    let across = repeat(coarse, 512_usize.div_ceil(coarse.height()));
    let rect = SampleRect::at(
        1_000_000,
        400_000,
        across.width() as i64,
        across.height() as i64,
    );
    println!("{width} × {height} coarse samples, an example of {SPACING_M} m");
    for by in [ColourDetailSource::Examples, ColourDetailSource::Noise] {
        let params = ColourDetailParams {
            by,
            coarse_spacing_m: lattice.step.y * Planet::EARTH.radius_m,
            ..ColourDetailParams::default()
        };
        let held = Grid::new(Arc::clone(&lattice), rect);
        let (graph, output) = graph(&held, &across, example, &params);
        for doublings in [1, 2, 3, 4, 6, 8] {
            let level = LevelKey::new(level.m + doublings, level.n + doublings);
            let place = rect.min + (rect.max - rect.min) / 4;
            let tile = place * (1 << doublings) / 256;
            let key = TileKey::new(level, tile.x, tile.y).ok_or("a tile of the level")?;
            let (mut first_ns, mut least_ns) = (None, f64::INFINITY);
            for east in 0..6 {
                let grid = key.neighbour(east % 3, 0).grid();
                let start = Instant::now();
                graph.evaluate(output, &grid, &Cancel::default())?;
                let taken_ns = start.elapsed().as_nanos() as f64;
                least_ns = least_ns.min(taken_ns);
                first_ns.get_or_insert(taken_ns);
            }
            let ns = least_ns / (256.0 * 256.0);
            let more_ms = (first_ns.unwrap_or(least_ns) - least_ns) * 1e-6;
            println!(
                "{by:?}, 2^{doublings} times as fine: {ns:.0} ns a sample, the first tile {more_ms:.0} ms more"
            );
        }
    }
    Ok(())
}
