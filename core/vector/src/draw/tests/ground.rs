//! Widths, areas and dashes as they are on the ground.

use core::f64::consts::PI;

use super::*;

/// Square metres that a drawing covers, by alpha.
fn area_m2(block: &Block, grid: &Grid) -> f64 {
    let mut area = 0.0;
    for (i, a) in block.plane(3).iter().enumerate() {
        let row = grid.rect.min.y + (i / block.width()) as i64;
        let p = grid.lattice.centre(I64Vec2::new(0, row));
        let size = Planet::EARTH.metres_per_radian(p.y) * grid.lattice.step.abs();
        area += f64::from(*a) * size.x * size.y;
    }
    area
}

#[test]
fn a_one_metre_line_has_its_width_in_every_direction_and_at_every_latitude() {
    for lat in [0.0, -40.0, 65.0, 80.0, 89.0] {
        for azimuth in [0.0, 30.0, 45.0, 90.0, 135.0] {
            for lon in [-170.0, 0.0, 111.65] {
                let mut b = Builder::degrees();
                b.line(segment(lon, lat, azimuth, 6.0)).unwrap();
                let drawing = drawing(b.finish().unwrap(), stroke(Length::Metres(1.0)));
                // About as wide as high on the ground.
                let narrower = (-lat.to_radians().cos().log2()) as u8;
                let level = LevelKey::new(21 - narrower, 20);
                let grid = around(level, lon, lat, 512);
                let covered = area_m2(&draw(&drawing, &grid), &grid);
                // With its round ends.
                let exact = 6.0 + PI / 4.0;
                assert!(
                    (covered / exact - 1.0).abs() < 0.04,
                    "{covered} m² at {lat}, azimuth {azimuth}"
                );
            }
        }
    }
}

#[test]
fn a_line_narrower_than_a_sample_fades_instead_of_vanishing() {
    let mut b = Builder::degrees();
    b.line(segment(10.0, 50.0, 37.0, 4000.0)).unwrap();
    let features = Arc::new(b.finish().unwrap());
    let level = LevelKey::new(13, 12);
    let grid = around(level, 10.02, 50.015, 512);
    for width in [4.0, 1.0, 0.25] {
        let style = stroke(Length::Metres(width));
        let drawing = Drawing::new(Arc::clone(&features), style, Planet::EARTH);
        let covered = area_m2(&draw(&drawing, &grid), &grid);
        assert!(
            (covered / (4000.0 * width) - 1.0).abs() < 0.05,
            "{width}: {covered}"
        );
    }
}

#[test]
fn a_fill_covers_the_area_that_it_has_on_the_ground() {
    let ring = [[10.0, 60.0], [12.0, 60.2], [11.8, 61.0], [10.3, 60.8]];
    let mut b = Builder::degrees();
    b.ring(ring, false).unwrap();
    b.ring(
        [[10.8, 60.4], [11.2, 60.4], [11.2, 60.6], [10.8, 60.6]],
        true,
    )
    .unwrap();
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let grid = around(LevelKey::new(8, 8), 11.0, 60.5, 800);
    let covered = area_m2(&draw(&drawing, &grid), &grid);
    // The same integral in narrow strips of latitude.
    let width = |ring: &[[f64; 2]], lat: f64| {
        let mut at: Vec<f64> = (0..ring.len())
            .filter_map(|i| {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                ((a[1] > lat) != (b[1] > lat))
                    .then(|| a[0] + (b[0] - a[0]) * (lat - a[1]) / (b[1] - a[1]))
            })
            .collect();
        at.sort_by(f64::total_cmp);
        at.chunks_exact(2).map(|c| c[1] - c[0]).sum::<f64>()
    };
    let hole = [[10.8, 60.4], [11.2, 60.4], [11.2, 60.6], [10.8, 60.6]];
    let steps = 20_000;
    let exact: f64 = (0..steps)
        .map(|i| {
            let lat = 59.9 + 1.2 * (f64::from(i) + 0.5) / f64::from(steps);
            let m = Planet::EARTH.metres_per_radian((90.0 - lat).to_radians());
            let w = (width(&ring, lat) - width(&hole, lat)).to_radians();
            w * m.x * m.y * (1.2 / f64::from(steps)).to_radians()
        })
        .sum();
    assert!(
        (covered / exact - 1.0).abs() < 2e-3,
        "{covered} for {exact}"
    );
}

/// Also where a ring is smaller than its stroke and is drawn by the shape around it.
#[test]
fn a_stroke_covers_what_lies_within_half_its_width_of_the_line() {
    let metres = Planet::EARTH.metres_per_radian(core::f64::consts::FRAC_PI_2);
    for (n, widths_m) in [
        (13, [10.0, 20.0, 40.0]),
        (14, [5.0, 8.0, 20.0]),
        (16, [1.5, 3.0, 9.0]),
    ] {
        for i in 0..8 {
            let ring = house(8, i, 0.0);
            let corners = ring.map(|p| DVec2::from(p.map(f64::to_radians)));
            let grid = around(LevelKey::new(n, n), ring[0][0], ring[0][1], 40);
            let (low, high) = corners
                .iter()
                .fold((corners[0], corners[0]), |(low, high), c| {
                    (low.min(*c), high.max(*c))
                });
            if (high - low).cmplt(0.5 * grid.lattice.step).all() {
                // Drawn by its area alone.
                continue;
            }
            for width_m in widths_m {
                let mut b = Builder::degrees();
                b.ring(ring, false).unwrap();
                let drawing = drawing(b.finish().unwrap(), stroke(Length::Metres(width_m)));
                let block = draw(&drawing, &grid);
                let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
                for (k, alpha) in block.plane(3).iter().enumerate() {
                    let sample = DVec2::new((k % 40) as f64, (k / 40) as f64);
                    let points = (0..64).map(|j| {
                        let at =
                            sample + (DVec2::new(f64::from(j % 8), f64::from(j / 8)) + 0.5) / 8.0;
                        let at = grid.lattice.origin
                            + (grid.rect.min.as_dvec2() + at) * grid.lattice.step;
                        DVec2::new(at.x, core::f64::consts::FRAC_PI_2 - at.y)
                    });
                    let inside = points.filter(|p| {
                        (0..5).any(|e| {
                            let (a, b) = (corners[e] * metres, corners[(e + 1) % 5] * metres);
                            let (d, v) = (b - a, *p * metres - a);
                            let t = (v.dot(d) / d.length_squared()).clamp(0.0, 1.0);
                            (v - d * t).length() <= 0.5 * width_m
                        })
                    });
                    let exact = inside.count() as f64 / 64.0;
                    let difference = (f64::from(*alpha) - exact).abs();
                    if exact > 0.0 || *alpha > 0.0 {
                        sum += difference;
                        count += 1.0;
                    }
                    worst = worst.max(difference);
                }
                let name = format!("level {n}, house {i}, {width_m} m");
                assert!(
                    sum / count < 0.05 && worst < 0.3,
                    "{name}: {} {worst}",
                    sum / count
                );
            }
        }
    }
}

#[test]
fn dashes_have_their_length_and_go_on_from_tile_to_tile() {
    let mut b = Builder::degrees();
    b.line(segment(8.0, 47.0, 90.0, 1000.0)).unwrap();
    let style = Style {
        dash: vec![30.0, 20.0],
        ..stroke(Length::Metres(40.0))
    };
    let drawing = drawing(b.finish().unwrap(), style);
    let grid = around(LevelKey::new(15, 14), 8.0066, 47.0, 1000);
    let covered = area_m2(&draw(&drawing, &grid), &grid);
    assert!((covered / 24_000.0 - 1.0).abs() < 0.02, "{covered}");
}

#[test]
fn a_projected_grid_shows_the_same_areas() {
    let ring = [
        [-111.7, 40.2],
        [-111.6, 40.21],
        [-111.61, 40.3],
        [-111.72, 40.28],
    ];
    let mut b = Builder::degrees();
    b.ring(ring, false).unwrap();
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let utm = Lattice {
        crs: relievo_planet::GridCrs::Projected("EPSG:26912".into()),
        origin: DVec2::new(430_000.0, 4_470_000.0),
        step: DVec2::new(30.0, -30.0),
        columns_around: None,
    };
    let projected = Grid::new(Arc::new(utm), SampleRect::at(0, 0, 900, 800));
    let alphas: f64 = draw(&drawing, &projected)
        .plane(3)
        .iter()
        .map(|a| f64::from(*a))
        .sum();
    let map = around(LevelKey::new(12, 11), -111.66, 40.25, 900);
    let on_map = area_m2(&draw(&drawing, &map), &map);
    // UTM shortens by 0.9996 at its middle meridian.
    assert!(
        (alphas * 900.0 / on_map - 0.9992).abs() < 1e-3,
        "{} {on_map}",
        alphas * 900.0
    );
}
