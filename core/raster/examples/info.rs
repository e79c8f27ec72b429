//! Prints one line for each file given: what it is, or why it cannot be opened.
//!
//! With `--at COLUMN,ROW` after a file, its samples there follow, level 0.

#![allow(clippy::print_stdout, reason = "an example for the terminal")]

use std::path::Path;

use relievo_raster::crs::Crs;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::{Block, Cancel, PixelRect, RasterFile};

fn main() {
    let options = OpenOptions {
        make_pyramid: std::env::var_os("PYRAMID").is_some(),
        ..OpenOptions::default()
    };
    let mut last = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--at" {
            let place = arguments.next().unwrap_or_default();
            if let (Some(file), Some((column, row))) = (&last, place.split_once(',')) {
                print_samples(file, column.parse().unwrap_or(0), row.parse().unwrap_or(0));
            }
            continue;
        }
        match open(Path::new(&argument), &options) {
            Ok(file) => {
                print_info(&*file);
                last = Some(file);
            }
            Err(error) => println!("refused: {error}"),
        }
    }
}

fn print_info(file: &dyn RasterFile) {
    let info = file.info();
    let levels: Vec<String> = info
        .overviews
        .iter()
        .map(|o| format!("{}x{}", o.width, o.height))
        .collect();
    let place = info.georeference.as_ref().map_or_else(
        || "no georeference".into(),
        |g| {
            let [x0, dx, _, y0, _, dy] = g.plane_from_pixel;
            let corner = match Crs::parse(&g.crs) {
                Ok(crs) => crs.to_lonlat(x0, y0).map_or_else(
                    |e| e.to_string(),
                    |(lon, lat)| format!("{:.7} {:.7}", lon.to_degrees(), lat.to_degrees()),
                ),
                Err(error) => error.to_string(),
            };
            format!("{} at {x0} {y0} by {dx} {dy}, corner {corner}", g.crs)
        },
    );
    println!(
        "{}: {} {:?} {} band(s) {} {} nodata {:?} [{}] {place}",
        info.path.display(),
        info.format,
        info.bands,
        info.band_count,
        info.sample_type,
        info.compression,
        info.nodata,
        levels.join(" ")
    );
}

fn print_samples(file: &std::sync::Arc<dyn RasterFile>, column: u32, row: u32) {
    let size = file.info().overviews[0];
    if column >= size.width || row >= size.height {
        println!("  ({column}, {row}) lies outside");
        return;
    }
    let mut block = Block::new(file.info().bands, 0, 0);
    match file.read(
        0,
        PixelRect {
            x: column,
            y: row,
            width: 1,
            height: 1,
        },
        &mut block,
        &Cancel::default(),
    ) {
        Ok(()) => println!("  ({column}, {row}): {:?}", block.samples()),
        Err(error) => println!("  {error}"),
    }
}
