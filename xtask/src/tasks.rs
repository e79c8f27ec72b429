//! The tasks themselves: each is a short list of Cargo calls.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::packages::Display;
use crate::{bench, setup, sizes, summary};

/// Crates of `core/`, which are tested first and alone, without any GPU or window crate.
const CORE: [&str; 9] = [
    "relievo-planet",
    "relievo-raster",
    "relievo-earthwork",
    "relievo-vector",
    "relievo-graph",
    "relievo-tiles",
    "relievo-analysis",
    "relievo-project",
    "relievo-engine",
];

/// Crates whose tests open a graphics device.
const NEEDS_DEVICE: [&str; 2] = ["relievo-gpu", "relievo"];

/// Part of the path of every other test that opens one.
const ON_DEVICE: &str = "on_device";

/// Which program runs the tests.
#[derive(Clone, Copy)]
enum Runner {
    /// `cargo test`.
    Cargo,
    /// `cargo nextest`, where it is installed.
    Nextest,
}

/// Sets up what is missing and opens the studio, or renders the sample where there is no display.
pub(crate) fn studio(arguments: &[String]) -> Result<()> {
    let display = setup::display();
    setup::ensure(true, display)?;
    let sample = root()?.join("projects").join("earth.relievo");
    let picture = std::env::current_dir()
        .context("cannot name the current folder")?
        .join("earth.png");
    let mut cargo = cargo()?;
    cargo.args(["run", "--release", "--package", "relievo", "--"]);
    cargo.args(studio_arguments(display, arguments, &sample, &picture));
    if display == Display::None {
        eprintln!(
            "xtask: no display (neither WAYLAND_DISPLAY nor DISPLAY is set): rendering a picture instead"
        );
    }
    succeed(&mut cargo)?;
    if display == Display::None {
        eprintln!("xtask: the picture is {}", picture.display());
    }
    Ok(())
}

/// Arguments of the studio: a project among the user's replaces the sample; without a display the
/// project is rendered.
fn studio_arguments(
    display: Display,
    user: &[String],
    sample: &Path,
    picture: &Path,
) -> Vec<OsString> {
    let is_project = |argument: &&String| {
        Path::new(argument)
            .extension()
            .is_some_and(|e| e == "relievo")
    };
    let project = user
        .iter()
        .find(is_project)
        .map_or_else(|| sample.into(), OsString::from);
    let rest = user
        .iter()
        .filter(|argument| !is_project(argument))
        .map(OsString::from);
    let mut all: Vec<OsString> = Vec::new();
    if display == Display::None {
        all.extend(["render".into(), project, "-o".into(), picture.into()]);
    } else {
        all.push(project);
    }
    all.extend(rest);
    all
}

/// Sets up what is missing and runs all tests: `core` first and alone, then the rest, the
/// examples in the documentation included.
pub(crate) fn test(gpu: bool) -> Result<()> {
    let window = if gpu { Display::Virtual } else { Display::None };
    setup::ensure(gpu, window)?;
    let has_nextest = setup::runs("cargo", &["nextest", "--version"]);
    let runner = if has_nextest {
        Runner::Nextest
    } else {
        Runner::Cargo
    };
    let mut reports = Vec::new();
    let mut failed = Vec::new();
    for (name, arguments) in test_runs(runner, gpu) {
        eprintln!("xtask: {name}: cargo {}", arguments.join(" "));
        let outcome = summary::run(cargo()?.args(&arguments))?;
        if !outcome.passed {
            failed.push(name);
        }
        reports.push((name, outcome.summary));
    }
    for (name, lines) in reports {
        eprintln!("\n{name}:");
        for line in lines {
            eprintln!("  {line}");
        }
    }
    if failed.is_empty() {
        Ok(())
    } else {
        bail!("tests failed: {}", failed.join(", "))
    }
}

/// The runs of a whole test: a name and Cargo's arguments each. Each selection of packages is
/// built with its own set of features, so that the runs of one selection share their builds.
fn test_runs(runner: Runner, gpu: bool) -> Vec<(&'static str, Vec<&'static str>)> {
    let with = |option: &'static str, packages: &[&'static str]| -> Vec<&'static str> {
        packages
            .iter()
            .flat_map(|package| [option, package])
            .collect()
    };
    let core = with("--package", &CORE);
    let mut rest = vec!["--workspace"];
    rest.extend(with("--exclude", &CORE));
    let mut filter: &[&str] = &[];
    if !gpu {
        rest.extend(with("--exclude", &NEEDS_DEVICE));
        filter = &["--", "--skip", ON_DEVICE];
    }
    match runner {
        // One call runs the examples in the documentation too.
        Runner::Cargo => vec![
            (
                "core alone",
                [&["test", "--no-fail-fast"], &core[..]].concat(),
            ),
            (
                "the other crates",
                [&["test", "--no-fail-fast"], &rest[..], filter].concat(),
            ),
        ],
        Runner::Nextest => vec![
            (
                "core alone",
                [&["nextest", "run", "--no-fail-fast"], &core[..]].concat(),
            ),
            (
                "core's documentation",
                [&["test", "--doc", "--no-fail-fast"], &core[..]].concat(),
            ),
            (
                "the other crates' documentation",
                [&["test", "--doc", "--no-fail-fast"], &rest[..]].concat(),
            ),
            (
                "the other crates",
                [&["nextest", "run", "--no-fail-fast"], &rest[..], filter].concat(),
            ),
        ],
    }
}

/// Times the pixel kernels and prints tables.
pub(crate) fn bench() -> Result<()> {
    setup::ensure(false, Display::None)?;
    bench::bench(cargo()?, &root()?)
}

/// Builds the program with more and fewer features and prints what each costs.
pub(crate) fn sizes(format: sizes::Format) -> Result<()> {
    setup::ensure(true, Display::None)?;
    sizes::sizes(cargo, &root()?, format)
}

/// Formatting, clippy and documentation, warnings denied; and crates without what can be left out.
pub(crate) fn ci() -> Result<()> {
    setup::ensure(false, Display::None)?;
    succeed(cargo()?.args(["fmt", "--all", "--check"]))?;
    succeed(cargo()?.args([
        "clippy",
        "--workspace",
        "--all-targets",
        "--",
        "--deny",
        "warnings",
    ]))?;
    // Each alone: together they would switch each other's features on.
    for package in [
        "relievo-raster",
        "relievo-vector",
        "relievo-engine",
        "relievo",
    ] {
        succeed(cargo()?.args(["check", "--package", package, "--no-default-features"]))?;
    }
    let mut doc = cargo()?;
    doc.args([
        "doc",
        "--workspace",
        "--no-deps",
        "--document-private-items",
    ]);
    succeed(doc.env("RUSTDOCFLAGS", "--deny warnings"))
}

/// The folder that holds the workspace.
fn root() -> Result<PathBuf> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    Ok(manifest
        .parent()
        .context("xtask lies inside the workspace")?
        .to_owned())
}

/// The Cargo that started this program, in the workspace's folder.
fn cargo() -> Result<Command> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()?);
    Ok(command)
}

/// Runs a command to its end.
fn succeed(command: &mut Command) -> Result<()> {
    let line = format!("{command:?}");
    let status = command
        .status()
        .with_context(|| format!("cannot start {line}"))?;
    if !status.success() {
        bail!("{line} ended with {status}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(display: Display, user: &[&str]) -> Vec<OsString> {
        let user: Vec<String> = user.iter().map(|s| (*s).to_owned()).collect();
        studio_arguments(
            display,
            &user,
            Path::new("earth.relievo"),
            Path::new("earth.png"),
        )
    }

    #[test]
    fn without_a_display_the_sample_becomes_a_picture() {
        assert_eq!(
            arguments(Display::None, &["--size", "640x480"]),
            [
                "render",
                "earth.relievo",
                "-o",
                "earth.png",
                "--size",
                "640x480"
            ]
        );
    }

    #[test]
    fn a_project_that_the_user_names_replaces_the_sample() {
        assert_eq!(
            arguments(Display::X11, &["--threads", "2"]),
            ["earth.relievo", "--threads", "2"]
        );
        assert_eq!(
            arguments(Display::Wayland, &["mars.relievo"]),
            ["mars.relievo"]
        );
        assert_eq!(
            arguments(Display::None, &["mars.relievo"]),
            ["render", "mars.relievo", "-o", "earth.png"]
        );
    }

    #[test]
    fn every_folder_of_core_is_tested_alone() {
        let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core");
        let folders = std::fs::read_dir(core).expect("core/ lies beside xtask/");
        let mut named: Vec<String> = folders
            .flatten()
            .map(|folder| format!("relievo-{}", folder.file_name().to_string_lossy()))
            .collect();
        let mut listed = CORE.to_vec();
        named.sort();
        listed.sort_unstable();
        assert_eq!(named, listed);
    }

    #[test]
    fn core_is_tested_first_in_a_run_that_builds_nothing_else() {
        for runner in [Runner::Cargo, Runner::Nextest] {
            let runs = test_runs(runner, true);
            let (_, core) = &runs[0];
            assert!(!core.contains(&"--workspace"));
            assert!(CORE.iter().all(|package| core.contains(package)));
        }
    }

    #[test]
    fn every_run_goes_on_after_a_failure() {
        for runner in [Runner::Cargo, Runner::Nextest] {
            assert!(
                test_runs(runner, true)
                    .iter()
                    .all(|(_, arguments)| arguments.contains(&"--no-fail-fast"))
            );
        }
    }

    #[test]
    fn nextest_which_runs_no_examples_gets_runs_for_them_over_the_same_packages() {
        let packages = |arguments: &[&'static str]| -> Vec<_> {
            let first = arguments
                .iter()
                .position(|a| ["--package", "--workspace"].contains(a));
            arguments[first.unwrap()..].to_vec()
        };
        let runs = test_runs(Runner::Nextest, true);
        let (examples, tests): (Vec<_>, Vec<_>) =
            runs.iter().partition(|(_, a)| a.contains(&"--doc"));
        let sorted = |runs: Vec<&(&str, Vec<&'static str>)>| {
            let mut all: Vec<_> = runs
                .iter()
                .map(|(_, arguments)| packages(arguments))
                .collect();
            all.sort();
            all
        };
        assert_eq!(sorted(examples), sorted(tests));
    }

    #[test]
    fn without_a_gpu_no_test_that_opens_a_device_runs() {
        for runner in [Runner::Cargo, Runner::Nextest] {
            let runs = test_runs(runner, false);
            let wide = runs
                .iter()
                .filter(|(_, arguments)| arguments.contains(&"--workspace"));
            for (_, arguments) in wide.clone() {
                assert!(
                    NEEDS_DEVICE
                        .iter()
                        .all(|package| arguments.contains(package))
                );
            }
            assert!(runs.last().unwrap().1.ends_with(&["--skip", ON_DEVICE]));
        }
    }
}
