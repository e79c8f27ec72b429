//! `relievo flood`: still water at a level.

use std::path::PathBuf;

use relievo_engine::analysis::FloodSettings;
use relievo_engine::export::{flood_features, write_flood};
use relievo_engine::planet::MapPoint;
use serde_json::json;

use super::super::scenario::Scenario;
use super::super::units::{self, Place};
use super::super::{Context, Failure, features, project};
use super::{measured, note_left_out, unwritten};

/// Ends of the names of rasters.
const RASTERS: [&str; 3] = ["tif", "tiff", "png"];

/// Flood the ground around a place with still water.
///
/// Water stands at a level and covers what lies below it and is joined to the place. Prints area, volume,
/// greatest depth and length of the shore as JSON. With -o the water is written: its area with its islands, a
/// GeoTIFF of its depth, or a picture with a world file (.pgw) and its system (.prj).
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// A place under water, in degrees, longitude east.
    #[arg(long, value_name = "LON,LAT", allow_hyphen_values = true, value_parser = units::place)]
    at: Place,
    /// Height of the water in metres above the datum.
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    level: f64,
    /// The area, raster or picture to write.
    #[arg(short = 'o', value_name = "OUT.geojson|OUT.gpkg|OUT.tif|OUT.png")]
    file: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(file) = &arguments.file {
        super::check_extension(file, &[&RASTERS, &features::EXTENSIONS[..]].concat())?;
    }
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    let seed = MapPoint::from_degrees(arguments.at.lon_deg, arguments.at.lat_deg);
    let settings = FloodSettings::to(arguments.level);
    let found = measured("flooding", &arguments.project, context, |task| {
        engine.questions().flood(seed, &settings, task)
    })?;
    note_left_out(&engine, context);
    if let Some(file) = &arguments.file {
        let is_raster = |e: &std::ffi::OsStr| RASTERS.iter().any(|r| e.eq_ignore_ascii_case(r));
        if file.extension().is_some_and(is_raster) {
            project::check_output(file, &[&arguments.project], &engine)?;
            let planet = engine.project().planet.body.figure();
            write_flood(&found, &planet, file, context.cancel).map_err(unwritten)?;
        } else {
            let water = flood_features(&found);
            features::deliver(
                &water,
                "flood",
                Some(file),
                &arguments.project,
                &engine,
                context,
            )?;
        }
    }
    let line = json!({
        "level_m": found.level_m,
        "area_m2": found.area_m2,
        "volume_m3": found.volume_m3,
        "deepest_m": found.deepest_m,
        "shore_m": found.shore_m,
        "spacing_m": found.spacing_m,
    });
    writeln!(context.out, "{line}")?;
    Ok(())
}
