//! Laws that no single crate can hold: who may depend on whom, what the documentation promises,
//! that the sample projects open. The tests are in `tests/`; this library is what they share.
//!
//! Invariant: needs nothing but the checkout. Absent: tests of one crate, which live with it.

use std::path::{Path, PathBuf};

/// The folder that holds the workspace.
///
/// # Panics
/// If this crate lies outside a workspace, which is a mistake in its manifest.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests/ lies inside the workspace")
        .to_owned()
}

/// Reads a text file of the workspace by its path from the root.
///
/// # Panics
/// If it cannot be read as UTF-8; the message names it.
pub fn text(path: &str) -> String {
    let whole = workspace().join(path);
    std::fs::read_to_string(&whole).unwrap_or_else(|error| panic!("cannot read {path}: {error}"))
}

/// All files below a folder of the workspace whose name ends in one of the extensions, sorted, as
/// paths from the root with forward slashes. Build output, hidden folders and version control are
/// left out.
///
/// # Panics
/// If a folder cannot be listed.
pub fn files(folder: &str, extensions: &[&str]) -> Vec<String> {
    let root = workspace();
    let mut found = Vec::new();
    let mut folders = vec![root.join(folder)];
    while let Some(next) = folders.pop() {
        let entries = std::fs::read_dir(&next)
            .unwrap_or_else(|error| panic!("cannot list {}: {error}", next.display()));
        for path in entries.flatten().map(|entry| entry.path()) {
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned())
                .unwrap_or_default();
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') {
                    folders.push(path);
                }
            } else if path
                .extension()
                .is_some_and(|e| extensions.iter().any(|x| e == *x))
            {
                let from_root = path.strip_prefix(&root).expect("listed below the root");
                found.push(from_root.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}
