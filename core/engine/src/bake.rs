//! Writing a region to a file: the graph evaluated on the file's own grid, block by block.

#[cfg(feature = "openexr")]
mod exr;

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use relievo_graph::{NodeIndex, RenderError};
use relievo_planet::{Grid, GridCrs, Lattice, SampleRect};
use relievo_raster::crs::Crs;
use relievo_raster::file::Georeference;
use relievo_raster::write::{
    CogLayout, CogSamples, CogWork, Png, WriteError, write_cog, write_png,
};
use relievo_raster::{Bands, Block, Cancel, PixelRect, normal};

use crate::query::Questions;

/// Side of a block and of a stored tile in samples.
pub(crate) const BLOCK: u32 = 512;

/// Largest PNG, which is held in memory as a whole: 16384² samples.
const LARGEST_PNG: u64 = 1 << 28;

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Heights in metres.
    Height,
    /// Colours as RGBA.
    Colour,
    /// East, north and up component of the surface normal, without exaggeration.
    Normal,
}

/// A region to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Bake {
    /// What to write.
    pub output: Output,
    /// Outer edges west, south, east, north in units of `crs`; in degrees, west beyond east crosses
    /// the antimeridian.
    pub bounds: [f64; 4],
    /// Size of a sample in units of `crs`, positive.
    pub resolution: f64,
    /// The coordinate system of bounds, resolution and file: `EPSG:n`, `ESRI:n` or a proj string.
    pub crs: String,
}

/// Why nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The region makes no sense.
    #[error("{0}")]
    Region(String),
    /// The project has nothing of that kind.
    #[error("the project has no {0} to write")]
    Nothing(&'static str),
    /// A source cannot be read.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// A region whose sense has been checked.
pub(crate) struct Plan {
    node: NodeIndex,
    lattice: Arc<Lattice>,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) georeference: Georeference,
}

impl Questions {
    /// Writes a region to a GeoTIFF (`.tif`, `.tiff`: Cloud Optimised, any size), to OpenEXR (`.exr`:
    /// tiled, any size; heights as f32, colours as linear, premultiplied half floats) or a PNG. Blocks
    /// are made on `threads` threads; the file is the same for any number. `progress` is told the
    /// part that is done, 0 to 1.
    ///
    /// A GeoTIFF whose making is stopped in any way keeps its finished tiles beside its place (its
    /// name and `.part`): the same request goes on from there, and ends in the same bytes.
    ///
    /// # Errors
    /// [`BakeError`]; a file that was there before is untouched then.
    pub fn bake(
        &self,
        bake: &Bake,
        path: &Path,
        threads: usize,
        progress: &mut dyn FnMut(f64),
        cancel: &Cancel,
    ) -> Result<(), BakeError> {
        let plan = self.plan(bake)?;
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("tif" | "tiff") => self.bake_cog(bake, &plan, path, threads, progress, cancel),
            #[cfg(feature = "openexr")]
            Some("exr") => self.bake_exr(bake, &plan, path, threads, progress, cancel),
            Some("png") => self.bake_png(bake, &plan, path, progress, cancel),
            _ => Err(BakeError::Region(format!(
                "expected a name that ends in .tif, .exr or .png, found \"{}\"",
                path.display()
            ))),
        }
    }

    pub(crate) fn plan(&self, bake: &Bake) -> Result<Plan, BakeError> {
        let region = |text: String| BakeError::Region(text);
        let crs = Crs::parse(&bake.crs).map_err(|e| region(e.to_string()))?;
        let [west, south, mut east, north] = bake.bounds;
        let finite = bake.bounds.iter().all(|b| b.is_finite()) && bake.resolution.is_finite();
        if !finite || bake.resolution <= 0.0 {
            return Err(region(
                "expected finite bounds and a positive resolution".to_owned(),
            ));
        }
        if crs.is_geographic() && west >= east {
            east += 360.0;
        }
        if east <= west || north <= south {
            return Err(region(format!(
                "expected bounds W,S,E,N with E beyond W and N beyond S, found {west},{south},{east},{north}"
            )));
        }
        if crs.is_geographic() && (north > 90.0 || south < -90.0 || east - west > 360.0) {
            return Err(region(format!(
                "expected bounds within 360° and from −90° to 90°, found {west},{south},{east},{north}"
            )));
        }
        // A hair less than a whole sample is a whole sample: bounds are decimal, steps are not.
        let samples = |length: f64| (length / bake.resolution - 1e-6).ceil().max(1.0);
        let (width, height) = (samples(east - west), samples(north - south));
        if width.max(height) > f64::from(1 << 30) {
            return Err(region(format!(
                "expected at most 2³⁰ samples a side, found {width} × {height}"
            )));
        }
        let scene = &self.scene;
        let node = match bake.output {
            Output::Height => scene.roots.height,
            Output::Colour => scene.roots.colour.ok_or(BakeError::Nothing("colour"))?,
            Output::Normal => scene.roots.normal.ok_or(BakeError::Nothing("heights"))?,
        };
        let step = bake.resolution;
        let lattice = if crs.is_geographic() {
            Lattice {
                crs: GridCrs::Map,
                origin: DVec2::new(west.to_radians(), (90.0 - north).to_radians()),
                step: DVec2::splat(step.to_radians()),
                columns_around: None,
            }
        } else {
            Lattice {
                crs: GridCrs::Projected(Arc::from(bake.crs.as_str())),
                origin: DVec2::new(west, north),
                step: DVec2::new(step, -step),
                columns_around: None,
            }
        };
        Ok(Plan {
            node,
            lattice: Arc::new(lattice),
            width: width as u32,
            height: height as u32,
            georeference: Georeference {
                crs: Arc::from(bake.crs.as_str()),
                plane_from_pixel: [west, step, 0.0, north, 0.0, -step],
            },
        })
    }

    fn grid(plan: &Plan, rect: PixelRect) -> Grid {
        let rect = SampleRect::at(
            i64::from(rect.x),
            i64::from(rect.y),
            i64::from(rect.width),
            i64::from(rect.height),
        );
        Grid::new(Arc::clone(&plan.lattice), rect)
    }

    pub(crate) fn block(
        &self,
        plan: &Plan,
        rect: PixelRect,
        cancel: &Cancel,
    ) -> Result<Block, RenderError> {
        let grid = Self::grid(plan, rect);
        self.scene.graph.evaluate(plan.node, &grid, cancel)
    }

    fn bake_cog(
        &self,
        bake: &Bake,
        plan: &Plan,
        path: &Path,
        threads: usize,
        progress: &mut dyn FnMut(f64),
        cancel: &Cancel,
    ) -> Result<(), BakeError> {
        let layout = CogLayout {
            width: plan.width,
            height: plan.height,
            samples: match bake.output {
                Output::Height => CogSamples::Height { nodata: -32767.0 },
                Output::Colour => CogSamples::Rgba8,
                Output::Normal => CogSamples::NormalF32,
            },
            tile: BLOCK,
            georeference: Some(plan.georeference.clone()),
            largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
        };
        let source = |rect: PixelRect| Ok(self.block(plan, rect, cancel)?);
        let whole = PixelRect {
            x: 0,
            y: 0,
            width: plan.width,
            height: plan.height,
        };
        let request = self
            .scene
            .graph
            .evaluation_id(plan.node, &Self::grid(plan, whole));
        let work = CogWork {
            threads,
            resume: Some(request.0),
            cancel,
        };
        Ok(write_cog(path, &layout, &source, &work, progress)?)
    }

    fn bake_png(
        &self,
        bake: &Bake,
        plan: &Plan,
        path: &Path,
        progress: &mut dyn FnMut(f64),
        cancel: &Cancel,
    ) -> Result<(), BakeError> {
        if u64::from(plan.width) * u64::from(plan.height) > LARGEST_PNG {
            return Err(BakeError::Region(format!(
                "expected a PNG of at most {LARGEST_PNG} samples, found {} × {}; write a .tif instead",
                plan.width, plan.height
            )));
        }
        let whole = PixelRect {
            x: 0,
            y: 0,
            width: plan.width,
            height: plan.height,
        };
        let block = self.block(plan, whole, cancel)?;
        progress(0.9);
        let (block, kind) = match bake.output {
            Output::Colour => (block, Png::Rgba8),
            Output::Normal => (shown_normals(&block), Png::Rgb8),
            Output::Height => {
                let heights = block.plane(0).iter().copied().filter(|h| h.is_finite());
                let (low_m, high_m) = heights
                    .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| {
                        (l.min(v), h.max(v))
                    });
                (block, Png::Heights16 { low_m, high_m })
            }
        };
        write_png(path, &block, kind)?;
        progress(1.0);
        Ok(())
    }
}

/// Normals as the usual picture of them: east, north, up from −1..1 to red, green, blue.
fn shown_normals(normals: &Block) -> Block {
    let mut picture = Block::new(Bands::Colour, normals.width(), normals.height());
    let (east, north) = (normals.plane(0).to_vec(), normals.plane(1).to_vec());
    let [red, green, blue, alpha] = picture.planes_mut();
    for (i, (x, y)) in east.into_iter().zip(north).enumerate() {
        let unit = normal::unit([x, y]).as_vec3();
        [red[i], green[i], blue[i]] = (0.5 + 0.5 * unit).to_array();
        alpha[i] = 1.0;
    }
    picture
}
