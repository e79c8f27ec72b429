//! Surfaces whose height is a closed form everywhere, and files of their samples.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use relievo_engine::planet::{Grid, GridCrs, Lattice, MapPoint, Planet, SampleRect};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::file::{Georeference, OverviewInfo, ReadError};
use relievo_engine::raster::{Bands, Block, Cancel, PixelRect, RasterFile, RasterInfo, reduce};

use crate::SuiteError;

/// A surface: plane waves through space, as the sphere cuts them. The same on every call.
#[derive(Clone, Debug)]
pub(super) struct Waves(Vec<(DVec3, f64, f64)>);

impl Waves {
    /// Waves of `count` lengths from `shortest_m` to `longest_m`, evenly in their logarithm, heights
    /// in proportion to lengths (a natural ground), directions spread by the golden angle.
    pub(super) fn new(shortest_m: f64, longest_m: f64, count: u32) -> Self {
        let wave = |k: u32| {
            let share = f64::from(k) / f64::from(count - 1).max(1.0);
            let length_m = shortest_m * libm::pow(longest_m / shortest_m, share);
            let up = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(count);
            let (sin, cos) = libm::sincos(2.399_963_229_728_653 * f64::from(k));
            let across = libm::sqrt(1.0 - up * up);
            let direction = DVec3::new(across * cos, across * sin, up);
            let number = core::f64::consts::TAU / length_m * Planet::EARTH.radius_m;
            (direction * number, length_m / longest_m, 1.7 * f64::from(k))
        };
        Self((0..count).map(wave).collect())
    }

    /// Height at a point of the unit sphere.
    pub(super) fn at(&self, unit: DVec3) -> f64 {
        let waves = self.0.iter();
        waves
            .map(|(wave, height, phase)| height * libm::sin(wave.dot(unit) + phase))
            .sum()
    }

    /// Root mean square of the heights.
    pub(super) fn rms(&self) -> f64 {
        libm::sqrt(
            self.0
                .iter()
                .map(|(_, height, _)| height * height / 2.0)
                .sum(),
        )
    }
}

/// The point of the unit sphere at a longitude and latitude in radians.
pub(super) fn unit(lon_rad: f64, lat_rad: f64) -> DVec3 {
    MapPoint::new(lon_rad, core::f64::consts::FRAC_PI_2 - lat_rad).to_unit()
}

/// A file in memory.
pub(super) struct Memory {
    info: RasterInfo,
    levels: Vec<Block>,
}

impl Memory {
    /// A square or oblong of `size` pixels whose samples are what `value` says of a pixel's centre on
    /// the plane of its system, with `overviews` halvings.
    pub(super) fn file(
        crs: &str,
        plane_from_pixel: [f64; 6],
        size: [usize; 2],
        overviews: usize,
        value: impl Fn(DVec2) -> f64,
    ) -> Arc<dyn RasterFile> {
        let mut full = Block::new(Bands::Height, size[0], size[1]);
        let [x0, xc, _, y0, _, yr] = plane_from_pixel;
        for (i, sample) in full.plane_mut(0).iter_mut().enumerate() {
            let pixel = DVec2::new((i % size[0]) as f64, (i / size[0]) as f64) + 0.5;
            *sample = value(DVec2::new(x0, y0) + pixel * DVec2::new(xc, yr)) as f32;
        }
        let mut levels = vec![full];
        for _ in 0..overviews {
            let next = reduce::halve(&levels[levels.len() - 1]);
            levels.push(next);
        }
        let sizes = levels.iter().map(|level| OverviewInfo {
            width: level.width() as u32,
            height: level.height() as u32,
        });
        let info = RasterInfo {
            path: PathBuf::from("memory"),
            format: "memory",
            overviews: sizes.collect(),
            bands: Bands::Height,
            band_count: 1,
            sample_type: "float32".into(),
            compression: "none".into(),
            deep_colour: false,
            nodata: None,
            may_have_holes: false,
            georeference: Some(Georeference {
                crs: crs.into(),
                plane_from_pixel,
            }),
        };
        Arc::new(Self { info, levels })
    }
}

impl RasterFile for Memory {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn fingerprint(&self) -> [u8; 32] {
        [0; 32]
    }

    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        _: &Cancel,
    ) -> Result<(), ReadError> {
        let size = (rect.width as usize, rect.height as usize);
        out.reshape(Bands::Height, size.0, size.1);
        let from = (rect.x as usize, rect.y as usize);
        out.copy_from(&self.levels[overview], from, (0, 0), size);
        Ok(())
    }
}

/// A grid of degrees whose first sample's corner is at `west_deg`, `north_deg`.
pub(super) fn degrees(west_deg: f64, north_deg: f64, step_deg: DVec2, size: [i64; 2]) -> Grid {
    let lattice = Lattice {
        crs: GridCrs::Projected("EPSG:4326".into()),
        origin: DVec2::new(west_deg, north_deg),
        step: DVec2::new(step_deg.x, -step_deg.y),
        columns_around: None,
    };
    Grid::new(Arc::new(lattice), SampleRect::at(0, 0, size[0], size[1]))
}

/// Longitude and latitude in radians of all samples of a grid of degrees, row by row.
pub(super) fn lonlats(grid: &Grid) -> impl Iterator<Item = DVec2> {
    let lattice = grid.lattice.clone();
    let (min, size) = (grid.rect.min, grid.rect.max - grid.rect.min);
    (0..size.x * size.y).map(move |i| {
        let at = min + glam::I64Vec2::new(i % size.x, i / size.x);
        let centre = lattice.centre(at);
        DVec2::new(centre.x.to_radians(), centre.y.to_radians())
    })
}

/// A coordinate system that the program knows.
pub(super) fn crs(name: &str) -> Result<Crs, SuiteError> {
    Crs::parse(name).map_err(|error| SuiteError::System(error.to_string()))
}
