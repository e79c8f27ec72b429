mod edges;

use core::f64::consts::PI;
use std::path::PathBuf;

use glam::I64Vec2;
use proptest::prelude::*;
use relievo_planet::{GridCrs, Lattice, LevelKey, TileKey};

use super::*;
use crate::crs::Crs;
use crate::file::{Georeference, OverviewInfo, PixelRect, RasterInfo};
use crate::reduce;

mod bent;

/// A file in memory with a pyramid made by halving.
struct Memory {
    info: RasterInfo,
    levels: Vec<Block>,
}

impl Memory {
    fn file(
        full: Block,
        crs: &str,
        plane_from_pixel: [f64; 6],
        overviews: usize,
    ) -> Arc<dyn RasterFile> {
        let mut levels = vec![full];
        for _ in 0..overviews {
            let next = reduce::halve(&levels[levels.len() - 1]);
            levels.push(next);
        }
        let size = |b: &Block| OverviewInfo {
            width: b.width() as u32,
            height: b.height() as u32,
        };
        let info = RasterInfo {
            path: PathBuf::from("memory"),
            format: "memory",
            overviews: levels.iter().map(size).collect(),
            bands: levels[0].bands(),
            band_count: 1,
            sample_type: "float32".into(),
            compression: "none".into(),
            deep_colour: false,
            nodata: None,
            may_have_holes: true,
            georeference: Some(Georeference {
                crs: crs.into(),
                plane_from_pixel,
            }),
        };
        Arc::new(Self { info, levels })
    }
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
        out.reshape(level.bands(), rect.width as usize, rect.height as usize);
        let from = (rect.x as usize, rect.y as usize);
        out.copy_from(
            level,
            from,
            (0, 0),
            (rect.width as usize, rect.height as usize),
        );
        Ok(())
    }
}

fn heights(width: usize, height: usize, f: impl Fn(f64, f64) -> f64) -> Block {
    let mut block = Block::new(Bands::Height, width, height);
    for (i, v) in block.plane_mut(0).iter_mut().enumerate() {
        *v = f((i % width) as f64 + 0.5, (i / width) as f64 + 0.5) as f32;
    }
    block
}

/// A plate carrée of the whole globe whose columns begin at `west_deg`.
fn globe(
    width: usize,
    west_deg: f64,
    overviews: usize,
    f: impl Fn(f64, f64) -> f64,
) -> Arc<dyn RasterFile> {
    let step = 360.0 / width as f64;
    let block = heights(width, width / 2, |x, y| {
        f((west_deg + x * step).to_radians(), (y * step).to_radians())
    });
    Memory::file(
        block,
        "EPSG:4326",
        [west_deg, step, 0.0, 90.0, 0.0, -step],
        overviews,
    )
}

/// A square of `size` 90 m pixels in UTM 12N about 40.5° N, 111.5° W.
fn utm(size: usize, overviews: usize, f: impl Fn(f64, f64) -> f64) -> Arc<dyn RasterFile> {
    let half = size as f64 * 45.0;
    let place = [457_000.0 - half, 90.0, 0.0, 4_483_000.0 + half, 0.0, -90.0];
    Memory::file(heights(size, size, f), "EPSG:26912", place, overviews)
}

fn warp(file: Arc<dyn RasterFile>) -> Warp {
    Warp::new(file, Planet::EARTH, Kernel::Bilinear).expect("a georeferenced file")
}

fn render(warp: &Warp, grid: &Grid) -> Block {
    let mut out = Block::new(Bands::Height, 0, 0);
    warp.render(grid, &mut out, &Cancel::default())
        .expect("memory does not fail");
    out
}

fn level_grid(n: u8, lon_deg: f64, lat_deg: f64, width: i64, height: i64) -> Grid {
    let level = LevelKey::new(n + 1, n);
    let at = level
        .sample_from_map(MapPoint::from_degrees(lon_deg, lat_deg))
        .floor()
        .as_i64vec2();
    let rect = SampleRect::at(at.x - width / 2, at.y - height / 2, width, height);
    Grid::new(Arc::new(level.lattice()), rect)
}

fn bits(block: &Block) -> Vec<u32> {
    block.samples().iter().map(|v| v.to_bits()).collect()
}

/// The grid of a rectangle of a grid's samples.
fn part_of(grid: &Grid, column: i64, row: i64, width: i64, height: i64) -> Grid {
    let min = grid.rect.min + I64Vec2::new(column, row);
    grid.with_rect(SampleRect::at(min.x, min.y, width, height))
}

/// Asserts that parts cut anywhere equal the whole, in both orders of making them.
fn assert_tiled_equals_whole(warp: &Warp, grid: &Grid, cut: (i64, i64)) {
    let whole = render(warp, grid);
    let (w, h) = (grid.rect.width(), grid.rect.height());
    let mut parts = vec![(0, 0, cut.0, cut.1), (cut.0, 0, w - cut.0, cut.1)];
    parts.extend([
        (0, cut.1, cut.0, h - cut.1),
        (cut.0, cut.1, w - cut.0, h - cut.1),
    ]);
    for _ in 0..2 {
        let mut tiled = Block::new(whole.bands(), whole.width(), whole.height());
        for (x, y, pw, ph) in &parts {
            let part = render(warp, &part_of(grid, *x, *y, *pw, *ph));
            let size = (*pw as usize, *ph as usize);
            tiled.copy_from(&part, (0, 0), (*x as usize, *y as usize), size);
        }
        assert_eq!(bits(&tiled), bits(&whole));
        parts.reverse();
    }
}

fn rough(x: f64, y: f64) -> f64 {
    if libm::sin(x * 0.11) * libm::cos(y * 0.07) > 0.93 {
        f64::NAN
    } else {
        1500.0
            + 700.0 * libm::sin(x * 0.3 + y * 0.1)
            + 40.0 * libm::cos(x * 1.7) * libm::sin(y * 2.1)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn parts_equal_the_whole_in_a_projected_source(
        n in 7..13_u8, lon in -112.2..-110.8_f64, lat in 40.0..41.0_f64, cut in (1..90_i64, 1..70_i64),
        kernel in prop::sample::select(vec![Kernel::Nearest, Kernel::Bilinear, Kernel::Bicubic]),
    ) {
        let warp = Warp::new(utm(300, 3, rough), Planet::EARTH, kernel).expect("a good file");
        assert_tiled_equals_whole(&warp, &level_grid(n, lon, lat, 91, 71), cut);
    }

    #[test]
    fn parts_equal_the_whole_across_the_antimeridian_and_at_the_poles(
        n in 1..6_u8, lon in -182.0..182.0_f64, lat in prop::sample::select(vec![-89.9, -60.0, 0.3, 75.0, 89.9]),
        west in prop::sample::select(vec![-180.0, 0.0, -37.3]), cut in (1..90_i64, 1..70_i64),
    ) {
        let warp = warp(globe(512, west, 3, |lon, colat| rough(lon * 40.0, colat * 60.0)));
        let mut grid = level_grid(n, lon, lat, 91, 71);
        let rows = LevelKey::new(n + 1, n).samples().y;
        grid.rect = grid.rect.intersection(&SampleRect::at(-10_000, 0, 30_000, rows));
        let cut = (cut.0, cut.1.min(grid.rect.height() - 1));
        assert_tiled_equals_whole(&warp, &grid, cut);
    }

    #[test]
    fn a_constant_stays_constant_to_the_bit(
        n in 2..13_u8, value in -9e3..9e3_f32, lon in -112.2..-110.8_f64, lat in 40.0..41.0_f64,
    ) {
        for file in [utm(200, 2, |_, _| f64::from(value)), globe(256, -180.0, 2, |_, _| f64::from(value))] {
            let out = render(&warp(file), &level_grid(n, lon, lat, 64, 64));
            for v in out.samples() {
                prop_assert!(v.is_nan() || v.to_bits() == value.to_bits());
            }
        }
    }

    #[test]
    fn a_ramp_in_the_source_is_reproduced_by_its_places(lon in -111.6..-111.4_f64, lat in 40.4..40.6_f64) {
        let warp = warp(utm(600, 0, |x, y| 3.0 * x + 2.0 * y));
        let grid = level_grid(11, lon, lat, 40, 40);
        let out = render(&warp, &grid);
        let crs = Crs::parse("EPSG:26912").expect("a known system");
        for (i, v) in out.samples().iter().enumerate() {
            let at = grid.rect.min + I64Vec2::new(i as i64 % 40, i as i64 / 40);
            let p = grid.lattice.map_point(at);
            let (x, y) = crs.from_lonlat(p.lon_rad, p.lat_rad()).expect("inside");
            let (column, row) = ((x - 430_000.0) / 90.0, (4_510_000.0 - y) / 90.0);
            prop_assert!((f64::from(*v) - (3.0 * column + 2.0 * row)).abs() < 0.02, "{v}");
        }
    }

    #[test]
    fn coverage_never_errs_when_it_is_sure(
        n in 0..12_u8, lon in -180.0..180.0_f64, lat in -88.0..88.0_f64, near in any::<bool>(),
    ) {
        let (lon, lat) = if near { (-111.5 + lon / 180.0, 40.5 + lat / 88.0) } else { (lon, lat) };
        let warp = warp(utm(400, 4, |_, _| 1.0));
        let grid = level_grid(n, lon, lat, 48, 48);
        let valid = render(&warp, &grid).samples().iter().filter(|v| !v.is_nan()).count();
        match warp.coverage(&grid) {
            Coverage::Outside => prop_assert_eq!(valid, 0),
            Coverage::Inside => prop_assert_eq!(valid, 48 * 48),
            Coverage::Partial => {}
        }
    }
}

#[test]
fn a_globe_has_no_seam_where_its_columns_meet() {
    let f = |lon: f64, colat: f64| 1000.0 * libm::sin(colat) * libm::cos(lon);
    for west in [-180.0, 0.0] {
        let warp = warp(globe(720, west, 3, f));
        for n in [1, 2, 4] {
            for lon in [-180.0, 0.0, 180.0] {
                let grid = level_grid(n, lon, 10.0, 32, 8);
                for (i, v) in render(&warp, &grid).samples().iter().enumerate() {
                    let p = grid
                        .lattice
                        .map_point(grid.rect.min + I64Vec2::new(i as i64 % 32, i as i64 / 32));
                    assert!(
                        (f64::from(*v) - f(p.lon_rad, p.colat_rad)).abs() < 2.0,
                        "{p:?} {v}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_globe_is_smooth_over_the_poles() {
    // Height of a plane that cuts the sphere: no place of the globe is special.
    let f = |lon: f64, colat: f64| {
        1000.0
            * (0.7 * libm::sin(colat) * libm::cos(lon)
                + 0.2 * libm::cos(colat)
                + 0.4 * libm::sin(colat) * libm::sin(lon))
    };
    let warp = warp(globe(1440, -180.0, 4, f));
    for n in 1..5 {
        let level = LevelKey::new(n + 1, n);
        for row in [0, level.samples().y - 20] {
            let grid = Grid::new(
                Arc::new(level.lattice()),
                SampleRect::at(0, row, level.samples().x, 20),
            );
            let out = render(&warp, &grid);
            let mut worst = 0.0_f64;
            for (i, v) in out.samples().iter().enumerate() {
                let at = I64Vec2::new(
                    i as i64 % level.samples().x,
                    row + i as i64 / level.samples().x,
                );
                let p = grid.lattice.map_point(at);
                worst = worst.max((f64::from(*v) - f(p.lon_rad, p.colat_rad)).abs());
            }
            // The kernel's own radius on the ground, times the steepest slope.
            assert!(
                worst < 1000.0 * level.step_rad().y,
                "level {n} row {row}: {worst}"
            );
        }
    }
}

#[test]
fn a_source_across_the_antimeridian_is_found_from_both_sides() {
    let block = heights(200, 100, |x, _| x);
    let file = Memory::file(block, "EPSG:4326", [170.0, 0.1, 0.0, 5.0, 0.0, -0.1], 0);
    let warp = warp(file);
    for (lon, expected) in [
        (175.0, 50.0),
        (-175.0, 150.0),
        (179.99, 99.9),
        (-179.99, 100.1),
        (185.0, 150.0),
    ] {
        let grid = level_grid(7, lon, 0.0, 1, 1);
        let v = f64::from(render(&warp, &grid).samples()[0]);
        assert!((v - expected).abs() < 0.2, "{lon}: {v}");
        assert_ne!(warp.coverage(&grid), Coverage::Outside);
    }
    assert_eq!(
        warp.coverage(&level_grid(7, 160.0, 0.0, 4, 4)),
        Coverage::Outside
    );
}

#[test]
fn nothing_is_shifted_at_any_level() {
    // Mean offset against the function itself, from the product of residual and slope.
    for (n, overviews) in [(9, 4), (8, 4), (7, 4), (6, 4), (6, 0)] {
        let wave = |x: f64, y: f64| libm::sin(x * 0.02) + libm::cos(y * 0.017 + x * 0.004);
        let warp = warp(utm(1024, overviews, wave));
        let grid = level_grid(n, -111.5, 40.5, 40, 40);
        let out = render(&warp, &grid);
        let crs = Crs::parse("EPSG:26912").expect("a known system");
        let (mut num, mut den) = ([0.0; 2], [0.0; 2]);
        for (i, v) in out.samples().iter().enumerate() {
            let p = grid
                .lattice
                .map_point(grid.rect.min + I64Vec2::new(i as i64 % 40, i as i64 / 40));
            let (x, y) = crs.from_lonlat(p.lon_rad, p.lat_rad()).expect("inside");
            let half = 512.0 * 90.0;
            let (x, y) = (
                (x - 457_000.0 + half) / 90.0,
                (4_483_000.0 + half - y) / 90.0,
            );
            if v.is_nan() {
                continue;
            }
            let residual = f64::from(*v) - wave(x, y);
            let slope = [
                (wave(x + 0.5, y) - wave(x - 0.5, y)),
                (wave(x, y + 0.5) - wave(x, y - 0.5)),
            ];
            for axis in 0..2 {
                num[axis] += residual * slope[axis];
                den[axis] += slope[axis] * slope[axis];
            }
        }
        for axis in 0..2 {
            let shift = num[axis] / den[axis];
            // In pixels of the level that is read.
            let pixel = f64::from(1_u32 << (10 - n).min(4));
            assert!(
                den[axis] > 0.0 && shift.abs() / pixel < 0.01,
                "level {n}, axis {axis}: {shift} px"
            );
        }
    }
}

#[test]
fn a_coarse_grid_averages_what_it_covers() {
    // A chessboard of single pixels: any sampling without averaging gives 0 or 1.
    for overviews in [0, 4] {
        let warp = warp(utm(512, overviews, |x, y| {
            ((x as i64 + y as i64) % 2) as f64
        }));
        let out = render(&warp, &level_grid(6, -111.5, 40.5, 8, 8));
        assert!(
            out.samples().iter().all(|v| (v - 0.5).abs() < 0.01),
            "{:?}",
            out.samples()
        );
    }
}

/// Width by height on the ground, in metres, of a hill's image at a coarse level.
fn hill_ratio(lon_deg: f64, lat_deg: f64, west_deg: f64) -> f64 {
    let hill = MapPoint::from_degrees(lon_deg, lat_deg);
    let file = globe(4096, west_deg, 5, |lon, colat| {
        if (colat - hill.colat_rad).abs() > 0.02 {
            return 0.0; // the hill is e⁻¹⁰⁰ high here
        }
        let d = MapPoint::new(lon, colat).angle_to(hill);
        libm::exp(-(d / 0.002).powi(2))
    });
    let level = LevelKey::new(3, 2);
    let grid = Grid::new(
        Arc::new(level.lattice()),
        SampleRect::at(0, 0, level.samples().x, 60),
    );
    let out = render(&warp(file), &grid);
    let places: Vec<(f64, MapPoint)> = (0..)
        .zip(out.samples())
        .map(|(i, v)| {
            let columns = level.samples().x;
            let p = grid
                .lattice
                .map_point(I64Vec2::new(i % columns, i / columns));
            (f64::from(*v) * libm::sin(p.colat_rad), p)
        })
        .collect();
    let sum: f64 = places.iter().map(|(w, _)| w).sum();
    assert!(sum > 0.0);
    // About the image's own middle, since a coarse row is not where the hill is.
    let middle = places.iter().map(|(w, p)| w * p.colat_rad).sum::<f64>() / sum;
    let (mut east, mut south) = (0.0, 0.0);
    for (w, p) in &places {
        let across = relievo_planet::map::wrap_longitude(p.lon_rad - hill.lon_rad);
        east += w * (across * libm::sin(p.colat_rad)).powi(2);
        south += w * (p.colat_rad - middle).powi(2);
    }
    (east / south).sqrt()
}

#[test]
fn the_kernel_is_round_on_the_ground_beside_the_pole() {
    // Rows of grid and overview coincide where columns begin at -180°, so the kernel is at its
    // narrowest along them; without a wider one along columns the ratio would be 0.85.
    for (lon, lat, west) in [
        (20.0, 85.0, -180.0),
        (20.37, 85.21, -180.0),
        (-133.1, 84.83, -37.3),
        (71.03, 86.1, 11.7),
        (179.9, 84.4, -180.0),
    ] {
        let ratio = hill_ratio(lon, lat, west);
        assert!((0.9..1.25).contains(&ratio), "{lon} {lat}: {ratio}");
    }
}

#[test]
fn a_grid_in_the_sources_own_system_needs_no_projection() {
    let warp = warp(utm(64, 0, |x, y| x * 10.0 + y));
    let lattice = Lattice {
        crs: GridCrs::Projected("EPSG:26912".into()),
        origin: DVec2::new(457_000.0 - 32.0 * 90.0, 4_483_000.0 + 32.0 * 90.0),
        step: DVec2::new(90.0, -90.0),
        columns_around: None,
    };
    let grid = Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 64, 64));
    let out = render(&warp, &grid);
    for (i, v) in out.samples().iter().enumerate() {
        let expected = ((i % 64) as f32 + 0.5) * 10.0 + (i / 64) as f32 + 0.5;
        assert!((v - expected).abs() < 1e-3, "{v} {expected}");
    }
}

#[test]
fn a_grid_about_the_pole_in_a_polar_system_sees_the_whole_circle() {
    let f = |lon: f64, colat: f64| 1000.0 * libm::sin(colat) * libm::cos(lon);
    let warp = warp(globe(1440, -180.0, 4, f));
    let lattice = Lattice {
        crs: GridCrs::Projected("+proj=stere +lat_0=90 +lon_0=0 +datum=WGS84 +units=m".into()),
        origin: DVec2::new(-1_000_000.0, 1_000_000.0),
        step: DVec2::new(20_000.0, -20_000.0),
        columns_around: None,
    };
    let crs = Crs::parse("+proj=stere +lat_0=90 +lon_0=0 +datum=WGS84 +units=m").expect("known");
    let grid = Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 100, 100));
    for (i, v) in render(&warp, &grid).samples().iter().enumerate() {
        let p = grid
            .lattice
            .centre(I64Vec2::new(i as i64 % 100, i as i64 / 100));
        let (lon, lat) = crs.to_lonlat(p.x, p.y).expect("inside");
        assert!(
            (f64::from(*v) - f(lon, PI / 2.0 - lat)).abs() < 3.0,
            "{i}: {v}"
        );
    }
    assert_eq!(warp.coverage(&grid), Coverage::Inside);
}

#[test]
fn colours_beside_transparency_keep_their_hue() {
    let mut block = Block::filled(Bands::Colour, 64, 64, &[0.8, 0.4, 0.2, 1.0]);
    for plane in 0..4 {
        for (i, v) in block.plane_mut(plane).iter_mut().enumerate() {
            if i % 64 < 32 {
                *v = 0.0;
            }
        }
    }
    let file = Memory::file(block, "EPSG:4326", [0.0, 0.1, 0.0, 3.2, 0.0, -0.1], 2);
    let mut out = Block::new(Bands::Colour, 0, 0);
    let grid = TileKey::new(LevelKey::new(5, 4), 16, 7)
        .expect("inside")
        .grid();
    warp(file)
        .render(&grid, &mut out, &Cancel::default())
        .expect("memory does not fail");
    let mut partial = 0;
    for i in 0..256 * 256 {
        let a = out.plane(3)[i];
        partial += usize::from(a > 0.0 && a < 1.0);
        for (plane, v) in [0.8, 0.4, 0.2].into_iter().enumerate() {
            assert!((out.plane(plane)[i] - if a > 0.0 { v } else { 0.0 }).abs() < 2e-5);
        }
    }
    assert!(partial > 0);
}

#[test]
fn a_cancelled_warp_says_so_and_an_unplaced_file_is_refused() {
    let cancel = Cancel::default();
    cancel.cancel();
    let grid = level_grid(9, -111.5, 40.5, 8, 8);
    let mut out = Block::new(Bands::Height, 0, 0);
    assert!(matches!(
        warp(utm(300, 0, |_, _| 0.0)).render(&grid, &mut out, &cancel),
        Err(ReadError::Cancelled)
    ));
    let nowhere = Memory::file(heights(2, 2, |_, _| 0.0), "EPSG:4326", [0.0; 6], 0);
    assert!(matches!(
        Warp::new(nowhere, Planet::EARTH, Kernel::Bilinear),
        Err(WarpError::Degenerate { .. })
    ));
}
