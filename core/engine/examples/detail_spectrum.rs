//! How rough heights are that were thinned out and continued again, beside what they were: comma-separated
//! values, and the time that detail takes.
//!
//! `cargo run --release -p relievo-engine --example detail_spectrum [FILE LON LAT CRS SPACING_M]`; without
//! arguments the sample project's heights of the Wasatch Front, 81.56 m apart.

#![allow(clippy::print_stdout, reason = "an example for the terminal")]

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use relievo_engine::graph::roughness::Surface;
use relievo_engine::planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_engine::project::{
    Detail, DetailLayer, DetailMethod, HeightLayer, Layer, LayerId, LayerKind, Project, Source,
};
use relievo_engine::raster::{Cancel, crs::Crs};
use relievo_engine::{Bake, Engine, EngineOptions, Output, Questions, Stage};

/// How many times fewer samples the thinned heights have along a side.
const THINNED: f64 = 8.0;

/// Samples along a side of the square that is compared.
const SIDE: usize = 1024;

type Failed = Box<dyn core::error::Error>;

fn main() -> Result<(), Failed> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let (file, place, crs, spacing_m) = match &arguments[..] {
        [file, lon, lat, crs, spacing_m] => {
            let place = MapPoint::from_degrees(lon.parse()?, lat.parse()?);
            (file.into(), place, crs.clone(), spacing_m.parse()?)
        }
        _ => (
            data.join("wasatch-dem.tif"),
            MapPoint::from_degrees(-111.55, 40.4),
            "EPSG:26912".to_owned(),
            81.56,
        ),
    };
    let folder = std::env::temp_dir().join("relievo-detail-spectrum");
    std::fs::create_dir_all(&folder)?;
    let thinned = folder.join("thinned.tif");
    let (lon_deg, lat_deg) = place.to_degrees();
    let (x, y) = Crs::parse(&crs)?.from_lonlat(lon_deg.to_radians(), lat_deg.to_radians())?;
    let half = 64.0 * THINNED * spacing_m;
    let original = questions(&file, None)?;
    let bake = Bake {
        output: Output::Height,
        bounds: [x - half, y - half, x + half, y + half],
        resolution: THINNED * spacing_m,
        crs,
    };
    original.bake(&bake, &thinned, 1, &mut |_| {}, &Cancel::default())?;
    // Samples a quarter to a half of the original's apart.
    let rows = core::f64::consts::PI * Planet::EARTH.radius_m / (0.5 * spacing_m) / 256.0;
    let n = libm::ceil(libm::log2(rows)) as u8;
    let level = LevelKey::new(n + 1, n);
    let truth = samples(&original, "heights", level, place)?;
    println!("# {}, {THINNED} times thinner", file.display());
    println!("lag_m,true_m2,thinned_db,simplex_db,spectral_db");
    let mut columns = Vec::new();
    let bare = questions(&thinned, None)?;
    columns.push(samples(&bare, "heights", level, place)?);
    for method in [DetailMethod::Simplex, DetailMethod::Spectral] {
        let detailed = questions(&thinned, Some(method))?;
        let start = Instant::now();
        columns.push(samples(&detailed, "detail", level, place)?);
        let first_s = start.elapsed().as_secs_f64();
        // The shortest of several: the machine has other work.
        let shortest = |layer: &str| -> Result<f64, Failed> {
            let mut shortest_s = f64::INFINITY;
            for _ in 0..7 {
                let start = Instant::now();
                samples(&detailed, layer, level, place)?;
                shortest_s = shortest_s.min(start.elapsed().as_secs_f64());
            }
            Ok(shortest_s)
        };
        let (made_s, source_s) = (shortest("detail")?, shortest("heights")?);
        let per = (made_s - source_s) / (SIDE * SIDE) as f64;
        println!(
            "# {method:?}: {:.0} ns per sample, {:.0} ms for what is measured once",
            per * 1e9,
            (first_s - made_s) * 1e3
        );
    }
    let step_m = level.step_rad() * Planet::EARTH.radius_m;
    for octave in 1..8 {
        let lag = 1_usize << octave;
        let energy = |heights: &[f32]| {
            let across_m = step_m.x * libm::sin(place.colat_rad);
            let surface = Surface::new(heights, SIDE, step_m.y, |_| across_m);
            let energy = surface.energy(lag, 0..SIDE, 0..SIDE);
            energy.mean_m2().unwrap_or(f64::NAN)
        };
        let whole_m2 = energy(&truth);
        let off = columns.iter().map(|heights| {
            let off_db = 10.0 * libm::log10(energy(heights) / whole_m2);
            format!("{off_db:.2}")
        });
        let off: Vec<String> = off.collect();
        println!(
            "{:.1},{whole_m2:.3},{}",
            lag as f64 * step_m.y,
            off.join(",")
        );
    }
    Ok(())
}

/// A project of one file, continued or not.
fn questions(file: &Path, method: Option<DetailMethod>) -> Result<Questions, Failed> {
    let path = file.to_str().ok_or("expected a path in UTF-8")?;
    let heights = LayerKind::Height(HeightLayer::new(Source::new(path)));
    let mut layers = vec![Layer::new(LayerId::from("heights"), "heights", heights)];
    if let Some(method) = method {
        let detail = Detail {
            method,
            ..Detail::default()
        };
        let kind = LayerKind::Detail(DetailLayer { detail });
        layers.push(Layer::new(LayerId::from("detail"), "detail", kind));
    }
    let project = Project {
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options)?;
    engine.wait_for_sources();
    Ok(engine.questions())
}

/// Heights of a layer on a square of a level about a place.
fn samples(
    questions: &Questions,
    layer: &str,
    level: LevelKey,
    place: MapPoint,
) -> Result<Vec<f32>, Failed> {
    let middle = level.sample_from_map(place).floor().as_i64vec2();
    let side = SIDE as i64;
    let rect = SampleRect::at(middle.x - side / 2, middle.y - side / 2, side, side);
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    let cancel = Cancel::default();
    let found = questions.layer_samples(&LayerId::from(layer), Stage::Source, &grid, &cancel)?;
    Ok(found.ok_or("expected heights")?.plane(0).to_vec())
}
