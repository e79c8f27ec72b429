//! The command line as scripts see it: results, help, and an end that is asked for.

use std::path::Path;

use relievo_engine::raster::Cancel;
use serde_json::Value;

use crate::shared::{NOISE, good, in_folder, refused, sample_file, text_file};

#[test]
fn a_project_made_from_a_file_is_checked_sampled_edited_and_described() {
    let folder = tempfile::tempdir().unwrap();
    let project = in_folder(folder.path(), "new.relievo");
    good(&[
        "new",
        &project,
        "--source",
        &sample_file("data/wasatch-dem.tif"),
        &sample_file("data/provo-aerial.tif"),
    ]);
    assert_eq!(
        good(&["check", &project, "--json"]).json(),
        Value::Array(vec![])
    );
    let info = good(&["info", &project, "--json"]).json();
    assert_eq!(info["layers"][0]["kind"], "height");
    assert_eq!(info["layers"][1]["kind"], "imagery");
    let camera_lon = info["camera"]["lon_deg"].as_f64().unwrap();
    assert!(
        (-113.0..-110.0).contains(&camera_lon),
        "the camera looks at the data: {camera_lon}"
    );

    let lines = good(&[
        "sample",
        &project,
        "--at",
        "-111.65,40.25",
        "--at",
        "-111.6,40.3",
    ])
    .out;
    let places: Vec<Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(places.len(), 2);
    assert!(
        (1200.0..3500.0).contains(&places[0]["height_m"].as_f64().unwrap()),
        "{}",
        places[0]
    );

    let edits = text_file(
        folder.path(),
        "edits.json",
        r#"[{"edit": "set_exaggeration", "vertical_exaggeration": 2.5}]"#,
    );
    let edited = in_folder(folder.path(), "edited.relievo");
    good(&["apply", &project, &edits, "-o", &edited]);
    assert_eq!(
        good(&["info", &edited, "--json"]).json()["planet"]["vertical_exaggeration"],
        2.5
    );
    let moved = good(&["sample", &edited, "--at", "-111.65,40.25"]).json();
    assert_eq!(
        moved["height_m"], places[0]["height_m"],
        "measurements are not exaggerated"
    );
}

#[test]
fn a_small_new_project_in_the_mountains_is_seen_from_above_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let header = "ncols 4\nnrows 4\nxllcorner 10\nyllcorner 45\ncellsize 0.001\n";
    let rows = "3000 3000 3000 3000\n".repeat(4);
    let heights = text_file(folder.path(), "alp.asc", &format!("{header}{rows}"));
    let project = in_folder(folder.path(), "alp.relievo");
    good(&["new", &project, "--source", &heights]);
    let info = good(&["info", &project, "--json"]).json();
    let altitude_m = info["camera"]["altitude_m"].as_f64().unwrap();
    // 0.004 degrees of latitude fill a picture of 60 degrees from 385 m, and there is room around.
    assert!((3385.0..3600.0).contains(&altitude_m), "{altitude_m}");
}

#[test]
fn a_new_project_replaces_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "mine.relievo", NOISE);
    let line = refused(&[
        "new",
        &project,
        "--source",
        &sample_file("data/wasatch-dem.tif"),
    ]);
    assert!(
        line.contains("exists") && line.contains("mine.relievo"),
        "{line}"
    );
    assert_eq!(std::fs::read_to_string(project).unwrap(), NOISE);
}

#[test]
fn edits_take_effect_all_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let edits = text_file(
        folder.path(),
        "edits.json",
        r#"[{"edit": "set_visible", "id": "hills", "visible": false}, {"edit": "remove_layer", "id": "nobody"}]"#,
    );
    let output = in_folder(folder.path(), "out.relievo");
    let line = refused(&["apply", &project, &edits, "-o", &output]);
    assert!(
        line.contains("edit 1") && line.contains("nobody") && line.contains("edits.json"),
        "{line}"
    );
    assert!(!Path::new(&output).exists());
}

#[test]
fn the_schema_is_json_and_describes_edits() {
    let schema = good(&["schema"]).json();
    assert!(schema["$defs"]["edits"].is_object());
}

#[test]
fn help_tells_every_option_with_its_unit_and_default() {
    let help = good(&["help", "render"]).out;
    for part in [
        "--size <WxH>",
        "pixels",
        "[default: 1280x960]",
        "degrees",
        "metres",
        "milliseconds",
        "--threads",
    ] {
        assert!(help.contains(part), "{part} in {help}");
    }
    let all = good(&["--help"]).out;
    for command in [
        "render", "bake", "sample", "info", "check", "new", "apply", "schema",
    ] {
        assert!(all.contains(command), "{command} in {all}");
        assert!(!good(&["help", command]).out.is_empty());
    }
    assert!(good(&["--version"]).out.starts_with("relievo "));
}

#[test]
fn an_asked_for_end_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let out = in_folder(folder.path(), "heights.tif");
    let cancel = Cancel::default();
    cancel.cancel();
    let (mut output, mut err) = (Vec::new(), Vec::new());
    let arguments = [
        "relievo",
        "bake",
        &project,
        "-o",
        &out,
        "--output",
        "height",
        "--bounds",
        "0,0,9,9",
        "--resolution",
        "0.01",
    ];
    assert_eq!(
        relievo::cli::run(arguments, &mut output, &mut err, &cancel),
        130
    );
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left, ["p.relievo"]);
}

/// A reader that went away.
struct Gone;

impl std::io::Write for Gone {
    fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
        Err(std::io::ErrorKind::BrokenPipe.into())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut err = Vec::new();
    let code = relievo::cli::run(
        ["relievo", "schema"],
        &mut Gone,
        &mut err,
        &Cancel::default(),
    );
    assert_eq!((code, err.len()), (0, 0));
}
