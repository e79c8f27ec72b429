use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use proptest::prelude::*;
use relievo_planet::{Lattice, LevelKey, SampleRect};
use relievo_raster::Cancel;

use super::*;
use crate::nodes::DiscMask;

fn made(mask: &dyn ImageNode, grid: &Grid) -> Vec<f32> {
    let size = (grid.rect.width() as usize, grid.rect.height() as usize);
    let mut out = Block::new(Bands::Mask, size.0, size.1);
    let cancel = Cancel::default();
    let job = Job {
        grid,
        cancel: &cancel,
    };
    mask.render(&job, &[], &mut out).unwrap();
    out.plane(0).to_vec()
}

/// Samples of the map around a place, `half_m` to each side of the ellipsoid; all around where the pole
/// lies within.
fn around(planet: &Planet, place: MapPoint, half_m: f64, samples: i64) -> Grid {
    let place = place.normalised();
    let per_rad = planet.metres_per_radian(place.colat_rad);
    let south_rad = half_m / per_rad.y;
    let (north, south) = (place.colat_rad - south_rad, place.colat_rad + south_rad);
    let narrowest = libm::sin(north.max(0.0)).min(libm::sin(south.min(PI)));
    let east_rad = (half_m / (planet.equatorial_radius_m * narrowest.max(1e-9))).min(PI);
    let (north, south) = (north.max(0.0), south.min(PI));
    let size = DVec2::new(2.0 * east_rad, south - north);
    let lattice = Lattice {
        crs: GridCrs::Map,
        origin: DVec2::new(place.lon_rad - east_rad, north),
        step: size / samples as f64,
        columns_around: None,
    };
    Grid::new(Arc::new(lattice), SampleRect::at(0, 0, samples, samples))
}

/// Square metres of the ground under the samples of a mask.
fn area_m2(planet: &Planet, mask: &PolygonMask, grid: &Grid) -> f64 {
    let width = grid.rect.width() as usize;
    let weights = made(mask, grid);
    let rows = weights.chunks_exact(width).zip(grid.rect.min.y..);
    rows.map(|(row, y)| {
        let colat_rad = grid.lattice.centre(I64Vec2::new(0, y)).y;
        let sample_m = planet.metres_per_radian(colat_rad) * grid.lattice.step;
        row.iter().map(|w| f64::from(*w)).sum::<f64>() * sample_m.x * sample_m.y
    })
    .sum()
}

/// An L of 27 km².
const ELBOW_M: [[f64; 2]; 6] = [
    [-3000.0, -3000.0],
    [3000.0, -3000.0],
    [3000.0, 0.0],
    [0.0, 0.0],
    [0.0, 3000.0],
    [-3000.0, 3000.0],
];

fn at(mask: &PolygonMask, east_m: f64, north_m: f64) -> f32 {
    let place = mask.frame.to_map(DVec2::new(east_m, north_m));
    let lattice = Lattice {
        crs: GridCrs::Map,
        origin: DVec2::new(place.lon_rad, place.colat_rad) - 0.5e-9,
        step: DVec2::splat(1e-9),
        columns_around: None,
    };
    made(
        mask,
        &Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 1, 1)),
    )[0]
}

#[test]
fn a_polygon_of_many_corners_is_the_disc_but_for_the_band_between_them() {
    let planet = Planet::sphere(6.4e6);
    let centre = MapPoint::from_degrees(179.9, 60.0);
    for (radius_m, fade_m) in [(100.0, 40.0), (2e5, 5e4)] {
        let corner = |k: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(k) / 64.0);
            [radius_m * sin, radius_m * cos]
        };
        let corners: Vec<[f64; 2]> = (0..64).map(corner).collect();
        let polygon = PolygonMask::new(&planet, centre, &corners, fade_m);
        let disc = DiscMask::new(&planet, centre, radius_m, fade_m);
        let grid = around(&planet, centre, 1.5 * radius_m, 150);
        let band_m = radius_m * (1.0 - libm::cos(PI / 64.0)) * 1.05;
        let weights = made(&polygon, &grid).into_iter().zip(made(&disc, &grid));
        let mut counts = [0; 3];
        for (i, (ours, theirs)) in weights.enumerate() {
            let sample = I64Vec2::new(i as i64 % 150, i as i64 / 150);
            let place = grid.lattice.map_point(sample);
            let distance_m = place.angle_to(centre) * planet.radius_m;
            if distance_m < radius_m - band_m || distance_m > radius_m + fade_m {
                counts[usize::from(theirs == 0.0)] += 1;
                assert_eq!(ours, theirs, "{distance_m}");
            } else {
                counts[2] += 1;
                // A smooth step is at most half again as steep as a straight one.
                let most = 1.5 * band_m / fade_m;
                assert!(f64::from((ours - theirs).abs()) <= most, "{ours} {theirs}");
            }
        }
        assert!(counts.iter().all(|n| *n > 1000), "{counts:?}");
    }
}

#[test]
fn a_polygon_keeps_its_square_metres_wherever_it_is_moved() {
    let planet = Planet::EARTH;
    for (lon_deg, lat_deg) in [
        (0.0, 0.0),
        (10.0, 47.0),
        (180.0, -70.0),
        (-179.999, 80.0),
        (33.0, 89.99),
        (0.0, 90.0),
        (0.0, -90.0),
    ] {
        let centre = MapPoint::from_degrees(lon_deg, lat_deg);
        let mask = PolygonMask::new(&planet, centre, &ELBOW_M, 0.0);
        let grid = around(&planet, centre, 4500.0, 1200);
        let area_m2 = area_m2(&planet, &mask, &grid);
        assert!(
            (area_m2 / 27e6 - 1.0).abs() < 2e-3,
            "{lon_deg} {lat_deg}: {area_m2}"
        );
    }
}

#[test]
fn inside_is_by_the_even_odd_rule_and_the_fade_by_the_distance_to_the_outline() {
    for (lon_deg, lat_deg) in [(11.0, 47.0), (180.0, 10.0), (20.0, 90.0)] {
        let centre = MapPoint::from_degrees(lon_deg, lat_deg);
        let elbow = PolygonMask::new(&Planet::EARTH, centre, &ELBOW_M, 200.0);
        assert_eq!(at(&elbow, -1500.0, 1500.0), 1.0);
        assert_eq!(at(&elbow, 1500.0, -1500.0), 1.0);
        assert_eq!(at(&elbow, 1500.0, 1500.0), 0.0);
        assert!((at(&elbow, 1500.0, 100.0) - 0.5).abs() < 1e-3);
        assert!((at(&elbow, 3060.0, -3080.0) - 0.5).abs() < 1e-3, "a corner");
        assert_eq!(at(&elbow, 3150.0, -3150.0), 0.0);
        // A bow tie: both wings, nothing above and below the knot.
        let bow = [
            [-100.0, -50.0],
            [100.0, 50.0],
            [100.0, -50.0],
            [-100.0, 50.0],
        ];
        let bow = PolygonMask::new(&Planet::EARTH, centre, &bow, 0.0);
        let weights = [(-80.0, 0.0), (80.0, 0.0), (0.0, 40.0), (0.0, -40.0)];
        assert_eq!(weights.map(|(x, y)| at(&bow, x, y)), [1.0, 1.0, 0.0, 0.0]);
    }
}

#[test]
fn what_is_no_polygon_shows_nowhere() {
    let centre = MapPoint::from_degrees(11.0, 47.0);
    let grid = around(&Planet::EARTH, centre, 1e4, 20);
    let with =
        |corners: &[[f64; 2]], fade_m| PolygonMask::new(&Planet::EARTH, centre, corners, fade_m);
    let broken = |x: f64| [[x, 0.0], [1e3, 0.0], [0.0, 1e3]];
    for mask in [
        with(&[], 1e3),
        with(&[[0.0, 0.0], [1e3, 0.0]], 1e3),
        with(&broken(f64::NAN), 1e3),
        with(&broken(f64::INFINITY), 1e3),
        with(&broken(-1e300), 1e3),
    ] {
        assert!(made(&mask, &grid).iter().all(|w| *w == 0.0));
        assert_eq!(mask.known(&grid, &[]), Known::Uniform([0.0; 4]));
    }
    // A fade that is no length is none.
    let sharp = made(&with(&ELBOW_M, 0.0), &grid);
    for fade_m in [-5.0, f64::NAN, f64::INFINITY] {
        assert_eq!(made(&with(&ELBOW_M, fade_m), &grid), sharp);
    }
}

#[test]
fn tiles_beside_and_within_the_outline_are_known_and_those_on_it_are_not() {
    let centre = MapPoint::from_degrees(179.99, 47.0);
    let mask = PolygonMask::new(&Planet::EARTH, centre, &ELBOW_M, 100.0);
    let known = |east_m: f64, north_m: f64| {
        let place = mask.frame.to_map(DVec2::new(east_m, north_m));
        mask.known(&around(&Planet::EARTH, place, 200.0, 16), &[])
    };
    let of = |v| Known::Uniform([v, 0.0, 0.0, 0.0]);
    assert_eq!(known(-1500.0, -1500.0), of(1.0));
    assert_eq!(known(1500.0, 1500.0), of(0.0));
    assert_eq!(known(1500.0, 200.0), Known::Nothing);
    assert_eq!(known(-3000.0, 0.0), Known::Nothing);
    assert_eq!(known(40_000.0, 0.0), of(0.0));
    let antipode = MapPoint::from_degrees(-0.01, -47.0);
    let there = around(&Planet::EARTH, antipode, 1e5, 16);
    assert_eq!(mask.known(&there, &[]), of(0.0));
}

/// Outlines that are round, star-shaped, crossed, thin, or have corners twice.
fn corners() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let star = (
        1.0..7.0_f64,
        prop::collection::vec((0.0..TAU, 0.05..1.0_f64), 3..20),
    )
        .prop_map(|(size, turns)| {
            let corner = |(turn, part): (f64, f64)| {
                let (sin, cos) = libm::sincos(turn);
                let distance_m = part * libm::pow(10.0, size);
                [distance_m * cos, distance_m * sin]
            };
            turns.into_iter().map(corner).collect()
        });
    let sliver = (1.0..7.0_f64, 1e-6..1e-1_f64).prop_map(|(size, thin)| {
        let far_m = libm::pow(10.0, size);
        vec![
            [-far_m, 0.0],
            [far_m, thin],
            [far_m, thin],
            [0.0, -thin * far_m],
        ]
    });
    prop_oneof![4 => star, 1 => sliver]
}

fn planet() -> impl Strategy<Value = Planet> {
    let odd = Planet {
        flattening: 0.45,
        ..Planet::EARTH
    };
    prop_oneof![Just(Planet::EARTH), Just(Planet::MOON), Just(odd)]
}

fn centre() -> impl Strategy<Value = MapPoint> {
    let lat =
        prop_oneof![3 => -90.0..90.0_f64, 1 => Just(90.0), 1 => Just(-90.0), 1 => 89.9..90.0_f64];
    let lon = prop_oneof![3 => -180.0..180.0_f64, 1 => Just(180.0), 1 => 179.9..180.0_f64];
    (lon, lat).prop_map(|(lon, lat)| MapPoint::from_degrees(lon, lat))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1500) })]

    #[test]
    fn what_is_known_of_a_part_of_the_map_is_so(
        planet in planet(), centre in centre(), corners in corners(), fade in -1.0..6.0_f64,
        which in 0..5_usize, off in (-3.0..3.0_f64, -3.0..3.0_f64),
        n in 2..18_u8, w in 1..40_i64, h in 1..40_i64,
    ) {
        let fade_m = if fade < 0.0 { 0.0 } else { libm::pow(10.0, fade) };
        let mask = PolygonMask::new(&planet, centre, &corners, fade_m);
        let level = LevelKey::new(n, n);
        let lattice = Arc::new(level.lattice());
        let frame = Frame::new(planet, centre);
        // Where it is hard: beside a corner, in the middle of an edge, at a pole, opposite the centre.
        let corner = DVec2::from_array(corners[0]);
        let place = match which {
            0 => frame.to_map(corner),
            1 => frame.to_map(0.5 * (corner + DVec2::from_array(corners[1]))),
            2 => MapPoint::new(centre.lon_rad, 0.0),
            3 => MapPoint::from_direction(-centre.to_unit()),
            _ => centre,
        };
        let sample = level.sample_from_map(place) + DVec2::new(off.0, off.1) * 40.0;
        let sample = sample.floor().as_i64vec2();
        let rect = SampleRect::at(sample.x - w / 2, sample.y - h / 2, w, h);
        let grid = Grid::new(lattice, rect);
        if let Known::Uniform([known, ..]) = mask.known(&grid, &[]) {
            prop_assert!(made(&mask, &grid).iter().all(|v| *v == known), "{known}");
        }
    }

    #[test]
    fn leaving_out_edges_changes_no_weight(
        centre in centre(), corners in corners(), fade in -1.0..6.0_f64, off in (-3.0..3.0_f64, -3.0..3.0_f64),
        n in 4..16_u8,
    ) {
        let fade_m = if fade < 0.0 { 0.0 } else { libm::pow(10.0, fade) };
        let mask = PolygonMask::new(&Planet::EARTH, centre, &corners, fade_m);
        let level = LevelKey::new(n, n);
        let place = mask.frame.to_map(DVec2::from_array(corners[0]));
        let sample = level.sample_from_map(place) + DVec2::new(off.0, off.1) * 4.0;
        let sample = sample.floor().as_i64vec2();
        let rect = SampleRect::at(sample.x, sample.y, 24, 6);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let all = Near { crossed: mask.edges.clone(), reached: mask.edges.clone() };
        let weights = made(&mask, &grid);
        for (i, weight) in weights.iter().enumerate() {
            let centre = grid.lattice.centre(rect.min + I64Vec2::new(i as i64 % 24, i as i64 / 24));
            let point = mask.frame.at(&mask.frame.row(centre.y), &mask.frame.column(centre.x));
            prop_assert_eq!(*weight, mask.weight(point, &all));
        }
    }
}
