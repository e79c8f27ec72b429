//! Synthesised heights: how near to the truth their roughness is, against their cost.
//!
//! Heights are thinned out, continued by a detail layer, and compared with what they were: by the mean
//! square of second differences at distances that double, the measure by which detail follows the data
//! (decision 30). Places differ, as they must; statistics should not.

use core::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_engine::graph::roughness::Surface;
use relievo_engine::planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_engine::project::{
    Detail, DetailLayer, DetailMethod, HeightLayer, Layer, LayerId, LayerKind, PlanetSettings,
    Project, Source,
};
use relievo_engine::raster::kernel::Kernel;
use relievo_engine::raster::warp::Warp;
use relievo_engine::raster::{Cancel, crs::Crs};
use relievo_engine::{Bake, Engine, EngineOptions, Output, Questions, SourceState, Stage};

use crate::scene::open;
use crate::timing::in_turns;
use crate::{
    Axis, Chart, Content, Context, Curve, Figure, Point, Report, Spread, Suite, SuiteError, Table,
    Work,
};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "detail",
    sentence: "Synthesised heights: how near to the truth the roughness of thinned and continued ground is, against the cost of continuing it.",
    run,
};

/// How many times fewer samples the thinned heights have along a side.
const THINNED: f64 = 8.0;

/// Metres from sample to sample of ground that has no end.
const NOISE_SPACING_M: f64 = 80.0;

/// Thinned samples from the middle to each side of the square that is thinned.
const HALF: f64 = 64.0;

const THINNED_ID: &str = "thinned";
const DETAIL_ID: &str = "detail";

/// Ground that is taken as the truth.
struct Truth {
    layer: Layer,
    place: MapPoint,
    spacing_rad: f64,
}

/// One way to have heights between thinned samples.
struct Way {
    name: &'static str,
    questions: Questions,
    layer: &'static str,
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let engine = open(context)?;
    let truth = truth(&engine)?;
    let planet = engine.project().planet.clone();
    let folder = tempfile::tempdir().map_err(|e| SuiteError::System(e.to_string()))?;
    let thinned = folder.path().join("thinned.tif");
    let layers = vec![truth.layer.clone()];
    let original = questions(&planet, layers, engine.folder())?;
    bake(&original, &truth, &thinned, &context.cancel)?;
    context.step(1, 4)?;

    let ways = ways(&planet, &thinned)?;
    let figure = planet.body.figure();
    let level = level(truth.spacing_rad);
    let side = context.pick(256, 1024);
    let grid = square(level, truth.place, side);
    let whole = energies(
        &samples(&original, &truth.layer.id, &grid, &context.cancel)?,
        (level, &figure, truth.place, side),
    );
    if !whole.iter().any(|lag| lag.db > 0.0) {
        let found = truth.layer.id.0.as_str();
        let expected = "expected heights that are not level about the middle of the finest layer";
        return Err(SuiteError::Input(format!(
            "{expected}, found none in {found:?}"
        )));
    }
    let mut off_db = Vec::new();
    for way in &ways {
        context.go_on()?;
        let heights = samples(&way.questions, &way.layer.into(), &grid, &context.cancel)?;
        let found = energies(&heights, (level, &figure, truth.place, side));
        let off = found.iter().zip(&whole).map(|(found, whole)| Lag {
            lag_m: whole.lag_m,
            db: 10.0 * libm::log10(found.db / whole.db),
        });
        off_db.push(off.collect::<Vec<Lag>>());
    }
    context.step(2, 4)?;
    let times = times(context, &ways, level, truth.place)?;
    Ok(Report {
        summary: vec![summary(&off_db, &truth, &figure)],
        figures: vec![
            spectra(&ways, &off_db),
            trade(&ways, &off_db, &times, truth.spacing_rad * figure.radius_m),
            table(&ways, &off_db),
        ],
    })
}

/// The finest heights of a project, or else its first noise below the camera.
fn truth(engine: &Engine) -> Result<Truth, SuiteError> {
    let project = engine.project();
    let figure = project.planet.body.figure();
    let of_file = |layer: &Layer| {
        let state = engine.sources().state(&layer.kind, engine.folder());
        let Some(SourceState::Open(file)) = state else {
            return None;
        };
        let warp = Warp::new(file, figure, Kernel::Bilinear).ok()?;
        Some(Truth {
            layer: layer.clone(),
            place: warp.middle()?.0,
            spacing_rad: warp.finest_step_rad(),
        })
    };
    let shown = project.layers.iter().filter(|layer| layer.visible);
    let files = shown
        .clone()
        .filter(|layer| matches!(layer.kind, LayerKind::Height(_)))
        .filter_map(of_file);
    let camera = project.camera.to_camera();
    let of_noise = || {
        let mut noise = shown.filter(|layer| matches!(layer.kind, LayerKind::Noise(_)));
        Some(Truth {
            layer: noise.next()?.clone(),
            place: MapPoint::new(
                camera.lon_rad,
                core::f64::consts::FRAC_PI_2 - camera.lat_rad,
            ),
            spacing_rad: NOISE_SPACING_M / figure.radius_m,
        })
    };
    let found = files
        .min_by(|a, b| a.spacing_rad.total_cmp(&b.spacing_rad))
        .or_else(of_noise);
    let mut found = found.ok_or_else(|| {
        SuiteError::Input("expected a project with a visible layer of heights, found none".into())
    })?;
    found.layer.opacity = 1.0;
    Ok(found)
}

/// Writes the heights with so many fewer samples; angles are what counts, whatever the planet.
fn bake(original: &Questions, truth: &Truth, to: &Path, cancel: &Cancel) -> Result<(), SuiteError> {
    let (lon_deg, lat_deg) = truth.place.to_degrees();
    let zone = (((lon_deg + 180.0) / 6.0).floor() as u32).min(59) + 1;
    let crs = format!(
        "EPSG:{}",
        if lat_deg < 0.0 { 32_700 } else { 32_600 } + zone
    );
    let input = |e: &dyn core::fmt::Display| SuiteError::Input(e.to_string());
    let system = Crs::parse(&crs).map_err(|e| input(&e))?;
    let (x, y) = system
        .from_lonlat(lon_deg.to_radians(), lat_deg.to_radians())
        .map_err(|e| input(&e))?;
    let resolution = THINNED * truth.spacing_rad * Planet::EARTH.radius_m;
    let half = HALF * resolution;
    let bake = Bake {
        output: Output::Height,
        bounds: [x - half, y - half, x + half, y + half],
        resolution,
        crs,
    };
    let baked = original.bake(&bake, to, 1, &mut |_| {}, cancel);
    baked.map_err(|e| SuiteError::System(e.to_string()))?;
    Ok(())
}

/// The thinned heights as they are, and continued.
fn ways(planet: &PlanetSettings, thinned: &Path) -> Result<Vec<Way>, SuiteError> {
    let path = thinned
        .to_str()
        .ok_or_else(|| SuiteError::System("expected a temporary folder in UTF-8".into()))?;
    let heights = LayerKind::Height(HeightLayer::new(Source::new(path)));
    let heights = Layer::new(LayerId::from(THINNED_ID), THINNED_ID, heights);
    let continued = |method| {
        let detail = Detail {
            method,
            ..Detail::default()
        };
        let kind = LayerKind::Detail(DetailLayer { detail });
        let layers = vec![
            heights.clone(),
            Layer::new(LayerId::from(DETAIL_ID), DETAIL_ID, kind),
        ];
        questions(planet, layers, Path::new("."))
    };
    Ok(vec![
        Way {
            name: "thinned, bilinear",
            questions: questions(planet, vec![heights.clone()], Path::new("."))?,
            layer: THINNED_ID,
        },
        Way {
            name: "continued, simplex",
            questions: continued(DetailMethod::Simplex)?,
            layer: DETAIL_ID,
        },
        Way {
            name: "continued, spectral",
            questions: continued(DetailMethod::Spectral)?,
            layer: DETAIL_ID,
        },
    ])
}

fn questions(
    planet: &PlanetSettings,
    layers: Vec<Layer>,
    folder: &Path,
) -> Result<Questions, SuiteError> {
    let project = Project {
        planet: planet.clone(),
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let folder: PathBuf = folder.to_owned();
    let engine = Engine::new(project, &folder, options);
    let mut engine = engine.map_err(|e| SuiteError::System(e.to_string()))?;
    engine.wait_for_sources();
    Ok(engine.questions())
}

/// A level whose samples are a quarter to a half of the truth's apart.
fn level(spacing_rad: f64) -> LevelKey {
    let rows = core::f64::consts::PI / (0.5 * spacing_rad) / 256.0;
    let n = libm::ceil(libm::log2(rows)).clamp(0.0, 23.0) as u8;
    LevelKey::new(n + 1, n)
}

fn square(level: LevelKey, place: MapPoint, side: usize) -> Grid {
    let middle = level.sample_from_map(place).floor().as_i64vec2();
    let side = side as i64;
    let rect = SampleRect::at(middle.x - side / 2, middle.y - side / 2, side, side);
    Grid::new(Arc::new(level.lattice()), rect)
}

fn samples(
    questions: &Questions,
    layer: &LayerId,
    grid: &Grid,
    cancel: &Cancel,
) -> Result<Vec<f32>, SuiteError> {
    let found = questions.layer_samples(layer, Stage::Source, grid, cancel);
    let found = found.map_err(|e| SuiteError::System(e.to_string()))?;
    let found = found.ok_or_else(|| SuiteError::System("expected heights, found none".into()))?;
    Ok(found.plane(0).to_vec())
}

/// A mean square, or decibels, at a distance.
struct Lag {
    lag_m: f64,
    db: f64,
}

/// Mean squares of second differences at distances that double.
fn energies(
    heights: &[f32],
    (level, planet, place, side): (LevelKey, &Planet, MapPoint, usize),
) -> Vec<Lag> {
    let step_m = level.step_rad() * planet.radius_m;
    let across_m = step_m.x * libm::sin(place.colat_rad);
    let surface = Surface::new(heights, side, step_m.y, |_| across_m);
    (1..8)
        .map(|octave| {
            let lag = 1_usize << octave;
            let energy = surface.energy(lag, 0..side, 0..side);
            Lag {
                lag_m: lag as f64 * step_m.y,
                db: energy.mean_m2().unwrap_or(f64::NAN),
            }
        })
        .collect()
}

/// Nanoseconds a sample, sources included.
fn times(
    context: &Context,
    ways: &[Way],
    level: LevelKey,
    place: MapPoint,
) -> Result<Vec<Spread>, SuiteError> {
    let side = context.pick(64, 256);
    let grid = square(level, place, side);
    // What is measured once for all tiles is made before.
    for way in ways {
        samples(&way.questions, &way.layer.into(), &grid, &context.cancel)?;
    }
    let mut works: Vec<Work> = ways
        .iter()
        .map(|way| {
            let (grid, cancel) = (&grid, &context.cancel);
            let layer = LayerId::from(way.layer);
            Work::new((side * side) as f64, move || {
                // Whether it works was seen before.
                let done = samples(&way.questions, &layer, black_box(grid), cancel);
                black_box(&done);
            })
        })
        .collect();
    in_turns(context, &mut works)
}

/// Root mean square of the decibels where the thinned heights know nothing: below their spacing.
fn error_db(lags: &[Lag], spacing_m: f64) -> f64 {
    let below: Vec<f64> = lags
        .iter()
        .filter(|lag| lag.lag_m < 1.01 * THINNED * spacing_m && lag.lag_m > 0.9 * spacing_m)
        .map(|lag| lag.db * lag.db)
        .collect();
    (below.iter().sum::<f64>() / below.len().max(1) as f64).sqrt()
}

fn spectra(ways: &[Way], off_db: &[Vec<Lag>]) -> Figure {
    let mut curves: Vec<Curve> = ways
        .iter()
        .zip(off_db)
        .map(|(way, lags)| {
            let points = lags.iter().map(|lag| {
                let name = format!("{:.0} m", lag.lag_m);
                Point::new(name, lag.lag_m, lag.db)
            });
            Curve {
                name: way.name.to_owned(),
                points: points.collect(),
                joined: true,
            }
        })
        .collect();
    let truth = off_db.first().into_iter().flatten();
    curves.push(Curve {
        name: "the truth".to_owned(),
        points: truth.map(|lag| Point::new("", lag.lag_m, 0.0)).collect(),
        joined: true,
    });
    let chart = Chart {
        x: Axis::log("distance", "m"),
        y: Axis::linear("roughness beside the truth", "dB"),
        curves,
        marks_front: false,
    };
    let caption = "Mean squares of second differences of heights at a distance, beside those of the heights before they were thinned to an \
                   eighth of their samples along each side. Left of eight times the truth's spacing the thinned heights know nothing; \
                   left of the spacing itself the truth is interpolated and no truth.";
    Figure::new(
        "spectra",
        "Roughness of thinned and continued heights",
        caption,
        Content::Chart(chart),
    )
}

fn trade(ways: &[Way], off_db: &[Vec<Lag>], times: &[Spread], spacing_m: f64) -> Figure {
    let points = ways
        .iter()
        .zip(off_db)
        .zip(times)
        .map(|((way, lags), time)| Point::timed(way.name, *time, error_db(lags, spacing_m)));
    let curve = Curve {
        name: "heights".to_owned(),
        points: points.collect(),
        joined: false,
    };
    let chart = Chart::trade(
        "ns per sample",
        "deviation of the roughness",
        "dB",
        vec![curve],
    );
    let caption = "Root mean square of the decibels at distances from the truth's spacing to eight times that. Times: one thread, sources \
                   included, what is measured once for all tiles made before.";
    Figure::new(
        "trade",
        "Deviation from the true roughness against time",
        caption,
        Content::Chart(chart),
    )
}

fn table(ways: &[Way], off_db: &[Vec<Lag>]) -> Figure {
    let head = core::iter::once("distance, m".to_owned());
    let head = head.chain(ways.iter().map(|way| format!("{}, dB", way.name)));
    let lags = off_db.first().map_or(0, Vec::len);
    let rows = (0..lags).map(|i| {
        let lag = off_db[0][i].lag_m.into();
        let each = off_db.iter().map(|lags| lags[i].db.into());
        core::iter::once(lag).chain(each).collect()
    });
    let table = Table {
        head: head.collect(),
        rows: rows.collect(),
    };
    Figure::new(
        "table",
        "Roughness beside the truth",
        "As in the picture.",
        Content::Table(table),
    )
}

fn summary(off_db: &[Vec<Lag>], truth: &Truth, planet: &Planet) -> String {
    let spacing_m = truth.spacing_rad * planet.radius_m;
    let text = crate::number::text;
    let errors: Vec<String> = off_db
        .iter()
        .map(|lags| text(error_db(lags, spacing_m)))
        .collect();
    format!(
        "Heights of `{}` ({} m apart) were thinned to an eighth. Below the thinned spacing their roughness is off by {} dB (root mean square); \
         continued by simplex noise by {} dB, by spectral synthesis by {} dB.",
        truth.layer.id.0,
        text(spacing_m),
        errors[0],
        errors[1],
        errors[2],
    )
}
