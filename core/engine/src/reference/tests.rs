//! The reference against closed forms, against itself when refined, and against exact intersections
//! with triangles.

mod scenes;
mod triangles;

use glam::DVec3;
use relievo_planet::clipmap::view::View;
use relievo_planet::ellipsoid::ray_sphere;
use relievo_planet::{MapPoint, Planet};
use relievo_raster::Cancel;

use self::scenes::{Formula, RADIUS_M, camera, settings, stage};
use super::*;

/// Distances along their rays of a small picture, with the rays' directions.
fn hits(field: &Formula, stage: &Stage, settings: &ReferenceSettings) -> Vec<(DVec3, f64)> {
    let task_cancel = Cancel::default();
    let task = Task::quiet(&task_cancel);
    let depths =
        distances((field, &Kept::default()), stage, settings, &task).expect("formulas do not fail");
    let view = View::new(&stage.camera, &stage.planet, settings.size_px);
    let raster = raster(settings);
    let columns = settings.size_px[0] as usize;
    let along = |(i, depth): (usize, f64)| {
        let place = DVec2::new((i % columns) as f64, (i / columns) as f64) + 0.5;
        let ray = draw::ray(&view, &raster, place);
        (ray.direction, depth / ray.direction.dot(view.forward))
    };
    depths.into_iter().enumerate().map(along).collect()
}

/// Greatest relative difference of distances to a closed form, where both see the ground; the second
/// number counts rays of which only one does.
fn worst(found: &[(DVec3, f64)], truth: impl Fn(DVec3) -> Option<f64>) -> (f64, usize) {
    let (mut worst, mut odd) = (0.0_f64, 0);
    for (direction, distance_m) in found {
        match (truth(*direction), distance_m.is_finite()) {
            (Some(t), true) => worst = worst.max((distance_m - t).abs() / t),
            (None, false) => {}
            _ => odd += 1,
        }
    }
    (worst, odd)
}

#[test]
fn a_ball_is_met_where_the_sphere_is_from_any_height_and_over_the_poles() {
    for (place, altitude_m, pitch) in [
        ((10.0, 45.0), 2.0, -5.0),
        ((10.0, 45.0), 1e5, -20.0),
        ((-180.0, 0.0), 2e7, -90.0),
        ((30.0, 90.0), 1e4, -60.0),
        ((30.0, -89.9999), 3e6, -70.0),
    ] {
        let stage = stage(camera(place, altitude_m, 120.0, pitch));
        let found = hits(&Formula::level(250.0), &stage, &settings([24, 18]));
        let eye = stage.camera.eye(&stage.planet);
        let (worst, odd) = worst(&found, |d| {
            (altitude_m > 250.0)
                .then(|| ray_sphere(eye, d, RADIUS_M + 250.0))
                .flatten()
                .or_else(|| (altitude_m < 250.0).then_some(f64::NAN))
        });
        if altitude_m > 250.0 {
            assert!(
                worst < 1e-7 && odd == 0,
                "{place:?} {altitude_m}: {worst} {odd}"
            );
        } else {
            assert!(
                found.iter().all(|(_, t)| *t == 0.0),
                "an eye under the ground sees it at once"
            );
        }
    }
}

#[test]
fn a_tilted_plane_is_met_where_the_ray_meets_the_plane() {
    let middle = MapPoint::from_degrees(20.0, 40.0).to_unit();
    let (east, _) = middle.any_orthonormal_pair();
    let normal = (middle - 0.3 * east).normalize();
    let offset_m = normal.dot(middle * (RADIUS_M + 300.0));
    let field = Formula::new(15, move |up| {
        (offset_m / normal.dot(up) - RADIUS_M).clamp(-5e4, 5e4)
    });
    let stage = stage(camera((20.0, 40.0), 3e3, 200.0, -50.0));
    let found = hits(&field, &stage, &settings([32, 24]));
    let eye = stage.camera.eye(&stage.planet);
    let (worst, odd) = worst(&found, |d| {
        let t = (offset_m - normal.dot(eye)) / normal.dot(d);
        (t > 0.0).then_some(t)
    });
    assert!(worst < 1e-6 && odd == 0, "{worst} {odd}");
}

/// Distance at which a ray meets a cone around the vertical of a place, of a slope and a height.
fn on_cone(eye: DVec3, direction: DVec3, axis: DVec3, apex_m: f64, slope: f64) -> Option<f64> {
    let from_apex = eye - axis * (RADIUS_M + apex_m);
    let (z, dz) = (from_apex.dot(axis), direction.dot(axis));
    let (flat, dflat) = (from_apex - axis * z, direction - axis * dz);
    // z = −slope · |flat|, squared.
    let k = slope * slope;
    let (a, b, c) = (
        dz * dz - k * dflat.length_squared(),
        z * dz - k * flat.dot(dflat),
        z * z - k * flat.length_squared(),
    );
    let root = (b * b - a * c).sqrt();
    let mut both = [(-b - root) / a, (-b + root) / a];
    both.sort_by(f64::total_cmp);
    both.into_iter().find(|t| *t > 0.0 && z + dz * t < 0.0)
}

#[test]
fn a_cone_is_met_where_the_ray_meets_the_cone_and_its_ridge_hides_what_is_behind() {
    let axis = MapPoint::from_degrees(-60.0, -30.0).to_unit();
    let (apex_m, slope) = (2500.0, 0.8);
    let field = Formula::new(17, move |up| {
        // The angle from the axis by its sine, which keeps its digits.
        let (c, s) = (axis.dot(up), axis.cross(up).length());
        ((RADIUS_M + apex_m) / (c + slope * s) - RADIUS_M).clamp(-5e4, 5e4)
    });
    let stage = stage(camera((-60.0, -30.05), 2000.0, 0.0, -12.0));
    let settings = ReferenceSettings {
        samples_per_pixel: 12.0,
        ..settings([32, 24])
    };
    let found = hits(&field, &stage, &settings);
    let eye = stage.camera.eye(&stage.planet);
    let cone = |d: DVec3| on_cone(eye, d, axis, apex_m, slope);
    // Far down the cone is deeper than the formula goes.
    let near: Vec<_> = found
        .into_iter()
        .filter(|(d, _)| cone(*d).is_none_or(|t| t < 2e4))
        .collect();
    assert!(near.iter().filter(|(d, _)| cone(*d).is_some()).count() > 200);
    let exact: Vec<_> = near
        .iter()
        .filter(|(d, _)| cone(*d).is_some())
        .copied()
        .collect();
    let (worst, odd) = worst(&exact, cone);
    assert!(worst < 3e-4, "{worst}");
    // At most rays that graze the outline.
    assert!(odd <= 1, "{odd}");
}

#[test]
fn the_wall_of_a_step_is_met_within_the_sample_that_it_stands_on() {
    let wall = 12.0_f64.to_radians();
    let field = Formula::new(18, move |up| {
        if libm::atan2(up.y, up.x) < wall {
            0.0
        } else {
            400.0
        }
    });
    // West of the wall, looking east along the equator.
    let stage = stage(camera((11.995, 0.0), 100.0, 90.0, 0.0));
    let settings = settings([24, 18]);
    let eye = stage.camera.eye(&stage.planet);
    let mut walls = 0;
    for (direction, t) in hits(&field, &stage, &settings) {
        let at = eye + direction * t;
        let height_m = at.length() - RADIUS_M;
        if t.is_finite() && (1.0..399.0).contains(&height_m) {
            let off_m = (libm::atan2(at.y, at.x) - wall) * RADIUS_M;
            // Samples are a quarter of a pixel's footprint, or the data's own quarter.
            let pixel_m = t * 2.0 * libm::tan(0.5 * stage.camera.fov_y_rad) / 18.0;
            assert!(off_m.abs() < (0.5 * pixel_m).max(1.0), "{off_m} {pixel_m}");
            walls += 1;
        }
    }
    assert!(walls > 100, "{walls}");
}

#[test]
fn halving_the_spacing_brings_distances_nearer_to_the_closed_form() {
    let field = Formula::hills(20);
    let stage = stage(camera((7.3, 46.1), 6e3, 30.0, -55.0));
    let eye = stage.camera.eye(&stage.planet);
    // The formula's own surface, by fine steps that know nothing of samples.
    let truth = |d: DVec3| scenes::by_fine_steps(&field, eye, d, 6e4);
    let error = |samples_per_pixel: f64| {
        let settings = ReferenceSettings {
            samples_per_pixel,
            ..settings([10, 8])
        };
        let found = hits(&field, &stage, &settings);
        let errors: Vec<f64> = found
            .iter()
            .filter_map(|(d, t)| truth(*d).map(|truth| (t - truth).abs() / truth))
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let errors = [0.5, 1.0, 2.0, 4.0].map(error);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.5 * pair[0], "{errors:?}");
    }
    assert!(errors[3] < 4e-4, "{errors:?}");
}

#[test]
fn a_needle_that_no_survey_saw_is_not_missed() {
    let needle = MapPoint::from_degrees(0.25, 0.0).to_unit();
    let field = Formula::new(14, move |up| {
        let off_m = needle.cross(up).length() * RADIUS_M;
        (8000.0 - 40.0 * off_m).max(0.0)
    });
    let stage = stage(camera((0.0, 0.0), 3000.0, 90.0, 0.0));
    let settings = settings([33, 33]);
    let found = hits(&field, &stage, &settings);
    // Straight ahead, where there is sky otherwise.
    let (_, ahead) = found[16 * 33 + 16];
    assert!((2.6e4..2.9e4).contains(&ahead), "{ahead}");
    assert!(found[10 * 33 + 2].1.is_infinite());
}

#[test]
fn a_picture_is_the_same_for_any_number_of_threads_and_any_memory() {
    let field = Formula::hills(16);
    let stage = stage(camera((7.3, 46.1), 2e3, 30.0, -15.0));
    let cancel = Cancel::default();
    let draw_on = |kept: &Kept, threads, memory| {
        let settings = ReferenceSettings {
            threads,
            memory,
            rays: 2,
            samples_per_pixel: 1.0,
            ..settings([32, 18])
        };
        let raster = raster(&settings);
        picture(
            (&field, kept),
            &stage,
            &settings,
            &raster,
            &Task::quiet(&cancel),
        )
        .expect("formulas")
    };
    let draw = |threads, memory| draw_on(&Kept::default(), threads, memory);
    let one = draw(1, 1 << 28);
    assert!(
        one.iter().any(|p| p[0] != one[0][0]),
        "the picture shows something"
    );
    assert!(one == draw(4, 1 << 28) && one == draw(3, 4 << 20));
    // Nor does it matter what another picture kept.
    let kept = Kept::default();
    assert!(one == draw_on(&kept, 2, 1 << 28) && one == draw_on(&kept, 1, 1 << 28));
}

#[test]
fn a_cancelled_picture_is_an_error() {
    let cancel = Cancel::default();
    cancel.cancel();
    let stage = stage(camera((7.3, 46.1), 2e3, 30.0, -15.0));
    let settings = settings([8, 8]);
    let made = distances(
        (&Formula::hills(16), &Kept::default()),
        &stage,
        &settings,
        &Task::quiet(&cancel),
    );
    assert!(matches!(made, Err(RenderError::Cancelled)));
}

#[test]
fn an_exaggerated_scene_is_the_scene_of_exaggerated_heights() {
    let cancel = Cancel::default();
    let camera = camera((7.3, 46.1), 9e3, 30.0, -35.0);
    let settings = settings([16, 12]);
    let task = Task::quiet(&cancel);
    let twice = Stage {
        exaggeration: 2.0,
        ..stage(camera)
    };
    let hills = Formula::hills(16);
    let high = Formula::hills(16).times(2.0);
    let a = distances((&hills, &Kept::default()), &twice, &settings, &task).expect("formulas");
    let b =
        distances((&high, &Kept::default()), &stage(camera), &settings, &task).expect("formulas");
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= 1e-6 * a || a == b, "{a} {b}");
    }
}

#[test]
fn ground_that_is_shown_too_high_is_as_far_off_as_it_is_too_high() {
    let cancel = Cancel::default();
    let task = Task::quiet(&cancel);
    let stage = stage(camera((7.3, 46.1), 3e3, 30.0, -35.0));
    let settings = settings([16, 12]);
    let shown = |height_m: f64| -> Vec<f32> {
        let made = distances(
            (&Formula::level(height_m), &Kept::default()),
            &stage,
            &settings,
            &task,
        );
        made.expect("formulas")
            .into_iter()
            .map(|d| d as f32)
            .collect()
    };
    let off = |height_m: f64| {
        let made = offsets(
            (&Formula::level(100.0), &Kept::default()),
            &stage,
            &settings,
            &shown(height_m),
            &task,
        );
        made.expect("formulas")
    };
    for same in off(100.0) {
        assert!(same.height_m.is_nan() || same.screen_px < 1e-2, "{same:?}");
    }
    let higher = off(130.0);
    assert!(higher.iter().any(|o| o.height_m.is_finite()));
    for offset in higher.iter().filter(|o| o.height_m.is_finite()) {
        assert!((offset.height_m - 30.0).abs() < 0.1, "{offset:?}");
        // 30 m from at least 2870 m away, in a picture of 12 pixels for 50 degrees.
        let most = 30.0 / 2870.0 * 6.0 / 25.0_f64.to_radians().tan();
        assert!(
            offset.screen_px > 0.0 && offset.screen_px < 1.3 * most,
            "{offset:?}"
        );
    }
}
