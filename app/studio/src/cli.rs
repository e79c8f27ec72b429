//! The command line: what is asked, by whom it is done, and how it ends.
//!
//! Invariant: results go to the first writer, one line about what went wrong to the second, and
//! nothing here panics, whatever the arguments and files hold.

mod apply;
mod bake;
mod balance;
mod cache;
mod check;
mod compare;
mod export;
mod features;
mod info;
mod matching;
mod measure;
mod new;
mod progress;
mod project;
mod render;
#[cfg(feature = "report")]
mod report;
mod sample;
mod scenario;
mod schema;
mod units;

pub use cache::Cache;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Parser, Subcommand};
use relievo_engine::raster::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// Exit code of success.
pub const SUCCESS: u8 = 0;
/// Exit code when the system fails: no adapter, no space, no permission.
pub const FAILURE: u8 = 1;
/// Exit code of bad input.
pub const BAD_INPUT: u8 = 2;
/// Exit code after Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// A studio for editing terrain and planning on it, on a whole planet.
///
/// Angles are in degrees, lengths in metres, longitudes east. Without a command the studio's window
/// opens.
#[derive(Debug, Parser)]
#[command(name = "relievo", version, max_term_width = 100)]
struct Arguments {
    /// The project to open in the studio; without one an empty Earth is shown.
    project: Option<PathBuf>,
    /// Threads that make tiles, 1 to 1024. Default: all cores but one.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    cache: cache::Arguments,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Arguments),
    Bake(bake::Arguments),
    Sample(sample::Arguments),
    Info(info::Arguments),
    Check(check::Arguments),
    New(new::Arguments),
    Apply(apply::Arguments),
    Compare(compare::Arguments),
    Match(matching::Arguments),
    Balance(balance::Arguments),
    Export(export::Arguments),
    Profile(measure::profile::Arguments),
    Contours(measure::contours::Arguments),
    Viewshed(measure::viewshed::Arguments),
    Flood(measure::flood::Arguments),
    #[cfg(feature = "report")]
    Report(report::Arguments),
    Schema(schema::Arguments),
}

/// What a command works with besides its arguments.
pub(crate) struct Context<'a> {
    /// Where results go.
    out: &'a mut dyn Write,
    /// Asks to stop.
    cancel: &'a Cancel,
    /// Threads that make tiles.
    threads: Option<usize>,
    /// What is kept from run to run.
    cache: Cache,
    /// What users should know although the command went on.
    notes: Vec<String>,
}

impl Context<'_> {
    /// Tells something that users should know although the command goes on, in one line.
    pub(crate) fn note(&mut self, text: String) {
        self.notes.push(text);
    }
}

/// How a command ended other than well.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The user's input: one line that names the file, what was expected and what was found.
    Input(String),
    /// The system.
    System(String),
    /// Somebody asked to stop.
    Cancelled,
    /// The reader of the results is gone, which is its good right.
    NoReader,
}

impl Failure {
    /// Bad input, told by an error.
    pub(crate) fn input(error: impl core::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    /// A failure of the system, told by an error.
    pub(crate) fn system(error: impl core::fmt::Display) -> Self {
        Self::System(error.to_string())
    }
}

impl From<io::Error> for Failure {
    /// Of writing results.
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::NoReader
        } else {
            Self::System(format!("cannot write the result: {error}"))
        }
    }
}

/// Runs the program: `arguments` with the program's name first, results to `out`, what went wrong to
/// `err`. Returns the exit code: 0 on success, 1 when the system fails, 2 on bad input, 130 when
/// `cancel` was asked for.
pub fn run(
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    out: &mut dyn Write,
    err: &mut dyn Write,
    cancel: &Cancel,
) -> u8 {
    let result = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => dispatch(arguments, out, err, cancel),
        Err(error) if error.use_stderr() => Err(Failure::Input(usage_line(&error))),
        Err(help) => write!(out, "{}", help.render()).map_err(Failure::from),
    };
    let result = result.and_then(|()| out.flush().map_err(Failure::from));
    let (code, text) = match result {
        Ok(()) | Err(Failure::NoReader) => return SUCCESS,
        Err(Failure::Input(text)) => (BAD_INPUT, text),
        Err(Failure::System(text)) => (FAILURE, text),
        Err(Failure::Cancelled) => (INTERRUPTED, "interrupted; nothing was written".to_owned()),
    };
    // Where not even this can be told, the exit code says it.
    let _told = writeln!(err, "relievo: {}", one_line(&text));
    code
}

fn dispatch(
    arguments: Arguments,
    out: &mut dyn Write,
    err: &mut dyn Write,
    cancel: &Cancel,
) -> Result<(), Failure> {
    let threads = arguments.threads.map(usize::from);
    let mut context = Context {
        out,
        cancel,
        threads,
        cache: arguments.cache.decide(),
        notes: Vec::new(),
    };
    let result = carry_out(arguments.project, arguments.command, &mut context);
    for note in &context.notes {
        // A line that cannot be told is no reason to fail.
        let _told = writeln!(err, "relievo: {}", one_line(note));
    }
    result
}

fn carry_out(
    project: Option<PathBuf>,
    command: Option<Command>,
    context: &mut Context,
) -> Result<(), Failure> {
    match (project, command) {
        (Some(project), Some(_)) => Err(Failure::Input(format!(
            "expected a project or a command, found both: {}",
            project.display()
        ))),
        (project, None) => open_window(project, context),
        (None, Some(Command::Render(a))) => render::run(&a, context),
        (None, Some(Command::Bake(a))) => bake::run(&a, context),
        (None, Some(Command::Sample(a))) => sample::run(&a, context),
        (None, Some(Command::Info(a))) => info::run(&a, context),
        (None, Some(Command::Check(a))) => check::run(&a, context),
        (None, Some(Command::New(a))) => new::run(&a, context),
        (None, Some(Command::Apply(a))) => apply::run(&a, context),
        (None, Some(Command::Compare(a))) => compare::run(&a, context),
        (None, Some(Command::Match(a))) => matching::run(&a, context),
        (None, Some(Command::Balance(a))) => balance::run(&a, context),
        (None, Some(Command::Export(a))) => export::run(&a, context),
        (None, Some(Command::Profile(a))) => measure::profile::run(&a, context),
        (None, Some(Command::Contours(a))) => measure::contours::run(&a, context),
        (None, Some(Command::Viewshed(a))) => measure::viewshed::run(&a, context),
        (None, Some(Command::Flood(a))) => measure::flood::run(&a, context),
        #[cfg(feature = "report")]
        (None, Some(Command::Report(a))) => report::run(&a, context),
        (None, Some(Command::Schema(a))) => schema::run(&a, context),
    }
}

#[cfg(feature = "window")]
fn open_window(project: Option<PathBuf>, context: &Context) -> Result<(), Failure> {
    use crate::window::{OpenWindowError, open};
    let cache = context.cache.clone();
    open(project, context.threads, cache, context.cancel).map_err(|failed| match failed {
        OpenWindowError::Project(line) => Failure::Input(line),
        OpenWindowError::System(line) => Failure::System(line),
    })
}

#[cfg(not(feature = "window"))]
fn open_window(_project: Option<PathBuf>, _context: &Context) -> Result<(), Failure> {
    let line = "expected a command, found none: this program was built without the studio's window";
    Err(Failure::Input(line.to_owned()))
}

/// What is wrong with the arguments, in one line.
fn usage_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let wrong = text.split("\n\n").next().unwrap_or_default();
    let wrong = one_line(wrong.strip_prefix("error: ").unwrap_or(wrong));
    format!("{wrong}; `relievo help` tells what can be asked")
}

/// Lines joined by single spaces.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Sends diagnostics to standard error as `RELIEVO_LOG` says (`info`, `relievo_gpu=debug`); only
/// errors without it.
pub fn log_to_stderr() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("RELIEVO_LOG")
        .unwrap_or_else(|_unset_or_wrong| tracing_subscriber::EnvFilter::new("error"));
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr);
    // A program that has set one up before keeps it.
    let _kept = log.try_init();
}

/// A token that Ctrl-C sets; a second Ctrl-C ends the program at once.
pub fn cancel_on_interrupt() -> Cancel {
    let cancel = Cancel::default();
    let asked = cancel.clone();
    let watch = || -> io::Result<()> {
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        let wait = move || {
            for _ in signals.forever() {
                if asked.is_cancelled() {
                    std::process::exit(i32::from(INTERRUPTED));
                }
                asked.cancel();
            }
        };
        std::thread::Builder::new()
            .name("relievo-interrupt".to_owned())
            .spawn(wait)?;
        Ok(())
    };
    if let Err(error) = watch() {
        tracing::warn!("Ctrl-C will end the program without tidying up: {error}");
    }
    cancel
}
