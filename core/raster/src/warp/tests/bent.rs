//! Grids that bend strongly against their file.

use super::*;

/// A polar file and a grid of longitudes and latitudes over it, whose rows are strongly bent.
fn bent() -> (Warp, Crs, Grid) {
    let name = "+proj=stere +lat_0=90 +lon_0=0 +datum=WGS84 +units=m";
    let half_m = 4_000_000.0;
    let block = heights(800, 800, |x, y| x + y);
    let place = [-half_m, 10_000.0, 0.0, half_m, 0.0, -10_000.0];
    let lattice = Lattice {
        crs: GridCrs::Projected("EPSG:4326".into()),
        origin: DVec2::new(-100.0, 83.0),
        step: DVec2::new(0.2, -0.1),
        columns_around: None,
    };
    let grid = Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 256, 256));
    (
        warp(Memory::file(block, name, place, 0)),
        Crs::parse(name).expect("known"),
        grid,
    )
}

#[test]
fn interpolated_places_keep_their_tolerance() {
    for tolerance_px in [0.0, 1e-4, 0.002, 0.02, 0.125, 0.5, 3.0] {
        let (warp, crs, grid) = bent();
        let warp = warp.with_approximation(Approximation {
            tolerance_px,
            ..Approximation::default()
        });
        let mut worst = 0.0_f64;
        warp.for_each_place(&grid, |i, place| {
            let p = grid
                .lattice
                .centre(I64Vec2::new(i as i64 % 256, i as i64 / 256));
            let (x, y) = crs
                .from_lonlat(p.x.to_radians(), p.y.to_radians())
                .expect("inside");
            let exact = DVec2::new(x + 4e6, 4e6 - y) / 10_000.0;
            worst = worst.max(place.distance(exact));
        })
        .expect("a known system");
        // Places within a window are singles.
        assert!(worst <= tolerance_px + 3e-5, "{tolerance_px}: {worst}");
    }
}

#[test]
fn a_strongly_bent_grid_is_followed_by_parabolas() {
    let (warp, _, grid) = bent();
    let patches = warp.geometry(&grid).expect("known").patches(&grid.rect);
    let each: i64 = patches
        .iter()
        .filter(|p| matches!(p.places, places::Places::Each(_)))
        .map(|p| p.rect.area())
        .sum();
    assert!(each == 0, "{each} samples");
    assert!(patches.len() < 400, "{} patches", patches.len());
}
