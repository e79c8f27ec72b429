//! `relievo compare`: what differs between two scenarios, in volumes and areas, or between two layers, in
//! colours.

use std::path::PathBuf;

use relievo_engine::analysis::{MapBox, Version, VolumeSettings};
use relievo_engine::project::Project;

use super::matching::compare_layers;
use super::measure::{check_extension, deliver, measured, threads};
use super::scenario::Scenario;
use super::{Context, Failure, project, units};
use crate::report::{self, Format};

/// Measure what differs between two scenarios, or the colours of two layers.
///
/// Per element and in total: cut, fill and net volume, plan and surface area, highest cut and fill, mean
/// slope, each with its discretisation error. From A to B changes are made one after the other in the
/// order of B's elements; a row is what that element's step changes.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    /// The scenario before: its name or id, base, or ground for the base without elements.
    #[arg(long, value_name = "NAME", default_value = "base")]
    a: String,
    /// The scenario after, likewise.
    #[arg(long, value_name = "NAME", required_unless_present = "layers")]
    b: Option<String>,
    /// Instead of scenarios, print how far the colours of one layer are from another's (CIEDE2000) as both are
    /// shown: two names or ids.
    #[arg(long, value_name = "A,B", value_delimiter = ',', conflicts_with_all = ["b", "bounds", "file"])]
    layers: Option<Vec<String>>,
    /// Compare layers only inside these edges, in degrees. Default: wherever both are.
    #[arg(long, value_name = "W,S,E,N", requires = "layers", allow_hyphen_values = true, value_parser = units::bounds)]
    region: Option<[f64; 4]>,
    /// The report to write: a page with pictures, JSON or a table. Default: JSON to standard output.
    #[arg(short = 'o', value_name = "REPORT.html|REPORT.json|REPORT.csv")]
    file: Option<PathBuf>,
    /// Measure what lies inside these edges, in degrees, and nothing else: also layers that differ there.
    /// Default: the surroundings of elements that differ.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    bounds: Option<[f64; 4]>,
    /// Share of volumes and areas that their errors should not exceed.
    #[arg(long, value_name = "SHARE", default_value_t = 1e-3, allow_hyphen_values = true, value_parser = units::positive)]
    tolerance: f64,
    /// Samples that are evaluated at most for a step; what they leave open stands in the errors.
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = clap::value_parser!(u64).range(1024..=1 << 32))]
    samples: u64,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if let Some(layers) = &arguments.layers {
        let region = arguments.region.map(MapBox::from_degrees).transpose();
        let region = region.map_err(Failure::input)?;
        return compare_layers(&arguments.project, layers, region.as_ref(), context);
    }
    let kind = match &arguments.file {
        Some(file) => check_extension(file, &["html", "json", "csv"])?,
        None => "json".to_owned(),
    };
    let bounds = arguments.bounds.map(MapBox::from_degrees).transpose();
    let bounds = bounds.map_err(Failure::input)?;
    let engine = project::open_complete(&arguments.project, &Scenario::default(), context)?;
    if let Some(file) = &arguments.file {
        project::check_output(file, &[&arguments.project], &engine)?;
    }
    let b = arguments.b.as_deref().unwrap_or_default();
    let [a, b] = [arguments.a.as_str(), b].map(|name| version(engine.project(), name));
    let (a, b) = (a?, b?);
    let comparison = engine
        .comparison(&a, &b, bounds.as_ref())
        .map_err(|line| Failure::Input(format!("{line}: {:?}", arguments.project)))?;
    let settings = VolumeSettings {
        tolerance: arguments.tolerance,
        max_samples: arguments.samples,
        threads: threads(context),
        ..VolumeSettings::from_spacing(1e9)
    };
    let report = measured("comparing", &arguments.project, context, |task| {
        comparison.measure(&settings, task)
    })?;
    let named = Format::ALL.into_iter().find(|(_, name)| *name == kind);
    let format = named.map_or(Format::Json, |(format, _)| format);
    let title = arguments.project.file_stem().unwrap_or_default();
    let text = measured("pictures", &arguments.project, context, |task| {
        report::text(format, &title.to_string_lossy(), &comparison, &report, task)
    })?;
    deliver(
        text.as_bytes(),
        arguments.file.as_ref(),
        &arguments.project,
        &engine,
        context,
    )
}

/// The version that is called so.
pub(super) fn version(project: &Project, name: &str) -> Result<Version, Failure> {
    Version::called(project, name).ok_or_else(|| {
        let known: Vec<&str> = project.scenarios.iter().map(|s| s.name.as_str()).collect();
        Failure::Input(format!(
            "expected base, ground or a scenario ({}), found {name:?}",
            if known.is_empty() {
                "there is none".to_owned()
            } else {
                known.join(", ")
            }
        ))
    })
}
