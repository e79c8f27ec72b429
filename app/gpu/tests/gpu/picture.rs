//! What is drawn is what is there: no holes, right places, right colours.

use glam::{DVec2, DVec3};
use relievo_engine::planet::clipmap::view::View;
use relievo_engine::planet::{Camera, Planet};
use relievo_gpu::Look;

use crate::scene::{self, World, camera, draw, renderer, sun};

const SIZE: [u32; 2] = [320, 240];

const SMOOTH: World = World {
    planet: Planet::EARTH,
    height: scene::smooth_hills,
    colour: Some(scene::smooth_colour),
    lit: false,
    range: scene::SMOOTH_RANGE,
};

/// Views that meet every special case: seams, poles, limits of altitude.
fn views() -> Vec<(&'static str, Camera)> {
    vec![
        ("whole planet", camera(10.0, 35.0, 15e6, 0.0, -90.0)),
        ("limb", camera(-60.0, -20.0, 2e6, 70.0, -38.0)),
        ("aircraft", camera(11.0, 47.0, 11_000.0, 200.0, -20.0)),
        ("straight down", camera(11.0, 47.0, 9_000.0, 30.0, -90.0)),
        (
            "ground",
            camera(
                11.02,
                47.03,
                scene::smooth_hills(camera(11.02, 47.03, 0.0, 0.0, 0.0).map_point().to_unit())
                    + 2.0,
                130.0,
                -5.0,
            ),
        ),
        (
            "across the antimeridian",
            camera(179.95, 12.0, 40_000.0, 90.0, -25.0),
        ),
        (
            "across the north pole",
            camera(20.0, 89.7, 60_000.0, 0.0, -30.0),
        ),
        (
            "over the north pole itself",
            camera(0.0, 90.0, 400_000.0, 45.0, -90.0),
        ),
        (
            "across the south pole",
            camera(-120.0, -89.0, 300_000.0, 180.0, -45.0),
        ),
        (
            "pole on the horizon",
            camera(77.0, 80.0, 900_000.0, 2.0, -40.0),
        ),
    ]
}

/// World positions of a picture's pixels and whether their ray must hit ground.
fn places(view: &View, distances: &[f32], size: [u32; 2]) -> Vec<(DVec3, bool, Option<DVec3>)> {
    let inner_m = Planet::EARTH.radius_m + scene::SMOOTH_RANGE.min_m;
    (0..size[1])
        .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
        .map(|(x, y)| {
            let ndc = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(size[0]) * 2.0 - 1.0,
                1.0 - (f64::from(y) + 0.5) / f64::from(size[1]) * 2.0,
            );
            let ray = view.ray(ndc);
            let along = view.eye.dot(ray.normalize());
            let nearest_m = (view.eye.length_squared() - along * along).max(0.0).sqrt();
            // Facets of the mesh lie a little inside the sphere that they stand for.
            let must_hit = along < 0.0 && nearest_m < inner_m * (1.0 - 2e-4);
            let distance = distances[(y * size[0] + x) as usize];
            let hit = distance
                .is_finite()
                .then(|| view.eye + ray * f64::from(distance));
            (ray, must_hit, hit)
        })
        .collect()
}

#[test]
fn every_ray_that_meets_the_planet_shows_ground_of_the_right_height_and_colour() {
    for (name, camera) in views() {
        let frame = scene::frame(&SMOOTH, camera, SIZE, sun(&camera, 150.0, 50.0));
        let mut renderer = renderer();
        renderer.set_look(Look { haze: 0.0 });
        let (picture, stats) = draw(&mut renderer, &frame);
        assert!(
            stats.triangles <= 80_000,
            "{name}: {} triangles",
            stats.triangles
        );
        let view = View::new(&camera, &Planet::EARTH, SIZE);
        let places = places(&view, &renderer.read_distances().unwrap(), SIZE);
        let (mut holes, mut wrong, mut sum, mut worst) = (0, 0, 0.0_f64, 0.0_f64);
        let mut hits = 0;
        for (i, (_, must_hit, hit)) in places.into_iter().enumerate() {
            let Some(position) = hit else {
                holes += u32::from(must_hit);
                continue;
            };
            hits += 1;
            let p = position.normalize();
            let height = position.length() - Planet::EARTH.radius_m;
            // Triangles are chords: allow what the widest triangle in the picture may sag.
            let tolerance = 40.0 + 0.02 * (position - view.eye).length();
            wrong += u32::from((height - scene::smooth_hills(p)).abs() > tolerance);
            if -(position - view.eye).normalize().dot(p) < 0.2 {
                continue; // at grazing angles a pixel is the mean over a long stretch of ground
            }
            let expected = scene::smooth_colour(p);
            let pixel = &picture.rgba[4 * i..4 * i + 3];
            for (e, found) in expected.iter().zip(pixel) {
                let difference = (f64::from(*e) * 255.0 - f64::from(*found)).abs();
                sum += difference;
                worst = worst.max(difference);
            }
        }
        let mean = sum / (3.0 * f64::from(hits.max(1)));
        assert_eq!(holes, 0, "{name}: holes");
        assert_eq!(wrong, 0, "{name}: wrong heights of {hits}");
        assert!(hits > 5_000, "{name}: only {hits} pixels of ground");
        assert!(
            mean < 1.0 && worst < 16.0,
            "{name}: colours differ by {mean} in the mean, {worst} at most"
        );
    }
}

#[test]
fn two_renderers_draw_the_same_bytes() {
    let camera = camera(11.0, 47.0, 11_000.0, 200.0, -20.0);
    let world = World {
        lit: true,
        ..SMOOTH
    };
    let frame = scene::frame(&world, camera, SIZE, sun(&camera, 150.0, 50.0));
    let (first, stats) = draw(&mut renderer(), &frame);
    let (second, again) = draw(&mut renderer(), &frame);
    assert!(first == second);
    assert_eq!(stats.uploaded_bytes, again.uploaded_bytes);
}

#[test]
fn culled_sectors_never_change_a_pixel() {
    for (name, camera) in views() {
        let frame = scene::frame(&SMOOTH, camera, SIZE, sun(&camera, 150.0, 50.0));
        let (culled, stats) = draw(&mut renderer(), &frame);
        let mut all = frame.clone();
        let mut plan = (*frame.plan).clone();
        for sectors in &mut plan.sectors {
            sectors.visible = 0xffff;
        }
        plan.disc_sectors = 0xffff;
        all.plan = std::sync::Arc::new(plan);
        let (whole, _) = draw(&mut renderer(), &all);
        let different = culled
            .rgba
            .chunks(4)
            .zip(whole.rgba.chunks(4))
            .filter(|(a, b)| a != b)
            .count();
        assert_eq!(different, 0, "{name}");
        assert!(stats.triangles <= stats.triangles_without_culling);
    }
}

#[test]
fn an_unchanged_frame_is_not_drawn_again() {
    let camera = camera(11.0, 47.0, 11_000.0, 200.0, -20.0);
    let mut frame = scene::frame(&SMOOTH, camera, SIZE, sun(&camera, 150.0, 50.0));
    let mut renderer = renderer();
    let (before, stats) = draw(&mut renderer, &frame);
    assert!(!stats.reused && stats.displaced_vertices > 0);
    frame.uploads.clear();
    let (after, stats) = draw(&mut renderer, &frame);
    assert!(stats.reused && stats.displaced_vertices == 0);
    assert!(before == after);
    frame.sun.ambient += 0.1;
    let (_, stats) = draw(&mut renderer, &frame);
    assert!(!stats.reused);
}

#[test]
fn a_scene_runs_only_what_it_uses() {
    let camera = camera(11.0, 47.0, 11_000.0, 200.0, -20.0);
    let world = World {
        colour: None,
        ..SMOOTH
    };
    let frame = scene::frame(&world, camera, SIZE, sun(&camera, 150.0, 50.0));
    let mut renderer = renderer();
    let (_, stats) = draw(&mut renderer, &frame);
    assert!(!stats.pipeline.colour && !stats.pipeline.normals && stats.pipeline.haze);
    assert_eq!(renderer.pipeline_keys(), vec![stats.pipeline]);
}

#[test]
fn a_picked_pixel_is_the_ground_that_it_shows() {
    let camera = camera(11.0, 47.0, 9_000.0, 30.0, -90.0);
    let frame = scene::frame(&SMOOTH, camera, [321, 241], sun(&camera, 150.0, 50.0));
    let mut renderer = renderer();
    draw(&mut renderer, &frame);
    let below = renderer.pick(160, 120).unwrap().unwrap();
    assert!(below.point.angle_to(camera.map_point()) * Planet::EARTH.radius_m < 1.0);
    assert!((below.height_m - scene::smooth_hills(camera.map_point().to_unit())).abs() < 5.0);
    assert!(renderer.pick(4000, 0).unwrap().is_none());
}
