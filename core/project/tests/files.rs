//! Saving and opening files.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::fs;
use std::path::Path;

use relievo_project::{
    OpenProjectError, Project, Replace, SaveProjectError, SourceRole, open, save_atomic,
};

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_saved_project_opens_equal_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let stamp = save_atomic(&path, &Project::default(), Replace::Never).unwrap();
    let (project, read_stamp) = open(&path).unwrap();
    assert_eq!((project, read_stamp), (Project::default(), stamp));
    assert_eq!(names(folder.path()), ["a.relievo"]);
}

#[test]
fn a_file_that_another_program_changed_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let stamp = save_atomic(&path, &Project::default(), Replace::Never).unwrap();
    fs::write(&path, "theirs").unwrap();
    let error = save_atomic(&path, &Project::default(), Replace::IfUnchanged(stamp)).unwrap_err();
    assert!(
        matches!(error, SaveProjectError::ChangedOnDisk { .. }),
        "{error}"
    );
    let error = save_atomic(&path, &Project::default(), Replace::Never).unwrap_err();
    assert!(matches!(error, SaveProjectError::Exists { .. }), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "theirs");
    assert_eq!(names(folder.path()), ["a.relievo"]);
    save_atomic(&path, &Project::default(), Replace::Always).unwrap();
    open(&path).unwrap();
}

#[test]
fn a_folder_in_the_place_of_the_file_is_an_error_that_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("x"), "").unwrap();
    let error = save_atomic(&path, &Project::default(), Replace::Always).unwrap_err();
    assert!(matches!(error, SaveProjectError::Write { .. }), "{error}");
    assert_eq!(names(folder.path()), ["a.relievo"]);
    assert!(matches!(
        open(&path).unwrap_err(),
        OpenProjectError::Read { .. }
    ));
}

#[test]
fn bytes_that_are_not_text_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    fs::write(&path, b"{\"version\": 1 \xff}").unwrap();
    assert!(matches!(
        open(&path).unwrap_err(),
        OpenProjectError::NotText {
            valid_bytes: 14,
            ..
        }
    ));
}

#[cfg(unix)]
#[test]
fn a_link_and_the_permissions_of_its_file_survive_a_save() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (
        folder.path().join("a.relievo"),
        folder.path().join("link.relievo"),
    );
    save_atomic(&file, &Project::default(), Replace::Never).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("a.relievo", &link).unwrap();
    save_atomic(&link, &Project::default(), Replace::Always).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o640
    );
}

#[cfg(unix)]
#[test]
fn a_project_made_from_files_stores_them_relative_and_moves_with_them() {
    let (from, to) = (Path::new("/a/projects"), Path::new("/a"));
    let files = [
        (
            Path::new("/a/projects/data/Blue_Marble.tif"),
            SourceRole::Imagery,
        ),
        (Path::new("/a/dem.tif"), SourceRole::Height),
        (Path::new("/a/b/dem.tif"), SourceRole::Height),
    ];
    let project = Project::new_from_sources(from, files).unwrap();
    let ids: Vec<_> = project
        .layers
        .iter()
        .map(|layer| layer.id.0.as_str())
        .collect();
    assert_eq!(ids, ["blue-marble", "dem", "dem-2"]);
    assert_eq!(project.layers[0].name, "Blue Marble");
    let paths = |project: &Project| -> Vec<String> {
        project
            .layers
            .iter()
            .map(|layer| layer.source().unwrap().path.clone())
            .collect()
    };
    assert_eq!(
        paths(&project),
        ["data/Blue_Marble.tif", "../dem.tif", "../b/dem.tif"]
    );
    assert_eq!(
        paths(&project.rebased(from, to)),
        ["projects/data/Blue_Marble.tif", "dem.tif", "b/dem.tif"]
    );
    assert_eq!(project.rebased(from, to).rebased(to, from), project);
}
