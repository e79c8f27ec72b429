//! What leaving out saves: size and start-up of the program with all features and with none.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};

/// Builds: what they are called, and Cargo's options for them.
const BUILDS: [(&str, &[&str]); 5] = [
    ("minimal", &["--no-default-features"]),
    (
        "minimal + readers",
        &["--no-default-features", "--features", "readers"],
    ),
    (
        "minimal + report",
        &["--no-default-features", "--features", "report"],
    ),
    (
        "minimal + window",
        &["--no-default-features", "--features", "window"],
    ),
    ("full", &[]),
];

/// How often each program is started; the middle of the times counts.
const STARTS: usize = 15;

/// How often each program draws.
const PICTURES: usize = 5;

/// One program, measured.
#[derive(Debug, PartialEq)]
struct Measured {
    build: &'static str,
    bytes: u64,
    version_ms: f64,
    render_ms: f64,
}

/// How the table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// A table in Markdown.
    Markdown,
    /// Values divided by commas.
    Csv,
}

/// Builds the programs in release, measures them in turns and prints a table.
pub(crate) fn sizes(
    cargo: impl Fn() -> Result<Command>,
    root: &Path,
    format: Format,
) -> Result<()> {
    let folder = root.join("target").join("sizes");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make {}", folder.display()))?;
    let mut programs = Vec::new();
    for (name, options) in BUILDS {
        programs.push((name, build(cargo()?, &folder, name, options)?));
    }
    let project = root.join("projects").join("synthetic.relievo");
    let picture = folder.join("picture.png");
    let version = |program: &Path| {
        let mut command = Command::new(program);
        command.arg("--version");
        command
    };
    let render = |program: &Path| {
        let mut command = Command::new(program);
        command.arg("render").arg(&project).arg("-o").arg(&picture);
        command.args(["--size", "64x48"]);
        command
    };
    let version_ms = in_turns(&programs, STARTS, &version)?;
    let render_ms = in_turns(&programs, PICTURES, &render)?;
    let mut rows = Vec::new();
    for (((build, program), version_ms), render_ms) in
        programs.iter().zip(version_ms).zip(render_ms)
    {
        rows.push(Measured {
            build,
            bytes: program.metadata()?.len(),
            version_ms,
            render_ms,
        });
    }
    // The one thing that this task is asked for.
    let text = table(&rows, format);
    std::io::Write::write_all(&mut std::io::stdout(), text.as_bytes())
        .context("cannot write the table")
}

/// Builds one program; where it lies.
fn build(mut cargo: Command, folder: &Path, name: &str, options: &[&str]) -> Result<PathBuf> {
    let target = folder.join("build");
    cargo.args([
        "build",
        "--release",
        "--package",
        "relievo",
        "--bin",
        "relievo",
    ]);
    cargo.args(options).arg("--target-dir").arg(&target);
    let status = cargo.status().context("cannot start Cargo")?;
    if !status.success() {
        bail!("the build `{name}` ended with {status}");
    }
    let suffix = std::env::consts::EXE_SUFFIX;
    let made = target.join("release").join(format!("relievo{suffix}"));
    let kept = folder.join(format!("{}{suffix}", name.replace(" + ", "-")));
    std::fs::copy(&made, &kept).with_context(|| format!("cannot copy {}", made.display()))?;
    Ok(kept)
}

/// The middle of each program's times in milliseconds; programs take turns.
fn in_turns(
    programs: &[(&str, PathBuf)],
    times: usize,
    command: &dyn Fn(&Path) -> Command,
) -> Result<Vec<f64>> {
    let mut all = vec![Vec::new(); programs.len()];
    for _ in 0..times {
        for ((name, program), times_ms) in programs.iter().zip(&mut all) {
            let start = Instant::now();
            let status = command(program)
                .stdout(Stdio::null())
                .status()
                .with_context(|| format!("cannot start {}", program.display()))?;
            times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            if !status.success() {
                bail!("the program `{name}` ended with {status}");
            }
        }
    }
    Ok(all.into_iter().map(middle).collect())
}

fn middle(mut times_ms: Vec<f64>) -> f64 {
    times_ms.sort_by(f64::total_cmp);
    times_ms
        .get(times_ms.len() / 2)
        .copied()
        .unwrap_or(f64::NAN)
}

fn table(rows: &[Measured], format: Format) -> String {
    let (mut text, divider, ends) = match format {
        Format::Markdown => (
            "| build | size, bytes | `--version`, ms | `render` of 64 × 48 pixels, ms |\n|---|---|---|---|\n"
                .to_owned(),
            " | ",
            ["| ", " |"],
        ),
        Format::Csv => (
            "build,size in bytes,--version in ms,render of 64 x 48 pixels in ms\n".to_owned(),
            ",",
            ["", ""],
        ),
    };
    for row in rows {
        let cells = [
            row.build.to_owned(),
            row.bytes.to_string(),
            format!("{:.2}", row.version_ms),
            format!("{:.1}", row.render_ms),
        ];
        // Writing to a string never fails.
        let _always = writeln!(text, "{}{}{}", ends[0], cells.join(divider), ends[1]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_tables_say_the_same() {
        let rows = [Measured {
            build: "minimal",
            bytes: 12_345,
            version_ms: 1.5,
            render_ms: 250.0,
        }];
        let markdown = table(&rows, Format::Markdown);
        assert_eq!(
            markdown.lines().last(),
            Some("| minimal | 12345 | 1.50 | 250.0 |")
        );
        let csv = table(&rows, Format::Csv);
        assert_eq!(csv.lines().last(), Some("minimal,12345,1.50,250.0"));
        let columns = |text: &str, divider| text.lines().map(|l| l.matches(divider).count()).max();
        assert_eq!(columns(&markdown, '|'), Some(5));
        assert_eq!(columns(&csv, ','), Some(3));
    }

    #[test]
    fn the_middle_is_not_moved_by_one_slow_start() {
        assert_eq!(middle(vec![2.0, 1.0, 900.0, 1.5, 1.2]), 1.5);
        assert!(middle(Vec::new()).is_nan());
    }
}
