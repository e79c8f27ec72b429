//! Bodies on the ground: where they are, what they hide and what hides them.

use std::sync::Arc;

use glam::DVec3;
use relievo_engine::planet::clipmap::HeightRange;
use relievo_engine::planet::clipmap::view::View;
use relievo_engine::planet::{MapPoint, Planet};
use relievo_engine::{Frame, MassMesh, MassVertex};

use crate::scene::{self, World, camera, draw, renderer, sun};

const SIZE: [u32; 2] = [160, 120];

/// A hill of 300 m, a kilometre north of (11° E, 47° N), on level ground.
const HILL: World = World {
    planet: Planet::EARTH,
    height: |direction| {
        let top = MapPoint::from_degrees(11.0, 47.01).to_unit();
        let distance_m = (direction - top).length() * Planet::EARTH.radius_m;
        (300.0 - 0.6 * distance_m).max(0.0)
    },
    colour: Some(|_| [0.2, 0.5, 0.2]),
    lit: false,
    range: HeightRange {
        min_m: 0.0,
        max_m: 300.0,
    },
};

/// A red box of 40 m sides and `height_m` on the datum.
fn red_box(lat_deg: f64, height_m: f64, id: u64) -> Arc<MassMesh> {
    let up = MapPoint::from_degrees(11.0, lat_deg).to_unit();
    let east = DVec3::new(
        -11.0_f64.to_radians().sin(),
        11.0_f64.to_radians().cos(),
        0.0,
    );
    let north = up.cross(east);
    let axes = [east * 20.0, north * 20.0, up * height_m];
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for (normal, a, b, from) in [
        (up, axes[0], axes[1], axes[2]),
        (east, axes[1], axes[2] * 0.5, axes[0] + axes[2] * 0.5),
        (-east, -axes[1], axes[2] * 0.5, -axes[0] + axes[2] * 0.5),
        (north, -axes[0], axes[2] * 0.5, axes[1] + axes[2] * 0.5),
        (-north, axes[0], axes[2] * 0.5, -axes[1] + axes[2] * 0.5),
    ] {
        let first = vertices.len() as u32;
        for corner in [-a - b, a - b, a + b, b - a] {
            vertices.push(MassVertex {
                offset_m: (from + corner).as_vec3().to_array(),
                normal: normal.as_vec3().to_array(),
                rgba: [220, 40, 40, 255],
            });
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }
    Arc::new(MassMesh {
        id,
        origin_in_world: up * Planet::EARTH.radius_m,
        radius_m: 40.0 + height_m,
        vertices,
        indices,
    })
}

fn frame(masses: Vec<Arc<MassMesh>>) -> Frame {
    let eye = camera(11.0, 46.99, 60.0, 0.0, 0.0);
    let mut frame = scene::frame(&HILL, eye, SIZE, sun(&eye, 315.0, 45.0));
    frame.masses = masses;
    frame
}

fn red_pixels(frame: &Frame) -> Vec<(u32, u32)> {
    let (picture, _) = draw(&mut renderer(), frame);
    let red = |x: u32, y: u32| {
        let [r, g, b, _] = picture.pixel(x, y);
        i32::from(r) > i32::from(g) + 50 && i32::from(r) > i32::from(b) + 50
    };
    (0..SIZE[1])
        .flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)))
        .filter(|(x, y)| red(*x, *y))
        .collect()
}

#[test]
fn a_body_stands_where_its_corners_are_projected() {
    let frame = frame(vec![red_box(47.0, 100.0, 1)]);
    let red = red_pixels(&frame);
    let view = View::new(&frame.camera, &frame.planet, SIZE);
    let mesh = &frame.masses[0];
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for v in &mesh.vertices {
        let from_eye = mesh.origin_in_world + glam::Vec3::from(v.offset_m).as_dvec3() - view.eye;
        let depth = from_eye.dot(view.forward);
        let x = from_eye.dot(view.right) / depth / view.tan_half.x;
        let y = -from_eye.dot(view.up) / depth / view.tan_half.y;
        for (k, v) in [x, y].into_iter().enumerate() {
            let pixel = (v + 1.0) * 0.5 * f64::from(SIZE[k]);
            low[k] = low[k].min(pixel);
            high[k] = high[k].max(pixel);
        }
    }
    let seen = |k: fn(&(u32, u32)) -> u32| {
        let all = red.iter().map(k);
        let last = red.iter().map(k).max().unwrap_or(0);
        (f64::from(all.min().unwrap_or(0)), f64::from(last) + 1.0)
    };
    let (x, y) = (seen(|p| p.0), seen(|p| p.1));
    assert!(
        (x.0 - low[0]).abs() <= 1.0 && (x.1 - high[0]).abs() <= 1.0,
        "{x:?} {low:?} {high:?}"
    );
    // The ground hides the foot, or shows it to the pixel.
    assert!(
        (y.0 - low[1]).abs() <= 1.0 && y.1 <= high[1] + 1.0,
        "{y:?} {low:?} {high:?}"
    );
}

#[test]
fn the_ground_hides_a_body_behind_a_hill_and_a_body_hides_the_ground() {
    let behind = frame(vec![red_box(47.02, 100.0, 2)]);
    assert_eq!(red_pixels(&behind), []);
    let taller = frame(vec![red_box(47.02, 2000.0, 3)]);
    assert!(
        !red_pixels(&taller).is_empty(),
        "what rises above the hill is seen"
    );
}

#[test]
fn a_frame_without_bodies_draws_none_and_gives_their_memory_back() {
    let mut renderer = renderer();
    let (_, with) = draw(&mut renderer, &frame(vec![red_box(47.0, 100.0, 4)]));
    assert_eq!(with.mass_triangles, 10);
    let (_, without) = draw(&mut renderer, &frame(Vec::new()));
    assert_eq!(without.mass_triangles, 0);
    assert!(without.gpu_memory < with.gpu_memory);
}
