//! Still water against closed forms.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of a test panic where it would fail"
)]

mod common;

use core::f64::consts::PI;

use common::{Impatient, on_map};
use relievo_analysis::{AnalysisError, Flood, FloodSettings, Ground, Unwatched, flood};
use relievo_planet::{MapPoint, Planet};

const RADIUS_M: f64 = 6_000_000.0;
const SPHERE: Planet = Planet::sphere(RADIUS_M);

fn to(ground: &dyn Ground, seed: MapPoint, level_m: f64) -> Flood {
    flood(ground, seed, &FloodSettings::to(level_m), &Unwatched).unwrap()
}

/// A funnel that rises by 0.01 from 100 m.
fn funnel(centre: MapPoint) -> impl Fn(MapPoint) -> f64 + Sync {
    move |p| 100.0 + 0.01 * p.angle_to(centre) * RADIUS_M
}

#[test]
fn a_funnel_fills_to_a_cone_of_second_order() {
    let centre = MapPoint::from_degrees(-60.0, 12.0);
    let mut errors = Vec::new();
    for n in [9, 10, 11] {
        let ground = on_map(SPHERE, n, funnel(centre));
        let found = to(&ground, centre, 200.0);
        // Radius 10 km: the sphere's curvature takes 2·10⁻⁷ of it.
        let (area, volume) = (PI * 1e8, PI * 1e8 * 100.0 / 3.0);
        assert!((found.area_m2 / area - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.shore_m / (2.0 * PI * 1e4) - 1.0).abs() < 0.01);
        assert!((found.deepest_m - 100.0).abs() < 3.0);
        assert_eq!(found.shore.len(), 1);
        errors.push((found.volume_m3 / volume - 1.0).abs());
    }
    assert!(
        errors[2] < 1e-4 && errors[0] / errors[2] > 8.0,
        "{errors:?}"
    );
}

#[test]
fn a_lake_across_the_antimeridian_is_one() {
    let there = MapPoint::from_degrees(180.0, 12.0);
    let here = MapPoint::from_degrees(0.0, 12.0);
    let [a, b] = [here, there].map(|centre| to(&on_map(SPHERE, 10, funnel(centre)), centre, 180.0));
    assert!((a.volume_m3 / b.volume_m3 - 1.0).abs() < 1e-9);
    assert_eq!(b.shore.len(), 1);
    assert!(b.shore[0].closed);
}

#[test]
fn water_behind_a_ridge_stays_where_it_is() {
    // Two bowls side by side, joined above 150 m.
    let (west, east) = (
        MapPoint::from_degrees(10.0, 0.0),
        MapPoint::from_degrees(10.1, 0.0),
    );
    let bowls = |p: MapPoint| funnel(west)(p).min(funnel(east)(p));
    let ground = on_map(SPHERE, 11, bowls);
    let ridge_m = 100.0 + 0.01 * 0.05_f64.to_radians() * RADIUS_M;
    let below = to(&ground, west, ridge_m - 5.0);
    let above = to(&ground, west, ridge_m + 5.0);
    let radius_m = (ridge_m - 5.0 - 100.0) / 0.01;
    assert!((below.area_m2 / (PI * radius_m * radius_m) - 1.0).abs() < 0.01);
    assert!(above.area_m2 > 1.9 * below.area_m2);
}

#[test]
fn an_island_is_dry_and_has_its_own_shore() {
    let centre = MapPoint::from_degrees(5.0, -20.0);
    let ring = move |p: MapPoint| 100.0 + 0.01 * (p.angle_to(centre) * RADIUS_M - 8000.0).abs();
    let ground = on_map(SPHERE, 10, ring);
    let seed = MapPoint::new(centre.lon_rad, centre.colat_rad + 8000.0 / RADIUS_M);
    let found = to(&ground, seed, 130.0);
    let expected = PI * (11_000.0 * 11_000.0 - 5_000.0 * 5_000.0);
    assert!((found.area_m2 / expected - 1.0).abs() < 0.01);
    assert_eq!(found.shore.len(), 2);
    assert!((found.shore_m / (2.0 * PI * 16_000.0) - 1.0).abs() < 0.02);
}

#[test]
fn a_lake_over_a_pole_is_filled() {
    let ground = on_map(SPHERE, 8, |p| 100.0 + 0.01 * p.colat_rad * RADIUS_M);
    let found = to(&ground, MapPoint::from_degrees(30.0, 89.9), 500.0);
    let angle = 40_000.0 / RADIUS_M;
    let expected = 2.0 * PI * RADIUS_M * RADIUS_M * (1.0 - libm::cos(angle));
    // All but the half sample around the pole.
    assert!(
        (found.area_m2 / expected - 1.0).abs() < 0.02,
        "{} {expected}",
        found.area_m2
    );
}

#[test]
fn dry_seeds_and_oceans_are_refused() {
    let centre = MapPoint::from_degrees(1.0, 1.0);
    let ground = on_map(SPHERE, 11, funnel(centre));
    let text = |level_m: f64, max_samples: u64| {
        let settings = FloodSettings {
            level_m,
            max_samples,
        };
        flood(&ground, centre, &settings, &Unwatched)
            .unwrap_err()
            .to_string()
    };
    assert!(text(90.0, 1 << 20).contains("below the water level of 90 m"));
    assert!(text(5000.0, 1 << 17).contains("at most 131072 samples"));
    assert!(text(f64::NAN, 1 << 17).starts_with("expected a finite level"));
    let stopped = flood(
        &ground,
        centre,
        &FloodSettings::to(400.0),
        &Impatient::default(),
    );
    assert!(matches!(stopped, Err(AnalysisError::Cancelled)));
}
