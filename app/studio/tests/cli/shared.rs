//! Runs of the program, and files for them.

use std::io::Write;
use std::path::Path;

use relievo_engine::raster::Cancel;
use serde_json::Value;

/// A project without files: hills of noise, coloured by height.
pub(crate) const NOISE: &str = r##"{"version": 1, "layers": [
    {"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 900.0, "wavelength_m": 500000.0, "octaves": 6},
    {"id": "tint", "name": "Tint", "kind": "tint",
     "stops": [{"height_m": -500.0, "colour": "#102030"}, {"height_m": 500.0, "colour": "#f0e0d0"}]}]}"##;

/// What a run of the program gives.
pub(crate) struct Run {
    pub(crate) code: u8,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Run {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out)
            .unwrap_or_else(|e| panic!("expected JSON, found {e}: {}", self.out))
    }
}

/// A run of the program.
pub(crate) fn relievo(arguments: &[&str]) -> Run {
    let mut out = Vec::new();
    let (code, err) = relievo_into(arguments, &mut out);
    let out = String::from_utf8(out).unwrap();
    Run { code, out, err }
}

/// A run whose results go somewhere else: its exit code and what it says is wrong.
pub(crate) fn relievo_into(arguments: &[&str], out: &mut dyn Write) -> (u8, String) {
    let mut err = Vec::new();
    let all = ["relievo"].iter().chain(arguments).copied();
    let code = relievo::cli::run(all, out, &mut err, &Cancel::default());
    (code, String::from_utf8(err).unwrap())
}

/// A run that must succeed.
pub(crate) fn good(arguments: &[&str]) -> Run {
    let run = relievo(arguments);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{arguments:?}");
    run
}

/// The line of a run that must be refused as bad input.
pub(crate) fn refused(arguments: &[&str]) -> String {
    let run = relievo(arguments);
    assert_eq!(run.code, 2, "{arguments:?}: {}", run.err);
    assert!(
        run.err.starts_with("relievo: ") && run.err.ends_with('\n'),
        "{}",
        run.err
    );
    assert_eq!(run.err.lines().count(), 1, "one line: {}", run.err);
    run.err
}

pub(crate) fn sample_file(name: &str) -> String {
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects");
    projects.join(name).to_str().unwrap().to_owned()
}

pub(crate) fn text_file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

pub(crate) fn in_folder(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}
