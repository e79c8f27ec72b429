//! Writes a Cloud Optimised GeoTIFF of a synthetic surface, for validators, for measuring memory and
//! for stopping half way.
//!
//! Arguments: file, `height`, `colour`, `rgb`, `normal` or `normal8`, columns, rows, coordinate
//! system, threads; a seventh, if given, is the largest size in bytes that is no BigTIFF.

use std::path::Path;

use relievo_raster::file::Georeference;
use relievo_raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_raster::{Bands, Block, Cancel, PixelRect};

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, kind, width, height, crs, threads, limit @ ..] = arguments.as_slice() else {
        return Err(
            "expected a file, a kind, columns, rows, a coordinate system and threads".into(),
        );
    };
    let samples = match kind.as_str() {
        "height" => CogSamples::Height { nodata: -32767.0 },
        "colour" => CogSamples::Rgba8,
        "rgb" => CogSamples::Rgb8,
        "normal" => CogSamples::NormalF32,
        "normal8" => CogSamples::Normal8,
        other => return Err(format!("expected a kind of samples, found {other}").into()),
    };
    let (width, height) = (width.parse()?, height.parse()?);
    let degrees = relievo_raster::crs::Crs::parse(crs)?.is_geographic();
    let layout = CogLayout {
        width,
        height,
        samples,
        tile: 512,
        georeference: Some(Georeference {
            crs: crs.as_str().into(),
            plane_from_pixel: if degrees {
                [-20.0, 1e-4, 0.0, 40.0, 0.0, -1e-4]
            } else {
                [440_000.0, 2.0, 0.0, 4_485_000.0, 0.0, -2.0]
            },
        }),
        largest_classic_bytes: match limit {
            [bytes, ..] => bytes.parse()?,
            [] => CogLayout::LARGEST_CLASSIC_BYTES,
        },
    };
    let source = |rect: PixelRect| Ok(surface(samples.bands(), rect));
    let cancel = Cancel::default();
    let work = CogWork {
        threads: threads.parse()?,
        resume: Some([7; 32]),
        cancel: &cancel,
    };
    write_cog(Path::new(file), &layout, &source, &work, &mut |_| ())?;
    Ok(())
}

/// Waves, and a hole here and there.
fn surface(bands: Bands, rect: PixelRect) -> Block {
    let (width, height) = (rect.width as usize, rect.height as usize);
    let mut block = Block::new(bands, width, height);
    for plane in 0..bands.planes() {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            let (x, y) = (rect.x as usize + i % width, rect.y as usize + i / width);
            let wave = libm::sinf(x as f32 * 0.003 + plane as f32) * libm::cosf(y as f32 * 0.002);
            let grain = ((x * 7919 + y * 104_729) % 97) as f32 / 97.0;
            let hole = (x / 300 + y / 200) % 11 == 0;
            *v = match bands {
                Bands::Height if hole => f32::NAN,
                Bands::Height => 1500.0 + 900.0 * wave + grain,
                Bands::Colour if hole => 0.0,
                Bands::Colour if plane == 3 => 1.0,
                Bands::Colour => 0.5 + 0.4 * wave + 0.1 * grain,
                Bands::Normal | Bands::Mask => 0.6 * wave + 0.05 * grain,
            };
        }
    }
    block
}
