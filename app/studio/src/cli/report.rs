//! `relievo report`: error against run time.

use std::path::PathBuf;

use relievo_accuracy::suites;
use relievo_accuracy::{DeviceWish, Machine, Suite, SuiteError, write};

use super::progress::Progress;
use super::{Context, Failure};

/// The word that stands for all suites.
const ALL: &str = "all";

/// Measure error against run time, and write it as a page with its figures.
///
/// Every approximation has a curve: what it costs, how far it is off, one point for each setting, and the
/// settings that nothing beats marked. The folder gets `index.html`, which needs nothing else, and for each
/// figure a table (CSV) and a drawing (SVG) or picture (PNG). Measure with a release build on a quiet machine.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// A project to measure on, where a suite takes one. Default: scenes of the suites' own.
    #[arg(value_name = "PROJECT")]
    project: Option<PathBuf>,
    /// What to measure; may be given several times.
    #[arg(long = "suite", value_name = "NAME", required = true, value_parser = suite_names())]
    suites: Vec<String>,
    /// The folder to write to, which is made if there is none; files of the same names are replaced.
    #[arg(short = 'o', value_name = "DIR")]
    folder: PathBuf,
    /// Measure fewer settings, less often: seconds instead of minutes, and times that say little.
    #[arg(long)]
    quick: bool,
}

/// Names with their sentences.
fn suite_names() -> clap::builder::PossibleValuesParser {
    use clap::builder::PossibleValue;
    let named = suites::ALL
        .iter()
        .map(|suite| PossibleValue::new(suite.name).help(suite.sentence));
    named
        .chain([PossibleValue::new(ALL).help("all of them")])
        .collect::<Vec<_>>()
        .into()
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let wanted: Vec<&Suite> = suites::ALL
        .iter()
        .filter(|suite| {
            let asked = |name: &String| name == suite.name || name == ALL;
            arguments.suites.iter().any(asked)
        })
        .collect();
    if arguments.folder.exists() && !arguments.folder.is_dir() {
        return Err(Failure::Input(format!(
            "expected a folder to write to, found a file: {:?}",
            arguments.folder
        )));
    }
    if let Some(project) = arguments.project.as_ref().filter(|p| !p.is_file()) {
        return Err(Failure::Input(format!(
            "expected a project file, found none: {project:?}"
        )));
    }
    let mut reports = Vec::new();
    let mut adapter = None;
    for suite in wanted {
        let progress = Progress::new(suite.name);
        let show = |share| progress.set(share);
        let mut measuring =
            relievo_accuracy::Context::new(arguments.quick, DeviceWish::IfAny, &show);
        measuring.threads = super::measure::threads(context);
        measuring.peers = true;
        measuring.project.clone_from(&arguments.project);
        measuring.cancel = context.cancel.clone();
        let report = (suite.run)(&measuring).map_err(|error| match error {
            SuiteError::Cancelled => Failure::Cancelled,
            SuiteError::Input(line) => Failure::Input(line),
            SuiteError::System(line) => Failure::System(line),
        })?;
        adapter = adapter.or_else(|| measuring.adapter());
        reports.push((suite, report));
    }
    let machine = Machine::here(adapter);
    let paths = write::to_folder(&arguments.folder, &reports, &machine).map_err(Failure::system)?;
    for path in paths.iter().take(1) {
        writeln!(context.out, "{}", path.display())?;
    }
    Ok(())
}
