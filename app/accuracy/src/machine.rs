//! On what and by what a report was made.

use std::path::Path;
use std::process::Command;

/// Machine and program of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Name of the processor, `unknown processor` otherwise.
    pub processor: String,
    /// Threads that it runs at once, for this program.
    pub cores: usize,
    /// Name of the graphics adapter, if one was used.
    pub adapter: Option<String>,
    /// Operating system and architecture.
    pub system: String,
    /// The commit of the program, `unknown` otherwise; `with changes` where files differ from it.
    pub commit: String,
    /// Whether the program was built with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// This machine and program.
    pub fn here(adapter: Option<String>) -> Self {
        Self {
            processor: processor().unwrap_or_else(|| "unknown processor".to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            adapter,
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            commit: commit(),
            optimised: !cfg!(debug_assertions),
        }
    }

    /// All of it in a line, for captions.
    pub fn line(&self) -> String {
        let adapter = self
            .adapter
            .as_deref()
            .unwrap_or("no graphics adapter used");
        let build = if self.optimised {
            "release build"
        } else {
            "development build: times are not those of a release"
        };
        format!(
            "{} ({} threads), {adapter}, {}; relievo {} at commit {}, {build}",
            self.processor,
            self.cores,
            self.system,
            env!("CARGO_PKG_VERSION"),
            self.commit
        )
    }
}

/// The processor's name where the system tells it.
fn processor() -> Option<String> {
    if let Ok(told) = std::fs::read_to_string("/proc/cpuinfo") {
        let line = told.lines().find(|line| line.starts_with("model name"))?;
        return Some(line.split_once(':')?.1.trim().to_owned());
    }
    let told = answer(Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"]));
    told.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
}

/// The commit: what the packager says (`RELIEVO_COMMIT` while building), else what git says of the
/// sources where they still lie.
fn commit() -> String {
    if let Some(told) = option_env!("RELIEVO_COMMIT") {
        return told.to_owned();
    }
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    let git =
        |arguments: &[&str]| answer(Command::new("git").arg("-C").arg(sources).args(arguments));
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else {
        return "unknown".to_owned();
    };
    match git(&["status", "--porcelain", "--untracked-files=no"]) {
        Some(changes) if !changes.is_empty() => format!("{commit} with changes"),
        _ => commit,
    }
}

/// What a program prints, `None` where it fails.
fn answer(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_is_told_in_one_line_with_its_commit() {
        let line = Machine::here(Some("An adapter".to_owned())).line();
        assert_eq!(line.lines().count(), 1);
        assert!(line.contains("An adapter") && line.contains(" at commit "));
    }
}
