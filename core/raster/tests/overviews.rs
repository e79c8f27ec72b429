//! Overviews lie where the full image does, whatever its size.

use std::sync::Arc;

use glam::DVec2;
use relievo_planet::{Grid, GridCrs, Lattice, Planet, SampleRect};
use relievo_raster::file::Georeference;
use relievo_raster::open::{OpenOptions, open};
use relievo_raster::warp::{Kernel, Warp};
use relievo_raster::{Bands, Block, Cancel};

const WIDTH: u32 = 1201;
const HEIGHT: u32 = 603;
const PIXEL_M: f64 = 30.0;

/// Heights along a row, a whole number per column.
fn ramp(x: u32) -> u16 {
    (16 * x) as u16
}

#[test]
fn a_ramp_of_odd_size_is_not_shifted_at_any_overview() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ramp.png");
    let picture = image::ImageBuffer::from_fn(WIDTH, HEIGHT, |x, _| image::Luma([ramp(x)]));
    picture.save(&path).unwrap();
    let options = OpenOptions {
        as_bands: Some(Bands::Height),
        georeference: Some(Georeference {
            crs: Arc::from("EPSG:32612"),
            plane_from_pixel: [440_000.0, PIXEL_M, 0.0, 4_485_000.0, 0.0, -PIXEL_M],
        }),
        ..OpenOptions::default()
    };
    let file = open(&path, &options).unwrap();
    let overviews = file.info().overviews.clone();
    assert_eq!(overviews.len(), 4);
    for (level, size) in overviews.iter().enumerate() {
        // Samples as large as the level's pixels, but elsewhere.
        let pixels = f64::from(WIDTH) / f64::from(size.width);
        let step = pixels.max(f64::from(HEIGHT) / f64::from(size.height)) * 1.01;
        let lattice = Lattice {
            crs: GridCrs::Projected(Arc::from("EPSG:32612")),
            origin: DVec2::new(440_000.0 + 0.3 * PIXEL_M, 4_485_000.0),
            step: DVec2::new(step, -step) * PIXEL_M,
            columns_around: None,
        };
        let columns = (f64::from(WIDTH) / step) as i64;
        let rows = (f64::from(HEIGHT) / step) as i64;
        let grid = Grid::new(
            Arc::new(lattice),
            SampleRect::at(2, 2, columns - 4, rows - 4),
        );
        let warp = Warp::new(Arc::clone(&file), Planet::EARTH, Kernel::Bilinear).unwrap();
        let mut out = Block::new(Bands::Height, 0, 0);
        warp.render(&grid, &mut out, &Cancel::default()).unwrap();
        for (i, found) in out.samples().iter().enumerate() {
            let column = 2 + i % out.width();
            let place = 0.3 + (column as f64 + 0.5) * step;
            let expected = 16.0 * (place - 0.5);
            let shift = (f64::from(*found) - expected) / 16.0 / step;
            assert!(
                shift.abs() < 0.05,
                "level {level}, column {column}: shifted by {shift} pixels"
            );
        }
    }
}
