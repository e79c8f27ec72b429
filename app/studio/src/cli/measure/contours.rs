//! `relievo contours`: lines of equal height.

use std::path::PathBuf;

use relievo_engine::analysis::{ContourSettings, MapBox};
use serde_json::json;

use super::super::scenario::Scenario;
use super::super::{Context, Failure, project, units};
use super::{deliver, geojson, measured};

/// Write contours of a region as GeoJSON.
///
/// Drawn between the samples of the data's own resolution. Each line has height_m and closed; higher
/// ground lies to its left.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// Outer edges west, south, east, north in degrees; W > E crosses the antimeridian.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    bounds: [f64; 4],
    /// Metres between contours.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    interval: f64,
    /// A height in metres that has a contour.
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    base: f64,
    /// The file to write. Default: standard output.
    #[arg(short = 'o', value_name = "OUT.geojson")]
    file: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(file) = &arguments.file {
        super::check_extension(file, &["geojson", "json"])?;
    }
    let area = MapBox::from_degrees(arguments.bounds).map_err(Failure::input)?;
    let settings = ContourSettings {
        base_m: arguments.base,
        ..ContourSettings::every(arguments.interval)
    };
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    let lines = measured("contours", &arguments.project, context, |task| {
        engine.questions().contours(&area, &settings, task)
    })?;
    let found = geojson::collection(
        &lines,
        |line| json!({ "height_m": line.height_m, "closed": line.closed }),
    );
    deliver(
        format!("{found}\n").as_bytes(),
        arguments.file.as_ref(),
        &arguments.project,
        &engine,
        context,
    )
}
