//! `cargo xtask`: sets up a fresh machine, runs the studio, the tests and the checks.
//!
//! Invariant: nothing is installed before a line on standard error has said what and why; where
//! it may not install, it prints exactly what is missing and how to get it, and exits with 1.
//! Absent: any knowledge of maps, tiles or GPUs.

mod bench;
mod packages;
mod setup;
mod sizes;
mod summary;
mod tasks;

use std::process::ExitCode;

/// What `cargo xtask` prints without a task, or with one it does not know.
const USAGE: &str = "\
Usage: cargo xtask TASK

Tasks:
  studio [-- ARGS]   set up what is missing and open the studio on projects/earth.relievo;
                     without a display, render it to earth.png and say where that is.
                     ARGS go to the studio; a .relievo file among them replaces the sample
  test [--no-gpu]    set up what is missing and run all tests;
                     --no-gpu leaves out those that need a Vulkan, Metal or DirectX device
  bench              time the pixel kernels, and what GDAL and OpenCV take for the same work
                     where they are installed for python3
  sizes [--csv]      build the program with all features and with fewer, in release, and print
                     what each costs: bytes, and milliseconds to start and to draw
  ci                 formatting, clippy and documentation, warnings denied
  help               print this
";

/// One task with its options, as the command line named it.
#[derive(Debug, PartialEq, Eq)]
enum Task {
    Studio { arguments: Vec<String> },
    Test { gpu: bool },
    Bench,
    Sizes { format: sizes::Format },
    Ci,
    Help,
}

/// Reads the arguments that follow `cargo xtask`; `Err` is one line that says what is wrong.
fn parse(arguments: &[String]) -> Result<Task, String> {
    let Some((task, rest)) = arguments.split_first() else {
        return Ok(Task::Help);
    };
    match task.as_str() {
        "studio" => {
            let rest = rest.strip_prefix(&["--".to_owned()]).unwrap_or(rest);
            Ok(Task::Studio {
                arguments: rest.to_vec(),
            })
        }
        "test" => match rest {
            [] => Ok(Task::Test { gpu: true }),
            [only] if only == "--no-gpu" => Ok(Task::Test { gpu: false }),
            other => Err(format!(
                "`test` takes only --no-gpu, found {}",
                other.join(" ")
            )),
        },
        "bench" if rest.is_empty() => Ok(Task::Bench),
        "bench" => Err(format!(
            "`bench` takes no options, found {}",
            rest.join(" ")
        )),
        "sizes" => match rest {
            [] => Ok(Task::Sizes {
                format: sizes::Format::Markdown,
            }),
            [only] if only == "--csv" => Ok(Task::Sizes {
                format: sizes::Format::Csv,
            }),
            other => Err(format!(
                "`sizes` takes only --csv, found {}",
                other.join(" ")
            )),
        },
        "ci" if rest.is_empty() => Ok(Task::Ci),
        "ci" => Err(format!("`ci` takes no options, found {}", rest.join(" "))),
        "help" | "--help" | "-h" => Ok(Task::Help),
        other => Err(format!("unknown task `{other}`")),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match parse(&arguments) {
        Ok(Task::Studio { arguments }) => tasks::studio(&arguments),
        Ok(Task::Test { gpu }) => tasks::test(gpu),
        Ok(Task::Bench) => tasks::bench(),
        Ok(Task::Sizes { format }) => tasks::sizes(format),
        Ok(Task::Ci) => tasks::ci(),
        Ok(Task::Help) => {
            eprint!("{USAGE}");
            Ok(())
        }
        Err(problem) => {
            eprintln!("xtask: {problem}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Task, String> {
        parse(
            &line
                .split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn arguments_after_the_dashes_go_to_the_studio_untouched() {
        let task = parsed("studio -- --threads 2 -- x").unwrap();
        assert_eq!(
            task,
            Task::Studio {
                arguments: ["--threads", "2", "--", "x"].map(str::to_owned).to_vec()
            }
        );
        assert_eq!(
            parsed("studio").unwrap(),
            Task::Studio {
                arguments: Vec::new()
            }
        );
    }

    #[test]
    fn a_mistyped_task_or_option_is_named() {
        assert!(parsed("tset").unwrap_err().contains("tset"));
        assert!(parsed("test --no-gup").unwrap_err().contains("--no-gup"));
        assert!(parsed("sizes --cvs").unwrap_err().contains("--cvs"));
        assert!(parsed("ci --fast").unwrap_err().contains("--fast"));
    }

    #[test]
    fn gpu_tests_run_unless_they_are_left_out() {
        assert_eq!(parsed("test").unwrap(), Task::Test { gpu: true });
        assert_eq!(parsed("test --no-gpu").unwrap(), Task::Test { gpu: false });
    }
}
