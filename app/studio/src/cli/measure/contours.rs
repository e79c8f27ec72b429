//! `relievo contours`: lines of equal height.

use std::path::PathBuf;

use relievo_engine::analysis::{ContourSettings, MapBox};
use relievo_engine::export::contour_features;

use super::super::scenario::Scenario;
use super::super::{Context, Failure, features, project, units};
use super::{measured, note_left_out};

/// Write contours of a region as GeoJSON or GeoPackage.
///
/// Drawn between the samples of the data's own resolution. Each line has its height, height_m and closed;
/// higher ground lies to its left.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    #[command(flatten)]
    which: Which,
    /// The file to write. Default: GeoJSON to standard output.
    #[arg(short = 'o', value_name = "OUT.geojson|OUT.gpkg")]
    file: Option<PathBuf>,
}

/// Which contours.
#[derive(Debug, clap::Args)]
pub(crate) struct Which {
    /// Outer edges of the contours west, south, east, north in degrees; W > E crosses the antimeridian.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    pub(crate) bounds: [f64; 4],
    /// Metres between contours.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    pub(crate) interval: f64,
    /// A height in metres that has a contour.
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    pub(crate) base: f64,
}

impl Which {
    pub(crate) fn settings(&self) -> Result<(MapBox, ContourSettings), Failure> {
        let area = MapBox::from_degrees(self.bounds).map_err(Failure::input)?;
        let settings = ContourSettings {
            base_m: self.base,
            ..ContourSettings::every(self.interval)
        };
        Ok((area, settings))
    }
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(file) = &arguments.file {
        super::check_extension(file, &features::EXTENSIONS)?;
    }
    let (area, settings) = arguments.which.settings()?;
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    let lines = measured("contours", &arguments.project, context, |task| {
        engine.questions().contours(&area, &settings, task)
    })?;
    note_left_out(&engine, context);
    features::deliver(
        &contour_features(&lines),
        "contours",
        arguments.file.as_ref(),
        &arguments.project,
        &engine,
        context,
    )
}
