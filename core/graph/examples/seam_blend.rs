//! Layers blended into what lies below them: what is left of the step across the edge, and what it costs.
//!
//! `cargo run --release -p relievo-graph --example seam_blend -- [PICTURE.png]`
//!
//! Two pairs of the sample projects: the aerial photograph of Provo over the Blue Marble, which a pixel of
//! 7 km makes one colour and a drift, and a round piece of the photograph, darker and warmer, over the
//! photograph itself. Printed are the mean absolute difference of encoded colours (8-bit steps) across
//! the edge, sample by sample and of means of 8 × 8 samples, how much of the layer's gradients is changed,
//! and the time of tiles. The picture shows both pairs before and after.

#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use relievo_graph::nodes::{
    Adjust, AdjustParams, BlendMode, Constant, DiscMask, FileSource, Memory, Overlay, SeamBlend,
};
use relievo_graph::{Graph, GraphBuilder, ImageNode, NodeIndex};
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect, TileKey};
use relievo_raster::crs::Crs;
use relievo_raster::kernel::Kernel;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::warp::Warp;
use relievo_raster::write::{Png, write_png};
use relievo_raster::{Bands, Block, Cancel, SampleType};

/// Samples of 2.4 m.
const LEVEL: LevelKey = LevelKey { m: 16, n: 15 };

/// Half as many samples of a side of what is looked at.
const HALF: i64 = 320;

/// What lies over what.
#[derive(Clone, Copy, PartialEq)]
enum Pair {
    AerialOverWorld,
    AerialOverAerial,
}

struct Scene {
    graph: Graph,
    below: NodeIndex,
    layer: NodeIndex,
    blended: NodeIndex,
    mask: Option<NodeIndex>,
    over: NodeIndex,
}

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("seam_blend.png"), PathBuf::from);
    let centre = centre()?;
    let at = LEVEL.sample_from_map(centre).as_i64vec2();
    let rect = SampleRect::new(at - HALF, at + HALF);
    let grid = Grid::new(Arc::new(LEVEL.lattice()), rect);
    let mut pictures = Vec::new();
    for (pair, name) in [
        (Pair::AerialOverWorld, "aerial over world"),
        (Pair::AerialOverAerial, "aerial over aerial"),
    ] {
        for reach_m in [0.0, 50.0, 100.0, 200.0, 400.0] {
            let scene = scene(pair, centre, reach_m)?;
            let shown = report(name, &scene, &grid, reach_m)?;
            if reach_m == 0.0 || reach_m == 100.0 {
                pictures.push(shown);
            }
        }
    }
    write_png(&picture, &side_by_side(&pictures), Png::Rgb8)?;
    println!("{}", picture.display());
    for reach_m in [100.0, 400.0] {
        times(centre, reach_m)?;
    }
    time_of_block("with a line of seams", |x, _| x < 220)?;
    time_of_block("with a hole at every other sample", |x, y| (x + y) % 2 == 0)
}

/// A block of corrections whose lattice is as fine as it gets for its reach.
fn time_of_block(
    name: &str,
    is_there: impl Fn(usize, usize) -> bool,
) -> Result<(), Box<dyn Error>> {
    const SIDE: usize = 400;
    let lattice = Arc::new(LEVEL.lattice());
    // A block of 128 × 128 samples in the middle.
    let block = SampleRect::at(80_000 * 128, 8_000 * 128, 128, 128);
    let side = SIDE as i64;
    let held = SampleRect::at(block.min.x - 136, block.min.y - 136, side, side);
    let mut layer = Block::filled(Bands::Colour, SIDE, SIDE, &[0.5, 0.4, 0.3, 1.0]);
    for (i, alpha) in layer.plane_mut(3).iter_mut().enumerate() {
        *alpha = f32::from(u8::from(is_there(i % SIDE, i / SIDE)));
    }
    let mut least_ms = f64::INFINITY;
    for _ in 0..5 {
        let mut b = GraphBuilder::default();
        let below = b.add(Arc::new(Constant::colour([0.3, 0.4, 0.5, 1.0])), &[]);
        let held = Grid::new(Arc::clone(&lattice), held);
        let layer = b.add(Arc::new(Memory::new(&held, layer.clone())), &[]);
        let reach_m = 31.9 * lattice.step.y * Planet::EARTH.radius_m;
        let node = Arc::new(SeamBlend::new(Planet::EARTH, reach_m, false));
        let blended = b.add(node, &[below, layer]);
        let graph = b.build();
        let grid = Grid::new(Arc::clone(&lattice), block);
        let start = Instant::now();
        graph.evaluate(blended, &grid, &Cancel::default())?;
        least_ms = least_ms.min(start.elapsed().as_secs_f64() * 1e3);
    }
    println!("a block of 128 × 128 samples {name}: {least_ms:.1} ms");
    Ok(())
}

/// The middle of the aerial photograph.
fn centre() -> Result<MapPoint, Box<dyn Error>> {
    let aerial = source("provo-aerial.tif")?;
    let info = aerial.warp().file().info();
    let place = info.georeference.as_ref().ok_or("a place")?;
    let [x, column, _, y, _, row] = place.plane_from_pixel;
    let (width, height) = (info.overviews[0].width, info.overviews[0].height);
    println!("the photograph has {width} × {height} samples of {column} m");
    let (east, north) = (
        x + f64::from(width) / 2.0 * column,
        y + f64::from(height) / 2.0 * row,
    );
    let (lon_rad, lat_rad) = Crs::parse(&place.crs)?.to_lonlat(east, north)?;
    Ok(MapPoint::new(
        lon_rad,
        core::f64::consts::FRAC_PI_2 - lat_rad,
    ))
}

fn source(name: &str) -> Result<Arc<FileSource>, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let file = open(&path.join(name), &OpenOptions::default())?;
    let warp = Arc::new(Warp::new(file, Planet::EARTH, Kernel::Bilinear)?);
    Ok(Arc::new(FileSource::new(warp, 1.0, 0.0)))
}

fn scene(pair: Pair, centre: MapPoint, reach_m: f64) -> Result<Scene, Box<dyn Error>> {
    let mut b = GraphBuilder::default();
    let aerial = b.add(source("provo-aerial.tif")?, &[]);
    let (below, layer, mask) = if pair == Pair::AerialOverWorld {
        (b.add(source("blue-marble.tif")?, &[]), aerial, None)
    } else {
        let params = AdjustParams {
            gain: [0.9, 0.82, 0.74],
            ..AdjustParams::default()
        };
        let layer = b.add(Arc::new(Adjust::new(&params)), &[aerial]);
        let disc = DiscMask::new(&Planet::EARTH, centre, 180.0, 0.0);
        (aerial, layer, Some(b.add(Arc::new(disc), &[])))
    };
    let masked = mask.is_some();
    let inputs: Vec<_> = [below, layer].into_iter().chain(mask).collect();
    let node: Arc<dyn ImageNode> = Arc::new(SeamBlend::new(Planet::EARTH, reach_m, masked));
    let blended = b.add(node, &inputs);
    let inputs: Vec<_> = [below, blended].into_iter().chain(mask).collect();
    let overlay = Overlay::new(BlendMode::Normal, 1.0, masked);
    let over = b.add(Arc::new(overlay), &inputs);
    b.cut(over, SampleType::Rgba8);
    Ok(Scene {
        graph: b.build(),
        below,
        layer,
        blended,
        mask,
        over,
    })
}

fn report(name: &str, scene: &Scene, grid: &Grid, reach_m: f64) -> Result<Block, Box<dyn Error>> {
    let make = |node| scene.graph.evaluate(node, grid, &Cancel::default());
    let (below, layer, blended) = (make(scene.below)?, make(scene.layer)?, make(scene.blended)?);
    let mut shows: Vec<bool> = layer.plane(3).iter().map(|a| *a > 0.5).collect();
    if let Some(mask) = scene.mask {
        for (shows, weight) in shows.iter_mut().zip(make(mask)?.plane(0)) {
            *shows &= *weight > 0.5;
        }
    }
    let width = layer.width();
    // Across edges between columns: sample by sample, and means of squares on either side.
    let (mut fine, mut own, mut wide, mut count) = (0.0, 0.0, 0.0, 0);
    let (mut wide_count, mut changed, mut gradients) = (0, 0.0, 0.0);
    for i in 0..shows.len() - 1 {
        let (x, y) = (i % width, i / width);
        if x < 8 || x + 9 > width || y < 4 || y + 4 > layer.height() {
            continue;
        }
        if shows[i] && shows[i + 1] {
            for c in 0..3 {
                let gradient = |block: &Block| block.plane(c)[i + 1] - block.plane(c)[i];
                gradients += f64::from(gradient(&layer).abs());
                changed += f64::from((gradient(&blended) - gradient(&layer)).abs());
            }
        }
        if shows[i] == shows[i + 1] {
            continue;
        }
        let inside = if shows[i] { i } else { i + 1 };
        let outside = 2 * i + 1 - inside;
        count += 1;
        let west = if shows[i] {
            (&blended, &below)
        } else {
            (&below, &blended)
        };
        let mean = |block: &Block, c: usize, first: usize| {
            let rows = (y - 4..y + 4).flat_map(|y| y * width + first..y * width + first + 8);
            rows.map(|i| f64::from(block.plane(c)[i])).sum::<f64>() / 64.0
        };
        let is_straight = (y - 4..y + 4).all(|y| {
            (y * width + x - 7..=y * width + x).all(|k| shows[k] == shows[i])
                && (y * width + x + 1..y * width + x + 9).all(|k| shows[k] != shows[i])
        });
        for c in 0..3 {
            let difference = blended.plane(c)[inside] - below.plane(c)[outside];
            fine += f64::from(difference.abs());
            own += f64::from((below.plane(c)[inside] - below.plane(c)[outside]).abs());
            if is_straight {
                wide += (mean(west.0, c, x - 7) - mean(west.1, c, x + 1)).abs();
                wide_count += 1;
            }
        }
    }
    println!(
        "{name}, reach {reach_m} m: step {:.2} of 255 (below {:.2}), of means {:.2}; {count} places, {} straight; gradients changed by {:.2} %",
        fine / f64::from(3 * count) * 255.0,
        own / f64::from(3 * count) * 255.0,
        wide / f64::from(wide_count) * 255.0,
        wide_count / 3,
        100.0 * changed / gradients
    );
    Ok(make(scene.over)?)
}

fn side_by_side(pictures: &[Block]) -> Block {
    let (width, height) = (pictures[0].width(), pictures[0].height());
    let mut all = Block::filled(Bands::Colour, 2 * width, 2 * height, &[1.0; 4]);
    for (i, picture) in pictures.iter().enumerate() {
        all.copy_from(
            picture,
            (0, 0),
            (i % 2 * width, i / 2 * height),
            (width, height),
        );
    }
    all
}

/// Means of tiles, the least of three times each, around the edge, with and without the node, on one thread.
fn times(centre: MapPoint, reach_m: f64) -> Result<(), Box<dyn Error>> {
    for drop in [0, 1, 2, 3, 4] {
        let level = LevelKey::new(LEVEL.m - drop, LEVEL.n - drop);
        let at = level.sample_from_map(centre).as_i64vec2() / 256;
        let mean_ms = |reach_m: f64, again: bool| -> Result<f64, Box<dyn Error>> {
            let scene = scene(Pair::AerialOverWorld, centre, reach_m)?;
            let mut all_ms = Vec::new();
            for pass in 0..2 {
                for (east, south) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                    let key = TileKey::new(level, at.x + east, at.y + south);
                    let grid = key.ok_or("a tile of the level")?.grid();
                    let start = Instant::now();
                    scene
                        .graph
                        .evaluate(scene.over, &grid, &Cancel::default())?;
                    if again == (pass == 1) {
                        all_ms.push(start.elapsed().as_secs_f64() * 1e3);
                    }
                }
            }
            Ok(all_ms.iter().sum::<f64>() / all_ms.len() as f64)
        };
        let mut best = [f64::INFINITY; 3];
        for _ in 0..3 {
            best[0] = best[0].min(mean_ms(0.0, true)?);
            best[1] = best[1].min(mean_ms(reach_m, false)?);
            best[2] = best[2].min(mean_ms(reach_m, true)?);
        }
        println!(
            "reach {reach_m} m, level {}/{}: {:.1} ms a tile without, {:.1} with, {:.1} once corrections are there",
            level.m, level.n, best[0], best[1], best[2]
        );
    }
    Ok(())
}
