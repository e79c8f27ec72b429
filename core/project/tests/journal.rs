//! The journal: what a crash leaves, down to kills at any moment.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use relievo_project::{
    Edit, Element, ElementKind, FileStamp, Journal, JournalOptions, Layer, LayerKind, Noise,
    NoiseLayer, Polygon, Project, Recovery, Replace, SurfaceKind, Vertex, open, save_atomic,
    save_with,
};

const LONG: Duration = Duration::from_mins(1);

fn options(gather_ms: u64) -> JournalOptions {
    JournalOptions {
        state_folder: None,
        gather: Duration::from_millis(gather_ms),
    }
}

fn noise() -> Layer {
    let noise = Noise::default();
    Layer::new("n".into(), "0", LayerKind::Noise(NoiseLayer { noise }))
}

/// The project as it is after edits 1 to `n`: a name, an opacity, and now and then long geometry.
fn after(n: u32) -> Project {
    let mut project = Project::default();
    project.layers.push(noise());
    project.layers[0].name = n.to_string();
    project.elements.push(outline(n - n % 10));
    project
}

/// An element that is too long for the project's text.
fn outline(n: u32) -> Arc<Element> {
    let vertices: Vec<Vertex> = (0..10_100)
        .map(|i| Vertex::new(f64::from(i + n) * 1e-6, 0.0))
        .collect();
    let kind = ElementKind::Polygon(Polygon::new(vertices, SurfaceKind::Tin));
    Arc::new(Element::new("e".into(), "e", kind))
}

/// The number comes last: where the journal is torn between the two, step `n` has not been done, and
/// doing it again gives the same.
fn edits(n: u32) -> Vec<Edit> {
    let mut edits = Vec::new();
    if n.is_multiple_of(10) {
        edits.push(Edit::ReplaceElement {
            scenario: None,
            element: outline(n),
        });
    }
    edits.push(Edit::SetName {
        id: "n".into(),
        name: n.to_string(),
    });
    edits
}

fn number(project: &Project) -> u32 {
    project.layers[0].name.parse().unwrap()
}

fn start(folder: &Path) -> (PathBuf, FileStamp) {
    let path = folder.join("a.relievo");
    let stamp = save_atomic(&path, &after(0), Replace::Never).unwrap();
    (path, stamp)
}

fn record(journal: &Journal, numbers: impl IntoIterator<Item = u32>) {
    for edit in numbers.into_iter().flat_map(edits) {
        journal.record(&edit);
    }
}

#[test]
fn edits_come_back_after_a_crash_and_go_with_a_save() {
    let folder = tempfile::tempdir().unwrap();
    let (path, stamp) = start(folder.path());
    assert!(Recovery::find(&path, stamp, None).unwrap().is_none());
    let journal = Journal::start(&path, stamp, options(1)).unwrap();
    record(&journal, 1..=12);
    assert!(journal.flush(LONG));
    // What a crash would leave now:
    let recovery = Recovery::find(&path, stamp, None).unwrap().unwrap();
    let (mut project, _) = open(&path).unwrap();
    assert!(recovery.fits() && !recovery.is_torn());
    assert_eq!(recovery.replay(&mut project).1, None);
    assert_eq!(project, after(12));

    let stamp = save_with(&path, &project, Replace::IfUnchanged(stamp), |s| {
        journal.saving(s);
    });
    // A crash between the replacement and the journal's end: the file has the edits already.
    let stamp = stamp.unwrap();
    assert!(Recovery::find(&path, stamp, None).unwrap().is_none());
    journal.saved(stamp);
    record(&journal, [13]);
    assert!(journal.flush(LONG));
    let recovery = Recovery::find(&path, stamp, None).unwrap().unwrap();
    assert_eq!(recovery.edits(), edits(13));
    journal.discard();
    assert!(Recovery::find(&path, stamp, None).unwrap().is_none());
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "a.relievo and its side files"
    );
}

#[test]
fn edits_are_on_disk_soon_though_nobody_asks() {
    let folder = tempfile::tempdir().unwrap();
    let (path, stamp) = start(folder.path());
    let journal = Journal::start(&path, stamp, options(5)).unwrap();
    record(&journal, [1]);
    let is_there = || matches!(Recovery::find(&path, stamp, None), Ok(Some(_)));
    let patience = Instant::now();
    while !is_there() && patience.elapsed() < LONG {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(is_there());
    drop(journal);
    assert!(is_there(), "closing without a save keeps the edits");
}

#[test]
fn a_torn_tail_is_dropped_wherever_it_is_torn_and_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let (path, stamp) = start(folder.path());
    let journal = Journal::start(&path, stamp, options(1)).unwrap();
    for n in 1..=3 {
        record(&journal, [n]);
        assert!(journal.flush(LONG));
    }
    drop(journal);
    let file = folder.path().join("a.relievo.journal");
    let whole = fs::read(&file).unwrap();
    let mut most = 0;
    for length in 0..=whole.len() {
        fs::write(&file, &whole[..length]).unwrap();
        let found = Recovery::find(&path, stamp, None).unwrap();
        let count = found.map_or(0, |recovery| recovery.edits().len());
        assert!(count == most || count == most + 1);
        most = count;
    }
    assert_eq!(most, 3);
    for place in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[place] ^= 0x55;
        fs::write(&file, &damaged).unwrap();
        if let Ok(Some(recovery)) = Recovery::find(&path, stamp, None) {
            let (mut project, _) = open(&path).unwrap();
            recovery.replay(&mut project);
            assert_eq!(project, after(number(&project)));
        }
    }
    // Going on behind a torn record.
    fs::write(&file, &whole[..whole.len() - 3]).unwrap();
    let recovery = Recovery::find(&path, stamp, None).unwrap().unwrap();
    assert!(recovery.is_torn());
    let journal = Journal::resume(&recovery, options(1)).unwrap();
    record(&journal, [3, 4]);
    assert!(journal.flush(LONG));
    let recovery = Recovery::find(&path, stamp, None).unwrap().unwrap();
    let (mut project, _) = open(&path).unwrap();
    assert_eq!(recovery.replay(&mut project).1, None);
    assert_eq!(project, after(4));
}

#[test]
fn a_project_that_another_program_changed_is_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let (path, stamp) = start(folder.path());
    let journal = Journal::start(&path, stamp, options(1)).unwrap();
    record(&journal, [1]);
    drop(journal);
    let other = save_atomic(&path, &Project::default(), Replace::Always).unwrap();
    let recovery = Recovery::find(&path, other, None).unwrap().unwrap();
    assert!(!recovery.fits());
    let (applied, problem) = recovery.replay(&mut Project::default());
    assert_eq!(applied, 0);
    assert!(
        problem
            .unwrap()
            .to_string()
            .contains("expected the id of a layer")
    );
    let copy = relievo_project::free_name_beside(&path);
    assert_eq!(copy.file_name().unwrap(), "a 2.relievo");
}

#[test]
fn a_journal_that_is_there_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let (path, stamp) = start(folder.path());
    for n in [1, 2] {
        let journal = Journal::start(&path, stamp, options(1)).unwrap();
        record(&journal, [n]);
        assert!(journal.flush(LONG));
    }
    assert!(folder.path().join("a.relievo.journal.old").exists());
}

/// The child below saves after this many steps, and again and again.
const FIRST_SAVE: u32 = 7;

/// Edits, saves and is killed: started by the test below, does nothing otherwise.
#[test]
fn child_that_is_killed() {
    let Some(path) = std::env::var_os("RELIEVO_KILLED_CHILD").map(PathBuf::from) else {
        return;
    };
    let (mut project, stamp) = open(&path).unwrap();
    let journal = if let Some(recovery) = Recovery::find(&path, stamp, None).unwrap() {
        assert_eq!(recovery.replay(&mut project).1, None);
        Journal::resume(&recovery, options(1)).unwrap()
    } else {
        Journal::start(&path, stamp, options(1)).unwrap()
    };
    let mut stamp = stamp;
    for n in number(&project) + 1.. {
        for edit in edits(n) {
            project.apply(edit.clone()).unwrap();
            journal.record(&edit);
        }
        if n.is_multiple_of(3) && journal.flush(LONG) {
            println!("\ndurable {n}");
        }
        if n.is_multiple_of(FIRST_SAVE) {
            let replace = Replace::IfUnchanged(stamp);
            stamp = save_with(&path, &project, replace, |s| journal.saving(s)).unwrap();
            journal.saved(stamp);
            println!("\ndurable {n}");
        }
    }
}

/// Starts the child above and kills it after a time, or once it has saved a first time; gives the last
/// step that it called durable.
fn kill_child(project: &Path, after: Option<Duration>) -> u32 {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "child_that_is_killed", "--nocapture"])
        .env("RELIEVO_KILLED_CHILD", project)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stdout.take().unwrap())
        .lines()
        .map_while(Result::ok)
        .filter_map(|line| line.strip_prefix("durable ")?.parse().ok());
    let mut last = 0;
    if let Some(time) = after {
        std::thread::sleep(time);
    } else {
        while last < FIRST_SAVE {
            last = said.next().unwrap();
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    said.fold(last, u32::max)
}

#[test]
fn a_program_killed_at_any_moment_loses_nothing_that_was_on_disk() {
    let kills: u32 = std::env::var("RELIEVO_KILLS").map_or(60, |n| n.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = start(folder.path());
    // How soon a child has saved here, which is a matter of the disk.
    let started = Instant::now();
    let mut durable = kill_child(&path, None);
    let first_save = started.elapsed();
    let (mut saved, mut recovered) = (0, 0);
    // More often where the machine has so much else to do that one of both does not happen.
    for kill in 0..10 * kills {
        if kill >= kills && saved > 0 && recovered > 0 {
            break;
        }
        // From before it opened the project to after some saves.
        let hash = blake3::hash(&kill.to_le_bytes()).as_bytes()[0];
        let delay = first_save.mul_f64(f64::from(hash) / 128.0);
        durable = durable.max(kill_child(&path, Some(delay)));

        let (mut project, stamp) = open(&path).unwrap();
        assert!(project.missing_geometry(&path).is_empty());
        assert_eq!(
            project,
            after(number(&project)),
            "the file is one that was saved"
        );
        assert!(number(&project) >= saved, "never one from before");
        saved = number(&project);
        if let Some(recovery) = Recovery::find(&path, stamp, None).unwrap() {
            assert!(recovery.fits());
            assert_eq!(recovery.replay(&mut project).1, None);
            recovered += 1;
        }
        let n = number(&project);
        // The outline of the next step may be there without its number.
        let next = after(n + 1).elements;
        let mut expected = after(n);
        if project.elements == next {
            expected.elements = next;
        }
        assert_eq!(project, expected);
        assert!(n >= durable, "{durable} was on disk, {n} came back");
    }
    assert!(
        saved > 0 && recovered > 0,
        "{saved} saves, {recovered} recoveries"
    );
}
