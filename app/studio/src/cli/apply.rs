//! `relievo apply`: the edits that the window makes, from a file.

use std::path::PathBuf;

use relievo_engine::project::{Edit, Replace, read_text};

use super::{Context, Failure, project};

/// Apply edits to a project and save the result.
///
/// They are the same edits that the window makes. All of them take effect, or none and nothing is
/// saved.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project to start from; it stays as it is unless it is also the output.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    /// A JSON array of edits, as `relievo schema` describes it under `$defs/edits`.
    #[arg(value_name = "EDITS.json")]
    edits: PathBuf,
    /// Where to save the edited project; an existing file is replaced.
    #[arg(short, long, value_name = "OUT.relievo")]
    output: PathBuf,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let text = read_text(&arguments.edits)
        .map_err(|e| Failure::Input(e.to_string().replacen("the project", "the edits", 1)))?;
    let edits = Edit::list_from_json(&text, &arguments.edits).map_err(Failure::input)?;
    let mut engine = project::open(&arguments.project, context)?;
    for (index, edit) in edits.into_iter().enumerate() {
        engine
            .apply(edit)
            .map_err(|e| Failure::Input(format!("edit {index}: {e}: {:?}", arguments.edits)))?;
    }
    if context.cancel.is_cancelled() {
        return Err(Failure::Cancelled);
    }
    project::check_output(&arguments.output, &[&arguments.edits], &engine)?;
    let output = project::absolute(&arguments.output)?;
    engine
        .save(&output, Replace::Always)
        .map_err(Failure::system)?;
    Ok(())
}
