//! Samples of a raster file, laid on the grid: the loader and the map resampler.

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, GridCrs, SampleRect};
use relievo_raster::warp::{Coverage, Warp};
use relievo_raster::{Bands, Block};

use super::memory::add_grid;
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

/// A raster file as heights in metres or straight, display-referred colours. No inputs.
///
/// The file's coordinate system is undone and its samples interpolated (or averaged from its
/// overviews where the grid is coarser) by [`Warp`]. Heights become height · scale + offset.
#[derive(Debug)]
pub struct FileSource {
    warp: Arc<Warp>,
    scale: f64,
    offset_m: f64,
    name: ContentId,
}

impl FileSource {
    /// `scale` and `offset_m` change heights only: metres per unit of the file's values, and metres added;
    /// numbers that are not finite count as 1 and 0.
    pub fn new(warp: Arc<Warp>, scale: f64, offset_m: f64) -> Self {
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let offset_m = if offset_m.is_finite() { offset_m } else { 0.0 };
        let mut id = IdHasher::default();
        id.bytes(&warp.file().fingerprint());
        id.int(warp.kernel().tag());
        // The finest step stands for the planet that the file was laid on.
        id.float(scale)
            .float(offset_m)
            .float(warp.finest_step_rad());
        if let Some(place) = &warp.file().info().georeference {
            // The user may have said where the file lies.
            id.bytes(place.crs.as_bytes());
            for v in place.plane_from_pixel {
                id.float(v);
            }
        }
        Self {
            warp,
            scale,
            offset_m,
            name: id.finish(),
        }
    }

    /// The file on the map.
    pub fn warp(&self) -> &Arc<Warp> {
        &self.warp
    }

    /// Whether no sample of the grid can be a hole.
    fn is_complete(&self, grid: &Grid) -> bool {
        if self.warp.file().info().may_have_holes {
            return false;
        }
        if self.warp.covers_globe() {
            return true;
        }
        let lattice = &grid.lattice;
        if lattice.crs != GridCrs::Map || self.warp.coverage(grid) != Coverage::Inside {
            return false;
        }
        // Kernels reach over the outline near it: by up to two samples or four pixels of the file.
        let reach =
            libm::ceil(4.0 * self.warp.finest_step_rad() / lattice.step.abs().min_element()) + 2.0;
        if reach > 1e6 {
            return false;
        }
        let around = SampleRect::new(
            grid.rect.min - I64Vec2::splat(reach as i64),
            grid.rect.max + reach as i64,
        );
        self.warp.coverage(&grid.with_rect(around)) == Coverage::Inside
    }
}

impl ImageNode for FileSource {
    fn kind(&self) -> &'static str {
        "file"
    }

    fn version(&self) -> u32 {
        3
    }

    fn output(&self) -> Bands {
        self.warp.file().info().bands
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        if self.warp.coverage(grid) == Coverage::Outside {
            let absent = if self.output() == Bands::Height {
                f32::NAN
            } else {
                0.0
            };
            Known::Uniform([absent, 0.0, 0.0, 0.0])
        } else if self.is_complete(grid) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        self.warp.render(job.grid, out, job.cancel)?;
        if out.bands() == Bands::Height && (self.scale != 1.0 || self.offset_m != 0.0) {
            for h in out.samples_mut() {
                *h = (f64::from(*h) * self.scale + self.offset_m) as f32;
            }
        }
        Ok(())
    }
}
