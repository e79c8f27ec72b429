//! Writes samples of raster files as raw f32 planes, for comparison with other readers.
//!
//! Reads requests from standard input, one a line, fields separated by tabs: file, level, `auto`,
//! `height` or `colour`, bands counted from 0 and separated by commas (or `-`), file to write (or
//! `-`). Answers each with one line: `read` and what was found, or `refused` and why.

#![allow(clippy::print_stdout, reason = "an example for the terminal")]

use std::io::BufRead;
use std::path::Path;

use relievo_raster::open::{OpenOptions, Stretch, open};
use relievo_raster::{Bands, Block, Cancel, PixelRect};

fn main() {
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        match answer(&line) {
            Ok(text) => println!("read\t{text}"),
            Err(reason) => println!("refused\t{reason}"),
        }
    }
}

fn answer(line: &str) -> Result<String, String> {
    let fields: Vec<&str> = line.split('\t').collect();
    let &[file, level, bands, select, out] = fields.as_slice() else {
        return Err(format!("expected five fields, found {}", fields.len()));
    };
    let level: usize = level
        .parse()
        .map_err(|e| format!("expected a level: {e}"))?;
    let options = OpenOptions {
        make_pyramid: false,
        as_bands: match bands {
            "height" => Some(Bands::Height),
            "colour" => Some(Bands::Colour),
            _ => None,
        },
        select: (select != "-").then(|| select.split(',').filter_map(|b| b.parse().ok()).collect()),
        stretch: if bands == "auto" {
            Stretch::Auto
        } else {
            Stretch::Full
        },
        ..OpenOptions::default()
    };
    let file = open(Path::new(file), &options).map_err(|e| e.to_string())?;
    let info = file.info();
    let size = info.overviews.get(level).ok_or_else(|| {
        format!(
            "expected level {level}, found {} levels",
            info.overviews.len()
        )
    })?;
    let mut block = Block::new(info.bands, 0, 0);
    let whole = PixelRect {
        x: 0,
        y: 0,
        width: size.width,
        height: size.height,
    };
    if out != "-" {
        file.read(level, whole, &mut block, &Cancel::default())
            .map_err(|e| e.to_string())?;
        let bytes: Vec<u8> = block
            .samples()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        std::fs::write(out, bytes).map_err(|e| e.to_string())?;
    }
    let levels: Vec<String> = info
        .overviews
        .iter()
        .map(|o| format!("{}x{}", o.width, o.height))
        .collect();
    let place = info.georeference.as_ref().map_or_else(
        || "none".to_owned(),
        |g| format!("{} {:?}", g.crs, g.plane_from_pixel),
    );
    Ok(format!(
        "{:?}\t{}\t{}\t{}\t{}\t{:?}\t{}\t{place}",
        info.bands,
        info.format,
        info.band_count,
        info.sample_type,
        info.compression,
        info.nodata,
        levels.join(" ")
    ))
}
