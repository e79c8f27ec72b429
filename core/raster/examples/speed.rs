//! Times files given as arguments: opening, and 256² tiles at their middle, on one thread.

#![allow(clippy::print_stdout, reason = "an example for the terminal")]

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use relievo_planet::{LevelKey, MapPoint, Planet, TileKey};
use relievo_raster::crs::Crs;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::warp::{Kernel, Warp};
use relievo_raster::{Block, Cancel, RasterFile};

fn main() {
    for argument in std::env::args().skip(1) {
        if let Err(error) = time(Path::new(&argument)) {
            println!("{argument}: {error}");
        }
    }
}

fn time(path: &Path) -> Result<(), Box<dyn core::error::Error>> {
    let options = OpenOptions::default();
    let bare = OpenOptions {
        make_pyramid: false,
        ..OpenOptions::default()
    };
    let start = Instant::now();
    open(path, &bare)?;
    let opened = start.elapsed();
    let start = Instant::now();
    let file = open(path, &options)?;
    println!(
        "{}: opened in {opened:?}, with its pyramid in {:?}",
        path.display(),
        start.elapsed()
    );
    let warp = Warp::new(Arc::clone(&file), Planet::EARTH, Kernel::Bilinear)?;
    let Some(middle) = middle(&*file) else {
        return Ok(());
    };
    // The level whose samples are about as large as the file's pixels, a finer and a coarser one.
    let finest = libm::log2(core::f64::consts::PI / 256.0 / warp.finest_step_rad());
    for n in [finest + 1.0, finest, finest - 1.5, finest - 3.0] {
        let n = n.clamp(0.0, 22.0) as u8;
        let level = LevelKey::new(n + 1, n);
        let at = level.sample_from_map(middle).as_i64vec2() / 256;
        let Some(tile) = TileKey::new(level, at.x, at.y) else {
            continue;
        };
        let grid = tile.grid();
        let mut out = Block::new(file.info().bands, 256, 256);
        let start = Instant::now();
        warp.render(&grid, &mut out, &Cancel::default())?;
        let first = start.elapsed();
        let mut times: Vec<Duration> = Vec::new();
        for _ in 0..60 {
            let start = Instant::now();
            warp.render(&grid, &mut out, &Cancel::default())?;
            times.push(start.elapsed());
        }
        times.sort();
        println!(
            "  level {n}: first {first:?}, then {:?} (best {:?})",
            times[times.len() / 2],
            times[0]
        );
    }
    Ok(())
}

/// The place of the file's middle.
fn middle(file: &dyn RasterFile) -> Option<MapPoint> {
    let info = file.info();
    let place = info.georeference.as_ref()?;
    let [x0, dx, rx, y0, ry, dy] = place.plane_from_pixel;
    let (column, row) = (
        f64::from(info.overviews[0].width) * 0.5,
        f64::from(info.overviews[0].height) * 0.5,
    );
    let (lon, lat) = Crs::parse(&place.crs)
        .ok()?
        .to_lonlat(x0 + dx * column + rx * row, y0 + ry * column + dy * row)
        .ok()?;
    Some(MapPoint::from_degrees(lon.to_degrees(), lat.to_degrees()))
}
