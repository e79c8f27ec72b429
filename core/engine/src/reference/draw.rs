//! Pictures and distances from rays, on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use parking_lot::Mutex;
use relievo_graph::RenderError;
use relievo_planet::clipmap::view::View;

use super::field::Field;
use super::light::display;
use super::march::Ray;
use super::patches::{Patches, Reader};
use super::shade::Light;
use crate::analysis::Task;

/// Side of the squares of pixels that a thread draws at a time.
const BLOCK_PX: u32 = 16;

/// Which rays make a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raster {
    pub(super) size_px: [u32; 2],
    /// Rays along a side of a pixel.
    pub(super) rays: u32,
    /// Samples of the ground along a ray's side of a pixel.
    pub(super) samples_per_pixel: f64,
    /// Of every how many squares of pixels one is drawn, in both directions.
    pub(super) stride: u32,
}

/// Side of the squares that [`Raster::stride`] counts, pixels: neighbours share the ground's samples.
const SQUARE_PX: u32 = 8;

impl Raster {
    /// Pixels that are drawn, across and down.
    pub(super) fn drawn(&self) -> [u32; 2] {
        self.size_px.map(|size| {
            let size = size.max(1);
            let period = SQUARE_PX * self.stride.max(1);
            size / period * SQUARE_PX + (size % period).min(SQUARE_PX)
        })
    }

    /// The drawn pixel (x, y), in pixels of the picture.
    pub(super) fn pixel(&self, x: u32, y: u32) -> [f64; 2] {
        let at = |i: u32| {
            let (square, within) = (i / SQUARE_PX, i % SQUARE_PX);
            f64::from(square * SQUARE_PX * self.stride.max(1) + within)
        };
        [at(x), at(y)]
    }
}

/// Runs of rows and columns of drawn pixels.
fn blocks(size: [u32; 2]) -> Vec<[u32; 4]> {
    let mut blocks = Vec::new();
    for y in (0..size[1]).step_by(BLOCK_PX as usize) {
        for x in (0..size[0]).step_by(BLOCK_PX as usize) {
            let (right, bottom) = ((x + BLOCK_PX).min(size[0]), (y + BLOCK_PX).min(size[1]));
            blocks.push([x, y, right, bottom]);
        }
    }
    blocks
}

/// A value for every drawn pixel, row by row; `pixel` makes it from the view's rays. The same for any
/// number of threads.
pub(super) fn each_pixel<F: Field, T: Copy + Default + Send>(
    raster: &Raster,
    threads: usize,
    patches: &Patches<'_, F>,
    task: &Task,
    pixel: &(impl Fn([f64; 2], &mut Reader<'_, F>) -> Result<T, RenderError> + Sync),
) -> Result<Vec<T>, RenderError> {
    let size = raster.drawn();
    let blocks = blocks(size);
    let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let made: Mutex<Vec<T>> = Mutex::new(vec![T::default(); size[0] as usize * size[1] as usize]);
    let failed: Mutex<Option<RenderError>> = Mutex::new(None);
    let work = || {
        let mut reader = Reader::new(patches);
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(block) = blocks.get(index) else {
                return;
            };
            match draw_block(*block, raster, &mut reader, task, pixel) {
                Ok(values) => {
                    let [x, y, right, bottom] = *block;
                    let width = (right - x) as usize;
                    let mut made = made.lock();
                    for (row, values) in (y..bottom).zip(values.chunks_exact(width)) {
                        let at = row as usize * size[0] as usize + x as usize;
                        made[at..at + width].copy_from_slice(values);
                    }
                }
                Err(error) => {
                    next.store(blocks.len(), Ordering::Relaxed);
                    failed.lock().get_or_insert(error);
                    return;
                }
            }
            let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
            (task.progress)(done as f64 / blocks.len() as f64);
        }
    };
    std::thread::scope(|scope| {
        for helper in 1..threads.clamp(1, 256).min(blocks.len()) {
            let name = format!("relievo-reference-{helper}");
            let thread = std::thread::Builder::new().name(name);
            // With fewer threads than asked for the work takes longer; nothing else changes.
            if let Err(error) = thread.spawn_scoped(scope, work) {
                tracing::warn!("draws on fewer threads: {error}");
                break;
            }
        }
        work();
    });
    match failed.into_inner() {
        Some(error) => Err(error),
        None => Ok(made.into_inner()),
    }
}

fn draw_block<F: Field, T>(
    [left, top, right, bottom]: [u32; 4],
    raster: &Raster,
    reader: &mut Reader<'_, F>,
    task: &Task,
    pixel: &impl Fn([f64; 2], &mut Reader<'_, F>) -> Result<T, RenderError>,
) -> Result<Vec<T>, RenderError> {
    let mut values = Vec::with_capacity((BLOCK_PX * BLOCK_PX) as usize);
    for y in top..bottom {
        if task.cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        for x in left..right {
            values.push(pixel(raster.pixel(x, y), reader)?);
        }
    }
    Ok(values)
}

/// The ray through a place of the picture in pixels from its top left corner.
pub(super) fn ray(view: &View, raster: &Raster, place_px: DVec2) -> Ray {
    let size = DVec2::from(raster.size_px.map(|s| f64::from(s.max(1))));
    let place = place_px / size * 2.0 - 1.0;
    let through = view.ray(DVec2::new(place.x, -place.y));
    let length = through.length();
    let pixel = 2.0 * view.tan_half.y / size.y;
    Ray {
        eye: view.eye,
        direction: through / length,
        // A pixel at the picture's side is seen from farther away and aslant.
        spread: pixel / (length * length) / raster.samples_per_pixel,
    }
}

/// Where the picture shows a place, in pixels from its top left corner; `from_eye` in metres along the
/// world's axes. Infinite or mirrored for what is not before the eye.
pub(super) fn place_px(view: &View, raster: &Raster, from_eye: DVec3) -> DVec2 {
    let depth_m = from_eye.dot(view.forward);
    let at = DVec2::new(from_eye.dot(view.right), -from_eye.dot(view.up)) / depth_m;
    let size = DVec2::from(raster.size_px.map(|s| f64::from(s.max(1))));
    0.5 * (at / view.tan_half + 1.0) * size
}

/// Display values of a pixel: the mean linear light of its rays, which is what a sensor counts.
pub(super) fn colour<F: Field>(
    view: &View,
    raster: &Raster,
    light: &Light,
    [x, y]: [f64; 2],
    reader: &mut Reader<'_, F>,
) -> Result<[f32; 3], RenderError> {
    let side = f64::from(raster.rays);
    let mut sum = DVec3::ZERO;
    for ray_y in 0..raster.rays {
        for ray_x in 0..raster.rays {
            let within = (DVec2::new(f64::from(ray_x), f64::from(ray_y)) + 0.5) / side;
            let ray = ray(view, raster, DVec2::new(x, y) + within);
            let hit = light.ground.hit(&ray, reader)?;
            sum += light.along(&ray, hit, reader)?;
        }
    }
    Ok(display(sum / (side * side)).as_vec3().to_array())
}
