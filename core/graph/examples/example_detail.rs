//! Coarse imagery continued after examples, beside what is really there.
//!
//! `cargo run --release -p relievo-graph --example example_detail -- [PICTURE.png] [AERIAL.tif]`
//!
//! The aerial photograph is reduced to an eighth of its resolution and refined again after pieces of its
//! other half. The picture shows the coarse imagery, what is made of it without and with exemplars, and
//! the truth. Any opaque picture of some hundred samples will do. Printed are the error of the constraint
//! and the time of a sample.

#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;
use relievo_graph::nodes::{ExampleDetail, ExampleDetailParams, Exemplar, Memory};
use relievo_graph::{Graph, GraphBuilder, NodeIndex};
use relievo_planet::{Grid, GridCrs, Lattice, LevelKey, Planet, SampleRect, TileKey};
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
        .map_or_else(|| PathBuf::from("example_detail.png"), PathBuf::from);
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let aerial = arguments
        .next()
        .map_or_else(|| projects.join("provo-aerial.tif"), PathBuf::from);

    let photograph = read(&aerial)?;
    let (width, height) = (photograph.width() / 2, photograph.height());
    let half = |first: usize| part(&photograph, (first, 0), (width, height));
    let truth = whole_coarse(&half(0));
    let exemplar = Arc::new(Exemplar::new(&half(width), SPACING_M)?);

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
    let params = ExampleDetailParams {
        coarse_spacing_m: SPACING_M * TIMES as f64,
        ..ExampleDetailParams::default()
    };
    let with = |strength: f64| {
        let params = ExampleDetailParams { strength, ..params };
        detailed(&lattice, &coarse, &exemplar, &params)
    };
    let (smooth, fine) = (with(1e-6)?, with(1.0)?);
    for (name, made) in [("without exemplars", &smooth), ("with exemplars", &fine)] {
        let (largest, mean) = constraint_error(made, &coarse);
        println!("{name}: constraint off by at most {largest:.2e}, on average {mean:.2e}");
        println!(
            "  roughness {:.5}, truth {:.5}",
            roughness(made),
            roughness(&truth)
        );
    }
    let repeated = repeat(&coarse, TIMES);
    write_png(
        &picture,
        &side_by_side(&[&repeated, &smooth, &fine, &truth]),
        Png::Rgb8,
    )?;
    println!("{}", picture.display());
    time_of_tiles(&coarse, &exemplar)
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
    exemplar: &Arc<Exemplar>,
    params: &ExampleDetailParams,
) -> (Graph, NodeIndex) {
    let mut b = GraphBuilder::default();
    let input = b.add(Arc::new(Memory::new(grid, coarse.clone())), &[]);
    let exemplars = vec![Arc::clone(exemplar)];
    let node = ExampleDetail::new(Planet::EARTH, params, exemplars, false);
    let output = b.add(Arc::new(node), &[input]);
    (b.build(), output)
}

fn detailed(
    lattice: &Lattice,
    coarse: &Block,
    exemplar: &Arc<Exemplar>,
    params: &ExampleDetailParams,
) -> Result<Block, Box<dyn Error>> {
    let (width, height) = (coarse.width() as i64, coarse.height() as i64);
    let above = Lattice {
        step: lattice.step * TIMES as f64,
        ..lattice.clone()
    };
    let held = Grid::new(Arc::new(above), SampleRect::at(0, 0, width, height));
    let (graph, output) = graph(&held, coarse, exemplar, params);
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

/// Pictures two by two, enlarged.
fn side_by_side(pictures: &[&Block; 4]) -> Block {
    let gap = 4;
    let (width, height) = (pictures[0].width() * ZOOM, pictures[0].height() * ZOOM);
    let white = [1.0; 4];
    let mut all = Block::filled(Bands::Colour, 2 * width + gap, 2 * height + gap, &white);
    for (i, picture) in pictures.iter().enumerate() {
        let to = (i % 2 * (width + gap), i / 2 * (height + gap));
        all.copy_from(&repeat(picture, ZOOM), (0, 0), to, (width, height));
    }
    all
}

/// Times tiles of several levels, on one thread.
fn time_of_tiles(coarse: &Block, exemplar: &Arc<Exemplar>) -> Result<(), Box<dyn Error>> {
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
    let params = ExampleDetailParams {
        coarse_spacing_m: lattice.step.y * Planet::EARTH.radius_m,
        ..ExampleDetailParams::default()
    };
    println!("{width} × {height} coarse samples, an exemplar of {SPACING_M} m");
    let (graph, output) = graph(&Grid::new(lattice, rect), &across, exemplar, &params);
    for doublings in [1, 2, 3, 4, 6, 8] {
        let level = LevelKey::new(level.m + doublings, level.n + doublings);
        let place = rect.min + (rect.max - rect.min) / 4;
        let tile = place * (1 << doublings) / 256;
        let key = TileKey::new(level, tile.x, tile.y).ok_or("a tile of the level")?;
        let mut least_ns = f64::INFINITY;
        for east in 0..6 {
            let grid = key.neighbour(east % 3, 0).grid();
            let start = Instant::now();
            graph.evaluate(output, &grid, &Cancel::default())?;
            least_ns = least_ns.min(start.elapsed().as_nanos() as f64);
        }
        let ns = least_ns / (256.0 * 256.0);
        println!("2^{doublings} times as fine: {ns:.0} ns a sample");
    }
    Ok(())
}
