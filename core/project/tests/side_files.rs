//! Long geometry in files beside the project.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::fs;
use std::path::Path;
use std::sync::Arc;

use relievo_project::{
    Element, ElementKind, Polygon, Project, Replace, SurfaceKind, Vertex, open, save_atomic,
    side_folder,
};

fn polygon(id: &str, vertices: u32) -> Arc<Element> {
    let outline: Vec<Vertex> = (0..vertices)
        .map(|i| Vertex {
            lon_deg: f64::from(i) * 1e-6,
            lat_deg: 45.5,
            height_m: (i % 2 == 0).then_some(f64::from(i)),
        })
        .collect();
    let kind = ElementKind::Polygon(Polygon::new(outline, SurfaceKind::Tin));
    Arc::new(Element::new(id.into(), id, kind))
}

fn project(lengths: &[u32]) -> Project {
    let elements = lengths.iter().enumerate();
    Project {
        elements: elements
            .map(|(i, length)| polygon(&format!("p{i}"), *length))
            .collect(),
        ..Project::default()
    }
}

fn files(path: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(side_folder(path)).into_iter().flatten();
    entries.map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_long_outline_goes_into_a_file_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let project = project(&[10_000, 10_001, 10_001, 30_000]);
    save_atomic(&path, &project, Replace::Never).unwrap();
    assert_eq!(files(&path).len(), 2, "equal outlines share a file");
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("\"vertices\": 10001").count(), 2);
    assert_eq!(text, project.to_json());
    assert_eq!(open(&path).unwrap().0, project);
}

#[test]
fn many_short_outlines_stay_within_what_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let project = project(&(0..60).map(|i| 9_000 + i).collect::<Vec<u32>>());
    save_atomic(&path, &project, Replace::Never).unwrap();
    assert!(!files(&path).is_empty());
    assert_eq!(open(&path).unwrap().0, project);
}

#[test]
fn what_nothing_names_any_more_goes_with_the_next_save() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    save_atomic(&path, &project(&[20_000]), Replace::Never).unwrap();
    let first = files(&path);
    save_atomic(&path, &project(&[20_001]), Replace::Always).unwrap();
    assert_eq!(files(&path).len(), 1);
    assert_ne!(files(&path), first);
    let foreign = side_folder(&path).join("notes.txt");
    fs::write(&foreign, "mine").unwrap();
    save_atomic(&path, &project(&[3]), Replace::Always).unwrap();
    assert_eq!(files(&path), std::slice::from_ref(&foreign));
    fs::remove_file(foreign).unwrap();
    save_atomic(&path, &project(&[3]), Replace::Always).unwrap();
    assert!(!side_folder(&path).exists());
}

#[test]
fn a_missing_or_damaged_file_is_named_and_its_reference_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let whole = project(&[20_000, 5]);
    save_atomic(&path, &whole, Replace::Never).unwrap();
    let file = files(&path).remove(0);
    let bytes = fs::read(&file).unwrap();

    let mut damaged = bytes.clone();
    damaged[1000] ^= 1;
    for (content, part) in [
        (Some(&damaged[..]), "expected content"),
        (Some(&bytes[..100]), "expected content"),
        (None, "cannot read it"),
    ] {
        match content {
            Some(content) => fs::write(&file, content).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        let (opened, _) = open(&path).unwrap();
        let missing = opened.missing_geometry(&path);
        assert_eq!(missing.len(), 1);
        assert_eq!((missing[0].name.as_str(), &missing[0].file), ("p0", &file));
        assert!(missing[0].reason.contains(part), "{}", missing[0].reason);
        assert!(opened.elements[0].vertex_lists()[0].is_empty());
        save_atomic(&path, &opened, Replace::Always).unwrap();
    }
    // The file comes back, from a backup say: nothing was lost.
    fs::create_dir_all(side_folder(&path)).unwrap();
    fs::write(&file, &bytes).unwrap();
    assert_eq!(open(&path).unwrap().0, whole);
}
