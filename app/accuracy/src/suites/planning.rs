//! Planning geometry: heights of elements on samples, smooth infills, volumes.

mod infill;
mod samples;
mod volumes;

use crate::{Context, Report, Suite, SuiteError};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "planning",
    sentence: "Planning elements: their heights on samples of any size, solvers of smooth infills, and volumes, each against closed forms.",
    run,
};

fn run(context: &Context) -> Result<Report, SuiteError> {
    let mut report = Report::default();
    for (done, part) in [samples::measure, infill::measure, volumes::measure]
        .into_iter()
        .enumerate()
    {
        context.step(done, 3)?;
        let Report { summary, figures } = part(context)?;
        report.summary.extend(summary);
        report.figures.extend(figures);
    }
    Ok(report)
}
