//! The map resampler: kernels, interpolated places and the filter about the poles.
//!
//! Surfaces are closed forms (`scene.rs`), so the truth of a sample is a formula and no finer picture.

mod gdal;
mod scene;

use core::hint::black_box;
use std::sync::Arc;

use glam::DVec2;
use relievo_engine::planet::{Grid, Planet};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::warp::{Approximation, Kernel, Warp};
use relievo_engine::raster::{Bands, Block, Cancel, RasterFile};

use crate::timing::in_turns;
use crate::{Chart, Content, Context, Curve, Figure, Point, Report, Suite, SuiteError, Work};
use scene::{Memory, Waves, crs, degrees, lonlats, unit};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "resample",
    sentence: "From a file in any coordinate system to any grid: kernels, interpolated places, and the filter about the poles.",
    run,
};

/// Kernels by name, ours and GDAL's.
const KERNELS: [(Kernel, &str, &str); 3] = [
    (Kernel::Nearest, "nearest", "near"),
    (Kernel::Bilinear, "bilinear", "bilinear"),
    (Kernel::Bicubic, "bicubic", "cubic"),
];

/// Tolerances of interpolated places, pixels; the third is what is shown with.
const TOLERANCES_PX: [f64; 5] = [0.0, 0.002, 0.02, 0.125, 0.5];

/// GDAL's tolerances (`-et`): none, its default, a coarser one.
const GDAL_TOLERANCES_PX: [f64; 3] = [0.0, 0.125, 0.5];

/// Widest kernels along a row, pixels; the last but one is what is shown with.
const WIDEST_PX: [f64; 6] = [1.0, 4.0, 16.0, 128.0, 1024.0, 4096.0];

/// Metres of a pixel of the polar file.
const PIXEL_M: f64 = 10_000.0;

/// Pixels of a side of the polar file: to 47° N.
const SIDE: usize = 960;

/// Degrees of a sample of the grid that it is laid on: at most 1.17 pixels on the ground, so that kernels
/// are as narrow as they get and a ramp stays a ramp.
const STEP_DEG: DVec2 = DVec2::new(0.15, 0.1);

/// Polar stereographic, far from straight in longitude and latitude.
const POLAR: &str = "EPSG:3413";

fn run(context: &Context) -> Result<Report, SuiteError> {
    let peer = context.peers.then(gdal::Peer::find).flatten();
    let (kernels, summary) = kernels(context, peer.as_ref())?;
    context.step(4, 10)?;
    let places = places(context, peer.as_ref())?;
    context.step(8, 10)?;
    let poles = poles(context)?;
    let mut report = Report {
        summary: vec![summary],
        figures: vec![kernels, places, poles],
    };
    report.summary.push(match peer {
        Some(peer) => format!(
            "GDAL's points are those of {}: its time is that of a large output minus that of a tiny one, so that \
             starting the program and opening the file do not count; one thread.",
            peer.version
        ),
        None => "GDAL's warp is not in the plots: no gdalwarp is installed here, or no other program was to be run.".to_owned(),
    });
    Ok(report)
}

/// The polar file with values by longitude and latitude or by place on its plane.
fn polar_file(value: impl Fn(DVec2) -> f64) -> Arc<dyn RasterFile> {
    let half_m = SIDE as f64 * PIXEL_M / 2.0;
    let place = [-half_m, PIXEL_M, 0.0, half_m, 0.0, -PIXEL_M];
    Memory::file(POLAR, place, [SIDE, SIDE], 0, value)
}

/// A grid over the polar file, from 57° to 83° N.
fn polar_grid(context: &Context) -> Grid {
    let columns = context.pick(256, 1024);
    degrees(-100.0, 83.0, STEP_DEG, [columns, 256])
}

/// The samples of a grid.
fn rendered(warp: &Warp, grid: &Grid) -> Result<Block, SuiteError> {
    let mut out = Block::new(Bands::Height, 0, 0);
    warp.render(grid, &mut out, &Cancel::default())
        .map_err(|error| SuiteError::System(error.to_string()))?;
    Ok(out)
}

fn warp(
    file: &Arc<dyn RasterFile>,
    kernel: Kernel,
    approximation: Approximation,
) -> Result<Warp, SuiteError> {
    let warp = Warp::new(Arc::clone(file), Planet::EARTH, kernel)
        .map_err(|error| SuiteError::System(error.to_string()))?;
    Ok(warp.with_approximation(approximation))
}

/// Work that renders a tile's worth of a grid.
fn work<'a>(context: &Context, warp: &'a Warp, grid: &Grid) -> Work<'a> {
    let side = context.pick(64, 256);
    let (rect, size) = (grid.rect, grid.rect.max - grid.rect.min);
    let tile = relievo_engine::planet::SampleRect::at(
        rect.min.x,
        rect.min.y,
        size.x.min(side),
        size.y.min(side),
    );
    let grid = grid.with_rect(tile);
    let mut out = Block::new(Bands::Height, 0, 0);
    Work::new(tile.area() as f64, move || {
        // Whether it works was seen before.
        let done = warp.render(black_box(&grid), &mut out, &Cancel::default());
        black_box((&done, &out));
    })
}

/// Root mean square of differences; infinite where there is a hole.
fn rms_of(differences: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = differences.fold((0.0, 0_u32), |(sum, n), d| (sum + d * d, n + 1));
    let rms = libm::sqrt(sum / f64::from(count.max(1)));
    if rms.is_nan() { f64::INFINITY } else { rms }
}

/// Error of kernels against time, places interpolated more or less.
fn kernels(context: &Context, peer: Option<&gdal::Peer>) -> Result<(Figure, String), SuiteError> {
    let waves = Waves::new(6.0 * PIXEL_M, 60.0 * PIXEL_M, 12);
    let system = crs(POLAR)?;
    let file = polar_file(|plane| match system.to_lonlat(plane.x, plane.y) {
        Ok((lon, lat)) => waves.at(unit(lon, lat)),
        Err(_beyond) => f64::NAN,
    });
    let grid = polar_grid(context);
    let truth: Vec<f64> = lonlats(&grid).map(|p| waves.at(unit(p.x, p.y))).collect();
    let scale = waves.rms();
    let error_of = |samples: &[f32]| {
        let each = samples.iter().zip(&truth);
        rms_of(each.map(|(found, truth)| f64::from(*found) - truth)) / scale
    };
    let mut warps = Vec::new();
    for (kernel, _, _) in KERNELS {
        for tolerance_px in TOLERANCES_PX {
            let approximation = Approximation {
                tolerance_px,
                ..Approximation::default()
            };
            warps.push(warp(&file, kernel, approximation)?);
        }
    }
    let mut errors = Vec::new();
    for warp in &warps {
        context.go_on()?;
        errors.push(error_of(rendered(warp, &grid)?.samples()));
    }
    let mut works: Vec<Work> = warps
        .iter()
        .map(|warp| work(context, warp, &grid))
        .collect();
    let times = in_turns(context, &mut works)?;
    let mut curves = Vec::new();
    let of_kernels = KERNELS.iter().zip(errors.chunks(TOLERANCES_PX.len()));
    for (((_, name, _), errors), times) in of_kernels.zip(times.chunks(TOLERANCES_PX.len())) {
        let points = TOLERANCES_PX.iter().zip(errors).zip(times);
        let points = points.map(|((tolerance, error), time)| {
            Point::timed(format!("places within {tolerance} px"), *time, *error)
        });
        curves.push(Curve {
            name: (*name).to_owned(),
            points: points.collect(),
            joined: true,
        });
    }
    let shown = |kernel: usize| errors[kernel * TOLERANCES_PX.len() + 2];
    let summary = format!(
        "On a ground with features of 6 to 60 pixels the shown settings (places within 0.02 pixels) are off by {} of its \
         standard deviation with the nearest sample, {} bilinearly and {} with the cubic kernel.",
        crate::number::text(shown(0)),
        crate::number::text(shown(1)),
        crate::number::text(shown(2)),
    );
    if let Some(peer) = peer {
        for (_, _, method) in KERNELS {
            let warped = peer.curve(
                context,
                &file,
                &grid,
                method,
                &GDAL_TOLERANCES_PX,
                &error_of,
            )?;
            curves.push(warped);
        }
    }
    let caption = "A polar stereographic file of 10 km pixels (float, in memory) on a grid of 0.15° × 0.1° from 57° to 83° N; \
                   one thread. Error: root mean square against the closed form of the surface, in parts of the surface's own. \
                   Truth: twelve plane waves through space, 6 to 60 pixels long, heights in proportion.";
    let chart = Chart::trade(
        "ns per sample",
        "root mean square error",
        "parts of the surface's",
        curves,
    );
    let figure = Figure::new("kernels", "Kernels", caption, Content::Chart(chart));
    Ok((figure, summary))
}

/// Error of interpolated places against time.
fn places(context: &Context, peer: Option<&gdal::Peer>) -> Result<Figure, SuiteError> {
    // Bilinear samples of a ramp are places: columns along one axis, rows along the other.
    let system = crs(POLAR)?;
    let grid = polar_grid(context);
    let mut exact = Vec::new();
    for p in lonlats(&grid) {
        exact.push(pixels_of(&system, p)?);
    }
    let ramps: [Arc<dyn RasterFile>; 2] =
        [|p: DVec2| p.x / PIXEL_M, |p: DVec2| -p.y / PIXEL_M].map(polar_file);
    let mut points = Vec::new();
    let mut warps = Vec::new();
    for tolerance_px in TOLERANCES_PX {
        let approximation = Approximation {
            tolerance_px,
            ..Approximation::default()
        };
        let mut worst = 0.0_f64;
        let mut both = Vec::new();
        for ramp in &ramps {
            let warp = warp(ramp, Kernel::Bilinear, approximation)?;
            both.push(rendered(&warp, &grid)?);
            warps.push(warp);
        }
        for (i, exact) in exact.iter().enumerate() {
            let found = [&both[0], &both[1]].map(|block| f64::from(block.samples()[i]));
            worst = worst.max(DVec2::from(found).distance(*exact));
        }
        points.push((tolerance_px, worst));
    }
    let mut works: Vec<Work> = warps
        .iter()
        .step_by(2)
        .map(|w| work(context, w, &grid))
        .collect();
    let times = in_turns(context, &mut works)?;
    let ours = points.iter().zip(times).map(|((tolerance, error), time)| {
        Point::timed(format!("tolerance {tolerance} px"), time, *error)
    });
    let mut curves = vec![Curve {
        name: "interpolated along lines and parabolas".to_owned(),
        points: ours.collect(),
        joined: true,
    }];
    if let Some(peer) = peer {
        let along = |samples: &[f32]| {
            let each = samples.iter().zip(&exact);
            each.map(|(found, exact)| (f64::from(*found) - exact.x).abs())
                .fold(0.0, f64::max)
        };
        let tolerances = [0.0, 0.02, 0.125, 0.5];
        curves.push(peer.curve(context, &ramps[0], &grid, "bilinear", &tolerances, &along)?);
    }
    let caption = "How far the place that a sample is read from is from its exact projection, at most, over the same grid. \
                   Places are read off a bilinear warp of ramps, whose f32 samples hold them to 3·10⁻⁵ pixels; GDAL's along columns only.";
    let chart = Chart::trade(
        "ns per sample",
        "largest error of a place",
        "pixels",
        curves,
    );
    Ok(Figure::new(
        "places",
        "Interpolated places",
        caption,
        Content::Chart(chart),
    ))
}

/// Place in the polar file, pixels from its middle, of a longitude and latitude in radians.
fn pixels_of(system: &Crs, lonlat: DVec2) -> Result<DVec2, SuiteError> {
    let (x, y) = system
        .from_lonlat(lonlat.x, lonlat.y)
        .map_err(|error| SuiteError::System(error.to_string()))?;
    Ok(DVec2::new(x, -y) / PIXEL_M)
}

/// Error of the filter about a pole against time.
fn poles(context: &Context) -> Result<Figure, SuiteError> {
    let columns = context.pick(1024, 4096);
    let pixel_deg = 360.0 / columns as f64;
    let pixel_m = pixel_deg.to_radians() * Planet::EARTH.radius_m;
    // From half of a sample of the grid on: what has to be filtered out as well as what has to stay.
    let waves = Waves::new(2.0 * pixel_m, 64.0 * pixel_m, 16);
    let place = [-180.0, pixel_deg, 0.0, 90.0, 0.0, -pixel_deg];
    let file = Memory::file("EPSG:4326", place, [columns, columns / 2], 5, |p| {
        waves.at(unit(p.x.to_radians(), p.y.to_radians()))
    });
    let step_deg = 4.0 * pixel_deg;
    let rows = context.pick(8, 16);
    let grid = degrees(-180.0, 90.0, DVec2::splat(step_deg), [256, rows]);
    let radius_rad = step_deg.to_radians();
    let truth: Vec<f64> = lonlats(&grid)
        .map(|p| filtered(&waves, p, radius_rad, context.pick(8, 24)))
        .collect();
    let scale = waves.rms();
    let mut warps = Vec::new();
    for widest_px in WIDEST_PX {
        let approximation = Approximation {
            widest_px,
            ..Approximation::default()
        };
        warps.push(warp(&file, Kernel::Bilinear, approximation)?);
    }
    let mut errors = Vec::new();
    for warp in &warps {
        context.go_on()?;
        let found = rendered(warp, &grid)?;
        let each = found.samples().iter().zip(&truth);
        errors.push(rms_of(each.map(|(f, t)| f64::from(*f) - t)) / scale);
    }
    let mut works: Vec<Work> = warps
        .iter()
        .map(|warp| work(context, warp, &grid))
        .collect();
    let times = in_turns(context, &mut works)?;
    let points = WIDEST_PX.iter().zip(errors).zip(times);
    let points = points.map(|((widest, error), time)| {
        Point::timed(format!("rows at most {widest} px wide"), time, error)
    });
    let curve = Curve {
        name: "kernel round on the ground".to_owned(),
        points: points.collect(),
        joined: true,
    };
    let caption = format!(
        "A plate carrée file of {columns} × {} pixels on a grid four times as coarse, the {rows} rows about the north pole. \
         Error: root mean square against the surface under a tent of the stated size on the ground (as wide as a sample is high, \
         integrated over its closed form), in parts of the surface's own; the surface has features from 2 pixels on.",
        columns / 2
    );
    let chart = Chart::trade(
        "ns per sample",
        "root mean square error",
        "parts of the surface's",
        vec![curve],
    );
    Ok(Figure::new(
        "poles",
        "The filter about a pole",
        caption,
        Content::Chart(chart),
    ))
}

/// The surface under a tent about a place, `radius_rad` to each side along both axes of the ground:
/// the mean of `count`² points, which follow the tent's weight.
fn filtered(waves: &Waves, lonlat: DVec2, radius_rad: f64, count: u32) -> f64 {
    let up = unit(lonlat.x, lonlat.y);
    let (sin_lon, cos_lon) = libm::sincos(lonlat.x);
    let east = glam::DVec3::new(-sin_lon, cos_lon, 0.0);
    let north = up.cross(east);
    // Quantiles of the tent: where equal shares of its weight have their middles.
    let offset = |k: u32| {
        let share = (f64::from(k) + 0.5) / f64::from(count);
        let from_end = libm::sqrt(2.0 * share.min(1.0 - share));
        radius_rad
            * if share < 0.5 {
                from_end - 1.0
            } else {
                1.0 - from_end
            }
    };
    let mut sum = 0.0;
    for i in 0..count {
        for j in 0..count {
            let point = up + east * offset(i) + north * offset(j);
            sum += waves.at(point.normalize());
        }
    }
    sum / f64::from(count * count)
}
