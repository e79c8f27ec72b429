//! How evenly a mesh samples the screen.
//!
//! \[Liv07\] 6.1 measures the Hausdorff distance between a uniform grid on the viewport, from which its
//! vertices are shot, and the mesh's vertices as the viewport shows them. A clipmap's mesh has no such
//! grid: here one set is the middles of all pixels that show ground, the other the vertices within the
//! picture. So zero is out of reach for a mesh with fewer vertices than pixels, and vertices are
//! measured that a ridge hides.

use glam::{DMat3, DVec2, DVec3};
use relievo_engine::planet::clipmap::view::{FocusFrame, View};
use relievo_gpu::Still;

use crate::SuiteError;

/// Side of the squares of pixels by which places are looked up.
const CELL_PX: f64 = 4.0;

/// Both directed distances between the ground's pixels and the mesh's vertices on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Distortion {
    /// How far the pixel that is farthest from any vertex is from it, pixels.
    pub(crate) to_vertices_px: f64,
    /// How far the vertex that is farthest from any pixel that shows ground is from it, pixels.
    pub(crate) to_pixels_px: f64,
}

impl Distortion {
    /// Of a picture.
    pub(crate) fn of(still: &Still) -> Result<Self, SuiteError> {
        let lost = |error: relievo_gpu::ReadError| SuiteError::System(error.to_string());
        let shown = still.renderer.read_distances().map_err(lost)?;
        let vertices = on_screen(still, &still.renderer.read_displaced().map_err(lost)?);
        let [width, height] = still.frame.viewport_px.map(|side| side as usize);
        let middle = |i: usize| DVec2::new((i % width) as f64, (i / width) as f64) + 0.5;
        let ground = shown.iter().enumerate().filter(|(_, d)| d.is_finite());
        let pixels: Vec<DVec2> = ground.map(|(i, _)| middle(i)).collect();
        let size = DVec2::new(width as f64, height as f64);
        Ok(Self::between(&pixels, &vertices, size))
    }

    fn between(pixels: &[DVec2], vertices: &[DVec2], size: DVec2) -> Self {
        Self {
            to_vertices_px: farthest_px(pixels, &Places::new(vertices, size)),
            to_pixels_px: farthest_px(vertices, &Places::new(pixels, size)),
        }
    }

    /// The greater of both of two pictures.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            to_vertices_px: self.to_vertices_px.max(other.to_vertices_px),
            to_pixels_px: self.to_pixels_px.max(other.to_pixels_px),
        }
    }

    /// The Hausdorff distance, pixels.
    pub(crate) fn hausdorff_px(self) -> f64 {
        self.to_vertices_px.max(self.to_pixels_px)
    }
}

/// Vertices within the picture, in pixels from its top left corner.
fn on_screen(still: &Still, vertices: &[[f32; 4]]) -> Vec<DVec2> {
    let frame = &still.frame;
    let size = DVec2::from(frame.viewport_px.map(f64::from));
    let view = View::new(&frame.camera, &frame.planet, frame.viewport_px);
    let at = FocusFrame::at(frame.plan.focus);
    let world_from_focus = DMat3::from_cols(at.south, at.east, at.up);
    // Parts of the mesh that were not drawn are zero.
    let drawn = vertices.iter().filter(|v| v[..3] != [0.0; 3]);
    let places = drawn.filter_map(|[x, y, z, _]| {
        let from_eye = world_from_focus * DVec3::new((*x).into(), (*y).into(), (*z).into());
        let depth = from_eye.dot(view.forward);
        let place = DVec2::new(from_eye.dot(view.right), -from_eye.dot(view.up)) / depth;
        let px = 0.5 * (place / view.tan_half + 1.0) * size;
        let inside = px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all();
        (depth > 0.0 && inside).then_some(px)
    });
    places.collect()
}

/// Places of a picture by squares of pixels.
struct Places {
    squares: Vec<Vec<DVec2>>,
    columns: usize,
    rows: usize,
}

impl Places {
    fn new(places: &[DVec2], size: DVec2) -> Self {
        let count = (size / CELL_PX).ceil().as_usizevec2();
        let mut squares = vec![Vec::new(); count.x * count.y];
        for place in places {
            let at = (*place / CELL_PX).as_usizevec2();
            squares[at.y * count.x + at.x].push(*place);
        }
        Self {
            squares,
            columns: count.x,
            rows: count.y,
        }
    }

    /// Distance to the nearest one; the picture's diagonal where there is none.
    fn nearest_px(&self, from: DVec2) -> f64 {
        let at = (from / CELL_PX).as_i64vec2();
        let most = self.columns.max(self.rows) as i64;
        let mut nearest = CELL_PX * libm::hypot(self.columns as f64, self.rows as f64);
        for reach in 0..=most {
            // Whatever is in squares farther out is at least so far away.
            if nearest <= (reach - 1) as f64 * CELL_PX {
                break;
            }
            for y in (at.y - reach).max(0)..=(at.y + reach).min(self.rows as i64 - 1) {
                let edge = (y - at.y).abs() == reach;
                let step = if edge || reach == 0 { 1 } else { 2 * reach };
                let mut x = at.x - reach;
                while x <= at.x + reach {
                    if (0..self.columns as i64).contains(&x) {
                        let square = &self.squares[y as usize * self.columns + x as usize];
                        let here = square.iter().map(|place| place.distance(from));
                        nearest = here.fold(nearest, f64::min);
                    }
                    x += step;
                }
            }
        }
        nearest
    }
}

/// The directed Hausdorff distance: that of the place that is farthest from all of `to`.
fn farthest_px(from: &[DVec2], to: &Places) -> f64 {
    from.iter().map(|p| to.nearest_px(*p)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DVec2 = DVec2::new(36.0, 28.0);

    /// Places of a picture that follow no pattern.
    fn scattered(count: u32) -> Vec<DVec2> {
        let at = |i: u32, prime: u32, side: u32| f64::from(i * prime % (10 * side)) / 10.0;
        (0..count)
            .map(|i| DVec2::new(at(i, 7919, 36), at(i, 104_729, 28)))
            .collect()
    }

    #[test]
    fn the_nearest_place_is_the_nearest_of_all() {
        let places = scattered(12);
        let lookup = Places::new(&places, SIZE);
        for i in 0..500_u32 {
            let pixel = DVec2::new(f64::from(i % 36) + 0.5, f64::from(i / 36 % 28) + 0.5);
            let truth = places
                .iter()
                .map(|v| v.distance(pixel))
                .fold(f64::INFINITY, f64::min);
            assert_eq!(lookup.nearest_px(pixel), truth, "{pixel}");
        }
    }

    #[test]
    fn the_distance_looks_from_both_sides() {
        let pixels = scattered(40);
        let same = Distortion::between(&pixels, &pixels, SIZE);
        assert_eq!(same, Distortion::default());
        // One vertex more, far from everything, is nobody's nearest; one fewer leaves a hole.
        let (left, right) = (vec![DVec2::new(2.0, 3.0)], DVec2::new(30.0, 3.0));
        let both = vec![left[0], right];
        let lone = Distortion::between(&left, &both, SIZE);
        assert_eq!((lone.to_vertices_px, lone.to_pixels_px), (0.0, 28.0));
        let hole = Distortion::between(&both, &left, SIZE);
        assert_eq!((hole.to_vertices_px, hole.to_pixels_px), (28.0, 0.0));
        assert_eq!(lone.hausdorff_px(), hole.hausdorff_px());
    }
}
