//! A second method: exact intersections with the triangles of all cells, without pyramids, marching or
//! bisection.

use glam::{DVec3, I64Vec2};
use relievo_planet::LevelKey;

use super::*;

/// Distance at which a ray meets a triangle; `None` beside it and behind the eye.
///
/// Source: \[MT97\].
fn on_triangle(eye: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac, from_a) = (b - a, c - a, eye - a);
    let p = direction.cross(ac);
    let q = from_a.cross(ab);
    let scale = 1.0 / ab.dot(p);
    let (u, v) = (from_a.dot(p) * scale, direction.dot(q) * scale);
    let t = ac.dot(q) * scale;
    let slack = 1e-9;
    let inside = u >= -slack && v >= -slack && u + v <= 1.0 + slack;
    (inside && t > 0.0).then_some(t)
}

/// Triangles of a level's cells within some cells of a place, as the samples place them.
fn triangles(field: &Formula, level: LevelKey, around: MapPoint, cells: i64) -> Vec<[DVec3; 3]> {
    let middle = level.sample_from_map(around).floor().as_i64vec2();
    let vertex = |x: i64, y: i64| {
        let up = level
            .lattice()
            .map_point(middle + I64Vec2::new(x, y))
            .to_unit();
        // Samples are stored in single precision.
        up * (RADIUS_M + f64::from(field.height_m(up) as f32))
    };
    let mut triangles = Vec::new();
    for y in -cells..cells {
        for x in -cells..cells {
            let [nw, ne, sw, se] = [
                vertex(x, y),
                vertex(x + 1, y),
                vertex(x, y + 1),
                vertex(x + 1, y + 1),
            ];
            triangles.push([nw, sw, se]);
            triangles.push([nw, se, ne]);
        }
    }
    triangles
}

#[test]
fn marching_and_exact_intersections_with_triangles_agree_ever_better_with_finer_cells() {
    let place = MapPoint::from_degrees(7.3, 46.1);
    let stage = stage(camera((7.3, 46.1), 2600.0, 40.0, -60.0));
    let eye = stage.camera.eye(&stage.planet);
    let differ = |finest: u8, cells: i64| {
        let field = Formula::hills(finest - 2);
        // So fine a pixel that every distance asks for the finest level.
        let settings = ReferenceSettings {
            samples_per_pixel: 128.0,
            ..settings([8, 8])
        };
        let columns = Levels::new(RADIUS_M, finest).spot(finest, place).key.level;
        let triangles = triangles(&field, columns, place, cells);
        let found = hits(&field, &stage, &settings);
        let mut worst = 0.0_f64;
        for (direction, t) in &found {
            let exact = triangles
                .iter()
                .filter_map(|tri| on_triangle(eye, *direction, *tri))
                .fold(f64::INFINITY, f64::min);
            assert!(exact.is_finite(), "the mesh reaches beyond the picture");
            worst = worst.max((exact - t).abs());
        }
        worst
    };
    // Cells of 76 m and 38 m.
    let (coarse, fine) = (differ(10, 60), differ(11, 120));
    assert!(coarse < 8.0 && fine < 2.5, "{coarse} {fine}");
    assert!(fine < 0.45 * coarse, "{coarse} {fine}");
}
