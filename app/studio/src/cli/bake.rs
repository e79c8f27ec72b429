//! `relievo bake`: a region of a project as a raster file.

use std::path::PathBuf;

use relievo_engine::graph::RenderError;
use relievo_engine::raster::write::WriteError;
use relievo_engine::{Bake, BakeError, Output};

use super::progress::Progress;
use super::scenario::Scenario;
use super::{Context, Failure, compare, project, units};

/// Write a region of a project to a raster file.
///
/// GeoTIFFs (.tif) are Cloud Optimised and of any size; one that was stopped goes on with the same
/// command, from the finished tiles in OUT.tif.part. OpenEXR files (.exr) are tiled and of any size:
/// heights as 32-bit floats, colours as linear, premultiplied 16-bit floats. PNGs hold up to 268
/// million samples, heights in them are 16-bit grey.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// The file to write: .tif, .exr or .png.
    #[arg(short = 'o', value_name = "OUT.tif|OUT.exr|OUT.png")]
    file: PathBuf,
    /// What to write: heights in metres, colours as RGBA, normals as east, north and up, or by how many
    /// metres --b is higher than --a (.tif).
    #[arg(long, value_enum, value_name = "KIND")]
    output: Kind,
    /// Outer edges west, south, east, north in units of --crs; in degrees W > E crosses the
    /// antimeridian.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    bounds: [f64; 4],
    /// Size of a sample in units of --crs.
    #[arg(long, value_name = "R", allow_hyphen_values = true, value_parser = units::positive)]
    resolution: f64,
    /// The coordinate system of bounds, resolution and file: EPSG:n, ESRI:n or a proj string.
    #[arg(long, value_name = "EPSG:N", default_value = "EPSG:4326")]
    crs: String,
    /// Leave out detail that is synthesised beyond the data's own resolution: heights and colours as the
    /// files have them.
    #[arg(long)]
    without_detail: bool,
    /// For differences the scenario before: its name or id, base, or ground for no elements.
    #[arg(long, value_name = "NAME", default_value = "base")]
    a: String,
    /// For differences the scenario after, likewise.
    #[arg(long, value_name = "NAME", required_if_eq("output", "difference"))]
    b: Option<String>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Kind {
    Height,
    Colour,
    Normal,
    Difference,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    project::check_output(&arguments.file, &[&arguments.project], &engine)?;
    let bake = Bake {
        output: match arguments.output {
            Kind::Height | Kind::Difference => Output::Height,
            Kind::Colour => Output::Colour,
            Kind::Normal => Output::Normal,
        },
        bounds: arguments.bounds,
        resolution: arguments.resolution,
        crs: arguments.crs.clone(),
    };
    let threads = context
        .threads
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(2, usize::from));
    let progress = Progress::new("baking");
    let told = &mut |share: f64| progress.set(share);
    let result = if let (Kind::Difference, Some(b)) = (arguments.output, &arguments.b) {
        let [a, b] = [&arguments.a, b].map(|name| compare::version(engine.project(), name));
        let comparison = engine.comparison(&a?, &b?, None).map_err(Failure::Input)?;
        comparison.bake_difference(&bake, &arguments.file, threads, told, context.cancel)
    } else {
        let mut questions = engine.questions();
        if arguments.without_detail {
            questions = questions.without_detail();
        }
        questions.bake(&bake, &arguments.file, threads, told, context.cancel)
    };
    match result {
        Ok(()) => Ok(()),
        Err(
            BakeError::Render(RenderError::Cancelled) | BakeError::Write(WriteError::Cancelled),
        ) => Err(Failure::Cancelled),
        Err(_) if context.cancel.is_cancelled() => Err(Failure::Cancelled),
        Err(error @ BakeError::Write(WriteError::Io { .. })) => Err(Failure::system(error)),
        Err(error) => Err(Failure::Input(format!("{error}: {:?}", arguments.project))),
    }
}
