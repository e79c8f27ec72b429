//! The map resampler: the samples of any grid from a georeferenced file.
//!
//! - Samples that lie outside of the file's outline are holes (NaN, transparent). A file that runs
//!   around the globe wraps, and reflects over a pole that it reaches.
//! - Where the grid is coarser than the file, an overview is read and averaged with a kernel that
//!   is round **on the ground** (\[CH06\] 4.3): its half-value radius is half of the sample's longer
//!   side in metres, so in a plate carrée file it spans 1/sin θ times as many columns near a pole.
//!   Columns are shrunk by halves before the kernel so that it never has more than 4 × 4 taps, and
//!   next to a pole a coarser overview bounds what is read.
//! - Results depend on global sample indices only: a block equals the same part of the whole bit
//!   for bit, in any order and on any thread.

mod cells;
mod coverage;
mod places;
mod plane;
mod window;

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec2;
use relievo_planet::{Grid, MapPoint, Planet, SampleRect};

use crate::file::{Cancel, RasterFile, ReadError};
pub use crate::kernel::Kernel;
use crate::kernel::{LANES, Lane, Window};
use crate::vector::on_widest;
use crate::{Bands, Block, colour};
use cells::{Geometry, Patch};
use plane::SourcePlane;
use window::Scale;

/// Pixels that a common window may hold beyond those its patches need each.
const SHARED_WINDOW_SLACK: i64 = 1 << 16;
/// Pixels of a window shared by several patches.
const LARGEST_SHARED_WINDOW: i64 = 1 << 22;

/// Why a file cannot be laid on the map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WarpError {
    /// Neither the file nor its companions say where it lies.
    #[error("expected a georeferenced image, found none: {path:?}")]
    NoGeoreference {
        /// The file.
        path: PathBuf,
    },
    /// Its pixels have no area, or it has none.
    #[error("expected pixels with an area, found a degenerate georeference: {path:?}")]
    Degenerate {
        /// The file.
        path: PathBuf,
    },
    /// A coordinate system that cannot be used.
    #[error("cannot use the coordinate system {crs:?}: {reason}")]
    Crs {
        /// Its name.
        crs: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// How much of a grid a file's outline covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// No sample: all would be holes.
    Outside,
    /// Every sample lies inside of the outline (where the file may still have holes).
    Inside,
    /// Perhaps some.
    Partial,
}

/// What exactness is given up for speed. What is shown uses the default, which ids of contents rest on;
/// other values are for measurements (`relievo report --suite resample`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approximation {
    /// Largest error of places that are interpolated instead of projected, as a distance in pixels of the
    /// level that is read; 0 projects every sample of a curved grid.
    pub tolerance_px: f64,
    /// Widest kernel along a row in pixels of the level that is read, at least 1; wider ones (about a
    /// pole) read a coarser level, which makes rows coarser too within 0.1° of it, and bounds the cost.
    pub widest_px: f64,
}

impl Default for Approximation {
    fn default() -> Self {
        Self {
            tolerance_px: 0.02,
            widest_px: 1024.0,
        }
    }
}

/// A georeferenced file, ready to be evaluated on grids.
pub struct Warp {
    file: Arc<dyn RasterFile>,
    source: SourcePlane,
    extent: coverage::Extent,
    planet: Planet,
    kernel: Kernel,
    approximation: Approximation,
    finest_step_rad: f64,
    covered: coverage::Memory<Coverage>,
    spans: coverage::Memory<Option<[DVec2; 2]>>,
}

impl core::fmt::Debug for Warp {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Warp")
            .field("path", &self.file.path())
            .field("kernel", &self.kernel)
            .finish_non_exhaustive()
    }
}

impl Warp {
    /// Lays a file on the map.
    ///
    /// # Errors
    /// [`WarpError`] when it is not georeferenced or its coordinate system is not known.
    pub fn new(
        file: Arc<dyn RasterFile>,
        planet: Planet,
        kernel: Kernel,
    ) -> Result<Self, WarpError> {
        let source = SourcePlane::new(file.info())?;
        let extent = coverage::of_source(&source);
        let finest_step_rad = finest_step_rad(&source, &planet);
        Ok(Self {
            file,
            source,
            extent,
            planet,
            kernel,
            approximation: Approximation::default(),
            finest_step_rad,
            covered: coverage::Memory::default(),
            spans: coverage::Memory::default(),
        })
    }

    /// The same with another exactness, for measurements.
    #[must_use]
    pub fn with_approximation(mut self, approximation: Approximation) -> Self {
        self.approximation = approximation;
        self
    }

    /// The planet that it lies on.
    pub fn planet(&self) -> &Planet {
        &self.planet
    }

    /// How it is resampled.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The file.
    pub fn file(&self) -> &Arc<dyn RasterFile> {
        &self.file
    }

    /// The smaller side of a pixel of the full image, at its middle, as an angle at the planet's
    /// centre in radians: finer grids show nothing new.
    pub fn finest_step_rad(&self) -> f64 {
        self.finest_step_rad
    }

    /// The middle of the image on the map, and its width and height in metres if all pixels were as large as
    /// those there; `None` where the middle lies beyond the coordinate system's reach.
    pub fn middle(&self) -> Option<(MapPoint, [f64; 2])> {
        let middle = self.source.size * 0.5;
        let [x_rad, y_rad] = pixel_sides_rad(&self.source)?;
        let size_rad = DVec2::new(x_rad, y_rad) * self.source.size;
        let place = map_point(&self.source, middle)?;
        Some((place, (size_rad * self.planet.radius_m).to_array()))
    }

    /// Whether the file runs all around the globe from pole to pole.
    pub fn covers_globe(&self) -> bool {
        self.source.columns_around.is_some() && self.source.reflects == [true; 2]
    }

    /// How much of a grid the file's outline covers, from outlines alone: the same each time,
    /// remembered, and never wrong when it says inside or outside.
    pub fn coverage(&self, grid: &Grid) -> Coverage {
        if self.covers_globe() && !grid.rect.is_empty() {
            return Coverage::Inside;
        }
        let find = || coverage::coverage(&self.source, &self.extent, grid);
        self.covered.of(grid, find)
    }

    /// Between which pixels of the full image, continuous, a grid lies; never too narrow, remembered. `None`
    /// where part of it has no place there.
    pub(crate) fn span(&self, grid: &Grid) -> Option<[DVec2; 2]> {
        let find = || coverage::span(&self.source, grid);
        self.spans.of(grid, find)
    }

    /// Whether the file's image ends at its sides, at its first row and at its last.
    pub(crate) fn outline(&self) -> [bool; 3] {
        [
            self.source.columns_around.is_none(),
            !self.source.reflects[0],
            !self.source.reflects[1],
        ]
    }

    /// Whether all pixels have the same size in metres.
    pub(crate) fn pixels_are_alike(&self) -> bool {
        !self.source.crs.is_geographic()
    }

    /// Width and height in metres of a pixel of the full image's row `row` (continuous).
    pub(crate) fn pixel_size_m(&self, row: f64) -> [f64; 2] {
        let m = self.source.plane_from_pixel.matrix2;
        if !self.source.crs.is_geographic() {
            let unit_m = self.source.crs.metres_per_unit();
            return [m.x_axis.length() * unit_m, m.y_axis.length() * unit_m];
        }
        let lat = self
            .source
            .plane_from_pixel
            .transform_point2(DVec2::new(self.source.size.x * 0.5, row))
            .y;
        let degree_m = self.planet.radius_m * 1.0_f64.to_radians();
        let metres = DVec2::new(libm::cos(lat.to_radians()).abs(), 1.0) * degree_m;
        [(m.x_axis * metres).length(), (m.y_axis * metres).length()]
    }

    /// Calls `each` with the index (row by row) of every sample of a grid that may see the file,
    /// and its continuous place in pixels of the full image. Other samples lie outside.
    pub(crate) fn for_each_place(
        &self,
        grid: &Grid,
        mut each: impl FnMut(usize, DVec2),
    ) -> Result<(), WarpError> {
        let geometry = self.geometry(grid)?;
        for patch in geometry.patches(&grid.rect) {
            let part = patch.rect.intersection(&grid.rect);
            let in_patch = (part.min - patch.rect.min).as_usizevec2();
            let to = (part.min - grid.rect.min).as_usizevec2();
            let width = part.width() as usize;
            let (mut x, mut y): (Lane, Lane) = ([0.0; LANES], [0.0; LANES]);
            for row in 0..part.height() as usize {
                patch.places.row(
                    (patch.rect.width() as usize, patch.rect.height() as usize),
                    in_patch.x,
                    in_patch.y + row,
                    &mut x,
                    &mut y,
                );
                for (i, (x, y)) in x.iter().zip(&y).enumerate().take(width) {
                    let place =
                        DVec2::new(f64::from(*x), f64::from(*y)) + patch.window.min.as_dvec2();
                    let sample = (to.y + row) * grid.rect.width() as usize + to.x + i;
                    each(sample, place * geometry.scale_pixel(patch.scale));
                }
            }
        }
        Ok(())
    }

    /// The geometry of a grid.
    fn geometry<'a>(&'a self, grid: &'a Grid) -> Result<Geometry<'a>, WarpError> {
        Ok(Geometry {
            source: &self.source,
            overviews: &self.file.info().overviews,
            kernel: self.kernel,
            approximation: self.approximation,
            radius_m: self.planet.radius_m,
            lattice: &grid.lattice,
            target: cells::target(grid, &self.source)?,
        })
    }

    /// Evaluates a grid into `out` (reshaped to fit).
    ///
    /// # Errors
    /// [`ReadError`] when the file is damaged or gone, the grid's coordinate system is not known,
    /// or work was cancelled; the content of `out` is then unspecified.
    pub fn render(&self, grid: &Grid, out: &mut Block, cancel: &Cancel) -> Result<(), ReadError> {
        let bands = self.file.info().bands;
        let rect = &grid.rect;
        out.reshape(bands, rect.width() as usize, rect.height() as usize);
        out.samples_mut().fill(if bands == Bands::Height {
            f32::NAN
        } else {
            0.0
        });
        let geometry = self.geometry(grid).map_err(|e| ReadError::Io {
            reason: e.to_string(),
            path: self.file.path().to_owned(),
        })?;
        let mut patches = geometry.patches(rect);
        // Stable: patches of a scale stay in the order of their place.
        patches.sort_by_key(|p| p.scale);
        let mut scratch = Block::new(bands, 0, 0);
        for same_scale in patches.chunk_by_mut(|a, b| a.scale == b.scale) {
            self.render_patches(same_scale, rect, out, &mut scratch, cancel)?;
        }
        if self.mixes() {
            colour::unpremultiply(out);
        }
        Ok(())
    }

    /// Whether colours are mixed, and so have to be premultiplied.
    fn mixes(&self) -> bool {
        self.file.info().bands == Bands::Colour && self.kernel != Kernel::Nearest
    }

    /// Reads one window for all of the patches if they lie close to each other, else divides them.
    fn render_patches(
        &self,
        patches: &mut [Patch],
        rect: &SampleRect,
        out: &mut Block,
        scratch: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let [first, ..] = &*patches else {
            return Ok(());
        };
        let scale: Scale = first.scale;
        let union = patches
            .iter()
            .fold(SampleRect::default(), |all, p| all.union(&p.window));
        let needed: i64 = patches.iter().map(|p| p.window.area()).sum();
        let shares = union.area() <= (needed + SHARED_WINDOW_SLACK).min(LARGEST_SHARED_WINDOW);
        if patches.len() > 1 && !shares {
            let samples = patches
                .iter()
                .fold(SampleRect::default(), |all, p| all.union(&p.rect));
            if samples.width() > samples.height() {
                patches.sort_by_key(|p| p.rect.min.x);
            } else {
                patches.sort_by_key(|p| p.rect.min.y);
            }
            let (a, b) = patches.split_at_mut(patches.len() / 2);
            self.render_patches(a, rect, out, scratch, cancel)?;
            return self.render_patches(b, rect, out, scratch, cancel);
        }
        window::load(
            &*self.file,
            &self.source,
            scale,
            &union,
            self.mixes(),
            scratch,
            cancel,
        )?;
        let magnifies = |p: &Patch| p.footprint.radius_x <= 1.0 && p.footprint.radius_y <= 1.0;
        let fetched_together =
            self.mixes() && self.kernel == Kernel::Bilinear && patches.iter().any(magnifies);
        let pixels = fetched_together.then(|| pixels(scratch));
        on_widest(
            #[inline(always)]
            || {
                for patch in patches {
                    sample_patch(patch, &union, scratch, pixels.as_deref(), rect, out);
                }
            },
        );
        Ok(())
    }
}

/// The samples of a block of colours side by side.
fn pixels(block: &Block) -> Vec<[f32; 4]> {
    let [r, g, b, a] = core::array::from_fn(|plane| block.plane(plane));
    (r.iter().zip(g))
        .zip(b.iter().zip(a))
        .map(|((r, g), (b, a))| [*r, *g, *b, *a])
        .collect()
}

/// Evaluates the part of a patch in `rect` from the window that was read.
#[inline(always)]
fn sample_patch(
    patch: &Patch,
    read: &SampleRect,
    window: &Block,
    pixels: Option<&[[f32; 4]]>,
    rect: &SampleRect,
    out: &mut Block,
) {
    let part = patch.rect.intersection(rect);
    let corner = patch.window.min - read.min;
    let bands = window.bands().planes();
    let planes: [&[f32]; 4] = core::array::from_fn(|i| window.plane(i.min(bands - 1)));
    let view = Window {
        planes: &planes[..bands],
        pixels,
        offset: corner.y as usize * window.width() + corner.x as usize,
        stride: window.width(),
        width: patch.window.width() as usize,
        height: patch.window.height() as usize,
    };
    let width = part.width() as usize;
    let (mut x, mut y): (Lane, Lane) = ([0.0; LANES], [0.0; LANES]);
    let mut rows = [[0.0_f32; LANES]; 4];
    let in_patch = (part.min - patch.rect.min).as_usizevec2();
    let to = (part.min - rect.min).as_usizevec2();
    let [low, high] = patch.inside;
    let whole = {
        // No sample can lie outside of the source if no corner of the window does.
        let size = [view.width as f32, view.height as f32];
        low[0] <= 0.0
            && low[1] <= 0.0
            && high[0] >= size[0]
            && high[1] >= size[1]
            && !matches!(patch.places, places::Places::Each(_))
    };
    let out_width = out.width();
    for row in 0..part.height() as usize {
        patch.places.row(
            (patch.rect.width() as usize, patch.rect.height() as usize),
            in_patch.x,
            in_patch.y + row,
            &mut x,
            &mut y,
        );
        view.sample(patch.footprint, &x, &y, &mut rows[..bands]);
        let at = (to.y + row) * out_width + to.x;
        for (plane, samples) in rows.iter().enumerate().take(bands) {
            let target = &mut out.plane_mut(plane)[at..at + width];
            if whole {
                match target.first_chunk_mut() {
                    Some(all) => *all = *samples,
                    None => target.copy_from_slice(&samples[..width]),
                }
            } else {
                for (i, (v, s)) in target.iter_mut().zip(samples).enumerate() {
                    let inside =
                        (low[0] <= x[i]) & (x[i] <= high[0]) & (low[1] <= y[i]) & (y[i] <= high[1]);
                    *v = if inside { *s } else { *v };
                }
            }
        }
    }
}

fn finest_step_rad(source: &SourcePlane, planet: &Planet) -> f64 {
    if source.is_upright_geographic() {
        let m = source.plane_from_pixel.matrix2;
        return m.x_axis.x.abs().min(m.y_axis.y.abs()).to_radians();
    }
    match pixel_sides_rad(source) {
        Some([x, y]) if x > 0.0 && y > 0.0 => x.min(y),
        // The middle lies beyond the system's reach: its unit is the best guess.
        _ => {
            let m = source.plane_from_pixel.matrix2 * source.crs.metres_per_unit();
            m.x_axis.length().min(m.y_axis.length()) / planet.radius_m
        }
    }
}

/// Where a place in pixels lies, as far as the coordinate system reaches.
fn map_point(source: &SourcePlane, pixel: DVec2) -> Option<MapPoint> {
    let in_plane = source.plane_from_pixel.transform_point2(pixel);
    let p = plane::lonlat_from_plane(&source.crs, in_plane)?;
    Some(MapPoint::from_degrees(p.x.to_degrees(), p.y.to_degrees()))
}

/// Angles at the planet's centre along the sides of the middle pixel.
fn pixel_sides_rad(source: &SourcePlane) -> Option<[f64; 2]> {
    let middle = source.size * 0.5;
    let side = |by: DVec2| {
        let [from, to] = [middle - by * 0.5, middle + by * 0.5];
        Some(map_point(source, from)?.angle_to(map_point(source, to)?))
    };
    Some([side(DVec2::X)?, side(DVec2::Y)?])
}

#[cfg(test)]
mod tests;
