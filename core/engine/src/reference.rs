//! The reference renderer: what a picture should show, in f64 and without clipmaps.
//!
//! Rays of the camera meet the evaluated height field: same sphere, exaggeration, light and air as the
//! front-ends in `app/gpu` show, but heights, colours and normals come from the graph on grids of their
//! own whose spacing is at most a part of the pixel's footprint ([`ReferenceSettings::samples_per_pixel`]),
//! and every pixel is the mean over several rays. Pyramids of maxima are used to skip empty space only.
//!
//! Invariant: same project, same settings, same bytes, for any number of threads and any memory. Memory
//! stays about the stated bytes. Absent: levels of a front-end, filters of a texture unit, time limits,
//! bodies on the ground, labels.
//!
//! A style whose width is stated in pixels (contour lines, strokes in pixels) is as wide as so many
//! *samples*: the reference draws it as much narrower as its samples are finer.

mod air;
mod draw;
mod field;
mod light;
mod march;
mod patches;
mod shade;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use relievo_graph::RenderError;
use relievo_planet::clipmap::view::View;
use relievo_planet::{Camera, Planet};

use self::air::Air;
use self::draw::Raster;
use self::field::{Field, Levels};
use self::march::Ground;
use self::patches::{Kept, Patches};
use self::shade::Light;
use crate::Engine;
use crate::analysis::Task;
use crate::frame::Sun;
use crate::scene::Scene;

/// How a reference picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Width and height of the picture in pixels, 1 to 16384.
    pub size_px: [u32; 2],
    /// Rays along a side of a pixel, 1 to 16; a pixel is the mean of their squares' number.
    pub rays: u32,
    /// Samples of heights and colours along the shorter side of a pixel's footprint on the ground, 0.25
    /// to 64.
    pub samples_per_pixel: f64,
    /// How much of the air is shown, 0 to 8, as a front-end's look says.
    pub haze: f64,
    /// Threads, at least 1.
    pub threads: usize,
    /// Bytes of samples that are kept, about.
    pub memory: usize,
}

impl ReferenceSettings {
    /// Four samples along a pixel's footprint and four by four rays, with half of the air, as the
    /// clipmaps show by default.
    pub fn new(size_px: [u32; 2], threads: usize) -> Self {
        Self {
            size_px,
            rays: 4,
            samples_per_pixel: 4.0,
            haze: 0.5,
            threads,
            memory: 1 << 29,
        }
    }
}

/// Display values of a picture before they are rounded.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePicture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue, sRGB encoded, 0 to 1, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}

impl ReferencePicture {
    /// RGBA with 8 bits, row by row from the top.
    pub fn rgba(&self) -> Vec<u8> {
        let byte = relievo_raster::colour::to_u8;
        let pixel = |p: &[f32; 3]| [byte(p[0]), byte(p[1]), byte(p[2]), 255];
        self.pixels.iter().flat_map(pixel).collect()
    }
}

/// How far a picture is from the one with half the spacing and twice the rays, over a part of its
/// pixels: what is left of the reference's own error.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Confirmation {
    /// Pixels that were drawn again.
    pub pixels: usize,
    /// Mean difference of a display value, of 1.
    pub mean: f64,
    /// The difference that one in a hundred of the values exceeds.
    pub p99: f64,
    /// Largest difference.
    pub max: f64,
}

/// How far a place of the ground as a front-end shows it is from the truth's ground at the same place of
/// the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// How much higher it is shown, metres with exaggeration.
    pub height_m: f64,
    /// How far apart the two are on the screen, pixels: the screen-space error of \[Liv07\] 6.1.
    pub screen_px: f64,
}

impl Default for Offset {
    /// Of the sky: not a number.
    fn default() -> Self {
        Self {
            height_m: f64::NAN,
            screen_px: f64::NAN,
        }
    }
}

/// One picture to be drawn: a revision, a camera, light and air. On any thread. Clones share the samples
/// that they evaluate.
#[derive(Clone)]
pub struct Reference {
    scene: Arc<Scene>,
    stage: Stage,
    kept: Arc<Kept>,
}

/// Everything but the source of samples.
#[derive(Clone, Copy, Debug)]
struct Stage {
    planet: Planet,
    exaggeration: f64,
    camera: Camera,
    sun: Sun,
    /// Density of the air relative to Earth's.
    air: f64,
}

impl Engine {
    /// The reference of what a camera sees of the project as it is now.
    pub fn reference(&self, camera: Camera) -> Reference {
        let project = self.project();
        let stage = Stage {
            planet: project.planet.body.figure(),
            exaggeration: project.planet.vertical_exaggeration.max(0.0),
            camera,
            sun: crate::engine::sun(project, &camera),
            air: f64::from(crate::engine::air(project.planet.body)),
        };
        Reference {
            scene: self.questions().scene,
            stage,
            kept: Arc::default(),
        }
    }
}

impl Reference {
    /// This picture, with the samples that another one of the same revision evaluates; alone where the
    /// revisions differ.
    #[must_use]
    pub fn sharing(mut self, other: &Self) -> Self {
        if Arc::ptr_eq(&self.scene, &other.scene) && self.stage.planet == other.stage.planet {
            self.kept = Arc::clone(&other.kept);
        }
        self
    }

    /// Draws the picture.
    ///
    /// # Errors
    /// [`RenderError`] when a source cannot be read or work was cancelled.
    pub fn picture(
        &self,
        settings: &ReferenceSettings,
        task: &Task,
    ) -> Result<ReferencePicture, RenderError> {
        let raster = raster(settings);
        let pixels = picture(self.ground(), &self.stage, settings, &raster, task)?;
        let [width, height] = raster.drawn();
        Ok(ReferencePicture {
            width,
            height,
            pixels,
        })
    }

    /// Distances along the direction of view in metres of what the middles of pixels show, row by row
    /// from the top; infinite for the sky.
    ///
    /// # Errors
    /// As [`Self::picture`].
    pub fn distances(
        &self,
        settings: &ReferenceSettings,
        task: &Task,
    ) -> Result<Vec<f64>, RenderError> {
        distances(self.ground(), &self.stage, settings, task)
    }

    /// How far the ground that a front-end shows is from the truth's. `shown_m`: for each pixel, row by
    /// row from the top, the distance along the direction of view in metres, as
    /// [`Self::distances`] has it; NaN comes back for the sky.
    ///
    /// # Errors
    /// As [`Self::picture`].
    pub fn offsets(
        &self,
        settings: &ReferenceSettings,
        shown_m: &[f32],
        task: &Task,
    ) -> Result<Vec<Offset>, RenderError> {
        offsets(self.ground(), &self.stage, settings, shown_m, task)
    }

    /// Draws one of `stride`² squares of pixels again with half the spacing and twice the rays, and
    /// compares.
    ///
    /// # Errors
    /// As [`Self::picture`].
    pub fn confirm(
        &self,
        drawn: &ReferencePicture,
        settings: &ReferenceSettings,
        stride: u32,
        task: &Task,
    ) -> Result<Confirmation, RenderError> {
        let finer = ReferenceSettings {
            rays: 2 * settings.rays,
            samples_per_pixel: 2.0 * settings.samples_per_pixel,
            ..*settings
        };
        let raster = Raster {
            stride: stride.max(1),
            ..raster(&finer)
        };
        let again = picture(self.ground(), &self.stage, &finer, &raster, task)?;
        Ok(compare(drawn, &raster, &again))
    }

    fn ground(&self) -> (&Scene, &Kept) {
        (&self.scene, &self.kept)
    }
}

/// The rays of settings, which are brought into their ranges.
fn raster(settings: &ReferenceSettings) -> Raster {
    Raster {
        size_px: settings.size_px.map(|s| s.clamp(1, 16_384)),
        rays: settings.rays.clamp(1, 32),
        samples_per_pixel: if settings.samples_per_pixel.is_finite() {
            settings.samples_per_pixel.clamp(0.25, 128.0)
        } else {
            4.0
        },
        stride: 1,
    }
}

fn compare(drawn: &ReferencePicture, raster: &Raster, again: &[[f32; 3]]) -> Confirmation {
    let columns = raster.drawn()[0] as usize;
    let mut differences: Vec<f64> = Vec::with_capacity(3 * again.len());
    for (i, pixel) in again.iter().enumerate() {
        let [x, y] = raster.pixel((i % columns) as u32, (i / columns) as u32);
        let at = y as usize * drawn.width as usize + x as usize;
        let before = drawn.pixels.get(at).unwrap_or(pixel);
        let bands = before.iter().zip(pixel);
        differences.extend(bands.map(|(a, b)| f64::from((a - b).abs())));
    }
    differences.sort_by(f64::total_cmp);
    let count = differences.len().max(1);
    let at = |share: f64| {
        let i = (share * (count - 1) as f64).round() as usize;
        differences.get(i).copied().unwrap_or(0.0)
    };
    Confirmation {
        pixels: again.len(),
        mean: differences.iter().sum::<f64>() / count as f64,
        p99: at(0.99),
        max: at(1.0),
    }
}

fn picture<F: Field>(
    field: (&F, &Kept),
    stage: &Stage,
    settings: &ReferenceSettings,
    raster: &Raster,
    task: &Task,
) -> Result<Vec<[f32; 3]>, RenderError> {
    let view = View::new(&stage.camera, &stage.planet, raster.size_px);
    let haze = settings.haze * stage.air;
    let sun = stage.sun.direction_in_world;
    on_ground(
        field,
        stage,
        &view,
        settings,
        task,
        &|ground, patches, task| {
            let pixel = 2.0 * view.tan_half.y / f64::from(raster.size_px[1]);
            let light = Light {
                ground,
                air: Air::new(stage.planet.radius_m, haze, view.eye, sun),
                sun: stage.sun,
                footprint: pixel / f64::from(raster.rays),
            };
            draw::each_pixel(raster, settings.threads, patches, task, &|at, reader| {
                draw::colour(&view, raster, &light, at, reader)
            })
        },
    )
}

fn distances<F: Field>(
    field: (&F, &Kept),
    stage: &Stage,
    settings: &ReferenceSettings,
    task: &Task,
) -> Result<Vec<f64>, RenderError> {
    let raster = raster(settings);
    let view = View::new(&stage.camera, &stage.planet, raster.size_px);
    on_ground(
        field,
        stage,
        &view,
        settings,
        task,
        &|ground, patches, task| {
            draw::each_pixel(
                &raster,
                settings.threads,
                patches,
                task,
                &|[x, y], reader| {
                    let ray = draw::ray(&view, &raster, DVec2::new(x, y) + 0.5);
                    let depth = ray.direction.dot(view.forward);
                    let hit = ground.hit(&ray, reader)?;
                    Ok(hit.map_or(f64::INFINITY, |hit| hit.distance_m * depth))
                },
            )
        },
    )
}

fn offsets<F: Field>(
    field: (&F, &Kept),
    stage: &Stage,
    settings: &ReferenceSettings,
    shown_m: &[f32],
    task: &Task,
) -> Result<Vec<Offset>, RenderError> {
    let raster = raster(settings);
    let view = View::new(&stage.camera, &stage.planet, raster.size_px);
    let columns = raster.size_px[0] as usize;
    on_ground(
        field,
        stage,
        &view,
        settings,
        task,
        &|ground, patches, task| {
            draw::each_pixel(
                &raster,
                settings.threads,
                patches,
                task,
                &|[x, y], reader| {
                    let shown_m = shown_m.get(y as usize * columns + x as usize);
                    let Some(depth_m) = shown_m.filter(|d| d.is_finite()).map(|d| f64::from(*d))
                    else {
                        return Ok(Offset::default());
                    };
                    let ray = draw::ray(&view, &raster, DVec2::new(x, y) + 0.5);
                    let distance_m = depth_m / ray.direction.dot(view.forward);
                    let height_m = ground.clearance(&ray, distance_m, reader)?;
                    let from_eye = ray.direction * distance_m;
                    let up = (view.eye + from_eye).normalize_or(DVec3::Z);
                    let place = |from_eye: DVec3| draw::place_px(&view, &raster, from_eye);
                    let apart = place(from_eye) - place(from_eye - up * height_m);
                    Ok(Offset {
                        height_m,
                        screen_px: apart.length(),
                    })
                },
            )
        },
    )
}

/// What is done with the ground and its patches.
type OnGround<'w, F, T> = dyn Fn(Ground, &Patches<'_, F>, &Task) -> Result<T, RenderError> + 'w;

/// Work on the ground below the highest height. How high that is, a survey says, with as much again
/// as its heights differ; should a ray have met something higher still, the work is done again.
fn on_ground<F: Field, T>(
    (field, kept): (&F, &Kept),
    stage: &Stage,
    view: &View,
    settings: &ReferenceSettings,
    task: &Task,
    work: &OnGround<'_, F, T>,
) -> Result<T, RenderError> {
    let radius_m = stage.planet.radius_m;
    let levels = Levels::new(radius_m, field.finest());
    let patches = || Patches::new(field, kept, settings.memory, task.cancel);
    let (low_m, high_m) = survey(&patches(), stage, &levels)?;
    let mut top_m = high_m + (high_m - low_m);
    loop {
        let ground = Ground {
            radius_m,
            exaggeration: stage.exaggeration,
            levels,
            // A little air, so that level ground is entered from above.
            top_m: top_m * stage.exaggeration + 1e-9 * view.eye.length(),
            step: 0.25,
        };
        let patches = patches();
        let made = work(ground, &patches, task)?;
        if patches.highest_m() <= top_m {
            return Ok(made);
        }
        top_m = 2.0 * patches.highest_m();
    }
}

/// Lowest and highest height, metres without exaggeration: of the whole planet at the coarsest level and
/// of ever smaller surroundings of the eye at ever finer ones. The datum counts.
fn survey<F: Field>(
    patches: &Patches<'_, F>,
    stage: &Stage,
    levels: &Levels,
) -> Result<(f64, f64), RenderError> {
    let (mut low_m, mut high_m) = (0.0_f64, 0.0_f64);
    let mut include = |key| -> Result<(), RenderError> {
        let heights = patches.heights(key)?;
        low_m = low_m.min(heights.lowest());
        high_m = high_m.max(heights.highest());
        Ok(())
    };
    for key in Levels::coarsest() {
        include(key)?;
    }
    let below = stage.camera.map_point().normalised();
    for n in 1..=levels.cap() {
        for key in levels.spot(n, below).nearest() {
            include(key)?;
        }
    }
    Ok((low_m, high_m))
}
