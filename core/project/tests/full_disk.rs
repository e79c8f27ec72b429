//! Saving where the system refuses after any number of bytes: the old file stays whole.
//!
//! The limit on the size of files stands for a full disk: the system lets writes through up to a
//! byte and refuses the rest, at every place where the program writes. It is one for the process, so
//! this file holds a single test.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::fs;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use relievo_project::{Project, Replace, SaveProjectError, open, save_atomic};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Limits files to so many bytes; `None` lifts the limit.
fn limit_files(bytes: Option<u64>) {
    let maximum = getrlimit(Resource::Fsize).maximum;
    let current = bytes.or(maximum);
    setrlimit(Resource::Fsize, Rlimit { current, maximum }).unwrap();
}

#[test]
fn a_disk_that_is_full_after_any_byte_loses_nothing() {
    // Without a handler the signal that tells of the limit ends the process.
    let told = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, told).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let text = include_str!("data/everything.relievo");
    let new = Project::from_json(text, &path).unwrap();
    let length = new.to_json().len() as u64;
    save_atomic(&path, &Project::default(), Replace::Never).unwrap();
    let before = fs::read(&path).unwrap();
    for space in 0..length {
        limit_files(Some(space));
        let result = save_atomic(&path, &new, Replace::Always);
        limit_files(None);
        let error = result.unwrap_err();
        assert!(matches!(error, SaveProjectError::Write { .. }), "{error}");
        assert!(error.to_string().lines().count() == 1, "{error}");
        assert_eq!(fs::read(&path).unwrap(), before, "after {space} bytes");
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 1, "after {space} bytes nothing is left behind");
    }
    limit_files(Some(length));
    save_atomic(&path, &new, Replace::Always).unwrap();
    limit_files(None);
    assert_eq!(open(&path).unwrap().0, new);
}
