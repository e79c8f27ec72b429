//! `relievo report`.

use crate::shared::{good, in_folder, refused, text_file};

#[test]
fn a_suite_is_written_as_a_page_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let into = in_folder(folder.path(), "new/folder");
    let run = good(&["report", "--suite", "transform", "--quick", "-o", &into]);
    let page = run.out.trim();
    assert!(page.ends_with("index.html"), "{page}");
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.contains("<svg role=\"img\"") && html.contains("cancellation-free"));
    assert!(html.contains(" at commit "), "machine and commit");
    let csv = std::fs::read_to_string(in_folder(folder.path(), "new/folder/transform-cpu.csv"));
    assert!(csv.unwrap().contains("on the front"));
}

#[test]
fn what_cannot_be_reported_is_refused_in_a_line_before_anything_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let file = text_file(folder.path(), "file", "");
    let into = in_folder(folder.path(), "out");
    let unknown = refused(&["report", "--suite", "nothing", "-o", &into]);
    assert!(
        unknown.contains("nothing") && unknown.contains("transform"),
        "{unknown}"
    );
    assert!(refused(&["report", "-o", &into]).contains("--suite"));
    let no_folder = refused(&["report", "--suite", "transform", "-o", &file]);
    assert!(no_folder.contains("expected a folder"), "{no_folder}");
    let missing = in_folder(folder.path(), "missing.relievo");
    let no_project = refused(&["report", "--suite", "transform", "-o", &into, &missing]);
    assert!(no_project.contains("missing.relievo"), "{no_project}");
    assert!(!std::path::Path::new(&into).exists());
}
