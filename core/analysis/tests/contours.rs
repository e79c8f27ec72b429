//! Contours against shapes whose contours are known.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of a test panic where it would fail"
)]

mod common;

use common::{Impatient, on_map};
use proptest::prelude::*;
use relievo_analysis::{
    AnalysisError, ContourLine, ContourSettings, MapBox, Measure, Unwatched, contours,
};
use relievo_planet::{MapPoint, Planet};

const SPHERE: Planet = Planet::sphere(6_000_000.0);

fn area(bounds: [f64; 4]) -> MapBox {
    MapBox::from_degrees(bounds).unwrap()
}

/// Twice the signed area of a ring in longitude and latitude; counter-clockwise is positive.
fn winding(line: &ContourLine) -> f64 {
    let n = line.points.len();
    (0..n)
        .map(|i| (line.points[i], line.points[(i + 1) % n]))
        .map(|(a, b)| a.lon_rad * b.lat_rad() - b.lon_rad * a.lat_rad())
        .sum()
}

fn cone(centre: MapPoint) -> impl Fn(MapPoint) -> f64 + Sync {
    move |p| 1000.0 - 0.1 * p.angle_to(centre) * 6e6
}

#[test]
fn contours_of_a_cone_are_circles_with_the_top_to_the_left() {
    let centre = MapPoint::from_degrees(10.0, 5.0);
    let ground = on_map(SPHERE, 11, cone(centre));
    let found = contours(
        &ground,
        &area([9.8, 4.8, 10.2, 5.2]),
        &ContourSettings::every(200.0),
        &Unwatched,
    )
    .unwrap();
    let inner: Vec<_> = found
        .iter()
        .filter(|l| l.closed && l.height_m < 1000.0)
        .collect();
    assert_eq!(inner.len(), 10, "from −1000 m, just inside, to 800 m");
    for line in inner {
        let radius_rad = (1000.0 - line.height_m) / (0.1 * 6e6);
        for point in &line.points {
            assert!(
                (point.angle_to(centre) - radius_rad).abs() < 2e-6,
                "{}",
                line.height_m
            );
        }
        assert!(winding(line) > 0.0);
        let ring = Measure::new(&SPHERE).area(std::slice::from_ref(&line.points));
        let exact = 2.0 * core::f64::consts::PI * 36e12 * (1.0 - libm::cos(radius_rad));
        assert!((ring.area_m2 / exact - 1.0).abs() < 2e-2);
    }
}

#[test]
fn a_hill_on_the_antimeridian_has_whole_contours() {
    let here = MapPoint::from_degrees(10.0, 0.0);
    let there = MapPoint::from_degrees(180.0, 0.0);
    let lines = |centre, bounds| {
        let ground = on_map(SPHERE, 10, cone(centre));
        let settings = ContourSettings::every(250.0);
        contours(&ground, &area(bounds), &settings, &Unwatched).unwrap()
    };
    let (a, b) = (
        lines(here, [9.8, -0.2, 10.2, 0.2]),
        lines(there, [179.8, -0.2, -179.8, 0.2]),
    );
    let closed = |lines: &[ContourLine]| lines.iter().filter(|l| l.closed).count();
    assert!(closed(&a) >= 3 && closed(&a) == closed(&b));
    for line in &b {
        let jumps = line
            .points
            .windows(2)
            .map(|p| (p[0].lon_rad - p[1].lon_rad).abs());
        assert!(
            jumps.fold(0.0, f64::max) < 1e-3,
            "no jump at the antimeridian"
        );
    }
}

#[test]
fn around_a_pole_contours_close_across_the_antimeridian() {
    let ground = on_map(SPHERE, 3, |p| p.lat_rad().to_degrees());
    let found = contours(
        &ground,
        &area([-180.0, 60.0, 180.0, 90.0]),
        &ContourSettings::every(10.0),
        &Unwatched,
    )
    .unwrap();
    let heights: Vec<_> = found.iter().map(|l| (l.height_m, l.closed)).collect();
    assert_eq!(heights, [(60.0, true), (70.0, true), (80.0, true)]);
}

#[test]
fn the_areas_beside_each_other_have_contours_that_meet() {
    let centre = MapPoint::from_degrees(10.0, 0.0);
    let ground = on_map(SPHERE, 10, cone(centre));
    let settings = ContourSettings::every(100.0);
    let ask = |bounds| contours(&ground, &area(bounds), &settings, &Unwatched).unwrap();
    let whole = ask([9.9, -0.1, 10.1, 0.1]);
    let parts = [ask([9.9, -0.1, 10.0, 0.1]), ask([10.0, -0.1, 10.1, 0.1])].concat();
    let points = |lines: &[ContourLine]| {
        let mut all: Vec<(u64, u64)> = lines
            .iter()
            .flat_map(|l| &l.points)
            .map(|p| (p.lon_rad.to_bits(), p.colat_rad.to_bits()))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    assert_eq!(
        points(&whole),
        points(&parts),
        "the same vertices, bit for bit"
    );
}

#[test]
fn in_a_saddle_the_mean_decides() {
    // Samples alternate between 0 and a little more than 2 around the level of 1, or less.
    let settings = ContourSettings {
        base_m: 1.0,
        ..ContourSettings::every(1000.0)
    };
    let step = core::f64::consts::PI / f64::from(1 << 16);
    let checker = |high: f64| {
        let ground = on_map(SPHERE, 8, move |p| {
            let at = (p.lon_rad / step).floor() + (p.colat_rad / step).floor();
            if at.rem_euclid(2.0) == 0.0 { high } else { 0.0 }
        });
        contours(&ground, &area([0.0, -0.1, 0.1, 0.1]), &settings, &Unwatched).unwrap()
    };
    let closed = |lines: &[ContourLine], sign: f64| {
        let rings: Vec<_> = lines.iter().filter(|l| l.closed).collect();
        assert!(!rings.is_empty() && rings.iter().all(|l| l.points.len() == 4));
        assert!(rings.iter().all(|l| winding(l) * sign > 0.0));
    };
    // High ground apart: islands of it. High ground joined: ponds in it.
    closed(&checker(1.9), 1.0);
    closed(&checker(2.1), -1.0);
}

#[test]
fn missing_ground_ends_contours() {
    let ground = on_map(SPHERE, 10, |p| {
        if p.lon_rad > 0.1 {
            f64::NAN
        } else {
            p.lat_rad() * 1e5
        }
    });
    let bounds = [5.6, 0.01, 5.8, 0.2];
    let found = contours(
        &ground,
        &area(bounds),
        &ContourSettings::every(50.0),
        &Unwatched,
    )
    .unwrap();
    assert!(!found.is_empty());
    for line in found {
        assert!(!line.closed && line.points.iter().all(|p| p.lon_rad < 0.1));
    }
}

#[test]
fn an_interval_too_fine_or_an_area_too_large_is_refused() {
    let ground = on_map(SPHERE, 14, |p| p.lat_rad() * 1e6);
    let refuse = |bounds, settings: &ContourSettings| {
        let error = contours(&ground, &area(bounds), settings, &Unwatched).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("expected ") && text.contains("found"),
            "{text}"
        );
    };
    refuse([0.0, 0.0, 10.0, 10.0], &ContourSettings::every(10.0));
    refuse(
        [0.0, 0.0, 0.01, 0.01],
        &ContourSettings {
            max_segments: 1 << 12,
            ..ContourSettings::every(1e-3)
        },
    );
    refuse([0.0, 0.0, 0.01, 0.01], &ContourSettings::every(1e-9));
    refuse([0.0, 0.0, 0.01, 0.01], &ContourSettings::every(0.0));
    refuse([0.0, 0.0, 0.01, 0.01], &ContourSettings::every(f64::NAN));
}

#[test]
fn contours_stop_when_they_are_asked_to() {
    let ground = on_map(SPHERE, 12, |p| p.lat_rad() * 1e6);
    let all = area([0.0, 0.0, 1.0, 1.0]);
    let stopped = contours(
        &ground,
        &all,
        &ContourSettings::every(1e4),
        &Impatient::default(),
    );
    assert!(matches!(stopped, Err(AnalysisError::Cancelled)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn on_any_ground_lines_end_only_at_the_rim_and_lie_at_their_height(
        seed in prop::array::uniform8(-1.0..1.0_f64), interval in 3.0..30.0_f64,
    ) {
        let wave = move |p: MapPoint| {
            let (x, y) = (p.lon_rad * 2000.0, p.colat_rad * 2000.0);
            40.0 * (seed[0] * libm::sin(x + seed[1]) + seed[2] * libm::cos(2.0 * y + seed[3])
                + seed[4] * libm::sin(3.0 * x + y * seed[5]) + seed[6] * libm::cos(x - 3.0 * y + seed[7]))
        };
        let ground = on_map(SPHERE, 10, wave);
        let bounds = area([1.0, 1.0, 1.1, 1.1]);
        let found = contours(&ground, &bounds, &ContourSettings::every(interval), &Unwatched).unwrap();
        let step = core::f64::consts::PI / f64::from(1 << 18);
        for line in &found {
            if !line.closed {
                for end in [line.points[0], line.points[line.points.len() - 1]] {
                    let inside = (end.lon_rad - bounds.west_rad).min(bounds.east_rad - end.lon_rad)
                        .min(end.colat_rad - bounds.north_colat_rad).min(bounds.south_colat_rad - end.colat_rad);
                    prop_assert!(inside < step, "an end inside at {end:?}");
                }
            }
            for point in &line.points {
                prop_assert!((wave(*point) - line.height_m).abs() < 3.0, "{} {}", wave(*point), line.height_m);
            }
        }
    }
}
