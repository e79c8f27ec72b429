//! GDAL's warp beside ours, where it is installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

use relievo_engine::planet::Grid;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_engine::raster::{Block, Cancel, PixelRect, RasterFile};

use crate::{Context, Curve, Point, Spread, SuiteError};

/// An installed `gdalwarp`.
pub(super) struct Peer {
    /// The program.
    program: &'static str,
    /// What it says it is.
    pub(super) version: String,
}

fn system(error: impl core::fmt::Display) -> SuiteError {
    SuiteError::System(format!("cannot compare with gdalwarp: {error}"))
}

impl Peer {
    /// Looks for it on the path.
    pub(super) fn find() -> Option<Self> {
        let program = "gdalwarp";
        let output = Command::new(program).arg("--version").output().ok()?;
        let version = String::from_utf8_lossy(&output.stdout);
        let version = version.split(',').next()?.trim().to_owned();
        (output.status.success() && !version.is_empty()).then_some(Self { program, version })
    }

    /// Error against time of warps to a grid of degrees with a method (`-r`) and each of some
    /// tolerances in pixels (`-et`); `error` judges the samples.
    pub(super) fn curve(
        &self,
        context: &Context,
        file: &Arc<dyn RasterFile>,
        grid: &Grid,
        method: &str,
        tolerances_px: &[f64],
        error: &dyn Fn(&[f32]) -> f64,
    ) -> Result<Curve, SuiteError> {
        let folder = tempfile::tempdir().map_err(system)?;
        let source = folder.path().join("source.tif");
        write(file, &source)?;
        let out = |k: usize| folder.path().join(format!("{k}.tif"));
        let tiny = grid.with_rect(relievo_engine::planet::SampleRect::at(0, 0, 8, 8));
        let repetitions = context.pick(3, 9);
        let mut times = vec![[Vec::new(), Vec::new()]; tolerances_px.len()];
        for _ in 0..repetitions {
            for (k, tolerance) in tolerances_px.iter().enumerate() {
                context.go_on()?;
                // The whole one comes last, so that its file stays.
                for (grid, times) in [&tiny, grid].into_iter().zip(&mut times[k]) {
                    times.push(self.warp_ns(&source, &out(k), grid, method, *tolerance)?);
                }
            }
        }
        let samples = (grid.rect.area() - tiny.rect.area()) as f64;
        let mut points = Vec::new();
        for (k, ([tiny, whole], tolerance)) in times.into_iter().zip(tolerances_px).enumerate() {
            let medians =
                [whole, tiny].map(|times| Spread::of(times).map_or(f64::NAN, |s| s.median));
            // What is lost in the noise of starting a program is no time.
            let time_ns = Some((medians[0] - medians[1]) / samples).filter(|ns| *ns > 0.0);
            let setting = format!("-et {tolerance}");
            let found = read(&out(k))?;
            points.push(Point::new(
                setting,
                time_ns.unwrap_or(f64::NAN),
                error(found.samples()),
            ));
        }
        Ok(Curve {
            name: format!("GDAL, {method}"),
            points,
            joined: true,
        })
    }

    /// Nanoseconds of one run.
    fn warp_ns(
        &self,
        source: &Path,
        out: &PathBuf,
        grid: &Grid,
        method: &str,
        tolerance_px: f64,
    ) -> Result<f64, SuiteError> {
        let (lattice, rect) = (&grid.lattice, grid.rect);
        let corner = |at: glam::I64Vec2| lattice.origin + at.as_dvec2() * lattice.step;
        let (nw, se) = (corner(rect.min), corner(rect.max));
        let numbers = |all: &[f64]| all.iter().map(f64::to_string).collect::<Vec<_>>();
        let mut command = Command::new(self.program);
        command
            .args([
                "-q",
                "-overwrite",
                "-t_srs",
                "EPSG:4326",
                "-ot",
                "Float32",
                "-te",
            ])
            .args(numbers(&[nw.x, se.y, se.x, nw.y]))
            .arg("-ts")
            .args([rect.width().to_string(), rect.height().to_string()])
            .args(["-r", method, "-et", &tolerance_px.to_string()])
            .args(["-ovr", "NONE"])
            .arg(source)
            .arg(out)
            .env("GDAL_NUM_THREADS", "1")
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let start = Instant::now();
        let output = command.output().map_err(system)?;
        let time_ns = start.elapsed().as_nanos() as f64;
        if !output.status.success() {
            return Err(system(String::from_utf8_lossy(&output.stderr).trim()));
        }
        Ok(time_ns)
    }
}

/// Writes a file's pixels as a GeoTIFF.
fn write(file: &Arc<dyn RasterFile>, path: &Path) -> Result<(), SuiteError> {
    let info = file.info();
    let layout = CogLayout {
        width: info.overviews[0].width,
        height: info.overviews[0].height,
        samples: CogSamples::Height { nodata: f32::NAN },
        tile: 256,
        georeference: info.georeference.clone(),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: PixelRect| {
        let mut part = Block::new(info.bands, 0, 0);
        file.read(0, rect, &mut part, &Cancel::default())?;
        Ok(part)
    };
    let work = CogWork {
        threads: 1,
        resume: None,
        cancel: &Cancel::default(),
    };
    write_cog(path, &layout, &source, &work, &mut |_| {}).map_err(system)?;
    Ok(())
}

/// The samples of a file.
fn read(path: &Path) -> Result<Block, SuiteError> {
    let file = open(path, &OpenOptions::default()).map_err(system)?;
    let size = file.info().overviews[0];
    let all = PixelRect {
        x: 0,
        y: 0,
        width: size.width,
        height: size.height,
    };
    let mut block = Block::new(file.info().bands, 0, 0);
    file.read(0, all, &mut block, &Cancel::default())
        .map_err(system)?;
    Ok(block)
}
