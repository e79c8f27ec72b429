//! Profiles against closed forms.

mod common;

use std::sync::atomic::Ordering;

use common::{Impatient, on_map};
use relievo_analysis::{AnalysisError, ProfileSettings, Unwatched, profile};
use relievo_planet::{MapPoint, Planet};

const SPHERE: Planet = Planet::sphere(6_000_000.0);

fn at(lon_deg: f64, lat_deg: f64) -> MapPoint {
    MapPoint::from_degrees(lon_deg, lat_deg)
}

#[test]
fn a_roof_climbs_and_falls_by_its_height() {
    // 100 m high at latitude 1°, falling by 1 in 200 to both sides.
    let rise = 0.005;
    let ground = on_map(SPHERE, 11, |p| {
        100.0 - rise * (p.lat_rad() - 1.0_f64.to_radians()).abs() * 6e6
    });
    let line = [at(20.0, 0.9), at(20.0, 1.1)];
    let found = profile(&ground, &line, &ProfileSettings::default(), &Unwatched).unwrap();
    let length_m = 0.2_f64.to_radians() * 6e6;
    assert!((found.length_m - length_m).abs() < 1e-6);
    let climb_m = 0.5 * length_m * rise;
    assert!((found.climb_m - climb_m).abs() < 0.5 && (found.descent_m - climb_m).abs() < 0.5);
    assert!((found.steepest - rise).abs() < 1e-5);
    let surface_m = length_m * (1.0 + rise * rise).sqrt();
    assert!((found.surface_length_m - surface_m).abs() < 0.01);
    let spacing_m = found.points[1].distance_m;
    let cell_m = core::f64::consts::PI / f64::from(1 << 19) * 6e6;
    assert!(
        spacing_m <= cell_m * 1.001 && spacing_m > 0.5 * cell_m,
        "{spacing_m} {cell_m}"
    );
}

#[test]
fn every_vertex_is_a_point_and_distances_rise_to_the_length() {
    let ground = on_map(Planet::EARTH, 10, |p| 1000.0 * p.lon_rad);
    let line = [
        at(179.9, 10.0),
        at(-179.9, 10.1),
        at(-179.9, 10.1),
        at(-179.8, 9.9),
    ];
    let found = profile(&ground, &line, &ProfileSettings::default(), &Unwatched).unwrap();
    for vertex in line {
        let near = found.points.iter().map(|p| p.place.angle_to(vertex));
        assert!(near.fold(f64::INFINITY, f64::min) < 1e-12);
    }
    assert!(
        found
            .points
            .windows(2)
            .all(|pair| pair[0].distance_m < pair[1].distance_m)
    );
    let last = found.points.last().unwrap();
    assert!((last.distance_m - found.length_m).abs() < 1e-6);
}

#[test]
fn a_line_over_a_pole_has_the_heights_on_both_sides() {
    let ground = on_map(SPHERE, 9, |p| p.colat_rad * 6e6 * 0.01);
    let found = profile(
        &ground,
        &[at(30.0, 89.0), at(-150.0, 89.0)],
        &ProfileSettings::default(),
        &Unwatched,
    )
    .unwrap();
    for point in &found.points {
        let expected = point.place.colat_rad * 6e4;
        assert!(
            (point.height_m - expected).abs() < 25.0,
            "{point:?} {expected}"
        );
    }
    let (low, high) = found.range_m.unwrap();
    assert!(low < 30.0 && (high - 1.0_f64.to_radians() * 6e4).abs() < 1.0);
}

#[test]
fn the_spacing_of_points_does_not_change_heights() {
    let ground = on_map(SPHERE, 12, |p| 50.0 * libm::sin(p.lon_rad * 4000.0));
    let line = [at(1.0, 1.0), at(1.05, 1.02)];
    let with = |spacing_m| {
        let settings = ProfileSettings {
            spacing_m,
            ..ProfileSettings::default()
        };
        profile(&ground, &line, &settings, &Unwatched).unwrap()
    };
    let (few, many) = (with(Some(3000.0)), with(Some(10.0)));
    for point in &few.points {
        let twin = many
            .points
            .iter()
            .min_by(|a, b| {
                let far =
                    |p: &relievo_analysis::ProfilePoint| (p.distance_m - point.distance_m).abs();
                far(a).total_cmp(&far(b))
            })
            .unwrap();
        assert!(
            (twin.distance_m - point.distance_m).abs() > 1e-6 || twin.height_m == point.height_m
        );
    }
}

#[test]
fn missing_ground_breaks_the_profile_but_not_its_sums() {
    let ground = on_map(
        SPHERE,
        10,
        |p| if p.lon_rad > 0.02 { f64::NAN } else { 5.0 },
    );
    let line = [at(1.0, 0.0), at(1.3, 0.0)];
    let found = profile(&ground, &line, &ProfileSettings::default(), &Unwatched).unwrap();
    assert!(found.points.iter().any(|p| p.height_m.is_nan()));
    assert_eq!(
        (found.climb_m, found.steepest, found.range_m),
        (0.0, 0.0, Some((5.0, 5.0)))
    );
    assert!((found.surface_length_m - found.length_m).abs() < 1e-6);
}

#[test]
fn a_profile_beyond_its_limit_is_refused_before_anything_is_read() {
    let ground = on_map(SPHERE, 22, |_| 0.0);
    let line = [at(0.0, 0.0), at(90.0, 0.0)];
    let error = profile(&ground, &line, &ProfileSettings::default(), &Unwatched).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("at most 1048576 points") && !text.contains('\n'),
        "{text}"
    );
    assert_eq!(ground.asked.load(Ordering::Relaxed), 0);
    for line in [vec![], vec![at(0.0, 0.0)], vec![at(1.0, 1.0), at(1.0, 1.0)]] {
        let refused = profile(&ground, &line, &ProfileSettings::default(), &Unwatched);
        assert!(matches!(refused, Err(AnalysisError::Refused(_))));
    }
}

#[test]
fn a_profile_stops_when_it_is_asked_to() {
    let ground = on_map(SPHERE, 14, |_| 0.0);
    let line = [at(0.0, 0.0), at(3.0, 0.0)];
    let stopped = profile(
        &ground,
        &line,
        &ProfileSettings::default(),
        &Impatient::default(),
    );
    assert!(matches!(stopped, Err(AnalysisError::Cancelled)));
}
