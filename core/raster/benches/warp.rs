//! A 256² tile from a tiled file in UTM on one thread: from pixels in memory, and from GeoTIFFs whose decoded
//! chunks are cached.

use std::cell::LazyCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, TileKey};
use relievo_raster::file::{Georeference, OverviewInfo, ReadError};
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::warp::{Kernel, Warp};
use relievo_raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_raster::{Bands, Block, Cancel, PixelRect, RasterFile, RasterInfo, reduce};

/// Side of the file in pixels.
const SIDE: usize = 2048;

/// A file whose levels are in memory.
struct Memory {
    info: RasterInfo,
    levels: Vec<Block>,
}

impl RasterFile for Memory {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn fingerprint(&self) -> [u8; 32] {
        [0; 32]
    }

    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        _: &Cancel,
    ) -> Result<(), ReadError> {
        let level = &self.levels[overview];
        let size = (rect.width as usize, rect.height as usize);
        out.reshape(level.bands(), size.0, size.1);
        out.copy_from(level, (rect.x as usize, rect.y as usize), (0, 0), size);
        Ok(())
    }
}

/// Waves of heights, or of colours.
fn full(bands: Bands) -> Block {
    let mut full = Block::new(bands, SIDE, SIDE);
    for plane in 0..bands.planes() {
        for (i, v) in full.plane_mut(plane).iter_mut().enumerate() {
            let wave = ((i % SIDE) as f32 * 0.1).sin();
            *v = match (bands, plane) {
                (Bands::Height, _) => wave * 300.0 + (i / SIDE) as f32,
                (_, 3) => 1.0,
                _ => (wave * 0.5 + 0.5) * (i / SIDE) as f32 / SIDE as f32,
            };
        }
    }
    full
}

/// Pixels of 30 m in zone 12.
fn place() -> Georeference {
    let half_m = SIDE as f64 * 15.0;
    Georeference {
        crs: "EPSG:32612".into(),
        plane_from_pixel: [
            457_000.0 - half_m,
            30.0,
            0.0,
            4_483_000.0 + half_m,
            0.0,
            -30.0,
        ],
    }
}

fn file(bands: Bands) -> Arc<dyn RasterFile> {
    let mut levels = vec![full(bands)];
    for _ in 0..3 {
        let half = reduce::halve(&levels[levels.len() - 1]);
        levels.push(half);
    }
    Arc::new(Memory {
        info: RasterInfo {
            path: PathBuf::from("memory"),
            format: "memory",
            overviews: levels
                .iter()
                .map(|b| OverviewInfo {
                    width: b.width() as u32,
                    height: b.height() as u32,
                })
                .collect(),
            bands,
            band_count: bands.planes() as u16,
            sample_type: "float32".into(),
            compression: "none".into(),
            deep_colour: false,
            nodata: None,
            may_have_holes: true,
            georeference: Some(place()),
        },
        levels,
    })
}

/// The same pixels in a GeoTIFF of the folder.
fn geotiff(folder: &Path, samples: CogSamples) -> Arc<dyn RasterFile> {
    let pixels = full(samples.bands());
    let path = folder.join(format!("{}.tif", samples.bands().planes()));
    let layout = CogLayout {
        width: SIDE as u32,
        height: SIDE as u32,
        samples,
        tile: 256,
        georeference: Some(place()),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: PixelRect| {
        let size = (rect.width as usize, rect.height as usize);
        let mut part = Block::new(pixels.bands(), size.0, size.1);
        part.copy_from(&pixels, (rect.x as usize, rect.y as usize), (0, 0), size);
        Ok(part)
    };
    let work = CogWork {
        threads: 1,
        resume: None,
        cancel: &Cancel::default(),
    };
    write_cog(&path, &layout, &source, &work, &mut |_| {}).expect("a file in a folder of our own");
    open(&path, &OpenOptions::default()).expect("a file that was just written")
}

/// The tile of a level at the middle of the file.
fn grid(n: u8) -> Grid {
    let level = LevelKey::new(n + 1, n);
    let at = level
        .sample_from_map(MapPoint::from_degrees(-111.5, 40.5))
        .as_i64vec2()
        / 256;
    TileKey::new(level, at.x, at.y)
        .expect("inside the level")
        .grid()
}

/// A name, the file, and how it is read at which level.
type Case<'a> = (&'a str, &'a dyn Fn() -> Arc<dyn RasterFile>, Kernel, u8);

fn warp(c: &mut Criterion) {
    let cancel = Cancel::default();
    let folder = tempfile::tempdir().expect("a folder for a moment");
    let heights = || file(Bands::Height);
    let colours = || file(Bands::Colour);
    let heights_of_tiff = || geotiff(folder.path(), CogSamples::Height { nodata: -9999.0 });
    let colours_of_tiff = || geotiff(folder.path(), CogSamples::Rgb8);
    let magnified = 12;
    let cases: [Case; 6] = [
        (
            "height tile from UTM: magnified, bilinear",
            &heights,
            Kernel::Bilinear,
            magnified,
        ),
        (
            "height tile from UTM: magnified, bicubic",
            &heights,
            Kernel::Bicubic,
            magnified,
        ),
        (
            "height tile from UTM: reduced by a tent",
            &heights,
            Kernel::Bilinear,
            11,
        ),
        (
            "height tile from a GeoTIFF in UTM",
            &heights_of_tiff,
            Kernel::Bilinear,
            magnified,
        ),
        (
            "colour tile from UTM",
            &colours,
            Kernel::Bilinear,
            magnified,
        ),
        (
            "colour tile from a GeoTIFF in UTM",
            &colours_of_tiff,
            Kernel::Bilinear,
            magnified,
        ),
    ];
    for (name, file, kernel, n) in cases {
        // Made only if it is asked for.
        let warp = LazyCell::new(|| {
            Warp::new(file(), Planet::EARTH, kernel).expect("a georeferenced file")
        });
        let grid = grid(n);
        let mut out = Block::new(Bands::Height, 256, 256);
        c.bench_function(name, |b| {
            let warp = &*warp;
            b.iter(|| warp.render(&grid, &mut out, &cancel).expect("a sound file"));
        });
    }
}

criterion_group!(benches, warp);
criterion_main!(benches);
