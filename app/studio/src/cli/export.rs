//! `relievo export`: elements, daylight lines and contours for other programs.

use std::path::PathBuf;
use std::sync::Arc;

use relievo_engine::export::contour_features;
use relievo_engine::project::Element;

use super::measure::contours::Which;
use super::measure::{check_extension, measured};
use super::scenario::Scenario;
use super::{Context, Failure, features, project, units};

/// Write elements, daylight lines or contours as GeoJSON or GeoPackage.
///
/// In longitude and latitude of WGS 84, cut at the antimeridian. Heights are metres above the datum:
/// vertices of elements have those that the element alone gives the ground.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    #[command(flatten)]
    scenario: Scenario,
    /// The file to write.
    #[arg(short = 'o', value_name = "OUT.geojson|OUT.gpkg")]
    file: PathBuf,
    /// What to write: outlines, axes and strokes of visible elements; the lines where their work ends;
    /// or contours.
    #[arg(long, value_enum, value_name = "WHAT")]
    what: What,
    /// For daylight lines: metres between the places that are looked at.
    #[arg(long, value_name = "M", default_value_t = 2.0, allow_hyphen_values = true, value_parser = units::positive)]
    spacing: f64,
    /// For contours: outer edges west, south, east, north in degrees; W > E crosses the antimeridian.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    bounds: Option<[f64; 4]>,
    /// For contours: metres between them.
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = units::positive)]
    interval: Option<f64>,
    /// For contours: a height in metres that has one.
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    base: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum What {
    Elements,
    Daylight,
    Contours,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    check_extension(&arguments.file, &features::EXTENSIONS)?;
    let contours = match (arguments.what, arguments.bounds, arguments.interval) {
        (What::Elements | What::Daylight, ..) => None,
        (What::Contours, Some(bounds), Some(interval)) => {
            let which = Which {
                bounds,
                interval,
                base: arguments.base,
            };
            Some(which.settings()?)
        }
        (What::Contours, ..) => {
            return Err(Failure::Input(
                "expected --bounds and --interval with --what contours, found only one or none"
                    .to_owned(),
            ));
        }
    };
    let engine = project::open_complete(&arguments.project, &arguments.scenario, context)?;
    project::check_output(&arguments.file, &[&arguments.project], &engine)?;
    let shown = engine.project();
    let mut elements: Vec<Arc<Element>> = shown.elements_in(shown.scenario.as_ref());
    elements.retain(|element| element.visible);
    let questions = engine.questions();
    let found = measured("exporting", &arguments.project, context, |task| {
        match (arguments.what, &contours) {
            (What::Contours, Some((area, settings))) => {
                Ok(contour_features(&questions.contours(area, settings, task)?))
            }
            (What::Daylight, _) => questions.daylight_features(&elements, arguments.spacing, task),
            (What::Elements | What::Contours, _) => questions.element_features(&elements, task),
        }
    })?;
    let table = match arguments.what {
        What::Elements => "elements",
        What::Daylight => "daylight",
        What::Contours => "contours",
    };
    features::deliver(
        &found,
        table,
        Some(&arguments.file),
        &arguments.project,
        &engine,
        context,
    )
}
