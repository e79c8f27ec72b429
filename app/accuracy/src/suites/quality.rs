//! What each setting of quality costs and how far what it shows is off on the screen: the front from
//! which the studio chooses.

mod pixels;

use core::cell::OnceCell;

use relievo_engine::Engine;
use relievo_gpu::quality::front::COLUMNS;
use relievo_gpu::{FrontPoint, Gpu, Quality, Setting, Still};

use super::colour::{frame_times, without};
use super::geometry::Bench;
use super::geometry::paths::Path;
use crate::scene::{open, standard, still, view};
use crate::{
    Cell, Chart, Content, Context, Curve, Figure, Point, Report, Suite, SuiteError, Table,
};
use pixels::Pixels;

/// The suite.
pub const SUITE: Suite = Suite {
    name: "quality",
    sentence: "Settings of quality, by what they cost and how far what they show is off on the screen: the front from which the studio chooses.",
    run,
};

/// Angle of view, degrees: as \[Liv07\] has most.
const PITCH_DEG: f64 = -30.0;

/// What a mesh is timed with, and a filter on.
const BASE: Setting = Setting {
    azimuth_steps: 192,
    radial_steps: 20,
    height_texel_px: 2.0,
    colour_texel_px: 1.0,
    max_taps: 8,
};

/// Neighbours on the written front differ by so much in error and in cost at least.
const STEP: f64 = 1.08;

/// Meshes with sizes of height samples: everything that decides where ground is.
fn meshes(context: &Context) -> Vec<Setting> {
    let steps: &[[u32; 2]] = if context.quick {
        &[[64, 8], [192, 20], [512, 40]]
    } else {
        &[
            [64, 8],
            [96, 12],
            [128, 16],
            [192, 20],
            [256, 24],
            [384, 32],
            [512, 40],
            [768, 60],
            [1024, 80],
        ]
    };
    let texels: &[f64] = context.pick(&[2.0], &[2.0, 4.0]);
    let pairs = steps
        .iter()
        .flat_map(|steps| texels.iter().map(move |texel_px| (*steps, *texel_px)));
    pairs
        .map(|([azimuth_steps, radial_steps], height_texel_px)| Setting {
            azimuth_steps,
            radial_steps,
            height_texel_px,
            ..BASE
        })
        .collect()
}

/// Taps with sizes of colour samples: everything that decides how sharp colours are.
fn filters(context: &Context) -> Vec<Setting> {
    let taps: &[u32] = context.pick(&[1, 8], &[1, 2, 4, 8, 16]);
    let texels: &[f64] = context.pick(&[1.0], &[1.0, 2.0, 4.0]);
    let pairs = taps
        .iter()
        .flat_map(|taps| texels.iter().map(move |texel_px| (*taps, *texel_px)));
    pairs
        .map(|(max_taps, colour_texel_px)| Setting {
            max_taps,
            colour_texel_px,
            ..BASE
        })
        .collect()
}

/// A mesh with a filter.
fn both(mesh: Setting, filter: Setting) -> Setting {
    Setting {
        colour_texel_px: filter.colour_texel_px,
        max_taps: filter.max_taps,
        ..mesh
    }
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let gpu = match context.gpu() {
        Ok(gpu) => gpu,
        Err(why) => return Ok(without("settings of quality", why)),
    };
    // As high as a window, since the mesh divides angles; narrow, since each pixel takes a ray.
    let bench = Bench {
        context,
        gpu,
        size_px: context.pick([24, 72], [48, 720]),
        truth: OnceCell::new(),
    };
    let mut engine = open(context)?;
    let paths = Path::find(&engine, context)?;
    let (meshes, filters) = (meshes(context), filters(context));
    let steps = meshes.len() * (paths.len() + 1) + filters.len();
    let mut errors_px = vec![0.0_f64; meshes.len() * filters.len()];
    for (p, path) in paths.iter().enumerate() {
        for (m, mesh) in meshes.iter().enumerate() {
            context.step(p * meshes.len() + m, steps)?;
            let mut pixels = Pixels::default();
            for camera in path.cameras(PITCH_DEG).into_iter().take(PLACES) {
                let drawn = draw(&bench, &mut engine, camera, mesh, bench.size_px)?;
                pixels.add(&drawn, &bench.offsets(&engine, &drawn)?)?;
            }
            for (f, filter) in filters.iter().enumerate() {
                let error_px = &mut errors_px[m * filters.len() + f];
                *error_px = error_px.max(pixels.error_px(filter));
            }
        }
    }
    let done = meshes.len() * paths.len();
    let (mesh_ms, filter_ms, base_ms) = times(
        &bench,
        &mut engine,
        &paths,
        &meshes,
        &filters,
        [done, steps],
    )?;
    let mut measured = Vec::new();
    for (m, mesh) in meshes.iter().enumerate() {
        for (f, filter) in filters.iter().enumerate() {
            measured.push(FrontPoint {
                setting: both(*mesh, *filter),
                error_px: errors_px[m * filters.len() + f],
                frame_ms: mesh_ms[m] + filter_ms[f] - base_ms,
            });
        }
    }
    Ok(report(&measured))
}

/// Places of a path that are looked from.
const PLACES: usize = 3;

fn draw(
    bench: &Bench,
    engine: &mut Engine,
    camera: relievo_engine::planet::Camera,
    setting: &Setting,
    size_px: [u32; 2],
) -> Result<Still, SuiteError> {
    let quality = setting.on(spent(bench));
    let mut view = view(engine, camera, size_px, &quality);
    view.height_texel_px = setting.height_texel_px;
    view.colour_texel_px = setting.colour_texel_px;
    still(engine, bench.gpu, view, quality, &bench.context.cancel)
}

/// The rest of a quality.
fn spent(bench: &Bench) -> Quality {
    let gpu: &Gpu = bench.gpu;
    Quality {
        colour_window: bench.context.pick(256, 1024),
        ..standard(gpu)
    }
}

/// Milliseconds a frame of all meshes with the base's filter, of all filters on the base's mesh, and of
/// the base itself.
fn times(
    bench: &Bench,
    engine: &mut Engine,
    paths: &[Path],
    meshes: &[Setting],
    filters: &[Setting],
    [done, steps]: [usize; 2],
) -> Result<(Vec<f64>, Vec<f64>, f64), SuiteError> {
    let cameras = paths.last().map(|path| path.cameras(PITCH_DEG));
    let Some(camera) = cameras.and_then(|all| all.first().copied()) else {
        return Err(SuiteError::Input("expected ground to look at".to_owned()));
    };
    let size_px = bench.context.pick([96, 72], [960, 720]);
    let mut stills = Vec::new();
    for (i, setting) in meshes.iter().chain(filters).chain([&BASE]).enumerate() {
        bench.context.step(done + i.min(steps - done - 1), steps)?;
        stills.push(draw(bench, engine, camera, setting, size_px)?);
    }
    let times = frame_times(bench.context, bench.gpu, &mut stills)?;
    let mut medians = times.into_iter().map(|time| time.median);
    let mesh_ms = medians.by_ref().take(meshes.len()).collect();
    let filter_ms = medians.by_ref().take(filters.len()).collect();
    let base_ms = medians.next().unwrap_or(0.0);
    Ok((mesh_ms, filter_ms, base_ms))
}

fn name(setting: &Setting) -> String {
    let Setting {
        azimuth_steps,
        radial_steps,
        height_texel_px,
        colour_texel_px,
        max_taps,
    } = setting;
    format!(
        "{azimuth_steps} × {radial_steps}, {max_taps} taps, samples of {height_texel_px} px (heights) and {colour_texel_px} px (colours)"
    )
}

/// Points that nothing beats and that differ, the cheapest first.
fn front(chart: &Chart, measured: &[FrontPoint]) -> Vec<FrontPoint> {
    let on: Vec<_> = chart
        .front()
        .into_iter()
        .map(|(_, p)| measured[p])
        .collect();
    let mut kept: Vec<FrontPoint> = Vec::new();
    // From the truest, so that it stays.
    for point in on.into_iter().rev().filter(|p| p.frame_ms > 0.0) {
        let differs = |last: &FrontPoint| {
            point.error_px >= last.error_px * STEP && point.frame_ms * STEP <= last.frame_ms
        };
        if kept.last().is_none_or(differs) {
            kept.push(point);
        }
    }
    kept.reverse();
    kept
}

fn report(measured: &[FrontPoint]) -> Report {
    let as_point = |p: &FrontPoint| Point::new(name(&p.setting), p.frame_ms, p.error_px);
    let curve = |name: &str, of: &[FrontPoint], joined| Curve {
        name: name.to_owned(),
        points: of.iter().map(as_point).collect(),
        joined,
    };
    let trade = |curves| Chart::trade("ms per frame", "error on the screen", "px", curves);
    let front = front(
        &trade(vec![curve("all settings", measured, false)]),
        measured,
    );
    // Each setting once.
    let is_offered = |p: &&FrontPoint| front.iter().any(|f| f.setting == p.setting);
    let others: Vec<FrontPoint> = measured
        .iter()
        .filter(|p| !is_offered(p))
        .copied()
        .collect();
    let chart = trade(vec![
        curve("other settings", &others, false),
        curve("offered by the studio", &front, true),
    ]);
    let caption = "Error: 9 in 10 pixels of ground have less, on flat or mountainous ground, whichever has \
        more, 1500 m up, looking 30° down, in pictures of 720 rows. A pixel's error is the distance on the \
        screen of its ground from the truth's ([Liv07] 6.1) plus (t − 1)/2, t = max(1, c·d₀/d, min(64, 1/sin γ)/n): \
        how much wider than a pixel colours are drawn that the clipmaps choose for n taps, colour samples of \
        c pixels at the nearest ground d₀, and ground d along the view, seen at an angle γ to the level. Time: of a \
        mesh plus of a filter, each measured with the other that of 192 × 20 and 8 taps.";
    let table = Table {
        head: COLUMNS.map(str::to_owned).to_vec(),
        rows: front.iter().map(row).collect(),
    };
    let summary = front.first().zip(front.last()).map(|(cheap, fine)| {
        format!(
            "{} settings are worth choosing: from {:.2} pixels of error in {:.1} ms a frame to {:.2} pixels in {:.1} ms.",
            front.len(), cheap.error_px, cheap.frame_ms, fine.error_px, fine.frame_ms
        )
    });
    Report {
        summary: summary.into_iter().collect(),
        figures: vec![
            Figure::new(
                "trade",
                "Error on the screen against frame time",
                caption,
                Content::Chart(chart),
            ),
            Figure::new(
                "front",
                "The front from which the studio chooses",
                caption,
                Content::Table(table),
            ),
        ],
    }
}

fn row(point: &FrontPoint) -> Vec<Cell> {
    let setting = &point.setting;
    vec![
        f64::from(setting.azimuth_steps).into(),
        f64::from(setting.radial_steps).into(),
        setting.height_texel_px.into(),
        setting.colour_texel_px.into(),
        f64::from(setting.max_taps).into(),
        point.error_px.into(),
        point.frame_ms.into(),
    ]
}
