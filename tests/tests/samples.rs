//! The sample projects: what is shipped must open, as the program itself would write it.

use std::path::Path;

use relievo_project::{LayerKind, Project, resolve_path};
use relievo_tests::{files, text, workspace};

/// Path from the root, text and document of each sample.
fn samples() -> Vec<(String, String, Project)> {
    let paths = files("projects", &["relievo"]);
    assert!(paths.len() >= 3, "three samples at least: {paths:?}");
    let open = |path: String| {
        let written = text(&path);
        let project = Project::from_json(&written, Path::new(&path))
            .unwrap_or_else(|error| panic!("{error}"));
        (path, written, project)
    };
    paths.into_iter().map(open).collect()
}

#[test]
fn samples_are_written_as_saving_them_would() {
    for (path, written, project) in samples() {
        assert_eq!(
            project.to_json(),
            written,
            "{path} is not in canonical form"
        );
    }
}

#[test]
fn samples_use_only_what_this_version_knows() {
    for (path, _, project) in samples() {
        assert!(project.extra.is_empty(), "{path}: {:?}", project.extra);
        for layer in &project.layers {
            assert!(
                !matches!(layer.kind, LayerKind::Unknown { .. }),
                "{path}: {} of an unknown kind",
                layer.id
            );
            assert!(
                layer.extra.is_empty(),
                "{path}: {} has unknown fields {:?}",
                layer.id,
                layer.extra
            );
        }
    }
}

#[test]
fn every_source_of_a_sample_is_shipped_and_every_shipped_file_is_used() {
    let folder = workspace().join("projects");
    let mut unused = files("projects/data", &["tif"]);
    assert!(!unused.is_empty(), "no data shipped");
    for (path, _, project) in samples() {
        for layer in &project.layers {
            let Some(source) = layer.source() else {
                continue;
            };
            assert!(
                resolve_path(&folder, &source.path).is_file(),
                "{path}: {} is not shipped",
                source.path
            );
            unused.retain(|file| *file != format!("projects/{}", source.path));
        }
    }
    assert!(unused.is_empty(), "no sample uses {unused:?}");
}

#[test]
fn samples_show_a_whole_planet_first() {
    for (path, _, project) in samples() {
        let altitude = project.camera.altitude_m / project.planet.body.figure().radius_m;
        assert!(
            (1.0..4.0).contains(&altitude),
            "{path} opens {altitude} radii above the ground"
        );
    }
}
