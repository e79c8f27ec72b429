//! `relievo sample`: what a project has at places.

use std::path::PathBuf;

use relievo_engine::graph::RenderError;
use relievo_engine::planet::MapPoint;

use super::scenario::Scenario;
use super::units::{self, Place};
use super::{Context, Failure, project};

/// Print height and colour at places: one JSON object a line.
///
/// Evaluated at the data's own resolution, not from a picture: height_m in metres above the datum
/// without exaggeration, colour as 8-bit sRGB with alpha, slope_deg in degrees, and what made them.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// A place in degrees, longitude east; may be repeated.
    #[arg(long, required = true, value_name = "LON,LAT", allow_hyphen_values = true, value_parser = units::place)]
    at: Vec<Place>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    let questions = engine.questions();
    for place in &arguments.at {
        let point = MapPoint::from_degrees(place.lon_deg, place.lat_deg);
        let answer = questions
            .place(point, context.cancel)
            .map_err(|error| match error {
                RenderError::Cancelled => Failure::Cancelled,
                error @ (RenderError::Read(_) | RenderError::Node { .. }) => Failure::input(error),
            })?;
        let line = serde_json::to_string(&answer).map_err(Failure::system)?;
        writeln!(context.out, "{line}")?;
    }
    Ok(())
}
