//! `relievo schema`.

use relievo_engine::project::schema_text;

use super::{Context, Failure};

/// Print the JSON Schema of the project file.
///
/// `edits` under `$defs` describes what `relievo apply` takes.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {}

pub(crate) fn run(_arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    Ok(context.out.write_all(schema_text().as_bytes())?)
}
