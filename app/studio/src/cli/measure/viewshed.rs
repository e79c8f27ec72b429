//! `relievo viewshed`: what can be seen from a place.

use std::path::PathBuf;

use relievo_engine::analysis::ViewshedSettings;
use relievo_engine::export::write_viewshed;
use relievo_engine::planet::MapPoint;
use serde_json::json;

use super::super::scenario::Scenario;
use super::super::units::{self, Place};
use super::super::{Context, Failure, project};
use super::{measured, note_left_out, threads, unwritten};

/// Show what can be seen from a place.
///
/// Every sample within the radius has a line of sight of its own over the ground at the data's
/// resolution, with the curvature of the planet and refraction. Prints areas as JSON. With -o it is written,
/// north up and the place in the middle, in metres around it: as a GeoTIFF with 1 where one sees and 0 where
/// not, or as a picture with a world file (.pgw) and its system (.prj), yellow what is seen, dark what is
/// hidden.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// Where the eye is, in degrees, longitude east.
    #[arg(long, value_name = "LON,LAT", allow_hyphen_values = true, value_parser = units::place)]
    at: Place,
    /// How far to look in metres.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    radius: f64,
    /// Metres of the eye above the ground.
    #[arg(
        long,
        value_name = "M",
        default_value_t = 1.7,
        allow_hyphen_values = true
    )]
    eye: f64,
    /// Metres above the ground of what should be seen.
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    target: f64,
    /// How much of the planet's curvature refraction takes away, -1 to 1.
    #[arg(
        long,
        value_name = "K",
        default_value_t = 0.13,
        allow_hyphen_values = true
    )]
    refraction: f64,
    /// Metres between samples. Default: the spacing of the data.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    spacing: Option<f64>,
    /// The raster or picture to write.
    #[arg(short = 'o', value_name = "OUT.tif|OUT.png")]
    file: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(file) = &arguments.file {
        super::check_extension(file, &["png", "tif", "tiff"])?;
    }
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    if let Some(file) = &arguments.file {
        project::check_output(file, &[&arguments.project], &engine)?;
    }
    let observer = MapPoint::from_degrees(arguments.at.lon_deg, arguments.at.lat_deg);
    let settings = ViewshedSettings {
        observer_height_m: arguments.eye,
        target_height_m: arguments.target,
        refraction: arguments.refraction,
        spacing_m: arguments.spacing,
        threads: threads(context),
        ..ViewshedSettings::within(arguments.radius)
    };
    let found = measured("viewshed", &arguments.project, context, |task| {
        engine.questions().viewshed(observer, &settings, task)
    })?;
    note_left_out(&engine, context);
    if let Some(file) = &arguments.file {
        write_viewshed(&found, file, context.cancel).map_err(unwritten)?;
    }
    let line = json!({
        "visible_m2": found.visible_m2,
        "area_m2": found.area_m2,
        "ground_m": found.ground_m,
        "spacing_m": found.spacing_m,
        "samples_across": found.side(),
    });
    writeln!(context.out, "{line}")?;
    Ok(())
}
