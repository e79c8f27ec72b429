//! A 256² height tile from a tiled file in UTM whose pixels are in memory, on one thread.

use std::path::PathBuf;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, TileKey};
use relievo_raster::file::{Georeference, OverviewInfo, ReadError};
use relievo_raster::warp::{Kernel, Warp};
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

fn file() -> Arc<dyn RasterFile> {
    let mut full = Block::new(Bands::Height, SIDE, SIDE);
    for (i, v) in full.plane_mut(0).iter_mut().enumerate() {
        *v = ((i % SIDE) as f32 * 0.1).sin() * 300.0 + (i / SIDE) as f32;
    }
    let mut levels = vec![full];
    for _ in 0..3 {
        let half = reduce::halve(&levels[levels.len() - 1]);
        levels.push(half);
    }
    let half_m = SIDE as f64 * 15.0;
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
            bands: Bands::Height,
            band_count: 1,
            sample_type: "float32".into(),
            compression: "none".into(),
            deep_colour: false,
            nodata: None,
            may_have_holes: true,
            georeference: Some(Georeference {
                crs: "EPSG:32612".into(),
                plane_from_pixel: [
                    457_000.0 - half_m,
                    30.0,
                    0.0,
                    4_483_000.0 + half_m,
                    0.0,
                    -30.0,
                ],
            }),
        },
        levels,
    })
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

fn warp(c: &mut Criterion) {
    let cancel = Cancel::default();
    let mut out = Block::new(Bands::Height, 256, 256);
    for (name, kernel, n) in [
        ("magnified, bilinear", Kernel::Bilinear, 12),
        ("magnified, bicubic", Kernel::Bicubic, 12),
        ("reduced by a tent", Kernel::Bilinear, 11),
    ] {
        let warp = Warp::new(file(), Planet::EARTH, kernel).expect("a georeferenced file");
        let grid = grid(n);
        c.bench_function(&format!("height tile from UTM: {name}"), |b| {
            b.iter(|| warp.render(&grid, &mut out, &cancel));
        });
    }
}

criterion_group!(benches, warp);
criterion_main!(benches);
