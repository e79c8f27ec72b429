//! Lines of sight against brute force and closed forms.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of a test panic where it would fail"
)]

mod common;

use common::{Impatient, in_frame};
use glam::DVec2;
use proptest::prelude::*;
use relievo_analysis::{
    AnalysisError, Ground, LocalFrame, Sight, Unwatched, Viewshed, ViewshedSettings, viewshed,
};
use relievo_planet::{MapPoint, Planet};

fn observer() -> MapPoint {
    MapPoint::from_degrees(179.999, 47.0)
}

fn settings(radius_m: f64, spacing_m: f64) -> ViewshedSettings {
    ViewshedSettings {
        spacing_m: Some(spacing_m),
        ..ViewshedSettings::within(radius_m)
    }
}

fn see(ground: &dyn Ground, settings: &ViewshedSettings) -> Viewshed {
    viewshed(ground, observer(), settings, &Unwatched).unwrap()
}

/// Every crossing of every line of sight, one by one, from the definition.
fn brute_force(height: impl Fn(DVec2) -> f64, settings: &ViewshedSettings) -> Vec<Sight> {
    let frame = LocalFrame::new(Planet::EARTH, observer());
    let spacing = settings.spacing_m.unwrap();
    let reach = (settings.radius_m / spacing).ceil() as i64;
    let lat = frame.centre.lat_rad();
    let radii = [
        Planet::EARTH.prime_vertical_radius_m(lat),
        Planet::EARTH.meridian_radius_m(lat),
    ];
    let lowered = |x: i64, y: i64| -> f64 {
        let (dx, dy) = (x as f64 * spacing, y as f64 * spacing);
        let drop = 0.5 * (1.0 - settings.refraction) * (dx * dx / radii[0] + dy * dy / radii[1]);
        f64::from((f64::from(height(DVec2::new(dx, dy)) as f32) - drop) as f32)
    };
    let eye = lowered(0, 0) + settings.observer_height_m;
    let mut sights = Vec::new();
    for y in (-reach..=reach).rev() {
        for x in -reach..=reach {
            let far = (x as f64).hypot(y as f64) * spacing;
            let target = lowered(x, y) + settings.target_height_m;
            if far > settings.radius_m || target.is_nan() {
                sights.push(Sight::Outside);
                continue;
            }
            let mut hidden = false;
            for k in 1..x.abs() {
                let share = k as f64 / x.abs() as f64;
                let beside = y as f64 * share;
                let (low, part) = (beside.floor() as i64, beside - beside.floor());
                let at = k * x.signum();
                let ground = lowered(at, low) * (1.0 - part)
                    + if part > 0.0 {
                        lowered(at, low + 1) * part
                    } else {
                        0.0
                    };
                hidden |= ground > eye + (target - eye) * share + 1e-6;
            }
            for k in 1..y.abs() {
                let share = k as f64 / y.abs() as f64;
                let beside = x as f64 * share;
                let (low, part) = (beside.floor() as i64, beside - beside.floor());
                let at = k * y.signum();
                let ground = lowered(low, at) * (1.0 - part)
                    + if part > 0.0 {
                        lowered(low + 1, at) * part
                    } else {
                        0.0
                    };
                hidden |= ground > eye + (target - eye) * share + 1e-6;
            }
            sights.push(if hidden {
                Sight::Hidden
            } else {
                Sight::Visible
            });
        }
    }
    sights
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn skipping_blocks_gives_what_brute_force_does(
        seed in prop::array::uniform4(-3.0..3.0_f64), rough in 0.0..60.0_f64,
        eye in 0.0..30.0_f64, target in 0.0..10.0_f64, spacing in 20.0..300.0_f64,
    ) {
        let height = move |p: DVec2| {
            let (x, y) = (p.x / spacing, p.y / spacing);
            rough * (libm::sin(x * 0.31 + seed[0]) * libm::cos(y * 0.23 + seed[1])
                + 0.5 * libm::sin(x * 1.7 + y * seed[2]) + 0.3 * libm::cos(y * 2.9 - x * seed[3]))
        };
        let settings = ViewshedSettings {
            observer_height_m: eye,
            target_height_m: target,
            ..settings(spacing * 41.3, spacing)
        };
        let found = see(&in_frame(height), &settings);
        let expected = brute_force(height, &settings);
        // Rounding may differ where ground grazes a line within 10⁻⁹ m of the slack.
        let wrong = found.sights.iter().zip(&expected).filter(|(a, b)| a != b).count();
        prop_assert_eq!(wrong, 0);
    }
}

#[test]
fn over_a_level_sea_one_sees_to_the_horizon() {
    let height_m = 30.0;
    let settings = ViewshedSettings {
        observer_height_m: height_m,
        ..settings(40_000.0, 200.0)
    };
    let found = see(&in_frame(|_| 0.0), &settings);
    // d² (1 − k) / 2R = h: the horizon's distance with refraction.
    let radius_m = found.frame.mean_radius_m();
    let horizon_m = libm::sqrt(2.0 * radius_m * height_m / (1.0 - 0.13));
    let seen_to = |x: f64, y: f64| {
        let direction = DVec2::new(x, y).normalize();
        (0..200)
            .map(|i| f64::from(i) * 200.0)
            .take_while(|d| found.at(found.frame.place(direction * *d)) == Sight::Visible)
            .last()
            .unwrap()
    };
    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (-2.0, 1.0)] {
        let seen_m = seen_to(x, y);
        // A sea of chords hides a sample earlier than a round one: up to √(2R·sag) and a cell.
        assert!((seen_m - horizon_m).abs() < 900.0, "{seen_m} {horizon_m}");
    }
    let share = found.visible_m2 / found.area_m2;
    assert!((share - (horizon_m / 40_000.0).powi(2)).abs() < 0.05);
}

#[test]
fn a_wall_casts_a_shadow_as_long_as_similar_triangles_say() {
    // A wall 20 m high 1000 m east; the eye 30 m high: hidden from the wall to 3000 m on flat ground.
    let wall = |p: DVec2| {
        if (p.x - 1000.0).abs() < 5.0 {
            20.0
        } else {
            0.0
        }
    };
    let settings = ViewshedSettings {
        observer_height_m: 30.0,
        refraction: 1.0,
        ..settings(4000.0, 10.0)
    };
    let found = see(&in_frame(wall), &settings);
    let at = |x: f64| found.at(found.frame.place(DVec2::new(x, 0.0)));
    assert_eq!(at(990.0), Sight::Visible);
    assert_eq!(at(1000.0), Sight::Visible, "the wall itself");
    assert_eq!(at(1020.0), Sight::Hidden);
    assert_eq!(at(2980.0), Sight::Hidden);
    assert_eq!(at(3020.0), Sight::Visible);
    assert_eq!(at(-3500.0), Sight::Visible);
    assert_eq!(at(4100.0), Sight::Outside);
}

#[test]
fn missing_ground_is_outside_and_hides_nothing() {
    let hole = |p: DVec2| {
        if (300.0..600.0).contains(&p.x) {
            f64::NAN
        } else {
            0.0
        }
    };
    let found = see(&in_frame(hole), &settings(900.0, 10.0));
    let at = |x: f64| found.at(found.frame.place(DVec2::new(x, 0.0)));
    assert_eq!((at(450.0), at(700.0)), (Sight::Outside, Sight::Visible));
}

#[test]
fn the_number_of_threads_does_not_show() {
    let hills = |p: DVec2| 40.0 * libm::sin(p.x / 90.0) * libm::cos(p.y / 70.0);
    let with = |threads| {
        let settings = ViewshedSettings {
            threads,
            ..settings(800.0, 10.0)
        };
        let found = see(&in_frame(hills), &settings);
        (found.sights, found.visible_m2.to_bits())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn senseless_and_endless_requests_are_refused() {
    let ground = in_frame(|p: DVec2| if p == DVec2::ZERO { f64::NAN } else { 0.0 });
    for wrong in [
        settings(f64::NAN, 1.0),
        settings(-1.0, 1.0),
        settings(1e6, 1.0),
        settings(1e9, 1e7),
        settings(100.0, 0.0),
        ViewshedSettings {
            refraction: 2.0,
            ..settings(100.0, 10.0)
        },
        // No ground below the observer.
        settings(100.0, 10.0),
    ] {
        let text = viewshed(&ground, observer(), &wrong, &Unwatched)
            .unwrap_err()
            .to_string();
        assert!(
            text.starts_with("expected ") && !text.contains('\n'),
            "{text}"
        );
    }
    let ground = in_frame(|_| 0.0);
    let stopped = viewshed(
        &ground,
        observer(),
        &settings(5e3, 5.0),
        &Impatient::default(),
    );
    assert!(matches!(stopped, Err(AnalysisError::Cancelled)));
}
