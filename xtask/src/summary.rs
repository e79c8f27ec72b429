//! Runs a test runner while copying what it says, and keeps its summary lines.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Context, Result};

/// What became of one run.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// Whether the runner ended well.
    pub(crate) passed: bool,
    /// The runner's summary lines, in the order printed.
    pub(crate) summary: Vec<String>,
}

/// Whether a line is a summary of `cargo test` or `cargo nextest`.
fn is_summary(line: &str) -> bool {
    line.trim_start().starts_with("test result:") || line.contains("Summary [")
}

/// Runs `command` to its end, copying its output, and keeps the summary lines.
///
/// # Errors
/// If the program cannot be started or its output cannot be read or copied.
pub(crate) fn run(command: &mut Command) -> Result<Outcome> {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("cannot start {}", command.get_program().display()))?;
    let stdout = child
        .stdout
        .take()
        .context("standard output was asked for")?;
    let stderr = child
        .stderr
        .take()
        .context("standard error was asked for")?;
    let copier = thread::Builder::new().name("stdout copier".to_owned());
    let copying = copier
        .spawn(move || copy(stdout, std::io::stdout()))
        .context("cannot start a thread")?;
    let mut summary = copy(stderr, std::io::stderr())?;
    let printed = copying
        .join()
        .map_err(|_panic| anyhow::anyhow!("the copying thread panicked"))??;
    summary.extend(printed);
    Ok(Outcome {
        passed: child.wait()?.success(),
        summary,
    })
}

/// Copies lines from one stream to another and returns the summaries among them.
fn copy(from: impl Read, mut to: impl Write) -> Result<Vec<String>> {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    let mut kept = Vec::new();
    // Lines may hold any bytes: a test prints what it likes.
    while from.read_until(b'\n', &mut line)? > 0 {
        to.write_all(&line)?;
        to.flush()?;
        let text = String::from_utf8_lossy(&line);
        if is_summary(&text) {
            kept.push(text.trim().to_owned());
        }
        line.clear();
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_copied_byte_for_byte_and_summaries_are_kept() {
        let said = b"running 2 tests\n\xff\xfe\ntest result: ok. 2 passed; 0 failed\n  Summary [ 1.2s] 3 tests run: 3 passed";
        let mut copied = Vec::new();
        let kept = copy(&said[..], &mut copied).unwrap();
        assert_eq!(copied, said);
        assert_eq!(
            kept,
            [
                "test result: ok. 2 passed; 0 failed",
                "Summary [ 1.2s] 3 tests run: 3 passed"
            ]
        );
    }
}
