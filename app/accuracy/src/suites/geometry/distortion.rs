//! How evenly a mesh samples the screen.

use glam::{DMat3, DVec2, DVec3};
use relievo_engine::planet::clipmap::view::{FocusFrame, View};
use relievo_gpu::Still;

use crate::SuiteError;

/// Side of the squares of pixels by which vertices are looked up.
const CELL_PX: f64 = 4.0;

/// One in so many pixels, across and down, is looked at.
const EVERY: usize = 4;

/// How far the ground's pixel that is farthest from any vertex of the mesh is from it, pixels: one half
/// of the Hausdorff distance between the picture's pixels and the mesh on the screen.
pub(crate) fn farthest_px(still: &Still) -> Result<f64, SuiteError> {
    let lost = |error: relievo_gpu::ReadError| SuiteError::System(error.to_string());
    let shown = still.renderer.read_distances().map_err(lost)?;
    let vertices = still.renderer.read_displaced().map_err(lost)?;
    let size = DVec2::from(still.frame.viewport_px.map(f64::from));
    let view = View::new(
        &still.frame.camera,
        &still.frame.planet,
        still.frame.viewport_px,
    );
    let at = FocusFrame::at(still.frame.plan.focus);
    let world_from_focus = DMat3::from_cols(at.south, at.east, at.up);
    let cells = (size / CELL_PX).ceil().as_usizevec2();
    let mut grid: Vec<Vec<DVec2>> = vec![Vec::new(); cells.x * cells.y];
    // Parts of the mesh that were not drawn are zero.
    for [x, y, z, _] in vertices.into_iter().filter(|v| v[..3] != [0.0; 3]) {
        let from_eye = world_from_focus * DVec3::new(x.into(), y.into(), z.into());
        let depth = from_eye.dot(view.forward);
        if depth <= 0.0 {
            continue;
        }
        let place = DVec2::new(from_eye.dot(view.right), -from_eye.dot(view.up)) / depth;
        let px = 0.5 * (place / view.tan_half + 1.0) * size;
        if px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all() {
            let cell = (px / CELL_PX).as_usizevec2();
            grid[cell.y * cells.x + cell.x].push(px);
        }
    }
    let width = still.frame.viewport_px[0] as usize;
    let mut farthest = 0.0_f64;
    for (i, distance_m) in shown.iter().enumerate() {
        let (x, y) = (i % width, i / width);
        if x % EVERY == 0 && y % EVERY == 0 && distance_m.is_finite() {
            let pixel = DVec2::new(x as f64, y as f64) + 0.5;
            farthest = farthest.max(nearest_px(&grid, [cells.x, cells.y], pixel));
        }
    }
    Ok(farthest)
}

/// Distance from a pixel to the nearest vertex; the picture's diagonal where there is none.
fn nearest_px(grid: &[Vec<DVec2>], [columns, rows]: [usize; 2], pixel: DVec2) -> f64 {
    let at = (pixel / CELL_PX).as_i64vec2();
    let most = columns.max(rows) as i64;
    let mut nearest = CELL_PX * libm::hypot(columns as f64, rows as f64);
    for reach in 0..=most {
        // Whatever is in squares farther out is at least so far away.
        if nearest <= (reach - 1) as f64 * CELL_PX {
            break;
        }
        for y in (at.y - reach).max(0)..=(at.y + reach).min(rows as i64 - 1) {
            let edge = (y - at.y).abs() == reach;
            let step = if edge || reach == 0 { 1 } else { 2 * reach };
            let mut x = at.x - reach;
            while x <= at.x + reach {
                if (0..columns as i64).contains(&x) {
                    let cell = &grid[y as usize * columns + x as usize];
                    let here = cell.iter().map(|vertex| vertex.distance(pixel));
                    nearest = here.fold(nearest, f64::min);
                }
                x += step;
            }
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_vertex_is_the_nearest_of_all() {
        let (columns, rows) = (9, 7);
        let vertices: Vec<DVec2> = (0..12_u32)
            .map(|i| {
                DVec2::new(
                    f64::from(i * 7919 % 360) / 10.0,
                    f64::from(i * 104_729 % 280) / 10.0,
                )
            })
            .collect();
        let mut grid = vec![Vec::new(); columns * rows];
        for vertex in &vertices {
            let cell = (*vertex / CELL_PX).as_usizevec2();
            grid[cell.y * columns + cell.x].push(*vertex);
        }
        for i in 0..500_u32 {
            let pixel = DVec2::new(f64::from(i % 36) + 0.5, f64::from(i / 36 % 28) + 0.5);
            let truth = vertices
                .iter()
                .map(|v| v.distance(pixel))
                .fold(f64::INFINITY, f64::min);
            assert_eq!(nearest_px(&grid, [columns, rows], pixel), truth, "{pixel}");
        }
    }
}
