//! `relievo profile`: heights along a line.

use std::fmt::Write;
use std::path::PathBuf;

use relievo_engine::analysis::{Profile, ProfileSettings};
use relievo_engine::export::profile_features;
use relievo_engine::planet::MapPoint;

use super::super::scenario::Scenario;
use super::super::units::{self, Line};
use super::super::{Context, Failure, features, project};
use super::{deliver, measured, note_left_out};

/// Measure heights along a line.
///
/// A table: distance along the geodesics in metres, longitude and latitude in degrees, height in metres
/// above the datum, slope of the step that ends there in per cent. With -o a line of JSON sums it up:
/// lengths along the ellipsoid and the surface, climb and descent, steepest step.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// Points in degrees, longitude east, joined by geodesics.
    #[arg(long, value_name = "LON,LAT;LON,LAT...", allow_hyphen_values = true, value_parser = units::line)]
    line: Line,
    /// Metres between points. Default: the spacing of the data under each part of the line.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    spacing: Option<f64>,
    /// The table to write, or the line with its heights. Default: the table to standard output.
    #[arg(short = 'o', value_name = "OUT.csv|OUT.geojson|OUT.gpkg")]
    file: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(file) = &arguments.file {
        super::check_extension(file, &[&["csv"], &features::EXTENSIONS[..]].concat())?;
    }
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    let line: Vec<MapPoint> = arguments
        .line
        .0
        .iter()
        .map(|p| MapPoint::from_degrees(p.lon_deg, p.lat_deg))
        .collect();
    let settings = ProfileSettings {
        spacing_m: arguments.spacing,
        ..ProfileSettings::default()
    };
    let found = measured("profile", &arguments.project, context, |task| {
        engine.questions().profile(&line, &settings, task)
    })?;
    note_left_out(&engine, context);
    let is_table = |file: &PathBuf| {
        file.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("csv"))
    };
    let (read, file) = (&arguments.project, arguments.file.as_ref());
    if file.is_none_or(is_table) {
        deliver(csv(&found).as_bytes(), file, read, &engine, context)?;
    } else {
        let line = profile_features(&found);
        features::deliver(&line, "profile", file, read, &engine, context)?;
    }
    if arguments.file.is_some() {
        writeln!(context.out, "{}", summary(&found))?;
    }
    Ok(())
}

/// The table of a profile; fields without a value are empty.
fn csv(profile: &Profile) -> String {
    let mut table = String::from("distance_m,lon_deg,lat_deg,height_m,slope_percent\n");
    let number = |value: f64, digits: usize| {
        if value.is_finite() {
            format!("{value:.digits$}")
        } else {
            String::new()
        }
    };
    for point in &profile.points {
        let (lon_deg, lat_deg) = point.place.to_degrees();
        // Writing to a string never fails.
        let _always = writeln!(
            table,
            "{:.3},{lon_deg:.9},{lat_deg:.9},{},{}",
            point.distance_m,
            number(point.height_m, 3),
            number(100.0 * point.slope, 3)
        );
    }
    table
}

fn summary(profile: &Profile) -> serde_json::Value {
    serde_json::json!({
        "points": profile.points.len(),
        "length_m": profile.length_m,
        "surface_length_m": profile.surface_length_m,
        "climb_m": profile.climb_m,
        "descent_m": profile.descent_m,
        "steepest_percent": 100.0 * profile.steepest,
        "lowest_m": profile.range_m.map(|(low, _)| low),
        "highest_m": profile.range_m.map(|(_, high)| high),
    })
}
