//! Opening a project for a command: absolute, with every file open, refusing what is missing.

use std::path::{Path, PathBuf};
use std::time::Duration;

use relievo_engine::project::LayerId;
use relievo_engine::{Engine, OpenError, Severity, SourceState};

use super::cache::engine_options;
use super::progress::Progress;
use super::scenario::Scenario;
use super::{Context, Failure};
use crate::report;

/// The absolute form of a path, so that relative paths inside projects can be told from it.
pub(crate) fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path)
        .map_err(|e| Failure::Input(format!("expected a path, found {path:?}: {e}")))
}

/// An engine on a project file; its sources are still being opened.
pub(crate) fn open(path: &Path, context: &Context) -> Result<Engine, Failure> {
    let options = engine_options(context.threads, &context.cache);
    match Engine::open(&absolute(path)?, options) {
        Ok((engine, _stamp)) => Ok(engine),
        Err(error @ OpenError::Project(_)) => Err(Failure::input(error)),
        Err(error @ OpenError::Threads(_)) => Err(Failure::system(error)),
    }
}

/// Waits until every file is open or refused.
pub(crate) fn wait_for_sources(engine: &mut Engine, context: &Context) -> Result<(), Failure> {
    let progress = Progress::new("opening files");
    while engine.stats().opening > 0 {
        if context.cancel.is_cancelled() {
            return Err(Failure::Cancelled);
        }
        progress.set(opened(engine));
        engine.wait(Duration::from_millis(50));
    }
    engine.wait_for_sources();
    Ok(())
}

/// The share of all files that is open, 0 to 1.
fn opened(engine: &Engine) -> f64 {
    let layers = &engine.project().layers;
    let states = layers
        .iter()
        .filter_map(|l| engine.sources().state(&l.kind, engine.folder()));
    let shares: Vec<f64> = states
        .map(|state| match state {
            SourceState::Opening(share) => f64::from(share),
            SourceState::Open(_) | SourceState::Features(_) | SourceState::Failed(_) => 1.0,
        })
        .collect();
    shares.iter().sum::<f64>() / shares.len().max(1) as f64
}

/// An engine with every file open. A visible layer whose file cannot be used is bad input: results
/// would lack it without saying so.
pub(crate) fn open_complete(
    path: &Path,
    scenario: &Scenario,
    context: &Context,
) -> Result<Engine, Failure> {
    let mut engine = open(path, context)?;
    scenario.show(&mut engine)?;
    wait_for_sources(&mut engine, context)?;
    let project = engine.project();
    let layers = project.layers_in(project.scenario.as_ref());
    let shown = |id: &LayerId| {
        let layer = layers.iter().find(|l| l.id == *id);
        layer.is_none_or(|l| l.visible && l.opacity > 0.0)
    };
    let problem = engine
        .messages()
        .iter()
        .find(|m| m.severity == Severity::Error && m.layer.as_ref().is_none_or(shown));
    match problem {
        None => {}
        Some(message) => {
            let layer = message
                .layer
                .as_ref()
                .map(|id| format!("layer {:?}: ", id.0))
                .unwrap_or_default();
            return Err(Failure::Input(format!("{layer}{}", message.text)));
        }
    }
    drop(layers);
    Ok(engine)
}

/// Refuses to write where nothing can be written, and over what is read: `inputs`, and the files of
/// the project's layers, hidden ones too.
pub(crate) fn check_output(
    output: &Path,
    inputs: &[&Path],
    engine: &Engine,
) -> Result<(), Failure> {
    report::check_output(output, inputs, engine).map_err(Failure::Input)
}
