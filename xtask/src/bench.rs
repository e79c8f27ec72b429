//! Speed: the benches of the pixel kernels, and what other programs take for the same work.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

/// Crates whose benches are run.
const PACKAGES: [&str; 2] = ["relievo-raster", "relievo-graph"];

/// Our work, a peer's, and how many times as fast ours should be.
const RATIOS: [(&str, &str, f64); 5] = [
    (
        "height tile from a GeoTIFF in UTM",
        "warp, default error (-et 0.125)",
        8.0,
    ),
    (
        "height tile from a GeoTIFF in UTM",
        "warp, exact places (-et 0)",
        8.0,
    ),
    ("slider: adjust of 8 bits", "adjust, without gamma", 10.0),
    (
        "slider: adjust with gamma of 8 bits",
        "adjust, with gamma",
        10.0,
    ),
    ("normals", "hillshade, a tile's share of 2048²", 2.5),
];

/// Times in milliseconds by what they measure.
type Times = BTreeMap<String, f64>;

/// Runs benches and peers, one after the other, and prints tables.
pub(crate) fn bench(cargo: Command, root: &Path) -> Result<()> {
    let results = root.join("target").join("kernel-benches");
    if results.exists() {
        std::fs::remove_dir_all(&results)
            .with_context(|| format!("cannot empty {}", results.display()))?;
    }
    run(cargo, &results)?;
    let mut ours = Times::new();
    collect(&results, &mut ours)?;
    if ours.is_empty() {
        bail!("the benches left no result in {}", results.display());
    }
    let (peers, missing) = peers(root);
    let tables = tables(&ours, &peers, &missing);
    // The one thing that this task is asked for.
    std::io::Write::write_all(&mut std::io::stdout(), tables.as_bytes())
        .context("cannot write the tables")
}

fn run(mut cargo: Command, results: &Path) -> Result<()> {
    cargo.arg("bench");
    for package in PACKAGES {
        cargo.args(["--package", package]);
    }
    cargo.args(["--benches", "--", "--noplot"]);
    cargo.env("CRITERION_HOME", results);
    let status = cargo.status().context("cannot start cargo bench")?;
    if !status.success() {
        bail!("cargo bench ended with {status}");
    }
    Ok(())
}

/// Reads what criterion left in a folder and those in it.
fn collect(folder: &Path, times: &mut Times) -> Result<()> {
    let read = |name: &str| std::fs::read_to_string(folder.join("new").join(name)).ok();
    if let (Some(about), Some(sample)) = (read("benchmark.json"), read("sample.json"))
        && let Some(name) = text(&about, "full_id")
    {
        let fastest =
            fastest_ns(&sample).with_context(|| format!("no times in the results of {name:?}"))?;
        times.insert(name, fastest * 1e-6);
    }
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    for entry in entries {
        let path = entry.context("cannot list results")?.path();
        if path.is_dir() {
            collect(&path, times)?;
        }
    }
    Ok(())
}

/// The text under a key of a flat JSON object.
fn text(json: &str, key: &str) -> Option<String> {
    let (_, rest) = json.split_once(&format!("\"{key}\":"))?;
    let (value, _) = rest.trim_start().strip_prefix('"')?.split_once('"')?;
    Some(value.to_owned())
}

/// The numbers under a key of a flat JSON object.
fn numbers(json: &str, key: &str) -> Option<Vec<f64>> {
    let (_, rest) = json.split_once(&format!("\"{key}\":"))?;
    let (list, _) = rest.trim_start().strip_prefix('[')?.split_once(']')?;
    list.split(',').map(|v| v.trim().parse().ok()).collect()
}

/// Nanoseconds of the fastest run in criterion's record of runs.
fn fastest_ns(sample: &str) -> Option<f64> {
    let (iterations, times) = (numbers(sample, "iters")?, numbers(sample, "times")?);
    iterations
        .iter()
        .zip(times)
        .map(|(n, ns)| ns / n)
        .min_by(f64::total_cmp)
}

/// What other programs take, and those that are not there. Python is looked for in several places, for
/// the first on the path may lack the peers that the system's has.
fn peers(root: &Path) -> (Times, Vec<String>) {
    let script = root.join("tests").join("peers").join("kernels.py");
    let mut candidates: Vec<OsString> = Vec::new();
    candidates.extend(std::env::var_os("RELIEVO_PYTHON"));
    candidates.extend(["python3", "/usr/bin/python3", "python"].map(OsString::from));
    let mut best: Option<(Times, Vec<String>)> = None;
    for python in candidates {
        let Ok(output) = Command::new(python).arg(&script).output() else {
            continue;
        };
        let found = measured(&String::from_utf8_lossy(&output.stdout));
        if best
            .as_ref()
            .is_none_or(|best| found.0.len() > best.0.len())
        {
            best = Some(found);
        }
        if best
            .as_ref()
            .is_some_and(|(times, missing)| !times.is_empty() && missing.is_empty())
        {
            break;
        }
    }
    best.unwrap_or_else(|| (Times::new(), vec!["python3".to_owned()]))
}

/// Reads the lines of the script: peer, work, milliseconds; or peer, `not installed`.
fn measured(lines: &str) -> (Times, Vec<String>) {
    let (mut times, mut missing) = (Times::new(), Vec::new());
    for line in lines.lines() {
        match line.split('\t').collect::<Vec<_>>()[..] {
            [_, work, ms] => {
                if let Ok(ms) = ms.parse() {
                    times.insert(work.to_owned(), ms);
                }
            }
            [peer, _not_installed] => missing.push(peer.to_owned()),
            _ => {}
        }
    }
    (times, missing)
}

fn tables(ours: &Times, peers: &Times, missing: &[String]) -> String {
    let mut out = String::from("\n| ours | ms |\n|---|---|\n");
    let mut rows = |times: &Times, head: &str| {
        out.push_str(head);
        for (name, ms) in times {
            writeln!(out, "| {name} | {ms:.4} |").expect("a string takes everything");
        }
    };
    rows(ours, "");
    rows(peers, "\n| peers | ms |\n|---|---|\n");
    for peer in missing {
        writeln!(out, "| {peer} | not installed |").expect("a string takes everything");
    }
    out.push_str("\n| ours | peer | times as fast | wanted |\n|---|---|---|---|\n");
    for (name, work, wanted) in RATIOS {
        let ratio = match (ours.get(name), peers.get(work)) {
            (Some(ours), Some(peer)) => format!("{:.1}", peer / ours),
            (None, _) => "no such bench".to_owned(),
            (_, None) => "not installed".to_owned(),
        };
        writeln!(out, "| {name} | {work} | {ratio} | {wanted} |")
            .expect("a string takes everything");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_run_counts() {
        let sample = r#"{"sampling_mode":"Linear","iters":[1.0,2.0,4.0],"times":[10.0,16.0,36.0]}"#;
        assert_eq!(fastest_ns(sample), Some(8.0));
        assert_eq!(fastest_ns("{}"), None);
        let about = r#"{"group_id":"a tile","full_id":"a tile","title":"x"}"#;
        assert_eq!(text(about, "full_id").as_deref(), Some("a tile"));
    }

    #[test]
    fn peers_that_are_missing_are_said_to_be() {
        let (peers, missing) =
            measured("GDAL 3\twarp, exact places (-et 0)\t6.5\nOpenCV\tnot installed\n");
        let ours = Times::from([("height tile from a GeoTIFF in UTM".to_owned(), 0.5)]);
        let tables = tables(&ours, &peers, &missing);
        assert!(tables.contains("| OpenCV | not installed |"));
        assert!(tables.contains("warp, exact places (-et 0) | 13.0 | 8 |"));
        assert!(tables.contains("| adjust, with gamma | no such bench | 10 |"));
    }
}
