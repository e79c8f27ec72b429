//! Poles, the antimeridian, other planes, small and large planets.

use core::f64::consts::PI;

use super::*;

/// A disc of a radius around a centre, of one colour over another.
fn disc(planet: Planet, centre: MapPoint, radius_m: f64, reach_m: f64) -> Scene {
    let below = colours(|_, _| grey(0.3));
    let layer = colours(move |place, _| {
        let inside = planet.offset_m(centre, place).length() < radius_m;
        if inside { grey(0.7) } else { [0.0; 4] }
    });
    Scene::new(planet, reach_m, &[below, layer])
}

/// The largest difference of what is added from what a straight seam of as many metres would add, over
/// samples inside of the disc.
fn error(
    scene: &Scene,
    planet: Planet,
    grid: &Grid,
    centre: MapPoint,
    radius_m: f64,
    reach_m: f64,
) -> f32 {
    let added = scene.added(grid);
    let rect = grid.rect;
    let mut largest = 0.0_f32;
    for y in rect.min.y..rect.max.y {
        for x in rect.min.x..rect.max.x {
            let place = grid.lattice.map_point(glam::I64Vec2::new(x, y));
            let from_seam_m = radius_m - planet.offset_m(centre, place).length();
            if from_seam_m <= 0.0 {
                continue;
            }
            let t = (from_seam_m / (SUPPORT * reach_m)).min(1.0) as f32;
            let expected = -0.4 * (1.0 - t * t * (3.0 - 2.0 * t));
            largest = largest.max((added(x, y) - expected).abs());
        }
    }
    largest
}

#[test]
fn around_and_beside_a_pole_distances_are_metres_in_every_direction() {
    let planet = Planet::EARTH;
    // A level as it is used there: a tile around the planet, rows of some 300 m.
    let level = LevelKey::new(0, 8);
    let row_m = spacing_m(level);
    for colat_rad in [0.0, 0.6 * 30.0 * row_m / planet.radius_m] {
        for south in [false, true] {
            let centre = MapPoint::new(1.0, if south { PI - colat_rad } else { colat_rad });
            let (radius_m, reach_m) = (30.0 * row_m, 24.0 * row_m);
            let scene = disc(planet, centre, radius_m, reach_m);
            let first = if south { level.samples().y - 60 } else { 0 };
            let grid = grid(level, SampleRect::at(0, first, 256, 60));
            // Seams are found to a sample or so, and the taper falls by 1.5 · 0.4 in 18 of them.
            let error = error(&scene, planet, &grid, centre, radius_m, reach_m);
            assert!(error < 0.06, "{colat_rad} {south}: {error}");
        }
    }
}

#[test]
fn far_from_the_equator_the_reach_is_as_wide_as_high() {
    let planet = Planet::EARTH;
    for (lat_deg, level) in [
        (60.0, LevelKey::new(14, 14)),
        (-60.0, LevelKey::new(15, 14)),
        (0.0, FINE),
    ] {
        let centre = MapPoint::from_degrees(20.0, lat_deg);
        let row_m = spacing_m(level);
        for rows in [20.0, 80.0] {
            let (radius_m, reach_m) = (60.0 * row_m, rows * row_m);
            let scene = disc(planet, centre, radius_m, reach_m);
            let middle = level.sample_from_map(centre).as_i64vec2();
            let rect = SampleRect::new(
                middle - glam::I64Vec2::new(130, 65),
                middle + glam::I64Vec2::new(130, 65),
            );
            let error = error(
                &scene,
                planet,
                &grid(level, rect),
                centre,
                radius_m,
                reach_m,
            );
            assert!(error < 0.05, "{lat_deg} {rows}: {error}");
        }
    }
}

#[test]
fn across_the_antimeridian_it_is_as_anywhere_else() {
    let planet = Planet::EARTH;
    let (radius_m, reach_m) = (50.0 * spacing_m(FINE), 70.0 * spacing_m(FINE));
    let quarter = FINE.samples().x / 4;
    let [across, elsewhere] = [-PI, -PI / 2.0].map(|lon_rad| {
        let scene = disc(planet, MapPoint::new(lon_rad, PI / 2.0), radius_m, reach_m);
        let west = if lon_rad == -PI { 0 } else { quarter };
        scene.added(&grid(
            FINE,
            SampleRect::at(west - 64, PLACE.y - 64, 128, 128),
        ))
    });
    for y in PLACE.y - 64..PLACE.y + 64 {
        for x in -64..64 {
            let (a, b) = (across(x, y), elsewhere(quarter + x, y));
            assert!((a - b).abs() < 0.01, "{x} {y}: {a} {b}");
        }
    }
}

#[test]
fn over_a_pole_and_around_the_planet_tiles_meet() {
    // A level with many more columns than its rows there ask for, and one with few.
    for (level, rows) in [
        (LevelKey::new(4, 6), 20.0),
        (LevelKey::new(1, 3), 9.0),
        (LevelKey::new(0, 3), 40.0),
    ] {
        let reach_m = rows * spacing_m(level);
        let centre = MapPoint::new(-PI, 6.0 * level.lattice().step.y);
        let scene = disc(Planet::EARTH, centre, 15.0 * spacing_m(level), reach_m);
        let columns = level.samples().x;
        let added = scene.added(&grid(level, SampleRect::at(-40, -30, 80, 60)));
        let inside = scene.added(&grid(level, SampleRect::at(0, 0, columns, 40)));
        for y in -30..30 {
            for x in -40..40 {
                let at = level.wrap_sample(glam::I64Vec2::new(x, y));
                assert_eq!(
                    added(x, y).to_bits(),
                    inside(at.x, at.y).to_bits(),
                    "{x} {y}"
                );
            }
            for x in -40..39 {
                // Columns are nearer to each other than rows.
                let step = (added(x + 1, y) - added(x, y)).abs();
                let both = [x, x + 1].map(|x| {
                    let at = level.lattice().map_point(glam::I64Vec2::new(x, y));
                    Planet::EARTH.offset_m(centre, at).length() < 15.0 * spacing_m(level)
                });
                assert!(both != [true; 2] || step < 0.1, "{level:?} {x} {y}: {step}");
            }
        }
    }
}

#[test]
fn on_a_projected_grid_it_is_the_same_in_metres() {
    let planet = Planet::EARTH;
    let centre = MapPoint::from_degrees(-111.65, 40.25);
    let (radius_m, reach_m) = (300.0, 240.0);
    let scene = disc(planet, centre, radius_m, reach_m);
    let crs = relievo_raster::crs::Crs::parse("EPSG:26912").expect("a system");
    let at = crs
        .from_lonlat(centre.lon_rad, PI / 2.0 - centre.colat_rad)
        .expect("a place");
    for spacing in [2.0, 10.0] {
        let lattice = Arc::new(relievo_planet::Lattice {
            crs: GridCrs::Projected("EPSG:26912".into()),
            origin: glam::DVec2::new(400_000.0, 4_500_000.0),
            step: glam::DVec2::new(spacing, -spacing),
            columns_around: None,
        });
        let middle = lattice.sample_from_plane(at.into()).as_i64vec2();
        let half = (360.0 / spacing) as i64;
        let rect = SampleRect::new(middle - half, middle + half);
        let grid = Grid::new(Arc::clone(&lattice), rect);
        let added = scene.added(&grid);
        let ground = super::super::super::ground::Ground::new(&lattice, "test").expect("a system");
        let mut largest = 0.0_f32;
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let place = ground
                    .point(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
                    .expect("a place");
                let from_seam_m = radius_m - planet.offset_m(centre, place).length();
                if from_seam_m > 0.0 {
                    let t = (from_seam_m / (SUPPORT * reach_m)).min(1.0) as f32;
                    let expected = -0.4 * (1.0 - t * t * (3.0 - 2.0 * t));
                    largest = largest.max((added(x, y) - expected).abs());
                }
            }
        }
        assert!(largest < 0.06, "{spacing}: {largest}");
    }
}

#[test]
fn planets_of_any_size_and_reaches_of_any_length_are_bounded() {
    for radius_m in [1.0, 500.0, 6.4e6, 3.5e7, 1e9] {
        let planet = Planet::sphere(radius_m);
        for reach in [1e-4, 1e-2, 0.5, 3.0, 1e6] {
            let reach_m = reach * radius_m;
            let centre = MapPoint::from_degrees(10.0, 20.0);
            let scene = disc(planet, centre, 0.7 * radius_m, reach_m);
            for level in [
                LevelKey::new(2, 1),
                LevelKey::new(7, 6),
                LevelKey::new(13, 12),
            ] {
                let node = SeamBlend::new(planet, reach_m, false);
                let middle = level.sample_from_map(MapPoint::from_degrees(50.0, 20.0));
                let key = TileKey::new(level, middle.x as i64 / 256, middle.y as i64 / 256);
                let tile = key.expect("inside").grid();
                let read: i64 = node
                    .artefacts(&tile)
                    .iter()
                    .flat_map(|artefact| artefact.reads())
                    .map(|(_, grid)| grid.rect.area())
                    .sum();
                assert!(read < 900_000, "{radius_m} {reach} {level:?}: {read}");
                let made = scene.at(
                    scene.blended,
                    &tile.with_rect(SampleRect::at(tile.rect.min.x, tile.rect.min.y, 9, 7)),
                );
                assert!(made.samples().iter().all(|v| (0.0..=1.0).contains(v)));
            }
        }
    }
}
