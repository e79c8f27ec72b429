//! What the measuring commands share: waiting, output, refusals.

pub(crate) mod contours;
pub(crate) mod flood;
pub(crate) mod profile;
pub(crate) mod viewshed;

use std::path::{Path, PathBuf};

use relievo_engine::Engine;
use relievo_engine::analysis::{AnalysisError, Task};
use relievo_engine::raster::write::WriteError;

use super::progress::Progress;
use super::{Context, Failure, project};
use crate::report;

/// Runs a measurement with a progress bar; `file` is named where it refuses.
pub(crate) fn measured<R>(
    name: &'static str,
    file: &Path,
    context: &Context,
    work: impl FnOnce(&Task) -> Result<R, AnalysisError>,
) -> Result<R, Failure> {
    let progress = Progress::new(name);
    let task = Task {
        cancel: context.cancel,
        progress: &|share| progress.set(share),
    };
    work(&task).map_err(|error| match error {
        AnalysisError::Cancelled => Failure::Cancelled,
        refused @ (AnalysisError::Refused(_) | AnalysisError::Ground(_)) => {
            Failure::Input(format!("{refused}: {file:?}"))
        }
    })
}

/// Notes what measurements leave out of the ground that pictures show.
pub(crate) fn note_left_out(engine: &Engine, context: &mut Context) {
    let sentence = engine.questions().left_out_of_measures();
    context.notes.extend(sentence.map(str::to_owned));
}

/// Threads to measure on.
pub(crate) fn threads(context: &Context) -> usize {
    context
        .threads
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(2, usize::from))
}

/// Writes a result to a file, beside its place first, or to standard output.
pub(crate) fn deliver(
    bytes: &[u8],
    file: Option<&PathBuf>,
    read: &Path,
    engine: &Engine,
    context: &mut Context,
) -> Result<(), Failure> {
    let Some(file) = file else {
        return Ok(context.out.write_all(bytes)?);
    };
    project::check_output(file, &[read], engine)?;
    if context.cancel.is_cancelled() {
        return Err(Failure::Cancelled);
    }
    report::write(file, bytes).map_err(Failure::System)
}

/// Ends of file names that a command writes.
pub(crate) fn check_extension(file: &Path, known: &[&str]) -> Result<String, Failure> {
    let extension = file
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase)
        .unwrap_or_default();
    if known.contains(&extension.as_str()) {
        return Ok(extension);
    }
    Err(Failure::Input(format!(
        "expected a name that ends in .{}, found {file:?}",
        known.join(" or .")
    )))
}

/// Why a raster was not written.
pub(crate) fn unwritten(error: WriteError) -> Failure {
    match error {
        WriteError::Cancelled => Failure::Cancelled,
        other @ (WriteError::Samples(_)
        | WriteError::Unsupported { .. }
        | WriteError::Io { .. }) => Failure::system(other),
    }
}
