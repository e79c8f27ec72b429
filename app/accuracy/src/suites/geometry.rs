//! Where the clipmaps' ground is on the screen against where it should be.
//!
//! The errors of \[Liv07\] 6.1: the screen-space error (a height's difference, projected) and the
//! distortion (a Hausdorff distance); and how far heights swim when the focus moves by a texel.

mod distortion;
mod layouts;
mod livny;
pub(crate) mod paths;
mod swimming;

use core::cell::OnceCell;

use relievo_engine::analysis::Task;
use relievo_engine::{Engine, Layout, Offset, Reference};
use relievo_gpu::{Gpu, Quality, Still};

use super::colour::{frame_times, without};
use crate::scene::{failed, open, settings, standard, still, view};
use crate::{
    Cell, Chart, Content, Context, Curve, Figure, Point, Report, Spread, Suite, SuiteError, Table,
};
use distortion::Distortion;
use paths::Path;

/// The suite.
pub const SUITE: Suite = Suite {
    name: "geometry",
    sentence: "The ground on the screen against the reference: screen-space error, distortion and swimming, by mesh, size of a height sample, windows and width of their blend.",
    run,
};

/// One way to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Setting {
    /// Vertices around a ring and rows of quads in it.
    steps: [u32; 2],
    /// Smallest size of a height sample on the screen, pixels.
    texel_px: f64,
    /// Windows and blends of heights.
    layout: Layout,
}

impl Setting {
    /// What the window shows by default on a graphics processor.
    const STANDARD: Self = Self {
        steps: [512, 40],
        texel_px: 2.0,
        layout: Layout::STANDARD,
    };

    fn name(self) -> String {
        format!("{} × {}", self.steps[0], self.steps[1])
    }

    fn quality(self, gpu: &Gpu) -> Quality {
        Quality {
            layout: self.layout,
            azimuth_steps: self.steps[0],
            radial_steps: self.steps[1],
            // Colours are not measured.
            colour_window: 256,
            ..standard(gpu)
        }
    }
}

/// Errors over the pixels of one or several pictures, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Errors {
    mean: f64,
    p99: f64,
    max: f64,
}

impl Errors {
    /// Of values among which there may be no numbers (sky).
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1) as f64;
        let at = |share: f64| values.get((share * last).round() as usize).copied();
        Self {
            mean: values.iter().sum::<f64>() / values.len().max(1) as f64,
            p99: at(0.99).unwrap_or(0.0),
            max: at(1.0).unwrap_or(0.0),
        }
    }
}

/// A suite's tools.
pub(crate) struct Bench<'a> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) gpu: &'a Gpu,
    pub(crate) size_px: [u32; 2],
    /// The truth that has been looked at first: others share its samples of the ground.
    pub(crate) truth: OnceCell<Reference>,
}

impl Bench<'_> {
    /// A converged picture.
    pub(crate) fn draw(
        &self,
        engine: &mut Engine,
        camera: relievo_engine::planet::Camera,
        setting: Setting,
    ) -> Result<Still, SuiteError> {
        let quality = setting.quality(self.gpu);
        let mut view = view(engine, camera, self.size_px, &quality);
        view.height_texel_px = setting.texel_px;
        still(engine, self.gpu, view, quality, &self.context.cancel)
    }

    /// How far a picture's ground is from the truth, pixel by pixel.
    pub(crate) fn offsets(
        &self,
        engine: &Engine,
        still: &Still,
    ) -> Result<Vec<Offset>, SuiteError> {
        let shown = still.renderer.read_distances();
        let shown = shown.map_err(|error| SuiteError::System(error.to_string()))?;
        let settings = settings(self.size_px, self.context);
        let task = Task::quiet(&self.context.cancel);
        let truth = engine.reference(still.frame.camera);
        let first = self.truth.get_or_init(|| truth.clone());
        truth
            .sharing(first)
            .offsets(&settings, &shown, &task)
            .map_err(|error| failed(&error))
    }
}

/// One setting on one path, measured.
struct Measured {
    setting: Setting,
    errors: Errors,
    distortion: Distortion,
    triangles: f64,
    frame_ms: Spread,
}

fn settings_of(context: &Context) -> Vec<Setting> {
    let meshes: &[[u32; 2]] = if context.quick {
        &[[64, 8], [512, 40]]
    } else {
        &[[64, 8], [128, 16], [192, 20], [512, 40], [1024, 80]]
    };
    let texels: &[f64] = if context.quick {
        &[2.0]
    } else {
        &[1.0, 2.0, 4.0]
    };
    let of = |texel_px: &f64| {
        let texel_px = *texel_px;
        meshes.iter().map(move |steps| Setting {
            steps: *steps,
            texel_px,
            ..Setting::STANDARD
        })
    };
    texels.iter().flat_map(of).collect()
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let gpu = match context.gpu() {
        Ok(gpu) => gpu,
        Err(why) => return Ok(without("the clipmaps' ground", why)),
    };
    let bench = Bench {
        context,
        gpu,
        size_px: context.picture_px([64, 48], [640, 480]),
        truth: OnceCell::new(),
    };
    let mut engine = open(context)?;
    let paths = Path::find(&engine, context)?;
    let settings = settings_of(context);
    let mut report = Report::default();
    let mut rows = Vec::new();
    let mut meshes = Vec::new();
    let steps = paths.len() * (settings.len() + 2);
    for (index, path) in paths.iter().enumerate() {
        let done = index * settings.len();
        let measured = by_setting(&bench, &mut engine, path, &settings, [done, steps])?;
        report.figures.push(trade(path, &measured));
        report.summary.push(best(path, &measured));
        rows.extend(measured.iter().map(|m| row(path, m)));
        meshes.extend(livny::mesh_rows(path, &measured));
    }
    let mut done = paths.len() * settings.len();
    report.figures.push(table(rows));
    report.figures.push(livny::by_mesh(&bench, meshes));
    for path in paths.iter().take(context.pick(1, paths.len())) {
        context.step(done, steps)?;
        done += 1;
        let figures = layouts::figures(&bench, &mut engine, path)?;
        report.figures.extend(figures);
    }
    context.step(done, steps)?;
    report
        .figures
        .push(livny::by_angle(&bench, &mut engine, &paths)?);
    context.step(done + 1, steps)?;
    report
        .figures
        .push(swimming::figure(&bench, &mut engine, &paths)?);
    Ok(report)
}

/// All settings at a path's places.
fn by_setting(
    bench: &Bench,
    engine: &mut Engine,
    path: &Path,
    settings: &[Setting],
    [done, steps]: [usize; 2],
) -> Result<Vec<Measured>, SuiteError> {
    let cameras = path.cameras(-30.0);
    let (mut errors, mut distortions, mut last) = (Vec::new(), Vec::new(), Vec::new());
    for (i, setting) in settings.iter().enumerate() {
        bench.context.step(done + i, steps)?;
        let (mut all, mut distortion) = (Vec::new(), Distortion::default());
        let mut drawn = None;
        for camera in &cameras {
            let still = bench.draw(engine, *camera, *setting)?;
            all.extend(bench.offsets(engine, &still)?);
            distortion = distortion.max(Distortion::of(&still)?);
            drawn = Some(still);
        }
        errors.push(Errors::of(all.iter().map(|o| o.screen_px)));
        distortions.push(distortion);
        last.extend(drawn);
    }
    let times = frame_times(bench.context, bench.gpu, &mut last)?;
    let measured = settings
        .iter()
        .zip(errors)
        .zip(distortions)
        .zip(last.iter().zip(times));
    Ok(measured
        .map(
            |(((setting, errors), distortion), (still, frame_ms))| Measured {
                setting: *setting,
                errors,
                distortion,
                triangles: still.drawn.triangles as f64,
                frame_ms,
            },
        )
        .collect())
}

fn trade(path: &Path, measured: &[Measured]) -> Figure {
    let curves = Curve::grouped(measured.iter().map(|m| {
        let point = Point::timed(m.setting.name(), m.frame_ms, m.errors.mean);
        (format!("height sample {} px", m.setting.texel_px), point)
    }));
    let chart = Chart::trade("ms per frame", "mean screen-space error", "px", curves);
    Figure::new(
        format!("trade-{}", path.name),
        format!(
            "Screen-space error against frame time: {} ground",
            path.name
        ),
        "How far on the screen ground that a pixel shows is from the truth's ground at the same place of \
         the map ([Liv07] 6.1), looking 30° down; for vertices around a ring × rows in it.",
        Content::Chart(chart),
    )
}

fn best(path: &Path, measured: &[Measured]) -> String {
    let standard = measured.iter().find(|m| m.setting == Setting::STANDARD);
    standard.map_or_else(String::new, |m| {
        format!(
            "{} ground, default mesh of a graphics processor: {:.2} pixels of screen-space error on \
             average, one in a hundred pixels above {:.2}, at most {:.1}.",
            path.name, m.errors.mean, m.errors.p99, m.errors.max
        )
    })
}

fn row(path: &Path, m: &Measured) -> Vec<Cell> {
    vec![
        path.name.into(),
        m.setting.name().into(),
        m.setting.texel_px.into(),
        m.triangles.into(),
        m.frame_ms.median.into(),
        m.errors.mean.into(),
        m.errors.p99.into(),
        m.errors.max.into(),
        m.distortion.to_vertices_px.into(),
        m.distortion.to_pixels_px.into(),
        m.distortion.hausdorff_px().into(),
    ]
}

fn table(rows: Vec<Vec<Cell>>) -> Figure {
    let head = [
        "path",
        "mesh, around × rows",
        "height sample, px",
        "triangles drawn",
        "frame, ms",
        "mean error, px",
        "p99 error, px",
        "max error, px",
        "farthest pixel from a vertex, px",
        "farthest vertex from a pixel, px",
        "distortion, px",
    ];
    Figure::new(
        "table",
        "All settings",
        "Screen-space error over all pixels that show ground. Distortion: the Hausdorff distance of the pixels \
         that show ground and the mesh's vertices within the picture.",
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    )
}
